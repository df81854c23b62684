"""Linear equations of a row against dense ones by numpy: pivots that are zero, exchanged columns, border."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from squama.contacts.linear import FILLED, INNER, Linear, factor, substitute


@numba.njit
def solved(J, n, x):
    found = factor(J, n)
    if found:
        substitute(J, n, x)
    return found


def banded(r, sizes, border):
    """Return a matrix whose cells are coupled to the next ones, bordered; without pivots on most of its diagonal."""
    ends = np.concatenate([[0], np.cumsum(sizes)])
    inner, n = ends[-1], ends[-1] + border
    A = np.zeros((n, n))
    for i in range(len(sizes)):
        own, near = slice(ends[i], ends[i + 1]), slice(ends[max(0, i - 1)], ends[min(len(sizes), i + 2)])
        A[own, near] = r.normal(size=(own.stop - own.start, near.stop - near.start))
    A[r.random(A.shape) < 0.5] = 0.0
    A[np.arange(inner), np.arange(inner)] *= r.random(inner) < 0.3
    A[inner:], A[:, inner:] = r.normal(size=(border, n)), r.normal(size=(n, border))
    return A, ends


def packed(A, ends):
    n, inner, cells = len(A), ends[-1], len(ends) - 1
    rows, filled, band = np.zeros((3, n), int), 0, []
    for i in range(cells):
        low, high = ends[max(0, i - 2)], ends[min(cells, i + 2)]
        for a in range(ends[i], ends[i + 1]):
            rows[:, a] = filled - low, low, high
            filled += high - low
            band.append(A[a, low:high])
    kept = np.zeros(5, int)
    kept[INNER], kept[FILLED] = inner, filled
    border = (A[:, inner:].T.copy(), A[inner:].copy(), A[inner:, inner:].copy())
    order, last = np.zeros(n, int), np.zeros(n, int)
    return Linear(
        np.concatenate(band), *border, order, last, rows, np.zeros(n), np.zeros(cells, int), kept, np.zeros(1)
    )


@pytest.mark.parametrize("border", [0, 1, 4])
@pytest.mark.parametrize("seed", range(5))
def test_it_solves_as_dense_equations_do(seed, border):
    r = np.random.default_rng([seed, border])
    A, ends = banded(r, r.integers(3, 12, 7), border)
    x = r.normal(size=len(A))
    b = A @ x
    assert solved(packed(A, ends), len(A), b)
    # tolerance: rounding, times the condition of the matrix
    assert np.abs(b - x).max() < 1e-13 * np.linalg.cond(A)


def test_a_singular_matrix_is_told():
    r = np.random.default_rng(1)
    A, ends = banded(r, [5, 5, 5], 1)
    A[7, :] = 0.0
    assert not solved(packed(A, ends), len(A), np.ones(len(A)))
    A, ends = banded(r, [5, 5, 5], 1)
    A[15, :] = 0.0
    assert not solved(packed(A, ends), len(A), np.ones(len(A)))
