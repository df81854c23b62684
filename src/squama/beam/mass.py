r"""Mass and moments of inertia per length of a beam's bar and scales, for vibration.

The axis of rotation is the middle line of the bar. With X across the beam, Y up and Z along it, a scale stands on the
face at (0, t); its plate reaches from -L to l along n_X, over its width 2b along n_Y and its thickness along n_Z:

.. math:: n_X = (-\sin\alpha\cos\theta_0, \sin\theta_0, \cos\alpha\cos\theta_0), \qquad
          n_Y = (\cos\alpha, 0, \sin\alpha), \qquad n_Z = n_X \times n_Y

The embedded part replaces material of the bar.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.beam.parts import Assembly

PLASTIC, SILICONE = 1240.0, 1150.0
"""Typical densities, kg/m^3: scales printed in PLA without infill, a bar of silicone (VPS 1100 to 1200)."""


class Mass(NamedTuple):
    """Mass (kg/m) and moments of inertia (kg m) per length of a beam: ``polar`` about its axis, ``across`` about X.

    ``across`` is that of the scales alone, about the X axis through each; that of a slender bar is neglected.
    """

    mass: float
    polar: float
    across: float


def of(beam: Assembly, bar: float, scale: float) -> Mass:
    """Return mass and inertia of a beam from the densities (kg/m^3) of bar and scales; density 0 leaves a part out."""
    s, b = beam.scale, beam.substrate
    faces = 2 if beam.other else 1
    parts = [_plate(beam, 0.0, s.length, scale), _plate(beam, -s.embedded, 0.0, scale - bar if scale else 0.0)]
    mass, polar, across = faces * np.sum(parts, axis=0) / beam.pitch
    own = bar * b.width * b.thickness
    return Mass(own + mass, own * (b.width**2 + b.thickness**2) / 12 + polar, across)


def _plate(beam: Assembly, low: float, high: float, density: float) -> tuple[float, float, float]:
    """Return mass (kg) and moments of inertia (kg m^2), polar and across, of a scale between two places on n_X."""
    s, t = beam.scale, beam.substrate.thickness / 2
    st, ct, sa, ca = math.sin(s.theta0), math.cos(s.theta0), math.sin(s.alpha), math.cos(s.alpha)
    axes = np.array([[-sa * ct, st, ca * ct], [ca, 0.0, sa], [sa * st, ct, -ca * st]])
    mass = density * (high - low) * s.width * s.thickness
    middle = np.array([0.0, t, 0.0]) + (low + high) / 2 * axes[0]
    # second moments per mass along X, Y, Z: of the plate's middle, and about it
    second = middle**2 + np.array([(high - low) ** 2, s.width**2, s.thickness**2]) / 12 @ axes**2
    return mass, mass * (second[0] + second[1]), mass * (second[1] + second[2])
