"""squama explore: a page in the browser on which a beam is turned, changed, loaded and compared."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from typing import Annotated

from cyclopts import Parameter

from squama.cli.options import Problems, flag, read_number, read_overrides
from squama.errors import InputError


def explore(
    beam: str | None = None,
    /,
    *,
    port: Annotated[str, flag("Port of the page; 0 takes any that is free (0).")] = "0",
    browser: Annotated[bool, Parameter(negative="--no-browser", help="Open a browser; --no-browser does not.")] = True,
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    json: Annotated[bool, Parameter(help="Print the address as JSON.")] = False,
) -> int:
    """Open the explorer: a page on this machine (127.0.0.1) that shows a beam in space, its curves and a regime map.

    Parameters
    ----------
    beam
        Beam file (TOML) to start from; without one, PLA scales on silicone.
    """
    from squama.cli import run
    from squama.web import server, state

    problems = Problems()
    number, start, overrides = 0, None, {}
    with problems.caught():
        number = _port(port)
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if beam is not None:
            start = state.of(run.read_beam(beam, overrides))
        elif overrides:
            message = "--set: has no beam file whose values it replaces; name one, e.g. squama explore beam.toml"
            raise InputError(message)
    if find_spec("nicegui") is None:
        problems.lines.append("squama explore needs NiceGUI; install it with: pip install 'squama[web]'")
    problems.settle()
    number = server.free_port(number)

    def ready(address: str) -> None:
        if json:
            from squama.cli import record

            record.show({"address": address})
            sys.stdout.flush()
        else:
            print(f"squama explorer: {address} (stop it with Ctrl-C)", flush=True)

    server.serve(start or state.preset("pla"), number, browser=browser, ready=ready)
    return 0


def _port(text: str) -> int:
    allowed = "0 to 65535"
    value = read_number("--port", text, 0, 65535, allowed, "8080")
    if value != int(value):
        message = f"--port = {text}: is not a whole number; allowed: {allowed}; write e.g. 8080"
        raise InputError(message)
    return int(value)
