"""General contact by a barrier, of finite elements: scales that may touch anywhere, a second way to the same states."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import pytest

needs_barrier = pytest.mark.skipif(find_spec("ipctk") is None, reason="general contact needs ipctk (the extra fe)")
_GRID = (6, 3)


def surface(scale: Any) -> Any:
    """Return the exposed part of a scale where it may touch; None of one that is thin and rigid."""
    from squama.fe import bending
    from squama.fe.exposed import box, sheet

    if scale.elastic:
        grid = bending.lines(scale.eta, scale.beta, _GRID)
        return bending.plate(sheet(*grid, scale.h), scale.eta, scale.beta, scale.D, scale.nu)
    return box(scale.eta, scale.beta, scale.h) if scale.h else None
