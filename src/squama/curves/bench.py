"""What an endless beam's torque or moment becomes on the bench: free to bow or twist, with its own number of scales.

:func:`squama.twist` and :func:`squama.bend` answer for an endless beam that is held straight, or from twisting. This
sets beside that answer, at one load, what holds it, the same beam under its load alone (:mod:`squama.curves.released`)
and, in twisting, a straight row of its own scales (:func:`squama.row`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.curves.labelled import Answer
from squama.loads import LOADS, Load, holds
from squama.units import torque_unit

MOST = 200
"""Most scales of a row that is set beside an endless beam."""


class State(NamedTuple):
    """Torque or moment (N m), and the tangent stiffness over that before contact; NaN where not known."""

    torque: float
    stiffness_ratio: float


class Bench(NamedTuple):
    """A beam at a load angle ``at``, rad per pitch.

    ``endless``: held straight (from twisting) by the moment (torque) ``holding``, N m; ``released``: free to bow (to
    twist), by ``strain`` rad per pitch; ``row``: ``scales`` of it in a straight row. ``notes`` say what is missing;
    ``held``: whether the beam's other strain is, which is free by :attr:`squama.Beam.hold` else.
    """

    load: Load
    at: float
    endless: State
    holding: float
    released: State
    strain: float
    row: State
    scales: int
    notes: tuple[str, ...]
    held: bool = True

    @property
    def record(self) -> dict[str, object]:
        """The figures as plain data, SI units."""
        found = {
            "at": self.at, "holding": self.holding, "scales": self.scales, "strain": self.strain,
            **{name: getattr(self, name)._asdict() for name in ("endless", "released", "row")},
        }  # fmt: skip
        return found | {"notes": list(self.notes)}

    @property
    def lines(self) -> Iterator[str]:
        """The figures in words, a line each."""
        twisting = self.load.sided
        held, free = ("straight", "bow") if twisting else ("from twisting", "twist")
        what = "bending moment" if twisting else "torque"
        factor, unit = torque_unit(self.endless.torque)

        def said(state: State) -> str:
            return f"{factor * state.torque:.3g} {unit}, {state.stiffness_ratio:.3g} times as stiff as the bar"

        if not self.held:
            yield f"  endless, free to {free} (no {what}): {said(self.endless)}"
            if math.isfinite(self.row.torque):
                yield f"  {self.scales} scales in a row, free to {free}: {said(self.row)}"
            yield from (f"  {note}" for note in self.notes)
            return
        by = f" by a {what} of {factor * self.holding:.3g} {unit}" if math.isfinite(self.holding) else ""
        yield f"  endless, held {held}{by}: {said(self.endless)}"
        if math.isfinite(self.released.torque):
            yield f"  endless, free to {free} (no {what}): {said(self.released)}"
        if math.isfinite(self.row.torque):
            yield f"  {self.scales} scales in a row, held straight: {said(self.row)}"
        yield from (f"  {note}" for note in self.notes)


def bench(beam: Beam, answer: Answer, *, ideal: bool, at: float | None = None) -> Bench | None:
    """Return what stands beside an answer at a load angle per pitch (rad); by default at twice the engagement.

    ``answer`` is one curve of :func:`squama.twist` or :func:`squama.bend` on the compliant joint. None where scales do
    not touch before the load, or the answer does not come to it.
    """
    load = LOADS[answer.attrs["load"]]
    x, torque = answer[load.angle], answer[load.torque]
    known = np.isfinite(torque)
    last, engaged = float(x[known].max(initial=0.0)), float(answer[f"{load.angle}_e"])
    at = min(2 * engaged, last) if at is None else at
    if not engaged < at <= last * (1 + 1e-9):
        return None

    def there(name: str) -> float:
        return float(np.interp(at, x[known], answer[name][known])) if name in answer.variables else math.nan

    endless, holding = State(there(load.torque), there("stiffness_ratio")), there("M" if load.sided else "T")
    mu, sense = float(answer["mu"]), str(answer.attrs.get("sense", "+"))
    held = holds(str(answer.attrs["hold"]), load)
    one, strain = State(math.nan, math.nan), math.nan
    notes: tuple[str, ...] = ()
    if held:
        one, strain, notes = _released(beam, load, mu, at, ideal=ideal, sense=sense)
    row = State(math.nan, math.nan)
    if load.sided and not beam.other and beam.scales <= MOST:
        row, why = _row(beam, mu, at, ideal=ideal, sense=sense)
        notes += why
    return Bench(load, at, endless, holding, one, strain, row, beam.scales, notes, held)


def _released(
    beam: Beam, load: Load, mu: float, at: float, *, ideal: bool, sense: str
) -> tuple[State, float, tuple[str, ...]]:
    from squama.curves.released import released

    r = released(beam, load.name, mu, at, ideal=ideal, sense=sense)
    note = f"free to {'bow' if load.sided else 'twist'}: {r.note}"
    return State(float(r.torque[0]), float(r.stiffness_ratio[0])), float(r.strain[0]), (note,) * bool(r.note)


def _row(beam: Beam, mu: float, at: float, *, ideal: bool, sense: str) -> tuple[State, tuple[str, ...]]:
    from squama.curves.own_scales import own_scales

    own = own_scales(beam, [at / beam.pitch], mu=mu, sense=sense, joint="compliant", ideal=ideal)
    return State(float(own.T[0]), float(own.stiffness_ratio[0])), (own.note,) * bool(own.note)
