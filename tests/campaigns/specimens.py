"""Fits of tests of a laboratory: the 2-sigma intervals of mu and K_theta hold, or the fit says why they may not.

Specimens of few scales in a machine that gives, bars that are not their file's, loops of different friction, specimens
together, bending, scales on both faces, grips. The tables are not made by the model that fits them: the contact solver
in increments a quarter as long, uneven twists, and a machine whose rotation is solved for with the true torque. A trial
is one kind.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

import squama
from squama.contacts import path, row
from squama.contacts.ties import KINDS as KINDS_OF_ENDS
from squama.curves import compliant, compliant_cycles
from squama.loads import LOADS
from squama.types import Array

ROOT = Path(__file__).parents[2] / "examples"
SIZE, MISSES = 25, 2
"""Specimens of a trial; intervals of a parameter that may miss without a word: three of 25 miss once in eight times."""
POINTS = 60
"""Readings of a way."""
TESTS = {"twisting": ("stiff_skin.toml", 0.12, 1e-4), "bending": ("finger.toml", 0.13, 2e-4)}
"""Beam, largest twist or bend (rad per pitch) and noise (N m) of a load."""


class Kind(NamedTuple):
    """One kind of test: what is true of it, and what the fit is told.

    ``share`` of the rotation at the top that is the machine's, ``softer`` modulus of the bar over its file's, ``ratio``
    friction of the second loop over the first; ``machine`` as the fit is told: "", "given" or "within" (25 %);
    ``tolerance`` of E_B; ``each``; ``find``; number of scales, specimens, load, ends, what is held, and faces.
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
    ends: str = "free"
    hold: str = "bend, lateral bend"
    faces: str = "one"


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
    "bending, a machine of 2 %, given": Kind(0.02, load="bending", hold="nothing"),
    "bending, a machine of 2 %, within 25 %": Kind(0.02, machine="within", load="bending", hold="nothing"),
    "free to bow": Kind(hold="nothing"),
    "in grips": Kind(hold="nothing", ends="gripped"),
    "scales on both faces": Kind(hold="nothing", faces="turned"),
    "25 scales": Kind(scales=25),
}
TRIALS = len(KINDS)


class Test(NamedTuple):
    """Tables of one specimen or several, the beam of the fit, true values by name, what the fit is told."""

    tables: list[dict[str, Array]]
    beam: squama.Beam
    true: dict[str, float]
    told: dict[str, object]


def walked(beam: squama.Beam, load: str, x: Array) -> Array:
    """Return the torques or moments (N m) of all scales, in increments a quarter as long as those of a fit."""
    by = LOADS[load]
    one = compliant.Path.of(beam, beam.friction.mu or 0.0, (by.verb,), ideal=False)
    kind = KINDS_OF_ENDS[beam.ends or "free"]
    track = row.track(one.way, beam.scales or 0, x, compliant_cycles.OF_ROWS / 4, ends=kind, load=by.axis)
    rows = [path.named(scale) for face in track.faces for scale in face.rows.swapaxes(0, 1)]
    return np.asarray(compliant_cycles.torque(rows, by) * beam.unit_moment)


def loop(kind: Kind, beam: squama.Beam, r: np.random.Generator) -> dict[str, Array]:
    """Return true twists (or bends) of a loop per pitch, and its torques, in even steps of nothing."""
    top = TESTS[kind.load][1]
    up = top * (np.arange(1, POINTS) + r.uniform(0.2, 0.8, POINTS - 1)) / POINTS
    down = top * (np.arange(POINTS) + r.uniform(0.2, 0.8, POINTS)) / POINTS
    x = np.concatenate([[0.0], up, [top], down[::-1]])
    return {"x": x, "T": walked(beam, kind.load, x)}


def test_of(kind: Kind, r: np.random.Generator) -> Test:
    """Return a test of one kind."""
    name, _, noise = TESTS[kind.load]
    like = {"scales": kind.scales, "hold": kind.hold, "ends": kind.ends, "faces": kind.faces}
    file = squama.Beam.from_toml(ROOT / name).replace(**like)
    K = compliant.Held.of(file).K_theta * r.uniform(0.8, 1.25)
    mu, E = r.uniform(0.15, 0.35), file.substrate.youngs_modulus
    bar = file.replace(joint={"stiffness": K}, substrate={"youngs_modulus": E * kind.softer})
    loops = [
        loop(kind, bar.replace(friction={"mu": f * mu}), r) for f in ((1.0, kind.ratio) if kind.ratio != 1 else (1.0,))
    ]
    top = max(float(np.max(one["x"])) for one in loops)
    stiff = max(float(np.max(one["T"])) for one in loops) / (top * kind.scales)
    compliance = kind.share / (1 - kind.share) / stiff
    tables, names = [], ("phi", "T") if kind.load == "twisting" else ("psi", "M")
    for one in loops:
        reading = one["x"] + compliance * one["T"] / kind.scales
        tables.append(dict(zip(names, (reading, one["T"] + r.normal(0, noise, reading.size)), strict=True)))
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
    # of loops that differ, one friction is the mean of both
    true = {"mu": mu * (1 + kind.ratio) / 2, "K_theta": K}
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
