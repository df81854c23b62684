"""Short commands: squama new (example of a beam file), ends (many designs), paper (its figures), explore."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from squama.cli import flags, output
from squama.cli.flags import flag, one_of, whole, words_of
from squama.errors import refuse
from squama.io.files import INPUT, STANDARD, exists, label, table_place

EXAMPLE = Path(__file__).with_name("example.toml")
_TABLE = (
    "CSV file with columns eta, beta, lambda, alpha_deg, theta0_deg, mu; others are kept. Columns added: phi_e_rad, "
    "end, theta_end_deg, phi_end_rad, neighbour, sense. Bad rows are listed and left out."
)
_FIGURES = (
    "Figures: fig4, fig5a, fig5b, fig6a, fig6b, fig7a, fig7b, bending (lock lines in twisting and bending). "
    "Default: all."
)
PICTURES = tuple(ending[1:] for ending in flags.PLOTS)
_FORMATS = f"Formats of the pictures: {','.join(PICTURES)}. Default: png."
_START = "Beam file (TOML). Default: PLA scales on silicone."
_BROWSER = "Open a browser, or not (--no-browser). Default: open."
_CONTACTS = "Contacts that may end a curve: tip (of all neighbours) or all (every pair of plates). Default: tip."


def new(
    beam: Annotated[flags.File, Parameter(help="File to write, e.g. beam.toml; - prints the example.")],
    /,
    *,
    force: Annotated[bool, Parameter(help="Replace the file if it exists.")] = False,
) -> int:
    """Write a commented example of a beam file."""
    from squama.io import datasets

    text, name = EXAMPLE.read_text(encoding="utf-8"), label(beam)
    if beam == INPUT:  # as "-" is read
        output.write_text(STANDARD, text)
        return 0
    datasets.check_place(beam)
    if exists(beam) and not force:
        refuse(name, "", "is there already", "give another name, or replace it with --force")
    output.write_text(beam, text)
    print(f"wrote {name}; compute it with: squama twist {name}")
    return 0


def ends(
    designs: Annotated[flags.File, Parameter(help=_TABLE)],
    /,
    *,
    out: Annotated[flags.File, flag("CSV file to write; - prints the table alone.", "--out", "-o")],
    law: flags.Law = "edge",
    sense: flags.Sense = "+",
    contacts: Annotated[str, flag(_CONTACTS, read=one_of("tip", "all"))] = "tip",
    json: flags.Json = False,
) -> int:
    """Find engagement and end of many designs of hinged scales, from a table."""
    place = table_place(flags.problems(), "-o", out, as_json=json)
    flags.check_places([(place, (".csv",))], [designs])
    flags.problems().settle()

    from squama.arrays import designs_table as table

    solved = table.solve(designs, law=law, sense=sense, contacts=contacts)
    if solved.rows and place is not None:
        table.write(solved, place)
    for line in solved.problems:
        print(f"squama: error: {line}", file=sys.stderr)
    if place is None:
        table.put(solved, sys.stdout)
        return 2 if solved.bad else 0
    counts = ", ".join(f"{count} {end}" for end, count in solved.ends.items())
    left = f"; {solved.bad} bad left out" if solved.bad else ""
    n, counted = len(solved.rows), f" ({counts})" if counts else ""
    written = f"wrote {label(out)}" if n else f"{label(out)} is not written"
    record = {"out": place if n else None, "rows": n, "bad": solved.bad, "counts": solved.ends}
    output.say(json, record, [f"{written}: {n} designs{counted}{left}"])
    return 2 if solved.bad else 0


def paper(
    *figures: Annotated[str, Parameter(help=_FIGURES)],
    out: Annotated[flags.File, flag("Folder to write to; it is made if missing.", "--out", "-o")],
    points: Annotated[flags.File | None, flag("CSV file of finite element points for Fig. 6b.")] = None,
    format_: Annotated[tuple[str, ...], flag(_FORMATS, "--format", read=words_of(PICTURES))] = ("png",),
    json: flags.Json = False,
) -> int:
    """Compute the figures of the paper on twisting (2020) and check its claims."""
    flags.problems().settle()

    from squama.paper import twisting2020

    written = twisting2020.write(figures, Path(out), Path(points) if points is not None else None, format_)
    return output.say(json, {"written": [*map(str, written)]}, (f"wrote {label(path)}" for path in written))


def explore(
    beam: Annotated[flags.File | None, Parameter(help=_START)] = None,
    /,
    *,
    port: Annotated[int, flag("Port of the page. Default: any that is free.", read=whole(0, 65535, "8080"))] = 0,
    browser: Annotated[bool, Parameter(negative="--no-browser", help=_BROWSER)] = True,
    base: flags.Base = flags.BASE,
) -> int:
    """Open the explorer: a page on this machine (127.0.0.1) with a beam in space, its curves and a regime map."""
    from squama.web import server, state

    start = None
    if beam is not None:
        described = base.beam(beam, friction=False)
        with flags.problems().caught():
            start = described and state.of(described)
    elif base.set_:
        remedy = "name one, e.g. squama explore beam.toml"
        flags.problems().add("--set", "", "has no beam file whose values it replaces", remedy)
    if find_spec("nicegui") is None:
        flags.problems().add("", "", "squama explore needs NiceGUI", "install it with: pip install 'squama[web]'")
    flags.problems().settle()

    def ready(address: str) -> None:
        if base.json:
            output.show_json({"address": address})
            sys.stdout.flush()
        else:
            print(f"squama explorer: {address} (stop it with Ctrl-C)", flush=True)

    server.serve(start or state.preset("pla"), server.free_port(port), browser=browser, ready=ready)
    return 0
