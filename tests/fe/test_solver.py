"""Bordered systems against dense algebra, with each of the two solvers."""

from importlib.util import find_spec

import numpy as np
import pytest
from scipy import sparse

from squama.fe import solver


@pytest.mark.parametrize("multipliers", [False, True], ids=["definite", "with multipliers"])
@pytest.mark.parametrize("where", ["installed", "SuperLU"])
def test_schur_complement_and_solutions(where, multipliers, monkeypatch):
    if where == "SuperLU":
        monkeypatch.setattr(solver, "find_spec", lambda name: None)
    n, m, dice = 60, 14, np.random.default_rng(4)
    M = dice.normal(size=(n, n)) * (dice.random((n, n)) < 0.1)
    K, B, D = M @ M.T + np.eye(n), dice.normal(size=(n, m)), dice.normal(size=(m, m))
    zero = 1.0
    if multipliers:
        K[-3:, -3:], zero = 0.0, 0.0
    whole = np.block([[K, B], [B.T, D + D.T]])
    pattern = np.triu(whole)
    # zeros on the diagonal are stored
    pattern[range(n - 3, n), range(n - 3, n)] += 1 - zero
    A = sparse.csr_array(pattern)
    A.data[A.indptr[n - 3 : n]] -= 1 - zero
    system = solver.Solver(A, m, multipliers=multipliers)
    for factor in (1.0, -2.5):
        S = system.factorise(factor * A.data)
        np.testing.assert_allclose(S, factor * (D + D.T - B.T @ np.linalg.solve(K, B)), atol=1e-9)
        f, border = dice.normal(size=n), dice.normal(size=m)
        np.testing.assert_allclose(system.solve(f), np.linalg.solve(K, f / factor), atol=1e-9, rtol=1e-8)
        np.testing.assert_allclose(system.spread(border), np.linalg.solve(K, B @ border), atol=1e-9, rtol=1e-8)
    assert (system.needs > 0) == (where == "installed" and not multipliers and find_spec("pypardiso") is not None)
    system.close()


@pytest.mark.skipif(find_spec("pypardiso") is None, reason="the analysis is that of MKL")
def test_the_work_of_a_full_matrix_is_a_third_of_its_cube():
    n = 400
    system = solver.Solver(sparse.csr_array(np.triu(np.ones((n, n)) + n * np.eye(n))), 2)
    # tolerance: MKL's own count of operations, 27 % above the third of a cube
    assert system.work == pytest.approx(n**3 / 3, rel=0.3)
    system.close()
