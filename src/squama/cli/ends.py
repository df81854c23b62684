"""squama ends: many designs from a table."""

from __future__ import annotations

import sys
from typing import Annotated

from cyclopts import Parameter

from squama.cli.options import Problems, flag
from squama.errors import InputError


def ends(
    designs: str,
    /,
    *,
    out: Annotated[str, Parameter(name=("--out", "-o"), help="CSV file to write.", allow_leading_hyphen=True)],
    law: Annotated[str, flag("Force law: edge or plate (edge).")] = "edge",
    sense: Annotated[str, flag("Which way the beams are twisted: + or - (+).")] = "+",
    contacts: Annotated[
        str, flag("Which contacts may end a curve: tip (of all neighbours) or all (every pair of plates).")
    ] = "tip",
    json: Annotated[bool, Parameter(help="Print the counts as JSON.")] = False,
) -> int:
    """Find where many designs engage and how they end, from a table.

    Parameters
    ----------
    designs
        CSV file with the columns eta, beta, lambda, alpha_deg, theta0_deg, mu; others are carried along. Added are
        phi_e_rad, end, theta_end_deg, phi_end_rad, neighbour. Bad rows are named and left out.
    """
    from pathlib import Path

    from squama import checks, files, store

    problems = Problems()
    for name, value, allowed in (
        ("law", law, None),
        ("sense", sense, ("+", "-")),
        ("contacts", contacts, ("tip", "all")),
    ):
        with problems.caught():
            if allowed is None:
                checks.law(value)
            else:
                checks.one_of(name, value, allowed)
    problems.lines = [f"--{line}" for line in problems.lines]
    with problems.caught():
        store.check_place(out, (".csv",))
        if Path(out).resolve() == Path(designs).resolve():
            message = f"{files.label(out)}: is read too; give the output another name"
            raise InputError(message)
    problems.settle()

    from squama import designs as table

    solved = table.solve(designs, law=law, sense=sense, contacts=contacts)
    if solved.rows:
        table.write(solved, out)
    for line in solved.problems:
        print(f"squama: error: {line}", file=sys.stderr)
    if json:
        from squama.cli import record

        record.show(
            {"out": out if solved.rows else None, "rows": len(solved.rows), "bad": solved.bad, "ends": solved.ends}
        )
    else:
        counts = ", ".join(f"{count} {end}" for end, count in solved.ends.items())
        left = f"; {solved.bad} bad left out" if solved.bad else ""
        place = f"wrote {files.label(out)}" if solved.rows else f"{files.label(out)} is not written"
        print(f"{place}: {len(solved.rows)} designs{f' ({counts})' if counts else ''}{left}")
    return 2 if solved.bad else 0
