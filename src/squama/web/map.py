"""The regime map: how designs end over two of their parameters, with the design that is shown."""

from __future__ import annotations

import functools
import math
import threading
from typing import Any, NamedTuple

import numpy as np

from squama.batch import solve
from squama.beam import joint_law
from squama.beam.matrixfile import StoredMatrix
from squama.errors import refuse
from squama.loads import LOADS
from squama.model.outcome import CODES, End
from squama.plot.palette import ENDS, KEPT, THEMES
from squama.types import Array
from squama.web import charts, live
from squama.web.fields import FIELDS
from squama.web.state import State

AXES = ("mu", "alpha", "eta", "theta0", "beta", "lam")
"""Fields that can be an axis."""
BENDING_AXES = ("mu", "eta", "theta0")
SIZE = (37, 29)
"""Designs along the axes."""
RANGES = {"eta": (1.0, 8.0), "theta0": (2.0, 40.0), "alpha": (2.0, 80.0), "mu": (0.0, 2.0)}
"""Ranges of axes that differ from those of the sliders, in shown units."""
ROOM = {"left": 58, "right": 16, "top": 8, "bottom": 36}
"""Pixels around the cells; the marks lie over the cells."""


class Key(NamedTuple):
    """What a map depends on: its axes, the values of the other fields (SI), loading, law, sense, margin."""

    x: str
    y: str
    fixed: tuple[tuple[str, float | None], ...]
    load: str
    law: str
    sense: str
    margin: float
    matrix: StoredMatrix | None = None


class Grid(NamedTuple):
    """Values along the axes (shown units), and by y and x: codes of the ends, load angles, RED."""

    x: Array
    y: Array
    code: Array
    load_e: Array
    load_end: Array
    RED: Array


_STIFF = ("embedded", "thickness", "pitch", "bar_width", "modulus", "poisson", "stiffness", "inclusion")
"""Fields on which only the share of the bar in the energy depends."""


def axes(load: str) -> tuple[str, ...]:
    """Return the fields that can be an axis under a kind of loading."""
    return AXES if LOADS[load].sided else BENDING_AXES


def key(state: State, x: str, y: str) -> Key:
    """Return what the map of a state depends on; values of its own axes are left out."""
    fixed = tuple((name, state.value(name)) for name in (*AXES, *_STIFF) if name not in (x, y))
    return Key(x, y, fixed, state.load, state.law, state.sense, state.margin, state.beam.joint.matrix)


@functools.lru_cache(maxsize=8)
def grid(wanted: Key) -> Grid:
    """Solve the designs of a map."""
    along = [np.linspace(*_range(name), n) for name, n in zip((wanted.x, wanted.y), SIZE, strict=True)]
    values: dict[str, Any] = dict(wanted.fixed)
    values[wanted.x] = along[0][None, :] * FIELDS[wanted.x].factor
    values[wanted.y] = along[1][:, None] * FIELDS[wanted.y].factor
    done = solve(
        **{name: values[name] for name in AXES},
        stiffness_ratio=_ratio(values, wanted.load, wanted.matrix),
        law=wanted.law,
        sense=wanted.sense,
        margin=wanted.margin,
        load=wanted.load,
    )
    shape = (SIZE[1], SIZE[0])
    parts = [np.broadcast_to(v, shape) for v in (done.code, done.load_e, done.load_end, done.RED)]
    return Grid(along[0], along[1], *parts)


def warm_up() -> threading.Thread:
    """Solve a design of each kind on a thread of its own, so that the first map need not wait for the compiler."""

    def tiny() -> None:
        for load in LOADS:
            solve(eta=3.0, beta=1.25, lam=0.45, alpha=0.8, theta0=0.2, mu=0.5, stiffness_ratio=1.0, load=load)

    thread = threading.Thread(target=tiny, name="warm-up", daemon=True)
    thread.start()
    return thread


def _ratio(v: dict[str, Any], load: str, matrix: StoredMatrix | None) -> Any:
    """Return the rigidity of the beam without contact over K d, as a beam has them."""
    d, beta, lam = (np.asarray(v[name]) for name in ("pitch", "beta", "lam"))
    sizes = joint_law.Sizes(
        v["modulus"],
        v["poisson"],
        v["bar_width"],
        2 * lam * d,
        d,
        beta * d,
        v["thickness"],
        v["embedded"],
        beta,
        lam,
        v["embedded"] / d,
    )
    given = joint_law.Given(v["stiffness"], v["inclusion"], matrix)
    rigidity = joint_law.rigidity(load, sizes, given, joint_law.whole)
    soft = np.asarray(joint_law.stiffness(load, sizes, given, joint_law.whole) * d)
    # a tab of no length has no stiffness: then the bar has all the energy, and there is no share to tell
    return np.divide(rigidity, soft, out=np.zeros(np.shape(rigidity * soft)), where=soft > 0)


def _range(name: str) -> tuple[float, float]:
    return RANGES.get(name, (FIELDS[name].low, FIELDS[name].high))


def take(state: State, x: str, y: str, cell: tuple[int, int]) -> State:
    """Return the state with the design of a cell of the map.

    Raises InputError: the beam cannot be so; the message names what is in the way.
    """
    at = (np.linspace(*_range(x), SIZE[0])[cell[0]], np.linspace(*_range(y), SIZE[1])[cell[1]])
    for name, value in zip((x, y), at, strict=True):
        state = state.change(name, f"{value:.6g}")
    return state


def options(wanted: Key, found: Grid, *, dark: bool) -> charts.Options:
    """Return the options of the map."""
    look = THEMES["dark" if dark else "light"]
    labels = [_label(name) for name in (wanted.x, wanted.y)]
    spans = [_range(wanted.x), _range(wanted.y)]
    steps = [(high - low) / (n - 1) for (low, high), n in zip(spans, SIZE, strict=True)]
    values = [
        charts.axis(label, look, nameGap=gap, min=low - step / 2, max=high + step / 2, splitLine={"show": False})
        for label, gap, (low, high), step in zip(labels, (20, 30), spans, steps, strict=True)
    ]
    for one in values:
        one["axisLabel"] |= {"showMinLabel": False, "showMaxLabel": False}
    names = [{"type": "category", "show": False, "data": list(range(n))} for n in SIZE]
    codes = [CODES.index(end) for end in ends(found)]
    pieces = [{"value": c, "color": ENDS[CODES[c]]} for c in codes]
    return {
        "animation": False,
        "aria": {"enabled": True, "label": {"description": f"Map of ends over {labels[0]} and {labels[1]}"}},
        "backgroundColor": "transparent",
        "grid": dict(ROOM),
        "tooltip": {"trigger": "item", "confine": True, ":formatter": _tooltip(wanted, wanted.load)},
        "xAxis": [names[0], {**values[0], "position": "bottom"}],
        "yAxis": [names[1], {**values[1], "position": "left"}],
        "visualMap": {"type": "piecewise", "pieces": pieces, "dimension": 2, "seriesIndex": 0, "show": False},
        "series": [
            {"type": "heatmap", "name": "end", "id": "cells", "xAxisIndex": 0, "yAxisIndex": 0,
             "data": _cells(found), "progressive": 0, "emphasis": {"itemStyle": {"borderColor": look["ink"]}}},
        ],
    }  # fmt: skip


def ends(found: Grid) -> list[End]:
    """Return the ends that a map shows."""
    return [CODES[c] for c in sorted({int(c) for c in np.unique(found.code)})]


class Mark(NamedTuple):
    """A mark over the map: letter (none for the design that is shown), colour, place from left and top (0 to 1)."""

    letter: str
    colour: str
    left: float
    top: float


def marks(state: State, wanted: Key) -> list[Mark]:
    """Return the marks of the kept designs and, last, of the one that is shown; those off the map are left out."""
    every = [(live.NAMES[i], KEPT[i], one) for i, one in enumerate(state.kept) if one.load == state.load]
    found = []
    for letter, colour, one in (*every, ("", THEMES["light"]["point"], state)):
        place = []
        for name, n in ((wanted.x, SIZE[0]), (wanted.y, SIZE[1])):
            low, high = _range(name)
            step = (high - low) / (n - 1)
            place.append((float(one.value(name) or 0.0) / FIELDS[name].factor - low + step / 2) / (high - low + step))
        if all(0 <= at <= 1 for at in place):
            found.append(Mark(letter, colour, place[0], 1 - place[1]))
    return found


def _label(name: str) -> str:
    field = FIELDS[name]
    return field.symbol + (f" ({field.unit})" if field.unit else "")


def _cells(found: Grid) -> list[list[float | None]]:
    """Rows of column, row, code, engagement, end, RED; what is not finite is left out."""
    cells = []
    for j in range(found.y.size):
        for i in range(found.x.size):
            figures = [float(f"{v[j, i]:.4g}") for v in (found.load_e, found.load_end, found.RED)]
            cells.append([i, j, int(found.code[j, i]), *(v if math.isfinite(v) else None for v in figures)])
    return cells


def _tooltip(wanted: Key, load: str) -> str:
    """Return the function that says what a cell is, for the browser."""
    angle = LOADS[load].letter
    parts = []
    for place, name, n in ((0, wanted.x, SIZE[0]), (1, wanted.y, SIZE[1])):
        low, high = _range(name)
        field = FIELDS[name]
        value = f"({low} + p.value[{place}] * {(high - low) / (n - 1)}).toPrecision(3)"
        parts.append(f"'{field.symbol} = ' + {value} + '{' ' + field.unit if field.unit else ''}<br>'")
    ends = [str(end) for end in CODES]
    more = f"(p.value[3] == null ? '' : '<br>{angle} at engagement ' + p.value[3] + ', at the end ' + p.value[4])"
    red = "(p.value[5] == null ? '' : '<br>RED ' + p.value[5])"
    last = f"'<b>' + {ends}[p.value[2]] + '</b>' + {more} + {red} + '<br><i>click takes it</i>'"
    return f"(p) => {' + '.join(parts)} + {last}"


def check_axes(load: str, x: str, y: str) -> None:
    """Refuse axes that the loading does not have, or one twice. Raises InputError: with the ones that can be chosen."""
    if x == y or not {x, y} <= set(axes(load)):
        refuse("map", "", f"{x} and {y}", f"choose two of {', '.join(axes(load))}")
