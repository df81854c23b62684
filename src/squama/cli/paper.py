"""squama paper: the figures of the paper, and its claims."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def paper(
    *figures: str,
    out: Annotated[
        str, Parameter(name=("--out", "-o"), help="Folder to write to; made if need be.", allow_leading_hyphen=True)
    ],
    points: Annotated[
        str | None, Parameter(help="CSV file of finite element points to draw in Fig. 6b.", allow_leading_hyphen=True)
    ] = None,
    json: Annotated[bool, Parameter(help="Print the names of the files as JSON.")] = False,
) -> int:
    """Compute the figures of the paper on twisting (2020) and check its claims.

    Parameters
    ----------
    figures
        Any of fig4, fig5a, fig5b, fig6a, fig6b, fig7a, fig7b, bending (lock lines of twisting beside bending);
        all if none is given.
    """
    from squama import files
    from squama.paper import twisting2020

    written = twisting2020.write(figures, Path(out), Path(points) if points is not None else None)
    if json:
        from squama.cli import record

        record.show({"written": [str(path) for path in written]})
    else:
        for path in written:
            print(f"wrote {files.label(path)}")
    return 0
