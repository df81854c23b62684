"""A beam of N scales under one load, in SI units: its end scales lack a neighbour, cells may have own strains.

All cells bear the same torque or moment, or there is a couple at the ends, or the ends stay on one axis between grips,
or all cells have the same strains (:data:`squama.loads.ENDS`). Scales may touch anywhere, with several contacts at
once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.contacts import increments, row, states
from squama.contacts.row import Track
from squama.contacts.system import STRAINS
from squama.contacts.ties import COUPLE, GRIPPED, LOOSE
from squama.curves import compliant
from squama.curves.both_faces import WHOSE
from squama.curves.compliant_figures import by_load, exchanged, values
from squama.curves.curve_figures import dissipation
from squama.curves.way import Solved, Stations
from squama.errors import refuse
from squama.loads import Load
from squama.model.elastic_plate import SIDE_D, TIP
from squama.model.outcome import End
from squama.people import per_pitch
from squama.symbols import OF_A_SCALE, OTHER
from squama.types import Array
from squama.units import number

CELLS = "psi_cell", "phi_cell", "chi_cell", "stretch_cell"
CARRIED = "M_cell", "T_cell", "M_lat_cell", "P_cell"
GRIPPED_MOST = 60
"""Largest number of scales between grips or under a couple: each engages on its own, and time grows as the square of
their number.
"""
ANGLES, BOWED = 3, 0.25
"""Number of a cell's strains that are angles; bow from end to end, rad, from which on a couple differs by about 5 %."""
_MANY = 20_000
_UNKNOWN = ("slip", "contact", "mu_lock")
"""Variables of a scale that a row leaves out."""


class Row(NamedTuple):
    """Kind of ends of a beam with a number of scales, and the same beam without ends.

    ``left``: roles left out, for scales on hinges, which touch by tip edges on side edges. ``within``: twist or bend of
    a cell, rad per pitch, at which the curve ends.
    """

    kind: int
    endless: Solved
    left: tuple[str, ...] = ()
    within: float = math.inf

    def track(self, one: compliant.Path, load: Load, at: Array) -> Track:
        """Follow the beam to load angles (n,) per pitch from 0 on."""
        loads = sum(one.toward) * at
        return row.track(one.way, one.beam.pitches, loads, ends=self.kind, load=load.axis, within=self.within)


class Told(NamedTuple):
    """States of a beam at load angles (n,), by role: of the beam, and of each scale (n, scales).

    ``own`` also has the scales' variables: the mean inclination, and the largest of others. ``met``: load angles of
    engagement; ``bent``: load angle at which scales are bent beyond the plate model; ``ended``: load angle of the end.
    """

    own: dict[str, Array]
    each: dict[str, Array]
    figures: dict[str, float | int | str]
    met: Array
    bent: float
    ended: float
    notes: tuple[str, ...] = ()


def told(one: compliant.Path, load: Load, ends: Row, at: Array) -> Told:
    """Return the states of N scales at load angles (n,) from 0 on, NaN beyond the end."""
    n, sign = one.beam.pitches, sum(one.toward)
    track = ends.track(one, load, at)
    points = len(track.rows)
    along, each = of_scales(one, load, Stations.along(load, sign * at[:points]).strains, track)
    if load.sided and one.lead:
        each = exchanged(each, where=True)
    means = [role for role in each if role.removesuffix(OTHER) == "theta"]
    own = along | {role: np.fmax.reduce(v, axis=1) for role, v in each.items()}
    own |= {role: each[role].mean(axis=1) for role in means}
    bent = np.concatenate([states.bent(one.way.scale, face.rows.reshape(points * n, -1)) for face in track.faces])
    thin = np.flatnonzero(np.fmax.reduce(bent.reshape(-1, points, n), axis=(0, 2)) >= states.THIN)
    cells = cells_of(one, track, ends.kind, load)
    return Told(
        own={role: _whole(v, at.size) for role, v in own.items()},
        each={role: _whole(v, at.size) for role, v in (each | cells).items() if role not in ends.left},
        figures=_figures(one, track, ends, load),
        met=np.unique(_met(one, track)),
        bent=float(at[thin[0]]) if thin.size else math.nan,
        ended=math.inf if _apart(one, track) else track.end.phi,
        notes=remarks(track, float(at[-1]), ends.kind, load),
    )


def _whole(v: Array, n: int) -> Array:
    """Return values at the first of n points, extended to all of them by NaN."""
    out = np.full((n, *v.shape[1:]), np.nan)
    out[: len(v)] = v
    return out


def of_scales(
    one: compliant.Path, load: Load | None, strains: Array, track: Track, turned: Array | float | None = None
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return variables of the whole row (points,) and of each scale (points, scales) in SI units, by role.

    By name without a single ``load``, where bend and twist are both loads. ``strains`` (points, 2): imposed bends and
    twists; ``turned``: sign of the twist (points,), by default that of the way.
    """
    points, n = track.held.shape
    flat = [face.rows.reshape(points * n, -1) for face in track.faces]
    sign, known = sum(one.toward) or 1.0, np.repeat(strains, n, axis=0)
    turned = np.repeat(np.broadcast_to(one.toward[1] if turned is None else turned, points), n)
    parts = [slice(i, i + _MANY) for i in range(0, points * n, _MANY)]
    found = [values(one, known[part], *(rows[part] for rows in flat), turned=turned[part]) for part in parts]
    found = [by_load(v, load, sign) for v in found] if load else found
    every = {role: np.concatenate([v[role] for v in found]).reshape(points, n) for role in found[0]}
    along = {role: v.mean(axis=1) for role, v in every.items() if role.removesuffix(OTHER) not in OF_A_SCALE}
    along["RED"] = dissipation(along["U_el"], along["W_fr"])
    each = {role: v for role, v in every.items() if role not in along and role.removesuffix(OTHER) not in _UNKNOWN}
    pressed: Array = np.zeros(points, bool)
    for suffix, face in zip(("", OTHER), track.faces, strict=False):
        each[f"Q{suffix}"] = face.held * one.unit_moment
        pressed |= (each[f"N{suffix}"] != 0).any(axis=1) | (face.held != 0).any(axis=1)
    untouched(each)
    for role in {"scales", "T_scales", "M_scales"} & along.keys():
        # before contact the scales' torque is rounding
        along[role][~pressed] = 0.0
    return along, each


def untouched(each: dict[str, Array]) -> None:
    """Clear contact forces of the last scale of each face, which has no neighbour to touch."""
    for role in {f"{name}{face}" for name in ("N", "f", "f0") for face in ("", OTHER)} & each.keys():
        each[role][:, -1] = math.nan


def check_ends(kind: int | None, held: compliant.Held, n: int) -> None:
    """Refuse grips of a bar that cannot bend between them, and too many scales between grips or under a couple."""
    if kind not in (GRIPPED, COUPLE):
        return
    if n > GRIPPED_MOST:
        where = "between grips" if kind == GRIPPED else "under a couple"
        refuse("scales", str(n), f"must be {GRIPPED_MOST} or less {where}", 'give fewer, or write ends="free"')
    if kind == COUPLE:
        return
    bend, _, aside, _ = held.free
    if not (bend and aside):
        why = "joint.matrix knows no bend" if len(held.K) < 9 else "the cells' bend is held"
        refuse("ends", '"gripped"', why, 'write ends="free", or hold="nothing" or "stretch"')


def beyond(track: Track, far: float, *loads: Load) -> tuple[str, ...]:
    """Return notes where cells twist or bend beyond the model's range while their mean ``far`` does not."""
    if far > compliant.STRAIN_LIMIT or not track.cells.size:
        return ()
    found = []
    for load in loads:
        strains = track.cells[..., load.axis]
        most = np.abs(strains).max(axis=0)
        if most.max() > compliant.STRAIN_LIMIT:
            farthest, mean = np.abs(strains).max(axis=1), np.abs(strains.mean(axis=1))
            i = int((farthest > compliant.STRAIN_LIMIT).argmax())
            end = np.interp(compliant.STRAIN_LIMIT, farthest[max(i - 1, 0) : i + 1], mean[max(i - 1, 0) : i + 1])
            many, most_of_all = most.size * math.degrees(end), math.degrees(most.max())
            found.append(
                f"trust the curve up to {number(many, 'deg')} ({per_pitch(float(end))}): pitch "
                f"{int(most.argmax()) + 1} {load.verb}s by up to {most_of_all:.3g} deg, and {compliant.COMPARED}"
            )
    return tuple(found)


def shifted(beam: Beam) -> tuple[str, ...]:
    """Return a note if scales of the other face stand between those of the scaled face."""
    if not beam.other or not beam.other.shift:
        return ()
    return (f"the {beam.pitches} scales of both faces are taken to stand opposite each other: no shift between them",)


def remarks(track: Track, far: float, kind: int, load: Load) -> tuple[str, ...]:
    """Return the notes of :func:`beyond`, and on free ends that turn far, for a row under one load."""
    return (*beyond(track, far, load), *_bowed(track, kind, load))


def _bowed(track: Track, kind: int, load: Load) -> tuple[str, ...]:
    """Return a note if a beam with free ends bows so much that a couple at its ends would be another load."""
    if kind != LOOSE or not track.cells.size:
        return ()
    others = [e for e in range(ANGLES) if e != load.axis]
    bow = float(np.linalg.norm(track.cells[..., others].sum(axis=1), axis=-1).max())
    if bow < BOWED:
        return ()
    how = f"the beam bows: its ends turn by {math.degrees(bow):.3g} deg about other axes than that of the load"
    remedy = f'for a couple on the ends (up to {GRIPPED_MOST} scales) write ends="couple"'
    return (f"{how}, and with free ends the load follows the axis of each cell; {remedy}",)


def cells_of(one: compliant.Path, track: Track, kind: int, *loads: Load) -> dict[str, Array]:
    """Return the strains of each cell, and the moments and forces that hold it, in SI units by role.

    ``loads`` are the same in all cells, except between grips or under a couple.
    """
    free, d = one.held.free, one.beam.pitch
    senses = (1.0, one.toward[1] or 1.0, 1.0, 1.0)
    known = [True] * 4 if len(one.held.K) > 7 else [False, True, False, False]
    loaded = [load.axis for load in loads]
    there = [known[e] and (kind in (GRIPPED, COUPLE) or (not free[e] and e not in loaded)) for e in range(STRAINS)]
    units = one.unit_moment * np.append(np.ones(3), 1 / d)
    strains, carried = (np.moveaxis(v, -1, 0) for v in (track.cells[..., :4], track.cells[..., 4:]))
    # (adding 0 leaves no -0)
    rows = zip(CELLS, CARRIED, strains, carried, senses, units, known, there, strict=False)
    found: dict[str, Array] = {}
    for strain, force, v, F, sign, unit, is_known, is_there in rows:
        found |= ({strain: sign * v + 0.0} if is_known else {}) | ({force: sign * unit * F + 0.0} if is_there else {})
    return found


def _apart(one: compliant.Path, track: Track) -> bool:
    """Return whether scales never touch."""
    return one.contact(one.lead).first == -1 and math.isinf(track.engaged) and track.end.code == increments.RANGE


def _met(one: compliant.Path, track: Track) -> list[float]:
    """Return the load angles at which scales of each face first touch, as in the endless beam if that is earlier."""
    return [min(way, c.phi) for way, c in zip(track.met, one.way.contacts, strict=True)]


def _figures(one: compliant.Path, track: Track, ends: Row, load: Load) -> dict[str, float | int | str]:
    """Return the single values of a row besides those of every curve, by role."""
    c, second, apart = one.contact(one.lead), track.other(), _apart(one, track)
    other = second
    if ends.left and c.first >= 0 and c[:3] != (TIP, SIDE_D, 1) and c.phi <= track.end.phi:
        other = row.Other(1, f"{c.words} at {per_pitch(c.phi)}", c.phi)
    found: dict[str, float | int | str] = {
        "end": str(End.NONE if apart else track.end.word),
        "neighbour": max(0, c.k) if c.first != -1 else 0,
        "first_contact": c.words,
        "scale_end": 0 if other is None else other.scale,
        "other_contact": said(other, one.lead),
        "load_second": math.nan if second is None else second.phi,
        "decay": row.decay(one.way, ends.kind, load.axis, sum(one.toward)),
    }
    return found | ({"load_e_other": _met(one, track)[1 - one.lead]} if track.opposite else {})


def said(other: row.Other | None, lead: int = 0) -> str:
    """Return another contact in words, seen from the face ``lead``; "" for none."""
    return "" if other is None else WHOSE * (other.face != lead) + other.words
