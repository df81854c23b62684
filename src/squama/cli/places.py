"""The files that a command is to write: looked at before anything is computed."""

from __future__ import annotations

import os
from collections.abc import Iterable

from squama.errors import Problems, refuse
from squama.io.files import label


def check_places(
    mistakes: Problems, wanted: Iterable[tuple[str | None, tuple[str, ...]]], inputs: Iterable[str]
) -> None:
    """Look at paths that are to be written, if given, each with the endings it may have; mistakes are kept."""
    from squama.io.datasets import check_place

    seen = {os.path.realpath(path): "is read too" for path in inputs}
    for path, allowed in wanted:
        if path is None:
            continue
        with mistakes.caught():
            check_place(path, allowed)
            place = os.path.realpath(path)
            if place in seen:
                refuse(label(path), "", seen[place], "give the output another name")
            seen[place] = "is given twice"
