"""Designs of wide ranges: figures that cannot be, ends that depend on how they are found, friction that unlocks.

Every trial has designs of one load, law and sense. They are answered by compiled code; some, and all whose ends hang on
a margin that just vanishes, by Python too; of a few the whole path is looked at by plain vectors.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from properties.designs import each
from properties.test_first_event import early_ends
from squama.arrays import solution
from squama.batch import Solved, solved
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY
from squama.types import Array

TRIALS, SIZE = 100, 100_000
ALONE, LOOKED_AT = 1_000, 25
"""Designs of a trial that Python answers, and those that are looked at on PLACES places of their paths."""
PLACES = 20_000
MARGIN = 0.01
NEARBY, JUMP = 1e-4, 1e-2
"""Relative changes of friction and of the load angle at the end: a design with a thin margin jumps so."""
SAME = 1e-6
"""Relative difference of load angles that are the same end."""
FRICTIONAL = CODES.index(End.FRICTIONAL)


class Group(NamedTuple):
    """What designs are asked for."""

    load: str
    law: str
    sense: str

    @property
    def name(self) -> str:
        """Words for it."""
        return "bending" if self.load == "bending" else f"twisting {self.sense} {self.law}"


GROUPS = [Group("twisting", law, sense) for law in ("edge", "plate") for sense in "+-"]
GROUPS.append(Group("bending", "edge", "+"))


def drawn(group: Group, seed: int, size: int) -> dict[str, Array]:
    """Columns of designs: each ratio half evenly and half evenly in its logarithm."""
    r = np.random.default_rng([GROUPS.index(group), seed])

    def wide(low: float, high: float) -> Array:
        return np.where(r.random(size) < 0.5, r.uniform(low, high, size), np.exp(r.uniform(*np.log([low, high]), size)))

    slippery, mu = r.random(size), wide(1e-6, 100)
    mu = np.where(slippery < 0.15, 0.0, np.where(slippery < 0.5, r.uniform(0, 2, size), mu))
    sizes = {"eta": wide(0.2, 50), "beta": wide(0.05, 20), "lam": wide(0.01, 20)}
    return sizes | {"alpha": np.radians(wide(1e-4, 89.999)), "theta0": np.radians(wide(0.01, 89)), "mu": mu}


def answers(group: Group, columns: dict[str, Array], *, few: int = -1, margin: float = MARGIN) -> Solved:
    """Answer the designs, by compiled code unless ``few`` says otherwise."""
    flat = (*columns.values(), np.zeros(columns["mu"].size))
    return solved(flat, law=group.law, sense=group.sense, margin=margin, load=group.load, few=few)


def impossible(s: Solved) -> dict[str, Array]:
    """Designs with figures that cannot be."""
    on = s.neighbour > 0
    ends = np.where(on, s.load_e, 0.0), np.where(on, s.load_end, 0.0)
    return {
        "not a number": ~np.isfinite([*ends, s.theta_end, *s[5:]]).all(axis=0),
        "RED": ~((s.RED >= 0) & (s.RED <= 1)),
        "W_fr": ~(s.W_fr >= 0),
        "engagement": ends[1] < ends[0],
    }


def apart(a: Solved, b: Solved, same: float = SAME) -> Array:
    """Designs whose ends differ."""
    on = (a.neighbour > 0) & (b.neighbour > 0)
    here, there = np.where(on, a.load_end, 1.0), np.where(on, b.load_end, 1.0)
    return np.asarray((a.code != b.code) | (a.neighbour != b.neighbour) | (abs(here - there) > same * there))


def thin(group: Group, columns: dict[str, Array], s: Solved) -> Array:
    """Designs that end elsewhere with hardly more friction: a margin of theirs just vanishes, or just does not."""
    return apart(s, answers(group, columns | {"mu": columns["mu"] * (1 + NEARBY)}), JUMP)


def picked(columns: dict[str, Array], which: Array) -> dict[str, Array]:
    """Return some of the designs."""
    return {name: v[which] for name, v in columns.items()}


def later(group: Group, columns: dict[str, Array], s: Solved, more: Solved) -> tuple[Array, Array]:
    """Designs that end later with more friction, and those of them in which friction helps at the lock with less."""
    found = np.flatnonzero((s.neighbour > 0) & (more.load_end > s.load_end * (1 + SAME)))
    helped = np.zeros(found.size, bool)
    if found.size:
        sol, _, tracks = solution.solve(picked(columns, found), law=group.law, sense=group.sense)
        for index, t in tracks:
            with np.errstate(all="ignore"):
                pt = t.row.point(t.x_end, group.law, ARRAY)
            helped[index] = (sol.code[index] == FRICTIONAL) & (pt.M_f <= 0)
    return found, found[helped]


def trial(seed: int, size: int = SIZE, alone: int = ALONE, looked_at: int = LOOKED_AT) -> list[str]:
    """Try designs; the line for a failure names the design."""
    group = GROUPS[seed % len(GROUPS)]
    columns = drawn(group, seed, size)
    s = answers(group, columns)
    failed = {what: np.flatnonzero(which) for what, which in impossible(s).items()}
    narrow = thin(group, columns, s)
    chosen = np.flatnonzero(narrow | (np.arange(size) < alone))
    single = answers(group, picked(columns, chosen), few=chosen.size)
    failed["another end one by one"] = chosen[apart(single, Solved._make(v[chosen] for v in s))]
    counts = {"engaged": int((s.neighbour > 0).sum()), "one by one": chosen.size, "thin": int(narrow.sum())}
    if group.load == "twisting":
        more = columns["mu"] * (1 + np.random.default_rng(seed).exponential(1.0, size)) + 1e-9
        found, helped = later(group, columns, s, answers(group, columns | {"mu": more}))
        failed["later with more friction"] = np.setdiff1d(found, helped if group.law == "plate" else [])
        some = np.flatnonzero(s.neighbour > 0)[:looked_at]
        early = [bool(early_ends(d, group.sense, group.law, PLACES)) for d in each(picked(columns, some))]
        failed["an earlier end by vectors"] = some[np.array(early, bool)]
        counts |= {"pairs": counts["engaged"], "later as the law has it": helped.size, "looked at": some.size}
    print(f"{group.name}: {size} designs, " + ", ".join(f"{n} {what}" for what, n in counts.items()), flush=True)
    return [
        f"{group.name}, {what}: {', '.join(f'{name} {v[i]!r}' for name, v in columns.items())}"
        for what, which in failed.items()
        for i in which
    ]
