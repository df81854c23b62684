"""Linear least squares under linear inequalities (Lawson and Hanson, Solving Least Squares Problems, chapter 23)."""

from __future__ import annotations

import numpy as np

from squama.model.solve import Array


def lsi(E: Array, f: Array, G: Array, h: Array) -> Array | None:
    """Return x that minimises |E x - f| under G x >= h; None where the inequalities contradict each other.

    Parameters
    ----------
    E, f : array
        Matrix (k, m) of full column rank, and vector (k,).
    G, h : array
        Matrix (c, m) and vector (c,).

    Notes
    -----
    With E = Q R and z = R x - Q^T f this is the vector of least length in a polyhedron, whose dual is one non-negative
    least squares problem.

    Examples
    --------
    >>> print(lsi(np.eye(2), np.array([2.0, 1.0]), np.array([[-1.0, 0.0]]), np.array([-0.5])))
    [0.5 1. ]
    """
    from scipy.optimize import nnls

    Q, R = np.linalg.qr(E)
    free = Q.T @ f
    start = np.linalg.solve(R, free)
    if np.all(G @ start >= h):
        return np.asarray(start)
    A = np.linalg.solve(R.T, G.T).T
    b = h - G @ start
    # rows of one size keep the small problem well scaled; one of nothing but zeros holds anyway, or never
    size = np.linalg.norm(A, axis=1)
    empty = size == 0
    if np.any(h[empty] > 0):
        return None
    A, b = A[~empty] / size[~empty, None], b[~empty] / size[~empty]
    top = max(float(np.abs(b).max()), 1e-300)
    b = b / top
    try:
        u, _ = nnls(np.vstack([A.T, b]), np.append(np.zeros(A.shape[1]), 1.0), maxiter=50 * b.size)
    except RuntimeError:
        return None
    rest = np.vstack([A.T, b]) @ u - np.append(np.zeros(A.shape[1]), 1.0)
    if abs(rest[-1]) < 1e-13:
        return None
    z = -rest[:-1] / rest[-1] * top
    x: Array = start + np.linalg.solve(R, z)
    return x
