"""Fits of tests of a laboratory: the 2-sigma intervals of mu and K_theta hold, or the fit says why they may not.

Specimens of few scales in a machine that gives, bars that are not their file's, loops of different friction, specimens
together, bending. The tables are not made by the model that fits them: the contact solver in increments a quarter as
long, uneven twists, and a machine whose rotation is solved for with the true torque. A trial is one kind.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

import squama
from squama.contacts import path, row
from squama.contacts.ties import LOOSE
from squama.curves import compliant, compliant_cycles
from squama.loads import LOADS
from squama.types import Array

FILE = Path(__file__).parents[2] / "examples" / "stiff_skin.toml"
SIZE, MISSES = 6, 1
"""Specimens of a trial; intervals of a parameter that may miss without a word: two of 6 miss once in 30 times."""
POINTS, TOP, NOISE = 60, 0.12, 1e-4
"""Readings of a way, largest twist (rad per pitch), noise of a torque (N m)."""
BEND, BEND_NOISE = 0.14, 2e-4
_LOAD = LOADS["twisting"]


class Kind(NamedTuple):
    """One kind of test: what is true of it, and what the fit is told.

    ``share`` of the rotation at the top that is the machine's, ``softer`` modulus of the bar over its file's, ``ratio``
    friction of the second loop over the first; ``machine`` as the fit is told: "", "given" or "within" (25 %);
    ``tolerance`` of E_B; ``each``; ``find``; number of scales, specimens and the load.
    """

    share: float = 0.0
    softer: float = 1.0
    ratio: float = 1.0
    machine: str = "given"
    tolerance: str = ""
    each: str = ""
    find: tuple[str, ...] = ("mu", "K_theta")
    scales: int = 6
    specimens: int = 1
    load: str = "twisting"


KINDS = {
    "a machine of 1 %, given": Kind(0.01),
    "a machine of 3.3 %, given": Kind(0.033),
    "a machine of 1 %, within 25 %": Kind(0.01, machine="within"),
    "a machine of 3.3 %, within 25 %": Kind(0.033, machine="within"),
    "a machine of 1 %, not given": Kind(0.01, machine=""),
    "a machine of 3.3 %, not given": Kind(0.033, machine=""),
    "a bar 15 % softer": Kind(softer=0.85),
    "a bar 15 % softer, E_B found": Kind(softer=0.85, find=("mu", "K_theta", "E_B")),
    "a bar 5 % softer, within 5 % (s.d.)": Kind(softer=0.95, tolerance="+- 5 % sd"),
    "a bar and a machine, both within": Kind(0.01, softer=0.95, machine="within", tolerance="+- 5 % sd"),
    "a row of 8 scales, mu known": Kind(scales=8, find=("K_theta",)),
    "a second loop of 1.2 mu": Kind(ratio=1.2),
    "a second loop of 1.2 mu, each": Kind(ratio=1.2, each="mu"),
    "two specimens, each its friction": Kind(ratio=1.2, each="mu", specimens=2),
    "bending, a machine of 2 %, given": Kind(0.02, load="bending"),
    "bending, a machine of 2 %, within 25 %": Kind(0.02, machine="within", load="bending"),
}
TRIALS = len(KINDS)


class Test(NamedTuple):
    """Tables of one specimen or several, the beam of the fit, true values by name, what the fit is told."""

    tables: list[dict[str, Array]]
    beam: squama.Beam
    true: dict[str, float]
    told: dict[str, object]


def walked(beam: squama.Beam, x: Array) -> Array:
    """Return the torques (N m) of all scales through twists, in increments a quarter as long as those of a fit."""
    one = compliant.Path.of(beam, beam.friction.mu or 0.0, (_LOAD.verb,), ideal=False)
    track = row.track(one.way, beam.scales or 0, x, compliant_cycles.OF_ROWS / 4, ends=LOOSE, load=_LOAD.axis)
    return np.asarray(path.named(track.rows)["torque"][:, 0] * beam.unit_moment)


def bent(beam: squama.Beam, x: Array) -> Array:
    """Return the moments (N m) of hinges through bends there and back."""
    c = squama.cycle(beam, f"{BEND} rad/pitch", load="bending", joint="hinge", ideal=True, points=1500)
    leg, psi, M = (c[name].values for name in ("leg", "psi", "M"))
    up = np.arange(x.size) <= np.argmax(x)
    out = np.zeros(x.size)
    for number, own in ((1, up), (2, ~up)):
        known = np.flatnonzero(leg == number)
        known = known[np.argsort(psi[known], kind="stable")]
        out[own] = np.interp(x[own], psi[known], M[known])
    return out


def loop(kind: Kind, beam: squama.Beam, r: np.random.Generator) -> dict[str, Array]:
    """Return true twists (or bends) of a loop per pitch, and its torques, in even steps of nothing."""
    top = TOP if kind.load == "twisting" else BEND
    up = top * (np.arange(1, POINTS) + r.uniform(0.2, 0.8, POINTS - 1)) / POINTS
    down = top * (np.arange(POINTS) + r.uniform(0.2, 0.8, POINTS)) / POINTS
    x = np.concatenate([[0.0], up, [top], down[::-1]])
    return {"x": x, "T": (walked if kind.load == "twisting" else bent)(beam, x)}


def test_of(kind: Kind, r: np.random.Generator) -> Test:
    """Return a test of one kind."""
    file = squama.Beam.from_toml(FILE).replace(scales=kind.scales, hold="bend, lateral bend")
    bending = kind.load == "bending"
    K = (file.joint_stiffness if bending else compliant.Held.of(file).K_theta) * r.uniform(0.8, 1.25)
    mu, E = r.uniform(0.15, 0.35), file.substrate.youngs_modulus
    bar = file.replace(joint={"stiffness": K}, substrate={"youngs_modulus": E * kind.softer})
    loops = [
        loop(kind, bar.replace(friction={"mu": f * mu}), r) for f in ((1.0, kind.ratio) if kind.ratio != 1 else (1.0,))
    ]
    top = max(float(np.max(one["x"])) for one in loops)
    stiff = max(float(np.max(one["T"])) for one in loops) / (top * kind.scales)
    compliance = kind.share / (1 - kind.share) / stiff
    tables, names = [], ("psi", "M") if bending else ("phi", "T")
    for one in loops:
        reading = one["x"] + compliance * one["T"] / kind.scales
        noise = r.normal(0, BEND_NOISE if bending else NOISE, reading.size)
        tables.append(dict(zip(names, (reading, one["T"] + noise), strict=True)))
    if kind.specimens == 1:
        tables = [{name: np.concatenate([t[name] for t in tables]) for name in names}]
    told: dict[str, object] = {"each": kind.each, "load": kind.load}
    if kind.machine == "given":
        told["machine"] = f"{1 / compliance} N m/rad" if compliance else "rigid"
    elif kind.machine == "within":
        middle = r.uniform(0.8, 1.2) / compliance
        told["machine"] = f"{middle} +- {0.25 * middle} N m/rad"
    if kind.tolerance:
        told["tolerances"] = {"E_B": f"{E} Pa {kind.tolerance}"}
    true = {"mu": mu, "K_theta": K}
    if kind.each:
        true |= {"mu[1]": mu, "mu[2]": kind.ratio * mu}
    known = {} if "mu" in kind.find else {"friction": {"mu": mu}}
    return Test(tables, file.replace(**known), true, told)


def trial(seed: int) -> list[str]:
    """Fit all specimens of a kind; the line for a failure names it and its shares."""
    name = list(KINDS)[seed % TRIALS]
    kind, missed, doubted, took, off = KINDS[name], dict[str, int](), 0, 0.0, []
    for i in range(SIZE):
        test = test_of(kind, np.random.default_rng([2029, seed, i]))
        begun = time.process_time()
        fit = squama.fit(test.tables, test.beam, kind.find, starts=3, **test.told)
        took = max(took, time.process_time() - begun)
        told = not fit.holds or (fit.machine is not None and fit.machine.told)
        doubted += told
        apart = {n: (fit.values[n] - v) / fit.errors[n] for n, v in test.true.items() if n in fit.values}
        off.append(fit.values["K_theta"] / test.true["K_theta"] - 1)
        for n, errors in apart.items():
            missed[n] = missed.get(n, 0) + (not told and abs(errors) > 2)
        print(f"  {fit}; off by {', '.join(f'{n} {v:+.1f}' for n, v in apart.items())} errors", flush=True)
    mean = 100 * float(np.mean(off))
    line = (
        f"{name}: {missed} of {SIZE} miss without a word, {doubted} are told, K_theta {mean:+.1f} % off, {took:.1f} s"
    )
    print(f"specimens, {line}", flush=True)
    return [line] if max(missed.values()) > MISSES else []
