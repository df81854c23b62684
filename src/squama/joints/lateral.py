"""Stiffness of a pitch against lateral bend, about the axis through both faces of the bar; E = 1 and d = 1.

The joint's matrix does not have this strain. Embedded parts stiffen the bar against it as they do against the bend
across the faces, to a power that is less where they cover the middle of its width only: with B over that of the bare
bar,

    ln B_lateral = share * covered^a cos(alpha)^b zeta^c ln B_bend

The numbers are fitted to linear elements of 47 designs; on 298 (``tools/neighbours.py``) they are off by 6 % (rms) and
47 % at most, by 3 and 18 % on the 230 whose bar is not narrow between steep scales (:func:`squama.joints.tilt.fitted`).
On 117 others, most of them outside the core of the law's range, they are off by 4 and 17 %.
"""

from __future__ import annotations

import numpy as np

from squama.joints.law import Shape
from squama.model import section
from squama.types import Array

SHARE, COVERED, OBLIQUE, DEEP = 0.42, 1.2, -0.59, -0.37
"""Share, and the powers of the covered width, of cos(alpha) and of zeta."""
_BEND = 7


def stiffness(K: Array, shape: Shape) -> Array:
    """Return the moment per lateral bend (n,) of joints K (n, 9, 9) and the shapes of their pitch, or of one.

    Complex steps pass. The bar's own stiffness where a joint makes it no stiffer against bend.
    """
    own = section.bending_moment_of_area(2 * shape.lam, shape.width)
    bend = 1 / np.linalg.inv(K)[..., _BEND, _BEND] / section.bending_moment_of_area(shape.width, 2 * shape.lam)
    bend = np.where(np.real(bend) > 1, bend, 1.0)
    return np.asarray(own * np.exp(power(shape) * np.log(bend)))


def power(shape: Shape) -> Array:
    """Return the power p (n,) of B_lateral = B_bend^p, both over the bare bar's."""
    return np.asarray(SHARE * covered(shape) ** COVERED * np.cos(shape.alpha) ** OBLIQUE * shape.zeta**DEEP)


def covered(shape: Shape) -> Array:
    """Return the share of the bar's width that embedded parts cover."""
    share = 2 * shape.beta * np.cos(shape.alpha) / shape.width
    return np.asarray(np.where(np.real(share) < 1, share, 1.0))
