"""Random beams, bent and twisted along polygons, there and back: the contact solver against the barrier of elements.

Beams as those of :mod:`contacts`, their length free. What does not go to its end by both is counted.
"""

from __future__ import annotations

import collections

import numpy as np
from contacts import Given, drawn, followed, loads

from squama.contacts import follow, path
from squama.contacts.system import EPS
from squama.fe import bending
from squama.fe.assembly import make_bent
from squama.fe.exposed import Exposed, box, sheet
from squama.fe.geometry import Geometry
from squama.types import Array

TRIALS, SIZE = 20, 10
FAR = (0.12, 0.15)
"""Largest bend and twist per pitch."""
SAME, INCREMENT, GRID = 0.02, 2e-3, (6, 3)
"""Difference of moment or torque over both together; increments of the barrier; parts of a bent plate."""


def polygon(r: np.random.Generator) -> Array:
    """Return the corners of a path."""
    psi, phi = r.uniform(0.3, 1.0) * FAR[0], r.uniform(-0.7, 1.0) * FAR[1]
    kinds = (
        [(psi, phi)], [(psi, 0), (psi, phi)], [(0, phi), (psi, phi)], [(psi, 0), (psi, -abs(phi)), (psi, abs(phi))],
        [(0, abs(phi)), (psi, abs(phi)), (-psi, abs(phi)), (psi, abs(phi))],
    )  # fmt: skip
    return np.array(kinds[r.integers(len(kinds))], float)


def surface(s: path.Scale) -> Exposed:
    """Return the exposed part of a scale."""
    if np.isfinite(s.D):
        return bending.plate(sheet(*bending.lines(s.eta, s.beta, GRID), s.h), s.eta, s.beta, s.D, s.nu)
    return box(s.eta, s.beta, s.h)


def compared(given: Given, corners: Array) -> tuple[str, int, float]:
    """Return how a path ends, contacts at its end, and the larger difference of moment and torque to the barrier's."""
    found = followed(given, corners, np.arange(4) == EPS)
    touching = path.named(found.rows[0])["contacts"]
    if found.end().code != follow.RANGE or not touching.max() > 0:
        return str(path.WORDS[found.end().code]) if touching[0] >= 0 else "no state", 0, np.nan
    s = given.scale
    shape = Geometry(np.nan, s.lam, np.nan, s.eta, s.beta, s.h, s.alpha, s.theta0, np.nan)
    led = make_bent(given.K, shape, given.mu, exposed=surface(s))
    if not all(led.run(led.aim(*corner), INCREMENT).reached for corner in corners):
        return "not by the barrier", int(touching[-1]), np.nan
    own, other = loads(found)[-1, :2], np.array([led.columns[name][-1] for name in "MT"])
    return "both", int(touching[-1]), float(np.abs(own - other).max() / np.hypot(*other))


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Try paths; the line for a failure names the trial and its number."""
    r, counts, failed, offs = np.random.default_rng([17, seed]), collections.Counter[str](), [], [0.0]
    for i in range(size):
        given, corners = drawn(r), polygon(r)
        end, touching, off = compared(given, corners)
        counts[end] += 1
        offs.append(off)
        if off > SAME:
            failed.append(f"trial {seed}, path {i} (mu {given.mu:.3g}, {touching} contacts): is {off:.2%} off")
    ends = ", ".join(f"{n} {end}" for end, n in counts.most_common())
    print(f"bent contacts, {seed}: {ends}; differences of at most {np.nanmax(offs):.2%}", flush=True)
    return failed
