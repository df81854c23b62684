"""Reading and writing files: what goes wrong is one clear line, and nothing is left half-written."""

from __future__ import annotations

import errno
import os
import secrets
import stat
from collections.abc import Callable
from pathlib import Path

from squama.errors import InputError
from squama.units import shown

LARGEST_TEXT = 1_000_000
_WRITE_BITS = 0o222


def label(path: str | os.PathLike[str]) -> str:
    """Return a path as it is printed in a message, without quotes and on one line."""
    return shown(os.fspath(path), limit=200).strip('"')


def read_text(path: str | os.PathLike[str], *, limit: int = LARGEST_TEXT, missing: str = "check the name") -> str:
    """Read a text file in UTF-8 (with or without a byte order mark).

    Parameters
    ----------
    path : path
        The file.
    limit : int
        Largest size that is read, in bytes.
    missing : str
        What to do if there is no such file; the end of that message.

    Returns
    -------
    str
        The text; it holds more than white space.

    Raises
    ------
    InputError
        No such file, a folder, not readable, empty, larger than the limit, binary, or not UTF-8.
    """
    name = label(path)
    try:
        with Path(path).open("rb") as file:
            data = file.read(limit + 1)
    except (OSError, ValueError) as error:
        reasons = {
            errno.ENOENT: f"no such file; {missing}",
            errno.ENOTDIR: f"no such file; {missing}",
            errno.EISDIR: "is a folder; give the name of a file in it",
            errno.EACCES: "may not be read; check its permissions",
        }
        known = reasons.get(getattr(error, "errno", None) or 0)
        message = f"{name}: {known or f'cannot be read ({_why(error)})'}"
        raise InputError(message) from None
    if len(data) > limit:
        problem = f"is larger than {limit:,} bytes; check the name"
    elif b"\0" in data:
        problem = "is a binary file (or UTF-16 text); save it as plain text in UTF-8"
    elif not data.strip():
        problem = f"is empty; {missing}"
    else:
        try:
            return data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            problem = f"is not UTF-8 text (line {line}); save it in UTF-8"
    message = f"{name}: {problem}"
    raise InputError(message)


def atomic_write(path: str | os.PathLike[str], writer: Callable[[Path], object]) -> Path:
    """Write a file beside its place and move it there when it is complete.

    Parameters
    ----------
    path : path
        Where the file is to be; a file that is there is replaced, one that is read-only is not.
    writer : callable
        Writes the file to the path that it is given: a temporary name in the same folder, same ending.

    Returns
    -------
    Path
        The file's path, as given.

    Raises
    ------
    InputError
        The path is a folder, its folder is missing or read-only, the file is read-only, the disk is full, ...
        The old file, if any, is then as it was. An error of the writer that is no OSError passes unchanged.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     atomic_write(f"{folder}/a.txt", lambda place: place.write_text("whole")).read_text()
    'whole'
    """
    given = Path(path)
    try:
        # a link stays a link: the file it points to is replaced
        target = given.resolve()
        _check_place(target, label(path))
        beside = target.with_name(f".{secrets.token_hex(6)}{target.suffix[-20:]}")
    except (OSError, ValueError, RuntimeError) as error:
        if isinstance(error, InputError):
            raise
        raise _not_written(path, error) from None
    try:
        writer(beside)
        beside.replace(target)
    except OSError as error:
        raise _not_written(path, error) from None
    finally:
        beside.unlink(missing_ok=True)
    return given


def make_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder if it is not there, or refuse a place that cannot take one or its files.

    Parameters
    ----------
    path : path
        The folder; its own folder must be there.

    Returns
    -------
    Path
        The folder, as given.

    Raises
    ------
    InputError
        The path is a file, the folder or the one above is read-only, or the latter is missing.
    """
    given = Path(path)
    try:
        target = given.resolve()
        if target.exists() and not target.is_dir():
            message = f"{label(path)}: is a file; give the name of a folder"
            raise InputError(message)
        _check_place(target / "file" if target.is_dir() else target, label(path))
        target.mkdir(exist_ok=True)
    except (OSError, ValueError, RuntimeError) as error:
        if isinstance(error, InputError):
            raise
        raise _not_written(path, error) from None
    return given


def _check_place(target: Path, name: str) -> None:
    """Refuse a place that cannot take the file; mode bits are looked at because root may write anything."""
    folder = target.parent
    problem = None
    if target.is_dir():
        problem = "is a folder; give the name of a file in it"
    elif target.exists() and not target.is_file():
        problem = "is not an ordinary file; give the name of a file"
    elif target.exists() and not target.stat().st_mode & _WRITE_BITS:
        problem = "is read-only; give another name or make it writable"
    elif not folder.exists():
        problem = f"its folder {label(folder)} does not exist; make it first or give another path"
    elif not folder.is_dir():
        problem = f"{label(folder)} is not a folder; give another path"
    elif not stat.S_IMODE(folder.stat().st_mode) & _WRITE_BITS or not os.access(folder, os.W_OK):
        problem = f"its folder {label(folder)} is read-only; give another path"
    if problem:
        message = f"{name}: {problem}"
        raise InputError(message)


def _not_written(path: str | os.PathLike[str], error: Exception) -> InputError:
    if isinstance(error, OSError) and error.errno in {errno.ENOSPC, errno.EDQUOT}:
        reason = "the disk is full; make room or give another path"
    elif isinstance(error, OSError) and error.errno in {errno.EACCES, errno.EPERM, errno.EROFS}:
        reason = "the place is read-only; give another path"
    else:
        reason = f"cannot be written ({_why(error)}); give another path"
    return InputError(f"{label(path)}: {reason}")


def _why(error: Exception) -> str:
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return shown(text).strip('"').lower()
