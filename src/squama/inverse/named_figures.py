"""Figures that a target may name, the twists at which they are wanted, and their values for many designs."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np

from squama.beam.design import Beam
from squama.model.outcome import LOCKS
from squama.study.columns import Cells
from squama.types import Array

AT_TWIST = {
    "tangent": ("N m2", "tangent stiffness at the stated twist"),
    "torque": ("N m", "torque at the stated twist"),
    "stiffness_ratio": ("1", "tangent stiffness over that without contact at the stated twist"),
    "stress": ("Pa", "largest stress (von Mises) in a scale at the stated twist"),
    "strength_share": ("1", "largest stress in a scale over its strength at the stated twist"),
    "W_fr": ("J/m", "frictional work up to the stated twist"),
    "RED": ("1", "share of the work up to the stated twist that friction takes"),
}
"""Figures at a twist by name: unit, meaning. Hinges have tangent and torque only, and only in contact."""
OF_BEAM = {
    "stiffness": ("N m2", "stiffness before engagement"),
    "engagement": ("rad", "twist per pitch at engagement"),
    "length": ("m", "length of the beam"),
}
"""Figures without a twist; on hinges the length is fixed."""
OF_LOCKS = {
    "range": ("rad", "twist per pitch from engagement to the lock"),
    "lock": ("rad", "twist per pitch at the lock"),
    "W_fr": ("J/m", "frictional work at the cut-off before the lock"),
    "RED": ("1", "relative energy dissipation at the cut-off before the lock"),
    "critical_mu": ("1", "smallest friction that locks at engagement"),
}
"""Figures of the lock, which exists on hinges only."""
FIGURES = OF_LOCKS | OF_BEAM | AT_TWIST


Number = TypeVar("Number", float, Array)


class At(NamedTuple):
    """A twist ``rate * d + angle + total / N`` in rad per pitch, one term of which is set.

    ``rate`` in rad/m, ``angle`` in rad per pitch, ``total`` in rad of the whole beam. On hinges the number of scales N
    does not vary, and a total twist becomes an ``angle``.
    """

    rate: float
    angle: float
    total: float = 0.0

    def per_pitch(self, d: Number, scales: Number | float = 1.0) -> Number:
        """Return the twist (rad per pitch) of beams with pitches d (m) and numbers of scales."""
        return self.rate * d + self.angle + self.total / scales

    def per_length(self, beam: Beam) -> float:
        """Return the twist rate (rad/m) of a beam."""
        return float(self.per_pitch(beam.pitch, beam.pitches)) / beam.pitch


class Want(NamedTuple):
    """A figure by name, and the twist at which it is wanted.

    The search adds the borders of their domain: ``reach`` is the end of the curve (rad per pitch); ``tip`` and ``side``
    are the room of the contact to the end of its edge at the lock, over the scale's half width or length; ``hold`` is
    the moment of friction missing to a lock where the contact runs off an edge, over the scale's length.
    """

    figure: str
    at: At | None = None


class Options(NamedTuple):
    """Options common to all designs; ``locks``: codes of the ends that count as locks."""

    law: str = "edge"
    sense: str = "+"
    margin: float = 0.01
    load: str = "twisting"
    locks: tuple[int, ...] = LOCKS
    joint: str = "hinge"


class Found(NamedTuple):
    """Wanted figures of designs: values (wants, designs), NaN where a design has none, and the ends of the curves.

    ``slopes`` (wants, variables, designs) are derivatives by the moved variables; ``code`` (designs,) is the end,
    ``load_e`` engagement and ``load_end`` the end of the curve, rad per pitch.
    """

    values: Array
    slopes: Array
    code: Array
    load_e: Array
    load_end: Array


def flat(c: Cells, n: int = 1) -> Cells:
    """Return columns all of one length (m,): that of the broadcast arrays, ``n`` where nothing varies."""
    every = [*c.arrays.values(), *(v for t in c.sizes.values() for v in t.values())]
    shape = np.broadcast_shapes((n,), *map(np.shape, every))
    n = math.prod(shape)

    def column(v: Array) -> Array:
        return np.ascontiguousarray(np.broadcast_to(v, shape)).reshape(n)

    return c.mapped(column)


def harmless(c: Cells, good: Array) -> Cells:
    """Return columns in which rows that are no valid beam hold values that can be computed."""
    if good.all():
        return c
    fill = {"eta": 2.0, "lam": 0.5, "alpha": 0.5, "theta0": 0.2, "mu": 0.2}
    return c.changed({name: np.where(good, v, fill.get(name, 1.0)) for name, v in c.arrays.items()}, c.sizes)
