"""Columns of :mod:`squama.batch` from the dimensions of a beam, for many designs at once.

:func:`columns` does for arrays what :class:`squama.Beam` does for one beam. Every array is an open mesh: it spans only
the dimensions on which it depends, so the laws of joint and section are evaluated once for each combination of their
arguments. :func:`valid` tells which rows are valid beams, :func:`beam_at` builds the beam of one row.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama.beam import beamfile, joint_law
from squama.beam.design import Beam
from squama.errors import InputError, refuse
from squama.loads import LOADS
from squama.model import reach
from squama.study.parameters import BEND, FACTOR, Axis, canonical, text_of
from squama.types import Array

_OPTIONAL = {"scale": ("youngs_modulus", "poisson_ratio", "strength"), "substrate": ("strength", "strain_limit")}
"""Optional numbers of a beam, by its tables."""


class Cells(NamedTuple):
    """Dimensions and ratios of many beams: arrays that broadcast against each other, SI units, radians.

    ``lam`` is the contact height from :meth:`squama.loads.Load.height`, ``K`` the joint's stiffness (N m), ``d`` the
    pitch (m), ``rigidity`` that of the beam without contact (N m^2), ``sizes`` the dimensions by table and key. Moduli
    and strengths that the beam does not state are missing from ``sizes``; ``given`` holds the stated stiffness,
    inclusion factor or matrix from which K and rigidity follow, ``joint_factor`` multiplies the K_theta of a compliant
    joint, ``psi`` (rad per pitch) is the bend in which a beam is held while it is twisted.
    """

    eta: Array
    beta: Array
    lam: Array
    alpha: Array
    theta0: Array
    mu: Array
    K: Array
    d: Array
    rigidity: Array
    sizes: dict[str, dict[str, Array]]
    given: joint_law.Given
    joint_factor: Array | None = None
    psi: Array | None = None

    @property
    def arrays(self) -> dict[str, Array]:
        """All arrays by name but ``sizes`` and ``given``; ``joint_factor`` and ``psi`` only where they are set."""
        found = {name: value for name, value in self._asdict().items() if name not in ("sizes", "given")}
        return {name: value for name, value in found.items() if value is not None}

    def changed(self, arrays: Mapping[str, Any], sizes: dict[str, dict[str, Array]]) -> Cells:
        """Return cells with some arrays, and all sizes, replaced."""
        return self._replace(**arrays, sizes=sizes)

    def mapped(self, f: Callable[..., Array], *others: Cells) -> Cells:
        """Return cells each column of which is ``f`` of this column and of the same column of the ``others``."""
        every = (self, *others)
        sizes = {
            table: {key: f(*(c.sizes[table][key] for c in every)) for key in content}
            for table, content in self.sizes.items()
        }
        return self.changed({name: f(*(c.arrays[name] for c in every)) for name in self.arrays}, sizes)

    @property
    def ratio(self) -> Array:
        """Rigidity over K d, without unit; 0 where the joint has no stiffness."""
        soft = self.K * self.d
        return np.asarray(np.where(soft > 0, self.rigidity / np.where(soft > 0, soft, 1.0), 0.0))


@np.errstate(all="ignore")
def columns(
    beam: Beam, values: Mapping[str, object], *, load: str = "twisting", each: joint_law.Each = joint_law.whole
) -> Cells:
    """Return the columns of a beam with some values replaced; the columns are complex where values are complex.

    ``values``: numbers or arrays that broadcast, SI units, by the names of :data:`squama.study.parameters.PARAMETERS`
    or its aliases. They are not checked; see :func:`valid`. ``each`` selects how the laws of joint and section are
    evaluated: whole arrays (a million designs a second) or :func:`squama.beam.joint_law.one_by_one`, one element after
    the other, equal to :class:`squama.Beam` to the last bit.

    >>> c = columns(Beam.from_ratios(mu=0.3), {"beam.pitch": np.array([0.0177, 0.02])})
    >>> print(c.eta.round(3), c.rigidity.shape)
    [3.013 2.667] (2,)
    """
    values = {canonical(name): value for name, value in values.items()}

    def v(name: str, otherwise: object = None) -> Array:
        return _numbers(values.get(name, otherwise))

    def own(table: str, key: str) -> Array:
        return v(f"{table}.{key}", getattr(getattr(beam, table), key))

    pitch, t = v("beam.pitch", beam.pitch), own("substrate", "thickness") / 2
    d = t / v("lam") if "lam" in values else pitch
    grown = d / pitch if "lam" in values else 1.0

    def sized(ratio: str, size: Array) -> tuple[Array, Array]:
        """Return a ratio and its size (m): as swept, or the beam's own size, which keeps its ratio to the pitch."""
        if ratio in values:
            return v(ratio), np.asarray(v(ratio) * d)
        return np.asarray(size / pitch), np.asarray(size * grown)

    embedded, thickness = own("scale", "embedded"), own("scale", "thickness")
    slenderness = v("slenderness", embedded / thickness)
    eta, length = sized("eta", own("scale", "length"))
    beta, half = sized("beta", own("scale", "width") / 2)
    zeta, embedded = sized("zeta", embedded)
    thickness = np.asarray(thickness * grown)
    if {"zeta", "slenderness"} & set(values):
        thickness = np.where(slenderness > 0, embedded / slenderness, thickness)
    lam = v("lam", t / pitch)
    across, E, nu = (own("substrate", key) for key in ("width", "youngs_modulus", "poisson_ratio"))
    bar_sizes = joint_law.Sizes(E, nu, across, 2 * t, d, half, thickness, embedded, beta, lam, zeta)
    said = beam.given
    stated = [values.get(f"joint.{key}", getattr(said, key)) for key in ("stiffness", "inclusion_factor")]
    known = [None if value is None else _numbers(value) for value in stated]
    given = joint_law.Given(known[0], known[1], said.matrix, said.seen, said.held)
    K = _numbers(joint_law.stiffness(bar_sizes, given, each))
    rigidity = _numbers(joint_law.rigidity(load, bar_sizes, given, each))
    alpha, theta0 = v("alpha", beam.scale.alpha), v("theta0", beam.scale.theta0)
    scale = {"length": length, "embedded": embedded, "width": 2 * half, "thickness": thickness}
    sizes = {
        "scale": {**scale, "alpha": alpha, "theta0": theta0},
        "substrate": {"width": across, "thickness": 2 * t, "youngs_modulus": E, "poisson_ratio": nu},
    }
    for table, keys in _OPTIONAL.items():
        more = {key: values.get(f"{table}.{key}", getattr(getattr(beam, table), key)) for key in keys}
        sizes[table] |= {key: _numbers(value) for key, value in more.items() if value is not None}
    mu = v("mu", 0.0 if beam.friction.mu is None else beam.friction.mu)
    factor, psi = (_numbers(values[name]) if name in values else None for name in (FACTOR, BEND))
    height = LOADS[load].height(lam, beam.neutral)
    return Cells(eta, beta, height, alpha, theta0, mu, K, d, rigidity, sizes, given, factor, psi)


def _numbers(value: object) -> Array:
    """Return an array of floats, or of complex numbers where the value is complex."""
    array = np.asarray(value)
    return array if np.iscomplexobj(array) else array.astype(float)


def check(beam: Beam, load: str, swept: Sequence[Axis]) -> None:
    """Refuse a sweep with cells that are no valid beam: one line with the corner of the grid and the fault there.

    Every size of a cell, and the depth of its embedded tab, grows or falls monotonically with each parameter, so the
    corners of the grid are the worst cells: each corner is built as a :class:`squama.Beam`, with all checks.
    """
    for here in _corners({axis.name: (axis.values[0], axis.values[-1]) for axis in swept}):
        try:
            beam_at(beam, load, here)
        except InputError as error:
            ranges = ", ".join(axis.span for axis in swept if axis.name in here)
            what = "; ".join(map(str, error.problems))
            refuse(ranges, "", "some cells are no valid beam", f"at {at(here)}: {what}")


def _corners(limits: Mapping[str, tuple[float, float]]) -> Iterator[dict[str, float]]:
    """Yield the corners of the ranges of a beam's parameters; friction, margin and bend are left out."""
    named = {name: limit for name, limit in limits.items() if name not in ("mu", "margin", BEND)}
    for corner in itertools.product(*named.values()):
        yield {name: float(value) for name, value in zip(named, corner, strict=True)}


def matrix_warnings(beam: Beam, load: str, limits: Mapping[str, tuple[float, float]]) -> list[str]:
    """Return warnings at the corner of the ranges where a joint's matrix, which is kept, does not fit the shape."""
    if beam.joint.matrix is None:
        return []
    for here in _corners(limits):
        if lines := [line for line in beam_at(beam, load, here).warnings(load) if line.startswith("joint.matrix")]:
            return [f"at {at(here)}: {line}" for line in lines]
    return []


def at(values: Mapping[str, float]) -> str:
    """Return values of parameters (SI) as text with units."""
    return ", ".join(f"{name} = {text_of(name, value)}" for name, value in values.items())


def beam_at(beam: Beam, load: str, values: Mapping[str, float]) -> Beam:
    """Return the beam of one cell, validated; ``margin`` is left out."""
    values = {canonical(name): value for name, value in values.items()}
    found = beam_of(beam, columns(beam, values, load=load, each=joint_law.one_by_one))
    return found.replace(friction={"mu": values["mu"]}) if "mu" in values else found


def beam_of(beam: Beam, c: Cells, shape: tuple[int, ...] = (), cell: tuple[int, ...] = ()) -> Beam:
    """Return the validated beam of one cell of an array of shape ``shape``, with the friction of ``beam``."""

    def number(v: Array) -> float:
        return float(np.broadcast_to(v, shape)[cell])

    parts = {table: {key: number(v) for key, v in content.items()} for table, content in c.sizes.items()}
    stated = {"stiffness": c.given.stiffness, "inclusion_factor": c.given.inclusion_factor}
    changes: dict[str, object] = {**parts, "pitch": number(c.d)}
    changes["joint"] = {key: number(v) for key, v in stated.items() if v is not None}
    return beam.replace(**changes)


def valid(c: Cells) -> Array:
    """Return which rows are valid beams, bool: numbers and ratios within bounds, the tab inside the bar, K finite."""
    with np.errstate(all="ignore"):
        good = (c.eta <= reach.MOST) & (c.beta <= reach.MOST)
        good = good & (c.sizes["scale"]["embedded"] * np.sin(c.theta0) < c.sizes["substrate"]["thickness"])
        numbers = {f"{table}.{key}": v for table in ("scale", "substrate") for key, v in c.sizes[table].items()}
        for name, value in (numbers | {"friction.mu": c.mu, "beam.pitch": c.d}).items():
            low, high, _, closed, _ = beamfile.NUMBERS[name][1]
            good = good & ((value >= low) & (value <= high) if closed else (value > low) & (value < high))
        # K is 0 without an embedded part; a K that is not finite is no joint
        good = good & np.isfinite(c.K) & np.isfinite(c.rigidity) & (c.K >= 0)
    return np.asarray(np.broadcast_to(good, np.broadcast_shapes(good.shape, c.eta.shape, c.K.shape)))
