"""Random rows under end torques, free to bow: each ends by name, its work is balanced, no number is missing.

Beams of the campaign of histories with 5 to 25 scales, to .3 rad per pitch; their scales slide off each other one by
one.
"""

from __future__ import annotations

import collections
import math

import numpy as np
from real_histories import drawn

from squama.contacts import increments, path, row
from squama.contacts.path import Path
from squama.contacts.ties import LOOSE

TRIALS, SIZE = 20, 30
FAR, POINTS, BALANCE = 0.3, 60, 2e-4
"""Twist, rad per pitch; points; work that may be lost, over the largest energy."""


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Try rows; the line for a failure names the trial and its number."""
    r, ends, failed = np.random.default_rng([31, seed]), collections.Counter[str](), []
    for i in range(size):
        beam, n = drawn(r), int(r.integers(5, 26))
        way = Path.at_rest(beam.scale, beam.K, beam.mu, sense=beam.sense, free=(1, 1, 1, 1), aside=r.uniform(1, 6))
        track = row.track(way, n, np.linspace(0.0, FAR, POINTS + 1)[1:], ends=LOOSE)
        ends[str(track.end.word)] += 1
        v, found = path.named(track.rows), []
        U, W, rubbed, lost = (v[name].sum(axis=1) for name in ("energy", "W", "W_fr", "W_snap"))
        if not np.isfinite(track.cells).all() or not np.isfinite(U).all():
            found.append("has values that are no numbers")
        elif U.size and np.abs(W - U - rubbed - lost).max() > BALANCE * U.max():
            found.append(f"loses {np.abs(W - U - rubbed - lost).max() / U.max():.1e} of its work")
        if track.end.code == increments.MANY or not math.isfinite(track.end.phi):
            found.append(f"ends as {track.end.word} at {track.end.phi:.4g}")
        failed += [f"trial {seed}, row {i} ({n} scales, mu {beam.mu:.3g}): {what}" for what in found]
    print(f"rows, {seed}: " + ", ".join(f"{n} {end}" for end, n in ends.most_common()), flush=True)
    return failed
