"""Figures 4 to 7 of the paper on twisting with friction, and the lock lines of twisting beside bending.

H. Ebrahimi, H. Ali, R. Ghosh, Coulomb friction in twisting of biomimetic scale-covered substrate, Bioinspir. Biomim.
15 (2020), arXiv 2001.11054. The paper's force law (``plate``) is drawn as in the paper, the ``edge`` law beside it.
Values that the paper's text leaves open are chosen in :mod:`squama.paper.parameters`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import files
from squama.errors import InputError
from squama.units import shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from squama.paper.fe_points import FePoints
    from squama.paper.tables import Claim

DEGREES = 180 / np.pi


class Made(NamedTuple):
    """A figure, the columns of its CSV file and the claims it bears on."""

    figure: Figure
    table: dict[str, Any]
    claims: list[Claim]


def fig4(points: FePoints | None = None) -> Made:  # noqa: ARG001
    """Friction force against twist rate."""
    from squama.paper import claims, curves, tables
    from squama.paper import parameters as par

    data = curves.both_laws(par.main(), par.FIG4_MUS, par.LAWS)
    columns = {
        "law": ("law", 1.0),
        "mu (1)": ("mu", 1.0),
        "Phi/Phi_e (1)": ("ratio", 1.0),
        "Phi (rad/m)": ("Phi", 1.0),
        "theta (deg)": ("theta", DEGREES),
        "f0 (1)": ("f0", 1.0),
    }
    return Made(curves.fig4(data), tables.flat(data, columns), claims.fig4(data))


def _regimes(over: str, values: Any, scan: Any, mus: Any) -> tuple[Figure, dict[str, Any]]:
    from squama.paper import maps, tables
    from squama.paper import parameters as par
    from squama.plot.regimes import regime_figure

    data = maps.regimes(par.main(), over, values, scan, mus, par.LAWS)
    factor, unit = (DEGREES, "deg") if over == "alpha" else (1.0, "1")
    first = {f"{over} ({unit})": ("value", factor)}
    angles = ("phi (rad)", "theta (deg)")
    pieces = [tables.flat(data, {**first, angles[0]: ("phi", 1.0), angles[1]: ("theta", DEGREES)})]
    extras: list[tuple[str, str, float, Any]] = [("path of the scales", "", np.nan, "")]
    scanned = {f"{over} ({unit})": ("scan", factor)}
    words = {"lock": "kinematic lock", "off": "contact leaves the tip edge", "touch": "other plates touch"}
    for name, text in words.items():
        columns = {**scanned, angles[0]: (f"phi_{name}", 1.0), angles[1]: (f"theta_{name}", DEGREES)}
        pieces.append(tables.flat(data, columns))
        extras.append((text, "", np.nan, ""))
    for law in par.LAWS:
        for mu in mus:
            line = data.sel(law=law, mu=mu)
            columns = {**scanned, angles[0]: ("phi_end", 1.0), angles[1]: ("theta_end", DEGREES)}
            pieces.append(tables.flat(line, columns))
            extras.append(("end of the path", law, mu, line["end"].values))
    table: dict[str, Any] = {}
    for header, i in (("line", 0), ("law", 1), ("mu (1)", 2)):
        table[header] = np.concatenate([np.full(len(p[angles[0]]), e[i]) for p, e in zip(pieces, extras, strict=True)])
    for header in pieces[0]:
        table[header] = np.concatenate([p[header] for p in pieces])
    table["end"] = np.concatenate(
        [np.broadcast_to(np.asarray(e[3]), len(p[angles[0]])) for p, e in zip(pieces, extras, strict=True)]
    )
    return regime_figure(data), tables.without(table, np.isfinite(table[angles[0]]))


def fig5a(points: FePoints | None = None) -> Made:  # noqa: ARG001
    """Regimes for several overlap ratios."""
    from squama.paper import claims, maps
    from squama.paper import parameters as par

    figure, table = _regimes("eta", par.FIG5_ETAS, par.FIG5_SCAN, par.FIG5A_MUS)
    drops = {law: maps.lock_lines(par.main(), par.BENDING_MUS, par.BENDING_ETAS, law) for law in par.LAWS}
    return Made(figure, table, claims.fig5a(drops))


def fig5b(points: FePoints | None = None) -> Made:  # noqa: ARG001
    """Regimes for several angles alpha."""
    from squama.paper import claims
    from squama.paper import parameters as par

    figure, table = _regimes("alpha", par.FIG5_ALPHAS, par.FIG5_ALPHA_SCAN, par.FIG5B_MUS)
    return Made(figure, table, claims.fig5b())


def fig6a(points: FePoints | None = None) -> Made:  # noqa: ARG001
    """Torque and stiffness of the scales against twist rate."""
    from squama.paper import claims, curves, tables
    from squama.paper import parameters as par

    data = curves.both_laws(par.main(), par.FIG6A_MUS, par.LAWS)
    columns = {
        "law": ("law", 1.0),
        "mu (1)": ("mu", 1.0),
        "Phi/Phi_e (1)": ("ratio", 1.0),
        "Phi (rad/m)": ("Phi", 1.0),
        "T_scales/K_theta (1)": ("T_K", 1.0),
        "dT_scales/dphi/K_theta (1)": ("K_K", 1.0),
    }
    return Made(curves.fig6a(data), tables.flat(data, columns), claims.fig6a(data))


def fig6b(points: FePoints | None = None) -> Made:
    """Torque over G_B I against twist rate, with finite element points: those of the package if none are given."""
    from squama.paper import curves, elements, fe_points, tables
    from squama.paper import parameters as par

    points = elements.stored() if points is None else points
    etas = par.FIG6B_ETAS if points is None else tuple(np.unique(points.eta))
    mus = par.FIG6B_MUS if points is None else tuple(np.unique(points.mu))
    beams = {float(eta): par.fig6b(float(eta)) for eta in etas}
    parts = {eta: curves.both_laws(beam, mus, par.LAWS) for eta, beam in beams.items()}
    own = {}
    if points is not None and points.joint is not None:
        for eta, beam in beams.items():
            K_theta = points.joint[0] * beam.substrate.youngs_modulus * beam.pitch**3
            alike = beam.replace(joint={"stiffness": K_theta, "inclusion_factor": points.joint[1]})
            own[eta] = curves.both_laws(alike, mus, ("edge",))
    columns = {
        "mu (1)": ("mu", 1.0),
        "Phi (rad/m)": ("Phi", 1.0),
        "T/(G_B I) (rad/m)": ("T_GI", 1.0),
    }
    pieces = []
    for source, curves_of in (("model", parts), ("model, joint of the elements", own)):
        for eta, data in curves_of.items():
            rows = tables.flat(data, {"law": ("law", 1.0), **columns})
            n = rows["law"].size
            pieces.append({"source": np.full(n, source), "eta (1)": np.full(n, eta), **rows})
    if points is not None:
        loads = {"finite elements": points.load}
        if points.compliant is not None:
            loads["compliant joint"] = points.compliant
        for source, load in loads.items():
            n = points.eta.size
            names = {"source": np.full(n, source), "eta (1)": points.eta, "law": np.full(n, "")}
            pieces.append({**names, **dict(zip(columns, (points.mu, points.rate, load), strict=True))})
    table = {header: np.concatenate([p[header] for p in pieces]) for header in pieces[0]}
    return Made(curves.fig6b(parts, points, own), table, fe_points.compare(points))


def _red(over: str, values: Any) -> tuple[Any, Figure, dict[str, Any]]:
    from squama.paper import parameters as par
    from squama.paper import red, tables
    from squama.plot.maps import red_figure

    data = red.red_map(par.main(), over, values, par.FIG7_MUS, par.LAWS, par.MARGIN)
    data["touched"] = data["phi_end"] > data["phi_touch"]
    factor, unit = (DEGREES, "deg") if over == "alpha" else (1.0, "1")
    columns = {
        "law": ("law", 1.0),
        f"{over} ({unit})": ("value", factor),
        "mu (1)": ("mu", 1.0),
        f"RED at margin {par.MARGIN:g} (1)": ("RED", 1.0),
        "end": ("end", 1.0),
        "phi_end (rad)": ("phi_end", 1.0),
        "other plates touch first": ("touched", 1.0),
    }
    return data, red_figure(data), tables.flat(data, columns)


def fig7a(points: FePoints | None = None) -> Made:  # noqa: ARG001
    """RED over mu and eta."""
    from squama.paper import claims_red
    from squama.paper import parameters as par

    data, figure, table = _red("eta", par.FIG7_ETAS)
    return Made(figure, table, claims_red.fig7a(data))


def fig7b(points: FePoints | None = None) -> Made:  # noqa: ARG001
    """RED over mu and alpha."""
    from squama.paper import claims_red
    from squama.paper import parameters as par

    data, figure, table = _red("alpha", par.FIG7_ALPHAS)
    return Made(figure, table, claims_red.fig7b(data))


def bending(points: FePoints | None = None) -> Made:  # noqa: ARG001
    """Lock lines of twisting beside those of bending (edge law in twisting)."""
    from squama.paper import claims, maps, tables
    from squama.paper import parameters as par
    from squama.plot.regimes import lock_lines_figure

    data = maps.lock_lines(par.main(), par.BENDING_MUS, par.BENDING_ETAS, "edge")
    columns = {
        "loading": ("loading", 1.0),
        "mu (1)": ("mu", 1.0),
        "psi or phi (rad)": ("load", 1.0),
        "theta (deg)": ("theta", DEGREES),
        "below the kinematic line (deg)": ("drop", DEGREES),
    }
    return Made(lock_lines_figure(data), tables.flat(data, columns), claims.bending(data))


FIGURES: dict[str, Callable[[FePoints | None], Made]] = {
    "fig4": fig4,
    "fig5a": fig5a,
    "fig5b": fig5b,
    "fig6a": fig6a,
    "fig6b": fig6b,
    "fig7a": fig7a,
    "fig7b": fig7b,
    "bending": bending,
}
"""Figures by their names."""


def write(
    figures: Sequence[str],
    directory: str | os.PathLike[str],
    fe_points: str | os.PathLike[str] | None = None,
) -> list[Path]:
    """Write figures (PNG), their data (CSV) and the table of the claims they bear on.

    Parameters
    ----------
    figures : sequence of str
        Names from :data:`FIGURES`; none means all.
    directory : path
        Where to write; made if it is not there, its own folder must be.
    fe_points : path, optional
        CSV file of finite element points for fig6b in place of those in the package; see
        :func:`squama.paper.fe_points.read_points`.

    Returns
    -------
    list of Path
        The files written: ``fig4.png``, ``fig4.csv``, ..., ``claims.csv``, ``claims.md``.

    Raises
    ------
    InputError
        An unknown name, a file that cannot be read or written.
    """
    from squama.paper.fe_points import read_points
    from squama.paper.tables import write_claims, write_table
    from squama.plot.style import save_figure

    for name in figures:
        if name not in FIGURES:
            message = f"figure {shown(name)}: is not known; write one or more of {' '.join(FIGURES)}"
            raise InputError(message)
    points = None if fe_points is None else read_points(fe_points)
    place = files.make_folder(directory)
    done: list[Path] = []
    claims: list[Claim] = []
    for name in dict.fromkeys(figures or FIGURES):
        made = FIGURES[name](points)
        done.append(save_figure(made.figure, place / f"{name}.png"))
        done.append(write_table(made.table, place / f"{name}.csv"))
        claims += made.claims
    return done + write_claims(claims, place)
