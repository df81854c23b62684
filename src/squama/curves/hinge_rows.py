"""A row of N scales on hinges, in SI units: rigid scales that turn about their base lines only.

It is the row of :mod:`squama.contacts.row` with all other motions blocked, in units of K_theta and the pitch.
"""

from __future__ import annotations

import math

import numpy as np

from squama.contacts import path, states
from squama.curves import hinge, real
from squama.curves.curve_figures import dissipation
from squama.curves.real_rows import figures, followed
from squama.curves.way import Asked, States, Way
from squama.model.elastic_plate import SIDE_D, TIP
from squama.model.reach import SEARCH
from squama.types import Array

BLOCKED = (1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
"""Motions of a scale that a hinge blocks: all but the rotation about n_Y."""


def solve(asked: Asked, _: str) -> States:
    """Follow a row to the asked twist, or to the cut-off of the endless beam's curve; all its cells are alike."""
    beam, n, d, m, sign = asked.beam, asked.beam.scales, asked.beam.pitch, float(asked.mus), asked.way.sign
    (to,) = asked.way.values
    (endless,), _more = hinge.solve(asked._replace(way=Way.of("twisting", [sign * math.inf])))
    far = float(endless.curve(points=3).figures["rate_c"]) * d if math.isinf(to) else abs(to)
    scale = real.scale(beam, ideal=True)._replace(h=hinge.thickness(asked))
    way = path.Path.of(scale, np.diag([1.0] * 6 + [0.0]), m, toward=(0.0, sign), most=max(far, SEARCH), masked=BLOCKED)
    track = followed(way, n, far, asked.points, sign)
    along, each = _values(asked, way, track.rows)
    each["Q"] = track.held * beam.joint_stiffness
    same = endless.curve(points=asked.points, at=along["rate"] * d).along
    along |= {"T_periodic": same["torque"], "theta_periodic": same["theta"]}
    found, first = figures(way, track), way.contact if sign > 0 else way.contact.mirrored
    if first.first >= 0 and first[:3] != (TIP, SIDE_D, 1) and first.phi <= track.end.phi:
        # hinges are known to touch by tip edges on the next side edges
        found |= {"scale_end": 1, "other_contact": f"{first.words} at {first.phi:.4g} rad/pitch"}
    single = {name: np.asarray(value) for name, value in found.items()}
    return States({("point",): along, ("point", "scale"): each, (): single})


def _values(asked: Asked, way: path.Path, rows: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return everything along the twist in SI units by role: of the row (points,), of each scale (points, scales)."""
    beam, d, v = asked.beam, asked.beam.pitch, path.named(rows)
    moment, force = beam.joint_stiffness, beam.joint_stiffness / d
    phi = v["phi"][:, 0]
    scales, bar = v["torque"].mean(axis=1) * moment, beam.torsional_rigidity * phi / d
    stored, rubbed = v["energy"].mean(axis=1) * force + bar * phi / (2 * d), v["W_fr"].mean(axis=1) * force
    along = {
        "load": phi, "rate": phi / d, "torque": bar + scales, "scales": scales, "U_el": stored, "W_fr": rubbed,
        "RED": dissipation(stored, rubbed),
    }  # fmt: skip
    each = {
        "theta": states.inclinations(way, rows.reshape(-1, rows.shape[2])).reshape(rows.shape[:2]),
        "N": v["N"] * force, "f": v["f"] * force, "p": v["x"] * d, "s": v["y"] * d,
    }  # fmt: skip
    each["N"][:, -1] = each["f"][:, -1] = math.nan
    return along, each
