"""Variables of the model with thick scales in SI units: loads, forces, stresses, energies, tangent stiffness."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from squama.beam.design import Beam
from squama.beam.matrixfile import MOTIONS
from squama.contacts import events, path, states
from squama.curves.both_faces import of_other, worst
from squama.curves.compliant import Held, Path
from squama.curves.curve_figures import TIMES, dissipation, first_at
from squama.loads import LOADS, Load
from squama.model.elastic_plate import BASE, TIP
from squama.symbols import OF_A_SCALE, OTHER
from squama.types import Array

_LENGTHS = (*MOTIONS[:3], "p", "s", "slip", "deflection", "stress_x", "stress_y")
_PER_LENGTH = ("N", "f", "P", "U_el", "U_joint", "U_plate", "U_bar", "W_fr", "W_snap", "work")
_MOMENTS = ("T", "M", "M_lat", "onset")
INNER = ("mode", "onset", "work")
"""Variables that results along a path leave out."""
ROLES = {"phi": "load", "Phi": "rate", "T": "torque", "T_scales": "scales"}
"""Roles of the variables of a twisted beam, under bend and twist at once too, by their names here."""


def values(one: Path, strains: Array, *faces: Array, turned: Array | float = 0.0) -> dict[str, Array]:
    """Return every variable at states (n, 61) of each face, the scaled face first, in SI units by name.

    ``strains`` (n, 2): imposed bends and twists per pitch; ``turned``: sign of the twist (n,), for places of contacts,
    which are mirrored if the face sees a negative twist.
    """
    column, beam = path.named(faces[0]), one.beam
    own = {name: column[name] for name in ("mode", "W_fr", "W_snap")} | states.energies(one.way, *faces)
    own["U_el"] = own["U_joint"] + own["U_plate"] + own["U_bar"]
    own |= {"onset": column["T_slip"], "work": column["W"], **loads(one.held, column)}
    for face, rows in enumerate(faces):
        told = _of_scale(one, rows, turned * one.seen[face][1])
        own |= of_other(told) if face else told
    v = in_si(beam, one.held, own)
    for face, rows in enumerate(faces):
        tab = embedded(one, path.motions(rows, one.seen[face]))
        v |= of_other(tab) if face else tab
    return v | _along_the_bar(one, v, column, strains)


def _along_the_bar(one: Path, v: Mapping[str, Array], column: Mapping[str, Array], strains: Array) -> dict[str, Array]:
    """Return bend and twist per pitch and per length, and the scales' parts of moment and torque."""
    analysis = zip(("psi", "twist"), one.held.free, strains.T, strict=False)
    bend, twist = (column[name] if free else given for name, free, given in analysis)
    d, bare = one.beam.pitch, one.rigidities
    found = {"phi": twist, "Phi": twist / d}
    if len(bare) == 1:
        return found | {"T_scales": v["T"] - bare[0, 0] * found["Phi"]}
    found |= {"psi": bend, "kappa": bend / d}
    bar = bare @ [found["Phi"], found["kappa"]]
    return found | {"T_scales": v["T"] - bar[0], "M_scales": v["M"] - bar[1]}


def by_load(v: Mapping[str, Array], load: Load, sign: Array | float = 1.0) -> dict[str, Array]:
    """Return variables by their roles under a single load; load and torque as magnitudes in the sense ``sign``.

    The rate of the other load and the scales' part of its moment are left out.
    """
    (other,) = (kind for kind in LOADS.values() if kind is not load)
    names = {"load": load.angle, "rate": load.rate, "torque": load.torque, "scales": f"{load.torque}_scales"}
    left = {*names.values(), other.rate, f"{other.torque}_scales"}
    # (adding 0 leaves no -0)
    roles = {role: sign * v[name] + 0.0 for role, name in names.items()}
    return {name: values for name, values in v.items() if name not in left} | roles


def touching(answers: path.Answers) -> dict[str, Array]:
    """Return the letters of the contacts at states, for each face."""
    own, *other = ({"contact": events.touching(face)} for face in answers.faces)
    return own | (of_other(other[0]) if other else {})


def exchanged(v: Mapping[str, Array], where: Array | bool) -> dict[str, Array]:
    """Return variables with those of the two faces exchanged at the states ``where``."""
    both = [role for role in OF_A_SCALE if role + OTHER in v]
    found = dict(v)
    for role in both:
        own, other = v[role], v[role + OTHER]
        found[role], found[role + OTHER] = np.where(where, other, own), np.where(where, own, other)
    return found


def in_si(beam: Beam, held: Held, own: Mapping[str, Array]) -> dict[str, Array]:
    """Return variables in SI units, from values with d = 1 and modulus 1, by name; f0 and RED are added."""
    d, E = beam.pitch, held.modulus
    units = dict.fromkeys(_LENGTHS, d) | dict.fromkeys(_PER_LENGTH, E * d**2) | dict.fromkeys(_MOMENTS, E * d**3)
    units["stress"] = E
    v = {role: x * units.get(role.removesuffix(OTHER), 1.0) for role, x in own.items()}
    v |= {f"f0{face}": v[f"f{face}"] * beam.eta * d / held.K_theta for face in ("", OTHER) if f"f{face}" in v}
    v["RED"] = dissipation(v["U_el"], v["W_fr"])
    return v


def _of_scale(one: Path, rows: Array, turned: Array | float) -> dict[str, Array]:
    """Return the variables of a scale at the states of its face, E = d = 1, by role.

    Along the scale's own axes; places of contacts are mirrored where the face sees a negative twist.
    """
    column = path.named(rows)
    own = dict(zip(MOTIONS, states.displaced(one.way, rows).T, strict=True))
    own |= {name: column[name] for name in ("slip", "N", "f")}
    for role, across in _across(column).items():
        place = column[{"p": "x", "s": "y"}[role]]
        own[role] = np.where(across & (turned < 0), -place, place)
    own["theta"] = states.inclinations(one.way, rows)
    return own | states.plate_figures(one.way.scale, path.deflections(rows))


def _across(column: Mapping[str, Array]) -> dict[str, Array]:
    """Return whether the places of the first contact, p and s, are measured across the scale, for states (n,)."""
    one, other = column["first"], column["second"]
    faced = (one == path.FACE) | (other == path.FACE)
    return {"p": faced | np.isin(one, (TIP, BASE)), "s": ~faced & np.isin(other, (TIP, BASE))}


def loads(held: Held, column: Mapping[str, Array]) -> dict[str, Array]:
    """Return the strains of the bar that are not loaded and the forces that hold it, E = d = 1, by name; 0 if free.

    A matrix (7, 7) has the torque alone.
    """
    psi, phi, chi, eps = held.free
    torque = {"T": column["torque"] * (1 - phi) + 0.0}
    if len(held.K) < 9:
        return torque
    # (adding 0 leaves no -0)
    held_by = {"M": column["M"] * (1 - psi), "M_lat": column["B"] * (1 - chi), "P": column["P"] * (1 - eps)}
    strains = {"chi": column["aside"], "stretch": column["stretch"]}
    return torque | {role: v + 0.0 for role, v in (strains | held_by).items()}


def embedded(one: Path, q: Array) -> dict[str, Array]:
    """Return the forces on the embedded part and the strain around it, SI, by role, from motions ``q`` (n, m)."""
    force, moment = states.on_tab(one.way, q)
    moment_unit = one.unit_moment
    unit = moment_unit / one.beam.pitch
    strain = np.full(len(q), np.nan)
    if one.held.joint.strain is not None:
        n = min(q.shape[1], one.held.joint.strain.shape[-1])
        form = one.held.joint.strain[:, :n, :n]
        strain = np.sqrt(np.einsum("ni,eij,nj->ne", q[:, :n], form, q[:, :n]).max(axis=1))
    return {
        "pull_out": force[:, 0] * unit,
        "tab_force": np.linalg.norm(force, axis=1) * unit,
        "tab_bending": moment[:, 1] * moment_unit,
        "tab_torsion": moment[:, 0] * moment_unit,
        "strain": strain,
    }


def thresholds(engaged: float, beam: Beam, at: Array, v: Mapping[str, Array]) -> dict[str, float]:
    """Return load angles of stiffness, peak, strength and strain limits (NaN if not reached), and the energy error."""
    reached = np.isfinite(v["torque"])
    touching = reached & (at >= engaged)
    x, torque = at[reached], v["torque"][reached]
    found = {f"load_{name}": first_at(at[touching], v["stiffness_ratio"][touching], n) for name, n in TIMES.items()}
    peak = np.flatnonzero((torque[1:-1] > torque[:-2]) & (torque[1:-1] >= torque[2:]))
    found["load_peak"] = float(x[peak[0] + 1]) if peak.size else math.nan
    strength, limit = beam.scale.strength, beam.substrate.strain_limit
    found["load_strength"] = math.nan if strength is None else first_at(x, worst(v, "stress")[reached], strength)
    found["load_strain"] = math.nan if limit is None else first_at(x, worst(v, "strain")[reached], limit)
    known = np.isfinite(v["work"])
    work, kept = (float(e[known][-1]) if known.any() else 0.0 for e in (v["work"], v["U_el"] + v["W_fr"] + v["W_snap"]))
    found["energy_error"] = (work - kept) / work if work > 0 else 0.0
    return found
