"""Reading and writing of files: an error is one clear line, and no file is left half-written."""

from __future__ import annotations

import codecs
import errno
import functools
import hashlib
import os
import re
import secrets
import select
import stat
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import TextIO

from squama.errors import InputError, Problem, Problems
from squama.units import shown

LARGEST_TEXT = 1_000_000
STANDARD, INPUT = "-", "/dev/stdin"
"""Names of the standard output and the standard input; on a command line "-" is either."""
_MOST_INPUT = 100_000_001
"""Largest number of bytes read from the standard input: more than any reader accepts."""
SEAL = b"\nsquama sha256 %s\n"
"""End of binary files, after the data: the hash of all bytes before it."""
SEALED = len(SEAL % bytes(64))
"""Length of the seal, bytes."""
_WRITE_BITS = 0o222
_HIDDEN = ".squama-"
_LEFT = re.compile(re.escape(_HIDDEN) + r"[0-9a-f]{12}.{0,20}", re.DOTALL)
"""Pattern of temporary names of files."""
_TRIES, _PAUSE = 50, 0.02
"""Number of attempts, and seconds between them, to lock a folder in which another writer removes leftovers."""
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1b]")
"""Characters that do not occur in tables of text."""
_PLACE = (OSError, ValueError, RuntimeError)
"""Errors of inspecting a place; Path.resolve raises RuntimeError for a loop of links."""
PATIENCE = 30.0
"""Seconds without a byte after which a pipe is abandoned."""
_HEAD = 1000
"""Number of bytes from which an encoding is guessed."""
_ODD = "is not an ordinary file"
_WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_PLAIN, _ELSEWHERE = "save it as plain text in UTF-8", "give another path"
Known = Mapping[int, tuple[str, str]]
"""Reason and remedy by system error number."""
_ALWAYS: Known = {
    errno.ELOOP: ("is a loop of symbolic links", "give the name of a file"),
    errno.ENAMETOOLONG: ("is too long for a name", "give a shorter one"),
}
"""Errors of a name, in reading and writing."""
_TO_READ: Known = {
    errno.EISDIR: ("is a folder", "give the name of a file in it"),
    errno.EACCES: ("may not be read", "check its permissions"),
}
_TO_WRITE: Known = {
    **dict.fromkeys((errno.ENOSPC, errno.EDQUOT), ("the disk is full", "make room or give another path")),
    **dict.fromkeys((errno.EACCES, errno.EPERM, errno.EROFS), ("the place is read-only", _ELSEWHERE)),
}


def place(value: object, example: str, name: str = "path") -> None:
    """Refuse a value that is neither a path nor text."""
    if not isinstance(value, str | os.PathLike) or isinstance(os.fspath(value), bytes):
        raise InputError(Problem(name, "", f"is of type {type(value).__name__}, not a path", f'write e.g. "{example}"'))


def label(path: str | os.PathLike[str]) -> str:
    """Return a path as printed in messages, without quotes and on one line."""
    return "standard input" if os.fspath(path) == INPUT else shown(os.fspath(path), limit=200).strip('"')


def folder_of(path: str | os.PathLike[str]) -> Path:
    """Return the folder to which names in a file are relative; for the standard input the current one."""
    return Path() if os.fspath(path) == INPUT else Path(path).parent


def read_text(path: str | os.PathLike[str], *, limit: int = LARGEST_TEXT, missing: str = "check the name") -> str:
    """Return the text of a UTF-8 file (with or without a byte order mark).

    Refuses a missing file (remedy: ``missing``), a folder, and a file that is not readable, empty, larger than the
    limit in bytes, binary, or not UTF-8.
    """
    data = read_bytes(path, limit + 1, missing=missing)
    _check_text(path, data, limit, missing)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise _error(path, f"is not UTF-8 text (line {line})", "save it in UTF-8") from None


def any_text(path: str | os.PathLike[str], data: bytes, *, limit: int = LARGEST_TEXT) -> tuple[str, str]:
    """Return text and encoding of a file's bytes: UTF-8, UTF-16, else latin-1.

    Refuses files as :func:`read_text` does, and text with control characters.
    """
    encoding = "utf-16" if data.startswith(_WIDE) else _unmarked(data) or "utf-8"
    _check_text(path, data, limit, wide=encoding.startswith("utf-16"))
    try:
        text = data.decode("utf-8-sig" if encoding == "utf-8" else encoding)
    except UnicodeDecodeError:
        if encoding != "utf-8":
            raise _error(path, "begins as UTF-16 text but is none", _PLAIN) from None
        text, encoding = data.decode("latin-1"), "latin-1"
    if _CONTROL.search(text):
        raise _error(path, "is a binary file", _PLAIN)
    return text, encoding


def _unmarked(data: bytes) -> str:
    """Return the encoding of UTF-16 text without a byte order mark, nearly every second byte of which is 0; else ""."""
    head = data[:_HEAD]
    for encoding, low, high in (("utf-16-le", head[::2], head[1::2]), ("utf-16-be", head[1::2], head[::2])):
        if len(data) % 2 == 0 and b"\0" not in low and high.count(0) > 0.8 * len(high) > 0:
            return encoding
    return ""


def _check_text(
    path: str | os.PathLike[str], data: bytes, limit: int, missing: str = "check the name", *, wide: bool = False
) -> None:
    """Refuse bytes of a text that are too many, empty or binary (``wide``: UTF-16 is allowed)."""
    if len(data) > limit:
        raise _error(path, f"is larger than {limit:,} bytes", "check the name")
    if not data.strip():
        raise _error(path, "is empty", missing)
    if b"\0" in data and not wide:
        raise _error(path, "is a binary file (or UTF-16 text)", _PLAIN)


def read_bytes(path: str | os.PathLike[str], most: int, *, missing: str = "check the name") -> bytes:
    """Return the first ``most`` bytes of a file or a pipe; errors as from :func:`read_text`.

    Waits for a pipe, up to :data:`PATIENCE` seconds for each part; refuses a device, which may have no end. The
    standard input may be read repeatedly.
    """
    if os.fspath(path) == INPUT:
        return _standard_input(sys.stdin)[:most]
    with _reading(path, missing), open(path, "rb", buffering=0, opener=_at_once) as file:
        mode = os.fstat(file.fileno()).st_mode
        if stat.S_ISCHR(mode) or stat.S_ISBLK(mode):
            raise _error(path, "is a device", "give the name of a file")
        found, waited = bytearray(), not stat.S_ISFIFO(mode)
        while len(found) < most:
            part = file.read(most - len(found))
            if part:
                found += part
            elif part == b"" and waited:
                break
            elif not select.select([file], [], [], PATIENCE)[0]:
                reason = f"is a pipe into which nothing was written for {PATIENCE:g} s"
                raise _error(path, reason, "give the name of a file")
            # an empty read at first may mean that no process has opened the pipe for writing yet
            waited = True
        return bytes(found)


@functools.lru_cache(maxsize=1)
def _standard_input(stream: TextIO | None) -> bytes:
    """Return the bytes of the standard input, read once per stream."""
    if stream is None or not hasattr(stream, "buffer"):
        raise _error(INPUT, "is closed", "give the name of a file")
    return stream.buffer.read(_MOST_INPUT)


def read_ordinary(path: str | os.PathLike[str], most: int) -> bytes:
    """Return the bytes of an ordinary file of at most ``most`` bytes; raise OSError at once for any other."""
    with open(path, "rb", buffering=0, opener=_at_once) as file:
        found = os.fstat(file.fileno())
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, _ODD)
        if found.st_size > most:
            raise OSError(errno.EFBIG, f"is larger than {most:,} bytes")
        return file.read(found.st_size) or b""


def sealed(data: bytes) -> bytes:
    """Return the data with their seal.

    >>> len(sealed(b"data")) == 4 + SEALED, unsealed(sealed(b"data"))
    (True, b'data')
    """
    return data + SEAL % hashlib.sha256(data).hexdigest().encode()


def unsealed(data: bytes) -> bytes:
    """Return the data without their seal. Raises ValueError for a wrong or missing seal."""
    if data != sealed(data[:-SEALED]):
        raise ValueError(SEAL)
    return data[:-SEALED]


def regular(path: str | os.PathLike[str]) -> int:
    """Return the size of an ordinary file in bytes; refuse anything else, and files that cannot be read."""
    read_bytes(path, 0)
    with _reading(path, "check the name"):
        found = Path(path).stat()
    if not stat.S_ISREG(found.st_mode):
        raise _error(path, _ODD, "give the name of a file")
    return found.st_size


def exists(path: str | os.PathLike[str]) -> bool:
    """Return whether a file or folder exists; refuse an impossible name."""
    with _reading(path, "check the name"):
        try:
            # a loop of links is refused; Path.exists would return False
            Path(path).stat()
        except (FileNotFoundError, NotADirectoryError):
            return False
        return True


def _at_once(path: str, flags: int) -> int:
    """Open a file without waiting for the writer of a pipe."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


@contextmanager
def naming(
    path: str | os.PathLike[str], known: Known, other: tuple[str, str], kinds: tuple[type[Exception], ...] = _PLACE
) -> Iterator[None]:
    """Turn a system error into an InputError that names the path, with a known reason or ``other``."""
    try:
        yield
    except InputError:
        raise
    except kinds as error:
        number = errno.ELOOP if isinstance(error, RuntimeError) else getattr(error, "errno", None)
        said = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        reason, remedy = other
        because = f"{reason} ({shown(said).strip(chr(34)).lower()})", remedy
        raise _error(path, *{**_ALWAYS, **known}.get(number or 0, because)) from None


def _reading(path: str | os.PathLike[str], missing: str) -> AbstractContextManager[None]:
    """Name the path in errors of reading; ``missing``: remedy for a missing file."""
    none = "no such file", missing
    return naming(path, {**_TO_READ, errno.ENOENT: none, errno.ENOTDIR: none}, ("cannot be read", ""))


def _writing(path: str | os.PathLike[str], kinds: tuple[type[Exception], ...] = _PLACE) -> AbstractContextManager[None]:
    """Name the path in errors of writing; errors of other kinds pass."""
    return naming(path, _TO_WRITE, ("cannot be written", _ELSEWHERE), kinds)


def atomic_write(path: str | os.PathLike[str], writer: Callable[[Path], object]) -> Path:
    """Write a file beside its place and rename it when it is complete; return its path as given.

    ``writer`` gets a temporary path in the same folder with the same extension; leftovers of killed writers are
    removed. A place that cannot hold the file (a folder, read-only, disk full, ...) raises InputError and leaves an old
    file unchanged; errors of the writer other than OSError pass unchanged.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     atomic_write(f"{folder}/a.txt", lambda place: place.write_text("whole")).read_text()
    'whole'
    """
    target, beside = _places(path)
    try:
        with _writing(path, (OSError,)), _at_work(target.parent):
            writer(beside)
            beside.replace(target)
    finally:
        beside.unlink(missing_ok=True)
    return Path(path)


def try_place(path: str | os.PathLike[str]) -> None:
    """Refuse a path that :func:`atomic_write` could not write; nothing is left there."""
    beside = _places(path)[1]
    with _writing(path, (OSError,)):
        beside.touch()
        beside.unlink()


def make_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder if it is missing, and return it; refuse a place that cannot hold it or its files."""
    with _writing(path):
        target = Path(path).resolve()
        if os.fspath(path) == STANDARD:
            raise _error(path, "is standard output, which holds no folder", "give the name of a folder")
        if target.exists() and not target.is_dir():
            raise _error(path, "is a file", "give the name of a folder")
        _check_place(target / "file" if target.is_dir() else target, path)
        target.mkdir(exist_ok=True)
    return Path(path)


@contextmanager
def folder_for(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Make a folder for results; remove a new empty one where an input is refused."""
    made = not Path(path).exists()
    place = make_folder(path)
    try:
        yield place
    except InputError:
        if made:
            with suppress(OSError):
                place.rmdir()
        raise


def _places(path: str | os.PathLike[str]) -> tuple[Path, Path]:
    """Return the final path of a file and a temporary path beside it; refuse an impossible place."""
    with _writing(path):
        # a link stays a link: its target is replaced
        target = Path(path).resolve()
        _check_place(target, path)
        return target, target.with_name(f"{_HIDDEN}{secrets.token_hex(6)}{target.suffix[-20:]}")


@contextmanager
def _at_work(folder: Path) -> Iterator[None]:
    """Remove leftovers of killed writers from a folder, unless another writer works there; hold a lock meanwhile.

    A writer holds a lock on the folder, which ends with its process. Where the system has no such locks, leftovers
    stay.
    """
    handle = None
    with suppress(ImportError, OSError):
        from fcntl import LOCK_EX, LOCK_NB, LOCK_SH, flock

        handle = os.open(folder, os.O_RDONLY)
    if handle is None:
        yield
        return
    try:
        with suppress(OSError):
            flock(handle, LOCK_EX | LOCK_NB)
            with os.scandir(folder) as entries:
                for entry in entries:
                    if _LEFT.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                        Path(entry).unlink(missing_ok=True)
        # a process that removes leftovers has an exclusive lock for a moment
        for _ in range(_TRIES):
            with suppress(OSError):
                flock(handle, LOCK_SH | LOCK_NB)
                break
            time.sleep(_PAUSE)
        yield
    finally:
        os.close(handle)


def _check_place(target: Path, path: str | os.PathLike[str]) -> None:
    """Refuse a place that cannot hold the file; mode bits count too, because root may write anything."""
    folder = target.parent
    name = label(folder)
    if target.is_dir():
        raise _error(path, "is a folder", "give the name of a file in it")
    if target.exists() and not target.is_file():
        raise _error(path, _ODD, "give the name of a file")
    if target.exists() and not target.stat().st_mode & _WRITE_BITS:
        raise _error(path, "is read-only", "give another name or make it writable")
    if not folder.exists():
        raise _error(path, f"its folder {name} does not exist", f"make it first or {_ELSEWHERE}")
    if not folder.is_dir():
        raise _error(path, f"{name} is not a folder", _ELSEWHERE)
    if not stat.S_IMODE(folder.stat().st_mode) & _WRITE_BITS or not os.access(folder, os.W_OK):
        raise _error(path, f"its folder {name} is read-only", _ELSEWHERE)


def _error(path: str | os.PathLike[str], reason: str, remedy: str) -> InputError:
    return InputError(Problem("", "", reason, remedy, label(path)))


def table_place(problems: Problems, flag: str, path: str | None, *, as_json: bool) -> str | None:
    """Return the path of a flag's table, None if it is printed; add a mistake where JSON is printed too."""
    if path == STANDARD and as_json:
        problems.add(flag, path, "is printed, and so is --json", f"give {flag} a file, or leave out --json")
    return None if path == STANDARD else path
