"""Designs of `squama design` by finite elements of their own scales: the asked figure is reached within a tenth.

Three targets, each asked for several values: a beam that stiffens in twist, a finger that stiffens in bending, and a
beam whose friction takes a share of the work (damping). A trial is one design; it takes minutes. Elements of a coarse
mesh are told times what their mesh makes of the model (``squama.inverse.by_elements``).
"""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import squama
from squama.inverse.by_elements import ACCEPT
from squama.study import parts

ROOT = Path(__file__).parents[2] / "examples"
STATE = Path("out/campaigns")
"""Where elements go on from when they were stopped."""
SCALES, STARTS = 8, 512


class Ask(NamedTuple):
    """Start of the search, load, deformation up to which it is soft, that of the point, its figure and value there."""

    start: str
    load: str
    soft: str
    at: str
    figure: str
    value: float


LIMB = ("stiff_skin.toml", "twisting", "20 deg total", "50 deg total", "stiffness_ratio")
FINGER = ("finger.toml", "bending", "35 deg total", "55 deg total", "stiffness_ratio")
DAMPED = ("stiff_skin.toml", "twisting", "15 deg total", "55 deg total", "RED")
ASKS = (
    *(Ask(*LIMB, value) for value in (1.6, 2.2, 2.8, 3.4)),
    *(Ask(*FINGER, value) for value in (3.2, 3.6, 4.0)),
    *(Ask(*DAMPED, value) for value in (0.02, 0.03, 0.045)),
)
TRIALS, SIZE = len(ASKS), 1
VARY = {
    "scale.length": ("30 mm", "100 mm"),
    "scale.width": ("14 mm", "40 mm"),
    "scale.alpha": ("20 deg", "65 deg"),
    "scale.theta0": ("8 deg", "25 deg"),
}
SLENDER = {
    "scale.length": ("15 mm", "40 mm"),
    "scale.width": ("8 mm", "18 mm"),
    "scale.alpha": ("10 deg", "30 deg"),
    "scale.theta0": ("8 deg", "25 deg"),
}


def trial(seed: int) -> list[str]:
    """Search a design and compute it by elements; a line where they miss what the search says is reached."""
    ask, begun = ASKS[seed % TRIALS], time.process_time()
    bending = ask.load == "bending"
    # a twisted row is stiff between grips: under a couple it coils
    ends = "couple" if bending else "gripped"
    beam = squama.Beam.from_toml(ROOT / ask.start).replace(scales=SCALES, ends=ends)
    STATE.mkdir(parents=True, exist_ok=True)
    file: dict[str, Any] = {
        "load": ask.load,
        "designs": 1,
        "target": {"engagement": f"at least {ask.soft}", "points": [{"twist": ask.at, ask.figure: ask.value}]},
        "vary": SLENDER if bending else VARY,
        "limits": {"printable": False},
    }
    with patch.object(parts, "elements", partial(parts.elements, restart=STATE / f"design_{seed}.npz")):
        found = squama.inverse_design(file, beam=beam, starts=STARTS, elements=True)
    design = found[0]
    (told,) = (other for other in design.beside if other.key == "elements")
    (goal,) = told.goals
    took = time.process_time() - begun
    values = ", ".join(f"{k} {v:.4g}" for k, v in design.values.items())
    print(f"{ask}: {'reached' if found.met else 'missed'} by the model; {values}; {took:.0f} s", flush=True)
    for line in found.notes:
        print(f"  {line}", flush=True)
    if not found.met or abs(goal.reached - ask.value) <= ACCEPT * ask.value:
        return []
    return [f"{ask}: {goal.reached:.4g} by elements"]
