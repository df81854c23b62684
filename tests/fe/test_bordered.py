"""Bordered systems against dense algebra, with each of the two solvers."""

import numpy as np
import pytest
from scipy import sparse

from squama.fe import bordered


@pytest.mark.parametrize("solver", ["installed", "SuperLU"])
def test_schur_complement_and_solutions(solver, monkeypatch):
    if solver == "SuperLU":
        monkeypatch.setattr(bordered, "find_spec", lambda name: None)
    n, m, dice = 60, 14, np.random.default_rng(4)
    M = dice.normal(size=(n, n)) * (dice.random((n, n)) < 0.1)
    K, B, D = M @ M.T + np.eye(n), dice.normal(size=(n, m)), dice.normal(size=(m, m))
    whole = np.block([[K, B], [B.T, D + D.T]])
    A = sparse.csr_array(np.triu(whole))
    system = bordered.Bordered(A, m)
    for factor in (1.0, -2.5):
        S = system.factorise(factor * A.data)
        np.testing.assert_allclose(S, factor * (D + D.T - B.T @ np.linalg.solve(K, B)), atol=1e-9)
        f, border = dice.normal(size=n), dice.normal(size=m)
        np.testing.assert_allclose(
            system.solve(f, border), np.linalg.solve(K, f / factor - B @ border), atol=1e-9, rtol=1e-8
        )
    if solver == "SuperLU":
        assert system.needs == 0
    system.close()
