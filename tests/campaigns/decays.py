"""Fits of decays on the compliant joint: the 2-sigma intervals of mu, K_theta and damping hold the truth.

A trial is 20 decays: a beam of another friction, another joint and some damping in its material is let go near 130
degrees, read at 60 Hz over five cycles with white noise, and fitted from the values of its file. It fails where less
than 17 of the intervals of a parameter hold (of 95 % once in sixty times), and where a fit says that the model misses
something or that its search did not end.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicHermiteSpline

import squama
from squama.curves import compliant
from squama.types import Array

ROOT = Path(__file__).parents[2] / "examples"
TRIALS, SIZE, LEAST = 3, 20, 17
"""Decays of a trial; intervals of a parameter that hold, at least."""
NAMES = ("mu", "K_theta", "damping")
RATE, NOISE, CYCLES = 60.0, 0.4, 5
"""Hz, degrees over the whole beam, cycles of the record."""
ROTOR = "1e-4 kg m2"


def measured(r: np.random.Generator) -> tuple[squama.Beam, dict[str, Array], dict[str, float]]:
    """Return the beam that a fit starts from, a measured decay and the true values."""
    start = squama.Beam.from_toml(ROOT / "stiff_skin.toml").replace(rotor=ROTOR, hold="bend, lateral bend")
    mu, factor, damping = r.uniform(0.15, 0.4), r.uniform(0.8, 1.25), r.uniform(0.005, 0.03)
    K = factor * compliant.Held.of(start).K_theta
    beam = start.replace(friction={"mu": mu}, joint={"stiffness": K})
    release = r.uniform(120, 135)
    v = squama.vibrate(beam, release=f"{release} deg total", damping=damping, swings=2 * CYCLES)
    new = np.diff(v.t.values, prepend=-1.0) > 0
    way = CubicHermiteSpline(*(v[name].values[new] for name in ("t", "phi", "phi_speed")))
    t = np.arange(0.0, float(v.t[-1]), 1 / RATE)
    degree = np.radians(1) / beam.scales
    return (
        start,
        {"t": t, "phi": way(t) + degree * r.normal(0, NOISE, t.size)},
        dict(zip(NAMES, (mu, K, damping), strict=True)),
    )


def fitted(seed: int) -> tuple[squama.DecayFit, dict[str, float]]:
    """Return a fit, and how many errors each of its parameters is off."""
    start, data, truth = measured(np.random.default_rng([2025, seed]))
    begun = time.process_time()
    fit = squama.fit_decay(data, start)
    took = time.process_time() - begun
    off = {n: (fit.values[n] - v) / fit.errors[n] for n, v in truth.items()}
    words = ", ".join(f"{n} {fit.values[n]:.5g} for {truth[n]:.5g} ({x:+.1f} errors)" for n, x in off.items())
    print(f"decay {seed}: {words}, {took:.1f} s{''.join(f'; {n}' for n in fit.notes)}", flush=True)
    return fit, off


def trial(seed: int) -> list[str]:
    """Fit the decays of a trial; the lines of its failures name the parameter, or the decay and what is said of it."""
    held, failed = dict.fromkeys(NAMES, 0), []
    for number in range(seed * SIZE, (seed + 1) * SIZE):
        fit, off = fitted(number)
        for name, x in off.items():
            held[name] += abs(x) < 2
        failed += [f"decay {number}: {note}" for note in fit.notes if "misses" in note or "search" in note]
    return failed + [f"{name}: {n} of {SIZE} intervals hold" for name, n in held.items() if n < LEAST]
