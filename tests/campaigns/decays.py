"""Fits of decays on the compliant joint: 2-sigma intervals of mu and K_theta hold, or the fit says that they may not.

A beam of another friction, another joint and some damping in its material is let go beyond engagement, read at 60
points a period over five cycles with noise, and fitted from the values of its file. The record is of the package's own
motion, with its branches resolved twice as finely. A trial is one kind.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.signal import lfilter

import squama
from squama.curves import compliant
from squama.dynamics import joint_branches
from squama.loads import LOADS
from squama.types import Array

ROOT = Path(__file__).parents[2] / "examples"
SIZE, MISSES = 25, 2
"""Decays of a trial; intervals of a parameter that may miss without a word: three of 25 miss once in eight times."""
NOISE, CYCLES, RATE = 0.15, 5, 60
"""Noise in degrees over the whole beam; cycles of the record, and readings of each."""
ROTOR = "1e-4 kg m2"
CORRELATED = 0.8
"""Correlation of the noise of neighbouring readings, where it is slow."""


class Kind(NamedTuple):
    """One kind of record: beam, load, number of scales (None: endless), what is held, whether the noise is slow.

    ``release``: the smallest, rad per pitch; the largest is an eighth more.
    """

    file: str = "stiff_skin.toml"
    load: str = "twisting"
    scales: int | None = 8
    hold: str = "bend, lateral bend"
    slow: bool = False
    release: float = 0.083


KINDS = {
    "8 scales": Kind(),
    "8 scales, slow noise": Kind(slow=True),
    "8 scales, free to bow": Kind(hold="nothing"),
    "8 scales, bent": Kind("finger.toml", "bending", hold="nothing", release=0.15),
    "25 scales": Kind(scales=25),
    "an endless beam": Kind(scales=None),
}
TRIALS = len(KINDS)


def measured(kind: Kind, r: np.random.Generator) -> tuple[squama.Beam, dict[str, Array], dict[str, float]]:
    """Return the beam that a fit starts from, a measured decay and the true values."""
    start = squama.Beam.from_toml(ROOT / kind.file).replace(rotor=ROTOR, hold=kind.hold, scales=kind.scales)
    mu, factor, damping = r.uniform(0.15, 0.4), r.uniform(0.8, 1.25), r.uniform(0.005, 0.03)
    K = factor * compliant.Held.of(start).K_theta
    beam = start.replace(friction={"mu": mu}, joint={"stiffness": K})
    release = kind.release * r.uniform(1.0, 1.125)
    how = {"load": kind.load, "release": f"{release} rad/pitch", "damping": damping, "swings": 2 * CYCLES}
    finely = {name: 2 * getattr(joint_branches, name) for name in ("STEPS", "OF_ROW")}
    with mock.patch.multiple(joint_branches, TOPS=joint_branches.TOPS / 2, **finely):
        v = squama.vibrate(beam, **how)
    angle = LOADS[kind.load].angle
    new = np.diff(v.t.values, prepend=-1.0) > 0
    way = CubicHermiteSpline(*(v[name].values[new] for name in ("t", angle, f"{angle}_speed")))
    t = np.arange(0.0, float(v.t[-1]), 1 / (RATE * float(v.f_0)))
    noise = r.normal(0, np.radians(NOISE) / beam.pitches, t.size)
    if kind.slow:
        noise = lfilter([np.sqrt(1 - CORRELATED**2)], [1, -CORRELATED], noise)
    return start, {"t": t, angle: way(t) + noise}, {"mu": mu, "K_theta": K, "damping": damping}


def trial(seed: int) -> list[str]:
    """Fit the decays of a kind; the line for a failure names it and its shares."""
    name = list(KINDS)[seed % TRIALS]
    kind, missed, doubted, took = KINDS[name], dict[str, int](), 0, 0.0
    for i in range(SIZE):
        start, data, truth = measured(kind, np.random.default_rng([2026, seed, i]))
        begun = time.process_time()
        fit = squama.fit_decay(data, start, load=kind.load)
        took = max(took, time.process_time() - begun)
        told = any(word in note for word in ("misses", "search", "separable") for note in fit.notes)
        doubted += told
        apart = {n: (fit.values[n] - v) / fit.errors[n] for n, v in truth.items()}
        for n, errors in apart.items():
            missed[n] = missed.get(n, 0) + (not told and abs(errors) > 2)
        print(f"  {fit}; off by {', '.join(f'{n} {v:+.1f}' for n, v in apart.items())} errors", *fit.notes, flush=True)
    line = f"{name}: {missed} of {SIZE} miss without a word, {doubted} are told, {took:.1f} s"
    print(f"decays, {line}", flush=True)
    return [line] if max(missed.values()) > MISSES else []
