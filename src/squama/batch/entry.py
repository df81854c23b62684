"""The compiled function that Python calls, kept on the disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from squama import model
from squama.batch import kernel
from squama.batch.keeping import kept
from squama.model.figures import Common
from squama.types import Array

SOURCES = [f for room in (__file__, str(model.__file__)) for f in sorted(Path(room).parent.glob("*.py"))]
"""Source files that may be compiled into it; a change in any of them compiles it again."""
_answer = kernel.fill


def _fill(designs: Array, low: int, high: int, common: Common, rooms: Array, out: Array, whole: Array) -> None:
    """Solve the designs low..high, as :func:`squama.model.figures.fill`."""
    _answer(designs, low, high, common, rooms[0], out, whole)


fill = kept(_fill, SOURCES)


def room() -> Array:
    """Return a scratch record for the samples of one path."""
    return np.zeros(1, kernel.ROOM).view(np.recarray)
