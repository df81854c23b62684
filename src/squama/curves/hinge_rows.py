"""A row of N scales on hinges: rigid scales that turn about their base lines only.

It is the row of :mod:`squama.curves.rows` with all other motions blocked, in units of K_theta and the pitch.
"""

from __future__ import annotations

import math

import numpy as np

from squama.contacts import path
from squama.contacts.system import EQUAL
from squama.curves import compliant, hinge
from squama.curves.compliant_walk import Loaded
from squama.curves.rows import Row
from squama.curves.way import Analysis, States, Way
from squama.joints.choice import Joint
from squama.model.reach import SEARCH

BLOCKED = (1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
"""Motions of a scale that a hinge blocks: all but the rotation about n_Y."""
GIVES = (
    *("deflection", "scale_twist", "stress", "stress_x", "stress_y", "strain", "load_strength", "load_strain"),
    *("pull_out", "tab_force", "tab_bending", "tab_torsion", "U_joint", "U_plate", "U_bar", "load_bent"),
    *("u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z"),
)
"""Figures of scales that give in all motions, or bend."""


def solve(analysis: Analysis) -> tuple[list[Loaded], States]:
    """Return rows up to the asked twist, or to the cut-off of the endless beam's curve; all their cells are alike."""
    mus = np.atleast_1d(analysis.mus)
    return [_solved(analysis, float(mu)) for mu in mus], States({}, {"margin": analysis.margin})


def _solved(analysis: Analysis, mu: float) -> Loaded:
    """Return the row with one coefficient of friction."""
    beam, d, sign = analysis.beam, analysis.beam.pitch, analysis.way.sign
    to, K_theta, toward = analysis.way.values[-1], beam.joint_stiffness, (0.0, float(sign))
    whole = analysis._replace(way=Way.of("twisting", [sign * math.inf]), mus=np.asarray(mu))
    (endless,), _ = hinge.solve(whole)
    far = float(endless.curve(points=3).figures["rate_c"]) * d if math.isinf(to) else abs(to)
    K = np.diag([1.0] * 6 + [beam.torsional_rigidity / (d * K_theta)])
    held = compliant.Held(
        Joint(None, "hinge", "", 0.0), K, K_theta / d**3, K_theta, beam.torsional_rigidity, path.HELD, 1.0
    )
    scale = compliant.scale(beam, ideal=True)._replace(h=hinge.thickness(analysis))
    way = path.Path.of(scale, K, mu, toward=toward, most=max(far, SEARCH), masked=BLOCKED)
    ends = Row(EQUAL, endless, GIVES)
    return Loaded(compliant.Path(beam, held, way, toward), analysis.way.load, far, ends)
