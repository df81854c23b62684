"""The compiled functions of the real model that are called from outside, and their copies on the disk."""

from __future__ import annotations

import logging
from pathlib import Path

from squama.batch.keeping import is_ready, kept
from squama.real import follow as following
from squama.real import start
from squama.real.contact import Design
from squama.real.follow import End
from squama.types import Array

SOURCES = sorted(Path(__file__).parent.glob("*.py"))
"""All that may be compiled."""
_follow, _first = following.follow, start.first_contact


def _path(
    d: Design, begin: tuple[float, float, float], targets: Array, step: float, every: int, out: Array
) -> End:  # fmt: skip
    """Follow a path, as :func:`squama.real.follow.follow`."""
    return _follow(d, begin, targets, step, every, out)


def _contact(d: Design, most: float) -> tuple[int, int, int, float, float, float]:
    """Find the first contact, as :func:`squama.real.start.first_contact`."""
    return _first(d, most)


follow, first_contact = kept(_path, SOURCES), kept(_contact, SOURCES)
_told: list[bool] = []


def tell() -> None:
    """Say once that there is something to compile, where there is."""
    if not _told and not is_ready(follow):
        logging.getLogger("squama").warning("squama: compiling the code of the real beam, once; some seconds")
    _told.append(True)
