"""A beam's torque or moment at one load: its own scales by their ends, endless, and endless but held, or free."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import NamedTuple, Unpack

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.curves import doors
from squama.curves.chosen import COMPLIANT
from squama.curves.doors import How
from squama.curves.labelled import Answer
from squama.errors import InputError
from squama.loads import COUPLE, ENDLESS, FREE, GRIPPED, LOADS, NOTHING, STRAIGHT, Load, ending, holds
from squama.units import number, torque_unit

SEVEN = "joint.matrix knows no bend; squama joint --matrix writes all nine motions"


class State(NamedTuple):
    """Torque or moment (N m), and the tangent stiffness over that before contact; NaN where not known.

    ``strain``: what the beam does that is not loaded, rad per pitch: bend of a twisted beam, twist of a bent one;
    ``holding``: the moment or torque (N m) that holds that, 0 where it is free.
    """

    torque: float
    stiffness_ratio: float
    strain: float = math.nan
    holding: float = math.nan


class Bench(NamedTuple):
    """A beam at a load angle ``at``, rad per pitch.

    ``row``: of its own number of ``scales``, NaN of an endless beam, whose ``ends`` are as the word says; ``endless``
    without ends; ``other``: endless, held straight (from twisting) where that is free, else free to bow (to twist);
    ``held``: whether the beam is; ``by_ends``: the row with other ends, NaN where its curve ends before the load.
    ``notes`` say what is missing.
    """

    load: Load
    at: float
    endless: State
    other: State
    row: State
    scales: int
    ends: str
    notes: tuple[str, ...]
    held: bool
    by_ends: Mapping[str, State]

    @property
    def record(self) -> dict[str, object]:
        """The figures as plain data, SI units."""
        states = {"endless": self.endless, ("free" if self.held else STRAIGHT): self.other, "row": self.row}
        found = {name: state._asdict() for name, state in states.items()}
        own: dict[str, object] = {"scales": self.scales, "ends": self.ends}
        own["other_ends"] = {ends: state._asdict() for ends, state in self.by_ends.items()}
        return {"at": self.at, "held": self.held, **own, **found, "notes": list(self.notes)}

    @property
    def lines(self) -> Iterator[str]:
        """The figures in words, a line each."""
        factor, unit = torque_unit(self.endless.torque)
        straight, bow = ("straight", "bow") if self.load.sided else ("from twisting", "twist")
        what = "bending moment" if self.load.sided else "torque"

        def said(state: State) -> str:
            return f"{number(factor * state.torque)} {unit}, {number(state.stiffness_ratio)} times as stiff as the bar"

        def how(state: State, *, held: bool) -> str:
            if not held:
                return f"free to {bow} (no {what})"
            by = f" by a {what} of {number(factor * state.holding)} {unit}" if math.isfinite(state.holding) else ""
            return f"held {straight}{by}"

        if math.isfinite(self.row.torque):
            held_so = f", held {straight}" * self.held
            yield f"  {self.scales} scales {ending(self.ends)}{held_so}: {said(self.row)}"
            shares = (getattr(self.row, name) / getattr(self.endless, name) for name in State._fields[:2])
            torque, tangent = (number(share) for share in shares)
            yield f"  which is {torque} of the endless beam's {self.load.torque_words} and {tangent} of its stiffness:"
        for ends, state in self.by_ends.items():
            there = said(state) if math.isfinite(state.torque) else "the curve ends before"
            yield f"  {self.scales} scales {ending(ends)}: {there}"
        for state, held in ((self.endless, self.held), (self.other, not self.held)):
            if math.isfinite(state.torque):
                yield f"  endless, {how(state, held=held)}: {said(state)}"
        yield from (f"  {note}" for note in self.notes)


def bench(beam: Beam, answer: Answer, *, ideal: bool, at: float | None = None) -> Bench | None:
    """Return what stands beside an answer at a load angle per pitch (rad); by default at twice the engagement.

    ``answer`` is one curve of :func:`squama.twist` or :func:`squama.bend` on the compliant joint. None where scales do
    not touch before the load, or the answer does not come to it.
    """
    load = LOADS[answer.attrs["load"]]
    x = answer[load.angle]
    known = np.isfinite(answer[load.torque])
    last, engaged = float(x[known].max(initial=0.0)), float(answer[f"{load.angle}_e"])
    at = min(2 * engaged, last) if at is None else at
    if not engaged < at <= last * (1 + 1e-9):
        return None
    held, own = holds(str(answer.attrs["hold"]), load), str(answer.attrs.get("ends", ""))
    how, sense = How(mu=float(answer["mu"]), ideal=ideal, joint=COMPLIANT), str(answer.attrs.get("sense", "+"))
    one, row = beam.replace(hold=str(answer.attrs["hold"])), State(math.nan, math.nan)
    endless = _at(one, load, at, sense, **how) if own else _state(answer, load, at)
    if own:
        row = _state(answer, load, at)
    other, notes = _other(beam, load, at, sense, held=held, **how)
    by_ends = _by_ends(one, load, at, sense, own, **how) if own else {}
    return Bench(load, at, endless, other, row, beam.pitches, own, notes, held, by_ends)


def _by_ends(beam: Beam, load: Load, at: float, sense: str, own: str, **how: Unpack[How]) -> dict[str, State]:
    """Return the states of a beam's scales with other ends than its ``own``, without those that it cannot have."""
    found = {}
    for ends in (FREE, COUPLE, GRIPPED):
        with suppress(InputError):
            if ends != own:
                found[ends] = _at(beam, load, at, sense, ends, **how)
    return found


def _at(beam: Beam, load: Load, at: float, sense: str, ends: str = ENDLESS, **how: Unpack[How]) -> State:
    """Return the state at a load angle per pitch of a beam with such ends."""
    return _state(doors.respond(beam, load.name, at=[at / beam.pitch], sense=sense, ends=ends, **how), load, at)


def _state(answer: Answer, load: Load, at: float) -> State:
    """Return an answer's state at a load angle per pitch."""
    x, known = answer[load.angle], np.isfinite(answer[load.torque])
    strain, holding = ("psi", "M") if load.sided else ("phi", "T")
    names = load.torque, "stiffness_ratio", strain, holding

    def there(name: str) -> float:
        if name not in answer.variables or not known.any():
            return math.nan
        return float(np.interp(at, x[known], answer[name][known]))

    return State(*map(there, names))


def _other(
    beam: Beam, load: Load, at: float, sense: str, *, held: bool, **how: Unpack[How]
) -> tuple[State, tuple[str, ...]]:
    """Return what the beam does that is held straight, or free where it was ``held``."""
    none, free = State(math.nan, math.nan), "bow" if load.sided else "twist"
    if held and not beam.replace(hold=NOTHING).given.may:
        return none, (f"free to {free}: {SEVEN}",)
    try:
        one = arguments.held_by(beam, NOTHING if held else STRAIGHT)
        return _at(one, load, at, sense, **how), ()
    except InputError as error:
        return none, (str(error),)
