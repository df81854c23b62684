"""Line plots of torque, inclination and friction force against twist: their contents, and options for the browser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama.loads import HELD, LOADS
from squama.people import readable
from squama.plot.palette import KEPT, THEMES
from squama.types import Array
from squama.web import fields, live, tables
from squama.web.state import State
from squama.web.tables import Fitted, Table

Options = dict[str, Any]
"""Options of an ECharts chart."""
DASHES = ([8, 4], [3, 3], [10, 3, 2, 3])
"""Dashes of the kept designs: lengths of strokes and gaps, pixels."""
ROOM = {"left": 58, "right": 16, "top": 26, "bottom": 36}
"""Margins around the curves, pixels; the mark of the current point lies over them."""
PLOTS = ("torque", "theta", "f")
"""Variables of a curve and of a state that are plotted."""
OWN = "this design (endless beam)"
"""Name of the displayed design's line."""
RESIDUAL = "residual"
"""Name of the plot of measured less computed torque."""
FARTHEST = 3.0
"""Largest factor by which other curves may extend an axis beyond the range of the displayed design."""
FLAT = 4.0
"""Least span of the axis of the inclination, deg."""


class Line(NamedTuple):
    """A curve in a plot, or measured ``points``: x in rad, y in SI or deg; dashes in pixels, none for a solid line."""

    name: str
    x: Array
    y: Array
    colour: str
    width: float
    dashes: Sequence[int] = ()
    points: bool = False


class Frame(NamedTuple):
    """Ends of a plot's axes: the load angle from 0 to ``right`` (rad per pitch), values from ``low`` to ``top``."""

    right: float
    low: float
    top: float


def ground(words: str, room: Mapping[str, int]) -> Options:
    """Return the options common to all plots: description and margins."""
    aria = {"enabled": True, "label": {"description": words}}
    return {"animation": False, "aria": aria, "backgroundColor": "transparent", "grid": dict(room)}


def axis(name: str, look: Mapping[str, str], **more: object) -> Options:
    """Return the options of a value axis with its name in the middle."""
    return {
        "type": "value",
        "name": name,
        "nameLocation": "middle",
        "nameTextStyle": {"color": look["ink"], "fontSize": 11},
        "axisLabel": {"color": look["ink"], "fontSize": 10, "hideOverlap": True, "showMaxLabel": False},
        "axisLine": {"show": True, "lineStyle": {"color": look["ink"]}},
        "splitLine": {"lineStyle": {"color": look["faint"]}},
        **more,
    }


def lines(state: State, plot: str, *, dark: bool, table: Table | None = None, fit: Fitted | None = None) -> list[Line]:
    """Return the lines of a plot, the displayed design last.

    ``fit``: the fit to the table; its loop is drawn while its beam is displayed.
    """
    look, found = THEMES["dark" if dark else "light"], []

    def drawn(name: str, curve: live.Along, colour: str, width: float, dashes: Sequence[int] = ()) -> None:
        found.append(Line(name, curve.load, getattr(curve, plot), colour, width, dashes))

    if plot == RESIDUAL:
        left = tables.residual(table, state, fit) if table else None
        return [Line(table.name, left.load, left.torque, look["normal"], 0, points=True)] if table and left else []
    for i, one in enumerate(state.kept):
        if one.load == state.load:
            for curve in filter(None, (live.along(one.setting), live.back(one))):
                drawn(live.NAMES[i], curve, KEPT[i], 1.8, DASHES[i])
    own, back, other = live.along(state.setting), live.back(state), live.beside(state)
    if plot == "torque":
        ends = np.array([0.0, frame(state, plot, table).right / 1.03])
        found.append(Line("without contact", ends, own.bare * ends, look["ink"], 1, (2, 3)))
    if other and state.beside:
        drawn(f"on {HELD[state.beside.joint]}", other, look["soft"], 1)
    if back:
        drawn("unloading", back, look["accent"], 2)
    if plot == "torque" and table:
        found.append(Line(table.name, *tables.shown(table, state), look["normal"], 0, points=True))
        if fit and fit.beam == state.beam and table.load == state.load:
            load, torque, _ = tables.looped(fit, state)
            found.append(Line(f"fitted loop ({fit.specimen.removeprefix('an ')})", load, torque, look["mark"], 1.6))
    drawn(OWN, own, look["curve"], 2.2)
    return found


def frame(state: State, plot: str, table: Table | None = None, fit: Fitted | None = None) -> Frame:
    """Return the ends of a plot's axes: the readable range of the displayed design and of the curves with it.

    With a measured table they follow its points. The other model does not count, nor does a kept design that locks
    where the displayed one does not.
    """
    own, back = live.along(state.setting), live.back(state)
    kept = [live.along(one.setting) for one in state.kept if one.load == state.load]
    load, value = tables.shown(table, state) if table else (np.empty(0), np.empty(0))
    farthest = max([float(own.load[-1]), *(float(c.load[-1]) for c in kept)])
    right = 1.03 * (float(load.max(initial=0.0)) or farthest) or 1.0
    if plot == RESIDUAL:
        left = tables.residual(table, state, fit) if table else None
        most = float(np.abs(left.torque).max(initial=0.0)) if left else 0.0
        return Frame(right, -1.1 * most or -1.0, 1.1 * most or 1.0)
    if plot == "torque" and value.size:
        low, top = float(value.min()), float(value.max())
        room = 0.04 * (top - min(low, 0.0)) or 1.0
        return Frame(right, min(low, 0.0) - room * (low < 0), top + room)
    low, top = own.span(plot)
    if back:
        # unloading may lie below loading; near a lock only its readable part counts
        low = max(min(low, back.span(plot)[0]), -top)
    if plot == "torque":
        top = max(top, own.bare * right / 1.03)
    far = FARTHEST * top
    for c in kept:
        if own.locks or not c.locks:
            low, top = min(low, c.span(plot)[0]), max(top, min(c.span(plot)[1], far if c.locks else np.inf))
    if plot == "theta":
        more = max(0.05 * (top - low), (FLAT - (top - low)) / 2)
        return Frame(right, max(0.0, low - more), top + more)
    return Frame(right, 1.04 * min(low, 0.0), 1.04 * top or 1.0)


class Axis(NamedTuple):
    """An axis: its words, its unit, and the factor from SI (inclination: deg) to the unit."""

    words: str
    unit: str
    factor: float

    @property
    def label(self) -> str:
        """Words with the unit."""
        return f"{self.words} ({self.unit})"


def axes(state: State, plot: str, ends: Frame) -> tuple[Axis, Axis]:
    """Return the horizontal and the vertical axis of a plot."""
    words, unit = {
        "torque": (live.torque_label(state.load), "N m"),
        "theta": ("Inclination θ", "deg"),
        "f": ("Friction force f", "N"),
        RESIDUAL: (f"{LOADS[state.load].torque}, measured − computed", "N m"),
    }[plot]
    factor, unit = (1.0, unit) if plot == "theta" else readable(unit, ends.top)
    # kept designs may have other numbers of scales
    turn = fields.of("twist", state.beam, *(one.beam for one in state.kept), load=state.load)
    across = Axis(f"{turn.label} {turn.symbol}", turn.unit, turn.turn)
    return across, Axis(words, unit, factor)


def line_options(
    state: State, plot: str, *, dark: bool, table: Table | None = None, fit: Fitted | None = None
) -> Options:
    """Return the ECharts options of a plot."""
    look, ends = THEMES["dark" if dark else "light"], frame(state, plot, table, fit)
    across, up = axes(state, plot, ends)
    drawn = lines(state, plot, dark=dark, table=table, fit=fit)
    up_axis = axis("", look, max=_short(ends.top * up.factor), min=_short(ends.low * up.factor))
    # the lower end of the axis may be no round number
    up_axis["axisLabel"]["showMinLabel"] = not ends.low
    # the horizontal axis stays at the lower border where values are negative
    below = {"show": True, "onZero": False, "lineStyle": {"color": look["ink"]}}
    return {
        **ground(f"{up.label} against {across.label}", ROOM),
        "title": {"text": up.label, "left": 4, "top": 2, "textStyle": {"color": look["ink"], "fontSize": 12}},
        "tooltip": {"trigger": "axis", "confine": True, "axisPointer": {"type": "line"}},
        # units of the tooltip (chart.js)
        "words": {"units": [across.unit, up.unit]},
        "xAxis": axis(across.label, look, nameGap=20, min=0, max=_short(ends.right * across.factor), axisLine=below),
        "yAxis": up_axis,
        "series": [_series(line, across.factor, up.factor) for line in drawn],
    }


class Point(NamedTuple):
    """Position of the current point from left and top (0 to 1), with an ``arrow`` at a border if it lies beyond."""

    left: float
    top: float
    arrow: str = ""


UP, RIGHT = "\N{UPWARDS ARROW}", "\N{RIGHTWARDS ARROW}"
"""Arrows to a point above the axis, or beyond the twist of the last measured point."""


def point(state: State, plot: str, table: Table | None = None) -> Point:
    """Return the position of the current point in a plot."""
    ends, now = frame(state, plot, table), live.motion(state.setting).state(state.twist)
    value = float(np.degrees(now.theta)) if plot == "theta" else getattr(now, plot)
    up = (value - ends.low) / (ends.top - ends.low)
    left, top = min(now.load / ends.right, 1.0), 1 - min(max(up, 0.0), 1.0)
    return Point(left, top, RIGHT if now.load > ends.right else "" if top else UP)


def _series(line: Line, across: float, up: float) -> Options:
    pairs = [[_short(across * x), _short(up * y)] for x, y in zip(line.x.tolist(), line.y.tolist(), strict=True)]
    look = {"itemStyle": {"color": line.colour}, "clip": True, "silent": True}
    if line.points:
        return {"name": line.name, "type": "scatter", "data": pairs, "symbolSize": 4, **look}
    style = {"color": line.colour, "width": line.width, "type": list(line.dashes) or "solid"}
    return {"name": line.name, "type": "line", "data": pairs, "lineStyle": style, "showSymbol": False, **look}


def _short(value: float) -> float:
    """Return a number with six digits, for transmission to the browser."""
    return float(f"{value:.6g}")
