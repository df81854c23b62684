"""Designs for a target with its goals, and a Pareto front."""

from __future__ import annotations

import itertools
import textwrap
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from squama.curves import doors
from squama.errors import refuse
from squama.loads import ENDLESS, LOADS, model
from squama.model.outcome import End
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK
from squama.study.parameters import people
from squama.types import Array
from squama.units import for_people, shown, torque_unit

if TYPE_CHECKING:
    import xarray as xr

    from squama.inverse.designing import InverseDesign
    from squama.inverse.target import Target

MOST = 8
"""Largest number of curves, and of dimensions with tolerances."""
SYMBOL = {
    "tangent": r"Tangent stiffness (N m$^2$)",
    "stiffness_ratio": "Stiffness over that without contact",
    "stress": "Largest stress in a scale (MPa)",
    "strength_share": "Largest stress in a scale over its strength",
    "length": "Length of the beam (mm)",
    "torque": "Torque (N m)",
    "stiffness": r"Stiffness before engagement (N m$^2$)",
    "range": "Twist from engagement to lock (deg per pitch)",
    "lock": "Twist at the lock (deg per pitch)",
    "engagement": "Twist at engagement (deg per pitch)",
    "W_fr": "Frictional work (J/m)",
    "RED": "Relative energy dissipation RED",
    "critical_mu": "Friction that locks at engagement",
}
"""Axis labels of the objectives, in the units of :func:`squama.units.for_people`."""
_LOCK: style.Look = {"linewidth": 0.9, "linestyle": (0, (1, 1.5))}
_GOAL: style.Look = {"linewidth": 1.0, "zorder": 0}
_DASHES: tuple[style.Dash, ...] = (style.DASHED, (0, (1, 1.2)), (0, (5, 1.5, 1, 1.5)), (0, (8, 2)))
"""Line styles of the goals, in their order."""


@style.styled
def inverse_figure(found: InverseDesign, target: Target) -> Figure:
    """Draw the designs of :func:`squama.inverse_design` for a target.

    Left: torque (moment) against the twist over the whole beam, a curve for each design, with the goals. Right: change
    of a goal's figure by the tolerance of each dimension, for the first design (a missed goal first).
    """
    figure = style.new_figure(style.PAGE, 3.8)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    which = _curves(left, found, target)
    _bars(right, found)
    count = "one design" if len(found) == 1 else f"{len(found)} designs"
    return style.headline(figure, f"{target.space.load.capitalize()}, {count} for the target: {which}", (left, right))


def _curves(ax: Axes, found: InverseDesign, target: Target) -> str:
    """Draw the curves of endless beams with the goals; return the model of the curves in words."""
    kind, options, first = LOADS[target.space.load], target.options, found[0].beam
    # twists of whole beams, whose numbers of scales may differ
    degrees, own = 180 / np.pi * first.pitches, (first.pitch, first.pitches)
    how: style.Look = {name: getattr(options, name) for name in ("law", "sense", "margin", "joint")} | {"ends": ENDLESS}
    lines, handles, which = [], [], ""
    ats = [at for goal in target.goals for at in (goal.want.at, goal.twist) if at is not None]
    for i, (d, colour) in enumerate(zip(found.designs[:MOST], style.shades(min(len(found), MOST)), strict=False)):
        # curves on hinges are drawn to their ends, those of thick scales a little beyond the target
        most = 1.1 * max((float(at.per_pitch(d.beam.pitch, d.beam.pitches)) for at in ats), default=0.0)
        to = f"{most!r} rad/pitch" if target.compliant and most else None
        curve = doors.respond(d.beam, kind.name, to=to, **how)
        which = f"{model(curve.attrs)}; {ENDLESS} beams"
        lines.append((curve[kind.angle] * np.degrees(d.beam.pitches), curve[kind.torque], d, colour))
        end = "" if target.compliant and d.end == End.RANGE else f": {d.end}"
        handles.append(style.key(f"design {i + 1}{end}", color=colour))
    # a bound "at most" may lie far above the curves: it is in the legend only
    at = {i: float(goal.want.at.per_pitch(*own)) * degrees for i, goal in enumerate(target.goals) if goal.want.at}
    drawn = [i for i, goal in enumerate(target.goals) if goal.want.figure == "torque" and goal.sense == "="]
    points = np.array([[at[i], target.goals[i].asked] for i in drawn if i in at]).reshape(-1, 2)
    # curves rise without bound towards a lock: the axis follows the target
    part, room = (1.0, 1.1) if target.compliant else (0.9, 1.0)
    least = room * max((float(np.interp(part * x[-1], x, y)) for x, y, _, _ in lines), default=1.0)
    top = 1.6 * float(points[:, 1].max()) if points.size else least
    factor, unit = torque_unit(top)
    for x, y, d, colour in lines:
        ax.plot(x, factor * y, color=colour)
        if d.end.endswith("lock"):
            ax.axvline(np.degrees(d.rate_end * d.beam.length), color=colour, **_LOCK)
    if any(d.end.endswith("lock") for *_, d, _ in lines):
        handles.append(style.key("lock of a design", **_LOCK))
    if points.size:
        mark: style.Look = {"linestyle": "", "marker": "o", "color": ACCENT, "markersize": 4}
        ax.plot(points[:, 0], factor * points[:, 1], zorder=5, **mark)
        handles.append(style.key("asked", **mark))
    asked: dict[tuple[float, str], list[str]] = {}
    for i, goal in enumerate(target.goals):
        sense = {"=": "", ">=": " at least", "<=": " at most"}[goal.sense]
        place = at.get(i) if i not in drawn else None
        colour = GREY
        if goal.twist is not None:
            place, colour = float(goal.twist.per_pitch(*own)) * degrees, ACCENT
        if place is not None:
            asked.setdefault((place, colour), []).append(f"asked: {goal.name}{sense} {goal.number:g} {goal.unit}")
    for ((place, colour), words), dashes in zip(asked.items(), itertools.cycle(_DASHES)):
        look: style.Look = {"color": colour, "linestyle": dashes, **_GOAL}
        ax.axvline(place, **look)
        handles.append(style.key("\n".join(words), **look))
    scales = f"{first.pitches} scales" if len({d.beam.pitches for d in found.designs}) == 1 else "the beam"
    ax.set(ylim=(0, factor * top), xlim=(0, None), xlabel=f"{kind.verb.capitalize()} of {scales} (deg)")
    ax.set_ylabel(f"{kind.torque_words.capitalize()} ({unit})")
    style.legend_under(ax, handles)
    return which


def _bars(ax: Axes, found: InverseDesign) -> None:
    # a missed goal first
    goal = min(found[0].goals, key=lambda goal: goal.met)
    rows = sorted(goal.effects.items(), key=lambda item: -abs(item[1]))[:MOST]
    rows = [row for row in rows if row[1]][::-1]
    colours = [GREY if value < 0 else INK for _, value in rows]
    ax.barh(range(len(rows)), [abs(value) for _, value in rows], color=colours, height=0.6)
    sizes = [people(name)[0] * found.tolerance[name] for name, _ in rows]
    words = [f"\N{PLUS-MINUS SIGN}{v:.3g} {people(name)[1]}".rstrip() for v, (name, _) in zip(sizes, rows, strict=True)]
    ax.tick_params(axis="y", length=0)
    ax.set_yticks(range(len(rows)), [f"{name}\n{w}" for (name, _), w in zip(rows, words, strict=True)], fontsize=6)
    unit = f" ({goal.unit})" if goal.unit else ""
    missed = "" if goal.met else ", missed"
    ax.set_xlabel(textwrap.fill(f"Change of {goal.name}{unit} by a tolerance, design 1{missed}", 40))
    keys = [style.key("grows with it", color=INK, linewidth=4), style.key("falls with it", color=GREY, linewidth=4)]
    style.legend_under(ax, keys)


@style.styled
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
    names = _objectives(front)
    pairs = list(itertools.combinations(names, 2))
    columns = min(len(pairs), 3)
    rows = -(-len(pairs) // columns)
    figure = style.new_figure(style.COLUMN + 0.6 if len(pairs) == 1 else style.PAGE, 2.8 * rows + 0.2)
    panels = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for ax, (x, y) in zip(panels, pairs, strict=False):
        tradeoff(front, x, y, ax)
    for ax in panels[len(pairs) :]:
        ax.remove()
    title = f"Pareto front of {front.sizes['design']} beams: {model(front.attrs)}"
    return style.headline(figure, title, panels[: len(pairs)] if len(pairs) > 1 else ())


def _objectives(front: xr.Dataset) -> list[str]:
    return [str(name) for name, v in front.data_vars.items() if "objective" in v.attrs]


def _wide(values: Array) -> bool:
    """Return whether values span more than a factor of 30, so that their axis is logarithmic."""
    return bool(values.min() > 0 and values.max() > 30 * values.min())


def tradeoff(front: xr.Dataset, x: str, y: str, ax: Axes | None = None, *, by: str | None = None) -> Axes:
    """Draw two objectives of a Pareto front from :func:`squama.pareto` against each other, with a colour bar.

    The colour shows ``by``, an objective or a dimension; default: another objective, else the dimension that changes
    most along the front.
    """
    ax, _ = style.panel(ax, front, "design", "squama.pareto")
    names = _objectives(front)
    for where, name, known in (("x", x, names), ("y", y, names), ("by", by or x, [*map(str, front.data_vars)])):
        if name not in known:
            refuse(where, shown(name), "is not a figure of this front", f"allowed: {', '.join(known)}")
    by = by or next((name for name in names if name not in (x, y)), None)
    if by is None:
        # the varied dimension that uses most of its bounds along the front
        varied = {str(name): v for name, v in front.data_vars.items() if "low" in v.attrs}
        spans = {name: np.ptp(v.values) / (v.attrs["high"] - v.attrs["low"]) for name, v in varied.items()}
        by = max(spans, key=lambda name: float(spans[name]), default=None)
    dots: style.Look = {"s": 9, "linewidth": 0, "zorder": 3}
    if by is not None:
        (factor, unit), text = for_people(front[by].attrs["units"]), SYMBOL.get(by, by)
        if "objective" not in front[by].attrs:
            text = f"{by} ({unit})" if unit else by
        shade = front[by].values * factor
        norm = (LogNorm if _wide(shade) else Normalize)(shade.min(), shade.max())
        dots |= {"c": shade, "norm": norm, "cmap": mpl.colormaps["viridis"]}
    places = (front[name].values * for_people(front[name].attrs["units"])[0] for name in (x, y))
    drawn = ax.scatter(*places, **dots)
    for name, axis in ((x, "x"), (y, "y")):
        if _wide(front[name].values):
            getattr(ax, f"set_{axis}scale")("log")
        word = "larger" if front[name].attrs["objective"] == "max" else "smaller"
        at = f" at {front[name].attrs['at']}" if "at" in front[name].attrs else ""
        end = f"\n{word} is better" if axis == "x" else ""
        getattr(ax, f"set_{axis}label")(textwrap.fill(f"{SYMBOL.get(name, name)}{at}", 30) + end)
    ax.grid(color="0.9", linewidth=0.5)
    if by is not None:
        bar = ax.figure.colorbar(drawn, ax=ax, location="top", aspect=30, pad=0.02)
        bar.set_label(text, fontsize=7)
        bar.ax.tick_params(labelsize=6)
    return ax
