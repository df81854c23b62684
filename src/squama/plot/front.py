"""A Pareto front: every pair of objectives, coloured by a third."""

from __future__ import annotations

import itertools
import textwrap
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from squama.model.solve import Array
from squama.plot.style import COLUMN, PAGE, letter, new_figure, styled

if TYPE_CHECKING:
    import xarray as xr

SYMBOL = {
    "tangent": r"Tangent stiffness (N m$^2$)",
    "torque": "Torque (N m)",
    "stiffness": r"Stiffness before engagement (N m$^2$)",
    "range": "Twist from engagement to lock (rad per pitch)",
    "lock": "Twist at the lock (rad per pitch)",
    "engagement": "Twist at engagement (rad per pitch)",
    "W_fr": "Frictional work (J/m)",
    "RED": "Relative energy dissipation RED",
    "critical_mu": "Friction that locks at engagement",
}
"""Labels of the objectives."""
LINE = 30
"""Letters in a line of an axis label; the panels are narrow."""
DECADES = 30.0
"""An objective that spans more than this factor has a logarithmic axis."""


@styled
def front_figure(front: xr.Dataset) -> Figure:
    """Draw a Pareto front.

    Parameters
    ----------
    front : xarray.Dataset
        From :func:`squama.pareto`.

    Returns
    -------
    matplotlib.figure.Figure
        Two objectives: one panel, coloured by the dimension that changes most along it. More: a panel for each pair,
        coloured by another objective.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> from squama.plot import front_figure
    >>> about = {"objective": "max", "units": "1", "long_name": ""}
    >>> data = {name: ("design", np.arange(3.0), about) for name in ("range", "RED", "lock")}
    >>> front = xr.Dataset(data, attrs={"load": "twisting", "law": "edge", "objectives": []})
    >>> len([ax for ax in front_figure(front).axes if ax.get_xlabel()])
    6
    """
    names = [str(name) for name, v in front.data_vars.items() if "objective" in v.attrs]
    pairs = list(itertools.combinations(names, 2))
    columns = min(len(pairs), 3)
    rows = -(-len(pairs) // columns)
    figure = new_figure(COLUMN + 0.6 if len(pairs) == 1 else PAGE, 2.8 * rows + 0.2)
    panels = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for i, (ax, (x, y)) in enumerate(zip(panels, pairs, strict=False)):
        others = [name for name in names if name not in (x, y)]
        _panel(figure, ax, front, x, y, others[0] if others else _telling(front))
        if len(pairs) > 1:
            letter(ax, f"({chr(97 + i)})")
    for ax in panels[len(pairs) :]:
        ax.remove()
    title = f"{front.sizes['design']} beams of which none is better in all: {', '.join(front.attrs['objectives'])}"
    figure.suptitle(title, fontsize=8, x=0.01, ha="left")
    return figure


def _telling(front: xr.Dataset) -> str | None:
    """Return the varied dimension that uses most of its bounds along the front."""
    spans = {
        str(name): float(np.ptp(v.values) / (v.attrs["high"] - v.attrs["low"]))
        for name, v in front.data_vars.items()
        if "low" in v.attrs
    }
    return max(spans, key=lambda name: spans[name]) if spans else None


def _wide(values: Array) -> bool:
    return bool(values.min() > 0 and values.max() > DECADES * values.min())


def _panel(figure: Figure, ax: Axes, front: xr.Dataset, x: str, y: str, by: str | None) -> None:
    style: dict[str, Any] = {"s": 9, "linewidth": 0, "zorder": 3}
    if by is not None:
        factor, text = _scale(front, by)
        shade = front[by].values * factor
        norm = (LogNorm if _wide(shade) else Normalize)(shade.min(), shade.max())
        style |= {"c": shade, "norm": norm, "cmap": mpl.colormaps["viridis"]}
    drawn = ax.scatter(front[x].values, front[y].values, **style)
    for name, axis in ((x, "x"), (y, "y")):
        if _wide(front[name].values):
            getattr(ax, f"set_{axis}scale")("log")
        word = "larger" if front[name].attrs["objective"] == "max" else "smaller"
        at = f" at {front[name].attrs['at']}" if "at" in front[name].attrs else ""
        end = f"\n{word} is better" if axis == "x" else ""
        getattr(ax, f"set_{axis}label")(textwrap.fill(f"{SYMBOL.get(name, name)}{at}", LINE) + end)
    ax.grid(color="0.9", linewidth=0.5)
    if by is not None:
        bar = figure.colorbar(drawn, ax=ax, location="top", aspect=30, pad=0.02)
        bar.set_label(text, fontsize=7)
        bar.ax.tick_params(labelsize=6)


def _scale(front: xr.Dataset, name: str) -> tuple[float, str]:
    """Return factor and label of what the colour shows."""
    unit = front[name].attrs["units"]
    if "objective" in front[name].attrs:
        return 1.0, SYMBOL.get(name, name)
    factor, shown = {"m": (1e3, "mm"), "rad": (180 / np.pi, "deg"), "Pa": (1e-6, "MPa")}.get(unit, (1.0, unit))
    return factor, f"{name} ({shown})" if shown not in ("", "1") else name
