"""Which solids go into which file, where they stand in it, and what is measured of them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from squama.fabrication import bodies, mesh
from squama.fabrication import measure as measured
from squama.fabrication.bodies import Recipe
from squama.fabrication.formats import Placed
from squama.fabrication.measure import Check
from squama.fabrication.mesh import Mesh
from squama.fabrication.plan import Plan, between
from squama.types import Array

PARTS = ("scale", "substrate", "mould", "assembly")
SPACING = 2.0
"""Between scales that are laid out for the printer, mm."""

Copy = tuple[str, Array, Array]


class Item(NamedTuple):
    """A solid in a file: its ``recipe`` and ``mesh``, and its ``copies``: name, rotation, shift of each."""

    recipe: Recipe
    mesh: Mesh
    copies: list[Copy]

    @property
    def placed(self) -> list[Placed]:
        """The copies where they stand."""
        return [Placed(name, self.mesh, turn, shift) for name, turn, shift in self.copies]


class Solids(NamedTuple):
    """All solids of an export: ``files`` by name without ending, numbers of the parts, and what was measured."""

    files: dict[str, list[Item]]
    counts: list[tuple[Recipe, int]]
    checks: list[Check]


def make(plan: Plan, parts: Sequence[str]) -> Solids:
    """Return the solids of the parts that are asked for, measured."""
    files: dict[str, list[Item]] = {}
    counts: list[tuple[Recipe, int]] = []
    checks: list[Check] = []

    def built(recipe: Recipe) -> Mesh:
        made = mesh.build(recipe)
        checks.extend(measured.solid(recipe, made))
        return made

    scale, bar = bodies.scale(plan), bodies.substrate(plan)
    if {"scale", "assembly"} & set(parts):
        flat = built(scale)
        counts.append((scale, plan.scales))
    if "scale" in parts:
        files["scale"] = [_alone(scale, flat)]
        for name, copies in _plates(plan):
            files[name] = [Item(scale, flat, copies)]
    if {"substrate", "assembly"} & set(parts):
        body = built(bar)
        counts.append((bar, 1))
        checks += measured.slots(plan, body)
    if "substrate" in parts:
        files["substrate"] = [_alone(bar, body)]
    if "mould" in parts:
        pieces = [(r, built(r)) for r in (*bodies.trays(plan), *bodies.lids(plan))]
        knife = bodies.blade(plan)
        edge = built(knife)
        files |= {recipe.name: [_alone(recipe, made, down=True)] for recipe, made in pieces}
        files["blade"] = [_alone(knife, edge)]
        blades = Item(knife, edge, [(n, *bodies.seat(plan, k, plan.slot[2])) for k, n in _names(plan, "blade")])
        files["mould"] = [*(_alone(recipe, made) for recipe, made in pieces), blades]
        counts += [*((recipe, 1) for recipe, _ in pieces), (knife, plan.scales)]
        checks += measured.slits(plan, [made for recipe, made in pieces if recipe.name.startswith("lid")])
        checks.append(measured.overlaps([p.seated for item in files["mould"] for p in item.placed], "mould"))
    if "assembly" in parts:
        scales = Item(scale, flat, [(n, *bodies.seat(plan, k, plan.thickness)) for k, n in _names(plan, "scale")])
        files["assembly"] = [_alone(bar, body), scales]
        checks += _fitted(plan, body, [p.seated for p in scales.placed])
    return Solids(files, counts, checks)


def _fitted(plan: Plan, body: Mesh, seated: list[Mesh]) -> Iterator[Check]:
    """Measure the assembled beam."""
    for one in seated:
        yield from measured.scale(plan, one)
    yield measured.overlaps([body, *seated], "assembly")
    search = 2 * max(plan.clearance, plan.thickness)
    found = measured.gap(body, seated, search)
    yield Check("gap between scales and substrate", "assembly", plan.clearance, found, "mm", measured.LENGTH)
    t = plan.thickness / 2
    sides = np.array([(-plan.embedded, -t), (plan.length, -t), (plan.length, t), (-plan.embedded, t)])
    expected = between(plan, sides, plan.breadth)
    for one, other in itertools.islice(itertools.pairwise(seated), 1):
        found = measured.gap(one, [other], 2 * expected)
        yield Check("gap between neighbouring scales", "assembly", expected, found, "mm", measured.LENGTH)


def _alone(recipe: Recipe, made: Mesh, *, down: bool = False) -> Item:
    """Return a solid as it is, or put down on the bed with its corner at 0."""
    shift = -made.bounds[0] if down else np.zeros(3)
    return Item(recipe, made, [(recipe.name, np.eye(3), shift)])


def _names(plan: Plan, word: str) -> list[tuple[int, str]]:
    digits = len(str(plan.scales))
    return [(k, f"{word} {k + 1:0{digits}d}") for k in range(plan.scales)]


def _plates(plan: Plan) -> Iterator[tuple[str, list[Copy]]]:
    """Lay all scales out flat in rows, on as many beds as it takes."""
    long, wide = plan.length + plan.embedded + SPACING, plan.breadth + SPACING
    rows = max(1, round(sqrt(plan.scales * wide / long)))
    columns = ceil(plan.scales / rows)
    if plan.bed is not None:
        room = plan.bed + SPACING
        columns, rows = min(columns, int(room // wide)), int(room // long)
    each = rows * columns
    named = _names(plan, "scale")
    plates = [named[i : i + each] for i in range(0, len(named), each)]
    for i, plate in enumerate(plates):
        copies = [
            (name, np.eye(3), np.array([j // columns * long, j % columns * wide, 0.0]))
            for j, (_, name) in enumerate(plate)
        ]
        yield bodies.numbered("scales", i, len(plates)), copies
