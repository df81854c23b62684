"""The mould: a tray, a lid with inclined slits over its scaled face, and blades in the slits that form the slots.

All blades are parallel, so they are drawn out of the cured substrate one by one, or with the lid, along the scales.
Tray and lid are cut into pieces where they are longer than the printer's bed.
"""

from __future__ import annotations

from math import ceil, cos, sin, tan
from typing import NamedTuple

import numpy as np

from squama.fabrication.bodies import on_bench
from squama.fabrication.place import Plan
from squama.fabrication.recipe import Array, Recipe, block, skewed, tapered

BEYOND = 1.0
"""How far a cut goes beyond the block it is taken from, mm."""


class Lid(NamedTuple):
    """Sizes of the lid in mm.

    Half the ``inner`` width between its skirts, half its ``outer`` width, the depth of its ``skirt``, and where it
    begins and ends along the bar (``low``, ``high``).
    """

    inner: float
    outer: float
    skirt: float
    low: float
    high: float


def lid_sizes(plan: Plan) -> Lid:
    """Return the sizes of the lid; what is left open at the bar's ends is for pouring."""
    inner = tray_half(plan) + plan.clearance
    corners = [plan.corners(plan.slit_profile, plan.slit[0], k) for k in (0, plan.scales - 1)]
    heads = [plan.corners(np.array([(plan.shank, 0.0)]), plan.blade[1], k) for k in (0, plan.scales - 1)]
    reach = float(np.abs(corners[0][:, 0]).max())
    low = min(float(points[:, 2].min()) for points in (corners[0], heads[0]))
    high = max(float(points[:, 2].max()) for points in (corners[1], heads[1]))
    outer = max(inner, reach) + plan.wall
    return Lid(inner, outer, min(2 * plan.wall, plan.height / 2), low - plan.wall, high + plan.wall)


def tray_half(plan: Plan) -> float:
    """Return half the outer width of the tray."""
    return plan.width / 2 + plan.height / 2 * tan(plan.draft) + plan.wall


def blade(plan: Plan) -> Recipe:
    """Return a blade lying flat: its shank has the slot's width and thickness, its head rests on the lid."""
    deep, across, t = plan.slot
    _, wide, _ = plan.blade
    end = plan.blade[0] - deep
    whole = block((-deep, -wide / 2, 0), (end, wide / 2, t))
    low, high = (-deep - BEYOND, -BEYOND), (plan.shank, t + BEYOND)
    side = wide / 2 + BEYOND
    cuts = (
        block((low[0], across / 2, low[1]), (high[0], side, high[1])),
        block((low[0], -side, low[1]), (high[0], -across / 2, high[1])),
    )
    volume = t * (wide * (end - plan.shank) + across * (plan.shank + deep))
    return Recipe("blade", whole, cuts, volume)


def trays(plan: Plan) -> list[Recipe]:
    """Return the tray with the bar's cavity in its place on the bench, in pieces that fit on the bed.

    With a draft the cavity has the bar's own size in the middle of its height, so its sections keep the bar's area.
    """
    slope, y, half = tan(plan.draft), plan.height / 2, tray_half(plan)
    over = y * slope + plan.wall
    start, stop = -over, plan.total + over
    cuts = np.linspace(start, stop, _count(plan, stop - start) + 1)
    top = y + BEYOND
    grow = (-y * slope, top * slope)
    sides = [(-plan.width / 2 - g, plan.width / 2 + g) for g in grow]
    found = []
    for i in range(cuts.size - 1):
        low, high = float(cuts[i]), float(cuts[i + 1])
        first, last = i == 0, i == cuts.size - 2
        along = [(-g if first else low - BEYOND, plan.total + g if last else high + BEYOND) for g in grow]
        whole = block((-half, -y - plan.wall, low), (half, y, high))
        # exact for sides that are plane: prismatoid over bottom, middle and rim
        areas = []
        for g in (-y * slope, 0.0, y * slope):
            length = (plan.total + g if last else high) - (-g if first else low)
            areas.append((plan.width + 2 * g) * length)
        cavity = plan.height * (areas[0] + 4 * areas[1] + areas[2]) / 6
        volume = 2 * half * (plan.height + plan.wall) * (high - low) - cavity
        solid = Recipe(_name("tray", i, cuts.size - 1), whole, (tapered(sides, (-y, top), along),), volume)
        found.append(on_bench(plan, solid))
    return found


def lids(plan: Plan) -> list[Recipe]:
    """Return the lid in its place on the bench, in pieces that fit on the bed; a slit is never cut."""
    lid, y = lid_sizes(plan), plan.height / 2
    slope = tan(plan.alpha)
    seams = _seams(plan, lid)
    pieces = []
    for i in range(len(seams) - 1):
        (low, low_slope, k0), (high, high_slope, k1) = seams[i], seams[i + 1]
        x = (-lid.outer, lid.outer)
        z = [(low + low_slope * slope * s, high + high_slope * slope * s) for s in x]
        whole = skewed(x, (y - lid.skirt, y + plan.wall), z)
        far = [(min(map(min, z)) - BEYOND, max(map(max, z)) + BEYOND)] * 2
        channel = skewed((-lid.inner, lid.inner), (y - lid.skirt - BEYOND, y), far)
        cuts = [channel, *(_slit(plan, k) for k in range(k0, k1))]
        area = 2 * lid.outer * (plan.wall + lid.skirt) - 2 * lid.inner * lid.skirt
        volume = area * (high - low) - (k1 - k0) * slit_volume(plan)
        pieces.append(on_bench(plan, Recipe(_name("lid", i, len(seams) - 1), whole, tuple(cuts), volume)))
    return pieces


def slit_volume(plan: Plan) -> float:
    """Return the volume of a slit of the lid: an oblique prism."""
    across, t = plan.slit
    return across * t * plan.wall / sin(plan.theta0)


def _slit(plan: Plan, k: int) -> Array:
    across, t = plan.slit
    out = t / 2 / tan(plan.theta0) + BEYOND
    top = (plan.wall + t / 2 * cos(plan.theta0)) / sin(plan.theta0) + BEYOND
    return block((-out, -across / 2, -t / 2), (top, across / 2, t / 2), plan.axes, plan.base(k))


def seam_place(plan: Plan) -> float:
    """Return where the lid may be cut behind a scale: c of the plane z - x tan(alpha) = base + c, mm."""
    corners = plan.corners(plan.slit_profile, plan.slit[0]) - plan.base(0)
    along = corners[:, 2] - corners[:, 0] * tan(plan.alpha)
    return float((along.min() + along.max() + plan.pitch) / 2)


def seam_wall(plan: Plan) -> float:
    """Return the material of the lid between a slit and a cut behind it, mm; below 0 the slit is cut."""
    corners = plan.corners(plan.slit_profile, plan.slit[0])
    along = corners[:, 2] - corners[:, 0] * tan(plan.alpha)
    return float((plan.pitch - np.ptp(along)) / 2 * cos(plan.alpha))


def lid_counts(plan: Plan) -> list[int] | None:
    """Return how many scales each piece of the lid has; None if no number fits on the bed."""
    lid = lid_sizes(plan)
    if plan.bed is None or lid.high - lid.low <= plan.bed:
        return [plan.scales]
    skew = lid.outer * tan(plan.alpha)
    for pieces in range(2, plan.scales + 1):
        counts = [len(part) for part in np.array_split(np.arange(plan.scales), pieces)]
        places = np.array([lid.low, *(_cut(plan, int(k)) for k in np.cumsum(counts)[:-1]), lid.high])
        middle = np.diff(places)
        # a piece inside has two skewed ends, the first and the last have one
        longest = max(middle[[0, -1]].max() + skew, (middle[1:-1] + 2 * skew).max(initial=0.0))
        if longest <= plan.bed and middle[[0, -1]].min() - skew >= plan.wall:
            return counts
    return None


def _cut(plan: Plan, k: int) -> float:
    """Return the place of the cut before scale k where it crosses the bar's middle."""
    return float(plan.base(k - 1)[2]) + seam_place(plan)


def _seams(plan: Plan, lid: Lid) -> list[tuple[float, float, int]]:
    """Return the ends of the lid's pieces: place at x = 0, whether skewed (0 or 1), number of scales before it."""
    counts = lid_counts(plan) or [plan.scales]
    inner = [(_cut(plan, int(k)), 1.0, int(k)) for k in np.cumsum(counts)[:-1]]
    return [(lid.low, 0.0, 0), *inner, (lid.high, 0.0, plan.scales)]


def _count(plan: Plan, length: float) -> int:
    return 1 if plan.bed is None else ceil(length / plan.bed * (1 - 1e-12))


def _name(word: str, i: int, n: int) -> str:
    return word if n == 1 else f"{word}-{i + 1:0{len(str(n))}d}"
