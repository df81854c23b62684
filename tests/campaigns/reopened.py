"""Random beams on compliant joints along polygons of bend and twist that leave a contact and come back to it.

Beams as those of :mod:`histories`. A path turns, or ends, anywhere behind engagement, often shortly. Counted is
how paths end; wrong are ends and figures that hang on the number of stations, a beam and its mirror image that differ,
and a way that engages otherwise than the first one did.
"""

from __future__ import annotations

import collections

import numpy as np
from bent_contacts import along
from histories import Given, drawn

from legs import Bent, follow_legs
from squama.contacts import path
from squama.joints.factor import MIRROR
from squama.types import Array

TRIALS, SIZE = 20, 50
STATIONS = (1, 7, 60)
SAME, IMAGE, PLACE = 2e-3, 1e-4, 1e-3
"""Differences of moment or torque over the largest; that to the mirror image's; of ends and engagements, rad."""
FAR = 0.12


def polygon(r: np.random.Generator, engaged: float, ray: Array) -> Array:
    """Return the corners of a path that engages at a way on a ray, lets go, and engages again."""
    there = engaged + 10 ** r.uniform(-6, np.log10(FAR))
    back, again = engaged * r.uniform(0.0, 0.95), engaged + 10 ** r.uniform(-6, np.log10(FAR))
    ways = [there] if r.random() < 0.25 else [there, back, again]
    return np.multiply.outer(ways, ray)


def followed(given: Given, corners: Array, stations: int) -> Bent:
    """Follow a path by so many stations on each leg."""
    s = given.scale._replace(alpha=given.sense * given.scale.alpha)
    return follow_legs(s, given.K, given.mu, along(corners, stations))


def image(given: Given) -> Given:
    """Return the mirror image, to be followed along the mirrored path."""
    scale = given.scale._replace(alpha=-given.scale.alpha)
    return given._replace(scale=scale, K=given.K * np.outer(MIRROR, MIRROR))


def wrong(found: list[Bent], mirrored: Bent, engaged: float) -> list[str]:
    """Return what is wrong with a path that was followed to few stations and to many, the last as its image was."""
    told, ends = [], [one.answers.end() for one in found]
    if len({end.code for end in ends}) > 1 or np.ptp([end.phi for end in ends]) > PLACE:
        told.append(f"ends with its stations: {[(str(path.WORDS[end.code]), round(end.phi, 5)) for end in ends]}")
    loads = [np.column_stack([one.M, one.T])[n - 1 :: n] for one, n in zip(found, STATIONS, strict=True)]
    both = np.isfinite(loads[0]) & np.isfinite(loads[-1])
    if both.any() and (off := np.abs(loads[0] - loads[-1])[both].max()) > SAME * np.abs(loads[-1][both]).max():
        told.append(f"differs by {off / np.abs(loads[-1][both]).max():.1e} with its stations")
    if abs(found[0].answers.contact().phi - engaged) > 1e-9:
        told.append(f"engages at {found[0].answers.contact().phi:.9g}, not at {engaged:.9g}")
    own, other = np.column_stack([found[-1].M, found[-1].T]), np.column_stack([mirrored.M, -mirrored.T])
    with np.errstate(invalid="ignore"):
        off = float(np.nanmax(np.abs(own - other)) / np.nanmax(np.abs(own)))
    if off > IMAGE or ends[-1].code != mirrored.answers.end().code:
        told.append(f"is {off:.1e} off its mirror image")
    return told


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Try paths; the line for a failure names the trial and its number."""
    r, counts, failed = np.random.default_rng([23, seed]), collections.Counter[str](), []
    for i in range(size):
        given = drawn(r)
        angle = r.uniform(-0.4, np.pi / 2)
        ray = np.array([np.sin(angle), np.cos(angle)])
        far = followed(given, np.array([0.5 * ray]), 1)
        engaged = far.answers.contact().phi
        if far.answers.contact().first < 0:
            counts["nothing touches"] += 1
            continue
        corners = polygon(r, engaged, ray)
        found = [followed(given, corners, n) for n in STATIONS]
        told = wrong(found, followed(image(given), corners * [1.0, -1.0], STATIONS[-1]), engaged)
        counts[str(path.WORDS[found[-1].answers.end().code])] += 1
        failed += [f"trial {seed}, path {i} (mu {given.mu:.3g}, {corners.round(6).tolist()}): {what}" for what in told]
    print(f"reopened, {seed}: " + ", ".join(f"{n} {end}" for end, n in counts.most_common()), flush=True)
    return failed
