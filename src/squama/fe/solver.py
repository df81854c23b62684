"""Sparse symmetric systems with a border: one factorisation yields the Schur complement on the border.

The matrix is [[K, B], [B^T, D]] with a small square D of m rows. Results are ``D - B^T K^-1 B`` and solutions with K
alone. The solver is MKL Pardiso where it is installed, SciPy's SuperLU otherwise. Without multipliers in K, Pardiso
yields the complement without the m solutions ``K^-1 B``; else these are made a few at a time.
"""

from __future__ import annotations

import os
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from squama.errors import InputError
from squama.types import Array

_ANALYSE, _BOTH, _FACTORISE, _SOLVE, _FORWARD, _DIAGONAL, _BACKWARD = 11, 12, 22, 33, 331, 332, 333
_CHUNK = 12
"""Number of columns of the border solved for at once."""
_COMMON = ((1, 1), (2, 2), (8, 0), (10, 8), (24, 0))
"""Pardiso parameters: nested dissection; no refinement, since the next Newton step corrects as much."""
_MATCHED = ((11, 1), (13, 1))
"""Pardiso parameters of a system with multipliers: scaling and matching of pivots."""
_COMPLEMENT = ((11, 0), (13, 0), (19, -1), (36, 2))
"""Pardiso parameters that return the Schur complement and keep the factors for solutions; no matching."""
_FREE = Path("/proc/meminfo")


class Solver:
    """Factorise matrices of one pattern, one after another, and solve with the last one.

    ``pattern``: sparse (CSR) upper triangle (n + m, n + m), with all diagonal entries stored and columns sorted, the
    border of m rows last; ``multipliers``: whether K has rows of multipliers, with zeros on its diagonal. ``needs``:
    memory of factors and factorisation, bytes, by the analysis of MKL, ``work``: floating-point operations of a
    factorisation; 0 if not known.
    """

    def __init__(self, pattern: Any, border: int, *, multipliers: bool = False) -> None:
        self._A, self._m = pattern.astype(np.float64), border
        self._n = int(self._A.shape[0]) - border
        self._lu: Any = None
        self._pardiso: Any = None
        self.needs, self.work = 0, 0.0
        self._by_columns = multipliers or find_spec("pypardiso") is None
        self._phase = _BOTH
        if find_spec("pypardiso") is None:
            return
        self._pardiso = solver = import_module("pypardiso").PyPardisoSolver(mtype=-2)
        # without it each solver looks through the whole environment again
        os.environ.setdefault("PYPARDISO_MKL_RT", solver.libmkl._name)
        for place, value in (*_COMMON, *(_MATCHED if multipliers else _COMPLEMENT)):
            solver.set_iparm(place, value)
        if multipliers:
            return
        solver.perm = np.zeros(self._n + border, np.int32)
        solver.perm[-border:] = 1
        self._call(_ANALYSE, np.zeros((self._n + border, 1)))
        permanent, working = (int(solver.get_iparm(i)) for i in (16, 17))
        self.needs = 1024 * (permanent + working)
        self.work = 1e6 * int(solver.get_iparm(19))

    def factorise(self, values: Array) -> Array:
        """Factorise with values of the pattern's entries; return the Schur complement (m, m), or refuse the matrix."""
        self._A.data = np.ascontiguousarray(values)
        m, n = self._m, self._n
        if not self._by_columns:
            self._K = self._A
            out = self._call(_FACTORISE, np.zeros((max(n + m, m * m), 1)))
            return np.array(out.ravel()[: m * m].reshape(m, m))
        self._K, self._B, D = self._A[:n, :n], self._A[:n, n:].tocsc(), self._A[n:, n:].toarray()
        if self._pardiso is not None:
            self._call(self._phase, np.zeros((n, 1)))
            self._phase = _FACTORISE
        else:
            linalg, sparse = import_module("scipy.sparse.linalg"), import_module("scipy.sparse")
            full = (self._K + sparse.triu(self._K, 1).T).tocsc()
            try:
                self._lu = linalg.splu(full, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
            except (RuntimeError, MemoryError) as error:
                raise self._refused(error) from None
        S = D + np.triu(D, 1).T
        for first in range(0, m, _CHUNK):
            part = slice(first, min(first + _CHUNK, m))
            S[:, part] -= self._B.T @ self._solved(self._B[:, part].toarray())
        return np.asarray((S + S.T) / 2)

    def solve(self, f: Array) -> Array:
        """Return ``K^-1 f`` (n,) for f (n,)."""
        if self._by_columns:
            return self._solved(f)
        half = self._call(_FORWARD, np.append(f, np.zeros(self._m)).reshape(-1, 1))
        half = self._call(_DIAGONAL, half)
        half[self._n :] = 0.0
        return self._call(_BACKWARD, half)[: self._n, 0]

    def spread(self, border: Array) -> Array:
        """Return ``K^-1 B border`` (n,) for unknowns (m,) of the border."""
        if self._by_columns:
            return self._solved(self._B @ border)
        half = np.zeros((self._n + self._m, 1))
        half[self._n :, 0] = border
        return -self._call(_BACKWARD, half)[: self._n, 0]

    def _solved(self, b: Array) -> Array:
        if self._pardiso is None:
            return np.asarray(self._lu.solve(b))
        x = self._call(_SOLVE, np.asfortranarray(b.reshape(self._n, -1)))
        return x.reshape(b.shape)

    def _call(self, phase: int, b: Array) -> Array:
        self._pardiso.set_phase(phase)
        try:
            # the public calls compare the whole matrix with the last one each time
            return np.asarray(self._pardiso._call_pardiso(self._A if phase == _ANALYSE else self._K, b))
        except Exception as error:
            if type(error).__name__ != "PyPardisoError":
                raise
            raise self._refused(error) from None

    def _refused(self, error: Exception) -> InputError:
        said = str(error).strip()
        return InputError(
            f"the elements' {self._n} equations could not be solved ({said}): take larger elements, or give more memory"
        )

    def close(self) -> None:
        """Free the memory of the factors."""
        if self._pardiso is not None:
            self._pardiso.free_memory(everything=True)
        self._lu = None


def available() -> float | None:
    """Return the free memory in bytes, or None where the system does not report it."""
    try:
        lines = _FREE.read_text().splitlines()
    except OSError:
        return None
    return next((1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:")), None)


def estimate(unknowns: int, scales: int) -> float:
    """Return the approximate memory, bytes, of a beam of elements: matrices and factors.

    Fitted to runs with MKL Pardiso, 20 000 to 270 000 unknowns, 13 000 to 77 000 a pitch; SuperLU takes several times
    as much.
    """
    return float(unknowns * (5.5e3 + 4.3e3 * (unknowns / scales / 1e4) ** 0.13))


def check_memory(scales: int, unknowns: int, needs: float) -> None:
    """Refuse a beam whose memory ``needs`` (bytes) exceeds the free memory."""
    room = available()
    if room is not None and needs > room:
        message = (
            f"a beam of {scales} scales with {unknowns} unknowns needs about {needs / 1e9:.2g} GB of memory and "
            f"{room / 1e9:.2g} GB are free: take a coarser mesh or fewer scales"
        )
        raise InputError(message)
