"""A part: a beam with what supports and loads it, and how its scales differ; as a value and as a file."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from squama import arguments
from squama.beam import beamfile
from squama.beam.design import Beam
from squama.errors import Problems, refuse
from squama.io import files
from squama.part import grading, loading
from squama.units import as_text, shown


@dataclass(frozen=True)
class Part:
    """A part under load: a beam, what supports and loads it, and how its scales differ along it.

    What these say is read by :func:`squama.load`, whose arguments of the same names take the place of them.

    Parameters
    ----------
    beam : Beam
        The beam.
    load : str or sequence of str
        What loads it.
    support : str, optional
        How it is supported; "clamped" if it is not given.
    along : mapping or path, optional
        Grading: values by name, or a table (CSV) with a row for each scale.

    Raises
    ------
    InputError
        ``beam`` is no beam.
    """

    beam: Beam
    load: str | Sequence[str] = ()
    support: str | None = None
    along: grading.Grades | str | os.PathLike[str] | None = None

    def __post_init__(self) -> None:
        """Refuse what is no beam."""
        arguments.beam(self.beam)

    @classmethod
    def from_toml(
        cls, path: str | os.PathLike[str], *, overrides: Mapping[str, Mapping[str, object]] | None = None
    ) -> Self:
        """Read a part from a beam file with the sections [support], [[load]] and [along], any of which may be missing.

        Parameters
        ----------
        path : path
            The file, at most 1 MB of UTF-8.
        overrides : mapping, optional
            Values of the beam that replace those of the file, as of :meth:`squama.Beam.from_toml`.

        Returns
        -------
        Part

        Raises
        ------
        InputError
            The file cannot be used: one line per mistake, each with the file's name. Loads, supports and a table of
            scales are looked at by :func:`squama.load`.
        """
        name, text = beamfile.read(path)
        return cls.from_toml_text(text, source=name, overrides=overrides, folder=Path(path).parent)

    @classmethod
    def from_toml_text(
        cls,
        text: str,
        *,
        source: str = "part",
        overrides: Mapping[str, Mapping[str, object]] | None = None,
        folder: str | os.PathLike[str] | None = None,
    ) -> Self:
        """Read a part from the text of a file: its name in messages is `source`, other files are in `folder`.

        Without a folder the text names no file.
        """
        found, sections, problems = dict[str, Any](), dict[str, object](), Problems()
        with problems.caught():
            found["beam"] = Beam.from_toml_text(text, source=source, overrides=overrides, folder=folder)
        with problems.caught(source=source):
            sections = beamfile.sections(text)
        for name, content in sections.items():
            with problems.caught(source=source):
                found[name] = _READ[name](content, folder)
        problems.settle()
        return cls(**found)

    def graded(self, n: int) -> list[Beam]:
        """Return the beam of each of n scales, or one for all where nothing differs."""
        return grading.graded(self.beam, grading.of_scales(self.along or {}, n), n)

    def to_toml(self, path: str | os.PathLike[str] | None = None) -> str:
        """Return the part as the text of a beam file, and write that file if a path is given.

        Parameters
        ----------
        path : path, optional
            Where to write; the file is complete or not there at all.

        Returns
        -------
        str
            TOML that `from_toml` reads back; grades are SI values to the last bit, a table of scales is written out.

        Raises
        ------
        InputError
            The grading cannot be read, or the file cannot be written.
        """
        text = "\n".join([self.beam.to_toml(), *self._sections()])
        if path is not None:
            files.atomic_write(path, lambda place: place.write_text(text, encoding="utf-8"))
        return text

    def _sections(self) -> Iterator[str]:
        """Yield the sections as text."""
        if self.support is not None:
            yield f"[support]\nkind = {json.dumps(self.support)}\n"
        for words in loading.texts(self.load):
            yield f"[[load]]\ntext = {json.dumps(words.strip())}\n"
        if self.along:
            yield "[along]"
        for name, values in grading.of_scales(self.along or {}, self.beam.pitches).items():
            yield f"{name} = {json.dumps([as_text(v, beamfile.NUMBERS[name][0]) for v in values])}"


def _keys(section: str, content: object) -> dict[str, str]:
    """Return the texts under a heading of the file; refuse what is no table, no text, or not known."""
    known = beamfile.PART[section]
    if not isinstance(content, dict):
        refuse(*beamfile.no_table(section, content))
    for key, value in content.items():
        if key not in known:
            refuse(*beamfile.unknown_key(section, key))
        if not isinstance(value, str):
            refuse(f"{section}.{key}", shown(value), "is no text", f"write {key} = {known[key].example}")
    if (first := next(iter(known))) not in content:
        refuse(f"{section}.{first}", "", "is missing", f"write {first} = {known[first].example}")
    return content


def _support(content: object, _: object) -> str:
    """Return [support] as it is written in one text."""
    found = _keys("support", content)
    return ", span ".join(found[key] for key in beamfile.PART["support"] if key in found)


def _loads(content: object, _: object) -> list[str]:
    """Return the texts of [[load]]."""
    return [_keys("load", one)["text"] for one in (content if isinstance(content, list) else [content])]


def _along(content: object, folder: str | os.PathLike[str] | None) -> grading.Grades | Path:
    """Return [along]: values by name, or the table that it names."""
    if not isinstance(content, dict):
        refuse(*beamfile.no_table("along", content))
    table = content.get("table")
    if table is None:
        return grading.values(dict(_flat(content)), bare=False)
    if len(content) > 1 or not isinstance(table, str) or folder is None:
        why = "stands beside other keys" if len(content) > 1 else "must be the name of a file"
        refuse("along.table", shown(table), why, f"write {beamfile.PART['along']['table'].example} alone")
    return Path(folder) / table


def _flat(table: Mapping[str, object], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield keys and values of nested tables: scale.theta0 = [...] is a table in a table."""
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{name}.")
        else:
            yield before + name, value


_READ = {"support": _support, "load": _loads, "along": _along}
