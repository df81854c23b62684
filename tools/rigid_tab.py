"""How much a joint owes to its rigid tab: elements with the scale's embedded part as a solid of its own modulus.

python tools/rigid_tab.py [--count N] [--out FILE]
Random designs of the range of the law of the joint, and the beams of the examples. The tab is driven by the scale's
six motions at its root, and K compared with that of the same mesh with a tab that is all but rigid; so is the torque of
the beam on compliant joints whose exposed part has the same modulus, at twice the engagement. Both are ordered by
    g = (E_s / E) (t_s / L)^3.
Prints by how much K_theta, the torque per twist and the torque are too high for a rigid tab, and the torque's error
over what the package says of it. Goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np
from joint_sample import design, geometry

from squama import Beam
from squama.contacts.path import Path as Way
from squama.contacts.path import Scale
from squama.curves.compliant import TAB_LIMIT, rigid_tab
from squama.errors import InputError
from squama.fe import geometry as shapes
from squama.fe.elements import Material
from squama.fe.geometry import Geometry
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import response
from squama.fe.stiffness import sizes
from squama.joints import law
from squama.joints.factor import K_THETA, TWIST, pivots
from squama.types import Array

EXAMPLES = Path(__file__).parents[1] / "examples"
RATIOS = (100.0, 500.0, 2e3, 8e3, 3e4, 1.4e5, 1e8)
"""Ratios of the moduli; with the last one a tab is all but rigid."""
BOUNDS = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, math.inf)
"""Of g in the table."""
NU, MU = 0.35, 0.25
ETAS = (2.5, 3.5, 4.5)
FIRST = 1000
"""Number of the first random design."""


def wanted(count: int) -> Iterator[tuple[str, Geometry]]:
    """Yield names and pitches."""
    for file in ("stiff_skin.toml", "pla_on_vps.toml"):
        yield file, shapes.geometry(Beam.from_toml(EXAMPLES / file))
    for i in range(FIRST, FIRST + count):
        g = geometry(design(i, held_out=True))
        if law.within(shape(g)):
            yield str(i), g


def shape(g: Geometry) -> law.Shape:
    """Return what a joint depends on."""
    return law.Shape(*(getattr(g, name) for name in law.Shape._fields))


def matrices(g: Geometry) -> Array:
    """Return K (7, 9, 9) for tabs of the ratios of moduli."""
    size, edges = sizes(g, 3)
    pitch = pitch_mesh(g, size, edges[1], tab=True)
    return np.array([response(pitch, g, Material(ratio, NU)).K for ratio in RATIOS])


def torques(g: Geometry, ratio: float, eta: float, K: Array, rigid: Array) -> tuple[float, float]:
    """Return the torque with the elastic tab and with the rigid one, E d^3, at twice the latter's engagement."""
    D = ratio * g.thickness**3 / (12 * (1 - NU**2))
    scale = Scale(eta, g.beta, g.lam, g.alpha, g.theta0, g.thickness, D, NU)
    first = Way.of(scale, rigid, MU, most=0.3)
    if not 0 < first.contact.phi < math.inf:
        return math.nan, math.nan
    at = np.array([2 * first.contact.phi])
    one, other = (way.states(at)[0][0, 1] for way in (Way.of(scale, K, MU, most=0.6), first))
    return float(one), float(other)


def main() -> int:
    """Compute what is missing, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--count", type=int, default=46)
    parser.add_argument("--out", type=Path, default=Path("out/rigid_tab.jsonl"))
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    lines = given.out.read_text(encoding="utf-8").splitlines() if given.out.exists() else []
    done = {name: np.array(K) for name, K in map(json.loads, lines)}
    rows = []
    for name, g in wanted(given.count):
        if name not in done:
            try:
                done[name] = matrices(g)
            except InputError as error:
                print(f"{name}: {error}", file=sys.stderr)
                continue
            with given.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps([name, done[name].tolist()]) + "\n")
        *K, rigid = done[name]
        inclusion = pivots(rigid)[TWIST] / law.bare(shape(g))[0]
        for ratio, one in zip(RATIOS, K, strict=False):
            off = pivots(rigid) / pivots(one) - 1
            for eta in ETAS if name.isdigit() else (g.eta,):
                T, T_rigid = torques(g, ratio, eta, one, rigid)
                group = ratio * (g.thickness / g.zeta) ** 3
                rows.append((group, off[K_THETA], off[TWIST], T_rigid / T - 1, rigid_tab(group, inclusion)))
                if not name.isdigit():
                    print(name, f"{ratio:g}", *(f"{x:.3g}" for x in rows.pop()))
    table = np.array([row for row in rows if math.isfinite(row[3])])
    print("g from, to, cases; K_theta: median, 90 %, largest; torque per twist: the same; torque: the same")
    for low, high in pairwise(BOUNDS):
        own = table[(table[:, 0] >= low) & (table[:, 0] < high), 1:]
        if len(own):
            print(f"{low:g} {high:g} {len(own)}", *np.quantile(own, (0.5, 0.9, 1.0), axis=0).T.ravel().round(3)[:9])
    found, said = table[:, 3:].T
    print("over what is said: 5 %, half, 95 %", np.quantile(found / said, (0.05, 0.5, 0.95)).round(2))
    told = said > TAB_LIMIT
    print(f"told {told.sum()}, of which {(found[told] > 0.05).sum()} are off by more than 5 %", end="; ")
    print(f"of {(~told).sum()} others {(found[~told] > 0.05).sum()}, the largest by {found[~told].max():.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
