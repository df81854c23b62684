"""The command line: exit status 0, 2 for a mistake in what was given, 130 for Ctrl-C."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence

from squama.errors import InputError, SquamaError

__all__ = ["main"]

WRONG = 2
INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows ``squama``; those of the process if not given.

    Returns
    -------
    int
        Exit status.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            # a name that the terminal cannot show is no reason to stop
            stream.reconfigure(errors="backslashreplace")
    try:
        status = _run(list(sys.argv[1:] if arguments is None else arguments))
        sys.stdout.flush()
    except SquamaError as error:
        for line in str(error).splitlines():
            print(f"squama: error: {line}", file=sys.stderr)
        return WRONG
    except KeyboardInterrupt as stop:
        print(f"squama: {str(stop) or 'interrupted'}", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # whoever read the output has gone, e.g. head; nothing more can be said there
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return status


def _run(arguments: list[str]) -> int:
    """Run a command; a command line that cannot be understood is an InputError too."""
    from cyclopts import CycloptsError

    from squama.cli.app import make, usage_problem
    from squama.cli.flags import collecting

    try:
        with collecting():
            status = make()(arguments, exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        raise InputError(usage_problem(error)) from None
    return status if isinstance(status, int) else 0
