"""The law of the joint: its stiffness over nine motions as a function of the shape, fitted to finite elements.

Eight numbers describe a pitch: lengths over d, angles, Poisson's ratio (``Shape``). Gaussian processes over
``features`` (``squama.joints.processes``) fit the factor of K (``squama.joints.factor``), so that K is always
positive definite. The outputs are the logarithms of the pivots, less those of a bare bar

    twist G J (Saint-Venant)        bend w (2 lambda)^3 / 12        stretch 2 w lambda

and the ratios L_ij / L_jj. Outputs that change sign in the mirror alpha -> -alpha carry the factor sin(alpha); a
negative alpha is that mirror image. The finite elements are extrapolated to zero element size.

There are two fits. The first is of the core of the range, where most designs lie; the second of all of it, coarser,
holds beyond the core. They pass into each other over a margin outside the core (:func:`wider`).

The forms of the strain S near an edge are fitted over motions of unit energy, which makes them similar for all shapes:
S = L M L^T and M = m^2 R R, with the logarithm of m and the symmetric R of M = R R over its trace.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama.errors import Problem, Problems
from squama.fe.geometry import CROWDED, ROOM, Geometry
from squama.joints.factor import MIRROR, ORDER, TWIST, product
from squama.joints.processes import Errors, Law, Processes, shipped, values
from squama.model import section
from squama.types import Array

ROWS, COLUMNS = np.tril_indices(9, -1)
"""Row and column in the factor of each ratio, row by row."""
_SIGNS = MIRROR[list(ORDER)]
ODD = np.append(np.zeros(9, bool), _SIGNS[ROWS] * _SIGNS[COLUMNS] < 0)
"""Mask of the outputs that change sign with alpha."""
_ALL = np.arange(9)
_LOWER = np.tril_indices(9)
EDGES = 4


class Shape(NamedTuple):
    """Arguments of the law: floats, or arrays (n,) that broadcast; lengths in pitches, angles in rad.

    ``width`` of the section, half thickness ``lam``, embedded length ``zeta``, half width ``beta`` and ``thickness`` of
    a scale, ``alpha``, ``theta0``, Poisson's ratio ``nu``. Complex numbers are steps for derivatives; complex arrays
    (n, k) are n shapes, each with steps in k directions.
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
        """Return the shapes with the given indices."""
        return Shape(*(x[which] for x in self))


class Range(NamedTuple):
    """Range of one parameter of the law: key of the beam file, limits, their unit, and its reference in words."""

    key: str
    low: float
    high: float
    unit: str
    part: str = ""


Region = tuple[Range, ...]
"""Ranges of the eight numbers of the shapes that one fit describes."""
_PARTS = {
    "scale.thickness": "the gap is cos(alpha) sin(theta0) pitches",
    "substrate.width": "the scale's is scale.width cos(alpha)",
}
_UNITS = {
    "scale.alpha": " deg",
    "scale.theta0": " deg",
    "scale.width": " pitches",
    "scale.embedded": " pitches",
    "scale.thickness": " of the gap",
    "substrate.thickness": " pitches",
    "substrate.width": " of the scale's",
    "substrate.poisson_ratio": "",
}


def _region(*limits: tuple[float, float]) -> Region:
    """Return a region from the limits of the eight numbers."""
    named = zip(_UNITS.items(), limits, strict=True)
    return tuple(Range(key, *ends, unit, _PARTS.get(key, "")) for (key, unit), ends in named)


CORE = _region(
    (0.0, 75.0), (5.0, 25.5), (0.69, 2.5), (0.12, 0.52), (0.03, 0.45), (0.58, 1.64), (1.01, 3.15), (0.245, 0.495)
)
"""The core of the law's range."""
WHOLE = _region(
    (0.0, 75.0), (3.1, 30.0), (0.69, 2.5), (0.1, 0.7), (0.02, 0.55), (0.58, 1.88), (1.01, 3.15), (0.245, 0.495)
)
"""The law's range; in addition the scale must fit into the substrate, and beyond the core be no deeper than DEEP."""
DEEP = 0.25
"""Largest depth of embedded parts beyond the core, over the bar's thickness: nearly no designs check deeper ones."""
MARGIN = 0.05
"""Margin outside the core, as a share of its ranges, over which the fit of the whole range comes in."""
COVERING = 2.25
"""Band over the rms: in the core it contains 96 % of the 96 designs in contact that were not fitted, at the worst of
three overlaps (92 % with 2, as errors have longer tails than normal ones).
"""
NEAREST = 5
"""Number of nearest fitted designs whose distance sets the estimated error."""
BORDER, CORNER = 0.1, 1.5
"""Share of a range that counts as near its end; increase of the estimated error where all eight numbers are at an end.
"""
_SLACK = 1e-9
"""Tolerance on the limits, which belong to the range even if a ratio was rounded."""


def stiffness(shape: Shape, by: Law | None = None) -> Array:
    """Return K (9, 9), or (n, 9, 9) for arrays, over the motions of ``squama.joints.factor``, E = 1 and d = 1.

    Positive definite for every shape, also outside the law's range (:func:`outside`). ``by``: one fit for all shapes
    in place of the package's two.

    Raises
    ------
    InputError
        The package's file of the law is missing or damaged.
    """
    return product(_factor(shape, by))


def strain(shape: Shape, by: Law | None = None) -> Array:
    """Return the quadratic forms (4, 9, 9), or (n, 4, 9, 9), of the strain near the edges of the embedded scale.

    With q the nine motions, q^T form q is the mean of 2 W / E near an edge, W the energy per volume: the square of the
    strain of a bar in tension with that energy. Edges are those of ``squama.fe.pitch_stiffness.EDGES_OF_TAB``, the
    averaging distance is its ``NEAR``. Never negative.
    """
    # the mirror image of a negative alpha has the two sides swapped
    turned = np.real(shape.alpha) < 0
    alpha = np.where(turned, -shape.alpha, shape.alpha) if np.ndim(shape.alpha) else shape.alpha * (1 - 2 * turned)
    shape = shape._replace(alpha=alpha)
    y = _mixed(shape, lambda law, _, part: _outputs(law, law.strain, part), by)
    y = y.reshape(*y.shape[:-1], EDGES, 46)
    root = np.zeros((*y.shape[:-1], 9, 9), y.dtype)
    for rows, columns in (_LOWER, _LOWER[::-1]):
        root[..., rows, columns] = y[..., 1:]
    forms = product(_factor(shape, by)[..., None, :, :] @ (root * np.exp(y[..., 0])[..., None, None]))
    image = forms[..., [0, 2, 1, 3], :, :] * np.outer(MIRROR, MIRROR)
    return np.where(np.asarray(turned)[..., None, None, None], image, forms)


def errors(region: Region = CORE) -> Errors:
    """Return the errors of the law against finite elements of designs that were not fitted.

    Of the designs in the core, or of those of the whole range that lie outside it.
    """
    return shipped(wider=region is WHOLE).errors


def band(shape: Shape) -> Array:
    """Return the estimated relative error (n,) of the torque due to the law: ``COVERING`` times its rms at that shape.

    It grows with the ``distance`` to the fitted designs; the relation was calibrated on designs left out in turn
    and on others that were not fitted. It is larger in a corner of the range, where fitted designs lie on one side only
    (:func:`cornered`).
    """
    shape = Shape(*map(np.real, shape))
    return _mixed(shape, lambda law, region, part: _told(part, law, region)[..., None])[..., 0]


def _told(shape: Shape, law: Law, region: Region) -> Array:
    """Return the band (n,) of one fit; see :func:`band`."""
    away = law.apart.scale * distance(shape, law) ** law.apart.power
    return np.asarray(COVERING * np.hypot(law.apart.floor, away) * (1 + CORNER * cornered(shape, region)))


def cornered(shape: Shape, region: Region = CORE) -> Array:
    """Return how far shapes (n,) lie in a corner of a region, from 0 to 1: all eight numbers at an end.

    A number within ``BORDER`` of an end counts by its nearness; a single number is no corner.
    """
    margins = _margins(Shape(*map(np.real, shape)), region)
    near = sum(np.clip(1 - np.minimum(low, high) / BORDER, 0.0, 1.0) for _, low, high in margins)
    return np.asarray(np.maximum(near - 1, 0.0) / (len(region) - 1))


def distance(shape: Shape, law: Law, *, skip: int = 0) -> Array:
    """Return the mean distance (n,) of shapes to the :data:`NEAREST` designs of a fit, in the processes' lengths.

    ``skip``: number of nearest designs to leave out, 1 for the fitted designs themselves.
    """
    f = features(Shape(*map(np.real, shape)))
    at = law.scaled(f.reshape(-1, f.shape[-1])) / law.apart.lengths
    square = ((at**2).sum(1)[:, None] - 2 * at @ law.apart.designs.T) + (law.apart.designs**2).sum(1)
    nearest = np.partition(square, skip + NEAREST, axis=1)[:, : skip + NEAREST]
    nearest.sort(axis=1)
    return np.asarray(np.sqrt(np.maximum(nearest[:, skip:], 0.0)).mean(1).reshape(f.shape[:-1]))


def _factor(shape: Shape, by: Law | None) -> Array:
    """Return the Cholesky factor L (..., 9, 9) of K."""
    y = _mixed(shape, lambda law, _, part: _outputs(law, law.stiffness, part), by)
    y[..., ODD] *= np.sin(shape.alpha)[..., None]
    p = np.exp(y[..., :9])
    p[..., TWIST:] *= np.sqrt(bare(shape))
    L = np.zeros((*p.shape, 9), y.dtype)
    L[..., ROWS, COLUMNS] = y[..., 9:] * p[..., COLUMNS]
    L[..., _ALL, _ALL] = p
    return L


def _outputs(law: Law, of: Processes, shape: Shape) -> Array:
    """Return the outputs (..., m) of processes of a fit."""
    f = features(shape)
    y = values(of, law.scaled(f if f.ndim == 3 else f.reshape(-1, f.shape[-1])))
    return y.reshape(*f.shape[:-1], y.shape[-1])


def _mixed(shape: Shape, of: Callable[[Law, Region, Shape], Array], by: Law | None = None) -> Array:
    """Return numbers (..., m) of the package's two fits, each by its share at the place; with ``by`` of that fit."""
    if by is not None:
        return of(by, CORE, shape)
    share = wider(shape)
    away, inside = share.real > 0, share.real < 1
    if not away.any():
        return of(shipped(), CORE, shape)
    if not inside.any():
        return of(shipped(wider=True), WHOLE, shape)
    many = Shape(*np.broadcast_arrays(*map(np.atleast_1d, shape)))
    share = share.reshape(many.zeta.shape)
    # complex steps of one shape have the same place
    first = share.real.reshape(len(share), -1)[:, 0]
    at, beyond = first < 1, first > 0
    core = of(shipped(), CORE, many.at(at)) * (1 - share[at])[..., None]
    wide = of(shipped(wider=True), WHOLE, many.at(beyond)) * share[beyond][..., None]
    out = np.zeros((*share.shape, core.shape[-1]), np.result_type(core, wide))
    out[at] += core
    out[beyond] += wide
    return out if away.ndim else out[0]


def wider(shape: Shape) -> Array:
    """Return the share (n,) of the fit of the whole range: 0 in the core, 1 from :data:`MARGIN` outside it on."""
    margins = np.array(np.broadcast_arrays(*(v for _, *both in _margins(shape, CORE) for v in both)))
    least = np.take_along_axis(margins, np.real(margins).argmin(axis=0)[None], axis=0)[0]
    t = np.where(np.real(least) >= -_SLACK, 0.0, np.where(np.real(least) <= -MARGIN, 1.0, -least / MARGIN))
    return np.asarray(t * t * (3 - 2 * t))


def deepest(shape: Shape) -> Array:
    """Return the largest depth (n,) of an embedded scale that the law covers, over the bar's thickness."""
    return np.asarray(1 - ROOM - (1 - ROOM - DEEP) * wider(shape))


def region(shape: Shape) -> Region:
    """Return the region in which a shape (of floats) lies."""
    return WHOLE if wider(shape) > 0 else CORE


def features(shape: Shape) -> Array:
    """Return the features (n, 14) of the fit, even in alpha: sizes, angles, and the room of the embedded scale."""
    w, lam, zeta, beta, t, alpha, theta, nu = shape
    c = np.cos(alpha)
    crowded = crowding(shape)
    f = _together(
        (w / (2 * beta * c), lam, zeta, beta, t, np.sin(theta), c, 1.1 - 2 * nu, *crowded, *crowded[:2], alpha**2)
    )
    # shapes that elements refuse still get a joint
    taken = f[..., 8:11]
    f[..., 8:11] = np.where(taken.real < 1, 1.05 - taken, 0.05)
    f[..., :11] = np.log(f[..., :11])
    return f


def crowding(shape: Shape) -> tuple[Array, Array, Array]:
    """Return three ratios of the embedded scale that must stay below 1; see :meth:`squama.fe.geometry.Geometry.check`.

    Its cover taken by half the thickness over the embedded length; its extent along the bar over the pitch; and its
    depth over the substrate's thickness.
    """
    _, lam, zeta, _, t, alpha, theta, _ = shape
    sin, cos = np.sin(theta), np.cos(theta)
    along = (zeta * cos + t / 2 * (sin + 1 / sin)) / np.cos(alpha)
    # without an embedded length there is none to take from
    with np.errstate(divide="ignore"):
        cover = t * cos / (2 * zeta * sin)
    return cover, along, (zeta * sin + t / 2 * cos) / (2 * lam)


def bare(shape: Shape) -> Array:
    """Return the stiffness (n, 3) of a bar without scales against twist, bend and stretch, E = 1 and d = 1."""
    w, depth = shape.width, 2 * shape.lam
    twist = section.torsion_constant(w, depth) * section.shear_modulus(1.0, shape.nu)
    return _together((twist, section.bending_moment_of_area(w, depth), w * depth))


def _together(columns: Sequence[ArrayLike]) -> Array:
    """Return m numbers or arrays (n,) as the columns of an array (n, m)."""
    out = np.empty((*np.broadcast(*columns).shape, len(columns)), np.result_type(float, *columns))
    for k, column in enumerate(columns):
        out[..., k] = column
    return out


def within(shape: Shape, region: Region = WHOLE) -> Array:
    """Return truth values (n,): whether shapes are in the law's range, or in its core."""
    shape = Shape(*map(np.real, shape))
    return np.asarray(np.min(list(rooms(shape, region).values()), axis=0) >= -_SLACK)


def rooms(shape: Shape, region: Region = WHOLE) -> dict[str, Array]:
    """Return the margins (n,) of shapes to each end of the law's range, as shares of the range; negative outside."""
    found = {}
    for r, low, high in _margins(shape, region):
        found[f"the law's {r.key} >= {r.low:g}{r.unit}"] = low
        found[f"the law's {r.key} <= {r.high:g}{r.unit}"] = high
    cover, along, down = crowding(_positive(shape))
    found["the law's cover of the embedded scale"] = 1 - cover
    found[f"the law's embedded scale <= {CROWDED:g} pitches along the bar"] = CROWDED - along
    found["the law's depth of the embedded scale in the bar"] = deepest(shape) - down
    return found


def outside(shape: Shape) -> list[Problem]:
    """Return a problem for each parameter of a shape (of floats) outside the law's range, by the beam file's keys."""
    problems = Problems()
    width, lam, zeta, *rest = _positive(shape)
    # the exposed part plays no role
    pitch = Geometry(width, lam, zeta, 1.0, *rest)
    with problems.caught():
        pitch.check()
    if problems:
        # shapes that finite elements refuse too
        return problems
    deep = 2 * lam * float(deepest(shape)) - pitch.thickness / 2 * np.cos(pitch.theta0)
    longest = {
        "beside its neighbour": pitch.longest(CROWDED),
        "in a bar of this thickness": deep / np.sin(pitch.theta0),
    }
    place = min(longest, key=longest.__getitem__)
    for (key, low, high, unit, part), x in _measured(shape, WHOLE):
        most = min(high, longest[place]) if key == "scale.embedded" else high
        if low - _SLACK <= x <= most + _SLACK:
            continue
        reason = f"the law of the joint goes from {low:g} to {high:g}{unit}{f' ({part})' * bool(part)}"
        if key == "scale.embedded" and x > most:
            reason = f"longer than the law of the joint reaches (zeta up to {max(most, 0.0):.3g} {place})"
        problems.add(key, f"{x:.4g}{unit}", reason)
    return problems


def _margins(shape: Shape, region: Region) -> Iterator[tuple[Range, Array, Array]]:
    """Yield each range of a region, and the margins (n,) of shapes to its low and high end, as shares of the range."""
    for r, x in _measured(shape, region):
        yield r, (x - r.low) / (r.high - r.low), (r.high - x) / (r.high - r.low)


def _measured(shape: Shape, region: Region) -> list[tuple[Range, Array]]:
    """Return each range of a region with the values (n,) that it limits."""
    shape = _positive(shape)
    c, degrees = np.cos(shape.alpha), 180 / np.pi
    gap, across = c * np.sin(shape.theta0), 2 * shape.beta * c
    values = (
        shape.alpha * degrees,
        shape.theta0 * degrees,
        2 * shape.beta,
        shape.zeta,
        shape.thickness / gap,
        2 * shape.lam,
        shape.width / across,
        shape.nu,
    )
    return list(zip(region, values, strict=True))


def _positive(shape: Shape) -> Shape:
    """Return shapes with alpha replaced by its magnitude, the mirror image."""
    # a complex step goes through
    return shape._replace(alpha=shape.alpha * np.where(np.real(shape.alpha) < 0, -1.0, 1.0))
