"""Writing into a folder: files of others stay as they are, each file is complete or not there."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from squama import files
from squama.errors import InputError

RECORD = "export.json"
"""File that says what an export has written."""


def digest(data: bytes) -> str:
    """Return the SHA-256 of a file's bytes."""
    return hashlib.sha256(data).hexdigest()


def check(folder: str | os.PathLike[str], names: list[str], *, force: bool) -> None:
    """Refuse a folder that cannot be written to, or in which files of these names are not those of an export.

    Raises
    ------
    InputError
        One line per file or place.
    """
    place = Path(folder)
    if place.exists() or place.is_symlink():
        files.make_folder(place)
    elif not place.parent.is_dir():
        message = f"{files.label(folder)}: its folder {files.label(place.parent)} does not exist; make it first"
        raise InputError(message)
    known = _known(place)
    lines = []
    for name in names:
        path = place / name
        if path.is_dir():
            lines.append(f"{files.label(path)}: is a folder; give another folder to write to")
        elif path.exists() and not force and (known.get(name) is None or known[name] != digest(path.read_bytes())):
            lines.append(
                f"{files.label(path)}: is there and was not written, or was changed since, by squama export; give "
                "another folder, or --force to replace it"
            )
    if lines:
        raise InputError("\n".join(lines))


def write(
    folder: str | os.PathLike[str],
    contents: Mapping[str, bytes],
    record: Mapping[str, Any],
    look: Callable[[str, Path], None],
) -> list[Path]:
    """Write files and the record of them; ``look`` is called with each file before it is moved to its place.

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    place = files.make_folder(folder)
    hashes = {name: digest(data) for name, data in contents.items()}
    # files of an earlier export that are not written now stay known
    earlier = {name: old for name, old in _known(place).items() if name not in hashes and (place / name).is_file()}
    written = []
    for name, data in contents.items():

        def put(path: Path, name: str = name, data: bytes = data) -> None:
            path.write_bytes(data)
            look(name, path)

        written.append(files.atomic_write(place / name, put))
    text = json.dumps({**record, "files": hashes, "earlier": earlier}, indent=1, allow_nan=False) + "\n"
    written.append(files.atomic_write(place / RECORD, lambda path: path.write_text(text, encoding="utf-8")))
    return written


def _known(place: Path) -> dict[str, str | None]:
    """Return the files that exports have written, with their digests; the record itself is known by its content."""
    path = place / RECORD
    try:
        data = path.read_bytes()
        record = json.loads(data)
        if record["by"] == "squama export":
            return {**record["earlier"], **record["files"], RECORD: digest(data)}
    except (OSError, ValueError, KeyError, TypeError):
        pass
    return {}
