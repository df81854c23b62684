"""A row of N scales on hinges: rigid scales that turn about their base lines only.

It is the row of :mod:`squama.curves.real_rows` with all other motions blocked, in units of K_theta and the pitch.
"""

from __future__ import annotations

import math

import numpy as np

from squama.contacts import path
from squama.curves import hinge, real
from squama.curves.real_rows import GIVES, followed, row_states
from squama.curves.way import Analysis, States, Way
from squama.joints.choice import Joint
from squama.model.elastic_plate import SIDE_D, TIP
from squama.model.reach import SEARCH

BLOCKED = (1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
"""Motions of a scale that a hinge blocks: all but the rotation about n_Y."""


def solve(analysis: Analysis, _: str) -> States:
    """Follow a row to the asked twist, or to the cut-off of the endless beam's curve; all its cells are alike."""
    beam, d, m, sign = analysis.beam, analysis.beam.pitch, float(analysis.mus), analysis.way.sign
    (to,), K_theta, toward = analysis.way.values, beam.joint_stiffness, (0.0, float(sign))
    (endless,), _more = hinge.solve(analysis._replace(way=Way.of("twisting", [sign * math.inf])))
    far = float(endless.curve(points=3).figures["rate_c"]) * d if math.isinf(to) else abs(to)
    K = np.diag([1.0] * 6 + [beam.torsional_rigidity / (d * K_theta)])
    held = real.Held(Joint(None, "hinge", "", 0.0), K, K_theta / d**3, K_theta, beam.torsional_rigidity, path.HELD, 1.0)
    scale = real.scale(beam, ideal=True)._replace(h=hinge.thickness(analysis))
    way = path.Path.of(scale, K, m, toward=toward, most=max(far, SEARCH), masked=BLOCKED)
    one = real.Path(beam, held, way, toward)
    track = followed(way, beam.scales, far, analysis.points, sign)
    same = endless.curve(points=analysis.points, at=track.rows[:, 0, 0] / d * d).along
    by_dim, first = row_states(one, track, same, left=GIVES), one.contact(0)
    # before contact what is left of the torque is rounding
    by_dim["point",]["scales"][np.nansum(by_dim["point", "scale"]["N"], axis=1) == 0] = 0.0
    if first.first >= 0 and first[:3] != (TIP, SIDE_D, 1) and first.phi <= track.end.phi:
        # hinges are known to touch by tip edges on the next side edges
        words = f"{first.words} at {first.phi:.4g} rad/pitch"
        by_dim[()] |= {"scale_end": np.asarray(1), "other_contact": np.asarray(words)}
    return States(by_dim)
