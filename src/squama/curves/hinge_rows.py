"""A row of N scales on hinges: rigid scales that turn about their base lines only.

It is the row of :mod:`squama.curves.rows` with all other motions blocked, in units of K_theta and the pitch.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.contacts import path
from squama.contacts.system import EQUAL
from squama.curves import hinge, real
from squama.curves.real_walk import Loaded
from squama.curves.rows import Row
from squama.curves.way import Analysis, Case, Curve, States, Way
from squama.joints.choice import Joint
from squama.model.elastic_plate import SIDE_D, TIP
from squama.model.reach import SEARCH
from squama.types import Array

BLOCKED = (1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
"""Motions of a scale that a hinge blocks: all but the rotation about n_Y."""
GIVES = (
    *("deflection", "scale_twist", "stress", "stress_x", "stress_y", "strain", "load_strength", "load_strain"),
    *("pull_out", "tab_force", "tab_bending", "tab_torsion", "U_joint", "U_plate", "U_bar", "load_bent"),
    *("u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z"),
)
"""Figures of scales that give in all motions, or bend."""


class Hinged(NamedTuple):
    """A row on hinges, see :class:`squama.curves.way.Solved`."""

    row: Loaded

    @property
    def case(self) -> Case:
        """What the beam and the model bring."""
        return self.row.case

    @property
    def load_e(self) -> float:
        """Load angle per pitch at engagement."""
        return self.row.load_e

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at evenly spaced loads, or at load angles per pitch: NaN beyond its end."""
        found, first = self.row.curve(points=points, at=at), self.row.one.contact(0)
        told = {role: v for role, v in found.figures.items() if role not in GIVES}
        if first.first >= 0 and first[:3] != (TIP, SIDE_D, 1) and first.phi <= float(told["load_end"]):
            # hinges are known to touch by tip edges on the next side edges
            told |= {"scale_end": 1, "other_contact": f"{first.words} at {first.phi:.4g} rad/pitch"}
        return found._replace(figures=told)


def solve(analysis: Analysis) -> tuple[list[Hinged], States]:
    """Return rows up to the asked twist, or to the cut-off of the endless beam's curve; all their cells are alike."""
    mus = np.atleast_1d(analysis.mus)
    return [_solved(analysis, float(mu)) for mu in mus], States({}, {"margin": analysis.margin})


def _solved(analysis: Analysis, mu: float) -> Hinged:
    """Return the row with one coefficient of friction."""
    beam, d, sign = analysis.beam, analysis.beam.pitch, analysis.way.sign
    to, K_theta, toward = analysis.way.values[-1], beam.joint_stiffness, (0.0, float(sign))
    whole = analysis._replace(way=Way.of("twisting", [sign * math.inf]), mus=np.asarray(mu))
    (endless,), _ = hinge.solve(whole)
    far = float(endless.curve(points=3).figures["rate_c"]) * d if math.isinf(to) else abs(to)
    K = np.diag([1.0] * 6 + [beam.torsional_rigidity / (d * K_theta)])
    held = real.Held(Joint(None, "hinge", "", 0.0), K, K_theta / d**3, K_theta, beam.torsional_rigidity, path.HELD, 1.0)
    scale = real.scale(beam, ideal=True)._replace(h=hinge.thickness(analysis))
    way = path.Path.of(scale, K, mu, toward=toward, most=max(far, SEARCH), masked=BLOCKED)
    ends = Row(beam.pitches, EQUAL, endless, GIVES)
    return Hinged(Loaded(real.Path(beam, held, way, toward), analysis.way.load, far, ends))
