"""Random parts under load: each ends by name, its work is balanced, no number is missing.

Beams of the campaign of histories with 3 to 12 scales, a third of them with scales on both faces, on any support, under
a force at a place or over all, an end torque or moment, or a tendon, to strains of a quarter.
"""

from __future__ import annotations

import collections
import math
from typing import NamedTuple

import numpy as np
from histories import drawn

from squama.beam.faces import FACES
from squama.contacts import increments, path
from squama.contacts.path import Path
from squama.contacts.row import Track
from squama.contacts.system import PHI, PSI
from squama.contacts.ties import Tie
from squama.part import loaded
from squama.part.loaded import Course
from squama.part.loading import Load, Support
from squama.units import Dimension

TRIALS, SIZE = 20, 50
FAR, POINTS, BALANCE = 0.25, 24, 2e-4
"""Strain of the part without contact, rad per pitch; points; work that may be lost, over the largest energy."""
_KINDS = ("tip", "place", "over all", "twist", "bend", "tendon")


class Part(NamedTuple):
    """What is followed, and what it is in words."""

    course: Course
    words: str


def part(r: np.random.Generator, of_faces: np.random.Generator) -> Part:
    """Return a part."""
    beam, n = drawn(r), int(r.integers(3, 13))
    other = FACES[str(of_faces.choice(["one"] * 4 + ["mirrored", "turned"]))]
    bar = {"seen": other.seen, "own": (0.0, 0.0, 0.0, 0.0)} if other else {}
    way = Path.at_rest(beam.scale, beam.K, beam.mu, sense=beam.sense, free=(1, 1, 1, 1), aside=r.uniform(1, 6), **bar)
    word = str(r.choice(["clamped", "clamped", "gripped", "simple"]))
    held = Support(word, (0.0, float(n)) if word == "simple" else (0.0, 0.0))
    kind = str(r.choice(_KINDS if word == "clamped" else _KINDS[1:3]))
    if word == "gripped" and r.random() < 0.2:
        kind = "twist"
    way_of = np.array([0.5 * r.normal(), r.normal(), 0.2 * r.normal()]) * ((0, 1, 0) if word == "simple" else 1)
    way_of /= np.linalg.norm(way_of)
    ties = {
        "tip": Tie([(n, way_of)]),
        "place": Tie([(r.uniform(1, n - 1), way_of)]),
        "over all": Tie([(i + 0.5, way_of / n) for i in range(n)]),
        "twist": Tie(carried=(0, 1, 0, 0)),
        "bend": Tie(carried=(1, 0, 0, 0)),
        "tendon": Tie(carried=(r.uniform(-0.5, 0.5), 0, 0, -1)),
    }
    measures = Dimension.ANGLE if kind in ("twist", "bend") else Dimension.RATIO
    load = Load(kind, 1.0, measures, ties[kind], given=True, turns={"twist": PHI, "bend": PSI}.get(kind, -1))
    words = f"{n} scales{' on both faces' * bool(other)}, {word}, {kind}, mu {beam.mu:.3g}"
    return Part(loaded.course(way, n, [load], held, (1.0, 1.0, 1.0)), words)


def wrong(track: Track) -> list[str]:
    """Return what is wrong with what was followed: no numbers, work that is lost, no room for contacts."""
    v, found = path.named(track.rows), []
    U, W, rubbed, lost = (v[name].sum(axis=1) for name in ("energy", "W", "W_fr", "W_snap"))
    if not np.isfinite(track.cells).all() or not np.isfinite(U).all():
        found.append("has values that are no numbers")
    elif U.size and np.abs(W - U - rubbed - lost).max() > BALANCE * U.max():
        found.append(f"loses {np.abs(W - U - rubbed - lost).max() / U.max():.1e} of its work")
    if track.end.code == increments.MANY or not math.isfinite(track.end.phi):
        found.append(f"ends as {track.end.word} at {track.end.phi:.4g}")
    return found


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Try parts; the line for a failure names the trial and its number."""
    r, of_faces = np.random.default_rng([29, seed]), np.random.default_rng([30, seed])
    ends, failed = collections.Counter[str](), []
    for i in range(size):
        one = part(r, of_faces)
        track = one.course.follow(np.linspace(0.0, FAR, POINTS + 1)[1:])
        ends[str(track.end.word)] += 1
        failed += [f"trial {seed}, part {i} ({one.words}): {what}" for what in wrong(track)]
    print(f"parts, {seed}: " + ", ".join(f"{n} {end}" for end, n in ends.most_common()), flush=True)
    return failed
