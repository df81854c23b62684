"""Fits of loops with all that a test brings: the 2-sigma intervals of mu and K_theta hold, or the fit says they do not.

A trial is 25 loops of one beam with one kind of error; it fails where less than 88 % of the intervals that the fit
stands by cover the truth, or where a fit takes more than 10 s of CPU.
"""

from __future__ import annotations

import itertools
import time
from pathlib import Path

import numpy as np

import squama
from squama.curves import compliant
from squama.types import Array

ROOT = Path(__file__).parents[2] / "examples"
POINTS, SIZE, COVERED, SECONDS = 160, 25, 0.88, 10.0
"""Points of a way; loops of a trial; least share of intervals; most of a fit."""
NOISE, DRIFT, TWIST_NOISE, TWIST_ZERO, BACKLASH = 10e-3, 20e-3, 0.2, 1.5, 0.6
"""N m, and degrees over the whole beam."""
RIGID = {"youngs_modulus": None}
BEAMS = {
    "rigid scales": ("pla_on_vps.toml", RIGID, 0.14, "compliant", 1.0),
    "steel scales": ("pla_on_vps.toml", {"youngs_modulus": "200 GPa"}, 0.14, "compliant", 1.0),
    "PLA on soft silicone": ("stiff_skin.toml", {}, 0.12, "compliant", 0.1),
    "hinges": ("pla_on_vps.toml", RIGID, 0.12, "hinge", 1.0),
}
"""File, scale, twist (rad per pitch), joint, and torques of the errors over those above."""
KINDS = ("white noise", "twist noise", "drift", "twist zero", "backlash", "stray point")
CASES = tuple(itertools.product(BEAMS, KINDS))
TRIALS = len(CASES)


def truth(beam: squama.Beam, joint: str, r: np.random.Generator) -> tuple[squama.Beam, float]:
    """Return a beam of another friction and another joint, and its K_theta."""
    mu, factor = r.uniform(0.15, 0.4), r.uniform(0.8, 1.25)
    beam = beam.replace(friction={"mu": mu})
    K = factor * (beam.joint_stiffness if joint == "hinge" else compliant.Held.of(beam).K_theta)
    return beam.replace(joint={"stiffness": K}), K


def loop(beam: squama.Beam, to: float, joint: str, r: np.random.Generator) -> tuple[Array, Array, Array]:
    """Return twists (rad per pitch) of a loop, its torques and its ways, at uneven steps; one reading is at the top."""
    c = squama.cycle(beam, f"{to} rad/pitch", points=600, joint=joint)
    phi, torque, leg = c.phi.values, c["T"].values, c.leg.values
    x, T = [], []
    for number in (1, 2):
        own = np.flatnonzero(leg == number)
        own = own[np.argsort(phi[own], kind="stable")]
        wanted = to * (np.arange(POINTS) + r.uniform(0.2, 0.8, POINTS)) / POINTS
        x.append(np.append(wanted[:-1], to) if number == 1 else wanted[::-1])
        T.append(np.interp(x[-1], phi[own], torque[own]))
    return np.concatenate(x), np.concatenate(T), np.repeat([1.0, -1.0], POINTS)


def measured(case: tuple[str, str], r: np.random.Generator) -> tuple[squama.Beam, dict[str, Array], dict[str, float]]:
    """Return the beam that a fit starts from, a measured loop and the true values."""
    file, scale, to, joint, size = BEAMS[case[0]]
    start = squama.Beam.from_toml(ROOT / file).replace(scale=scale, hold="bend, lateral bend", scales=None)
    beam, K = truth(start, joint, r)
    x, T, way = loop(beam, to, joint, r)
    degree = np.radians(1) / start.pitches
    T = T + size * r.normal(0, NOISE, T.size)
    kind = case[1]
    if kind == "twist noise":
        x = x + degree * r.normal(0, TWIST_NOISE, x.size)
    elif kind == "drift":
        T = T + size * r.choice([-DRIFT, DRIFT]) * np.linspace(0, 1, T.size)
    elif kind == "twist zero":
        x = x + degree * r.choice([-TWIST_ZERO, TWIST_ZERO])
    elif kind == "backlash":
        # half of it either way, or all on the way back
        x = x + degree * BACKLASH * (way / 2 if r.random() < 0.5 else (way - 1) / 2)
    elif kind == "stray point":
        T[r.integers(T.size)] += size * NOISE * r.choice([-1, 1]) * r.uniform(10, 100)
    return start, {"phi": x, "T": T}, {"mu": float(beam.friction.mu or 0), "K_theta": K}


def fitted(case: tuple[str, str], seed: int, starts: int = 6) -> tuple[squama.Fit, dict[str, bool], float]:
    """Return a fit from so many starts, whether its intervals cover, and the seconds of CPU that it took."""
    start, data, values = measured(case, np.random.default_rng([2014, CASES.index(case), seed]))
    begun = time.process_time()
    fit = squama.fit(data, start, joint="hinge" if BEAMS[case[0]][3] == "hinge" else None, starts=starts)
    took = time.process_time() - begun
    return fit, {n: abs(fit.values[n] - v) < 2 * fit.errors[n] for n, v in values.items()}, took


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Fit loops of one case; the line for a failure names the beam and the error."""
    measured(CASES[0], np.random.default_rng(0))  # the code of compliant joints is compiled once, in no fit's time
    case, round_ = CASES[seed % len(CASES)], seed // len(CASES)
    covered, doubted, longest, added = {"mu": 0, "K_theta": 0}, 0, 0.0, set[str]()
    for i in range(size):
        fit, inside, took = fitted(case, round_ * size + i)
        doubted += not fit.holds
        longest = max(longest, took)
        added |= set(fit.added)
        for name, yes in inside.items():
            covered[name] += yes or not fit.holds
    shares = ", ".join(f"{name} {count} of {size}" for name, count in covered.items())
    also = f", found too: {', '.join(sorted(added))}" if added else ""
    print(f"fits, {case[0]}, {case[1]}: {shares}, {doubted} doubted, {longest:.1f} s at most{also}", flush=True)
    failed = [f"{case}: {shares}"] if min(covered.values()) < COVERED * size else []
    return failed + ([f"{case}: {longest:.1f} s of CPU"] if longest > SECONDS else [])
