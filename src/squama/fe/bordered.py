"""Sparse symmetric systems with a border: one factorisation gives the dense rest on the border (Schur complement).

The matrix is [[K, B], [B^T, D]] with a small square D of m rows. Wanted are ``D - B^T K^-1 B`` and solutions with K
alone. MKL Pardiso yields both without the m solutions ``K^-1 B``; elsewhere these are made a few at a time.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from squama.fe.direct import Array, refused

_ANALYSE, _FACTORISE, _FORWARD, _DIAGONAL, _BACKWARD = 11, 22, 331, 332, 333
_CHUNK = 12
"""Columns of the border that are solved for at once where there is no MKL."""
_KEEP = 2
"""The Schur complement is returned, and the factors stay for solutions."""


class Bordered:
    """Factorises matrices of one pattern, one after another, and solves with the last one.

    Parameters
    ----------
    pattern : scipy.sparse CSR matrix, (n + m, n + m)
        Upper triangle with every entry of the diagonal stored, columns in order; the border last.
    border : int
        Number m of rows of the border.

    Attributes
    ----------
    needs : int
        Bytes that factors and factorisation take, by the analysis of MKL; 0 where it is not installed.
    work : float
        Operations of a factorisation, likewise.
    """

    def __init__(self, pattern: Any, border: int) -> None:
        self._A, self._m = pattern.astype(np.float64), border
        self._lu: Any = None
        self._pardiso: Any = None
        self.needs, self.work = 0, 0.0
        if find_spec("pypardiso") is None:
            return
        self._pardiso = solver = import_module("pypardiso").PyPardisoSolver(mtype=-2)
        # nested dissection, no matching: there are no multipliers
        for place, value in ((1, 1), (2, 2), (8, 0), (10, 8), (11, 0), (13, 0), (19, -1), (24, 0), (36, _KEEP)):
            solver.set_iparm(place, value)
        solver.perm = np.zeros(self.size, np.int32)
        solver.perm[-border:] = 1
        self._call(_ANALYSE, np.zeros((self.size, 1)))
        permanent, working = (int(solver.get_iparm(i)) for i in (16, 17))
        self.needs = 1024 * (permanent + working)
        self.work = 1e6 * int(solver.get_iparm(19))

    @property
    def size(self) -> int:
        """Number of rows, the border's included."""
        return int(self._A.shape[0])

    def factorise(self, values: Array) -> Array:
        """Take the values of the pattern's entries, and return the Schur complement (m, m).

        Raises
        ------
        InputError
            The matrix is singular, or there is not memory enough.
        """
        self._A.data = np.ascontiguousarray(values)
        m, n = self._m, self.size - self._m
        if self._pardiso is not None:
            out = self._call(_FACTORISE, np.zeros((max(self.size, m * m), 1)))
            return np.array(out.ravel()[: m * m].reshape(m, m))
        linalg, sparse = import_module("scipy.sparse.linalg"), import_module("scipy.sparse")
        K = self._A[:n, :n]
        try:
            self._lu = linalg.splu(
                (K + sparse.triu(K, 1).T).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
            )
        except (RuntimeError, MemoryError) as error:
            raise refused(n, str(error)) from None
        B, D = self._A[:n, n:].tocsc(), self._A[n:, n:].toarray()
        S = D + np.triu(D, 1).T
        for first in range(0, m, _CHUNK):
            part = slice(first, min(first + _CHUNK, m))
            S[:, part] -= B.T @ self._lu.solve(B[:, part].toarray())
        return np.asarray((S + S.T) / 2)

    def solve(self, f: Array, border: Array) -> Array:
        """Return ``K^-1 (f - B border)`` for f (n,) and the border's unknowns (m,)."""
        n = f.size
        if self._pardiso is None:
            return np.asarray(self._lu.solve(f - self._A[:n, n:] @ border))
        half = self._call(_FORWARD, np.append(f, np.zeros(self._m)).reshape(-1, 1))
        half = self._call(_DIAGONAL, half)
        half[n:, 0] = border
        return self._call(_BACKWARD, half)[:n, 0]

    def _call(self, phase: int, b: Array) -> Array:
        self._pardiso.set_phase(phase)
        try:
            return np.asarray(self._pardiso._call_pardiso(self._A, b))
        except Exception as error:
            if type(error).__name__ != "PyPardisoError":
                raise
            raise refused(self.size, str(error)) from None

    def close(self) -> None:
        """Give the memory of the factors back."""
        if self._pardiso is not None:
            self._pardiso.free_memory(everything=True)
        self._lu = None
