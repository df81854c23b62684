"""What cannot be printed, cast or assembled: a line each, with the dimension that causes it and what to write."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import cos, degrees, sin, tan

import numpy as np

from squama.errors import InputError
from squama.fabrication import mould
from squama.fabrication.place import Plan, between

SLACK = 1e-9
"""Sizes that agree up to rounding fit, mm."""


def check(plan: Plan, parts: tuple[str, ...]) -> None:
    """Refuse a plan that cannot be made.

    Parameters
    ----------
    plan : Plan
        The plan.
    parts : tuple of str
        What is to be written; the mould has conditions of its own.

    Raises
    ------
    InputError
        One line per cause.
    """
    lines = [*_scale(plan), *_section(plan), *_along(plan), *_at_rest(plan)]
    if "mould" in parts and not lines:
        lines += _mould(plan)
    if lines:
        raise InputError("\n".join(lines))


def _scale(plan: Plan) -> Iterator[str]:
    """Sizes of a single scale."""
    least = plan.feature
    for name, size in (("thickness", plan.thickness), ("width", plan.breadth), ("length", plan.length)):
        if size < least - SLACK:
            yield (
                f"scale.{name} = {mm(size)}: is less than the least size that can be printed; write at least "
                f"{mm(least)}, or a smaller feature"
            )
    if plan.breadth <= plan.thickness:
        yield f"scale.width = {mm(plan.breadth)}: is no more than the thickness, {mm(plan.thickness)}; write a plate"
    if plan.bed is not None and plan.length + plan.embedded > plan.bed + SLACK:
        yield (
            f"scale.length = {mm(plan.length)}: with its tab of {mm(plan.embedded)} the scale is longer than the bed, "
            f"{mm(plan.bed)}; " + _at_most(plan.bed - plan.embedded, "embed less of it")
        )
    if plan.bed is not None and plan.breadth > plan.bed + SLACK:
        yield f"scale.width = {mm(plan.breadth)}: is wider than the bed; write at most {mm(plan.bed)}"


def _section(plan: Plan) -> Iterator[str]:
    """Look at the slot in the bar's section: closed over the tab, inside the sides and above the lower face."""
    deep, _, t = plan.slot
    th, a = plan.theta0, plan.alpha
    closes = t / 2 / tan(th)
    if deep < closes + plan.feature - SLACK:
        yield (
            f"scale.embedded = {mm(plan.embedded)}: the substrate does not close over the tab, whose slot is {mm(t)} "
            f"thick; write at least {mm_up(closes + plan.feature - plan.clearance)}, or a larger scale.theta0"
        )
    depth = deep * sin(th) + t / 2 * cos(th)
    room = plan.height - plan.feature
    if depth > room + SLACK:
        most = (room - t / 2 * cos(th)) / sin(th) - plan.clearance
        yield (
            f"scale.embedded = {mm(plan.embedded)}: the slot goes through the substrate, it is {mm(depth)} deep in "
            f"{mm(plan.height)}; {_at_most(most, 'write a thicker substrate')}"
        )
    across = plan.breadth * cos(a)
    corners = plan.corners(plan.slot_profile, plan.slot[1])
    reach = float(np.abs(corners[:, 0]).max())
    free = plan.width / 2 - plan.feature
    if across > plan.width + SLACK:
        yield (
            f"scale.width = {mm(plan.breadth)}: the scale is wider than the bar, 2 b cos(alpha) = {mm(across)} against "
            f"{mm(plan.width)}; {_at_most(plan.breadth + 2 * (free - reach) / cos(a), 'write a wider substrate')}"
        )
    elif reach > free + SLACK:
        yield (
            f"scale.width = {mm(plan.breadth)}: the slot opens at the bar's side, it reaches {mm(reach)} from the "
            f"middle, half the bar is {mm(plan.width / 2)}; "
            f"{_at_most(plan.breadth + 2 * (free - reach) / cos(a), 'write a wider substrate')}, or a substrate.width "
            f"of at least {mm_up(2 * (reach + plan.feature))}"
        )


def _along(plan: Plan) -> Iterator[str]:
    """Slots beside each other, and the bar's ends."""
    gap = between(plan, plan.slot_profile, plan.slot[1])
    if plan.scales > 1 and gap < plan.feature - SLACK:
        least = _pitch(plan, lambda p: between(p, p.slot_profile, p.slot[1]) >= plan.feature)
        yield (
            f"beam.pitch = {mm(plan.pitch)}: the slots of neighbouring tabs {_apart(gap)} in the bar, they need "
            f"{mm(plan.feature)}; write at least {mm_up(least)}, or a smaller scale.embedded"
        )
    low = plan.corners(plan.slot_profile, plan.slot[1], 0)[:, 2].min()
    high = plan.corners(plan.slot_profile, plan.slot[1], plan.scales - 1)[:, 2].max()
    short = plan.feature - min(float(low), plan.total - float(high))
    if short > SLACK:
        yield f"ends = {mm(plan.ends)}: a slot opens at the bar's end; write at least {mm_up(plan.ends + short)}"


def _at_rest(plan: Plan) -> Iterator[str]:
    """Plates of true thickness above each other; they are parallel, so their own axes separate them or nothing does."""
    sizes = np.array([plan.length + plan.embedded, plan.breadth, plan.thickness])
    k = 1
    while k < plan.scales and plan.step[0] * k < sizes[0] and plan.step[1] * k < sizes[1]:
        gap = abs(plan.step[2]) * k - plan.thickness
        if gap < plan.clearance - SLACK:
            slope = sin(plan.theta0) * cos(plan.alpha)
            least = (plan.thickness + plan.clearance) / slope / k
            words = "lie in each other" if gap < 0 else f"are only {mm(gap)} apart"
            yield (
                f"scale.thickness = {mm(plan.thickness)}: neighbouring scales {words} at rest, the pitch lifts them by "
                f"d sin(theta0) cos(alpha) = {mm(plan.pitch * slope)}; "
                f"{_at_most(plan.pitch * slope - plan.clearance, 'write a larger scale.theta0')}, or a beam.pitch of "
                f"at least {mm_up(least)}"
            )
            return
        k += 1


def _mould(plan: Plan) -> Iterator[str]:
    """Conditions of lid, blades and tray."""
    if plan.wall < plan.feature - SLACK:
        smallest = mm(plan.feature)
        yield f"wall = {mm(plan.wall)}: is less than the least size that can be printed; write at least {smallest}"
    rest = plan.width - plan.height * tan(plan.draft)
    if rest < plan.feature:
        yield f"draft = {degrees(plan.draft):.4g} deg: leaves {mm(rest)} of the tray's floor; write a smaller one"
        return
    corners = plan.corners(plan.slot_profile, plan.slot[1])
    inside = plan.width / 2 + corners[:, 1] * tan(plan.draft) - np.abs(corners[:, 0])
    if inside.min() < plan.feature - SLACK:
        at = corners[inside.argmin()]
        most = (plan.width / 2 - abs(at[0]) - plan.feature) / max(-at[1], SLACK)
        steepest = np.floor(degrees(np.arctan(max(most, 0))) * 100) / 100
        yield (
            f"draft = {degrees(plan.draft):.4g} deg: the blades come to {mm(float(inside.min()))} from the tray's "
            f"sides, they need {mm(plan.feature)}; write at most {steepest:g} deg"
        )
    ligament = between(plan, plan.slit_profile, plan.slit[0])
    if plan.scales > 1 and ligament < plan.feature - SLACK:
        least = _pitch(plan, lambda p: between(p, p.slit_profile, p.slit[0]) >= plan.feature)
        yield (
            f"beam.pitch = {mm(plan.pitch)}: the slits of the mould's lid {_apart(ligament)}, they need "
            f"{mm(plan.feature)}; write at least {mm_up(least)}, a smaller clearance, or leave out the mould"
        )
    long, wide, t = plan.blade
    x, y, z = np.abs(plan.step)
    if plan.scales > 1 and x < long and y < wide and z - t < plan.clearance - SLACK:
        slope = sin(plan.theta0) * cos(plan.alpha)
        yield (
            f"beam.pitch = {mm(plan.pitch)}: the mould's blades, {mm(t)} thick, do not fit beside each other; write at "
            f"least {mm_up((t + plan.clearance) / slope)}, a smaller clearance, or leave out the mould"
        )
    lid = mould.lid_sizes(plan)
    opening = min(lid.low, plan.total - lid.high)
    if opening < plan.wall - SLACK:
        yield (
            f"ends = {mm(plan.ends)}: the mould's lid leaves {mm(max(0.0, opening))} open for pouring; write at least "
            f"{mm_up(plan.ends + plan.wall - opening)}, or leave out the mould"
        )
    if plan.bed is None:
        return
    across = 2 * max(lid.outer, mould.tray_half(plan))
    for name, size, key in (("blade", long, "wall"), ("blade", wide, "wall"), ("lid", across, "substrate.width")):
        if size > plan.bed + SLACK:
            yield (
                f"bed = {mm(plan.bed)}: the mould's {name} measures {mm(size)}; write at least {mm_up(size)}, or a "
                f"smaller {key}"
            )
    if mould.lid_counts(plan) is None:
        length = lid.high - lid.low
        yield (
            f"bed = {mm(plan.bed)}: the mould's lid is {mm(length)} long and cannot be cut into pieces that fit, its "
            f"slits are skewed by alpha = {degrees(plan.alpha):.4g} deg; write at least {mm_up(length)}, fewer scales, "
            "or leave out the mould"
        )


def _pitch(plan: Plan, holds: Callable[[Plan], bool]) -> float:
    """Return the least pitch for which a condition holds that gets easier as the pitch grows."""
    low, high = plan.pitch, plan.pitch
    while not holds(plan._replace(pitch=high)):
        low, high = high, 2 * high
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if holds(plan._replace(pitch=middle)) else (middle, high)
    return high


def _apart(gap: float) -> str:
    return f"are only {mm(gap)} apart" if gap > 0 else "meet"


def _at_most(value: float, otherwise: str) -> str:
    return f"write at most {mm_down(value)}" if value > 0.0005 else otherwise


def mm(value: float) -> str:
    """Return a length as it is printed."""
    return f"{value:.4g} mm"


def mm_up(value: float) -> str:
    """Return a length rounded up to a thousandth, so that it is enough."""
    return f"{np.ceil(value * 1000 - 1e-6) / 1000:g} mm"


def mm_down(value: float) -> str:
    """Return a length rounded down to a thousandth, so that it is not too much."""
    return f"{np.floor(value * 1000 + 1e-6) / 1000:g} mm"
