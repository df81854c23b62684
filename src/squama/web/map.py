"""The regime map: how designs end over two of their parameters, with the design that is shown."""

from __future__ import annotations

import functools
import math
import threading
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from squama.batch import solved
from squama.beam.design import Beam
from squama.curves.chosen import idealisation, thin
from squama.errors import refuse
from squama.loads import LOADS
from squama.model.outcome import CODES, End
from squama.plot.palette import ENDS, KEPT, THEMES
from squama.study import columns, hinge_columns
from squama.types import Array
from squama.web import charts, live
from squama.web.fields import FIELDS, placed
from squama.web.state import State, preset

AXES = {"mu": "friction", "alpha": "slant", "eta": "overlap", "theta0": "inclination", "beta": "width", "lam": "bar"}
"""Fields that can be an axis, each in a word."""
SIZE = (37, 29)
"""Designs along the axes."""
RANGES = {"eta": (1.0, 8.0), "theta0": (2.0, 40.0), "alpha": (2.0, 80.0), "mu": (0.0, 2.0)}
"""Ranges of axes that differ from those of the sliders, in shown units."""
ROOM = {"left": 58, "right": 16, "top": 8, "bottom": 36}
"""Pixels around the cells; the marks lie over the cells."""
SHIFTS = (0, 20, -20, 40)
"""Pixels by which marks stand apart that would hide each other."""
_STIFF = ("embedded", "thickness", "pitch", "bar_width", "modulus", "poisson", "stiffness", "inclusion")
"""Fields on which only the share of the bar in the energy depends."""


class Axis(NamedTuple):
    """A field as an axis: its range (shown units) and how many cells it has."""

    name: str
    low: float
    high: float
    cells: int

    @property
    def values(self) -> Array:
        """The middles of the cells, in shown units."""
        return np.linspace(self.low, self.high, self.cells)

    @property
    def step(self) -> float:
        """Width of a cell."""
        return (self.high - self.low) / (self.cells - 1)

    @property
    def label(self) -> str:
        """Symbol and unit."""
        shown = FIELDS[self.name]
        return shown.symbol + (f" ({shown.unit})" if shown.unit else "")

    def place(self, state: State) -> float:
        """Return where a design lies, from the left or lower border (0 to 1)."""
        value = float(state.value(self.name) or 0.0) / FIELDS[self.name].factor
        return (value - self.low + self.step / 2) / (self.high - self.low + self.step)


def drawn(x: str, y: str) -> tuple[Axis, Axis]:
    """Return the axes of a map over two fields."""
    ranges = (RANGES.get(name, (FIELDS[name].low, FIELDS[name].high)) for name in (x, y))
    across, up = (Axis(name, *span, n) for name, span, n in zip((x, y), ranges, SIZE, strict=True))
    return across, up


@dataclass(frozen=True)
class Key:
    """What a map depends on: its axes, what else is fixed of the ``beam``, loading, law, sense, margin.

    ``ideal``: the scales on the map's hinges are thin, as those of the outcome beside it are.
    """

    x: str
    y: str
    fixed: tuple[object, ...]
    load: str
    law: str
    sense: str
    margin: float
    ideal: bool
    beam: Beam = field(compare=False)

    @property
    def scales(self) -> str:
        """How the scales of the map are taken, in words."""
        return idealisation(self.beam, "hinge", ideal=self.ideal)


class Grid(NamedTuple):
    """Values along the axes (shown units), and by y and x: codes of the ends, load angles, RED."""

    x: Array
    y: Array
    code: Array
    load_e: Array
    load_end: Array
    RED: Array


def key(state: State, x: str, y: str) -> Key:
    """Return what the map of a state depends on; values of its own axes are left out."""
    fixed = [state.value(name) for name in (*AXES, *_STIFF) if name not in (x, y)]
    ideal = thin(LOADS[state.load], state.law, "hinge", ideal=live.motion(state.setting).ideal)
    return Key(x, y, (*fixed, state.beam.joint.matrix, state.beam.neutral), *state[2:6], ideal, state.beam)


@functools.lru_cache(maxsize=8)
def grid(wanted: Key) -> Grid:
    """Solve the designs of a map."""
    w, (x, y) = wanted, (axis.values for axis in drawn(wanted.x, wanted.y))
    over = {w.x: x[None, :], w.y: y[:, None]}
    values = dict(placed(w.beam, name, FIELDS[name].factor * v) for name, v in over.items())
    cells = columns.columns(w.beam, values, load=w.load)
    done = hinge_columns.solved(cells, law=w.law, sense=w.sense, margin=w.margin, load=w.load, ideal=w.ideal)
    return Grid(x, y, *(np.broadcast_to(done[name], SIZE[::-1]) for name in Grid._fields[2:]))


def warm_up() -> threading.Thread:
    """Load or compile the code of map and curves on a thread of its own, so that the first ones need not wait."""

    def compiled() -> None:
        designs = tuple(np.full(1, v) for v in (3.0, 1.25, 0.45, 0.8, 0.2, 0.5, 1.0))
        # without a limit below which Python would answer
        solved(designs, law="edge", sense="+", margin=0.01, load="twisting", few=0)
        preset("pla")

    thread = threading.Thread(target=compiled, name="warm-up", daemon=True)
    thread.start()
    return thread


def take(state: State, x: str, y: str, cell: tuple[int, int]) -> State:
    """Return the state with the design of a cell of the map.

    Raises InputError: the beam cannot be so; the message names what is in the way.
    """
    for axis, i in zip(drawn(x, y), cell, strict=True):
        state = state.change(axis.name, f"{axis.values[i]:.6g}")
    return state


def options(wanted: Key, found: Grid, *, dark: bool) -> charts.Options:
    """Return the options of the map."""
    look, sides, angle = THEMES["dark" if dark else "light"], drawn(wanted.x, wanted.y), LOADS[wanted.load].letter
    values = []
    for axis, gap, place in zip(sides, (20, 30), ("bottom", "left"), strict=True):
        borders = {"min": axis.low - axis.step / 2, "max": axis.high + axis.step / 2, "splitLine": {"show": False}}
        values.append({**charts.axis(axis.label, look, nameGap=gap, **borders), "position": place})
        values[-1]["axisLabel"] |= {"showMinLabel": False, "showMaxLabel": False}
    names = [{"type": "category", "show": False, "data": list(range(n))} for n in SIZE]
    pieces = [{"value": CODES.index(end), "color": ENDS[end]} for end in ends(found)]
    # column, row, code, engagement, end, RED; what is not finite is left out
    cells = []
    for (j, i), code in np.ndenumerate(found.code):
        figures = [float(f"{v[j, i]:.4g}") for v in (found.load_e, found.load_end, found.RED)]
        cells.append([i, j, int(code), *(v if math.isfinite(v) else None for v in figures)])
    # what the browser says of a cell under the pointer (chart.js): symbol, unit, first value and step of the axes; a
    # number in braces is a place in the cell, and a line whose number is missing is left out
    words = {
        "axes": [[FIELDS[a.name].symbol, FIELDS[a.name].unit, a.low, a.step] for a in sides],
        "ends": [str(end) for end in CODES],
        "lines": [f"engagement at {angle} = {{3}}", f"end at {angle} = {{4}}, RED = {{5}}"],
    }
    tip = {"trigger": "item", "confine": True, "padding": [4, 8], "textStyle": {"fontSize": 12, "lineHeight": 15}}
    heat = {"type": "heatmap", "name": "end", "id": "cells", "xAxisIndex": 0, "yAxisIndex": 0, "data": cells}
    heat |= {"progressive": 0, "emphasis": {"itemStyle": {"borderColor": look["ink"]}}}
    return {
        **charts.ground(f"Map of ends, {wanted.scales} on hinges, over {sides[0].label} and {sides[1].label}", ROOM),
        "tooltip": tip,
        "words": words,
        "xAxis": [names[0], values[0]],
        "yAxis": [names[1], values[1]],
        "visualMap": {"type": "piecewise", "pieces": pieces, "dimension": 2, "seriesIndex": 0, "show": False},
        "series": [heat],
    }


def ends(found: Grid) -> list[End]:
    """Return the ends that a map shows."""
    return [CODES[int(c)] for c in np.unique(found.code)]


class Mark(NamedTuple):
    """A mark over a plot: letter (none for the design that is shown), colour, place from left and top (0 to 1).

    ``shift``: pixels to the right of it, where it would hide another one.
    """

    letter: str
    colour: str
    left: float
    top: float
    shift: int = 0


def marks(state: State, wanted: Key) -> list[Mark]:
    """Return the marks of the kept designs and, last, of the one that is shown; those off the map are left out."""
    every = [(live.NAMES[i], KEPT[i], one) for i, one in enumerate(state.kept) if one.load == state.load]
    found: list[Mark] = []
    # none hides another: the one of the design that is shown stays where it is
    for letter, colour, one in (("", THEMES["light"]["point"], state), *reversed(every)):
        left, bottom = (axis.place(one) for axis in drawn(wanted.x, wanted.y))
        if 0 <= left <= 1 and 0 <= bottom <= 1:
            # nearer than this, in widths and heights of a small map, they would stand over each other
            near = [o.shift for o in found if abs(o.left - left) < 0.06 and abs(o.top - 1 + bottom) < 0.12]
            found.insert(0, Mark(letter, colour, left, 1 - bottom, next(s for s in SHIFTS if s not in near)))
    return found


def check_axes(x: str, y: str) -> None:
    """Refuse axes that the loading does not have, or one twice. Raises InputError: with the ones that can be chosen."""
    if x == y or not {x, y} <= set(AXES):
        refuse("map", "", f"{x} and {y}", f"choose two of {', '.join(AXES)}")
