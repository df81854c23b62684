"""Which solids go into which file, where they stand in it, and what is measured of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from squama.fabrication import bodies, mesh
from squama.fabrication.bodies import Recipe
from squama.fabrication.formats import Placed
from squama.fabrication.kinds import PartName
from squama.fabrication.mesh import Check
from squama.fabrication.plan import Plan, between

SPACING = 2.0
"""Between scales that are laid out for the printer, mm."""


class Solids(NamedTuple):
    """All solids of an export: ``files`` by name without ending, numbers of the parts, and what was measured."""

    files: dict[str, list[Placed]]
    counts: list[tuple[Recipe, int]]
    checks: list[Check]


def make(plan: Plan, parts: Sequence[PartName]) -> Solids:
    """Return the solids of the parts that are asked for, measured."""
    files: dict[str, list[Placed]] = {}
    counts: list[tuple[Recipe, int]] = []
    checks: list[Check] = []

    def built(recipe: Recipe, number: int) -> Placed:
        made = Placed(recipe.name, recipe, mesh.build(recipe))
        checks.extend(mesh.solid(recipe, made.mesh))
        counts.append((recipe, number))
        return made

    if {"scale", "assembly"} & set(parts):
        flat = built(bodies.scale(plan), plan.pieces)
    if "scale" in parts:
        files |= {"scale": [flat], **dict(_plates(plan, flat))}
    if {"substrate", "assembly"} & set(parts):
        bar = built(bodies.substrate(plan), 1)
        checks += [check for half in mesh.halves(plan, bar.mesh) for check in mesh.slots(plan, half)]
    if "substrate" in parts:
        files["substrate"] = [bar]
    if "mould" in parts:
        pieces = [built(recipe, 1) for recipe in (*bodies.trays(plan), *bodies.lids(plan))]
        knife = built(bodies.blade(plan), plan.scales)
        # put down on the bed with its corner at 0
        files |= {one.name: [one._replace(shift=-one.mesh.bounds[0])] for one in pieces}
        files |= {"blade": [knife], "mould": [*pieces, *_seated(plan, knife, plan.slot[2])]}
        checks += mesh.slits(plan, [one.mesh for one in pieces if one.name.startswith("lid")])
        checks.append(mesh.overlaps([one.seated for one in files["mould"]], "mould"))
    if "assembly" in parts:
        files["assembly"] = [bar, *_seated(plan, flat, plan.thickness)]
        checks += _fitted(plan, [one.seated for one in files["assembly"]])
    return Solids(files, counts, checks)


def _fitted(plan: Plan, solids: list[mesh.Mesh]) -> Iterator[Check]:
    """Measure the assembled beam: the substrate and its scales."""
    body, *seated = solids
    for i, one in enumerate(seated):
        yield from mesh.scale(plan, mesh.upright(plan, one, i // plan.scales))
    yield mesh.overlaps(solids, "assembly")
    found = mesh.gap(body, seated, 2 * max(plan.clearance, plan.thickness))
    yield Check("gap between scales and substrate", "assembly", plan.clearance, found, "mm", mesh.LENGTH)
    t = plan.thickness / 2
    sides = np.array([(-plan.embedded, -t), (plan.length, -t), (plan.length, t), (-plan.embedded, t)])
    expected = between(plan, sides, plan.breadth)
    for one, other in (seated[i : i + 2] for i in range(0, plan.pieces, plan.scales) if plan.scales > 1):
        found = mesh.gap(one, [other], 2 * expected)
        yield Check("gap between neighbouring scales", "assembly", expected, found, "mm", mesh.LENGTH)


def _copies(plan: Plan, one: Placed) -> list[Placed]:
    """Return a plate for each scale of the beam, numbered."""
    digits = len(str(plan.pieces))
    return [one._replace(name=f"{one.name} {i + 1:0{digits}d}") for i in range(plan.pieces)]


def _seated(plan: Plan, flat: Placed, thickness: float) -> list[Placed]:
    """Return flat plates of a thickness, each in its place on the bar."""
    places = (bodies.seat(plan, i, thickness) for i in range(plan.pieces))
    copies = zip(_copies(plan, flat), places, strict=True)
    return [one._replace(turn=turn, shift=shift) for one, (turn, shift) in copies]


def _plates(plan: Plan, flat: Placed) -> Iterator[tuple[str, list[Placed]]]:
    """Lay all scales out flat in rows, on as many beds as it takes."""
    long, wide = plan.length + plan.embedded + SPACING, plan.breadth + SPACING
    rows = max(1, round(sqrt(plan.pieces * wide / long)))
    columns = ceil(plan.pieces / rows)
    if plan.bed is not None:
        room = plan.bed + SPACING
        columns, rows = min(columns, int(room // wide)), int(room // long)
    each, every = rows * columns, _copies(plan, flat)
    places = [np.array([j // columns * long, j % columns * wide, 0.0]) for j in range(each)]
    for i in range(count := ceil(len(every) / each)):
        plate = zip(every[i * each :], places, strict=False)
        yield bodies.numbered("scales", i, count), [one._replace(shift=place) for one, place in plate]
