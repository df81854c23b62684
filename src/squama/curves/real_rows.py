"""A row of N scales of the real beam, in SI units: thick, elastic scales on a joint that gives.

Its cells have twists, bends and stretches of their own, or the same ones (:data:`squama.loads.ENDS`). Its scales may
touch anywhere, with several contacts at once.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping

import numpy as np

from squama.contacts import increments, path, row
from squama.contacts.row import Track
from squama.contacts.system import EQUAL, PHI, STRAINS
from squama.contacts.ties import GRIPPED, LOOSE
from squama.curves import real, real_walk
from squama.curves.curve_figures import dissipation
from squama.curves.hinge import before
from squama.curves.real_figures import by_load, values
from squama.curves.way import Analysis, States, Stations
from squama.errors import refuse
from squama.loads import ENDS, LOADS
from squama.model.outcome import End
from squama.types import Array

_TAB = "pull_out", "tab_force", "tab_bending", "tab_torsion"
EACH = ("theta", "N", "f", "p", "s", "deflection", "stress", "strain", *_TAB, "Q")
_SHARED = ("torque", "scales", "U_el", "U_joint", "U_plate", "U_bar", "W_fr")
GIVES = ("deflection", "stress", "strain", *_TAB, "U_joint", "U_plate", "U_bar")
"""Figures of scales that give in all motions, or bend."""
CELLS = "psi_cell", "phi_cell", "chi_cell", "stretch_cell"
CARRIED = "M_cell", "T_cell", "M_lat_cell", "P_cell"
_MANY, _NEAR = 20_000, 1e-9
GRIPPED_MOST = 60
"""Most scales between grips: each engages on its own there, and the time grows as the square of their number."""
_KINDS = dict(zip(ENDS, (LOOSE, GRIPPED, EQUAL), strict=True))


def solve(analysis: Analysis, ends: str) -> States:
    """Follow a row to the asked twist, 0.3 rad per pitch if none is asked, or to its end; ``ends``: how they are."""
    (loaded,), more = real_walk.solve(analysis)
    one, load, kind, sign = loaded.one, analysis.way.load, _KINDS[ends], analysis.way.sign
    if kind == GRIPPED:
        _may_be_gripped(one.held, analysis.beam.scales)
    track = followed(one.way, analysis.beam.scales, loaded.far, analysis.points, sign, kind)
    strains = Stations.along(load, sign * track.rows[:, 0, 0]).strains
    endless = by_load(values(one, strains, one.way.along(strains).rows[0], turned=sign), load, sign)
    notes = [*more.notes, *_beyond(track, loaded.far)]
    return States(row_states(one, track, endless, kind), more.attrs, notes)


def row_states(
    one: real.Path, track: Track, endless: Mapping[str, Array], ends: int = EQUAL, left: Container[str] = ()
) -> dict[tuple[str, ...], dict[str, Array]]:
    """Return what is told of a row, by dimension and role, without the roles ``left``.

    ``endless``: the endless beam's curve at the same twists.
    """
    phi = track.rows[:, 0, 0]
    each = of_scales(one, one.toward[1] * phi, track)
    along = {role: each[role].mean(axis=1) for role in _SHARED if role not in left}
    along |= {"RED": dissipation(along["U_el"], along["W_fr"]), "load": phi, "rate": phi / one.beam.pitch}
    along |= {f"{name}_periodic": endless[role] for name, role in (("T", "torque"), ("theta", "theta"))}
    return {
        ("point",): along,
        ("point", "scale"): {role: each[role] for role in EACH if role not in left} | _cells(one, track, ends),
        (): {name: np.asarray(v) for name, v in figures(one.way, track, ends).items()},
    }


def _beyond(track: Track, far: float) -> list[str]:
    """Say where cells twist farther than the model was compared with, and the mean twist does not."""
    twists = np.abs(track.cells[..., PHI]) if track.cells.size else np.zeros((1, 1))
    if far > real.STRAIN_LIMIT or twists.max() <= real.STRAIN_LIMIT:
        return []
    cell = int(twists.max(axis=0).argmax()) + 1
    return [
        f"cell {cell} twists by up to {twists.max():.3g} rad per pitch; the joint's stiffness was compared with "
        f"nonlinear elements up to {real.STRAIN_LIMIT:g}"
    ]


def _may_be_gripped(held: real.Held, n: int) -> None:
    """Refuse grips of a bar that cannot bend between them, or of one of too many scales."""
    if n > GRIPPED_MOST:
        refuse("scales", str(n), f"must be {GRIPPED_MOST} or less between grips", 'give fewer, or write ends="free"')
    bend, _, aside, _ = held.free
    if not (bend and aside):
        why = "joint.matrix knows no bend" if len(held.K) < 9 else "the cells' bend is held"
        refuse("ends", '"gripped"', why, 'write ends="free", or hold="nothing" or "stretch"')


def _cells(one: real.Path, track: Track, ends: int) -> dict[str, Array]:
    """Return strains of each cell, and what it carries of the loads that there are, in SI units by role."""
    free, d = one.held.free, one.beam.pitch
    senses = (1.0, one.toward[1], 1.0, 1.0)
    known = [True] * 4 if len(one.held.K) > 7 else [False, True, False, False]
    there = [known[e] and (ends == GRIPPED or (not free[e] and e != PHI)) for e in range(STRAINS)]
    units = one.unit_moment * np.append(np.ones(3), 1 / d)
    strains, carried = (np.moveaxis(v, -1, 0) for v in (track.cells[..., :4], track.cells[..., 4:]))
    # (adding 0 leaves no -0)
    rows = zip(CELLS, CARRIED, strains, carried, senses, units, known, there, strict=False)
    found: dict[str, Array] = {}
    for strain, load, v, F, sign, unit, is_known, is_there in rows:
        found |= ({strain: sign * v + 0.0} if is_known else {}) | ({load: sign * unit * F + 0.0} if is_there else {})
    return found


def followed(way: path.Path, n: int, far: float, points: int, sign: int, ends: int = EQUAL) -> Track:
    """Follow a row to a twist in one sense, some points of it before its engagement; as many up to an earlier end."""
    found = row.track(way, n, sign * _twists(way, far, points), ends=ends)
    end = found.end
    if end.code in (increments.RANGE, increments.AT_REST) or end.solved == points:
        return _once(found)
    last = row.track(way, n, sign * _twists(way, end.phi * (1 - _NEAR), points), ends=ends)
    return _once(last._replace(end=end, events=found.events))


def _once(track: Track) -> Track:
    """Return a row without repeated points: where a jump passes several twists, all have the state behind it."""
    new = np.diff(track.rows[:, 0, 0], prepend=-np.inf) > 0
    kept = {name: getattr(track, name)[new] for name in ("rows", "cells", "held", "loads", "contacts")}
    return track._replace(**kept)


def _twists(way: path.Path, far: float, points: int) -> Array:
    """Return the twists of points."""
    c = way.contact
    first = before(points) if c.first >= 0 and c.phi < far else points
    straights = np.linspace(0.0, min(c.phi, far), first, endpoint=first == points)
    return np.concatenate([straights, np.linspace(c.phi, far, points - first)]) if first < points else straights


def of_scales(one: real.Path, phi: Array, track: Track) -> dict[str, Array]:
    """Return every variable (points, scales) in SI units, by role, at signed twists."""
    points, n = track.held.shape
    flat, load, sign = track.rows.reshape(points * n, -1), LOADS["twisting"], one.toward[1]
    strains = np.column_stack([np.zeros(points * n), np.repeat(phi, n)])
    parts = (slice(i, i + _MANY) for i in range(0, points * n, _MANY))
    found = [by_load(values(one, strains[part], flat[part], turned=sign), load, sign) for part in parts]
    each = {role: np.concatenate([v[role] for v in found]).reshape(points, n) for role in found[0]}
    each["Q"] = track.held * one.unit_moment
    each["N"][:, -1] = each["f"][:, -1] = math.nan
    return each


def figures(way: path.Path, track: Track, ends: int = EQUAL) -> dict[str, float | int | str]:
    """Return the single figures of a row."""
    c, other = way.contact, track.other()
    apart = c.first == -1 and math.isinf(track.engaged)
    end = End.NONE if apart and track.end.code == increments.RANGE else track.end.word
    return {
        "phi_e": min(track.engaged, c.phi) if ends == GRIPPED else c.phi,
        "phi_end": math.inf if end is End.NONE else track.end.phi,
        "end": str(end),
        "scale_end": 0 if other is None else other.scale,
        "other_contact": "" if other is None else other.words,
        "decay": row.decay(way, ends),
    }
