"""Figures 4 to 7 of the paper on twisting with friction, and the lock lines of twisting beside bending.

H. Ebrahimi, H. Ali, R. Ghosh, Coulomb friction in twisting of biomimetic scale-covered substrate, Bioinspir. Biomim. 15
(2020), arXiv 2001.11054. The paper's force law (``plate``) is drawn as in the paper, the ``edge`` law beside it. Values
that the paper leaves open are chosen in :mod:`squama.paper.parameters`.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from squama import arguments
from squama._version import __version__
from squama.errors import refuse
from squama.io import files, tabular
from squama.loads import HELD, THIN
from squama.paper import claims, curves, elements, maps
from squama.paper import parameters as par
from squama.paper.elements import FePoints
from squama.paper.parameters import Claim
from squama.plot.maps import lock_lines_figure, red_figure, regime_figure
from squama.plot.style import FORMATS as ENDINGS
from squama.plot.style import headline, save_figure
from squama.progress import steps
from squama.symbols import SYMBOLS
from squama.types import Array
from squama.units import shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Table = Mapping[str, ArrayLike]
"""Columns by their headers (name and unit), all of one length."""
Floats = tuple[float, ...]
MODEL = f"{THIN} on {HELD['hinge']}"
"""Model of all figures; each line names its force law."""
_OVER = {"eta": "eta (1)", "alpha": "alpha (deg)"}
"""Headers of the varied ratios."""
_CURVE = {"law": "law", "mu (1)": "mu", "Phi/Phi_e (1)": "ratio", "Phi (rad/m)": "Phi"}


class Made(NamedTuple):
    """A figure, the columns of its CSV file, its claims, and the ratios it does not vary, by symbol."""

    figure: Figure
    table: dict[str, Array]
    claims: Iterable[Claim]
    fixed: dict[str, str]


def _stacked(pieces: Sequence[Table]) -> dict[str, Array]:
    """Return tables of the same columns stacked; a scalar in place of a column is repeated in every row."""
    sizes = [max(np.size(column) for column in p.values()) for p in pieces]
    return {
        header: np.concatenate([np.broadcast_to(np.asarray(p[header]), n) for p, n in zip(pieces, sizes, strict=True)])
        for header in pieces[0]
    }


def fig4(_points: FePoints | None = None) -> Made:
    """Make the figure of friction force against twist rate."""
    data = curves.both_laws(par.main(), par.FIG4_MUS, par.LAWS)
    table = flat(data, {**_CURVE, "theta (deg)": "theta", "f0 (1)": "f0"})
    return Made(curves.fig4(data), table, claims.fig4(data), par.fixed(par.main()))


def _regimes(over: str, values: Floats, scan: Array, mus: Floats, claims: Iterable[Claim]) -> Made:
    """Make a regime map for several values of a ratio or an angle."""
    data = maps.regimes(par.main(), over, values, scan, mus, par.LAWS)

    def piece(part: xr.Dataset, words: str, law: str, mu: float, at: str, name: str, end: ArrayLike = "") -> Table:
        columns = {_OVER[over]: at, "phi (rad)": f"phi{name}", "theta (deg)": f"theta{name}"}
        return {"line": words, "law": law, "mu (1)": mu, **flat(part, columns), "end": end}

    pieces = [piece(data, "path of the scales", "", np.nan, "value", "")]
    words = {"lock": "kinematic lock", "off": "contact leaves the tip edge", "touch": "other plates touch"}
    pieces += [piece(data, text, "", np.nan, "scan", f"_{name}") for name, text in words.items()]
    for law in par.LAWS:
        for mu in mus:
            line = data.sel(law=law, mu=mu)
            pieces.append(piece(line, "end of the path", law, mu, "scan", "_end", line["end"].values))
    table = _stacked(pieces)
    there = np.isfinite(table["phi (rad)"])
    table = {header: column[there] for header, column in table.items()}
    return Made(regime_figure(data), table, claims, par.fixed(par.main(), over))


def fig6a(_points: FePoints | None = None) -> Made:
    """Make the figure of torque and stiffness of the scales against twist rate."""
    data = curves.both_laws(par.main(), par.FIG6A_MUS, par.LAWS)
    table = flat(data, {**_CURVE, "T_scales/K_theta (1)": "T_K", "dT_scales/dphi/K_theta (1)": "K_K"})
    return Made(curves.fig6a(data), table, claims.fig6a(data), par.fixed(par.main()))


def fig6b(points: FePoints | None = None) -> Made:
    """Make the figure of torque over G_B I against twist rate, with points given or stored in the package."""
    points = elements.read_points(elements.STORED) if points is None else points
    etas, mus = (tuple(np.unique(values)) for values in (points.eta, points.mu))
    beams = {float(eta): par.fig6b(float(eta)) for eta in etas}
    parts = {eta: curves.both_laws(beam, mus, par.LAWS) for eta, beam in beams.items()}
    own = {}
    if points.joint is not None:
        for eta, beam in beams.items():
            K_theta = points.joint[0] * beam.unit_moment
            alike = beam.replace(joint={"stiffness": K_theta, "inclusion_factor": points.joint[1]})
            own[eta] = curves.both_laws(alike, mus, ("edge",))
    columns = {"law": "law", "mu (1)": "mu", "Phi (rad/m)": "Phi", "T/(G_B I) (rad/m)": "T_GI"}
    pieces: list[Table] = [
        {"source": source, "eta (1)": eta, **flat(data, columns)}
        for source, curves_of in (("model", parts), ("model, joint of the elements", own))
        for eta, data in curves_of.items()
    ]
    for source, load in (("finite elements", points.load), ("compliant joint", points.compliant)):
        if load is not None:
            cells: tuple[ArrayLike, ...] = "", points.mu, points.rate, load
            pieces.append({"source": source, "eta (1)": points.eta, **dict(zip(columns, cells, strict=True))})
    said = chain(elements.compare(points), elements.straight(etas))
    return Made(curves.fig6b(parts, points, own), _stacked(pieces), said, par.fixed(par.fig6b(1.0), "eta"))


def _red(over: str, values: Array, claims: Callable[[xr.Dataset], Iterable[Claim]]) -> Made:
    """Make a map of RED over mu and a ratio or an angle."""
    data = maps.red_map(par.main(), over, values, par.FIG7_MUS, par.LAWS, par.MARGIN)
    data["touched"] = data["phi_end"] > data["phi_touch"]
    columns = {"law": "law", _OVER[over]: "value", "mu (1)": "mu", f"RED at margin {par.MARGIN:g} (1)": "RED"}
    columns |= {"end": "end", "phi_end (rad)": "phi_end", "other plates touch first": "touched"}
    return Made(red_figure(data), flat(data, columns), claims(data), par.fixed(par.main(), over))


def bending(_points: FePoints | None = None) -> Made:
    """Make the figure of lock lines of twisting beside those of bending (edge law in twisting)."""
    data = maps.lock_lines(par.main(), par.BENDING_MUS, par.BENDING_ETAS, "edge")
    columns = {"loading": "loading", "mu (1)": "mu", "psi or phi (rad)": "load", "theta (deg)": "theta"}
    table = flat(data, {**columns, "below the kinematic line (deg)": "drop"})
    return Made(lock_lines_figure(data), table, claims.bending(data), par.fixed(par.main(), "eta"))


FIGURES: dict[str, Callable[[FePoints | None], Made]] = {
    "fig4": fig4,
    "fig5a": lambda _: _regimes("eta", par.FIG5_ETAS, par.FIG5_SCAN, par.FIG5A_MUS, claims.fig5a()),
    "fig5b": lambda _: _regimes("alpha", par.FIG5_ALPHAS, par.FIG5_ALPHA_SCAN, par.FIG5B_MUS, claims.fig5b()),
    "fig6a": fig6a,
    "fig6b": fig6b,
    "fig7a": lambda _: _red("eta", par.FIG7_ETAS, claims.fig7a),
    "fig7b": lambda _: _red("alpha", par.FIG7_ALPHAS, claims.fig7b),
    "bending": bending,
}
"""Figures by their names."""


FORMATS = tuple(ending[1:] for ending in ENDINGS)
"""File formats of the figures."""


def write(
    figures: Sequence[str],
    directory: str | os.PathLike[str],
    fe_points: str | os.PathLike[str] | None = None,
    formats: Sequence[str] = ("png",),
) -> list[Path]:
    """Write figures, their data (CSV), and their claims as ``claims.csv`` and ``claims.md``; return the paths.

    ``figures`` are names from :data:`FIGURES`, all if empty; ``fe_points`` a CSV file of finite element points for
    fig6b in place of those in the package, see :func:`squama.paper.elements.read_points`; ``formats`` some of
    :data:`FORMATS`. Figures and tables state the model, the ratios they do not vary and the version. The directory is
    made if missing; its parent must exist.
    """
    for name in figures:
        if name not in FIGURES:
            refuse(f"figure {shown(name)}", "", "is not known", f"write one or more of {' '.join(FIGURES)}")
    endings = arguments.several("formats", formats, FORMATS)
    points = None if fe_points is None else elements.read_points(fe_points)
    place = files.make_folder(directory)
    done: list[Path] = []
    found: list[Claim] = []
    names = dict.fromkeys(figures or FIGURES)
    for name in steps(names, len(names), "figures"):
        made = FIGURES[name](points)
        signs = ", ".join(f"${SYMBOLS[key].tex}$ = {text.replace(' deg', '°')}" for key, text in made.fixed.items())
        headline(made.figure, f"{MODEL[0].upper()}{MODEL[1:]}; {signs}")
        done += [save_figure(made.figure, place / f"{name}.{ending}") for ending in endings]
        done.append(write_table(made.table, place / f"{name}.csv", f"{MODEL}; {par.words(made.fixed)}"))
        found += made.claims
    return done + write_claims(found, place)


def write_table(table: Table, path: str | os.PathLike[str], about: str) -> Path:
    """Write columns to a CSV file under a comment line ``about``; numbers have 12 digits, NaN is an empty cell."""
    out = io.StringIO()
    out.write(f"# {about}; squama {__version__}\n")
    rows = zip(*(np.asarray(column).ravel() for column in table.values()), strict=True)
    tabular.write(out, [table, *(map(_cell, row) for row in rows)])
    return files.atomic_write(path, lambda place: place.write_text(out.getvalue(), encoding="utf-8"))


def _cell(value: object) -> str:
    if isinstance(value, bool | np.bool):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return "" if np.isnan(value) else f"{value:.12g}"
    return str(value)


def flat(data: xr.Dataset, columns: Mapping[str, str]) -> dict[str, Array]:
    """Return variables of a dataset as columns, one row for each cell of their common dimensions.

    ``columns`` maps headers to the variables' names; angles under a header with "(deg)" are converted to degrees.
    """
    arrays = xr.broadcast(*(data[name] for name in columns.values()))
    flat = {header: array.values.ravel() for header, array in zip(columns, arrays, strict=True)}
    return {header: np.degrees(values) if "(deg)" in header else values for header, values in flat.items()}


def write_claims(claims: Sequence[Claim], directory: Path) -> list[Path]:
    """Write ``claims.csv`` and ``claims.md``, one value a row; return both paths."""
    rows = [row for claim in claims for row in claim.rows()]
    about = f"{MODEL}; {par.words(par.fixed(par.main()))} where nothing else is said"
    done = write_table({column: [row[column] for row in rows] for column in rows[0]}, directory / "claims.csv", about)
    head = (
        "# Claims of the paper and what is computed\n\n"
        "H. Ebrahimi, H. Ali, R. Ghosh, Coulomb friction in twisting of biomimetic scale-covered substrate, "
        "Bioinspir. Biomim. 15 (2020). The plate law is the paper's; the edge law satisfies virtual work.\n\n"
        f"{about[0].upper()}{about[1:]}. Fig. 6b has ratios of its own. Made by squama {__version__}.\n\n"
        "| figure | claim | law | what is computed | at | value | holds | note |\n|---|---|---|---|---|---|---|---|\n"
    )
    body = "".join(
        f"| {' | '.join(row[c] for c in ('figure', 'claim', 'law', 'quantity', 'at'))} | "
        f"{row['value']}{' ' + row['unit'] if row['unit'] else ''} | {row['holds']} | {row['note']} |\n"
        for row in rows
    )
    words = files.atomic_write(directory / "claims.md", lambda place: place.write_text(head + body, encoding="utf-8"))
    return [done, words]
