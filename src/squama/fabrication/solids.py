"""Which solids go into which file, where they stand in it, and what is measured of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from squama.fabrication import bodies, mesh
from squama.fabrication.bodies import Recipe
from squama.fabrication.formats import Placed
from squama.fabrication.mesh import Check, Mesh
from squama.fabrication.plan import Plan, between
from squama.types import Array

PARTS = ("scale", "substrate", "mould", "assembly")
SPACING = 2.0
"""Between scales that are laid out for the printer, mm."""


class Item(NamedTuple):
    """A solid in a file: its ``recipe``, and its copies where they are ``placed``."""

    recipe: Recipe
    placed: list[Placed]


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
        checks.extend(mesh.solid(recipe, made))
        return made

    scale, bar = bodies.scale(plan), bodies.substrate(plan)
    if {"scale", "assembly"} & set(parts):
        flat = built(scale)
        counts.append((scale, plan.pieces))
    if "scale" in parts:
        files["scale"] = [_alone(scale, flat)]
        files |= {name: [Item(scale, placed)] for name, placed in _plates(plan, flat)}
    if {"substrate", "assembly"} & set(parts):
        body = built(bar)
        counts.append((bar, 1))
        checks += [check for half in mesh.halves(plan, body) for check in mesh.slots(plan, half)]
    if "substrate" in parts:
        files["substrate"] = [_alone(bar, body)]
    if "mould" in parts:
        pieces = [(r, built(r)) for r in (*bodies.trays(plan), *bodies.lids(plan))]
        knife = bodies.blade(plan)
        edge = built(knife)
        # put down on the bed with its corner at 0
        files |= {recipe.name: [_alone(recipe, made, -made.bounds[0])] for recipe, made in pieces}
        files["blade"] = [_alone(knife, edge)]
        blades = _seated(plan, "blade", knife, edge, plan.slot[2])
        files["mould"] = [*(_alone(recipe, made) for recipe, made in pieces), blades]
        counts += [*((recipe, 1) for recipe, _ in pieces), (knife, plan.scales)]
        checks += mesh.slits(plan, [made for recipe, made in pieces if recipe.name.startswith("lid")])
        checks.append(mesh.overlaps([p.seated for item in files["mould"] for p in item.placed], "mould"))
    if "assembly" in parts:
        scales = _seated(plan, "scale", scale, flat, plan.thickness)
        files["assembly"] = [_alone(bar, body), scales]
        checks += _fitted(plan, body, [p.seated for p in scales.placed])
    return Solids(files, counts, checks)


def _fitted(plan: Plan, body: Mesh, seated: list[Mesh]) -> Iterator[Check]:
    """Measure the assembled beam."""
    for i, one in enumerate(seated):
        yield from mesh.scale(plan, mesh.upright(plan, one, i // plan.scales))
    yield mesh.overlaps([body, *seated], "assembly")
    search = 2 * max(plan.clearance, plan.thickness)
    found = mesh.gap(body, seated, search)
    yield Check("gap between scales and substrate", "assembly", plan.clearance, found, "mm", mesh.LENGTH)
    t = plan.thickness / 2
    sides = np.array([(-plan.embedded, -t), (plan.length, -t), (plan.length, t), (-plan.embedded, t)])
    expected = between(plan, sides, plan.breadth)
    for one, other in (seated[i : i + 2] for i in range(0, plan.pieces, plan.scales) if plan.scales > 1):
        found = mesh.gap(one, [other], 2 * expected)
        yield Check("gap between neighbouring scales", "assembly", expected, found, "mm", mesh.LENGTH)


def _alone(recipe: Recipe, made: Mesh, shift: Array | None = None) -> Item:
    """Return a solid as it is, or moved."""
    return Item(recipe, [Placed(recipe.name, made, np.eye(3), np.zeros(3) if shift is None else shift)])


def _names(plan: Plan, word: str) -> list[str]:
    digits = len(str(plan.pieces))
    return [f"{word} {i + 1:0{digits}d}" for i in range(plan.pieces)]


def _seated(plan: Plan, word: str, recipe: Recipe, made: Mesh, thickness: float) -> Item:
    """Return flat plates of a thickness, each in its place on the bar."""
    places = (bodies.seat(plan, i, thickness) for i in range(plan.pieces))
    return Item(recipe, [Placed(n, made, *place) for n, place in zip(_names(plan, word), places, strict=True)])


def _plates(plan: Plan, flat: Mesh) -> Iterator[tuple[str, list[Placed]]]:
    """Lay all scales out flat in rows, on as many beds as it takes."""
    long, wide = plan.length + plan.embedded + SPACING, plan.breadth + SPACING
    rows = max(1, round(sqrt(plan.pieces * wide / long)))
    columns = ceil(plan.pieces / rows)
    if plan.bed is not None:
        room = plan.bed + SPACING
        columns, rows = min(columns, int(room // wide)), int(room // long)
    each, named = rows * columns, _names(plan, "scale")
    places = [np.array([j // columns * long, j % columns * wide, 0.0]) for j in range(each)]
    for i in range(count := ceil(len(named) / each)):
        plate = zip(named[i * each :], places, strict=False)
        yield bodies.numbered("scales", i, count), [Placed(name, flat, np.eye(3), place) for name, place in plate]
