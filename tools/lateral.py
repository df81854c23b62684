"""Stiffness of a pitch against lateral bend: linear elements of designs, and the powers of ``squama.joints.lateral``.

python tools/lateral.py [--count N] [--file F]     goes on where it was stopped; some 5 CPU seconds a design
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import joint_law
import numpy as np
from scipy.optimize import least_squares

from squama.errors import InputError
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import LATERAL, response
from squama.fe.stiffness import sizes
from squama.joints import law
from squama.joints.lateral import covered


def one(number: int) -> dict[str, Any] | None:
    """Return the numbers of a design: its shape, stiffness against bend and lateral bend over the bare bar's."""
    g = joint_law.geometry(joint_law.design(number, held_out=False))
    try:
        g.check()
        size, edges = sizes(g, 3)
        K = response(pitch_mesh(g, size, edges[1]), g, motions=LATERAL).K
    except InputError:
        return None
    bend, lateral = (1 / np.linalg.inv(K[:k, :k])[at, at] for k, at in ((9, 7), (10, 9)))
    depth = 2 * g.lam
    shape = [getattr(g, name) for name in law.Shape._fields]
    return {
        "index": number,
        "shape": shape,
        "bend": bend * 12 / (g.width * depth**3),
        "lateral": lateral * 12 / (g.width**3 * depth),
    }


def main() -> int:
    """Sample, fit, and print powers and errors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=80)
    parser.add_argument("--file", type=Path, default=Path("out/lateral.jsonl"))
    given = parser.parse_args()
    given.file.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in given.file.read_text().splitlines()] if given.file.exists() else []
    first = 1 + max((row["index"] for row in rows), default=-1)
    with given.file.open("a") as out:
        for number in range(first, given.count):
            if row := one(number):
                rows.append(row)
                out.write(json.dumps(row) + "\n")
                out.flush()
    shape = law.Shape(*np.array([row["shape"] for row in rows]).T)
    bend, lateral = (np.log([row[name] for row in rows]) for name in ("bend", "lateral"))
    features = np.log([np.full(len(rows), np.e), covered(shape), np.cos(shape.alpha), shape.zeta]).T
    fit = least_squares(lambda c: np.exp(features @ c) * bend - lateral, np.zeros(4))
    off = np.expm1(fit.fun)
    share, *powers = fit.x
    print(f"{len(rows)} designs: SHARE {np.exp(share):.3f}, powers {np.round(powers, 3)}")
    print(f"off by {100 * np.sqrt((off**2).mean()):.1f} % rms, {100 * np.abs(off).max():.0f} % at most")
    print(f"lateral over bare {np.exp(lateral).min():.3f} to {np.exp(lateral).max():.2f}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
