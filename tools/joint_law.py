"""The law of the joint, made anew from its sample: fit, and check on designs that were not fitted.

python tools/joint_law.py fit [--region R] [--folder F]     write a fit into the package
python tools/joint_law.py band [--region R] [--folder F]    write anew its errors and how far it may be off at a place
python tools/joint_law.py check [--region R] [--folder F]   print its errors on designs that were not fitted
python tools/joint_law.py corners                elements of the designs in corners that tests look at, anew
R is core or whole, the region of a fit (squama.joints.law); F may hold designs that are not packed yet
(``joint_sample.py``). Only corners needs elements.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from joint_process import fitted, predicted
from joint_sample import PACKED, Records, meshed, records
from joint_torque import torque
from scipy.optimize import minimize

from squama.joints import law, processes
from squama.joints.factor import BEND, K_THETA, ORDER, STRETCH, TWIST, factor, pivots, product
from squama.types import Array

CHANCE = 0.3
"""Least share of what a finer mesh changes that is taken for chance: where its nodes happen to lie.

For designs left out in turn .1 and .6 are as good."""
GROUPS = (
    *(np.array(at) for at in ((K_THETA,), (TWIST,), (0, 2), (3, 4), (1, BEND, STRETCH))),
    9 + np.flatnonzero(~law.ODD[9:]),
    np.flatnonzero(law.ODD),
)
"""Outputs of K that share their lengths."""
BEYOND = 0.12
"""How far beyond a region, as a share of it, designs of the sample tell how far its fit may be off."""
REGIONS = {"core": law.CORE, "whole": law.WHOLE}
LONGEST, COVERED = 0.85, 0.98
"""Largest extent along the bar, and cover, of the designs for the fit of the whole range; longer ones spoil it."""
STRAINS = processes.STIFFNESS + np.arange(processes.STRAIN)
"""Outputs of the strains, after those of K."""


def of_region(folder: Path, region: law.Region, *, held_out: bool) -> Records:
    """Return the designs for the fit of a region, or those in it that are never fitted."""
    r = records(folder, held_out=held_out, wide=region is law.WHOLE)
    if not held_out:
        cover, along, _ = law.crowding(r.shape)
        return r if region is law.CORE else r.at((along < LONGEST) & (cover < COVERED))
    # those of both meshes; of the whole range those beyond its core
    known = r.both & law.within(r.shape, region)
    return r.at(known if region is law.CORE else known & ~law.within(r.shape, law.CORE))


def corners() -> None:
    """Write anew what elements of no size say of the designs in the corners of the range that tests look at."""
    file, low = PACKED.parents[1] / "tests" / "reference" / "joint_corners.json", np.tril_indices(9)
    made = []
    for case in json.loads(file.read_text()):
        coarse, fine = (r.K for r in meshed(case["design"], 2))
        made.append({**case, "K": [float(f"{v:.8g}") for v in (2 * fine - coarse)[low]]})
    file.write_text(json.dumps(made, indent=1))


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


def errors(r: Records) -> tuple[Array, list[tuple[str, Array]]]:
    """Return the numbers of a fit's file, and rows of relative errors by name, on designs that were not fitted.

    By the package's law: near the core its fit has a part beyond it, too.
    """
    K, true = law.stiffness(r.shape), r.limit
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
    q, forms = expected.motions[good], (law.strain(r.shape), r.strain)
    there, here = (np.sqrt(np.einsum("ni,neij,nj->ne", q, form[good], q)) for form in forms)
    rows += [("strain", (there / here - 1).ravel())]
    told = [dict(rows)[name] for name in (names[K_THETA], names[TWIST], "torque", "strain")]
    numbers = [len(K), *(x for e in told for x in (np.sqrt((e**2).mean()), np.abs(e).max()))]
    L, exact = ((A / np.diagonal(A, axis1=1, axis2=2)[:, None]) for A in (factor(K), factor(true)))
    rows += [("ratios of the factor (absolute)", (L - exact)[:, law.ROWS, law.COLUMNS].ravel())]
    return np.array(numbers), rows


def band(found: processes.Law, sample: Records, r: Records, region: law.Region) -> Array:
    """Return floor, scale and power of a fit's band (:func:`squama.joints.law.band`), of largest likelihood.

    Errors of the torque at twice the engagement are taken for normal, with the squared floor (a quarter of it where the
    sample's designs are left out in turn, whose meshes are those of the fit) and the square of scale r^power for their
    variance. ``r`` are those that were not fitted. A little more than the region counts, so that its corners lie within
    what is known.
    """
    x, _, _, goals = stiffness_goals(sample)
    made, off = np.zeros((len(x), processes.STIFFNESS)), np.zeros((len(x), processes.STIFFNESS))
    for at, goal, odd in goals:
        size = goal.std(0)
        made[:, at], off[:, at] = goal, fitted(x, goal / size, odd).left_out * size
    near = np.min([*law.rooms(sample.shape, region).values()], axis=0) > -BEYOND
    shape = sample.shape.at(near)
    own = torque_errors(shape, inverse(shape, made[near]), inverse(shape, (made - off)[near]))
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


def place(region: law.Region) -> Path:
    """Return the file of the fit of a region."""
    return processes.PLACE if region is law.CORE else processes.WIDER


def write(found: dict[str, Array], folder: Path, region: law.Region) -> None:
    """Write the file of a fit, with its errors in its region and how far it may be off at a place."""
    fit_to, others = (of_region(folder, region, held_out=held_out) for held_out in (False, True))
    found |= {"errors": np.zeros(9), "band": np.ones(3)}
    np.savez_compressed(place(region), **found)
    processes.shipped.cache_clear()
    found["errors"], rows = errors(others)
    found["band"] = band(processes.unpacked(found), fit_to, others, region)
    np.savez_compressed(place(region), **found)
    table(rows)
    floor, scale, power = found["band"]
    print(f"band: floor {floor:.4f}, {scale:.4g} r^{power:.3g}")


def main() -> int:
    """Run a task."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", choices=("fit", "band", "corners", "check"))
    parser.add_argument("--region", choices=REGIONS, default="core", help="region of the fit")
    parser.add_argument("--folder", type=Path, default=Path("out/joint_law"))
    given = parser.parse_args()
    region = REGIONS[given.region]
    if given.task == "fit":
        write(fit(of_region(given.folder, region, held_out=False)), given.folder, region)
    elif given.task == "band":
        with np.load(place(region)) as file:
            write({name: file[name] for name in file.files}, given.folder, region)
    elif given.task == "corners":
        corners()
    else:
        table(errors(of_region(given.folder, region, held_out=True))[1])
    return 0


if __name__ == "__main__":
    sys.exit(main())
