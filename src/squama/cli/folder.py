"""Numbered beam files in a folder: nothing that is there is replaced unless that is asked for."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from squama.errors import InputError


def check(folder: str, *, force: bool, flag: str = "-o") -> None:
    """Refuse a folder that cannot take files, before any work.

    Raises
    ------
    InputError
        It cannot be made, or holds files ``design_*.toml`` and ``force`` is not set.
    """
    from squama import files

    place = Path(folder)
    if place.exists() and not place.is_dir():
        message = f"{flag} {files.label(folder)}: is a file; give the name of a folder"
        raise InputError(message)
    if not place.exists() and not place.resolve().parent.is_dir():
        message = f"{flag} {files.label(folder)}: its folder does not exist; make it first or give another path"
        raise InputError(message)
    there = sorted(p.name for p in place.glob("design_*.toml")) if place.is_dir() else []
    if there and not force:
        more = f" and {len(there) - 1} more" if len(there) > 1 else ""
        message = (
            f"{flag} {files.label(folder)}: holds {there[0]}{more} already; give another folder, "
            "or replace them with --force"
        )
        raise InputError(message)


def write(folder: str, texts: Iterable[str], numbers: Iterable[int] | None = None) -> list[Path]:
    """Write ``design_1.toml`` ... into a folder; files ``design_*.toml`` of an earlier run are removed."""
    from squama import files

    place = files.make_folder(folder)
    written = []
    every = list(texts)
    for number, text in zip(numbers or range(1, len(every) + 1), every, strict=True):

        def put(path: Path, text: str = text) -> object:
            return path.write_text(text, encoding="utf-8")

        written.append(files.atomic_write(place / f"design_{number}.toml", put))
    for old in place.glob("design_*.toml"):
        if old not in written:
            old.unlink()
    return written
