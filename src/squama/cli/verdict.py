"""The verdict on a twisted or bent beam: free range, stiffness beyond it, loads and stresses, end of the curve."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama.cli.output import modelled, percent
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
    """Return up to which load angle (rad per pitch) the scales do not touch, as text."""
    if not math.isfinite(engaged):
        return f"the scales never touch: {load.done}, the beam is as soft as without contact"
    return f"free until {turned(engaged, beam)}" if engaged else "the scales touch before anything is loaded"


class Curve(NamedTuple):
    """A curve of a beam; ``asked``: whether its end was given; ``beside``: simpler beams for comparison, if known."""

    load: Load
    beam: Beam
    data: Answer
    asked: bool
    beside: Bench | None = None

    @property
    def end(self) -> End:
        """End of the curve."""
        return End(self.data["end"].item())

    def of(self, name: str) -> float:
        """Return a single figure of the load angle (rad per pitch): "e" at engagement, "end", "strength", "strain"."""
        return float(self.data[f"{self.load.angle}_{name}"])

    @property
    def at(self) -> float:
        """Load angle (rad per pitch) of the figures: the end if it was given, or twice the engagement."""
        x, known = self.data[self.load.angle], np.isfinite(self.data[self.load.torque])
        last, twice = float(x[known].max(initial=0.0)), 2 * self.of("e")
        return twice if twice <= last and not self.asked else last

    def there(self, name: str) -> float:
        """Return a variable at that load angle (stress, strain: the larger of both faces); NaN if missing."""
        curves = self.data.curves
        if name not in curves:
            return math.nan
        known = np.isfinite(curves[self.load.torque])
        along = worst(curves, name) if name in ("stress", "strain") else curves[name]
        return float(np.interp(self.at, curves[self.load.angle][known], along[known]))

    @property
    def stiffer(self) -> float:
        """Tangent stiffness at that load angle over that before contact."""
        if "stiffness_ratio" in self.data.variables:
            return self.there("stiffness_ratio")
        return self.there(self.load.tangent) / self.load.rigidity(self.beam)

    @property
    def verdict(self) -> str:
        """Free range and stiffness beyond it, or the lock, as text."""
        engaged = self.of("e")
        verdict = free_until(self.load, self.beam, engaged)
        if self.end.locks:
            return f"{verdict}, locks at {turned(self.of('end'), self.beam)}"
        if engaged < self.at:
            return f"{verdict}, then {figure(self.stiffer)} times as stiff as the bar"
        return f"{verdict}, beyond the end of the curve" if math.isfinite(engaged) else verdict

    @property
    def figures(self) -> Iterator[tuple[str, str]]:
        """Yield names and values of the decisive figures, a line each; the last is the model."""
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
        """The torque or moment of the endless beam and its ratio, to follow that of N scales; or ""."""
        there = self.beside.endless.torque if self.beside and self.beside.ends else math.nan
        ratio = self.there(self.load.torque) / there
        return f"; endless beam {self._moment(there)} (ratio {figure(ratio)})" if math.isfinite(there) else ""

    @property
    def _by_ends(self) -> str:
        """The torque or moment of the same scales with other ends; "" if unknown."""
        others = self.beside.by_ends if self.beside else {}
        there = {ends: self._moment(state.torque) or "the curve ends before" for ends, state in others.items()}
        return ", ".join(f"{torque} {ending(ends)}" for ends, torque in there.items())

    def _moment(self, value: float) -> str:
        """Return a torque or moment (N m) in the unit of the curve's figure."""
        factor, unit = torque_unit(self.there(self.load.torque))
        return figure(factor * value, unit)

    def _share(self, name: str, ending: str, limit: float | None) -> str:
        """Return a stress or strain, its share of the limit, and the load angle where it reaches the limit, as text."""
        written, missing = (_stress, "scale.strength") if name == "stress" else (percent, "substrate.strain_limit")
        value = self.there(name)
        if not math.isfinite(value):
            return ""
        if limit is None:
            return f"{written(value)}; {missing} is not given"
        reached = self.of(ending)
        where = f"; reached at {turned(reached, self.beam)}" if math.isfinite(reached) else ""
        return f"{written(value)}, {percent(value / limit)} of the limit, {written(limit)}{where}"
