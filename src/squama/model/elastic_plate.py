"""The exposed part of a scale as an elastic plate: Kirchhoff's theory, clamped at the base, by Ritz's method.

Deflections are w(x, y) = sum b_mn X^m Y^n with X = x / eta in 0..1, Y = y / beta in -1..1, m = 2..7, n = 0..3; D is
:func:`squama.model.section.plate_rigidity`. A force loads each power by its value at the force's place, so the contact
only needs a small table of the plate; along an edge the deflection is a polynomial of the place, and the table for two
edges in contact is smaller still (:mod:`squama.contacts.equations`).

Check, with D = 1, eta = 3, beta = .6, nu_s = .35: the compliance at the tip (y = -.15), at the side (x = 2.2), and
between the two are 8.1407, 3.5321 and 4.9569; converged plate elements give 8.2090, 3.5724 and 4.9987.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre, polynomial
from numpy.typing import ArrayLike

from squama.types import Array

LENGTHWISE, ACROSS = 6, 4
"""Numbers of powers along the length, X^2 .. X^7, and across, Y^0 .. Y^3."""
TIP, SIDE_D, SIDE_A, BASE = range(4)
"""Numbers of the edges: tip C-B, side D-C (y = -beta), side A-B (y = beta), base D-A."""


class _Basis(NamedTuple):
    """Integrals of products of derivatives of the polynomials along x and y, and coefficients b_mn of each (24, 24)."""

    x: dict[tuple[int, int], Array]
    y: dict[tuple[int, int], Array]
    powers: Array


@functools.cache
def _basis() -> _Basis:
    # Legendre polynomials, because monomials are nearly dependent
    half: list[Array] = []
    for i in range(LENGTHWISE):
        p: Array = np.zeros(1)
        for c in legendre.leg2poly([0] * i + [1])[::-1]:
            p = polynomial.polyadd(polynomial.polymul(p, [-1.0, 2.0]), [c])
        half.append(np.concatenate([[0.0, 0.0], p[: i + 1]]))
    across = [legendre.leg2poly([0] * j + [1]) for j in range(ACROSS)]
    orders = ((0, 0), (1, 1), (2, 2), (0, 2), (2, 0))
    x = {(m, n): _products(half, m, n, 0.0, 1.0) for m, n in orders}
    y = {(m, n): _products(across, m, n, -1.0, 1.0) for m, n in orders}
    rows, columns = np.zeros((LENGTHWISE, LENGTHWISE)), np.zeros((ACROSS, ACROSS))
    for i, p in enumerate(half):
        rows[i, : i + 1] = p[2:]
    for j, p in enumerate(across):
        columns[j, : j + 1] = p
    return _Basis(x, y, np.kron(rows, columns).T)


def _products(polys: list[Array], m: int, n: int, low: float, high: float) -> Array:
    out = np.empty((len(polys), len(polys)))
    for i, p in enumerate(polys):
        for j, q in enumerate(polys):
            whole = polynomial.polyint(polynomial.polymul(polynomial.polyder(p, m), polynomial.polyder(q, n)))
            out[i, j] = polynomial.polyval(high, whole) - polynomial.polyval(low, whole)
    return out


def curvatures(X: Array, Y: Array) -> Array:
    """Return the derivatives w,XX, w,YY and w,XY (3, 24, n) of the powers X^m Y^n at places of the plate, X, Y (n,)."""
    m, n = np.indices((LENGTHWISE, ACROSS)).reshape(2, -1, 1)
    m += 2
    along = [X**m, m * X ** (m - 1), m * (m - 1) * X ** (m - 2)]
    over = [Y**n, n * Y ** np.maximum(n - 1, 0), n * (n - 1) * Y ** np.maximum(n - 2, 0)]
    return np.array([along[2] * over[0], along[0] * over[2], along[1] * over[1]])


def stiffness(eta: ArrayLike, beta: ArrayLike, nu: ArrayLike) -> Array:
    """Return the stiffness (..., 24, 24) over the polynomials for D = 1, from the energy of Kirchhoff's plate.

    The energy is half the integral of w_xx^2 + w_yy^2 + 2 nu w_xx w_yy + 2 (1 - nu) w_xy^2.
    """
    x, y = _basis()[:2]
    eta, beta, nu = (np.asarray(v)[..., None, None] for v in (eta, beta, nu))
    mixed = np.kron(x[2, 0], y[0, 2])
    return np.asarray(
        beta / eta**3 * np.kron(x[2, 2], y[0, 0])
        + eta / beta**3 * np.kron(x[0, 0], y[2, 2])
        + (nu * (mixed + mixed.T) + 2 * (1 - nu) * np.kron(x[1, 1], y[1, 1])) / (eta * beta)
    )


def compliances(eta: Array, beta: Array, nu: Array) -> Array:
    """Return the coefficients b_mn (n, 24, 24), m first, of plates of D = 1 under unit loads on the powers X^m Y^n.

    The arguments are (n,). A force loads each power by its value X^m Y^n at the force's place.
    """
    powers = _basis().powers
    return np.asarray(powers @ np.linalg.inv(stiffness(eta, beta, nu)) @ powers.T)
