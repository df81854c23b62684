"""Rows of scales by nonlinear elements of all of them, beside the model with the joint of the same mesh.

    python tools/rows_by_elements.py          # the rows of docs/theory/row.md, some 15 minutes of a core
    python tools/rows_by_elements.py 21       # random rows of 5 scales, one or two minutes each

Prints for each row how far the model is from the elements at the end of the run: load, tangent, and the tangent without
the compliance by which the whole bars differ before contact; and the first contact's force over the middle one's.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

import squama
from squama.fe.geometry import geometry
from squama.fe.loaded import BLANK
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import response
from squama.joints import law
from squama.joints.choice import shape
from squama.study import parts

EXAMPLES = Path(__file__).parents[1] / "examples"
SKIN, FINGER = (squama.Beam.from_toml(EXAMPLES / name) for name in ("stiff_skin.toml", "finger.toml"))
MESH, MU, INCREMENTS, LATE = (0.3, 0.12), 0.25, 14, 4
"""Edges of elements (pitches), friction, increments of a run, and how many of the last ones give the tangent."""


class Row(NamedTuple):
    """A row: its beam and number of scales, and the deformation to which its pitches go (rad)."""

    words: str
    beam: squama.Beam
    scales: int
    to: float
    load: str = "twist"
    support: str = "clamped"


def _scale(length: float, width: float, alpha: float, theta0: float, embedded: float = 6.0) -> dict[str, float]:
    """Return a scale of lengths in mm and angles in degrees."""
    mm, deg = 1e-3, math.radians(1)
    lengths = {"length": length * mm, "width": width * mm, "embedded": embedded * mm}
    return {**lengths, "alpha": alpha * deg, "theta0": theta0 * deg}


WIDE = SKIN.replace(scale=_scale(38, 37.1, 54, 24))
STEEP = SKIN.replace(scale=_scale(70, 29.8, 57.5, 20))
NAMED = (
    Row("stiff_skin, 5 scales in grips", SKIN, 5, 0.1, support="gripped"),
    Row("stiff_skin, 8 scales in grips", SKIN, 8, 0.1, support="gripped"),
    Row("stiff_skin, 5 scales, couple", SKIN, 5, 0.1),
    Row("finger, 5 scales, bent", FINGER, 5, 0.12, load="bend"),
    Row("4 scales 37 mm wide at 54 deg, couple", WIDE, 4, 0.12),
    Row("4 scales 30 mm wide at 57.5 deg, couple", STEEP, 4, 0.1),
)


def drawn(count: int) -> Iterator[Row]:
    """Yield random rows that touch between 3 and 10 deg per pitch, to 1.6 times that."""
    dice, found = np.random.default_rng(5), 0
    while found < count:
        u = dice.random(5)
        alpha, pitch = 20 + 45 * u[0], 1e3 * SKIN.pitch
        width = (1.1 + 2.2 * u[1]) * pitch * math.cos(math.radians(alpha))
        scale = _scale((1.8 + 2.5 * u[4]) * pitch, width, alpha, 10 + 15 * u[2], (0.15 + 0.35 * u[3]) * pitch)
        try:
            beam = SKIN.replace(scale=scale)
            if not law.within(shape(beam)):
                continue
            touch = float(squama.twist(beam.replace(scales=5, ends="couple"), points=20)["phi_e"])
        except squama.InputError:
            continue
        if 3 < math.degrees(touch) < 10.5:
            found += 1
            yield Row(f"random row {found}: {width:.1f} mm wide at {alpha:.1f} deg", beam, 5, 1.6 * touch)


def compare(row: Row) -> str:
    """Compute a row both ways, and return a line."""
    begun, n, g = time.process_time(), row.scales, geometry(row.beam)
    K = response(pitch_mesh(g, *MESH), g).K
    beam = row.beam.replace(joint=parts.joint_of(row.beam, K), scales=n)

    def run(turn: float) -> parts.Run:
        led = parts.led(f"{turn} rad {row.load}", row.support, beam, n)
        return parts.Run(n, led, MU, MESH, abs(led.way) / INCREMENTS, ideal=False)

    first = g.square.pitches - g.square.pitches // 2 + BLANK
    cells = slice(first, first + n)
    most = parts.model(beam, run(3 * row.to * (n + 2 * BLANK)))
    own = np.abs(most["phi_cell" if row.load == "twist" else "psi_cell"].values[:, cells]).mean(axis=1)
    turn = float(np.interp(row.to, own, most["turn"].values))
    d, m = parts.elements(beam, run(turn)), parts.model(beam, run(turn))
    x, T = (np.abs(d[name].values) for name in ("turn", "moment"))
    Tm = np.interp(x, np.abs(m["turn"].values), np.abs(m["moment"].values))
    before, late = x < 0.8 * float(m["share_e"]) * turn, slice(-LATE, None)
    soft, hard = ([np.polyfit(load[at], x[at], 1)[0] for load in (T, Tm)] for at in (before, late))
    forces = [d["N"].values[-1][:-1], m["N"].values[-1][cells][:-1]]
    share = [N[0] / N[len(N) // 2] for N in forces]
    return (
        f"{row.words}: load {Tm[-1] / T[-1] - 1:+.1%}, tangent {hard[0] / hard[1] - 1:+.1%}, before contact "
        f"{soft[0] / soft[1] - 1:+.1%}, tangent without that "
        f"{hard[0] / (hard[1] + soft[0] - soft[1]) - 1:+.1%}, first contact over middle {share[1]:.2f}, elements "
        f"{share[0]:.2f}; {d.attrs['sentence']}, {time.process_time() - begun:.0f} s"
    )


if __name__ == "__main__":
    for row in drawn(int(sys.argv[1])) if len(sys.argv) > 1 else NAMED:
        print(compare(row), flush=True)
