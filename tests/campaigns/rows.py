"""Random rows under end torques, free to bow: each ends by name, its work is balanced, no number is missing.

Beams of the campaign of histories with 5 to 25 scales, to .3 rad per pitch; their scales slide off each other one by
one.
"""

from __future__ import annotations

import collections

import numpy as np
from histories import drawn
from parts import wrong

from squama.contacts import row
from squama.contacts.path import Path
from squama.contacts.ties import LOOSE

TRIALS, SIZE = 20, 30
FAR, POINTS = 0.3, 60
"""Twist, rad per pitch; points."""


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Try rows; the line for a failure names the trial and its number."""
    r, ends, failed = np.random.default_rng([31, seed]), collections.Counter[str](), []
    for i in range(size):
        beam, n = drawn(r), int(r.integers(5, 26))
        way = Path.at_rest(beam.scale, beam.K, beam.mu, sense=beam.sense, free=(1, 1, 1, 1), aside=r.uniform(1, 6))
        track = row.track(way, n, np.linspace(0.0, FAR, POINTS + 1)[1:], ends=LOOSE)
        ends[str(track.end.word)] += 1
        failed += [f"trial {seed}, row {i} ({n} scales, mu {beam.mu:.3g}): {what}" for what in wrong(track)]
    print(f"rows, {seed}: " + ", ".join(f"{n} {end}" for end, n in ends.most_common()), flush=True)
    return failed
