"""Slices of a sweep: two dimensions, perhaps a panel for each value of a third, the rest held at one value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.model.outcome import CODES
from squama.study.parameters import PARAMETERS, canonical, read_value, text_of
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

MOST_PANELS = 6


class Slice(NamedTuple):
    """A slice: ``data`` over ``y``, ``x`` and ``panels`` (None for one); ``y`` is None for a line."""

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
    at: Mapping[str, Any] | None = None,
    bare: bool = True,
) -> Slice:
    """Choose a slice by names; values that are held are those of the grid that lie nearest.

    Parameters
    ----------
    dataset : xarray.Dataset
        From :func:`squama.sweep` or :func:`squama.open_sweep`.
    x, y, panels : str, optional
        Dimensions; x and y are the last and the first that are left over, panels is ``law`` if there are several.
    at : mapping, optional
        Values of the other dimensions, by name.
    bare : bool
        Whether a number without a unit is SI.

    Returns
    -------
    Slice
        Not read from the store yet.

    Raises
    ------
    InputError
        A name is no dimension of the sweep, a value is not in its range, or a dimension is neither shown nor held.
    """
    dims = [str(dim) for dim in dataset["RED"].dims]
    held = {_dimension(name, dims, "at"): value for name, value in (at or {}).items()}
    named = {"x": x, "y": y, "panels": panels}
    chosen = {role: _dimension(name, dims, role) for role, name in named.items() if name is not None}
    used = [*chosen.values(), *held]
    for name in used:
        if used.count(name) > 1:
            message = f"{name}: is used twice; give each dimension one place among x, y, panels and at"
            raise InputError(message)
    for role in ("x", "y"):
        if chosen.get(role) == "law":
            message = f"{role} = law: has no order; write panels law"
            raise InputError(message)
    if "panels" not in chosen and "law" in dims and "law" not in used:
        chosen["panels"] = "law"
    data = dataset.isel({name: _index(dataset, name, value, bare) for name, value in held.items()})
    rest = [dim for dim in dims if dim not in (*held, *chosen.values())]
    if "x" not in chosen:
        if not rest:
            message = "no dimension is left for x; hold fewer with at"
            raise InputError(message)
        chosen["x"] = rest.pop()
    if "y" not in chosen and rest:
        chosen["y"] = rest.pop(0)
    if rest:
        text = ", ".join(f"{n} ({_span(dataset, n)})" for n in rest)
        message = f"{text}: is neither shown nor held; hold it with at, or show it as x, y or panels"
        raise InputError(message)
    over = chosen.get("panels")
    if over is not None and data.sizes[over] > MOST_PANELS:
        message = f"panels = {over}: has {data.sizes[over]} values, {MOST_PANELS} panels at most; hold it with at"
        raise InputError(message)
    order = [chosen[role] for role in ("panels", "y", "x") if role in chosen]
    return Slice(data.drop_vars("status").transpose(*order), chosen["x"], chosen.get("y"), over)


def thinned(part: Slice, most: int) -> Slice:
    """Return a slice with at most so many values along x and y, read from the store."""
    steps = {dim: slice(None, None, -(-part.data.sizes[dim] // most)) for dim in (part.x, part.y) if dim}
    return part._replace(data=part.data.isel(steps).load())


def worded(data: xr.Dataset) -> xr.Dataset:
    """Return a slice with the ends in words, for files."""
    words = np.array([*(str(end) for end in CODES), "not computed"])
    end = data["end"]
    attrs = {"long_name": end.attrs["long_name"], "units": ""}
    return data.assign(end=(end.dims, words[end.values], attrs))


def values_of(part: Slice, texts: Sequence[Any], *, bare: bool) -> list[float]:
    """Return the values of y that lie nearest to the given ones."""
    assert part.y is not None
    places = dict.fromkeys(_index(part.data, part.y, text, bare) for text in texts)
    return [float(part.data[part.y].values[i]) for i in places]


def _dimension(name: str, dims: Sequence[str], role: str) -> str:
    found = name
    if name not in dims and name != "law":
        found = canonical(name)
    if found not in dims:
        message = f"{role} = {shown(name).strip(chr(34))}: is no dimension of this sweep; it has {', '.join(dims)}"
        raise InputError(message)
    return found


def _index(dataset: xr.Dataset, name: str, value: Any, bare: bool) -> int:
    """Place of the value of the grid that lies nearest."""
    there = dataset[name].values
    if name == "law":
        if value not in there:
            message = f"law = {shown(value)}: must be {' or '.join(there)}"
            raise InputError(message)
        return int(np.flatnonzero(there == value)[0])
    wanted = read_value(name, value, bare=bare)
    slack = 1e-9 * (there[-1] - there[0])
    if not there[0] - slack <= wanted <= there[-1] + slack:
        message = f"{name} = {shown(value).strip(chr(34))}: is not in the sweep; it has {_span(dataset, name)}"
        raise InputError(message)
    return int(np.abs(there - wanted).argmin())


def _span(dataset: xr.Dataset, name: str) -> str:
    values = dataset[name].values
    if name not in PARAMETERS:
        return ", ".join(map(str, values))
    return f"{text_of(name, values[0])} to {text_of(name, values[-1])}"
