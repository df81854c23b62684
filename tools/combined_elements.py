"""Beams that are bent and twisted, by elements beside thin, rigid scales on hinges and on the compliant joint.

python tools/combined_elements.py [--mesh SIZE EDGE] [--mu MU] [CASE ...]
Elements: one pitch on a screw, no axial force, thin and rigid scales. All models have the joint of the same mesh, so
that what differs is geometry. Lengths in pitches; moments: what the scales add to the bar, over K_theta.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterable
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

from squama import Beam, combined
from squama.beam.matrixfile import inclination_stiffness
from squama.fe.assembly import make_bent
from squama.fe.geometry import Geometry, geometry
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import response
from squama.fe.walk import Walk
from squama.types import Array

STIFF_SKIN = Path(__file__).parents[1] / "examples" / "stiff_skin.toml"
FIG6B = Geometry(1.28, 0.32, 0.18, 3.0, 0.6, 0.004, np.radians(45), np.radians(10), 0.25)
CASES: dict[str, tuple[Geometry, tuple[tuple[float, float], ...]]] = {
    "fig6b bent": (FIG6B, ((0.13, 0.0),)),
    "across bent": (FIG6B._replace(alpha=0.0, theta0=np.radians(20), lam=0.45, thickness=0.02), ((0.27, 0.0),)),
    "skin bent": (geometry(Beam.from_toml(STIFF_SKIN)), ((0.22, 0.0),)),
    "fig6b bent, then twisted": (FIG6B, ((0.08, 0.0), (0.08, 0.12))),
    "fig6b twisted, then bent": (FIG6B, ((0.0, 0.12), (0.08, 0.12))),
}
"""A pitch and the corners (bend, twist) of its path."""
STEPS = 0.005
LINES = {"middle": 0.0, "face": 1.0}
"""Heights of the line that keeps its length, over lambda."""


def led(way: Walk, corners: Iterable[tuple[float, float]]) -> dict[str, Array]:
    """Lead a beam along its path; return its columns."""
    for corner in corners:
        ended = way.run(way.aim(*corner), STEPS)
        if not ended.reached:
            print(f"  {ended.sentence}")
            break
    return {name: np.array(column) for name, column in way.columns.items()}


def engagement(columns: dict[str, Array], name: str) -> float:
    """Return the strain at which the normal force begins, by its first two values on the first leg."""
    i = np.flatnonzero(columns["N"] > 0)[1:3]
    (x, y), (N, P) = columns[name][i], columns["N"][i]
    return float(x - N * (y - x) / (P - N))


def main() -> int:
    """Compute and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(CASES))
    parser.add_argument("--mesh", nargs=2, type=float, default=(0.2, 0.06))
    parser.add_argument("--mu", type=float, default=0.0)
    given = parser.parse_args()
    os.nice(10)
    for name in given.cases or CASES:
        compare(name, tuple(given.mesh), given.mu)
    return 0


def compare(name: str, mesh: tuple[float, float], mu: float) -> None:
    """Print a case."""
    shape, corners = CASES[name]
    begun = time.process_time()
    pitch = pitch_mesh(shape, *mesh)
    K = response(pitch, shape).K
    K_theta, bar = inclination_stiffness(K[:7, :7]), of_bar(K)
    found = led(make_bent(pitch, shape, mu), corners)
    linear = led(make_bent(K, shape, mu), corners)
    print(
        f"{name}: {len(pitch.tets)} elements, mu = {mu:g}, {time.process_time() - begun:.0f} CPU s; K_theta "
        f"{K_theta:.6f}, of the bar M over psi {bar[0, 0]:.5f} and T over phi {bar[1, 1]:.5f}"
    )
    ratios = {k: getattr(shape, k) for k in ("eta", "beta", "lam", "alpha", "theta0")}
    legs = np.diff(np.array([(0.0, 0.0), *corners]), axis=0)
    first, unit = ("psi" if corners[0][0] else "phi"), legs[0] / np.hypot(*legs[0])
    engaged = engagement(found, first)
    fine = np.linspace(0.5, 1.5, 20001) * engaged
    ends = np.cumsum(np.hypot(*legs.T))
    told = [f"elements {engaged:.5f}", f"compliant {engagement(linear, first):.5f}"]
    for words, height in LINES.items():
        s = combined(*np.outer(unit, fine), mu=mu, toward=tuple(unit), neutral_height=height * shape.lam, **ratios)
        told.append(f"{words} {fine[np.flatnonzero(s.contact != '')[0]]:.5f}")
    print(f"  {first} at engagement: {', '.join(told)}")
    both = "".join(f"{words:>12s} M         T" for words in ("elements", "compliant", *LINES))
    print(f"  over engagement, psi, phi, line over lambda, {both}, contact")
    for i in np.flatnonzero(found["N"] > 0):
        way, strains = found["way"][i], np.array([found["psi"][i], found["phi"][i]])
        leg = legs[min(int(np.searchsorted(ends, way - 1e-9)), len(legs) - 1)]
        j = int(np.argmin(np.abs(linear["way"] - way)))
        pairs = [np.array([c["M"][k], c["T"][k]]) - strains @ bar for c, k in ((found, i), (linear, j))]
        figures = [M / K_theta for pair in pairs for M in pair]
        for height in LINES.values():
            s = combined(*strains, mu=mu, toward=tuple(leg), neutral_height=height * shape.lam, **ratios)
            figures += [float(s.bending_moment), float(s.torque)]
        line = found["stretch"][i] / strains[0] / shape.lam if strains[0] else np.nan
        numbers = " ".join(f"{x:9.4f}" for x in (*strains, line, *figures))
        print(f"  {found[first][i] / engaged:5.3f} {numbers}  {found['contact'][i]}")


def of_bar(K: Array) -> Array:
    """Return the moments (2, 2), M and T, by bend and twist of a pitch whose scale and stretch are free."""
    loose, held = [0, 1, 2, 3, 4, 5, 8], [7, 6]
    A, B = K[np.ix_(loose, loose)], K[np.ix_(loose, held)]
    return np.asarray(K[np.ix_(held, held)] - B.T @ np.linalg.solve(A, B))


if __name__ == "__main__":
    sys.exit(main())
