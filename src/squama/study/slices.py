"""Slices of a sweep: two dimensions, a panel for each value of a third, and one value of all others.

Also the paths of single beams of a slice: inclination against load angle, without friction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama.arrays import solution
from squama.beam.design import Beam
from squama.errors import refuse
from squama.loads import PAPER
from squama.study.columns import columns
from squama.study.parameters import BEND, PARAMETERS, canonical, read_value, text_of
from squama.types import Array
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

MOST_PANELS = 6
POINTS = 200
"""Points of a path."""


class Slice(NamedTuple):
    """A slice of a sweep: ``data`` over the dimensions ``panels`` (or None), ``y`` (None for a line) and ``x``."""

    data: xr.Dataset
    x: str
    y: str | None
    panels: str | None


def take(
    dataset: xr.Dataset,
    *,
    x: str | None = None,
    y: str | None = None,
    panels: str | None = None,
    at: Mapping[str, object] | None = None,
    bare: bool = True,
) -> Slice:
    """Choose a slice of a sweep by the names of its dimensions, without reading values from the store.

    ``x`` is by default the last remaining dimension, ``y`` the first, ``panels`` is ``law`` where there are two laws.
    ``at`` fixes other dimensions at the nearest value of the grid; a number without a unit is SI (``bare``) or refused.
    Names that are no dimension of the sweep, values outside its ranges, and dimensions neither shown nor fixed are
    refused.
    """
    dims = [str(dim) for dim in dataset["RED"].dims]
    fixed = {_dimension(name, dims, "at"): value for name, value in (at or {}).items()}
    named = {"x": x, "y": y, "panels": panels}
    chosen = {role: _dimension(name, dims, role) for role, name in named.items() if name is not None}
    used = [*chosen.values(), *fixed]
    for name in used:
        if used.count(name) > 1:
            refuse(name, "", "is used twice", "give each dimension one place among x, y, panels and at")
    for role in ("x", "y"):
        if chosen.get(role) == "law":
            refuse(role, "law", "has no order", "write panels law")
    if "panels" not in chosen and "law" in dims and "law" not in used:
        chosen["panels"] = "law"
    data = dataset.isel({name: _index(dataset, name, value, bare) for name, value in fixed.items()})
    rest = [dim for dim in dims if dim not in (*fixed, *chosen.values())]
    if "x" not in chosen:
        if not rest:
            refuse("", "", "no dimension is left for x", "hold fewer with at")
        chosen["x"] = rest.pop()
    if "y" not in chosen and rest:
        chosen["y"] = rest.pop(0)
    if rest:
        text = ", ".join(f"{n} ({_span(dataset, n)})" for n in rest)
        refuse(text, "", "is neither shown nor held", "hold it with at, or show it as x, y or panels")
    over = chosen.get("panels")
    if over is not None and data.sizes[over] > MOST_PANELS:
        refuse("panels", over, f"has {data.sizes[over]} values, {MOST_PANELS} panels at most", "hold it with at")
    order = [chosen[role] for role in ("panels", "y", "x") if role in chosen]
    return Slice(data.drop_vars("status").transpose(*order), chosen["x"], chosen.get("y"), over)


def thinned(part: Slice, most: int) -> Slice:
    """Return a slice with at most ``most`` values along x and along y, loaded from the store."""
    steps = {dim: slice(None, None, -(-part.data.sizes[dim] // most)) for dim in (part.x, part.y) if dim}
    return part._replace(data=part.data.isel(steps).load())


def ends(data: xr.Dataset) -> Array:
    """Return the ends of a sweep's cells in words; "not computed" in unfinished tiles."""
    words = np.array([word.replace("_", " ") for word in data["end"].attrs["flag_meanings"].split()])
    return np.asarray(words[data["end"].values + 1])


def worded(data: xr.Dataset) -> xr.Dataset:
    """Return a slice with the codes of the ends replaced by words, for files."""
    end = data["end"]
    attrs = {"long_name": end.attrs["long_name"], "units": ""}
    return data.assign(end=(end.dims, ends(data), attrs))


def values_of(part: Slice, texts: Sequence[object], *, bare: bool) -> list[float]:
    """Return the values of y on the grid that are nearest to the given values (SI), without repetitions."""
    assert part.y is not None
    places = dict.fromkeys(_index(part.data, part.y, text, bare) for text in texts)
    return [float(part.data[part.y].values[i]) for i in places]


def paths(part: Slice, texts: Sequence[str], *, bare: bool) -> dict[float, tuple[Array, Array]]:
    """Return load angle and inclination (rad) along the path of each beam, by its value of x, on the grid or not.

    Friction and force law do not change a path, only the place of a lock on it: paths end where they would at mu = 0.
    The slice needs y = mu, and panels of law or margin only, so that all its lines lie on the same paths.
    """
    if part.data.attrs["joint"] != PAPER["joint"] or part.data.attrs["scales"] != PAPER["scales"]:
        refuse("paths", "", "are for thin, rigid scales on hinges, and this sweep has others")
    if BEND in part.data.coords:
        refuse("paths", "", "are for beams that are twisted only", "leave it out")
    if part.y != "mu" or part.panels not in (None, "law", "margin"):
        refuse("paths", "", "needs y = mu, and no panels but law and margin: else there is a path for each line")
    data, load = part.data, part.data.attrs["load"]
    beam = Beam.from_toml_text(data.attrs["beam"])
    fixed = {str(n): float(data[n]) for n in data.coords if n in PARAMETERS and data[n].ndim == 0}
    at = np.array([read_value(part.x, text, bare=bare) for text in texts])
    c = columns(beam, fixed | {part.x: at}, load=load)._replace(mu=np.zeros(at.size))
    flat = {name: np.array(np.broadcast_to(getattr(c, name), at.size)) for name in solution.COLUMNS}
    found = solution.solve(flat, load=load, law="edge", sense=data.attrs["sense"])
    found_at = zip(at.tolist(), *found.sampled(POINTS), strict=True)
    return {value: (angle, theta) for value, angle, theta in found_at if np.isfinite(angle[0])}


def _dimension(name: str, dims: Sequence[str], role: str) -> str:
    found = name if name in (*dims, "law") else canonical(name)
    if found not in dims:
        refuse(role, shown(name).strip('"'), "is no dimension of this sweep", f"it has {', '.join(dims)}")
    return found


def _index(dataset: xr.Dataset, name: str, value: object, bare: bool) -> int:
    """Return the index of the nearest value of the grid."""
    there = dataset[name].values
    if name == "law":
        if value not in there:
            refuse("law", shown(value), f"must be {' or '.join(there)}")
        return int(np.flatnonzero(there == value)[0])
    wanted = read_value(name, value, bare=bare)
    slack = 1e-9 * (there[-1] - there[0])
    if not there[0] - slack <= wanted <= there[-1] + slack:
        refuse(name, shown(value).strip('"'), "is not in the sweep", f"it has {_span(dataset, name)}")
    return int(np.abs(there - wanted).argmin())


def _span(dataset: xr.Dataset, name: str) -> str:
    values = dataset[name].values
    if name not in PARAMETERS:
        return ", ".join(map(str, values))
    return f"{text_of(name, values[0])} to {text_of(name, values[-1])}"
