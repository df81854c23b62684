"""Shapes of the first bending modes, and Gauss's rule along the beam."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from squama.loads import MODES
from squama.types import Array


class Mode(NamedTuple):
    """Shape of a bending mode: chi falls from 1 to 0 over the distance s from the place of largest curvature.

    ``far`` is the inverse of ``shape``; ``weight`` is the number of parts of the beam with that shape; ``square`` the
    mean of chi^2; omega0 = (number/L)^2 sqrt(E I/m'). ``slope`` is the mean square of the slope, times L^2, over that
    of the deflection.
    """

    shape: Callable[[Array], Array]
    far: Callable[[Array], Array]
    weight: float
    square: float
    number: float
    slope: float

    def of_cells(self, n: int) -> Array:
        """Return the shape in the middle of each of n cells along the beam."""
        return self.shape(np.abs((np.arange(n) + 0.5) / n - (self.weight - 1) / 2))


_B = 1.8751040687119611
_S = (math.cosh(_B) + math.cos(_B)) / (math.sinh(_B) + math.sin(_B))


def _cantilever(s: Array) -> Array:
    v = _B * np.asarray(s)
    return np.asarray((np.cosh(v) + np.cos(v) - _S * (np.sinh(v) + np.sin(v))) / 2)


def _cantilever_far(chi: Array) -> Array:
    """Return the place where the cantilever's curvature is a share ``chi`` of its largest: Newton, chi is convex."""
    s = np.zeros_like(chi)
    for _ in range(60):
        v = _B * s
        slope = _B * (np.sinh(v) - np.sin(v) - _S * (np.cosh(v) + np.cos(v))) / 2
        step = (_cantilever(s) - chi) / np.minimum(slope, -1e-12)
        s = np.clip(s - step, 0.0, 1.0)
        if np.abs(step).max(initial=0.0) < 1e-15:
            break
    return s


_SIMPLE = Mode(lambda s: np.cos(np.pi * s), lambda c: np.arccos(c) / np.pi, 2.0, 0.5, math.pi, math.pi**2)
_CANTILEVER = Mode(_cantilever, _cantilever_far, 1.0, 0.25, _B, _B * _S * (2 + _B * _S))
SHAPES = dict(zip(MODES[1:], (_SIMPLE, _CANTILEVER), strict=True))
"""First bending modes (<chi^2> of the cantilever is 1/4 exactly)."""


@functools.cache
def gauss(n: int) -> tuple[Array, Array]:
    """Return nodes and weights of Gauss and Legendre on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, w / 2
