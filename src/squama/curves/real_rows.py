"""A row of N scales of the real beam, in SI units: thick, elastic scales on a joint that gives.

All its cells have the same twist, bend and stretch. Its scales may touch anywhere, with several contacts at once.
"""

from __future__ import annotations

import math

import numpy as np

from squama.contacts import increments, path, row
from squama.contacts.row import Track
from squama.curves import real
from squama.curves.hinge import before
from squama.curves.path import Asked, States
from squama.model.outcome import End
from squama.types import Array

_TAB = "pull_out", "tab_force", "tab_bending", "tab_torsion"
_EACH = ("theta", "N", "f", "p", "s", "deflection", "stress", "strain", *_TAB)
_SHARED = ("torque", "scales", "U_el", "U_joint", "U_plate", "U_bar", "W_fr")
_MANY, _NEAR = 20_000, 1e-9


def solve(asked: Asked) -> States:
    """Follow a row to the asked twist, 0.3 rad per pitch if none is asked, or to its end."""
    (one,), more = real.solve(asked)
    n, way, d = asked.beam.scales, one.way, asked.beam.pitch
    track = followed(way, n, one.far, asked.points)
    phi = track.rows[:, 0, 0]
    each = _values(one, phi, track)
    along = {role: each[role].mean(axis=1) for role in _SHARED}
    total = along["U_el"] + along["W_fr"]
    along["RED"] = np.divide(along["W_fr"], total, out=np.zeros(phi.size), where=total > 0)
    endless = real.values(one, phi, way.states(phi)[0])
    along |= {"load": phi, "rate": phi / d, "T_periodic": endless["torque"], "theta_periodic": endless["theta"]}
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("point",): along,
        ("point", "scale"): {role: each[role] for role in (*_EACH, "Q")},
        (): {name: np.asarray(v) for name, v in figures(way, track).items()},
    }
    return States(by_dim, more.attrs, more.notes)


def followed(way: path.Path, n: int, far: float, points: int) -> Track:
    """Follow a row to a twist, some points of it before its engagement; as many up to an earlier end."""
    found = row.track(way, n, _twists(way, far, points))
    end = found.end
    if end.code in (increments.RANGE, increments.AT_REST) or end.solved == points:
        return found
    last = row.track(way, n, _twists(way, end.phi * (1 - _NEAR), points))
    return last._replace(end=end, events=found.events)


def _twists(way: path.Path, far: float, points: int) -> Array:
    """Return the twists of points."""
    c = way.contact
    first = before(points) if c.first >= 0 and c.phi < far else points
    straights = np.linspace(0.0, min(c.phi, far), first, endpoint=first == points)
    return np.concatenate([straights, np.linspace(c.phi, far, points - first)]) if first < points else straights


def _values(one: real.Path, phi: Array, track: Track) -> dict[str, Array]:
    """Return every variable (points, scales) in SI units, by role."""
    points, n = track.held.shape
    flat, twists = track.rows.reshape(points * n, -1), np.repeat(phi, n)
    parts = range(0, points * n, _MANY)
    found = [real.values(one, twists[i : i + _MANY], flat[i : i + _MANY]) for i in parts]
    each = {role: np.concatenate([v[role] for v in found]).reshape(points, n) for role in found[0]}
    each["Q"] = track.held * one.beam.unit_moment
    each["N"][:, -1] = each["f"][:, -1] = math.nan
    return each


def figures(way: path.Path, track: Track) -> dict[str, float | int | str]:
    """Return the single figures of a row."""
    c, other = way.contact, track.other()
    end = End.NONE if c.first == -1 and track.end.code == increments.RANGE else track.end.word
    return {
        "phi_e": c.phi,
        "phi_end": math.inf if end is End.NONE else track.end.phi,
        "end": str(end),
        "scale_end": 0 if other is None else other.scale,
        "other_contact": "" if other is None else other.words,
        "decay": row.decay(way),
    }
