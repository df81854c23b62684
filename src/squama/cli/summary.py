"""Summaries of all commands: the verdict, the decisive figures, warnings; more on request."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from squama.cli.output import warnings
from squama.loads import ENDLESS, NOTHING, ending, fixed, model
from squama.people import figure, rigidity_unit, turned
from squama.units import number, torque_unit

if TYPE_CHECKING:
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.types import Array

Shown: TypeAlias = "Iterable[str | Table]"
"""Lines and tables of a summary."""


class Summary(NamedTuple):
    """The printed result of a command: figures by name (without empty ones), a table, and more with --full."""

    verdict: str
    figures: Iterable[tuple[str, str]] = ()
    table: Shown = ()
    warnings: str | Iterable[str] = ()
    full: Shown = ()

    def shown(self, *, full: bool = False) -> Iterator[str | Table]:
        """Yield the lines and tables in order."""
        yield f": {self.verdict}"
        rows = [(name, value) for name, value in self.figures if value]
        wide = max((len(name) for name, _ in rows), default=0)
        yield from (f"  {name:{wide}}  {value}" for name, value in rows)
        yield from self.table
        yield from warnings(self.warnings)
        if full:
            yield ""
            yield from self.full


def touching(engaged: float, beam: Beam) -> str:
    """Return the load angle (rad per pitch) at which scales touch as text; "never" for inf."""
    return f"at {turned(engaged, beam)}" if math.isfinite(engaged) else "never"


def largest_stress(stress: Array, beam: Beam) -> str:
    """Return the largest of the stresses (Pa) of all scales as text, with its share of the strength; "" without any."""
    most = float(stress.max())
    if not (math.isfinite(most) and most > 0):
        return ""
    share = f"; {percent(most / beam.scale.strength)} of its strength" if beam.scale.strength else ""
    return f"{figure(1e-6 * most, 'MPa')}, in scale {stress.argmax() + 1}{share}"


def percent(share: float) -> str:
    """Return a share in per cent, with three digits; "below 0.01 %" for less."""
    return "below 0.01 %" if 0 < share < 1e-4 else number(100 * share, "%")


def energy(per_length: float, beam: Beam) -> str:
    """Return an energy per length (J/m) as the text of the energy of the whole beam, or of a pitch."""
    factor, unit = energy_unit(per_length, beam)
    return figure(factor * per_length, unit)


def energy_unit(largest: float, beam: Beam) -> tuple[float, str]:
    """Return factor and unit for an energy per length (J/m): of the whole beam, or per pitch."""
    length, of = (beam.length, "") if beam.scales else (beam.pitch, " per pitch")
    factor, unit = joules(largest * length)
    return factor * length, f"{unit}{of}"


def joules(largest: float) -> tuple[float, str]:
    """Return factor and unit for an energy (J) that match those of a torque: mJ with N mm, J with N m."""
    factor, unit = torque_unit(largest)
    return factor, "mJ" if unit == "N mm" else "J"


def rigidity(value: float) -> str:
    """Return a rigidity or tangent stiffness (N m^2) as text."""
    factor, unit = rigidity_unit(value)
    return figure(factor * value, unit)


def modelled(beam: Beam, attrs: Mapping[str, Any], many: str = "") -> str:
    """Return the model of a result, its scales and the band of its torque as text; ``many``: words for the scales."""
    ends = attrs.get("ends", ENDLESS)
    many = many or ("endless beam" if ends == ENDLESS else f"{beam.extent} {ending(ends)}")
    held = "" if attrs.get("hold", NOTHING) == NOTHING else f"; {fixed(attrs)}"
    band = float(attrs.get("band", math.nan))
    # the accuracy of the joint's law is known in twisting only
    known = "error of the moment not known" if attrs["load"] == "bending" else f"torque to about {100 * band:.2g} %"
    return f"{model(attrs)}; {many}{held}{f'; {known}' if math.isfinite(band) else ''}"
