"""One variable of a result, drawn into axes of the user's own picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from squama.errors import refuse
from squama.loads import LOADS
from squama.plot.style import label, panel
from squama.symbols import SYMBOLS
from squama.units import look_up, shown

ACROSS = ("t", "Phi", "kappa", "phi", "psi")
"""What a variable is drawn over if nothing is named: the first that a result has for every point."""


def line(
    dataset: xr.Dataset,
    name: str,
    ax: Axes | None = None,
    *,
    x: str | None = None,
    unit: str | None = None,
    x_unit: str | None = None,
    **look: Any,
) -> Axes:
    """Draw a variable of a curve, one line for each coefficient of friction or scale, and return the axes.

    Parameters
    ----------
    dataset
        What :func:`squama.twist`, ``bend``, ``bend_twist``, ``cycle``, ``row`` or ``vibrate`` returned.
    name, x
        Variables along ``point``: what is drawn, and over what (time, or the rate of the load).
    ax
        Where; axes of a new figure if not given. Labels that it has are kept.
    unit, x_unit
        Other units than those of SI, such as "N mm", "deg".
    look
        As for ``Axes.plot``.

    Raises
    ------
    InputError
        There is no such variable along ``point``, or it has no such unit.

    Examples
    --------
    >>> import squama
    >>> r = squama.twist(squama.Beam.from_ratios(), mu=[0.2, 0.5], joint="hinge", points=50)
    >>> ax = squama.plot.line(r, "T", unit="kN m")
    >>> ax.get_ylabel(), len(ax.lines)
    ('Torque $T$ (kN m)', 2)
    """
    there = along(dataset, name)
    load = dataset.attrs.get("load")
    first = (LOADS[load].rate,) if load in LOADS and LOADS[load].rate in there and "t" not in there else ()
    over = x or next((key for key in (*first, *ACROSS) if key in there), "")
    along(dataset, over, "x")
    ax, _ = panel(ax, dataset, name, "")
    factor, y_words = _unit(dataset, name, unit)
    x_factor, x_words = _unit(dataset, over, x_unit)
    drawn, across = dataset[name].transpose(..., "point"), dataset[over].transpose(..., "point")
    others = drawn.dims[:-1]
    for index in np.ndindex(drawn.shape[:-1]):
        one = dict(zip(others, index, strict=True))
        words = ", ".join(f"{dim} = {dataset[dim].values[i]:g}" for dim, i in one.items())
        place = across.isel({dim: i for dim, i in one.items() if dim in across.dims})
        ax.plot(x_factor * place, factor * drawn.isel(one), **{**({"label": words} if words else {}), **look})
    ax.set_ylabel(ax.get_ylabel() or y_words)
    ax.set_xlabel(ax.get_xlabel() or x_words)
    return ax


def along(dataset: xr.Dataset, name: str, where: str = "name") -> list[str]:
    """Return the numbers along the points of a result; another name is refused."""
    there = [str(key) for key, v in dataset.variables.items() if "point" in v.dims and v.dtype.kind in "fi"]
    if name not in there:
        refuse(where, shown(name), "is no number along the points of this result", f"allowed: {', '.join(there)}")
    return there


def _unit(dataset: xr.Dataset, name: str, unit: str | None) -> tuple[float, str]:
    """Return the factor to a unit, and the label of the axis."""
    attrs = dataset[name].attrs
    own = attrs.get("units", "1")
    factor = 1.0
    if unit is not None:
        there, wanted = look_up(own), look_up(unit)
        if there is None or wanted is None or there[0] is not wanted[0]:
            refuse("unit", shown(unit), f"is no unit of {name}, which is in {own}", "leave it out")
        factor = wanted[2] / wanted[1]
    if name in SYMBOLS:
        return factor, label(name, unit)
    words = str(attrs.get("long_name", name))
    return factor, f"{words[0].upper()}{words[1:]}" + ("" if own == "1" else f" ({unit or own})")
