"""The law of the joint: its stiffness over nine motions from the shape of a pitch, as elements of no size give it.

Eight numbers describe a pitch: lengths over d, angles, Poisson's ratio (:class:`Shape`). The factor of K
(:mod:`squama.joints.factor`) is fitted, so that K is positive definite whatever the numbers are: the logarithms of
its pivots, less those of a bare bar
    twist G J (Saint-Venant)        bend w (2 lambda)^3 / 12        stretch 2 w lambda
and the ratios L_ij / L_jj. Those that change sign in the mirror alpha -> -alpha carry the factor sin(alpha); a negative
alpha is that mirror. Each is a trend, linear in :func:`features`, and a Gaussian process: a sum over the designs of the
sample of a weight and
    exp(-r^2 / 2),    r^2 = sum_k ((f_k - f_k of the design) / l_k)^2
with lengths l_k for each of a few groups of outputs. `tools/joint_law.py` makes the file of numbers anew.
"""

from __future__ import annotations

import functools
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from squama.errors import Problem, Problems, refuse
from squama.fe.geometry import ROOM, Geometry
from squama.joints.factor import MIRROR, ORDER, TWIST, product
from squama.model import section
from squama.types import Array

PLACE = Path(__file__).with_name("law.npz")
VERSION = 1
"""Changes whenever the numbers of the file would mean something else."""
OUTPUTS = 45
"""Pivots and ratios of a factor."""
ROWS, COLUMNS = np.tril_indices(9, -1)
"""Where the ratios stand in the factor, row by row."""
_SIGNS = MIRROR[list(ORDER)]
ODD = np.append(np.zeros(9, bool), _SIGNS[ROWS] * _SIGNS[COLUMNS] < 0)
"""Which outputs change sign with alpha."""
_ALL = np.arange(9)
_CHUNK = 128
"""Shapes at a time, so that their nearness to the sample stays in the cache of the processor."""


class Shape(NamedTuple):
    """What a joint depends on: floats, or arrays (n,) that broadcast; lengths in pitches, angles in rad.

    ``width`` of the section, half thickness ``lam``, embedded length ``zeta``, half width ``beta`` and ``thickness``
    of a scale, ``alpha``, ``theta0``, Poisson's ratio ``nu``. Complex numbers are for derivatives.
    """

    width: Any
    lam: Any
    zeta: Any
    beta: Any
    thickness: Any
    alpha: Any
    theta0: Any
    nu: Any

    def at(self, which: Array) -> Shape:
        """Return some of many shapes."""
        return Shape(*(x[which] for x in self))


class Range(NamedTuple):
    """From where to where the law goes: key of the beam file, limits, their unit, and what they are a part of."""

    key: str
    low: float
    high: float
    unit: str
    part: str = ""


RANGES = (
    Range("scale.alpha", 0.0, 75.0, " deg"),
    Range("scale.theta0", 5.0, 25.5, " deg"),
    Range("scale.width", 0.69, 2.5, " pitches"),
    Range("scale.embedded", 0.095, 0.52, " pitches"),
    Range("scale.thickness", 0.022, 0.45, " of the gap", "the gap is cos(alpha) sin(theta0) pitches"),
    Range("substrate.thickness", 0.58, 1.64, " pitches"),
    Range("substrate.width", 1.01, 3.15, " of the scale's", "the scale's is scale.width cos(alpha)"),
    Range("substrate.poisson_ratio", 0.245, 0.495, ""),
)
"""The law's range; besides, the scale must fit into the substrate."""
_SLACK = 1e-9
"""The limits themselves belong to the range, also where a ratio was rounded on its way here."""


class Error(NamedTuple):
    """How far the law is from elements that were not fitted, relative."""

    rms: float
    worst: float


class Errors(NamedTuple):
    """Errors on ``designs`` shapes: of K_theta, of the torque per twist, of the torque at twice the engagement."""

    designs: int
    K_theta: Error
    rigidity: Error
    torque: Error


class Process(NamedTuple):
    """Outputs with the same lengths: their places (m,), lengths (11,), weights (n, m), the sample over the lengths."""

    outputs: Array
    lengths: Array
    weights: Array
    centres: Array
    halves: Array


class Law(NamedTuple):
    """What stands in the file: how features are scaled, trends (12, outputs), processes, errors."""

    mean: Array
    spread: Array
    trend: Array
    processes: tuple[Process, ...]
    errors: Errors


def stiffness(shape: Shape, by: Law | None = None) -> Array:
    """Return K (9, 9), or (n, 9, 9) of arrays, over the motions of :mod:`squama.joints.factor`, E = 1 and d = 1.

    Positive definite for every shape, whether it is in the law's range (:func:`outside`) or not; ``by`` another law
    than the package's.

    Raises
    ------
    InputError
        The package's file of the law is missing or damaged.
    """
    f = features(shape)
    y = _outputs(by or shipped(), f.reshape(-1, f.shape[-1])).reshape(*f.shape[:-1], OUTPUTS)
    y[..., ODD] *= np.sin(shape.alpha)[..., None]
    p = np.exp(y[..., :9])
    p[..., TWIST:] *= np.sqrt(bare(shape))
    L = np.zeros((*p.shape, 9), y.dtype)
    L[..., ROWS, COLUMNS] = y[..., 9:] * p[..., COLUMNS]
    L[..., _ALL, _ALL] = p
    return product(L)


def features(shape: Shape) -> Array:
    """Return what the fit is over, (n, 11), even in alpha: sizes, and the room around the embedded scale."""
    w, lam, zeta, beta, t, alpha, theta, nu = shape
    sizes = (w / (2 * beta * np.cos(alpha)), lam, zeta, beta, t, np.sin(theta), 1.1 - 2 * nu, *crowding(shape))
    f = _together((*sizes, alpha * alpha))
    # shapes that elements refuse still get a joint
    taken = f[..., 7:10]
    f[..., 7:10] = np.where(taken.real < 1, 1.05 - taken, 0.05)
    f[..., :-1] = np.log(f[..., :-1])
    return f


def crowding(shape: Shape) -> tuple[Array, Array, Array]:
    """Return three shares that must stay below 1, in full at :meth:`squama.fe.geometry.Geometry.check`.

    Of the embedded length that half the thickness takes from its cover, of the pitch that the embedded scale takes,
    and of the substrate's thickness that it reaches down.
    """
    _, lam, zeta, _, t, alpha, theta, _ = shape
    sin, cos = np.sin(theta), np.cos(theta)
    along = (zeta * cos + t / 2 * (sin + 1 / sin)) / np.cos(alpha)
    return t * cos / (2 * zeta * sin), along, (zeta * sin + t / 2 * cos) / (2 * lam)


def bare(shape: Shape) -> Array:
    """Return what a bar without scales opposes to twist, bend and stretch, (n, 3), E = 1 and d = 1."""
    w, depth = shape.width, 2 * shape.lam
    twist = section.torsion_constant(w, depth) * section.shear_modulus(1.0, shape.nu)
    return _together((twist, section.bending_moment_of_area(w, depth), w * depth))


def _together(columns: Sequence[Any]) -> Array:
    """Return numbers and arrays (n,) as columns of one array (n, m)."""
    out = np.empty((*np.broadcast(*columns).shape, len(columns)), np.result_type(float, *columns))
    for k, column in enumerate(columns):
        out[..., k] = column
    return out


def within(shape: Shape) -> Array:
    """Return which shapes are in the law's range, truths (n,)."""
    inside = np.array([r.low - _SLACK <= x for r, x in _measured(shape)])
    inside &= np.array([x <= r.high + _SLACK for r, x in _measured(shape)])
    cover, along, down = crowding(shape._replace(alpha=np.abs(shape.alpha)))
    return np.asarray(inside.all(0) & (cover < 1) & (along <= 1 - ROOM) & (down <= 1 - ROOM))


def outside(shape: Shape) -> list[Problem]:
    """Return where a shape (of floats) leaves the law's range, in the keys of the beam file; none: it does not."""
    problems = Problems()
    with problems.caught():
        _geometry(shape).check()
    for (key, low, high, unit, part), x in _measured(shape):
        if not low - _SLACK <= x <= high + _SLACK:
            reason = f"the law of the joint goes from {low:g} to {high:g}{unit}"
            problems.add(key, f"{x:.4g}{unit}", f"{reason}{f' ({part})' * bool(part)}")
    return problems


def errors() -> Errors:
    """Return how far the law is from elements that were not fitted."""
    return shipped().errors


def _measured(shape: Shape) -> list[tuple[Range, Any]]:
    """Return each range with what is to lie in it."""
    c = np.cos(shape.alpha)
    gap, across = c * np.sin(shape.theta0), 2 * shape.beta * c
    values = (
        np.abs(np.degrees(shape.alpha)), np.degrees(shape.theta0), 2 * shape.beta, shape.zeta, shape.thickness / gap,
        2 * shape.lam, shape.width / across, shape.nu,
    )  # fmt: skip
    return list(zip(RANGES, values, strict=True))


def _geometry(shape: Shape) -> Geometry:
    """Return the pitch with an exposed part of any length; the mirror image of a negative alpha is the same."""
    return Geometry(*shape[:3], 1.0, *shape[3:])._replace(alpha=abs(shape.alpha))


def _outputs(law: Law, f: Array) -> Array:
    """Return the fitted outputs (n, m) at features (n, 11)."""
    x = (f - law.mean) / law.spread
    y = law.trend[0] + x @ law.trend[1:]
    for first in range(0, len(x), _CHUNK):
        part = slice(first, first + _CHUNK)
        for p in law.processes:
            z = x[part] / p.lengths
            near = np.exp(z @ p.centres - p.halves - (z * z).sum(1)[:, None] / 2)
            y[part, p.outputs] += near @ p.weights
    return np.asarray(y)


@functools.cache
def shipped() -> Law:
    """Return the law as it stands in the file."""
    try:
        with PLACE.open("rb") as open_file, np.load(open_file, allow_pickle=False) as file:
            table = {name: file[name] for name in file.files}
        return unpacked(table)
    except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile, zlib.error):
        reason = "the law of the joint is missing, damaged or of another version"
        refuse("", "", reason, "install squama anew", PLACE.name)


def unpacked(table: Mapping[str, Array]) -> Law:
    """Return a law from the arrays of its file: see :class:`Law`; ``group`` numbers each output's process."""
    wide = {name: np.asarray(x, float) for name, x in table.items()}
    sample, weights, group = wide["sample"], wide["weights"], table["group"]
    processes = []
    for g, lengths in enumerate(wide["lengths"]):
        at = np.flatnonzero(group == g)
        centres = sample / lengths
        halves = (centres**2).sum(1) / 2
        processes.append(Process(at, lengths, np.ascontiguousarray(weights[:, at]), centres.T.copy(), halves))
    found = Law(wide["mean"], wide["spread"], wide["trend"], tuple(processes), _errors(wide["errors"]))
    whole = table["version"] == VERSION and found.trend.shape == (1 + sample.shape[1], OUTPUTS)
    if not whole or not all(np.isfinite(x).all() for x in wide.values()):
        raise ValueError
    return found


def _errors(numbers: Array) -> Errors:
    """Return errors from how many designs and six shares."""
    K, rigidity, torque = (Error(*pair) for pair in numbers[1:].reshape(3, 2).tolist())
    return Errors(int(numbers[0]), K, rigidity, torque)
