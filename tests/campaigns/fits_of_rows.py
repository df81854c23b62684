"""Fits of loops of beams of 10 and 25 scales: the 2-sigma intervals of mu and K_theta hold the truth, each in 22 of 24.

The loops come from the contact solver in increments a quarter as long as those of a fit, at uneven twists, with noise;
every other specimen is kept straight by a guide, the others are free to bow. The seconds are CPU time of a fit.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import squama
from squama.contacts import path, row
from squama.contacts.ties import LOOSE
from squama.curves import compliant, compliant_cycles
from squama.loads import LOADS

TRIALS, SIZE = 1, 24
SCALES, COVERED, SECONDS = (10, 25), 22, 60.0
"""Numbers of scales; least intervals of the fits that hold the truth, for each parameter; most of a fit."""
POINTS, TOP, NOISE = 100, 0.12, 1e-4
"""Readings of a way, largest twist (rad per pitch), noise of a torque (N m)."""
FILE = Path(__file__).parents[2] / "examples" / "stiff_skin.toml"
_LOAD = LOADS["twisting"]


def fitted(number: int) -> tuple[dict[str, bool], squama.Fit, float]:
    """Fit the loop of one specimen: which intervals hold the truth, the fit, and the seconds that it took."""
    r = np.random.default_rng([2028, number])
    hold = ("bend, lateral bend", "nothing")[number // 2 % 2]
    start = squama.Beam.from_toml(FILE).replace(scales=SCALES[number % 2], hold=hold)
    K = compliant.Held.of(start).K_theta * r.uniform(0.8, 1.25)
    true = {"mu": r.uniform(0.15, 0.4), "K_theta": K}
    beam = start.replace(friction={"mu": true["mu"]}, joint={"stiffness": K})
    up = TOP * (np.arange(1, POINTS) + r.uniform(0.2, 0.8, POINTS - 1)) / POINTS
    down = TOP * (np.arange(POINTS) + r.uniform(0.2, 0.8, POINTS)) / POINTS
    x = np.concatenate([[0.0], up, [TOP], down[::-1]])
    one = compliant.Path.of(beam, true["mu"], (_LOAD.verb,), ideal=False)
    track = row.track(one.way, beam.scales or 0, x, compliant_cycles.OF_ROWS / 4, ends=LOOSE, load=_LOAD.axis)
    T = path.named(track.rows)["torque"][:, 0] * beam.unit_moment + r.normal(0, NOISE, x.size)
    begun = time.process_time()
    fit = squama.fit({"phi": x, "T": T}, start)
    took = time.process_time() - begun
    return {name: abs(fit.values[name] - v) < 2 * fit.errors[name] for name, v in true.items()}, fit, took


def trial(seed: int) -> list[str]:
    """Fit all specimens; a line for each parameter whose intervals fail, and for each fit that takes too long."""
    covered, failed = {"mu": 0, "K_theta": 0}, []
    for i in range(seed * SIZE, (seed + 1) * SIZE):
        inside, fit, took = fitted(i)
        words = ", ".join(f"{name} {'holds' if yes else 'misses'}" for name, yes in inside.items())
        print(f"fits of rows, {fit.beam.scales} scales, {fit.beam.hold}: {words}; {fit}; {took:.1f} s", flush=True)
        failed += [f"specimen {i}: {took:.1f} s of CPU"] if took > SECONDS else []
        for name, yes in inside.items():
            covered[name] += yes
    shares = ", ".join(f"{name} {count} of {SIZE}" for name, count in covered.items())
    print(f"fits of rows: {shares}", flush=True)
    return failed + ([shares] if min(covered.values()) < COVERED else [])
