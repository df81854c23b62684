"""Random beams on compliant joints, twisted there and back: the work of the loads against the energies, everywhere.

Beams of :mod:`histories`, to .3 rad per pitch or to where their path ends, and back to 0. Wrong is work that is
neither stored, rubbed away nor lost in a snap that is told, and a snap that loses less than nothing.

python tests/campaigns/balances.py [SEED] [BEAMS] tells each beam of one trial.
"""

from __future__ import annotations

import collections
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama.contacts import increments, path

sys.path.insert(0, str(Path(__file__).parent))
from histories import Given, drawn

TRIALS, SIZE = 20, 500
FAR, STATIONS = 0.3, 75
"""Largest twist per pitch, rad, and stations on the way there; as many on the way back."""
LOST = 1e-4
"""Work that is lost, over the largest energy so far."""


class Balance(NamedTuple):
    """What is found of a history.

    ``lost``: most work over the largest energy that the path has had, ``there`` and after both ways; ends of both ways,
    way to the turn; jumps that are snaps and that are not, least loss of a snap over the largest energy; events.
    """

    there: float
    lost: float
    ends: tuple[str, str]
    turn: float
    snaps: int
    changes: int
    least: float
    events: int


def lost(found: path.Answers) -> float:
    """Return the largest work that a path loses, over its largest energy: at a station, or lost in a snap between."""
    v = {name: column[: found.end().solved] for name, column in path.named(found.rows[0]).items()}
    if not len(v["energy"]) or not v["energy"].max() > 0:
        return 0.0
    fell = found.events[0, : int(min(found.ends[0, 2], path.EVENTS)), 12].max(initial=0.0)
    return float(abs(v["W"] - v["energy"] - v["W_fr"] - v["W_snap"]).max() / max(v["energy"].max(), fell))


def measured(given: Given) -> Balance:
    """Follow a beam there and back, to where its path ends, and return the balance."""
    one = given.path()
    there = one.follow(np.linspace(0, FAR, STATIONS + 1)[1:])
    far = FAR if there.end().code == increments.RANGE else there.end().phi * (1 - 1e-6)
    ways = np.linspace(0, far, STATIONS + 1)[1:]
    found = one.follow(np.concatenate([ways, ways[-2::-1], [0.0]]))
    told = found.events[0, : int(min(found.ends[0, 2], path.EVENTS))]
    snaps = told[told[:, 0] == increments.SNAP]
    energy = np.nanmax(path.named(found.rows[0])["energy"], initial=0.0)
    least = float(snaps[:, 12].min() / energy) if len(snaps) and energy > 0 else 0.0
    changes = int((told[:, 0] == increments.CHANGE).sum())
    ends = str(there.end().word), str(found.end().word)
    return Balance(lost(there), lost(found), ends, far, len(snaps), changes, least, int(found.ends[0, 2]))


def told(i: int, given: Given, b: Balance) -> str:
    """Return a line for a beam."""
    kind = "elastic" if given.scale.elastic else "rigid"
    return (
        f"beam {i} ({kind}, mu {given.mu:.3g}): lost {b.there:.2e} there, {b.lost:.2e} in all; {b.ends[0]} at "
        f"{b.turn:.4g}, {b.ends[1]}; {b.snaps} snaps (least {b.least:.1e}), {b.changes} changes, {b.events} events"
    )


def trial(seed: int, size: int = SIZE, every: bool = False) -> list[str]:
    """Try histories; the line for a failure names the trial and its number."""
    r, failed, counts = np.random.default_rng(seed), [], collections.Counter[str]()
    balances = []
    for i in range(size):
        given = drawn(r)
        b = measured(given)
        balances.append(b)
        counts[f"end {' / '.join(b.ends)}"] += 1
        counts["snaps"] += b.snaps
        if every:
            print(told(i, given, b), flush=True)
        if b.lost > LOST or b.there > LOST or b.least < 0:
            failed.append(f"trial {seed}, {told(i, given, b)}")
    for name, column in ("there", [b.there for b in balances]), ("there and back", [b.lost for b in balances]):
        print(
            f"balances, {seed}, {name}: median {np.median(column):.2e}, 99 % {np.quantile(column, 0.99):.2e}, largest "
            f"{max(column):.2e}, {np.sum(np.array(column) > LOST)} of {size} above {LOST:g}"
        )
    print(f"balances, {seed}: " + ", ".join(f"{n} {what}" for what, n in counts.most_common()), flush=True)
    return failed


if __name__ == "__main__":
    seed, beams = [*map(int, sys.argv[1:]), *(2026, SIZE)[len(sys.argv) - 1 :]]
    print("\n".join(trial(seed, beams, every=True)))
