"""Random beams through the one contact solver: twisted, bent or both, there and back, with strains held or free.

Beams of the ranges of the joint's law, rigid and elastic, thick and thin. Wrong are: an end without a name before the
plates are bent beyond their model, a state that is not finite before the end, work that is lost, an image in the mirror
or a number of stations that changes the answer, loads on strains that are free.
"""

from __future__ import annotations

import collections
import math
from typing import NamedTuple

import numpy as np

from squama.contacts import entry, events, increments, path, states
from squama.contacts.system import PHI, PSI
from squama.joints import law
from squama.joints.factor import MIRROR
from squama.types import Array

TRIALS, SIZE = 300, 10
BALANCE, OUTSIDE, IMAGE, SAME, FREE = 1e-4, 5e-3, 1e-9, 1e-3, 1e-9
"""Work that is lost over the largest energy, by the solver's own work and by the loads at the stations; difference to
the image in the mirror, with other stations, and loads on free strains, over the largest load."""
STATIONS, STEP = 24, 1e-3
"""Stations on each leg, and the largest increment."""
FAR = (0.15, 0.3)
"""Largest bend and twist per pitch."""
FORCE = 1e-5
"""Contact force, E d^2, of scales so soft that rounding decides whether their contact is followed."""
EVENTS = ("engagement", "opening", "slide", "stick", "change", "snap")


class Given(NamedTuple):
    """A beam, its joint and friction."""

    scale: path.Scale
    K: Array
    mu: float

    def mirrored(self) -> Given:
        """Return the mirror image."""
        return Given(self.scale._replace(alpha=-self.scale.alpha), self.K * np.outer(MIRROR, MIRROR), self.mu)

    def beams(self, free: Array) -> entry.Beams:
        """Return what is followed, with such strains free."""
        one = path.beams(path.Scale(*np.array([self.scale]).T), self.K[None], np.array([self.mu]), free=path.STRETCHING)
        return one._replace(free=free[None].astype(float))


class Case(NamedTuple):
    """A beam, the corners (n, 2) of its path in bend and twist per pitch, and which strains are free (4,)."""

    given: Given
    corners: Array
    free: Array


def drawn(r: np.random.Generator) -> Given:
    """Return a beam."""
    alpha, theta0 = np.radians([r.uniform(20, 75), r.uniform(5, 25)])
    beta, lam, zeta, nu = r.uniform(0.35, 1.2), r.uniform(0.3, 0.8), r.uniform(0.1, 0.5), r.uniform(0.25, 0.495)
    h = r.uniform(0.05, 0.45) * math.cos(alpha) * math.sin(theta0)
    width = r.uniform(1.05, 1.95) * 2 * beta * math.cos(alpha)
    K = law.stiffness(law.Shape(width, lam, zeta, beta, h, alpha, theta0, nu))
    D = 10 ** r.uniform(3, 5.5) * h**3 / (12 * (1 - 0.35**2)) if r.random() < 2 / 3 else math.inf
    thickness = h if r.random() < 3 / 4 else 0.0
    scale = path.Scale(r.uniform(1.5, 5), beta, lam, alpha, theta0, thickness, D, 0.35)
    mu = math.exp(r.uniform(math.log(0.05), 0)) if r.random() < 0.9 else 0.0
    return Given(scale, K, mu)


def held(r: np.random.Generator, kind: str) -> Array:
    """Return which strains are free: of those that are not loaded, any."""
    free = r.random(4) < (0.5, 0.5, 0.5, 0.8)
    free[PSI] &= kind == "twist"
    free[PHI] &= kind == "bend"
    return free


def turned(r: np.random.Generator, kind: str, engaged: float) -> Array:
    """Return the corners of a path on which something touches at a way on its first ray."""
    far = engaged * r.uniform(1.05, 3)
    if kind in ("twist", "bend"):
        ways = [(far,), (far, 0), (far, r.uniform(0, 1) * far, far, 0), (far, 0, far, 0), (far, -far)][r.integers(5)]
        return np.outer(ways, (0, 1) if kind == "twist" else (1, 0))
    psi, phi = r.uniform(0.3, 1) * FAR[0], r.uniform(0.3, 1) * far
    kinds = (
        [(psi, phi)], [(psi, 0), (psi, phi)], [(0, phi), (psi, phi)], [(psi, 0), (psi, -phi), (psi, phi)],
        [(0, phi), (psi, phi), (-psi, phi), (psi, phi)], [(psi, phi), (0, 0), (psi, phi), (0, 0)],
    )  # fmt: skip
    return np.array(kinds[r.integers(len(kinds))], float)


def case(seed: int, number: int) -> Case:
    """Return a case of a trial: a beam that engages within the range, its path and what is free."""
    r = np.random.default_rng([29, seed, number])
    while True:
        given, kind = drawn(r), ("twist", "twist", "bend", "both", "both")[r.integers(5)]
        free, sense = held(r, kind), 1 if r.random() < 0.6 else -1
        ray = np.array([[0.0, sense]]) if kind != "bend" else np.array([[1.0 if r.random() < 0.5 else -1.0, 0.0]])
        most = FAR[1] if kind != "bend" else FAR[0]
        found = path.follow_all(given.beams(free), np.array([[most]]), corners=most * ray[None])
        if found.contact().first >= 0:
            corners = turned(r, kind, found.contact().phi) * [ray[0, 0] or 1.0, ray[0, 1] or 1.0]
            return Case(given, np.clip(corners, [-FAR[0], -FAR[1]], FAR), free)


def along(corners: Array, n: int) -> Array:
    """Return places of a path, so many on each leg."""
    starts = np.vstack([np.zeros(2), corners[:-1]])
    return np.concatenate(
        [a + (b - a) * np.arange(1, n + 1)[:, None] / n for a, b in zip(starts, corners, strict=True)]
    )


def followed(given: Given, corners: Array, free: Array, stations: int = STATIONS, step: float = STEP) -> path.Answers:
    """Follow a path with so many stations on each leg."""
    places = along(corners, stations)
    ways = np.cumsum(np.hypot(*np.diff(places, axis=0, prepend=np.zeros((1, 2))).T))
    return path.follow_all(given.beams(free), ways[None], corners=places[None], step=step, room=path.ROOM)


def loads(found: path.Answers) -> Array:
    """Return M, T, B, P of states (n, 4)."""
    v = path.named(found.rows[0])
    return np.column_stack([v[name] for name in ("M", "torque", "B", "P")])


def lost(found: path.Answers) -> tuple[float, float]:
    """Return the work lost over the largest energy, by the solver's own work, and by its loads at the stations."""
    v = {name: value[: found.end().solved] for name, value in path.named(found.rows[0]).items()}
    if not len(v["energy"]) or not v["energy"].max() > 0:
        return 0.0, 0.0
    spent = v["energy"] + v["W_fr"] + v["W_snap"]
    own = v["W"] - spent
    x, F = (np.column_stack([[0, *v[a]], [0, *v[b]]]) for a, b in (("psi", "twist"), ("M", "torque")))
    work = np.cumsum(((F[1:] + F[:-1]) / 2 * np.diff(x, axis=0)).sum(axis=1))
    return float(abs(own).max() / v["energy"].max()), float(abs(work - spent)[-1] / v["energy"].max())


def image(a: path.Answers, b: path.Answers, every: int = 1, signs: tuple[int, ...] = (1, 1, 1, 1)) -> float:
    """Return the largest difference of loads, over the largest load; ``every``: of b only each so many-th state."""
    one, other = loads(a), loads(b)[every - 1 :: every] * signs
    both = np.isfinite(one).all(axis=1) & np.isfinite(other).all(axis=1)
    return float(np.abs(one - other)[both, :2].max() / np.abs(one[both, :2]).max()) if both.any() else 0.0


def deflected(case: Case, found: path.Answers) -> float:
    """Return the largest deflection of a plate over its length."""
    return float(np.nanmax(states.bent(case.given.scale, found.rows[0, : found.end().solved]), initial=0.0))


def smooth(found: path.Answers) -> bool:
    """Say whether nothing jumped on a path."""
    told = found.events[0, : int(min(found.ends[0, 2], path.EVENTS)), 0]
    return bool((told != increments.SNAP).all())


def wrong(case: Case) -> tuple[path.Answers, list[tuple[str, float]]]:
    """Return what is found of a case, and what is wrong with it: its kind and size."""
    given, corners, free = case
    found = followed(given, corners, free)
    end, v, told = found.end(), path.named(found.rows[0]), []
    N = np.nanmax(v["N"], initial=0.0)
    if end.code in (increments.NO_EQUILIBRIUM, increments.MANY) and deflected(case, found) < states.THIN and N > FORCE:
        told.append((f"ends without a name ({end.code})", end.phi))
    rows = found.rows[0]
    if not np.isfinite(np.delete(rows[: end.solved], [path.COLUMNS.index(n) for n in "xy"], axis=1)).all():
        told.append(("is not finite before its end", end.phi))
    if np.isfinite(loads(found)[end.solved :]).any():
        told.append(("goes on behind its end", end.phi))
    own, outside = lost(found)
    lost_ways = ("loses work", own, BALANCE), ("loses work at stations", outside, OUTSIDE)
    told += [(word, size) for word, size, most in lost_ways if size > most and smooth(found)]
    if own > BALANCE and not smooth(found):
        told.append(("loses work beside snaps", own))
    F = np.abs(loads(found))[: end.solved]
    if F.size and (off := float(F[:, free].max(initial=0.0))) > FREE * F.max():
        told.append(("has a load on a free strain", off / F.max()))
    mirrored = followed(given.mirrored(), corners * [1, -1], free)
    if mirrored.end().code != end.code or (off := image(found, mirrored, signs=(1, -1, -1, 1))) > IMAGE:
        told.append(("is not its mirror image", math.inf if mirrored.end().code != end.code else off))
    finer = followed(given, corners, free, 4 * STATIONS)
    if finer.end().code != end.code or abs(finer.end().phi - end.phi) > SAME:
        told.append(("ends with its stations", abs(finer.end().phi - end.phi)))
    elif (off := image(found, finer, 4)) > SAME:
        told.append(("differs with its stations", off))
    return found, told


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Try paths; the line for a failure names the trial and its number, by which :func:`case` has it again."""
    counts, failed = collections.Counter[str](), []
    for i in range(size):
        one = case(seed, i)
        found, told = wrong(one)
        v = path.named(found.rows[0])
        end = str(path.WORDS[found.end().code])
        if found.end().code != increments.RANGE and deflected(one, found) >= path.THIN:
            end += ", plates bent beyond their model"
        counts[f"end: {end}"] += 1
        counts[f"contacts at once: {int(np.nanmax(v['contacts'], initial=0))}"] += 1
        for event in events.events(found):
            counts[f"event: {EVENTS[event.kind]}"] += 1
        failed += [f"trial {seed}, path {i}: {what}, {size:.2e}" for what, size in told]
    print(f"contacts, {seed}: " + ", ".join(f"{n} {what}" for what, n in sorted(counts.items())), flush=True)
    return failed
