"""Space of designs: dimensions of a beam between bounds, and choices from lists, as points of the unit cube."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from squama import units
from squama.beam.design import Beam
from squama.inverse.named_figures import flat
from squama.model.sensitivity import STEP
from squama.study.columns import Cells, columns
from squama.study.parameters import ALIASES, FACTOR, FULL, PARAMETERS, SCALES, of_beam
from squama.types import Array

DIMENSIONS = tuple(FULL.get(name, name) for name in PARAMETERS if "." in FULL.get(name, name) and name != FACTOR)
"""Dimensions of a beam file that may be varied."""
SLACK = 1e-9
"""Relative tolerance within which bounds count as multiples of a step."""
WIDE = 10.0
"""Ratio of the bounds above which a range is divided geometrically."""


class Grid(NamedTuple):
    """Rounding of a dimension to multiples of ``step`` in ``unit``; no rounding with step 0."""

    step: float = 0.0
    unit: str = ""


class Variable(NamedTuple):
    """A varied dimension: ``name`` as in the beam file, bounds (SI), and the grid to which it is rounded."""

    name: str
    low: float
    high: float
    grid: Grid = Grid()

    @property
    def key(self) -> str:
        """Name of the parameter in sweeps."""
        return ALIASES.get(self.name, self.name)

    @property
    def geometric(self) -> bool:
        """Whether the range is divided geometrically."""
        return self.low > 0 and self.high / self.low > WIDE

    @property
    def step(self) -> float:
        """Step of the rounding, SI; 0 where there is none, or no multiple lies within the bounds."""
        low, high = self.multiples
        return self.made(1) if high >= low else 0.0

    @property
    def multiples(self) -> tuple[int, int]:
        """Smallest and largest multiple of the step within the bounds; (1, 0) where there is none."""
        if not self.grid.step:
            return 1, 0
        step = self.made(1)
        return math.ceil(self.low / step * (1 - SLACK)), math.floor(self.high / step * (1 + SLACK))

    def made(self, multiple: float) -> float:
        """Return a multiple of the step as read from the text of a file, SI."""
        text = f"{multiple * self.grid.step:.12g} {self.grid.unit}".strip()
        return units.quantity(text, PARAMETERS[self.key].dimension)

    def rounded(self, value: float) -> float:
        """Return the nearest multiple of the step within the bounds, SI."""
        if not self.step:
            return value
        low, high = self.multiples
        return self.made(min(max(round(value / self.step), low), high))


class Choice(NamedTuple):
    """A choice from a list: its ``name``, options in words, and the values (SI) that each sets, by beam-file name."""

    name: str
    words: tuple[str, ...]
    options: tuple[dict[str, float], ...]

    @property
    def columns(self) -> dict[str, Array]:
        """Values (options,) that the options set, by key."""
        return {ALIASES.get(name, name): np.array([one[name] for one in self.options]) for name in self.options[0]}

    def number(self, share: Array) -> Array:
        """Return the option's index for shares (n,) of the unit interval."""
        return np.asarray(np.minimum((share * len(self.options)).astype(int), len(self.options) - 1))


class Space(NamedTuple):
    """The starting beam, varied dimensions and choices; points of the unit cube have a column for each, in order."""

    beam: Beam
    load: str
    variables: tuple[Variable, ...]
    choices: tuple[Choice, ...] = ()

    def values(self, y: Array) -> dict[str, Array]:
        """Return dimensions (n,), SI, by key, of points (n, m) of the unit cube."""
        found: dict[str, Array] = {}
        for choice, share in zip(self.choices, y.T[len(self.variables) :], strict=True):
            found |= {key: column[choice.number(share)] for key, column in choice.columns.items()}
        for v, share in zip(self.variables, y.T, strict=False):
            value = v.low * (v.high / v.low) ** share if v.geometric else v.low + (v.high - v.low) * share
            # rounding must not leave the bounds
            found[v.key] = np.clip(value, v.low, v.high)
        return found

    def place(self, values: Mapping[str, Array | float]) -> Array:
        """Return the nearest points (m,) or (n, m) for dimensions (SI) by key; choices by their first dimension."""
        shares = []
        for v in self.variables:
            value = np.clip(values[v.key], v.low, v.high)
            whole = np.log(v.high / v.low) if v.geometric else v.high - v.low
            shares.append((np.log(value / v.low) if v.geometric else value - v.low) / whole)
        for choice in self.choices:
            key, options = next(iter(choice.columns.items()))
            nearest = np.abs(np.asarray(values[key])[..., None] - options).argmin(axis=-1)
            shares.append((nearest + 0.5) / len(options))
        return np.stack(shares, axis=-1)

    @property
    def start(self) -> Array:
        """Point (m,) of the starting beam in the unit cube."""
        return self.place({key: of_beam(self.beam, self.load, key) for key in self.keys})

    @property
    def keys(self) -> list[str]:
        """Keys of all varied or chosen dimensions."""
        return [*(v.key for v in self.variables), *(key for choice in self.choices for key in choice.columns)]

    def cells(self, y: Array) -> Cells:
        """Return the columns of the beams at points (n, m)."""
        return cells_of(self.beam, self.load, self.values(y), len(y))

    def moved(self, y: Array) -> list[Cells]:
        """Return columns with each variable moved by a complex step, for derivatives by the unit cube's coordinates."""
        values = self.values(y)
        found = []
        for v in self.variables:
            rate = values[v.key] * np.log(v.high / v.low) if v.geometric else v.high - v.low
            found.append(stepped(self.beam, self.load, values, v.key, rate, len(y)))
        return found

    def beam_of(self, y: Array) -> Beam:
        """Return the beam at one point (m,), its dimensions rounded to their steps."""
        at = self.values(y[None])
        varied = {v.name: v.rounded(float(at[v.key][0])) for v in self.variables}
        return built(self.beam, {**varied, **{name: x for one in self.chosen(y) for name, x in one[1].items()}})

    def nearest(self, y: Array) -> Array:
        """Return points (n, m) with every dimension rounded to the nearest multiple of its step."""
        values = self.values(y)
        values |= {v.key: np.array([v.rounded(x) for x in values[v.key].tolist()]) for v in self.variables}
        return self.place(values)

    def chosen(self, y: Array) -> list[tuple[str, dict[str, float]]]:
        """Return the chosen options at one point (m,): words, and the values that they set."""
        shares = y[len(self.variables) :]
        numbers = [int(choice.number(share)) for choice, share in zip(self.choices, shares, strict=True)]
        return [(c.words[i], c.options[i]) for c, i in zip(self.choices, numbers, strict=True)]


def stepped(beam: Beam, load: str, values: dict[str, Array], key: str, rate: Array | float, n: int) -> Cells:
    """Return the columns (n,) with dimension ``key`` moved by ``rate`` i STEP."""
    at = np.broadcast_to(values.get(key, of_beam(beam, load, key)), n)
    return cells_of(beam, load, {**values, key: at + 1j * STEP * rate}, n)


def cells_of(beam: Beam, load: str, values: dict[str, Array], n: int) -> Cells:
    """Return the columns of n designs with dimensions (SI, by key) replaced; scales in ``sizes["beam"]``."""
    c = flat(columns(beam, {key: value for key, value in values.items() if key != SCALES}, load=load), n)
    scales = np.ascontiguousarray(np.broadcast_to(values.get(SCALES, float(beam.pitches)), n))
    return c.changed(c.arrays, {**c.sizes, "beam": {"scales": scales}})


def built(beam: Beam, values: Mapping[str, float]) -> Beam:
    """Return a beam with some values (SI) replaced, by their names in the beam file."""
    return beam._with({name: round(value) if name == SCALES else value for name, value in values.items()})
