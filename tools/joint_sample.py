"""The sample of the law of the joint: designs of a pitch, computed by elements.

python tools/joint_sample.py fit [--first I] [--count N] [--workers W] [--folder F]    designs for the fits
python tools/joint_sample.py check [--count N] ...                                     designs that are never fitted
python tools/joint_sample.py pack [--folder F]      add both to the sample that stands beside this file
Sampling goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import time
from collections.abc import Iterable
from math import cos, radians, sin
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

from squama.fe.geometry import Geometry
from squama.joints import law
from squama.types import Array

BOX = {
    "alpha": (0.0, 77.0), "beta": (0.33, 1.3), "theta0": (4.7, 27.0), "zeta": (0.09, 0.55), "gap": (0.02, 0.5),
    "lam": (0.28, 0.85), "width": (1.02, 3.2), "nu": (0.24, 0.496),
}  # fmt: skip
"""Where samples are drawn: a little more than the law's ranges, angles in degrees; ``gap`` is the thickness over
cos(alpha) sin(theta0), ``width`` that of the bar over the scale's 2 beta cos(alpha)."""
WIDE = {
    "alpha": (0.0, 78.5), "beta": (0.33, 1.3), "theta0": (2.9, 36.0), "zeta": (0.09, 1.9), "gap": (0.018, 0.87),
    "lam": (0.28, 0.95), "width": (1.02, 3.2), "nu": (0.24, 0.496),
}  # fmt: skip
"""Where designs of numbers from :data:`FIRST_WIDE` on are drawn; one of :data:`BORDER` near ends of these ranges."""
FIRST_WIDE, BORDER = 100_000, 3
FINE = 4
"""Every so many designs are computed with the finer mesh, too: what it changes is smooth and is fitted apart."""
LINEAR = {"alpha", "nu"}
PACKED = Path(__file__).with_name("joint_law_sample.npz")


def design(index: int, *, held_out: bool) -> dict[str, float]:
    """Return the sample's design of a number: Sobol points for the fit, random ones to check it."""
    from scipy.stats import qmc

    wide = index >= FIRST_WIDE
    if held_out:
        u = np.random.default_rng([7, index]).uniform(0.03, 0.97, len(BOX))
    else:
        # the first point is a corner
        u = qmc.Sobol(len(BOX), scramble=False).fast_forward(index % FIRST_WIDE + 1).random(1)[0]
    if wide and index % BORDER == 1:
        u = np.sin(np.pi / 2 * u) ** 2
    out = {}
    for x, (name, (low, high)) in zip(u.tolist(), (WIDE if wide else BOX).items(), strict=True):
        out[name] = low + x * (high - low) if name in LINEAR else low * (high / low) ** x
    return out


def geometry(x: dict[str, float]) -> Geometry:
    """Return a pitch of the design."""
    alpha, theta0 = radians(x["alpha"]), radians(x["theta0"])
    thickness = x["gap"] * cos(alpha) * sin(theta0)
    width = x["width"] * 2 * x["beta"] * cos(alpha)
    return Geometry(width, x["lam"], x["zeta"], 1.0, x["beta"], thickness, alpha, theta0, x["nu"])


def one(job: tuple[int, bool]) -> dict[str, object]:
    """Return the record of a design: lower triangles of K of each mesh, and of the strains of the coarser one."""
    from squama.errors import InputError

    index, held_out = job
    began = time.process_time()
    x = design(index, held_out=held_out)
    record: dict[str, object] = {"index": index, "design": x}
    try:
        found = meshed(x, 1 + (held_out or index % FINE == 0))
    except InputError as error:
        return {**record, "refused": str(error).splitlines()[0][:120]}
    low = np.tril_indices(9)
    record["K"] = [[float(f"{v:.8g}") for v in r.K[low]] for r in found]
    record["strain"] = [[float(f"{v:.5g}") for v in form[low]] for form in found[0].strain]
    return {**record, "elements": found[-1].elements, "seconds": round(time.process_time() - began, 2)}


def meshed(x: dict[str, float], meshes: int) -> list[Any]:
    """Return what elements say of a design, by the coarser mesh and, of two, by the finer one."""
    from squama.fe.mesh import pitch_mesh
    from squama.fe.pitch_stiffness import response
    from squama.fe.stiffness import sizes

    g = geometry(x)
    g.check()
    size, edges = sizes(g, 3)
    return [response(pitch_mesh(g, size, edge), g) for edge in edges[1 : 1 + meshes]]


def _name(*, held_out: bool) -> str:
    """Return what a sample is called."""
    return "held_out" if held_out else "sample"


def _lines(file: Path) -> Iterable[dict[str, Any]]:
    """Return the records of a file of JSON lines, those cut short left out."""
    for line in file.read_text().splitlines() if file.exists() else ():
        try:
            yield json.loads(line)
        except ValueError:
            print(f"{file}: a line cut short is left out")


def sample(file: Path, numbers: range, workers: int, *, held_out: bool) -> None:
    """Add designs to a file of JSON lines, those that are there or packed set aside."""
    file.parent.mkdir(parents=True, exist_ok=True)
    done = {record["index"] for record in _lines(file)} | set(_packed(file.stem))
    jobs = [(i, held_out) for i in numbers if i not in done]
    with multiprocessing.get_context("spawn").Pool(workers, maxtasksperchild=50) as pool, file.open("a") as out:
        if file.stat().st_size and not file.read_bytes().endswith(b"\n"):
            out.write("\n")
        for n, record in enumerate(pool.imap_unordered(one, jobs)):
            out.write(json.dumps(record) + "\n")
            out.flush()
            if n % 20 == 0:
                print(f"{n + 1} of {len(jobs)}", flush=True)


class Records(NamedTuple):
    """Designs with their elements.

    Numbers, shapes, K (n, 9, 9) of the coarser mesh and of the finer one, NaN where it was not made, forms of the
    strains (n, 4, 9, 9).
    """

    index: Array
    shape: law.Shape
    coarse: Array
    fine: Array
    strain: Array

    @property
    def both(self) -> Array:
        """Where both meshes were made."""
        return np.isfinite(self.fine[:, 0, 0])

    @property
    def limit(self) -> Array:
        """K for elements of no size, in proportion to which the error falls."""
        return 2 * self.fine - self.coarse

    def at(self, which: Array) -> Records:
        """Return some."""
        shape = self.shape.at(which)
        return Records(self.index[which], shape, *(x[which] for x in self[2:]))


def records(folder: Path, *, held_out: bool, wide: bool = False) -> Records:
    """Return what the packed sample and a folder hold, by their numbers; refused designs are left out.

    ``wide``: with the designs that were drawn from :data:`WIDE`.
    """
    name = _name(held_out=held_out)
    rows = _packed(name)
    for record in _lines(folder / f"{name}.jsonl"):
        if "K" in record:
            K = [np.array(v) for v in record["K"]]
            rows[record["index"]] = K[0], K[1] if len(K) > 1 else np.full(45, np.nan), np.array(record["strain"])
    index = np.array(sorted(i for i in rows if wide or i < FIRST_WIDE))
    coarse, fine, strain = (np.array([rows[i][k] for i in index.tolist()]) for k in range(3))
    shapes = [geometry(design(i, held_out=held_out)) for i in index.tolist()]
    shape = law.Shape(*(np.array([getattr(g, name) for g in shapes]) for name in law.Shape._fields))
    return Records(index, shape, whole(coarse), whole(fine), whole(strain))


def _packed(name: str) -> dict[int, tuple[Array, Array, Array]]:
    """Return the rows of a packed sample by their numbers: both meshes and strains, lower triangles."""
    if not PACKED.exists():
        return {}
    with np.load(PACKED) as file:
        index, *table = (file[f"{name}_{key}"].astype(float) for key in ("index", "coarse", "fine", "strain"))
    return {int(i): (coarse, fine, strain) for i, coarse, fine, strain in zip(index, *table, strict=True)}


def whole(rows: Array) -> Array:
    """Return symmetric matrices (.., 9, 9) of their lower triangles (.., 45)."""
    K = np.zeros((*rows.shape[:-1], 9, 9))
    i, j = np.tril_indices(9)
    K[..., i, j] = K[..., j, i] = rows
    return K


def pack(folder: Path) -> None:
    """Write both samples into the file beside this one."""
    low, arrays = np.tril_indices(9), {}
    for held_out in (False, True):
        r, name = records(folder, held_out=held_out, wide=True), _name(held_out=held_out)
        arrays[f"{name}_index"] = r.index.astype(np.int32)
        arrays[f"{name}_shape"] = np.column_stack(r.shape)
        for key in ("coarse", "fine", "strain"):
            arrays[f"{name}_{key}"] = getattr(r, key)[..., *low].astype(np.float32)
    np.savez_compressed(PACKED, **arrays)
    print(f"{PACKED.name}: {len(arrays['sample_index'])} and {len(arrays['held_out_index'])} designs")


def main() -> int:
    """Run a task."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", choices=("fit", "check", "pack"))
    parser.add_argument("--count", type=int, default=1500)
    parser.add_argument("--first", type=int, default=0, help=f"first number; from {FIRST_WIDE} on the larger range")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--folder", type=Path, default=Path("out/joint_law"))
    given = parser.parse_args()
    if given.task == "pack":
        pack(given.folder)
        return 0
    held_out = given.task == "check"
    file = given.folder / f"{_name(held_out=held_out)}.jsonl"
    sample(file, range(given.first, given.first + given.count), given.workers, held_out=held_out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
