"""A row of N scales of the real beam, in SI units: thick, elastic scales on a joint that gives.

All its cells have the same twist, bend and stretch. Its scales may touch anywhere, with several contacts at once.
"""

from __future__ import annotations

import math

import numpy as np

from squama.contacts import increments, path, row
from squama.contacts.row import Track
from squama.curves import real, real_path
from squama.curves.hinge import before
from squama.curves.path import Asked, States
from squama.curves.real_figures import by_load, values
from squama.curves.real_path import Stations
from squama.loads import LOADS
from squama.model.outcome import End
from squama.types import Array

_TAB = "pull_out", "tab_force", "tab_bending", "tab_torsion"
_EACH = ("theta", "N", "f", "p", "s", "deflection", "stress", "strain", *_TAB)
_SHARED = ("torque", "scales", "U_el", "U_joint", "U_plate", "U_bar", "W_fr")
_MANY, _NEAR = 20_000, 1e-9


def solve(asked: Asked) -> States:
    """Follow a row to the asked twist, 0.3 rad per pitch if none is asked, or to its end."""
    (loaded,), more = real_path.solve(asked)
    one, n, way, d = loaded.one, asked.beam.scales, loaded.one.way, asked.beam.pitch
    sign = int(one.toward[1])
    track = followed(way, n, loaded.far, asked.points, sign)
    phi = track.rows[:, 0, 0]
    each = _values(one, sign * phi, track)
    along = {role: each[role].mean(axis=1) for role in _SHARED}
    total = along["U_el"] + along["W_fr"]
    along["RED"] = np.divide(along["W_fr"], total, out=np.zeros(phi.size), where=total > 0)
    strains = Stations.along(asked.path.load, sign * phi).strains
    endless = by_load(values(one, strains, way.along(strains).rows[0], turned=sign), asked.path.load, sign)
    along |= {"load": phi, "rate": phi / d, "T_periodic": endless["torque"], "theta_periodic": endless["theta"]}
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("point",): along,
        ("point", "scale"): {role: each[role] for role in (*_EACH, "Q")},
        (): {name: np.asarray(v) for name, v in figures(way, track).items()},
    }
    return States(by_dim, more.attrs, more.notes)


def followed(way: path.Path, n: int, far: float, points: int, sign: int) -> Track:
    """Follow a row to a twist in one sense, some points of it before its engagement; as many up to an earlier end."""
    found = row.track(way, n, sign * _twists(way, far, points))
    end = found.end
    if end.code in (increments.RANGE, increments.AT_REST) or end.solved == points:
        return _once(found)
    last = row.track(way, n, sign * _twists(way, end.phi * (1 - _NEAR), points))
    return _once(last._replace(end=end, events=found.events))


def _once(track: Track) -> Track:
    """Return a row without repeated points: where a jump passes several twists, all have the state behind it."""
    new = np.diff(track.rows[:, 0, 0], prepend=-np.inf) > 0
    return track._replace(rows=track.rows[new], held=track.held[new], contacts=track.contacts[new])


def _twists(way: path.Path, far: float, points: int) -> Array:
    """Return the twists of points."""
    c = way.contact
    first = before(points) if c.first >= 0 and c.phi < far else points
    straights = np.linspace(0.0, min(c.phi, far), first, endpoint=first == points)
    return np.concatenate([straights, np.linspace(c.phi, far, points - first)]) if first < points else straights


def _values(one: real.Path, phi: Array, track: Track) -> dict[str, Array]:
    """Return every variable (points, scales) in SI units, by role, at signed twists."""
    points, n = track.held.shape
    flat, load, sign = track.rows.reshape(points * n, -1), LOADS["twisting"], one.toward[1]
    strains = np.column_stack([np.zeros(points * n), np.repeat(phi, n)])
    parts = (slice(i, i + _MANY) for i in range(0, points * n, _MANY))
    found = [by_load(values(one, strains[part], flat[part], turned=sign), load, sign) for part in parts]
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
