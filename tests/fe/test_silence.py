"""A long increment is not silent: a run says each ten seconds what it is at, by a clock that the test turns."""

import itertools

import numpy as np
import pytest

pytest.importorskip("ipctk", reason="needs the extra fe")

import squama
from squama.fe import runs
from squama.fe.assembly import make_bent
from squama.fe.geometry import geometry
from squama.joints.choice import joint_of

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml")
STEP = 4.0
"""Seconds that pass each time somebody looks at the clock."""


class Clock:
    """A clock that goes on as it is looked at."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        self.now += STEP
        return self.now


@pytest.mark.parametrize("watched", [True, False])
def test_iterations_are_told_each_ten_seconds(watched, monkeypatch, capsys):
    clock, told = Clock(), []
    monkeypatch.setattr(runs, "time", clock)
    walk = make_bent(np.asarray(joint_of(BEAM).K), geometry(BEAM), 0.25)
    goal = walk.aim(0.0, 0.12)

    def listen(at):
        # what stands is told at once
        told.append((clock.now, at))
        runs.print_progress(at)

    # large increments, each of many steps of the contact
    ended = runs.follow(walk, goal, 0.04, None, {}, listen if watched else None)
    assert ended.reached
    lines = capsys.readouterr().err.splitlines()
    if not watched:
        assert not lines
        return
    within = [at for _, at in told if at.toward is not None]
    assert len(within) > 5
    times = [0.0, *(now for now, _ in told)]
    assert max(b - a for a, b in itertools.pairwise(times)) <= runs.SILENCE + 2 * STEP
    for at in within:
        assert at.phi < at.toward <= at.goal
        assert at.iterations >= 1
        assert at.increment_s > 0
    # steps are counted up within an increment, and the time left is never that of before it
    for one, two in itertools.pairwise(at for _, at in told):
        if one.toward == two.toward is not None and one.phi == two.phi:
            assert two.rounds > one.rounds
            assert two.increment_s > one.increment_s
            assert one.left_s is None or two.left_s > one.left_s
    assert len(lines) == len(told)
    assert f"{within[-1].rounds} contact steps, {within[-1].increment_s:.0f} s in this increment" in "\n".join(lines)
    # an increment that is done says so as before
    assert sum("largest force left" in line for line in lines) == len(told) - len(within) >= 3
