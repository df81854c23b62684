"""The map over two parameters: how stiff beams are at the twist that is shown or, on hinges, how their curves end."""

from __future__ import annotations

import functools
import itertools
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
from squama.model.outcome import CODES
from squama.people import PITCH, degrees
from squama.plot.palette import DARK_ENDS, ENDED, ENDS, KEPT, SOFTER, STEPS, THEMES
from squama.study import columns, compliant_columns, hinge_columns
from squama.types import Array
from squama.units import number
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
SHIFTS = (0, *(sign * 20 * i for i in range(1, 7) for sign in (1, -1)))
"""Pixels by which marks stand apart that would hide each other."""
WIDTH = 300
"""Of a small map, pixels."""
LEVELS = (1.25, 1.6, 2.5, 4.0, 8.0)
"""Tangent stiffness over that of the bar: ends of the classes of a map."""
SOFT = 1 - 1e-6
"""Below it a beam is softer than its bar: behind a peak, or where its contacts hold it less."""
CLASSES = [
    "not in contact",
    "softer than the bar",
    *(f"{low:g} to {high:g} times the bar's" for low, high in itertools.pairwise((1, *LEVELS))),
    f"more than {LEVELS[-1]:g} times",
    "ends before this load",
    "not computed",
]
_FIGURES = {
    True: ["ends at {end}, RED = {{5}}"],
    False: ["ends at {end}", "{{5}} times as stiff as the bar"],
}
"""What is said of a cell: on hinges, and of compliant joints."""
_ELASTIC = ("scale_modulus", "scale_poisson")
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

    ``at``: twist or bend (rad per pitch) at which beams on compliant joints are shown, None of hinges. ``ideal``: the
    scales are thin, as those of the outcome beside the map are.
    """

    x: str
    y: str
    fixed: tuple[object, ...]
    load: str
    law: str
    sense: str
    margin: float
    ideal: bool
    at: float | None
    beam: Beam = field(compare=False)

    @property
    def scales(self) -> str:
        """How the scales of the map are taken, in words."""
        return idealisation(self.beam, "hinge" if self.at is None else "compliant", ideal=self.ideal)

    @property
    def title(self) -> str:
        """What the map shows."""
        turn, unit = degrees(self.beam)
        return "Ends on hinges" if self.at is None else f"Stiffness at {number(turn * self.at, unit)}"


class Grid(NamedTuple):
    """Values along the axes (shown units), and by y and x: numbers of the classes, load angles, and a ``figure``.

    On hinges classes are ends and the figure is RED. On compliant joints the figure is the tangent stiffness over the
    bar's; ``load_end`` is NaN where a curve goes on.
    """

    x: Array
    y: Array
    code: Array
    load_e: Array
    load_end: Array
    figure: Array


def key(state: State, x: str, y: str) -> Key:
    """Return what the map of a state depends on; values of its own axes are left out."""
    m = live.motion(state.setting)
    names = (*AXES, *_STIFF) if m.joint == "hinge" else (*AXES, *_STIFF, *_ELASTIC)
    fixed = [state.value(name) for name in names if name not in (x, y)]
    ideal = thin(LOADS[state.load], state.law, m.joint, ideal=m.ideal)
    at = None if m.joint == "hinge" else min(state.twist, m.last)
    beam = state.beam
    # the number of scales: angles are said over all of them
    return Key(x, y, (*fixed, beam.scales, beam.joint.matrix, beam.neutral, beam.held), *state[2:6], ideal, at, beam)


@functools.lru_cache(maxsize=8)
def grid(wanted: Key) -> Grid:
    """Solve the designs of a map."""
    w, (x, y) = wanted, (axis.values for axis in drawn(wanted.x, wanted.y))
    over = {w.x: x[None, :], w.y: y[:, None]}
    values = dict(placed(w.beam, name, FIELDS[name].factor * v) for name, v in over.items())
    if w.at is not None:
        cells = columns.columns(w.beam, values)
        f = compliant_columns.solved(cells, w.at, load=w.load, sense=w.sense, ideal=w.ideal, along=False)
        code = 1 + np.searchsorted((SOFT, *LEVELS), f.stiffness_ratio, side="right")
        ended = (f.load_end < w.at) | ~np.isfinite(f.stiffness_ratio)
        code[ended] = CLASSES.index("ends before this load")
        code[f.load_e > w.at] = CLASSES.index("not in contact")
        code[f.code == compliant_columns.ENDS.index(compliant_columns.UNKNOWN)] = CLASSES.index("not computed")
        load_end = np.where(ended, f.load_end, np.nan)
        return Grid(x, y, *(v.reshape(SIZE[::-1]) for v in (code, f.load_e, load_end, f.stiffness_ratio)))
    cells = columns.columns(w.beam, values, load=w.load)
    done = hinge_columns.solved(cells, law=w.law, sense=w.sense, margin=w.margin, load=w.load, ideal=w.ideal)
    names = ("code", "load_e", "load_end", "RED")
    return Grid(x, y, *(np.broadcast_to(done[name], SIZE[::-1]) for name in names))


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
    look, sides = THEMES["dark" if dark else "light"], drawn(wanted.x, wanted.y)
    values = []
    for axis, gap, place in zip(sides, (20, 30), ("bottom", "left"), strict=True):
        borders = {"min": axis.low - axis.step / 2, "max": axis.high + axis.step / 2, "splitLine": {"show": False}}
        values.append({**charts.axis(axis.label, look, nameGap=gap, **borders), "position": place})
        values[-1]["axisLabel"] |= {"showMinLabel": False, "showMaxLabel": False}
    names = [{"type": "category", "show": False, "data": list(range(n))} for n in SIZE]
    every, colours = _words(wanted), classes(wanted, found, dark=dark)
    pieces = [{"value": every.index(name), "color": colour} for name, colour in colours.items()]
    # column, row, class, engagement and end, figure, engagement and end per pitch; what is not finite is left out
    cells, (turn, unit) = [], degrees(wanted.beam)
    for (j, i), code in np.ndenumerate(found.code):
        loads = [v[j, i] for v in (found.load_e, found.load_end)]
        each = [math.degrees(v) for v in loads] if wanted.beam.scales else []
        figures = [float(f"{v:.3g}") for v in (*(turn * v for v in loads), found.figure[j, i], *each)]
        cells.append([i, j, int(code), *(v if math.isfinite(v) else None for v in figures)])
    # what the browser says of a cell under the pointer (chart.js): symbol, unit, first value and step of the axes; a
    # number in braces is a place in the cell, and a line whose number is missing is left out
    first, end = (f"{{{i}}} {unit}" + f" ({{{i + 3}}} {PITCH})" * bool(wanted.beam.scales) for i in (3, 4))
    words = {
        "axes": [[FIELDS[a.name].symbol, FIELDS[a.name].unit, a.low, a.step] for a in sides],
        "ends": every,
        "lines": [f"engages at {first}", *(line.format(end=end) for line in _FIGURES[wanted.at is None])],
    }
    tip = {"trigger": "item", "confine": True, "padding": [4, 8], "textStyle": {"fontSize": 12, "lineHeight": 15}}
    heat = {"type": "heatmap", "name": "end", "id": "cells", "xAxisIndex": 0, "yAxisIndex": 0, "data": cells}
    heat |= {"progressive": 0, "emphasis": {"itemStyle": {"borderColor": look["ink"]}}}
    return {
        **charts.ground(f"{wanted.title}, {wanted.scales}, over {sides[0].label} and {sides[1].label}", ROOM),
        "tooltip": tip,
        "words": words,
        "xAxis": [names[0], values[0]],
        "yAxis": [names[1], values[1]],
        "visualMap": {"type": "piecewise", "pieces": pieces, "dimension": 2, "seriesIndex": 0, "show": False},
        "series": [heat],
    }


def _words(wanted: Key) -> list[str]:
    return [str(end) for end in CODES] if wanted.at is None else CLASSES


def classes(wanted: Key, found: Grid, *, dark: bool) -> dict[str, str]:
    """Return the classes that a map shows, in words, and their colours."""
    of_ends = DARK_ENDS if dark else ENDS
    if wanted.at is None:
        colours = [of_ends[end] for end in CODES]
    else:
        colours = [THEMES["dark" if dark else "light"]["faint"], SOFTER, *STEPS, ENDED, of_ends["not computed"]]
    return {_words(wanted)[int(c)]: colours[int(c)] for c in np.unique(found.code)}


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
    found: dict[str, Mark] = {}
    for letter, colour, one in (("", THEMES["light"]["point"], state), *reversed(every)):
        left, bottom = (axis.place(one) for axis in drawn(wanted.x, wanted.y))
        if 0 <= left <= 1 and 0 <= bottom <= 1:
            found[letter] = Mark(letter, colour, left, 1 - bottom)
    # none hides another: those that stand apart stay where they are, and first that of the design that is shown
    placed: list[Mark] = []
    for shifts in (SHIFTS[:1], SHIFTS):
        for mark in found.values():
            if mark.letter not in {one.letter for one in placed}:
                taken = [WIDTH * (o.left - mark.left) + o.shift for o in placed if abs(o.top - mark.top) < 0.12]
                free = (s for s in shifts if all(abs(s - place) >= SHIFTS[1] - 1 for place in taken))
                placed += [mark._replace(shift=s) for s in itertools.islice(free, 1)]
    return sorted(placed, key=lambda mark: mark.letter or "~")


def check_axes(x: str, y: str) -> None:
    """Refuse axes that the loading does not have, or one twice. Raises InputError: with the ones that can be chosen."""
    if x == y or not {x, y} <= set(AXES):
        refuse("map", "", f"{x} and {y}", f"choose two of {', '.join(AXES)}")
