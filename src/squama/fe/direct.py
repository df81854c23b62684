"""Sparse symmetric systems by a direct solver: MKL Pardiso where it is installed, SciPy's SuperLU otherwise."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from squama.errors import InputError

Array = NDArray[np.float64]
_SYMMETRIC_INDEFINITE = -2
_ANALYSE_AND_FACTORISE, _FACTORISE, _SOLVE = 12, 22, 33
_BYTES = 16
"""Least bytes an entry of a factor takes, with its index."""


class Symmetric:
    """Factorises matrices of one pattern, one after another, and solves with the last one.

    Parameters
    ----------
    pattern : scipy.sparse CSR matrix
        Upper triangle with every entry of the diagonal stored, columns in order.
    """

    def __init__(self, pattern: Any) -> None:
        self._A = pattern.astype(np.float64)
        self._upper = self._A
        self._lu: Any = None
        self._pardiso: Any = None
        if find_spec("pypardiso") is not None:
            self._pardiso = import_module("pypardiso").PyPardisoSolver(mtype=_SYMMETRIC_INDEFINITE)
            # pivots are scaled and matched, as a system with multipliers needs; the order is that of nested dissection;
            # solutions are improved only where pivots were perturbed, since Newton's next step does as much
            for place, value in ((1, 1), (2, 2), (8, 0), (10, 8), (11, 1), (13, 1), (24, 0)):
                self._pardiso.set_iparm(place, value)
        self._phase = _ANALYSE_AND_FACTORISE

    def factorise(self, values: Array) -> None:
        """Factorise the matrix whose upper triangle has these values, in the order of the pattern.

        Raises
        ------
        InputError
            The matrix is singular, or there is not memory enough.
        """
        self._A.data = np.ascontiguousarray(values)
        if self._pardiso is None:
            linalg = import_module("scipy.sparse.linalg")
            sparse = import_module("scipy.sparse")
            full = (self._A + sparse.triu(self._A, 1).T).tocsc()
            try:
                self._lu = linalg.splu(full, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
            except (RuntimeError, MemoryError) as error:
                raise refused(self._A.shape[0], str(error)) from None
            return
        self._call(self._phase, np.zeros((self._A.shape[0], 1)))
        self._phase = _FACTORISE

    def solve(self, b: Array) -> Array:
        """Solve for one or more right-hand sides, (n,) or (n, m)."""
        if self._pardiso is None:
            return np.asarray(self._lu.solve(b))
        return self._call(_SOLVE, np.asfortranarray(b))

    def _call(self, phase: int, b: Array) -> Array:
        self._pardiso.set_phase(phase)
        try:
            # the public calls compare the whole matrix with the last one each time
            return np.asarray(self._pardiso._call_pardiso(self._A, b))
        except Exception as error:
            if type(error).__name__ != "PyPardisoError":
                raise
            raise refused(self._A.shape[0], str(error)) from None

    def close(self) -> None:
        """Give the memory of the factors back."""
        if self._pardiso is not None:
            self._pardiso.free_memory(everything=True)
        self._lu = None


def refused(n: int, said: str) -> InputError:
    """Return the error that says why equations could not be solved."""
    return InputError(
        f"the elements' {n} equations could not be solved ({said.strip()}): take larger elements, or give more memory"
    )
