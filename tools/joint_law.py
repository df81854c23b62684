"""The law of the joint, made anew: sample the elements, fit, and check on designs that were not fitted.

python tools/joint_law.py sample [--first I] [--count N] [--workers W] [--folder F]   designs for the fit
python tools/joint_law.py check-sample [--count N] ...                      designs that are never fitted
python tools/joint_law.py pack [--folder F]      add both to the sample that stands beside this file
python tools/joint_law.py fit [--folder F]       write the law into the package, from both samples
python tools/joint_law.py band [--folder F]      write anew into it its errors and how far it may be off at a place
python tools/joint_law.py corners                elements of the designs in corners that tests look at, anew
python tools/joint_law.py check [--folder F]     print its errors on designs that were not fitted
Sampling goes on where it was stopped; fit and check need no elements.
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
from joint_process import fitted, predicted
from joint_torque import torque
from scipy.optimize import minimize

from squama.fe.geometry import Geometry
from squama.joints import law, processes
from squama.joints.factor import BEND, K_THETA, ORDER, STRETCH, TWIST, factor, pivots, product
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
CHANCE = 0.3
"""Least share of what a finer mesh changes that is taken for chance: where its nodes happen to lie.

For designs left out in turn .1 and .6 are as good."""
LINEAR = {"alpha", "nu"}
PACKED = Path(__file__).with_name("joint_law_sample.npz")
GROUPS = (
    *(np.array(at) for at in ((K_THETA,), (TWIST,), (0, 2), (3, 4), (1, BEND, STRETCH))),
    9 + np.flatnonzero(~law.ODD[9:]),
    np.flatnonzero(law.ODD),
)
"""Outputs of K that share their lengths."""
BEYOND = 0.12
"""How far beyond the law's range, as a share of it, designs of the sample tell how far the law may be off."""
STRAINS = processes.STIFFNESS + np.arange(processes.STRAIN)
"""Outputs of the strains, after those of K."""


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


def corners() -> None:
    """Write anew what elements of no size say of the designs in the corners of the range that tests look at."""
    file, low = PACKED.parents[1] / "tests" / "reference" / "joint_corners.json", np.tril_indices(9)
    made = []
    for case in json.loads(file.read_text()):
        coarse, fine = (r.K for r in meshed(case["design"], 2))
        made.append({**case, "K": [float(f"{v:.8g}") for v in (2 * fine - coarse)[low]]})
    file.write_text(json.dumps(made, indent=1))


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

    ``wide``: with designs of the larger range, which are too few for a fit so far.
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


def outputs(shape: law.Shape, K: Array) -> Array:
    """Return what the law fits of K (n, 9, 9): the inverse of its last step, (n, 45)."""
    L = factor(K)
    p = np.diagonal(L, axis1=1, axis2=2)
    logs = np.log(p)
    logs[:, TWIST:] -= np.log(law.bare(shape)) / 2
    y = np.column_stack([logs, L[:, law.ROWS, law.COLUMNS] / p[:, law.COLUMNS]])
    y[:, law.ODD] /= np.sin(shape.alpha)[:, None]
    return y


def inverse(shape: law.Shape, y: Array) -> Array:
    """Return K (n, 9, 9) of what the law fits of it: the way back of :func:`outputs`."""
    y = y.copy()
    y[:, law.ODD] *= np.sin(shape.alpha)[:, None]
    p = np.exp(y[:, :9])
    p[:, TWIST:] *= np.sqrt(law.bare(shape))
    L = np.zeros((len(p), 9, 9))
    L[:, law.ROWS, law.COLUMNS] = y[:, 9:] * p[:, law.COLUMNS]
    L[:, range(9), range(9)] = p
    return product(L)


def strain_outputs(sample: Records) -> Array:
    """Return what the law fits of the forms of the strains, (n, 184): per edge log m and the lower triangle of R."""
    L = factor(sample.coarse)[:, None]
    rows = list(ORDER)
    M = np.linalg.solve(L, np.swapaxes(np.linalg.solve(L, sample.strain[..., rows, :][..., rows]), -1, -2))
    trace = np.trace(M, axis1=-2, axis2=-1)
    w, V = np.linalg.eigh((M + np.swapaxes(M, -1, -2)) / (2 * trace[..., None, None]))
    R = (V * np.sqrt(np.maximum(w, 0.0))[..., None, :]) @ np.swapaxes(V, -1, -2)
    return np.concatenate([np.log(trace)[..., None] / 2, R[..., *np.tril_indices(9)]], -1).reshape(len(M), -1)


def stiffness_goals(sample: Records) -> tuple[Array, Array, Array, list[tuple[Array, Array, Array]]]:
    """Return scaled features, what they are less and over, and by groups: outputs of K, their goals, their noise."""
    f = law.features(sample.shape)
    mean, spread = f.mean(0), f.std(0)
    x, both, noise = (f - mean) / spread, sample.both, 1 / np.sin(sample.shape.alpha) ** 2
    y = outputs(sample.shape, sample.coarse)
    change = outputs(sample.shape.at(both), sample.limit[both]) - y[both]
    goals = []
    for at in GROUPS:
        odd = noise if law.ODD[at[0]] else np.ones(len(x))
        size = change[:, at].std(0)
        small = fitted(x[both], change[:, at] / size, odd[both], noise=CHANCE)
        goals.append((at, y[:, at] + predicted(small, x[both], x) * size, odd))
    return x, mean, spread, goals


def fit(sample: Records) -> dict[str, Array]:
    """Return the arrays of the law's file but for its errors.

    What the finer mesh and the limit of no size change is fitted to the designs that have both, and added to all.
    """
    x, mean, spread, goals = stiffness_goals(sample)
    goals.append((STRAINS, strain_outputs(sample), np.ones(len(x))))
    most = STRAINS[-1] + 1
    group, weights, trend, lengths = (
        np.zeros(most, np.int8),
        np.zeros((len(x), most)),
        np.zeros((1 + x.shape[1], most)),
        [],
    )
    for g, (at, goal, odd) in enumerate(goals):
        size = goal.std(0)
        found = fitted(x, goal / size, odd)
        group[at], weights[:, at], trend[:, at] = g, found.weights * size, found.trend * size
        lengths.append(found.lengths)
        left = np.sqrt((found.left_out**2).mean(0)) * size
        print(f"group {g}: noise {found.noise:.1e}, left out {np.round(left.min(), 4)} to {np.round(left.max(), 4)}")
    table = {
        "sample": x,
        "mean": mean,
        "spread": spread,
        "lengths": np.array(lengths),
        "weights": weights,
        "trend": trend,
    }
    return {
        "version": np.array(processes.VERSION),
        "group": group,
        **{k: v.astype(np.float32) for k, v in table.items()},
    }


def errors(found: processes.Law, held_out: Records) -> tuple[Array, list[tuple[str, Array]]]:
    """Return the numbers of the law's file, and rows of relative errors by name, on designs that were not fitted."""
    r = held_out.at(held_out.both)
    r = r.at(law.within(r.shape))
    K, true = law.stiffness(r.shape, found), r.limit
    names = ("u_X", "u_Y", "u_Z", "w_X", "w_Z", "K_theta (w_Y)", "rigidity (phi)", "bend (psi)", "stretch")
    rows = list(zip(names, (pivots(K) / pivots(true) - 1).T, strict=True))
    eta = np.random.default_rng(3).choice([2.5, 3.5, 4.5], len(K))
    expected = torque(r.shape, true, eta)
    reached = torque(r.shape, K, eta, 2 * expected.engagement)
    good = expected.good & reached.good
    rows += [("engagement", (reached.engagement / expected.engagement - 1)[good])]
    rows += [("torque", (reached.torque / expected.torque - 1)[good])]
    # no error of the law: what ends that may come nearer change
    loose = torque(r.shape, true, eta, 2 * expected.engagement, free=True)
    both = expected.good & loose.good
    rows += [("torque of ends that are free", (loose.torque / expected.torque - 1)[both])]
    bare = np.linalg.inv(np.linalg.inv(true[:, [*range(7), 8]][:, :, [*range(7), 8]])[:, 6:7, 6:7])[:, 0, 0]
    rows += [("rigidity of ends that are free", bare / pivots(true)[:, TWIST] - 1)]
    # the strains of the coarser mesh, at the state of the torque
    q, forms = expected.motions[good], (law.strain(r.shape, found), r.strain)
    there, here = (np.sqrt(np.einsum("ni,neij,nj->ne", q, form[good], q)) for form in forms)
    rows += [("strain", (there / here - 1).ravel())]
    told = [dict(rows)[name] for name in (names[K_THETA], names[TWIST], "torque", "strain")]
    numbers = [len(K), *(x for e in told for x in (np.sqrt((e**2).mean()), np.abs(e).max()))]
    L, exact = ((A / np.diagonal(A, axis1=1, axis2=2)[:, None]) for A in (factor(K), factor(true)))
    rows += [("ratios of the factor (absolute)", (L - exact)[:, law.ROWS, law.COLUMNS].ravel())]
    return np.array(numbers), rows


def band(found: processes.Law, sample: Records, held_out: Records) -> Array:
    """Return floor, scale and power of the law's band (:func:`squama.joints.law.band`), of largest likelihood.

    Errors of the torque at twice the engagement are taken for normal, with the squared floor (a quarter of it where the
    sample's designs are left out in turn, whose meshes are those of the fit) and the square of scale r^power for their
    variance. A little more than the law's range counts, so that its corners lie within what is known.
    """
    x, _, _, goals = stiffness_goals(sample)
    made, off = np.zeros((len(x), processes.STIFFNESS)), np.zeros((len(x), processes.STIFFNESS))
    for at, goal, odd in goals:
        size = goal.std(0)
        made[:, at], off[:, at] = goal, fitted(x, goal / size, odd).left_out * size
    near = np.min([*law.rooms(sample.shape).values()], axis=0) > -BEYOND
    shape = sample.shape.at(near)
    own = torque_errors(shape, inverse(shape, made[near]), inverse(shape, (made - off)[near]))
    r = held_out.at(held_out.both)
    r = r.at(law.within(r.shape))
    other = torque_errors(r.shape, r.limit, law.stiffness(r.shape, found))
    parts = [(own, law.distance(shape, found, skip=1), 0.25), (other, law.distance(r.shape, found), 1.0)]

    def unlikely(at: Array) -> float:
        total = 0.0
        for e, far, share in parts:
            variance = share * np.exp(2 * at[0]) + np.exp(2 * np.clip(at[1] + at[2] * np.log(far), -12, 2))
            known = np.isfinite(e).any(axis=0)
            square = np.nanmean(e[:, known] ** 2, axis=0)
            total += (np.log(variance[known]) + square / variance[known]).sum()
        return float(total)

    best = minimize(unlikely, [-5.7, 7.0, 5.0], method="Nelder-Mead", options={"maxiter": 4000, "maxfev": 4000})
    return np.array([np.exp(best.x[0]), np.exp(best.x[1]), best.x[2]])


def torque_errors(shape: law.Shape, true: Array, K: Array) -> Array:
    """Return relative errors of the torque at twice the engagement for three overlaps, (3, n); NaN without contact."""
    rows = []
    for eta in (2.5, 3.5, 4.5):
        every = np.full(len(K), eta)
        expected = torque(shape, true, every)
        reached = torque(shape, K, every, 2 * expected.engagement)
        rows.append(np.where(expected.good & reached.good, reached.torque / expected.torque - 1, np.nan))
    return np.array(rows)


def table(rows: Iterable[tuple[str, Array]]) -> None:
    """Print errors in per cent."""
    print(f"{'':34}{'designs':>8}{'rms':>8}{'worst':>8}  %")
    for name, e in rows:
        print(f"{name:34}{e.size:8}{100 * np.sqrt((e**2).mean()):8.2f}{100 * np.abs(e).max():8.2f}")


def write(found: dict[str, Array], folder: Path) -> None:
    """Write the law's file, with its errors in the law's range and how far it may be off at a place."""
    made = processes.unpacked({**found, "errors": np.zeros(9), "band": np.ones(3)})
    fit_to, others = (records(folder, held_out=held_out) for held_out in (False, True))
    numbers, rows = errors(made, others)
    told = band(made, fit_to, others)
    np.savez_compressed(processes.PLACE, **{**found, "errors": numbers, "band": told})
    table(rows)
    print(f"band: floor {told[0]:.4f}, {told[1]:.4g} r^{told[2]:.3g}")


def main() -> int:
    """Run a task."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", choices=("sample", "check-sample", "pack", "fit", "band", "corners", "check"))
    parser.add_argument("--count", type=int, default=1500)
    parser.add_argument("--first", type=int, default=0, help=f"first number; from {FIRST_WIDE} on the larger range")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--folder", type=Path, default=Path("out/joint_law"))
    given = parser.parse_args()
    if given.task in {"sample", "check-sample"}:
        held_out = given.task == "check-sample"
        file = given.folder / f"{_name(held_out=held_out)}.jsonl"
        sample(file, range(given.first, given.first + given.count), given.workers, held_out=held_out)
    elif given.task == "pack":
        pack(given.folder)
    elif given.task == "fit":
        write(fit(records(given.folder, held_out=False)), given.folder)
    elif given.task == "band":
        with np.load(processes.PLACE) as file:
            write({name: file[name] for name in file.files}, given.folder)
    elif given.task == "corners":
        corners()
    else:
        table(errors(processes.shipped(), records(given.folder, held_out=True))[1])
    return 0


if __name__ == "__main__":
    sys.exit(main())
