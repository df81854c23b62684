"""Solids as recipes: the scale with its tab, the substrate with its slots, and the mould.

A recipe is one block with plane faces, less other blocks, and its volume in closed form.

A block is an array (8, 3) of corners in mm: corner 4 i + 2 j + k has the first, second and third coordinate low (0) or
high (1). The coordinate system of the blocks is right-handed.

The mould is a tray, a lid with inclined slits over its scaled face, and blades in the slits that form the slots. All
blades are parallel, so they are drawn out of the cured substrate one by one, or with the lid, along the scales. Tray
and lid are cut into pieces where they are longer than the printer's bed.
"""

from __future__ import annotations

import itertools
from math import ceil, cos, sin, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama.fabrication.plan import Plan
from squama.types import Array

QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""Corners of a block's six faces, counterclockwise seen from outside."""
BENCH = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Rotation from the beam's x, y, z (across, out of the scaled face, along) to along, across, up."""
BEYOND = 1.0
"""Length by which a cut extends beyond its block, mm."""


class Recipe(NamedTuple):
    """A solid: ``name``, the block ``whole``, the blocks ``cuts`` taken from it, ``volume`` in mm^3 in closed form."""

    name: str
    whole: Array
    cuts: tuple[Array, ...]
    volume: float

    def moved(self, turn: Array, shift: ArrayLike = (0.0, 0.0, 0.0)) -> Recipe:
        """Return the solid turned by a rotation matrix (3, 3), then shifted (mm)."""
        whole, *cuts = (block @ turn.T + np.asarray(shift) for block in (self.whole, *self.cuts))
        return self._replace(whole=whole, cuts=tuple(cuts))


def block(low: ArrayLike, high: ArrayLike, axes: Array | None = None, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return a box between two corners given in ``axes`` (rows) from ``origin``."""
    lo, hi = np.asarray(low, float), np.asarray(high, float)
    bits = (np.arange(8)[:, None] >> np.array([2, 1, 0])) & 1
    corners = np.where(bits == 1, hi, lo)
    return np.asarray(corners @ (np.eye(3) if axes is None else axes) + np.asarray(origin, float))


def scale(plan: Plan) -> Recipe:
    """Return one scale lying flat: its length along the first axis, the base at 0, its lower face at height 0."""
    t, b = plan.thickness, plan.breadth / 2
    whole = block((-plan.embedded, -b, 0), (plan.length, b, t))
    return Recipe("scale", whole, (), (plan.length + plan.embedded) * plan.breadth * t)


def seat(plan: Plan, i: int, thickness: float) -> tuple[Array, Array]:
    """Return rotation and shift that move a flat scale or blade to place i on the bar (along, across, up; mm)."""
    axes, base = plan.stands(i)
    turn = BENCH @ axes.T
    low = np.array([0.0, 0.0, -thickness / 2])
    return turn, turn @ low + (BENCH @ base + [0.0, 0.0, plan.height / 2])


def on_bench(plan: Plan, solid: Recipe) -> Recipe:
    """Return a solid of the beam's frame as (along, across, up), the bar's lower face at height 0."""
    return solid.moved(BENCH, (0.0, 0.0, plan.height / 2))


def substrate(plan: Plan) -> Recipe:
    """Return the bar with its ends and slots, the scaled face up.

    The volume of a slot below the face is t (L + c) 2 (b + c) with its thickness t: the face cuts its mouth obliquely,
    with equal gain and loss on both sides of the middle plane.
    """
    deep, across, t = plan.slot
    x, y = plan.width / 2, plan.height / 2
    whole = block((-x, -y, 0), (x, y, plan.total))
    out = t / 2 / tan(plan.theta0) + t + 1
    cuts = [block((-deep, -across / 2, -t / 2), (out, across / 2, t / 2), *plan.stands(i)) for i in range(plan.pieces)]
    volume = plan.width * plan.height * plan.total - plan.pieces * deep * across * t
    return on_bench(plan, Recipe("substrate", whole, tuple(cuts), volume))


class Lid(NamedTuple):
    """Sizes of the lid, mm: half widths inside and outside its skirts, their depth, and coordinates of its ends."""

    inner: float
    outer: float
    skirt: float
    low: float
    high: float


class Seam(NamedTuple):
    """A plane end of a piece of the lid, mm.

    ``place``: coordinate along the bar, in its middle at the scaled face; ``by_x``, ``by_y``: its change across the bar
    and with the height above the face; ``before``: number of scales before it.
    """

    place: float
    by_x: float
    by_y: float
    before: int

    def at(self, x: float, y: float) -> float:
        """Return the coordinate along the bar at x across and y above the face."""
        return self.place + x * self.by_x + y * self.by_y


def lid_sizes(plan: Plan) -> Lid:
    """Return the sizes of the lid; the bar's ends stay open for pouring."""
    inner = tray_half(plan) + plan.clearance
    slit = plan.corners(plan.slit_profile, plan.slit[0])
    head = plan.corners(np.array([(plan.shank, 0.0)]), plan.blade[1])
    low, high = (float(f([f(slit[:, 2]), f(head[:, 2])])) for f in (np.min, np.max))
    outer = max(inner, float(np.abs(slit[:, 0]).max())) + plan.wall
    last = (plan.scales - 1) * plan.pitch
    return Lid(inner, outer, min(plan.wall, plan.height / 2), low - plan.wall, high + last + plan.wall)


def tray_half(plan: Plan) -> float:
    """Return half the outer width of the tray."""
    return plan.width / 2 + plan.height / 2 * tan(plan.draft) + plan.wall


def blade(plan: Plan) -> Recipe:
    """Return a blade lying flat: its shank has the slot's width and thickness, its head rests on the lid."""
    deep, across, t = plan.slot
    _, wide, _ = plan.blade
    end, side = plan.blade[0] - deep, wide / 2 + BEYOND
    whole = block((-deep, -wide / 2, 0), (end, wide / 2, t))
    beside = ((across / 2, side), (-side, -across / 2))
    cuts = tuple(block((-deep - BEYOND, a, -BEYOND), (plan.shank, b, t + BEYOND)) for a, b in beside)
    volume = t * (wide * (end - plan.shank) + across * (plan.shank + deep))
    return Recipe("blade", whole, cuts, volume)


def trays(plan: Plan) -> list[Recipe]:
    """Return the tray with the bar's cavity in its place on the bench, in pieces that fit on the bed.

    With a draft the cavity has the size of the bar at middle height, so its sections have the bar's area.
    """
    slope, y, half = tan(plan.draft), plan.height / 2, tray_half(plan)
    over = y * slope + plan.wall
    start, stop = -over, plan.total + over
    pieces = 1 if plan.bed is None else ceil((stop - start) / plan.bed * (1 - 1e-12))
    grow = (-y * slope, (y + BEYOND) * slope)
    sides = [(-plan.width / 2 - g, plan.width / 2 + g) for g in grow]
    found = []
    for i, (low, high) in enumerate(itertools.pairwise(np.linspace(start, stop, pieces + 1).tolist())):
        first, last = i == 0, i == pieces - 1
        along = [(-g if first else low - BEYOND, plan.total + g if last else high + BEYOND) for g in grow]
        whole = block((-half, -y - plan.wall, low), (half, y, high))
        # exact for plane sides: prismatoid formula with bottom, middle and rim
        levels = (-y * slope, 0.0, y * slope)
        lengths = [(plan.total + g if last else high) - (-g if first else low) for g in levels]
        floor, middle, rim = ((plan.width + 2 * g) * length for g, length in zip(levels, lengths, strict=True))
        cavity = plan.height * (floor + 4 * middle + rim) / 6
        volume = 2 * half * (plan.height + plan.wall) * (high - low) - cavity
        hollow = np.array([(sides[j][i], (-y, y + BEYOND)[j], along[j][k]) for i, j, k in np.ndindex(2, 2, 2)])
        found.append(on_bench(plan, Recipe(numbered("tray", i, pieces), whole, (hollow,), volume)))
    return found


def lids(plan: Plan) -> list[Recipe]:
    """Return the lid in its place on the bench, in pieces that fit on the bed; no slit is cut."""
    lid, y = lid_sizes(plan), plan.height / 2
    area = 2 * lid.outer * (plan.wall + lid.skirt) - 2 * lid.inner * lid.skirt
    # height of the section's centroid above the face: plate and skirts
    skirts = 2 * (lid.outer - lid.inner) * lid.skirt
    middle = (2 * lid.outer * plan.wall * plan.wall - skirts * lid.skirt) / 2 / area
    x, high = (-lid.outer, lid.outer), (-lid.skirt, plan.wall)
    # a slit is an oblique prism
    across, t = plan.slit
    oblique = across * t * plan.wall / sin(plan.theta0)
    out, top = t / 2 / tan(plan.theta0) + BEYOND, (plan.wall + t / 2 * cos(plan.theta0)) / sin(plan.theta0) + BEYOND
    slit = block((-out, -across / 2, -t / 2), (top, across / 2, t / 2), plan.axes)
    seams = _between(plan, lid, lid_counts(plan) or [plan.scales])
    pieces = []
    for i, (front, back) in enumerate(itertools.pairwise(seams)):
        whole = np.array([(px, y + py, seam.at(px, py)) for px in x for py in high for seam in (front, back)])
        far = (whole[:, 2].min() - BEYOND, whole[:, 2].max() + BEYOND)
        channel = block((-lid.inner, y - lid.skirt - BEYOND, far[0]), (lid.inner, y, far[1]))
        cuts = (channel, *(slit + plan.base(k) for k in range(front.before, back.before)))
        # the ends are planes, so their distance at the section's centroid gives the volume
        volume = area * (back.at(0, middle) - front.at(0, middle)) - (back.before - front.before) * oblique
        pieces.append(on_bench(plan, Recipe(numbered("lid", i, len(seams) - 1), whole, cuts, volume)))
    return pieces


def seam(plan: Plan) -> Seam | None:
    """Return the cut behind scale 0, relative to its base; None without room between the slits.

    Upright and along the scales' width where the slits of neighbours do not overlap along the bar; otherwise in the
    oblique plane between the slits.
    """
    corners = plan.corners(plan.slit_profile, plan.slit[0]) - plan.base(0)
    slope = tan(plan.alpha)
    along = corners[:, 2] - corners[:, 0] * slope
    if (plan.pitch - np.ptp(along)) / 2 * cos(plan.alpha) >= plan.feature:
        return Seam(float(along.min() + along.max() + plan.pitch) / 2, slope, 0.0, 1)
    if (plan.pitch * plan.slope - plan.slit[1]) / 2 >= plan.feature:
        return Seam(plan.pitch / 2, slope, 1 / (tan(plan.theta0) * cos(plan.alpha)), 1)
    return None


def lid_counts(plan: Plan) -> list[int] | None:
    """Return the number of scales of each piece of the lid; None if no division fits on the bed."""
    lid = lid_sizes(plan)
    if plan.bed is None or lid.high - lid.low <= plan.bed:
        return [plan.scales]
    if seam(plan) is None:
        return None
    corners = [(x, y) for x in (-lid.outer, lid.outer) for y in (-lid.skirt, plan.wall)]
    for pieces in range(2, plan.scales + 1):
        counts = [len(part) for part in np.array_split(np.arange(plan.scales), pieces)]
        ends = np.array([[one.at(x, y) for x, y in corners] for one in _between(plan, lid, counts)])
        longest = (ends[1:].max(axis=1) - ends[:-1].min(axis=1)).max()
        if longest <= plan.bed and (ends[1:] - ends[:-1]).min() >= plan.wall:
            return counts
    return None


def _between(plan: Plan, lid: Lid, counts: list[int]) -> list[Seam]:
    """Return the ends of pieces with these numbers of scales, from front to back."""
    found = [Seam(lid.low, 0.0, 0.0, 0)]
    one = seam(plan)
    for k in map(int, np.cumsum(counts)[:-1]):
        assert one is not None
        found.append(one._replace(place=float(plan.base(k - 1)[2]) + one.place, before=k))
    return [*found, Seam(lid.high, 0.0, 0.0, plan.scales)]


def numbered(word: str, i: int, n: int) -> str:
    """Return the name of the i-th of n pieces; for a single piece the word alone."""
    return word if n == 1 else f"{word}-{i + 1:0{len(str(n))}d}"
