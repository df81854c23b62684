"""Rules of printing, casting and assembly: the dimension that breaks a rule, and the remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import cos, degrees, sin, tan

import numpy as np
from scipy.optimize import bisect

from squama.errors import InputError, Problem
from squama.fabrication import bodies
from squama.fabrication.kinds import parts_for
from squama.fabrication.plan import Plan, between

SLACK = 1e-9
"""Rounding error of sizes that still fit, mm."""


def check(plan: Plan, parts: tuple[str, ...]) -> None:
    """Refuse a plan that breaks rules, all causes together; the mould has further rules."""
    found = [*_scale(plan), *_section(plan), *_along(plan), *_at_rest(plan)]
    if not {*parts} <= {*parts_for(plan.faces)}:
        reason = "casts the slots of one face, and scales are on both"
        found.append(Problem("parts", '"mould"', reason, 'write e.g. "scale,substrate,assembly"'))
    if "mould" in parts and not found:
        found += _mould(plan)
    if found:
        raise InputError(*found)


def _scale(plan: Plan) -> Iterator[Problem]:
    """Yield problems of a single scale."""
    reason, remedy = "is less than the least size that can be printed", f"write at least {mm(plan.feature)}"
    for name, size in (("thickness", plan.thickness), ("width", plan.breadth), ("length", plan.length)):
        if size < plan.feature - SLACK:
            yield Problem(f"scale.{name}", mm(size), reason, f"{remedy}, or a smaller feature")
    width = "scale.width", mm(plan.breadth)
    if plan.breadth <= plan.thickness:
        yield Problem(*width, f"is no more than the thickness, {mm(plan.thickness)}", "write a plate")
    if plan.bed is not None and plan.length + plan.embedded > plan.bed + SLACK:
        reason = f"with its tab of {mm(plan.embedded)} the scale is longer than the bed, {mm(plan.bed)}"
        remedy = _at_most(plan.bed - plan.embedded, "embed less of it")
        yield Problem("scale.length", mm(plan.length), reason, remedy)
    if plan.bed is not None and plan.breadth > plan.bed + SLACK:
        yield Problem(*width, "is wider than the bed", f"write at most {mm(plan.bed)}")


def _section(plan: Plan) -> Iterator[Problem]:
    """Yield problems of the slot in the bar's section: closed over the tab, inside the sides, above the lower face."""
    deep, _, t = plan.slot
    th, a = plan.theta0, plan.alpha
    embedded, width = ("scale.embedded", mm(plan.embedded)), ("scale.width", mm(plan.breadth))
    closes = t / 2 / tan(th)
    if deep < closes + plan.feature - SLACK:
        reason = f"the substrate does not close over the tab, whose slot is {mm(t)} thick"
        least = mm_up(closes + plan.feature - plan.clearance)
        yield Problem(*embedded, reason, f"write at least {least}, or a larger scale.theta0")
    depth = deep * sin(th) + t / 2 * cos(th)
    own = plan.height / len(plan.sides)
    room = own - plan.feature / len(plan.sides)
    if depth > room + SLACK:
        through = "goes through the substrate" if plan.faces == "one" else "comes to those of the other face"
        reason = f"the slot {through}, it is {mm(depth)} deep in {mm(own)}"
        most = (room - t / 2 * cos(th)) / sin(th) - plan.clearance
        yield Problem(*embedded, reason, _at_most(most, "write a thicker substrate"))
    across = plan.breadth * cos(a)
    reach = float(np.abs(plan.corners(plan.slot_profile, plan.slot[1])[:, 0]).max())
    free = plan.width / 2 - plan.feature
    narrower = _at_most(plan.breadth + 2 * (free - reach) / cos(a), "write a wider substrate")
    if across > plan.width + SLACK:
        reason = f"the scale is wider than the bar, 2 b cos(alpha) = {mm(across)} against {mm(plan.width)}"
        yield Problem(*width, reason, narrower)
    elif reach > free + SLACK:
        reason = f"it reaches {mm(reach)} from the middle, half the bar is {mm(plan.width / 2)}"
        wider = f"or a substrate.width of at least {mm_up(2 * (reach + plan.feature))}"
        yield Problem(*width, f"the slot opens at the bar's side, {reason}", f"{narrower}, {wider}")


def _along(plan: Plan) -> Iterator[Problem]:
    """Yield problems of neighbouring slots, and of the bar's ends."""
    slots = "the slots of neighbouring tabs {} in the bar", "or a smaller scale.embedded or clearance"
    yield from _ligament(plan, lambda p: between(p, p.slot_profile, p.slot[1]), *slots)
    along = plan.corners(plan.slot_profile, plan.slot[1])[:, 2]
    last = (plan.scales - 1) * plan.pitch + max(shift for _, shift in plan.sides)
    short = plan.feature - min(float(along.min()), plan.total - last - float(along.max()))
    if short > SLACK:
        remedy = f"write at least {mm_up(plan.ends + short)}"
        yield Problem("ends", mm(plan.ends), "a slot opens at the bar's end", remedy)


def _at_rest(plan: Plan) -> Iterator[Problem]:
    """Yield problems of neighbouring plates of true thickness; as parallel plates they separate along own axes only."""
    x, y, z = plan.step
    lift, gap = plan.pitch * plan.slope, abs(z) - plan.thickness
    # the next scale is the nearest
    if plan.scales > 1 and x < plan.length + plan.embedded and y < plan.breadth and gap < plan.clearance - SLACK:
        words = "lie in each other" if gap < 0 else f"are only {mm(gap)} apart"
        reason = f"{words} at rest, the pitch lifts them by d sin(theta0) cos(alpha) = {mm(lift)}"
        thinner = _at_most(lift - plan.clearance, "write a larger scale.theta0")
        remedy = f"{thinner}, or a beam.pitch of at least {mm_up((plan.thickness + plan.clearance) / plan.slope)}"
        yield Problem("scale.thickness", mm(plan.thickness), f"neighbouring scales {reason}", remedy)


def _mould(plan: Plan) -> Iterator[Problem]:
    """Yield problems of tray, blades and lid."""
    if plan.wall < plan.feature - SLACK:
        reason = "is less than the least size that can be printed"
        yield Problem("wall", mm(plan.wall), reason, f"write at least {mm(plan.feature)}")
    draft = "draft", f"{degrees(plan.draft):.4g} deg"
    rest = plan.width - plan.height * tan(plan.draft)
    if rest < plan.feature:
        yield Problem(*draft, f"leaves {mm(rest)} of the tray's floor", "write a smaller one")
        return
    corners = plan.corners(plan.slot_profile, plan.slot[1])
    inside = plan.width / 2 + corners[:, 1] * tan(plan.draft) - np.abs(corners[:, 0])
    if inside.min() < plan.feature - SLACK:
        at = corners[inside.argmin()]
        most = (plan.width / 2 - abs(at[0]) - plan.feature) / max(-at[1], SLACK)
        steepest = np.floor(degrees(np.arctan(max(most, 0))) * 100) / 100
        reason = f"the blades come to {mm(float(inside.min()))} from the tray's sides, they need {mm(plan.feature)}"
        yield Problem(*draft, reason, f"write at most {steepest:g} deg")
    otherwise = "a smaller clearance, or leave out the mould"
    slits = "the slits of the mould's lid {}"
    yield from _ligament(plan, lambda p: between(p, p.slit_profile, p.slit[0]), slits, otherwise)
    long, wide, t = plan.blade
    x, y, z = np.abs(plan.step)
    if plan.scales > 1 and x < long and y < wide and z - t < plan.clearance - SLACK:
        least = mm_up((t + plan.clearance) / plan.slope)
        reason = f"the mould's blades, {mm(t)} thick, do not fit beside each other"
        yield Problem("beam.pitch", mm(plan.pitch), reason, f"write at least {least}, {otherwise}")
    lid = bodies.lid_sizes(plan)
    opening = min(lid.low, plan.total - lid.high)
    if opening < plan.wall - SLACK:
        least = mm_up(plan.ends + plan.wall - opening)
        reason = f"the mould's lid leaves {mm(max(0.0, opening))} open for pouring"
        yield Problem("ends", mm(plan.ends), reason, f"write at least {least}, or leave out the mould")
    if plan.bed is not None:
        yield from _on_bed(plan, plan.bed, lid)


def _on_bed(plan: Plan, bed: float, lid: bodies.Lid) -> Iterator[Problem]:
    """Yield problems of the mould's parts on the printer's bed."""
    long, wide, _ = plan.blade
    across = 2 * max(lid.outer, bodies.tray_half(plan))
    for name, size, key in (("blade", long, "wall"), ("blade", wide, "wall"), ("lid", across, "substrate.width")):
        if size > bed + SLACK:
            remedy = f"write at least {mm_up(size)}, or a smaller {key}"
            yield Problem("bed", mm(bed), f"the mould's {name} measures {mm(size)}", remedy)
    if bodies.lid_counts(plan) is None:
        length = lid.high - lid.low
        skewed = f"its slits are skewed by alpha = {degrees(plan.alpha):.4g} deg"
        reason = f"the mould's lid is {mm(length)} long and cannot be cut into pieces that fit, {skewed}"
        remedy = f"write at least {mm_up(length)}, fewer scales, or leave out the mould"
        yield Problem("bed", mm(bed), reason, remedy)


def _ligament(plan: Plan, gap: Callable[[Plan], float], words: str, otherwise: str) -> Iterator[Problem]:
    """Yield the problem of neighbouring cuts, whose ``gap`` grows with the pitch."""
    found = gap(plan)
    if plan.scales < 2 or found >= plan.feature - SLACK:
        return
    high = plan.pitch
    while gap(plan._replace(pitch=high)) < plan.feature:
        high *= 2
    least = bisect(lambda pitch: gap(plan._replace(pitch=pitch)) - plan.feature, high / 2, high)
    reason = words.format(f"are only {mm(found)} apart" if found > 0 else "meet")
    remedy = f"write at least {mm_up(least)}, {otherwise}"
    yield Problem("beam.pitch", mm(plan.pitch), f"{reason}, they need {mm(plan.feature)}", remedy)


def _at_most(value: float, otherwise: str) -> str:
    """Return advice with a length rounded down to 0.001 mm."""
    return f"write at most {np.floor(value * 1000 + 1e-6) / 1000:g} mm" if value > 0.0005 else otherwise


def mm(value: float) -> str:
    """Return a length (mm) as text."""
    return f"{value:.4g} mm"


def mm_up(value: float) -> str:
    """Return a length (mm) rounded up to 0.001 mm, as text."""
    return f"{np.ceil(value * 1000 - 1e-6) / 1000:g} mm"
