"""The exposed part of a scale as an elastic plate: Kirchhoff's theory, clamped at the base, by Ritz's method.

Deflections are w(x, y) = sum b_mn X^m Y^n with X = x / eta in 0..1, Y = y / beta in -1..1, m = 2..7, n = 0..3; D is
:func:`squama.model.section.plate_rigidity`. Forces act on edges, and along an edge a deflection is a polynomial in the
place. So a plate enters a contact through small tables, its compliances between the powers of the places on the two
edges that meet, and the number of modes costs nothing there.

With D = 1, eta = 3, beta = .6, nu_s = .35 the compliances at the tip (y = -.15), at the side (x = 2.2), and of one by
the other are 8.1407, 3.5321 and 4.9569; converged plate elements give 8.2090, 3.5724 and 4.9987.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre, polynomial
from numpy.typing import ArrayLike

from squama.types import Array

LENGTHWISE, ACROSS, POWERS = 6, 4, 6
"""Powers along the length, X^2 .. X^7, and across, Y^0 .. Y^3; room for the powers of a place on an edge."""
TIP, SIDE_D, SIDE_A, BASE = range(4)
"""Edges by number: tip C-B, side D-C (y = -beta), side A-B (y = beta), base D-A."""
FIRST = (0, 2, 2, 0)
"""Lowest power of the place in a deflection along each edge."""


class _Basis(NamedTuple):
    """Integrals of products of derivatives of orthogonal polynomials along x and y, and changes to powers.

    ``edges`` (4, 24, 6): powers of the place along each edge for each polynomial; ``powers`` (24, 24): b_mn of each.
    """

    x: dict[tuple[int, int], Array]
    y: dict[tuple[int, int], Array]
    edges: Array
    powers: Array


@functools.cache
def _basis() -> _Basis:
    # Legendre's, for monomials alone are nearly dependent
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
    rows, columns = np.zeros((LENGTHWISE, POWERS)), np.zeros((ACROSS, ACROSS))
    for i, p in enumerate(half):
        rows[i, : i + 1] = p[2:]
    for j, p in enumerate(across):
        columns[j, : j + 1] = p
    edges = np.zeros((4, LENGTHWISE * ACROSS, POWERS))
    edges[TIP, :, :ACROSS] = np.kron(rows.sum(1)[:, None], columns)
    signs = (-1.0) ** np.arange(ACROSS)
    edges[SIDE_D], edges[SIDE_A] = np.kron(rows, signs[:, None]), np.kron(rows, np.ones((ACROSS, 1)))
    return _Basis(x, y, edges, np.kron(rows, columns).T)


def _products(polys: list[Array], m: int, n: int, low: float, high: float) -> Array:
    out = np.empty((len(polys), len(polys)))
    for i, p in enumerate(polys):
        for j, q in enumerate(polys):
            whole = polynomial.polyint(polynomial.polymul(polynomial.polyder(p, m), polynomial.polyder(q, n)))
            out[i, j] = polynomial.polyval(high, whole) - polynomial.polyval(low, whole)
    return out


def monomials(X: Array, Y: Array) -> Array:
    """Return X^m Y^n (n, 24) at places of the plate, X (n,) in 0..1 and Y (n,) in -1..1."""
    m, n = np.indices((LENGTHWISE, ACROSS)).reshape(2, -1)
    return np.asarray(X[:, None] ** (m + 2) * Y[:, None] ** n)


def polynomials(X: Array, Y: Array) -> Array:
    """Return the polynomials (n, 24) by which the plate bends at such places."""
    return np.asarray(monomials(X, Y) @ _basis().powers)


def curvatures(X: Array, Y: Array) -> Array:
    """Return what makes w,XX, w,YY and w,XY (3, 24, n) at places of the plate of the powers b_mn (.., 24)."""
    m, n = np.indices((LENGTHWISE, ACROSS)).reshape(2, -1, 1)
    m += 2
    along = [X**m, m * X ** (m - 1), m * (m - 1) * X ** (m - 2)]
    over = [Y**n, n * Y ** np.maximum(n - 1, 0), n * (n - 1) * Y ** np.maximum(n - 2, 0)]
    return np.array([along[2] * over[0], along[0] * over[2], along[1] * over[1]])


def stiffness(eta: ArrayLike, beta: ArrayLike, nu: ArrayLike) -> Array:
    """Return the stiffness (..., 24, 24) of the polynomials for D = 1, by the energy of Kirchhoff's plate.

    That is half the integral of w_xx^2 + w_yy^2 + 2 nu w_xx w_yy + 2 (1 - nu) w_xy^2.
    """
    x, y = _basis()[:2]
    eta, beta, nu = (np.asarray(v)[..., None, None] for v in (eta, beta, nu))
    mixed = np.kron(x[2, 0], y[0, 2])
    return np.asarray(
        beta / eta**3 * np.kron(x[2, 2], y[0, 0])
        + eta / beta**3 * np.kron(x[0, 0], y[2, 2])
        + (nu * (mixed + mixed.T) + 2 * (1 - nu) * np.kron(x[1, 1], y[1, 1])) / (eta * beta)
    )


def answers(eta: Array, beta: Array, nu: Array) -> tuple[Array, Array]:
    """Return what forces on edges do to plates of D = 1.

    Parameters
    ----------
    eta, beta, nu : (n,) arrays
        Length and half width of the plates, Poisson's ratio.

    Returns
    -------
    compliances : (n, 4, 4, 6, 6) array
        Power a of a place on one edge, by edges (see ``TIP`` ..), under a unit force times power b of its place on
        another one.
    shapes : (n, 4, 24, 6) array
        The deflection's b_mn, m first, under the same force.
    """
    edges, powers = _basis()[2:]
    K = stiffness(eta, beta, nu)
    right = np.concatenate(list(edges), axis=1)
    bent = np.empty((*K.shape[:-2], *right.shape), K.dtype)
    # deflections even and odd across the width know nothing of each other
    for parity in range(2):
        one = np.flatnonzero(np.arange(LENGTHWISE * ACROSS) % 2 == parity)
        bent[..., one, :] = np.linalg.solve(K[..., one, :][..., one], right[one])
    compliances = (right.T @ bent).reshape(*K.shape[:-2], 4, POWERS, 4, POWERS)
    shapes = (powers @ bent).reshape(*K.shape[:-2], -1, 4, POWERS)
    return np.moveaxis(compliances, -2, -3), np.moveaxis(shapes, -2, -3)
