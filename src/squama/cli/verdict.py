"""What decides of a twisted or bent beam: until where it is free, how stiff it is then, how much it bears, its end."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama.cli.summary import modelled, percent
from squama.curves.both_faces import worst
from squama.loads import ending
from squama.model.outcome import SENTENCES, End
from squama.people import figure, turned
from squama.units import torque_unit

if TYPE_CHECKING:
    from squama.beam.design import Beam
    from squama.curves.bench import Bench
    from squama.curves.labelled import Answer
    from squama.loads import Load


def _stress(value: float) -> str:
    return figure(1e-6 * value, "MPa")


def free_until(load: Load, beam: Beam, engaged: float) -> str:
    """Say up to which load angle (rad per pitch) the scales of a beam do not touch."""
    if not math.isfinite(engaged):
        return f"the scales never touch: {load.done}, the beam is as soft as without contact"
    return f"free until {turned(engaged, beam)}" if engaged else "the scales touch before anything is loaded"


class Curve(NamedTuple):
    """A curve of a beam, whose end was ``asked`` for or not, and what stands ``beside`` it on the bench, if known."""

    load: Load
    beam: Beam
    data: Answer
    asked: bool
    beside: Bench | None = None

    @property
    def end(self) -> End:
        """Why the curve ends."""
        return End(self.data["end"].item())

    def of(self, name: str) -> float:
        """Return a single figure of the load angle: "e" at engagement, "end", "strength", "strain"."""
        return float(self.data[f"{self.load.angle}_{name}"])

    @property
    def at(self) -> float:
        """Load angle (rad per pitch) that figures are for: the end if that was asked for, or twice the engagement."""
        x, known = self.data[self.load.angle], np.isfinite(self.data[self.load.torque])
        last, twice = float(x[known].max(initial=0.0)), 2 * self.of("e")
        return twice if twice <= last and not self.asked else last

    def there(self, name: str) -> float:
        """Return a variable at that load angle, of stress and strain the larger of both faces; NaN if there is none."""
        curves = self.data.curves
        if name not in curves:
            return math.nan
        known = np.isfinite(curves[self.load.torque])
        along = worst(curves, name) if name in ("stress", "strain") else curves[name]
        return float(np.interp(self.at, curves[self.load.angle][known], along[known]))

    @property
    def stiffer(self) -> float:
        """Tangent stiffness there over that before contact."""
        if "stiffness_ratio" in self.data.variables:
            return self.there("stiffness_ratio")
        return self.there(self.load.tangent) / self.load.rigidity(self.beam)

    @property
    def verdict(self) -> str:
        """Until where the beam is free, how many times as stiff it is then, or where it locks."""
        engaged = self.of("e")
        verdict = free_until(self.load, self.beam, engaged)
        if self.end.locks:
            return f"{verdict}, locks at {turned(self.of('end'), self.beam)}"
        if engaged < self.at:
            return f"{verdict}, then {figure(self.stiffer)} times as stiff as the bar"
        return f"{verdict}, beyond the end of the curve" if math.isfinite(engaged) else verdict

    @property
    def figures(self) -> Iterator[tuple[str, str]]:
        """Yield names and values of what decides, a line each; the last says which model it is of."""
        beam, data, load = self.beam, self.data, self.load
        touch = self.of("e") < self.at
        if touch:
            place = "twice that" if self.at == 2 * self.of("e") else "the end of the curve"
            yield "figures at", f"{turned(self.at, beam)}, {place}"
            yield load.torque_words, f"{self._moment(self.there(load.torque))}{self._endless}"
            yield "other ends", self._by_ends
            yield "tangent stiffness", f"{figure(self.stiffer)} times that before contact"
            yield "largest stress in a scale", self._share("stress", "strength", beam.scale.strength)
            yield "largest strain in the bar", self._share("strain", "strain", beam.substrate.strain_limit)
        if self.end is not End.NONE:
            other = f" ({data['other_contact'].item()})" if self.end is End.OTHER else ""
            asked = f"{'as asked' if self.asked else 'the default range'}; nothing locks before"
            why = f": {asked}" if self.end is End.RANGE else f", {self.end}: {SENTENCES[self.end]}{other}"
            yield "end of the curve", f"{turned(self.of('end'), beam)}{why}"
        lost = f"; it takes {percent(float(data['RED_c']))} of the work of the curve" if touch else ""
        sense = "; sense -" if data.attrs.get("sense") == "-" else ""
        yield "friction", f"mu = {float(data['mu']):g}{lost}{sense}"
        yield "model", modelled(beam, data.attrs)

    @property
    def _endless(self) -> str:
        """The endless beam's torque or moment and the ratio of N scales to it, to stand behind that of N scales."""
        there = self.beside.endless.torque if self.beside and self.beside.ends else math.nan
        ratio = self.there(self.load.torque) / there
        return f"; endless beam {self._moment(there)} (ratio {figure(ratio)})" if math.isfinite(there) else ""

    @property
    def _by_ends(self) -> str:
        """The torque or moment of the same scales with other ends; "" where it is not known."""
        others = self.beside.by_ends if self.beside else {}
        there = {ends: self._moment(state.torque) or "the curve ends before" for ends, state in others.items()}
        return ", ".join(f"{torque} {ending(ends)}" for ends, torque in there.items())

    def _moment(self, value: float) -> str:
        """Return a torque or moment (N m) in the unit of the curve's own."""
        factor, unit = torque_unit(self.there(self.load.torque))
        return figure(factor * value, unit)

    def _share(self, name: str, ending: str, limit: float | None) -> str:
        """Return a stress or strain, how much of its limit that is, and where along the curve it comes to the limit."""
        written, missing = (_stress, "scale.strength") if name == "stress" else (percent, "substrate.strain_limit")
        value = self.there(name)
        if not math.isfinite(value):
            return ""
        if limit is None:
            return f"{written(value)}; {missing} is not given"
        reached = self.of(ending)
        where = f"; reached at {turned(reached, self.beam)}" if math.isfinite(reached) else ""
        return f"{written(value)}, {percent(value / limit)} of the limit, {written(limit)}{where}"
