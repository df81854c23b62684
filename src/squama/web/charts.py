"""Options of the three line plots: torque, inclination and friction force against twist."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from squama.web import live
from squama.web.state import State

DASHES: tuple[Any, ...] = ([8, 4], [3, 3], [10, 3, 2, 3])
"""Lines of the kept designs."""


class Theme(NamedTuple):
    """Colours of plots on a light or a dark page."""

    ink: str
    faint: str
    line: str
    mark: str
    page: str


LIGHT = Theme("#1d2125", "#d9dde1", "#14181c", "#c8323c", "#ffffff")
DARK = Theme("#e8eaed", "#3a4047", "#f4f6f8", "#ff7a80", "#16191d")
ROOM = {"left": 58, "right": 16, "top": 26, "bottom": 36}
"""Pixels around the curves; the mark of the current point lies over them."""
PLOTS = {"torque": "Load", "theta": "Inclination θ", "f": "Friction force f"}


def theme(*, dark: bool) -> Theme:
    """Return the colours of the page."""
    return DARK if dark else LIGHT


def axis(name: str, look: Theme, **more: Any) -> dict[str, Any]:
    """Return a value axis with its name in the middle."""
    return {
        "type": "value",
        "name": name,
        "nameLocation": "middle",
        "nameTextStyle": {"color": look.ink, "fontSize": 11},
        "axisLabel": {"color": look.ink, "fontSize": 10, "hideOverlap": True, "showMaxLabel": False},
        "axisLine": {"show": True, "lineStyle": {"color": look.ink}},
        "splitLine": {"lineStyle": {"color": look.faint}},
        **more,
    }


def line_options(state: State, plot: str, *, dark: bool) -> dict[str, Any]:
    """Return the options of one plot: the curve, the kept ones dashed, the current point."""
    look, words = theme(dark=dark), live.WORDS[state.load]
    same = [(i, one) for i, one in enumerate(state.kept) if one.load == state.load]
    own = live.along(state.setting)
    others = [live.along(one.setting) for _, one in same]
    right, top, factor = _frame(state, plot)
    label = _label(plot, factor, words["load"])
    series: list[dict[str, Any]] = []
    for (i, _), curve in zip(same, others, strict=True):
        dashed = {"color": live.COLOURS[i], "width": 1.8, "type": DASHES[i]}
        series.append(_line(f"{live.NAMES[i]}", curve, plot, factor, dashed))
    if plot == "torque":
        ends = [[0.0, 0.0], [right / 1.03, own.bare * right / 1.03 * factor]]
        grey = {"color": look.ink, "width": 1, "type": [2, 3], "opacity": 0.6}
        series.append(_series("without contact", ends, grey))
    series.append(_line("this design", own, plot, factor, {"color": look.line, "width": 2.2}))
    return {
        "animation": False,
        "aria": {"enabled": True, "label": {"description": f"{label} against {words['axis']}"}},
        "backgroundColor": "transparent",
        "grid": dict(ROOM),
        "title": {"text": label, "left": 4, "top": 2, "textStyle": {"color": look.ink, "fontSize": 12}},
        "tooltip": {"trigger": "axis", "confine": True, "axisPointer": {"type": "line"}},
        "legend": _legend(look, plot, [live.NAMES[i] for i, _ in same]),
        "xAxis": axis(words["axis"], look, nameGap=20, min=0, max=_short(right)),
        "yAxis": axis("", look, max=_short(top * factor), min=0),
        "series": series,
    }


def _legend(look: Theme, plot: str, names: list[str]) -> dict[str, Any]:
    shown = (["without contact"] if plot == "torque" else []) + names
    style = {"color": look.ink, "fontSize": 10}
    return {"data": shown, "right": 8, "top": 2, "itemWidth": 22, "itemHeight": 8, "textStyle": style,
            "itemStyle": {"opacity": 0}}  # fmt: skip


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


def _frame(state: State, plot: str) -> tuple[float, float, float]:
    """Return the ends of the axes (SI, degrees) and the factor to the unit that is shown."""
    every = [live.along(one.setting) for one in (state, *state.kept) if one.load == state.load]
    top = 1.04 * _top(every, plot, _now(state, plot)[1])
    right = 1.03 * max(float(c.load[-1]) for c in every)
    return right or 1.0, top or 1.0, 1.0 if plot == "theta" else live.prefix(top)[0]


def _now(state: State, plot: str) -> tuple[float, float]:
    """Return load and value of the current point."""
    now = live.motion(state.setting).state(state.twist)
    return now.load, {"torque": now.torque, "theta": float(np.degrees(now.theta)), "f": now.f}[plot]


def point(state: State, plot: str) -> tuple[float, float]:
    """Return where the current point lies, from left and top (0 to 1)."""
    right, top, _ = _frame(state, plot)
    load, value = _now(state, plot)
    return load / right, 1 - value / top


def _label(plot: str, factor: float, load: str) -> str:
    if plot == "theta":
        return "Inclination θ (deg)"
    sign = {1e-6: "M", 1e-3: "k", 1.0: "", 1e3: "m", 1e6: "\N{MICRO SIGN}"}[factor]
    return f"{load} ({sign}N m)" if plot == "torque" else f"Friction force f ({sign}N)"


def _line(name: str, curve: live.Along, plot: str, factor: float, style: dict[str, Any]) -> dict[str, Any]:
    values = {"torque": curve.torque, "theta": curve.theta, "f": curve.f}[plot] * (1.0 if plot == "theta" else factor)
    pairs = [[_short(x), _short(y)] for x, y in zip(curve.load.tolist(), values.tolist(), strict=True)]
    return _series(name, pairs, style)


def _series(name: str, pairs: list[list[Any]], style: dict[str, Any]) -> dict[str, Any]:
    colour = {"itemStyle": {"color": style["color"]}}
    return {
        "name": name,
        "type": "line",
        "data": pairs,
        "showSymbol": False,
        "lineStyle": style,
        "clip": True,
        **colour,
    }


def _short(value: float) -> float:
    """Return a number with six digits, for the way to the browser."""
    return float(f"{value:.6g}")
