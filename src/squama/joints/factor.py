"""A joint's stiffness K (9, 9) and its Cholesky factor, whose pivots are the joint's named stiffnesses.

Variables: the scale's motions (u_X, u_Y, u_Z, w_X, w_Y, w_Z), the twist phi, the bend psi and the stretch epsilon, all
per pitch (:mod:`squama.fe.pitch_stiffness`); E = 1, d = 1. With the variables in the :data:`ORDER` u_X, u_Y, u_Z, w_X,
w_Z, w_Y, phi, psi, epsilon and K = L L^T, the square of a pivot is the stiffness of its variable, with the variables
before it free and those behind it held:
    of w_Y       K_theta = 1 / (A^-1)_55, A the six motions' part
    of phi       the torque per twist of the pitch, the scale free, neither bent nor stretched
    of psi       the moment per bend, the scale and the twist free
    of epsilon   the tension per stretch, all else free.
The energy is 1/2 sum_j (pivot_j (x_j + sum_i c_ij x_i))^2 with c_ij = L_ij / L_jj: a free x_j follows each x_i behind
it by -c_ij x_i.
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
"""Indices of the pivots in the factor."""
MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0, 1.0])
"""Signs of the variables under the mirror x -> -x, which turns alpha into -alpha: K(-alpha) = MIRROR K(alpha) MIRROR.
"""


def factor(K: Array) -> Array:
    """Return the lower triangular factors L (..., m, m), m = 7 or 9, of matrices K, variables in the :data:`ORDER`.

    Complex steps are carried through: with K = L L^T, dL = L (lower triangle of L^-1 dK L^-T, half its diagonal).
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
    """Return K (..., m, m) from its factor L, real or complex."""
    # the order is its own inverse
    L = L[..., ORDER[: L.shape[-1]], :]
    return np.asarray(L @ np.swapaxes(L, -1, -2))


def pivots(K: Array) -> Array:
    """Return the squared pivots (..., m) of K, which are stiffnesses."""
    return np.asarray(np.diagonal(factor(K), axis1=-2, axis2=-1) ** 2)


def scaled(
    K: Array, *, K_theta: ArrayLike | None = None, rigidity: ArrayLike | None = None, free: Sequence[int] = ()
) -> Array:
    """Return K (..., m, m) with a prescribed K_theta or torque per twist (both over E d^3, (...)); None leaves it.

    For K_theta the factor's column of that pivot is scaled, so that the other pivots and the ratios c_ij are unchanged.
    The torque per twist is corrected on the diagonal of the twist alone, as by a spring beside the joint. ``free``:
    flags of the strains bend, twist, lateral bend and stretch that are free under the torque.
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
