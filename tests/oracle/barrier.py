"""General contact by a barrier, of finite elements: scales that may touch anywhere, a second way to the same states."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

from squama.model import elastic_plate

needs_barrier = pytest.mark.skipif(find_spec("ipctk") is None, reason="general contact needs ipctk (the extra fe)")
_GRID = (6, 3)


def surface(scale: Any) -> Any:
    """Return the exposed part of a scale where it may touch; None of one that is thin and rigid."""
    from squama.fe import bending
    from squama.fe.exposed import box, sheet

    if scale.elastic:
        grid = bending.lines(scale.eta, scale.beta, _GRID)
        return plate(sheet(*grid, scale.h), scale.eta, scale.beta, scale.D, scale.nu)
    return box(scale.eta, scale.beta, scale.h) if scale.h else None


def plate(surface: Any, eta: float, beta: float, D: float, nu: float, *, along: int = 7, across: int = 3) -> Any:
    """Return an exposed part that bends as a thin plate, by polynomials with powers of X from 2, moved along n_Z only.

    ``along``, ``across``: their highest powers of X and Y.
    """
    i, j = np.indices((elastic_plate.LENGTHWISE, elastic_plate.ACROSS)).reshape(2, -1)
    used = np.flatnonzero((i <= along - 2) & (j <= across))
    modes = np.zeros((len(surface.points), 3, used.size))
    values = monomials(surface.points[:, 0] / eta, surface.points[:, 1] / beta) @ elastic_plate._basis().powers
    modes[:, 2] = values[:, used]
    return surface.bending(modes, D * elastic_plate.stiffness(eta, beta, nu)[np.ix_(used, used)])


def monomials(X: Any, Y: Any) -> Any:
    """Return X^m Y^n (n, 24) at places of an elastic plate, X (n,) in 0..1 and Y (n,) in -1..1."""
    m, n = np.indices((elastic_plate.LENGTHWISE, elastic_plate.ACROSS)).reshape(2, -1)
    return X[:, None] ** (m + 2) * Y[:, None] ** n
