"""Plans of tests against fits of noisy loops: the scatter of the estimates is the standard error that was expected.

A trial is 40 loops of one beam, hinged, on joints that give, or of N scales; it fails where the sum of squares of the
estimates' distances over the expected errors lies outside 99.9 % of its distribution for a parameter.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.stats import chi2

import squama
from squama.types import Array

ROOT = Path(__file__).parents[2] / "examples"
SIZE, TRIALS = 40, 8
CASES = (
    ("pla_on_vps.toml", "hinge", "endless", None),
    ("pla_on_vps.toml", "compliant", "endless", None),
    ("stiff_skin.toml", "compliant", "endless", None),
    ("stiff_skin.toml", "compliant", "free", 5),
)
"""File, joint, ends, scales."""
SHARE = 0.05
"""Largest relative error: the model is linear over it."""
NAMES = ("mu", "K_theta", "E_B")


def torque(beam: squama.Beam, x: Array, joint: str, ends: str | None = None, points: int = 600) -> Array:
    """Return the torques of a loop of the beam at twists (rad per pitch) there and back."""
    top = int(np.argmax(x))
    how = {"joint": joint, "ends": None if joint == "hinge" else ends, "ideal": joint == "hinge"}
    c = squama.cycle(beam, f"{float(x[top])!r} rad/pitch", points=points, **how)
    phi, T, leg = c.phi.values, c["T"].values, c.leg.values
    found = []
    for number, part in ((1, x[: top + 1]), (2, x[top + 1 :])):
        own = np.flatnonzero(leg == number)
        own = own[np.argsort(phi[own], kind="stable")]
        found.append(np.interp(part, phi[own], T[own]))
    return np.concatenate(found)


def trial(seed: int) -> list[str]:
    """Return what does not agree in one trial."""
    file, joint, ends, scales = CASES[seed % len(CASES)]
    r = np.random.default_rng(seed)
    beam = squama.Beam.from_toml(ROOT / file).replace(scales=scales, hold="bend, lateral bend")
    beam = beam.replace(friction={"mu": float(r.uniform(0.15, 0.4))})
    how = {"joint": joint, "ends": None if joint == "hinge" else ends}
    plan = squama.plan(beam, NAMES, noise=1e-3, **how)
    one = [c for c in plan.candidates if c.shape == "loop" and not c.problem][-2]
    errors, noise = one.errors * SHARE / one.worst, 1e-3 * SHARE / one.worst
    half = np.linspace(0, one.top, one.readings // 2 + 1)
    x = np.concatenate([half[1:], half[:-1][::-1]])
    T, apart = torque(beam, x, joint, ends), []
    for _ in range(SIZE):
        loop = {"phi": x, "T": T + r.normal(0, noise, x.size)}
        fit = squama.fit(loop, beam, NAMES, nuisances="none", starts=1, noise=noise, **how)
        apart.append((fit.estimates - one.values) / errors)
    square = (np.array(apart) ** 2).sum(axis=0)
    low, high = chi2.ppf([5e-4, 1 - 5e-4], SIZE)
    return [
        f"{seed}: {file} {joint} {ends}: {name} scatters by {np.sqrt(s / SIZE):.2f} of what is expected"
        for name, s in zip(NAMES, square, strict=True)
        if not low < s < high
    ]
