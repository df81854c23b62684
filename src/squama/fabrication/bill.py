"""Bill of materials: what is needed, how much of it, what it weighs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from squama.fabrication.place import Plan
from squama.fabrication.recipe import Recipe

PLA, SILICONE = 1.24, 1.15
"""Densities in g/cm^3 of printed PLA (solid, without infill) and of silicone (VPS: 1.1 to 1.2)."""


class Row(NamedTuple):
    """One line: ``part``, its ``material``, how it is ``made``, ``number`` of them.

    ``volume`` is that of one in mm^3, ``density`` in g/cm^3.
    """

    part: str
    material: str
    made: str
    number: int
    volume: float
    density: float

    @property
    def mass(self) -> float:
        """Mass of one, g."""
        return self.volume * self.density / 1000

    def record(self) -> dict[str, str | int | float]:
        """Return the row with its products, by the names of the columns."""
        return {
            "part": self.part,
            "material": self.material,
            "made": self.made,
            "count": self.number,
            "volume_mm3": self.volume,
            "total_volume_mm3": self.volume * self.number,
            "density_g_cm3": self.density,
            "mass_g": self.mass,
            "total_mass_g": self.mass * self.number,
        }


def rows(plan: Plan, solids: Sequence[tuple[Recipe, int]], printed: float, cast: float) -> list[Row]:
    """Return the bill of solids, each with its number, and of the silicone that the slots' clearance takes up."""
    found = []
    for solid, count in solids:
        silicone = solid.name == "substrate"
        how = (
            ("silicone", "cast", count, solid.volume, cast)
            if silicone
            else ("PLA", "printed", count, solid.volume, printed)
        )
        found.append(Row(solid.name, *how))
    if any(solid.name == "substrate" for solid, _ in solids) and plan.clearance > 0:
        deep, across, t = plan.slot
        glue = deep * across * t - plan.embedded * plan.breadth * plan.thickness
        found.append(Row("glue in a slot", "silicone", "filled in", plan.scales, glue, cast))
    return found


def table(bill: Sequence[Row]) -> str:
    """Return the bill as CSV."""
    lines = [",".join(bill[0].record())] if bill else []
    lines += [",".join(v if isinstance(v, str) else f"{v:.10g}" for v in row.record().values()) for row in bill]
    return "\n".join(lines) + "\n"
