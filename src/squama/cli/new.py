"""squama new: a beam file to begin with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from squama.errors import InputError

EXAMPLE = Path(__file__).with_name("example.toml")


def new(beam: str, /, *, force: Annotated[bool, Parameter(help="Replace a file that is there.")] = False) -> int:
    """Write a commented example of a beam file.

    Parameters
    ----------
    beam
        The file to write, e.g. beam.toml.
    """
    from squama import files, store

    store.check_place(beam)
    if Path(beam).exists() and not force:
        message = f"{files.label(beam)}: is there already; give another name, or replace it with --force"
        raise InputError(message)
    text = EXAMPLE.read_text(encoding="utf-8")
    files.atomic_write(beam, lambda place: place.write_text(text, encoding="utf-8"))
    name = files.label(beam)
    print(f"wrote {name}; compute it with: squama twist {name}")
    return 0
