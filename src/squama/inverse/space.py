"""What is varied: dimensions of a beam between bounds, as points of the unit cube."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.inverse.figures import flat
from squama.model.sensitivity import STEP
from squama.study.columns import Cells, columns
from squama.study.parameters import ALIASES, FULL, PARAMETERS, of_beam
from squama.types import Array

DIMENSIONS = tuple(FULL.get(name, name) for name in PARAMETERS if "." in FULL.get(name, name))
"""Dimensions of a beam file that may be varied."""
WIDE = 10.0
"""Bounds farther apart than this factor are divided in equal ratios."""


class Variable(NamedTuple):
    """A dimension (``name`` as in the beam file, ``key`` as in a sweep) and its bounds, SI."""

    name: str
    low: float
    high: float

    @property
    def key(self) -> str:
        """Name of the parameter."""
        return ALIASES.get(self.name, self.name)

    @property
    def geometric(self) -> bool:
        """Whether the range is divided in equal ratios."""
        return self.low > 0 and self.high / self.low > WIDE


class Space(NamedTuple):
    """A beam and what is varied of it."""

    beam: Beam
    load: str
    variables: tuple[Variable, ...]

    def values(self, y: Array) -> dict[str, Array]:
        """Return dimensions (SI, by key) of points (n, m) of the unit cube."""
        found = {}
        for v, share in zip(self.variables, y.T, strict=True):
            value = v.low * (v.high / v.low) ** share if v.geometric else v.low + (v.high - v.low) * share
            # rounding must not leave the bounds
            found[v.key] = np.clip(value, v.low, v.high)
        return found

    def place(self, values: dict[str, float]) -> Array:
        """Return the point (m,) of the unit cube of some dimensions, by key; outside the bounds the nearest."""
        shares = []
        for v in self.variables:
            value = min(max(values[v.key], v.low), v.high)
            whole = np.log(v.high / v.low) if v.geometric else v.high - v.low
            shares.append((np.log(value / v.low) if v.geometric else value - v.low) / whole)
        return np.array(shares)

    def cells(self, y: Array) -> Cells:
        """Return the columns of points (n, m)."""
        return flat(columns(self.beam, self.values(y), load=self.load), len(y))

    def moved(self, y: Array) -> list[Cells]:
        """Return the columns with each variable moved by a complex step; derivatives are by the unit cube."""
        values = self.values(y)
        found = []
        for v in self.variables:
            rate = values[v.key] * np.log(v.high / v.low) if v.geometric else v.high - v.low
            found.append(stepped(self.beam, self.load, values, v.key, rate, len(y)))
        return found

    def beam_of(self, y: Array) -> Beam:
        """Return the beam of one point (m,)."""
        at = self.values(y[None])
        return self.beam._with({v.name: float(at[v.key][0]) for v in self.variables})


def stepped(beam: Beam, load: str, values: dict[str, Array], key: str, rate: Array | float, n: int) -> Cells:
    """Return the columns with one dimension moved by ``rate`` i STEP."""
    at = np.broadcast_to(values.get(key, of_beam(beam, load, key)), n)
    return flat(columns(beam, {**values, key: at + 1j * STEP * rate}, load=load), n)
