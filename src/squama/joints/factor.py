"""A joint's stiffness K (9, 9) and its Cholesky factor, whose diagonal has the figures that have names.

Variables: the scale's motions (u_X, u_Y, u_Z, w_X, w_Y, w_Z), the twist phi, the bend psi and the stretch epsilon, all
per pitch (:mod:`squama.fe.pitch_stiffness`); E = 1, d = 1. With the variables in the :data:`ORDER` u_X, u_Y, u_Z, w_X,
w_Z, w_Y, phi, psi, epsilon and K = L L^T, the square of a pivot is the stiffness of its variable, those before it free
and those behind it held:
    of w_Y       K_theta = 1 / (A^-1)_55, A the six motions' part
    of phi       the torque per twist of the pitch, the scale free, neither bent nor stretched
    of psi       the moment per bend, the scale and the twist free
    of epsilon   the tension per stretch, all else free.
The energy is 1/2 sum_j (pivot_j (x_j + sum_i c_ij x_i))^2 with c_ij = L_ij / L_jj: -c_ij says how far x_j goes by
itself with each x_i behind it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from squama.beam.matrixfile import loose_rows
from squama.types import Array

ORDER = (0, 1, 2, 3, 5, 4, 6, 7, 8)
"""Rows of K in the order of the factor."""
K_THETA, TWIST, BEND, STRETCH = 5, 6, 7, 8
"""Places of pivots."""
MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0, 1.0])
"""Signs of the variables in the mirror x = 0, which turns alpha into -alpha: K(-alpha) = MIRROR K(alpha) MIRROR."""


def factor(K: Array) -> Array:
    """Return L (..., m, m) of matrices K (..., m, m), m = 7 or 9, lower triangles over the variables in their order.

    A complex step goes through: with K = L L^T, dL = L (lower triangle of L^-1 dK L^-T, half its diagonal).
    """
    order = ORDER[: K.shape[-1]]
    K = K[..., order, :][..., order]
    L = np.linalg.cholesky(K.real)
    if not np.iscomplexobj(K):
        return L
    inverse = np.linalg.inv(L)
    change = np.tril(inverse @ K.imag @ np.swapaxes(inverse, -1, -2))
    change[..., range(K.shape[-1]), range(K.shape[-1])] /= 2
    return np.asarray(L + 1j * (L @ change))


def product(L: Array) -> Array:
    """Return K of a factor L, real or complex."""
    # the order is its own inverse
    L = L[..., ORDER[: L.shape[-1]], :]
    return np.asarray(L @ np.swapaxes(L, -1, -2))


def pivots(K: Array) -> Array:
    """Return the squares (..., m) of the factor's pivots."""
    return np.asarray(np.diagonal(factor(K), axis1=-2, axis2=-1) ** 2)


def scaled(
    K: Array, *, K_theta: ArrayLike | None = None, rigidity: ArrayLike | None = None, free: Sequence[int] = ()
) -> Array:
    """Return K (..., m, m) with K_theta or torque per twist (both E d^3, (...)) as given, whatever is None as it is.

    For K_theta the factor's column of that pivot is stretched, so that the other pivots stay and so does how far each
    motion goes by itself with the load. Torque per twist is given by what acts beside the joint, on the twist alone.
    ``free``: which of the strains bend, twist, lateral bend and stretch are under the torque.
    """
    L = factor(K)
    if K_theta is not None:
        L[..., K_THETA] *= np.sqrt(K_theta / L[..., K_THETA, K_THETA] ** 2)[..., None]
    found = product(L)
    if rigidity is not None:
        own, loose = L[..., TWIST, TWIST] ** 2, [row for row in loose_rows(free) if row < K.shape[-1]]
        if loose:
            across, rest = L[..., loose, TWIST], L[..., loose, BEND:]
            give = np.linalg.solve(rest @ np.swapaxes(rest, -1, -2), across[..., None])[..., 0]
            own = own / (1 + (across * give).sum(axis=-1))
        found[..., TWIST, TWIST] += rigidity - own
    return found
