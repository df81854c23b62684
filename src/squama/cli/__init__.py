"""The command line: exit status 0, 1 for a verification without contact, 2 for a mistake in the input, 130: Ctrl-C."""

from __future__ import annotations

import io
import os
import re
import sys
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TextIO

from squama.errors import InputError, Problem, SquamaError, SquamaWarning, TableWarning

__all__ = ["main"]

WRONG = 2
INTERRUPTED = 130
NARROWEST = 20
"""Least width of a terminal, columns."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command with ``arguments`` after ``squama`` (None: those of the process); return the exit status."""
    _set_up()
    try:
        if sys.stdout is None:
            raise InputError(Problem("standard output", "", "is closed", "redirect it to a file or to /dev/null"))
        status = _run(list(sys.argv[1:] if arguments is None else arguments))
        sys.stdout.flush()
    except SquamaError as error:
        return _say(WRONG, *(f"error: {line}" for line in str(error).splitlines()))
    except KeyboardInterrupt as stop:
        return _say(INTERRUPTED, str(stop) or "interrupted")
    except BrokenPipeError:
        # the reader of the output has closed the pipe, e.g. head
        _silence(sys.stdout)
        return 1
    except OSError as error:
        return _say(WRONG, f"error: {_about(error)}")
    return status


def _set_up() -> None:
    """Set up environment, streams and plotting backend of the process."""
    width = os.environ.get("COLUMNS", "")
    if not re.fullmatch("[0-9]{2,4}", width) or int(width) < NARROWEST:
        # not a usable width
        os.environ.pop("COLUMNS", None)
    # a file that is written must not get the descriptor of a closed stream
    while (spare := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(spare)
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 - to the end of the process
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            # print names that the terminal cannot show with escapes
            stream.reconfigure(errors="backslashreplace")
    # no command opens a window, so a missing backend must not stop it
    os.environ["MPLBACKEND"] = "agg"


def _say(status: int, *lines: str) -> int:
    """Write lines on standard error, if it takes them, and return the exit status."""
    try:
        for line in lines:
            print(f"squama: {line}", file=sys.stderr)
        sys.stderr.flush()
    except OSError:
        _silence(sys.stderr)
    return status


def _silence(stream: TextIO) -> None:
    """Redirect a broken stream, with its unwritten text, to the null device."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def _about(error: OSError) -> Problem:
    """Return the cause of a system error: working folder, standard output or a file."""
    from squama.io.files import label

    why = (error.strerror or str(error)).lower()
    try:
        Path.cwd()
    except OSError:
        return Problem("the working folder", "", "is gone", "change to one that is there")
    try:
        # an error of an earlier write may show only now
        sys.stdout.write("\n")
        sys.stdout.flush()
    except OSError:
        _silence(sys.stdout)
        return Problem("standard output", "", f"cannot be written ({why})", "make room or redirect it")
    return Problem(label(error.filename) if error.filename else "", "", why, "look at the name, the place and the disk")


def _warned(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Print a warning; one of the package's own as one line, without its place in the code."""
    if issubclass(category, SquamaWarning):
        _say(0, f"warning: {message}")
    else:
        print(warnings.formatwarning(message, category, filename, lineno, line), file=file or sys.stderr)


_OWN = ("--sense", "--csv", "--plot", "--netcdf", "--out", "-o", "--toml", "--matrix", "--gif", "--band", "--corner")
"""Flags whose value "-" is not the standard input."""


def _named(arguments: Sequence[str]) -> Iterator[str]:
    """Yield the arguments with the name of the standard input for "-", except after a flag of :data:`_OWN`."""
    from squama.io.files import INPUT, STANDARD

    for before, text in zip(["", *arguments], arguments, strict=False):
        yield INPUT if text == STANDARD and before not in _OWN else text


def _run(arguments: list[str]) -> int:
    """Run a command; a command line that cannot be parsed raises InputError too."""
    from cyclopts import CycloptsError

    from squama.cli.app import make, usage_problem
    from squama.cli.flags import collecting
    from squama.progress import spoken
    from squama.units import shown

    if wrong := [text for text in arguments if "\0" in text]:
        # shells and file names have no null characters
        raise InputError(Problem(reason=f"{shown(wrong[0])} holds a null character", remedy="leave it out"))

    try:
        with spoken(), collecting(), warnings.catch_warnings():
            warnings.simplefilter("default", TableWarning)
            warnings.showwarning = _warned
            status = make()([*_named(arguments)], exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        raise InputError(usage_problem(error)) from None
    return status if isinstance(status, int) else 0
