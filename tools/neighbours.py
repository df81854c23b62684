"""Linear elements of a pitch beyond the joint's matrix: lateral bend, and scales that move alternately.

python tools/neighbours.py sample [--first I] [--count N] [--file F]   goes on where it was stopped; 6 CPU s a design
python tools/neighbours.py fit    write squama/joints/tilt.npz from the sample that stands beside this file, and print
                                  its errors, and the powers of squama.joints.lateral

A line of the sample: number of the design, its shape, the bar's stiffness against bend and lateral bend over that of
the bare bar, the joint's compliance against w_Y, and B of squama.joints.tilt over u_Z, w_X, w_Y: uu uX uY XX XY YY.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np
from alternating import alternating, unshared
from joint_process import fitted
from joint_sample import FIRST_WIDE, design, geometry
from scipy.optimize import least_squares

from squama.errors import InputError
from squama.fe.geometry import Geometry
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import LATERAL, response
from squama.fe.stiffness import sizes
from squama.joints import law, tilt
from squama.joints.lateral import covered, power
from squama.types import Array

SAMPLE = Path(__file__).with_name("neighbours.csv")
HEAD = ("index", *law.Shape._fields, "bend", "lateral", "F_YY", "uu", "uX", "uY", "XX", "XY", "YY")
FOLDS, TIP = 10, (2.0, 3.5)
"""Parts of the sample, one of which is left out at a time; overlap ratios at which a tip presses."""


def line(number: int, g: Geometry, K: Array, A: Array) -> list[float]:
    """Return a design's line of the sample from its stiffness (10, 10) and that of alternating scales (6, 6)."""
    bend, lateral = (1 / np.linalg.inv(K[:k, :k])[at, at] for k, at in ((9, 7), (10, 9)))
    depth = 2 * g.lam
    alone = K.copy()
    # in rows the lateral bend does not couple with the other motions
    alone[9], alone[:, 9], alone[9, 9] = 0.0, 0.0, lateral
    B = unshared(A, alone, g.rest)[2:5, 2:5]
    ratios = bend * 12 / (g.width * depth**3), lateral * 12 / (g.width**3 * depth)
    shape = [getattr(g, name) for name in law.Shape._fields]
    return [number, *shape, *ratios, np.linalg.inv(alone)[4, 4], *B[np.triu_indices(3)]]


def sample(first: int, count: int, place: Path) -> None:
    """Add designs to a file of the sample from number ``first`` up to ``count``, those beyond the law's range left out.

    Numbers are those of ``joint_sample``: from its FIRST_WIDE on designs are drawn from a larger box.
    """
    if not place.exists():
        place.write_text(",".join(HEAD) + "\n")
    numbers = [int(row.split(",")[0]) for row in place.read_text().splitlines()[1:]]
    last = max((n for n in numbers if first <= n < count), default=first - 1)
    with place.open("a") as out:
        for number in range(last + 1, count):
            g = geometry(design(number, held_out=False))
            if number >= FIRST_WIDE and not law.within(law.Shape(*(getattr(g, name) for name in HEAD[1:9]))):
                continue
            try:
                g.check()
                size, edges = sizes(g, 3)
                pitch = pitch_mesh(g, size, edges[1])
                found = line(number, g, response(pitch, g, motions=LATERAL).K, alternating(pitch, g))
            except InputError:
                continue
            out.write(",".join(f"{v:.9g}" for v in found) + "\n")
            out.flush()


def fit(place: Path) -> None:
    """Fit both laws, print their errors, and write that of the tilt; designs of the larger box check them."""
    rows = np.loadtxt(place, delimiter=",", skiprows=1)
    known, later = (_table(rows[which]) for which in (rows[:, 0] < FIRST_WIDE, rows[:, 0] >= FIRST_WIDE))
    _lateral(known[0], known[1], later)
    shape, there = known[1], tilt.fitted(known[1])
    shape = shape.at(there)
    own, lift, roll, turn = (known[0][name][there] for name in ("F_YY", "uY", "XY", "YY"))
    Y = np.log(np.column_stack([turn, -roll / np.sin(shape.alpha), -lift]))
    features = law.features(shape)
    mean, spread = features.mean(axis=0), features.std(axis=0)
    x = (features - mean) / spread
    process = fitted(x, Y, steps=60)
    places = tilt.Process(mean, spread, x, process.lengths, process.trend, process.weights)
    np.savez_compressed(tilt.PLACE, **places._asdict())
    B = np.array([known[0][name][there] for name in HEAD[-6:]]).T
    for words, found in (("none", Y - 99), ("left out", Y - process.left_out), ("B itself", Y)):
        _tell(words, shape, B, found, own)
    table, shape = later
    there = tilt.fitted(shape)
    shape, own, B = shape.at(there), table["F_YY"][there], np.array([table[name][there] for name in HEAD[-6:]]).T
    found = places(shape)
    for words, column in (("later designs, none", found - 99), ("later designs", found)):
        _tell(words, shape, B, column, own)


def _table(rows: Array) -> tuple[dict[str, Array], law.Shape]:
    """Return lines of the sample by name, and their shapes."""
    table = dict(zip(HEAD, rows.T, strict=True))
    return table, law.Shape(*(table[name] for name in law.Shape._fields))


def _tell(words: str, shape: law.Shape, B: Array, column: Array, own: Array) -> None:
    """Print how far the compliance under a tip is off."""
    rms, most = _off(shape, B, column, own)
    print(f"tilt, {words}: {len(B)} designs, compliance off by {100 * rms:.1f} % rms, {100 * most:.0f} % (9 of 10)")


def _off(shape: law.Shape, B: Array, column: Array, own: Array) -> tuple[float, float]:
    """Return how far g g^T is off B for a force at a tip, over the compliance of joint and B there: rms, 9 of 10."""
    g = tilt.motion(shape, column)
    half = np.cos(shape.alpha) * np.cos(shape.theta0) / 2
    off = []
    for eta in TIP:
        for side in (-1, 1):
            w = np.array([np.ones_like(half), side * shape.beta - np.sin(shape.alpha) / 2, half - eta])
            uu, uX, uY, XX, XY, YY = B.T
            exact = np.einsum("in,ijn,jn->n", w, np.array([[uu, uX, uY], [uX, XX, XY], [uY, XY, YY]]), w)
            off.append(((w.T * g).sum(axis=1) ** 2 - exact) / (own * w[2] ** 2 + np.abs(exact)))
    errors = np.abs(off)
    return float(np.sqrt((errors**2).mean())), float(np.quantile(errors, 0.9))


def _lateral(table: dict[str, Array], shape: law.Shape, later: tuple[dict[str, Array], law.Shape]) -> None:
    """Print the powers of :mod:`squama.joints.lateral` and their errors, and those of the package on later designs."""
    bend, lateral = np.log(table["bend"]), np.log(table["lateral"])
    features = np.log([np.full(len(bend), np.e), covered(shape), np.cos(shape.alpha), shape.zeta]).T
    found = least_squares(lambda c: np.exp(features @ c) * bend - lateral, np.zeros(4))
    off = np.expm1(found.fun)
    share, *powers = found.x
    print(f"lateral bend: {len(bend)} designs, SHARE {np.exp(share):.3f}, powers {np.round(powers, 3)}")
    print(f"off by {100 * np.sqrt((off**2).mean()):.1f} % rms, {100 * np.abs(off).max():.0f} % at most")
    print(f"lateral over bare {np.exp(lateral).min():.3f} to {np.exp(lateral).max():.2f}")
    table, shape = later
    off = table["bend"] ** power(shape) / table["lateral"] - 1
    rms = np.sqrt((off**2).mean())
    print(f"on {len(off)} later designs off by {100 * rms:.1f} % rms, {100 * np.abs(off).max():.0f} %")


def main() -> int:
    """Sample or fit."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("sample", "fit"))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=400, help="last number and one")
    parser.add_argument("--file", type=Path, default=SAMPLE)
    given = parser.parse_args()
    if given.what == "sample":
        sample(given.first, given.count, given.file)
    else:
        fit(given.file)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
