"""A row of N scales of the real beam, in SI units: thick, elastic scales on a joint that gives.

The row is straight and keeps its length. Other contacts than those of the two edges that touch first are looked for
between all scales, and end the row.
"""

from __future__ import annotations

import math

import numpy as np

from squama.curves import real
from squama.curves.hinge import before
from squama.curves.path import Asked, States
from squama.model.outcome import End
from squama.real import chain_track, changes, path
from squama.real.chain_track import Track
from squama.types import Array

_TAB = "pull_out", "tab_force", "tab_bending", "tab_torsion"
_EACH = ("theta", "N", "f", "p", "s", "deflection", "stress", "strain", *_TAB)
_SHARED = ("torque", "scales", "U_el", "U_joint", "U_plate", "U_bar", "W_fr")
_MANY = 20_000


def solve(asked: Asked) -> States:
    """Follow a row to the asked twist, 0.3 rad per pitch if none is asked, or to its end."""
    (one,), more = real.solve(asked, stretched=False)
    n, way, c, d = asked.beam.scales, one.way, one.way.contact, asked.beam.pitch
    # plates that meet elsewhere first end the row there
    last = min(one.far, c.phi) if c.first == -2 else one.far
    first = before(asked.points) if c.first >= 0 and c.phi < last else asked.points
    straights = np.linspace(0.0, min(c.phi, last), first, endpoint=first == asked.points)
    contacts = np.linspace(c.phi, last, asked.points - first)
    track = _track(way, n, straights, contacts)
    reached = np.isfinite(track.rows[:, 0, 1])
    track = track._replace(rows=track.rows[reached], sides=track.sides[reached], held=track.held[reached])
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
        (): {name: np.asarray(v) for name, v in _figures(way, track).items()},
    }
    return States(by_dim, more.attrs, more.notes)


def _track(way: path.Path, n: int, straights: Array, contacts: Array) -> Track:
    """Follow a row: all scales do the same until they touch, then each its own."""
    c = way.contact
    free = way.states(straights)[0]
    rows = np.repeat(free[:, None], n, axis=1)
    rows[:, :, 4:8] = np.nan
    rows[:, :, 6:8] = 0.0
    sides, held = np.full((len(rows), n), np.nan), np.zeros((len(rows), n))
    if not contacts.size:
        code, edge, k = (changes.OTHER, c.second, c.k) if c.first == -2 and straights[-1] >= c.phi else (0, -1, 0)
        return Track(rows, sides, held, code, float(straights[-1]), 0, edge, k)
    t = chain_track.track(way, n, contacts)
    rows, sides, held = (np.concatenate(v) for v in ((rows, t.rows), (sides, t.sides), (held, t.held)))
    return t._replace(rows=rows, sides=sides, held=held)


def _values(one: real.Path, phi: Array, track: Track) -> dict[str, Array]:
    """Return every variable (points, scales) in SI units, by role."""
    points, n = track.sides.shape
    flat, twists = track.rows.reshape(points * n, -1), np.repeat(phi, n)
    parts = range(0, points * n, _MANY)
    found = [real.values(one, twists[i : i + _MANY], flat[i : i + _MANY]) for i in parts]
    each = {role: np.concatenate([v[role] for v in found]).reshape(points, n) for role in found[0]}
    beam = one.beam
    # a state's places are those of its plate; those of a contact are on its tip and on the next one's side
    each["s"] = track.sides * beam.pitch
    each["Q"] = track.held * beam.unit_moment
    each["N"][:, -1] = each["f"][:, -1] = math.nan
    return each


def _figures(way: path.Path, track: Track) -> dict[str, float | int | str]:
    """Return the single figures of a row."""
    c = way.contact
    ends = np.array([[track.code, track.phi, track.edge, track.k, 0]])
    end = End(path.endings(np.array([c], float), ends)[0])
    other = path.place(track.edge, track.k, track.scale + 1) if track.code == changes.OTHER else ""
    return {
        "phi_e": c.phi,
        "phi_end": math.inf if end is End.NONE else track.phi,
        "end": str(end),
        "scale_end": track.scale + 1 if track.code != changes.RANGE else 0,
        "other_contact": other,
        "decay": chain_track.decay(way),
    }
