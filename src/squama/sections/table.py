r"""The law of a section as a table: ``squama.law_table``; a potential without friction, or branches of each load alone.

Without friction moment and torque have a potential, the elastic energy per length,

.. math:: w(\kappa, \Phi), \qquad M = \partial w/\partial\kappa, \qquad T = \partial w/\partial\Phi .

Between the nodes of a grid w is the bicubic Hermite polynomial of the nodes' w, M, T and dM/dPhi, of which moment and
torque are the slopes, so that :math:`\partial M/\partial\Phi = \partial T/\partial\kappa` there, too. With friction the
order of bending and twisting counts, and there is no such table: only branches of one load, with the other one free.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama._version import __version__
from squama.beam.design import Beam
from squama.contacts import increments, path, row
from squama.contacts.ties import LOOSE
from squama.curves import compliant, labelled
from squama.curves.chosen import COMPLIANT, idealisation
from squama.curves.way import OPEN, SLIDING, VERBS
from squama.errors import refuse
from squama.loads import LOADS, Load
from squama.sections.trial import Law, compliant_path
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

SNAP = "snap"
"""State of a node behind a jump of the scales, where there is no single potential."""
BRANCHES = ("loading", "unloading")
WITHIN = 10.0
"""Number of scales times (1 - decay) from which the endless beam is accurate to 10 %."""
MOST_EACH, MOST = 1001, 40_000
"""Largest numbers of values of one strain, and of nodes."""
_WORDS: dict[str, tuple[str, str]] = {
    "kappa": ("rad/m", "curvature, positive towards the scaled face"),
    "Phi": ("rad/m", "twist rate"),
    "w": ("J/m", "potential: elastic energy per length"),
    "M": ("N m", "bending moment"),
    "T": ("N m", "torque"),
    "dM_dkappa": ("N m^2", "tangent stiffness in bending"),
    "dM_dPhi": ("N m^2", "change of the moment with the twist rate, and of the torque with the curvature"),
    "dT_dPhi": ("N m^2", "tangent stiffness in twisting"),
    "state": ("", "open, sliding, or why there is no state"),
    "end_M": ("", "why a branch of bending ends, in the senses of negative and positive curvature"),
    "end_T": ("", "why a branch of twisting ends, in both senses"),
}


@dataclass(frozen=True)
class LawTable:
    """A table of a section's law, made by :func:`law_table`.

    ``data``: an ``xarray.Dataset`` in SI units. Over the plane: dimensions ``kappa`` and ``Phi``, variables ``w``,
    ``M``, ``T``, ``dM_dkappa``, ``dM_dPhi``, ``dT_dPhi``, ``state``. Of single loads: ``M`` over ``branch`` and
    ``kappa``, ``T`` over ``branch`` and ``Phi``. Attributes: beam, number of scales for 10 % accuracy, strain limit.
    """

    data: xr.Dataset

    @property
    def plane(self) -> bool:
        """Whether the table is a potential over bend and twist; tables of single loads are not."""
        return "w" in self.data

    def potential(self, kappa: ArrayLike, Phi: ArrayLike) -> Array:
        """Return w, J/m, at curvatures and twist rates (rad/m); NaN beyond the table and where there is no state."""
        return self._slope(kappa, Phi, 0, 0)

    def loads(self, kappa: ArrayLike, Phi: ArrayLike) -> tuple[Array, Array]:
        """Return moment and torque (..), N m, the derivatives of :meth:`potential`."""
        return self._slope(kappa, Phi, 1, 0), self._slope(kappa, Phi, 0, 1)

    def tangent(self, kappa: ArrayLike, Phi: ArrayLike) -> Array:
        """Return the second derivatives (.., 2, 2) of :meth:`potential`, N m^2: symmetric."""
        mixed = self._slope(kappa, Phi, 1, 1)
        rows = [[self._slope(kappa, Phi, 2, 0), mixed], [mixed, self._slope(kappa, Phi, 0, 2)]]
        return np.moveaxis(np.array(rows), (0, 1), (-2, -1))

    def save(self, place: str | Path, format: str | None = None) -> Path:  # noqa: A002 - as in Path and NumPy
        """Write the table to a file, see ``squama.sections.writers.write``."""
        from squama.sections import writers

        return writers.write(self.data, place, format)

    def _slope(self, kappa: ArrayLike, Phi: ArrayLike, i: int, j: int) -> Array:
        """Return the derivative of the potential of orders i and j by curvature and twist rate."""
        if not self.plane:
            refuse("", "", "a table of loads alone has no potential", "give kappa and Phi, and leave uncoupled out")
        x, y = np.broadcast_arrays(np.asarray(kappa, float), np.asarray(Phi, float))
        (a, A), (b, B) = (_hermite(self.data[v].values, at, n) for v, at, n in (("kappa", x, i), ("Phi", y, j)))
        node = {(m, n): self.data[v].values for (m, n), v in _NODES.items()}
        out = np.zeros(x.shape)
        for side_x in range(2):
            for side_y in range(2):
                for (m, n), v in node.items():
                    out = out + A[side_x, m] * B[side_y, n] * v[a + side_x, b + side_y]
        return np.asarray(out)


_NODES = {(0, 0): "w", (1, 0): "M", (0, 1): "T", (1, 1): "dM_dPhi"}
"""Variables at a node, by the orders of the derivative of the potential."""


def _hermite(nodes: Array, at: Array, order: int) -> tuple[Array, Array]:
    """Return intervals (..) and weights (2, 2, ..) of values and slopes at both ends; NaN outside the nodes."""
    k = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2)
    h = nodes[k + 1] - nodes[k]
    t = np.where((at >= nodes[0]) & (at <= nodes[-1]), (at - nodes[k]) / h, np.nan)
    powers = [np.polynomial.polynomial.polyder(p, order) for p in _CUBICS] if order else list(_CUBICS)
    v = [np.polynomial.polynomial.polyval(t, p) / h**order for p in powers]
    return k, np.array([[v[0], h * v[1]], [v[2], h * v[3]]])


_CUBICS = (
    np.array([1.0, 0.0, -3.0, 2.0]),
    np.array([0.0, 1.0, -2.0, 1.0]),
    np.array([0.0, 0.0, 3.0, -2.0]),
    np.array([0.0, 0.0, -1.0, 1.0]),
)
"""Coefficients of Hermite's polynomials on 0..1: value and slope at 0, value and slope at 1."""


def law_table(
    beam: Beam,
    *,
    kappa: ArrayLike | None = None,
    Phi: ArrayLike | None = None,
    mu: float = 0.0,
    uncoupled: bool = False,
    ideal: bool | None = None,
    hold: str | None = None,
) -> LawTable:
    """Tabulate the law of the section of an endless beam: moment and torque over curvature and twist rate.

    Parameters
    ----------
    beam
        The beam.
    kappa, Phi
        Curvatures and twist rates, rad/m, increasing, 3 to 1001 values. Both: a potential over the plane; one: loading
        and unloading by that load alone.
    mu
        Coefficient of friction, 0 for a table over the plane.
    uncoupled
        With both given, loading and unloading by each load alone, as needed for uncoupled section formats. The other
        load's strain is free, as in :func:`squama.twist` and :func:`squama.bend`, or as ``hold`` says.
    ideal, hold
        As in :func:`squama.twist`.

    Returns
    -------
    LawTable
        The table, with its potential and slopes between the nodes, and with ``save``.

    Raises
    ------
    InputError
        An argument is out of range, or a table over the plane has friction.

    Examples
    --------
    >>> import numpy as np, squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45)
    >>> grid = np.linspace(-0.1, 0.1, 9) / beam.pitch
    >>> table = squama.law_table(beam, kappa=grid, Phi=grid)
    >>> M, T = table.loads(kappa=grid[6], Phi=grid[5])
    >>> bool(np.isclose(M, table.data.M[6, 5]))
    True
    """
    arguments.beam(beam)
    grids = {name: _grid(name, v) for name, v in (("kappa", kappa), ("Phi", Phi)) if v is not None}
    if not grids:
        refuse("kappa", "", "neither curvatures nor twist rates are given", "give kappa, Phi or both, in rad/m")
    friction = arguments.friction(None, mu)
    if len(grids) == 1 or uncoupled:
        return LawTable(_alone(beam, grids, friction, ideal, hold))
    if friction:
        refuse(
            "mu",
            f"{friction:g}",
            "must be 0 over the plane: with friction the order of bending and twisting counts",
            "give kappa or Phi alone, write uncoupled=True, or use squama.law",
        )
    if grids["kappa"].size * grids["Phi"].size > MOST:
        refuse("kappa", "", f"the grid has more than {MOST} nodes", "give fewer values")
    one = compliant_path(beam, 0.0, loaded=VERBS, ideal=ideal, hold=hold)
    return LawTable(_plane(one, grids["kappa"], grids["Phi"]))


def _grid(name: str, value: ArrayLike) -> Array:
    """Return the increasing values (n,) of a strain, or refuse them."""
    grid = arguments.numbers(name, value)
    if grid.ndim != 1 or not 3 <= grid.size <= MOST_EACH:
        refuse(name, "", f"must be 3 to {MOST_EACH} values", "write e.g. numpy.linspace(-5, 5, 41)")
    if (np.diff(grid) <= 0).any():
        refuse(name, "", "must rise from value to value", "sort them")
    return grid


def _plane(one: compliant.Path, kappa: Array, Phi: Array) -> xr.Dataset:
    """Return the table over the plane, from the least twist in both senses, with one cell for each curvature."""
    shape = kappa.size, Phi.size
    found = {name: np.full(shape, np.nan) for name in ("w", "M", "T", "dM_dkappa", "dM_dPhi", "dT_dPhi")}
    state, least = np.full(shape, "", "U40"), int(np.abs(Phi).argmin())
    start = Law(one, kappa.size)
    start.trial(kappa, Phi[least])
    start.commit()
    for way in (range(least, Phi.size), range(least - 1, -1, -1)):
        cells = start.copy()
        for j in way:
            M, T = cells.trial(kappa, Phi[j])
            K = cells.tangent()
            snapped = cells.W_snap > 0
            word = np.where(snapped, SNAP, np.where(cells.contacts > 0, SLIDING, OPEN))
            state[:, j] = np.where(cells.end != "", cells.end, word)
            for name, v in zip(found, (cells.U_el, M, T, K[:, 0, 0], K[:, 0, 1], K[:, 1, 1]), strict=True):
                found[name][:, j] = np.where(snapped, np.nan, v)
            cells.commit()
    values = {"kappa": kappa, "Phi": Phi, **found, "state": state}
    dims: dict[str, tuple[str, ...]] = dict.fromkeys((*found, "state"), ("kappa", "Phi"))
    dims |= {"kappa": ("kappa",), "Phi": ("Phi",)}
    return _labelled(values, dims, one, "plane of bend and twist", {"kappa": kappa, "Phi": Phi})


def _alone(beam: Beam, grids: dict[str, Array], mu: float, ideal: bool | None, hold: str | None) -> xr.Dataset:
    """Return the branches of loading and unloading by each load alone."""
    values: dict[str, Array] = {"branch": np.array(BRANCHES)}
    dims: dict[str, tuple[str, ...]] = {"branch": ("branch",)}
    for name, grid in grids.items():
        load = next(load for load in LOADS.values() if load.rate == name)
        one = compliant_path(beam, mu, loaded=(load.verb,), ideal=ideal, hold=hold)
        values[name], dims[name] = grid, (name,)
        values[load.torque], values[f"end_{load.torque}"] = _branches(one, load, grid)
        dims[load.torque], dims[f"end_{load.torque}"] = ("branch", name), ("sense",)
    return _labelled(values, dims, one, "each load alone", grids)


def _branches(one: compliant.Path, load: Load, grid: Array) -> tuple[Array, Array]:
    """Return a load (2, n) on loading from 0 in both senses and on unloading from the ends; and end reasons (2,)."""
    out, ends = np.full((2, grid.size), np.nan), np.full(2, "", "U40")
    out[:, grid == 0] = 0.0
    column = path.COLUMNS.index("M" if load.torque == "M" else "torque")
    for i, sense in enumerate((-1, 1)):
        side = np.flatnonzero(grid * sense > 0)[::sense]
        if not side.size:
            continue
        there = one.beam.pitch * grid[side]
        corners = np.zeros((2 * side.size, 2))
        corners[:, load.axis] = [*there, *there[-2::-1], 0.0]
        found = one.way.along(corners)
        v = found.rows[0, :, column] * one.unit_moment
        out[0, side], out[1, side] = v[: side.size], v[side.size - 1 : -1][::-1]
        if found.end().code != increments.RANGE:
            ends[i] = str(found.end().word)
    return out, ends


def _labelled(
    values: dict[str, Array], dims: dict[str, tuple[str, ...]], one: compliant.Path, title: str, grids: dict[str, Array]
) -> xr.Dataset:
    """Return the dataset of a table, with the attributes used by its files."""
    import xarray as xr

    beam, d = one.beam, one.beam.pitch
    thin = one.way.scale.h == 0 and beam.scale.thickness > 0
    far = max(float(np.abs(grid).max()) for grid in grids.values()) * d
    attrs = {
        "title": f"law of a scale-covered beam's section: {title}",
        "load": " and ".join(load.name for load in LOADS.values() if load.rate in grids),
        "joint": COMPLIANT,
        "scales": idealisation(beam, COMPLIANT, ideal=thin),
        "beam": labelled.text(beam),
        "mu": one.way.mu,
        "pitch": d,
        "scales_for_10_percent": _enough(one, grids),
        "strain_limit": compliant.STRAIN_LIMIT / d,
        **compliant.attributes(one.held, *(load.verb for load in LOADS.values() if load.rate in grids)),
        **{f"bare_{load.torque}": _bare(one, load) for load in LOADS.values()},
        "lateral_rigidity": float(one.held.aside * one.held.K[7, 7] * one.unit_moment * d),
        "squama_version": __version__,
        "warnings": "\n".join(compliant.notes(one.held, beam, far, ideal=thin)),
    }
    found = {name: (dims[name], v, _attrs(name)) for name, v in values.items()}
    coords = {name: found.pop(name) for name in [*found] if dims[name] == (name,)}
    return xr.Dataset(found, coords, attrs)


def _bare(one: compliant.Path, load: Load) -> float:
    """Return the rigidity (N m^2) of the beam without contact for a load alone."""
    held = compliant.Held.of(one.beam, load.verb)
    way = path.Path.at_rest(one.way.scale, held.K, 0.0, **held.bar)
    return compliant.Path(one.beam, held, way, (0.0, 0.0)).case(load).rigidity


def _attrs(name: str) -> dict[str, str]:
    """Return units and long name of a variable."""
    units, words = _WORDS.get(name, ("", ""))
    return {key: v for key, v in (("units", units), ("long_name", words)) if v}


def _enough(one: compliant.Path, grids: dict[str, Array]) -> float:
    """Return the number of scales from which the endless beam is accurate to 10 %, largest over the loads.

    NaN without contact, and with scales on both faces, for which it is not known.
    """
    if one.way.other is not None:
        return math.nan
    most: Sequence[float] = []
    for load in LOADS.values():
        if load.rate not in grids:
            continue
        alone = compliant.Held.of(one.beam, load.verb)
        way = path.Path.at_rest(one.way.scale, alone.K, 0.0, **alone.bar)
        grid = grids[load.rate]
        sense = 1.0 if grid[-1] >= -grid[0] else -1.0
        toward = (0.0, sense) if load.axis else (sense, 0.0)
        left = row.decay(way.looked(toward, path.RANGE), LOOSE, load.axis)
        most = [*most, WITHIN / (1 - left)] if left < 1 else most
    return math.ceil(max(most)) if most else math.nan
