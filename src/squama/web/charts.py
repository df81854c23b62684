"""Options of the three line plots: torque, inclination and friction force against twist."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from squama.loads import LOADS
from squama.plot.palette import KEPT, THEMES
from squama.units import prefix
from squama.web import live
from squama.web.state import State

Options = dict[str, Any]
"""What a chart is drawn from, for the browser."""
DASHES = ([8, 4], [3, 3], [10, 3, 2, 3])
"""Lines of the kept designs."""
ROOM = {"left": 58, "right": 16, "top": 26, "bottom": 36}
"""Pixels around the curves; the mark of the current point lies over them."""
LEGEND: Options = {"right": 8, "top": 2, "itemWidth": 22, "itemHeight": 8, "itemStyle": {"opacity": 0}}
PLOTS = ("torque", "theta", "f")
"""Variables that are drawn, of a curve and of a state."""


def ground(words: str, room: Mapping[str, int]) -> Options:
    """Return what every plot has: what it shows in words, and the room around it."""
    aria = {"enabled": True, "label": {"description": words}}
    return {"animation": False, "aria": aria, "backgroundColor": "transparent", "grid": dict(room)}


def axis(name: str, look: Mapping[str, str], **more: Any) -> Options:
    """Return a value axis with its name in the middle."""
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


def line_options(state: State, plot: str, *, dark: bool) -> Options:
    """Return the options of one plot: the curve, the kept ones dashed, the current point."""
    look, names = THEMES["dark" if dark else "light"], LOADS[state.load]
    across = f"{names.angle_words.capitalize()} {names.letter} (rad)"
    same = {i: live.along(one.setting) for i, one in enumerate(state.kept) if one.load == state.load}
    own = live.along(state.setting)
    right, top = _frame(state, plot)
    factor, sign = (1.0, "") if plot == "theta" else prefix(top)
    label = {
        "torque": f"{live.torque_label(state.load)} ({sign}N m)",
        "theta": "Inclination θ (deg)",
        "f": f"Friction force f ({sign}N)",
    }[plot]
    series: list[Options] = []
    for i, curve in same.items():
        dashed = {"color": KEPT[i], "width": 1.8, "type": DASHES[i]}
        series.append(_line(live.NAMES[i], curve, plot, factor, dashed))
    if plot == "torque":
        ends = [[0.0, 0.0], [right / 1.03, own.bare * right / 1.03 * factor]]
        grey = {"color": look["ink"], "width": 1, "type": [2, 3], "opacity": 0.6}
        series.append(_series("without contact", ends, grey))
    shown = ["without contact"] * (plot == "torque") + [live.NAMES[i] for i in same]
    series.append(_line("this design", own, plot, factor, {"color": look["curve"], "width": 2.2}))
    return {
        **ground(f"{label} against {across}", ROOM),
        "title": {"text": label, "left": 4, "top": 2, "textStyle": {"color": look["ink"], "fontSize": 12}},
        "tooltip": {"trigger": "axis", "confine": True, "axisPointer": {"type": "line"}},
        "legend": {"data": shown, "textStyle": {"color": look["ink"], "fontSize": 10}, **LEGEND},
        "xAxis": axis(across, look, nameGap=20, min=0, max=_short(right)),
        "yAxis": axis("", look, max=_short(top * factor), min=0),
        "series": series,
    }


def _top(curves: list[live.Along], plot: str, value: float) -> float:
    """Return the upper end of the axis: loads grow without bound towards a lock."""
    if plot == "theta":
        return max(float(np.max(c.theta)) for c in curves)
    if plot == "torque":
        return max([value, *(c.top for c in curves)])
    tops = []
    for c in curves:
        span = c.load[-1] - c.load_e
        inside = c.load <= c.load_e + live.READABLE * span if np.isfinite(span) and c.top < c.torque.max() else c.f > -1
        tops.append(float(c.f[inside].max(initial=0.0)))
    return max([value, *tops])


def _frame(state: State, plot: str) -> tuple[float, float]:
    """Return the ends of the axes (SI, degrees)."""
    every = [live.along(one.setting) for one in (state, *state.kept) if one.load == state.load]
    top = 1.04 * _top(every, plot, _now(state, plot)[1])
    right = 1.03 * max(float(c.load[-1]) for c in every)
    return right or 1.0, top or 1.0


def _now(state: State, plot: str) -> tuple[float, float]:
    """Return load and value of the current point."""
    now = live.motion(state.setting).state(state.twist)
    value: float = getattr(now, plot)
    return now.load, float(np.degrees(value)) if plot == "theta" else value


def point(state: State, plot: str) -> tuple[float, float]:
    """Return where the current point lies, from left and top (0 to 1)."""
    right, top = _frame(state, plot)
    load, value = _now(state, plot)
    return load / right, 1 - value / top


def _line(name: str, curve: live.Along, plot: str, factor: float, style: Options) -> Options:
    values = getattr(curve, plot) * factor
    pairs = [[_short(x), _short(y)] for x, y in zip(curve.load.tolist(), values.tolist(), strict=True)]
    return _series(name, pairs, style)


def _series(name: str, pairs: list[list[float]], style: Options) -> Options:
    look = {"lineStyle": style, "itemStyle": {"color": style["color"]}, "showSymbol": False, "clip": True}
    return {"name": name, "type": "line", "data": pairs, **look}


def _short(value: float) -> float:
    """Return a number with six digits, for the way to the browser."""
    return float(f"{value:.6g}")
