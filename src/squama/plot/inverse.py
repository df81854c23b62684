"""Designs for a target with what was asked, and a Pareto front."""

from __future__ import annotations

import itertools
import textwrap
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from squama.beam.beamfile import TABLES
from squama.curves import doors
from squama.loads import LOADS, model
from squama.plot.palette import ACCENT, GREY, INK
from squama.plot.style import COLUMN, PAGE, Look, headline, key, letters, new_figure, shades, styled
from squama.types import Array
from squama.units import for_people

if TYPE_CHECKING:
    import xarray as xr

    from squama.inverse.designing import InverseDesign
    from squama.inverse.target import Target

BARS = 8
"""Dimensions whose tolerances are drawn."""
CURVES = 8
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
def inverse_figure(found: InverseDesign, target: Target) -> Figure:
    """Draw what :func:`squama.inverse_design` has found for a target.

    Left: torque (moment) against the twist over the whole beam, a curve for each design, with what was asked. Right: by
    how much the tolerance of each dimension changes what the first design reaches.
    """
    figure = new_figure(PAGE, 3.2)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    _curves(left, found, target)
    _bars(right, found)
    letters((left, right))
    return figure


def _curves(ax: Axes, found: InverseDesign, target: Target) -> None:
    names = LOADS[target.space.load]
    options, scales = target.options, target.space.beam.scales
    degrees = 180 / np.pi * scales
    lines, handles = [], []
    for i, (d, colour) in enumerate(zip(found.designs[:CURVES], shades(min(len(found), CURVES)), strict=False)):
        curve = doors.respond(
            d.beam, target.space.load, law=options.law, sense=options.sense, margin=options.margin, joint="hinge"
        )
        x, y = curve[names.angle] * degrees, curve[names.torque]
        lines.append((x, y, d, colour))
        handles.append(key(f"design {i + 1}: {d.end}", color=colour))
    asked = [goal for goal in target.goals if goal.want.figure == "torque"]
    pitch = found[0].beam.pitch
    points = np.array([[g.want.at.per_pitch(pitch) * degrees, g.asked] for g in asked if g.want.at]).reshape(-1, 2)
    # curves climb without bound towards a lock: show the part in which the target lies
    least = max((float(np.interp(0.9 * x[-1], x, y)) for x, y, _, _ in lines), default=1.0)
    top = 1.6 * float(points[:, 1].max()) if points.size else least
    factor, unit = (1e3, "N mm") if top < 1 else (1.0, "N m")
    for x, y, d, colour in lines:
        ax.plot(x, factor * y, color=colour)
        if d.end.endswith("lock"):
            ax.axvline(d.rate_end * d.beam.pitch * degrees, color=colour, linewidth=0.7, linestyle=(0, (1, 1.5)))
    if points.size:
        ax.plot(points[:, 0], factor * points[:, 1], linestyle="", marker="o", color=ACCENT, markersize=4, zorder=5)
        handles.append(key("asked", linestyle="", marker="o", color=ACCENT, markersize=4))
    for goal in target.goals:
        if goal.twist is not None:
            at = float(goal.twist.per_pitch(pitch)) * degrees
            ax.axvline(at, color=ACCENT, linewidth=1.0, linestyle=(0, (4, 2)), zorder=0)
            sense = {"=": "", ">=": " at least", "<=": " at most"}[goal.sense]
            handles.append(key(f"asked: {goal.name}{sense}", color=ACCENT, linewidth=1.0, linestyle=(0, (4, 2))))
    ax.set(ylim=(0, factor * top), xlim=(0, None), xlabel=f"{names.verb.capitalize()} of {scales} scales (deg)")
    ax.set_ylabel(f"{names.torque_words.capitalize()} ({unit})")
    ax.legend(handles=handles, loc="upper left", fontsize=6)


def _bars(ax: Axes, found: InverseDesign) -> None:
    goal = found[0].goals[0]
    rows = sorted(goal.effects.items(), key=lambda item: -abs(item[1]))[:BARS]
    rows = [row for row in rows if row[1]][::-1]
    colours = [GREY if value < 0 else INK for _, value in rows]
    ax.barh(range(len(rows)), [abs(value) for _, value in rows], color=colours, height=0.6)
    ax.set_yticks(range(len(rows)), [f"{name}\n{_size(found, name)}" for name, _ in rows], fontsize=6)
    unit = f" ({goal.unit})" if goal.unit else ""
    ax.set_xlabel(f"Change of {goal.name}{unit}, design 1")
    words = [key("grows with it", color=INK, linewidth=4), key("falls with it", color=GREY, linewidth=4)]
    ax.legend(handles=words, loc="lower right")


def _size(found: InverseDesign, name: str) -> str:
    table, _, key = name.partition(".")
    kind = str(TABLES[table][key].dimension if key else "")
    factor, unit = for_people({"length": "m", "angle": "rad", "pressure": "Pa"}.get(kind, ""))
    return f"\N{PLUS-MINUS SIGN}{factor * found.tolerance[name]:.3g} {unit}".rstrip()


@styled
def front_figure(front: xr.Dataset) -> Figure:
    """Draw a Pareto front from :func:`squama.pareto`.

    Two objectives: one panel, coloured by the dimension that changes most along it. More: a panel for each pair,
    coloured by another objective.

    >>> import numpy as np, xarray as xr
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
    for ax, (x, y) in zip(panels, pairs, strict=False):
        others = [name for name in names if name not in (x, y)]
        _panel(figure, ax, front, x, y, others[0] if others else _telling(front))
    if len(pairs) > 1:
        letters(panels[: len(pairs)])
    for ax in panels[len(pairs) :]:
        ax.remove()
    title = f"{front.sizes['design']} beams of which none is better in all: {', '.join(front.attrs['objectives'])}"
    headline(figure, f"{title}; {model(front.attrs)}")
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
    style: Look = {"s": 9, "linewidth": 0, "zorder": 3}
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
    factor, shown = for_people(unit)
    return factor, f"{name} ({shown})" if shown else name
