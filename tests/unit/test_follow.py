"""The spine: load paths, one solved path for all coefficients of friction, and the table of models."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from squama.arrays import solution
from squama.curves import doors, hinge
from squama.curves.way import Analysis, Way
from squama.errors import InputError
from squama.loads import LOADS

MUS = [0.0, 0.1, 0.3, 0.6, 1.0, 3.0]


def designs(n: int, seed: int) -> list[squama.Beam]:
    """Beams about the paper's and over wide ranges: locks, folds, edges, neighbours, other contacts, no engagement."""
    rng = np.random.default_rng(seed)
    near = (1.5, 0.5, 0.3, 0.4, 0.05), (4, 1.5, 0.7, 1.4, 0.3)
    far = (1, 0.1, 0.05, 0.05, 0.02), (8, 2.5, 1.5, 1.5, 0.8)
    names = ("eta", "beta", "lam", "alpha", "theta0")
    rows = [rng.uniform(*(near if i % 3 else far)) for i in range(n)]
    # of the last the tip-side pair engages in the other sense too
    rows.append([1.0683, 0.80579, 1.034, 0.15793, 0.11])
    return [squama.Beam.from_ratios(**dict(zip(names, row, strict=True)), zeta=0.02) for row in rows]


def paths(beam: squama.Beam, load: str, mus: list[float], law: str = "edge", sense: str = "+") -> list[hinge.Path]:
    way = Way.of(load, [math.inf if sense == "+" else -math.inf])
    return hinge.solve(Analysis(beam, way, np.array(mus), law, 0.01, 3))[0]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("law", ["edge", "plate"])
@pytest.mark.parametrize("sense", ["+", "-"])
def test_several_frictions_together_are_each_by_itself(law: str, sense: str) -> None:
    ends = set()
    for beam in designs(30, seed=4):
        together = paths(beam, "twisting", MUS, law, sense)
        for mu, p in zip(MUS, together, strict=True):
            (one,) = paths(beam, "twisting", [mu], law, sense)
            assert (p.end, p.neighbour, p.other) == (one.end, one.neighbour, one.other)
            ends.add(p.end)
            for name in ("load_e", "load_end", "theta_end", "x0", "x_end", "x_c", "touch"):
                here, there = np.asarray(getattr(p, name)), np.asarray(getattr(one, name))
                np.testing.assert_allclose(here, there, rtol=1e-9, atol=1e-12)
    assert len(ends) >= (5 if sense == "+" else 2), ends


def test_what_touches_when_is_looked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = {"touch": 0}

    def counted(name: str, function):
        def count(*args, **kwargs):
            asked[name] += 1
            return function(*args, **kwargs)

        return count

    monkeypatch.setattr(solution, "touch", counted("touch", solution.touch))
    family = squama.twist(squama.Beam.from_ratios(), mu=MUS, joint="hinge")
    assert asked == {"touch": 1}
    for i, mu in enumerate(MUS):
        one = squama.twist(squama.Beam.from_ratios(), mu=mu, joint="hinge")
        np.testing.assert_allclose(family.T[i], one["T"], rtol=1e-9)


def test_a_load_path_knows_its_load_and_its_sense() -> None:
    back = Way.of("bending", [0.0, 0.2, -0.1])
    assert back.corners == ((0.0, 0.0), (0.2, 0.0), (-0.1, 0.0))
    assert (back.load.name, back.values, back.sense) == ("bending", [0.0, 0.2, -0.1], "+")
    far = Way.of("twisting", [-math.inf])
    assert (far.load.name, far.values, far.sense) == ("twisting", [-math.inf], "-")


@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_the_solved_path_is_that_of_the_door(load: str) -> None:
    beam = squama.Beam.from_ratios(mu=0.3)
    kind = LOADS[load]
    (path,), _ = hinge.solve(doors.analysis(beam, Way.of(load, [0.1]), kind, points=3, joint="hinge"))
    answer = doors.respond(beam, load, points=7, to="0.1 rad/pitch", joint="hinge")
    curve = path.curve(points=7)
    torque = (answer.attrs["load"] == "twisting" and "T") or "M"
    np.testing.assert_array_equal(curve.along["torque"], answer[torque])
    assert curve.figures["end"] == answer["end"].item()
    assert (path.case.rigidity, path.case.stiffness) == (kind.rigidity(beam), beam.joint_stiffness)


def test_flat_scales_engage_where_the_formula_of_small_angles_says() -> None:
    for alpha in (0.1, 0.7):
        beam = squama.Beam.from_ratios(eta=1.5, beta=1.4, lam=0.3, alpha=alpha, theta0=1e-5)
        r = squama.twist(beam, mu=0.1, points=3, joint="hinge")
        assert float(r.phi_e_small) == pytest.approx(float(r.phi_e), rel=1e-4)


def test_bent_away_the_scales_spread() -> None:
    beam = squama.Beam.from_ratios()
    (away,) = paths(beam, "bending", [0.3], sense="-")
    assert (str(away.end), away.load_e, away.load_end) == ("no engagement", math.inf, solution.SEARCH)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"joint": "glue"}, 'joint = "glue": must be "hinge" or "compliant"'),
        (
            {"joint": "compliant", "law": "plate"},
            'law = "plate": is not covered by joint="compliant"; write law="edge"',
        ),
    ],
)
def test_what_no_model_covers_is_refused(asked: dict[str, str], words: str) -> None:
    beam = squama.Beam.from_ratios(mu=0.3)
    for door in (lambda: squama.twist(beam, **asked), lambda: squama.cycle(beam, "0.1 rad/pitch", **asked)):
        with pytest.raises(InputError) as caught:
            door()
        assert str(caught.value) == words


def test_the_package_shows_its_public_names_only() -> None:
    assert dir(squama) == sorted(squama.__all__)
    assert all(hasattr(squama, name) for name in dir(squama))
