"""squama joint: stiffness of a scale's joint by finite elements, compared with the scaling laws."""

from __future__ import annotations

import math
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.beam.matrixfile import freed
from squama.cli import flags, output
from squama.cli.flags import flag, settled, whole
from squama.cli.output import Shown, Summary, of, percent
from squama.interrupt import kept
from squama.io.files import label, table_place
from squama.units import change, number, torque_unit

if TYPE_CHECKING:
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.fe.stiffness import JointMatrix, Level, Value
    from squama.types import Array

MOTIONS = (
    ("u_X", "shift up the scale (n_X)"),
    ("u_Y", "shift along its width (n_Y)"),
    ("u_Z", "shift out of its face (n_Z)"),
    ("w_X", "roll (about n_X)"),
    ("w_Y", "inclination (about n_Y)"),
    ("w_Z", "yaw (about n_Z)"),
)
"""Symbols of the six motions, and their words."""
LOADS = ("phi", "psi", "epsilon")
"""Twist, bend and stretch per pitch."""
TWIST = 5.0
"""Twist per pitch for which the motions of a scale are listed, degrees."""
_EDGES = "Size of the coarsest elements along the scale's edges, in pitches. Default: a fifth of the embedded length."
_LEVELS = "Number of meshes, each half as coarse as the one before. Default: 3."
_TAB = "The embedded part of a scale: rigid, or elastic with the scale's modulus. Default: rigid."
_TOML = "Beam file (.toml) to write, with K_theta and C_f of the elements under [joint]."
_MATRIX = 'CSV file to write, - prints it: stiffness in all motions, for matrix = "joint.csv" under [joint] of a file.'
_table = partial(output.table, left=1)
_size = flags.number(1e-3, 0.5, "0.04", "0.001 to 0.5 pitches")


def joint(
    beam: flags.BeamFile,
    /,
    *,
    edge_size: Annotated[float | None, flag(_EDGES, read=_size)] = None,
    levels: Annotated[int, flag(_LEVELS, read=whole(1, 6, "3"))] = 3,
    tab: Annotated[str, flag(_TAB, read=flags.one_of("rigid", "elastic"))] = "rigid",
    toml: Annotated[flags.File | None, flag(_TOML)] = None,
    matrix: Annotated[flags.File | None, flag(_MATRIX)] = None,
    full: flags.Full = False,
    quiet: flags.Quiet = False,
    fresh: Annotated[bool, Parameter(help="Ignore results in the cache.")] = False,
    base: flags.Base = flags.BASE,
) -> int:
    """Compute the stiffness of a scale's joint by finite elements; needs the extra fe."""
    place = table_place(flags.problems(), "--matrix", matrix, as_json=base.json)
    flags.check_places([(toml, (".toml",)), (place, (".csv",))])
    described = settled(base.beam(beam, friction=False))

    from squama.beam import matrixfile
    from squama.fe import stiffness

    rest = "" if fresh else "; meshes that are done are kept: run it again to go on"
    with kept(label(beam), rest):
        how: dict[str, Any] = {"edge_size": edge_size, "levels": levels, "tab": tab, "fresh": fresh}
        found = stiffness.joint(described, **how, progress=None if quiet else print_level)
    written: list[Path | str] = []
    if toml is not None:
        own = {"stiffness": found.stiffness.value, "inclusion_factor": found.C_f.value, "matrix": None}
        described.replace(joint=own).to_toml(toml)
        written.append(label(toml))
    if matrix is not None:
        stored = matrixfile.stored(described, found.K, matrix, tab=tab == "elastic")
        written.append(label(matrixfile.write(stored, matrix)) if place else output.write_text(matrix, stored.text))
    shown = _summary(described, found).shown(full=full)
    return output.report(base.json, beam, written, _record(described, found), shown)


def print_level(level: Level) -> None:
    """Print a finished mesh on standard error."""
    took = f"{level.seconds:.1f} s" if level.seconds else "from the cache"
    print(
        f"squama: {level.elements} elements, {number(level.edge_size)} pitches along the scale's edges: "
        f"K_theta = {number(level.K_theta)} E d^3 ({took})",
        file=sys.stderr,
        flush=True,
    )


def laws(beam: Beam, found: JointMatrix) -> dict[str, tuple[Value, float]]:
    """Return K_theta (N m) and C_f by elements, each with the value of its scaling law, whatever the file states."""
    bare = beam.replace(joint={"stiffness": None, "inclusion_factor": None, "matrix": None})
    return {"K_theta": (found.stiffness, bare.joint_stiffness), "C_f": (found.C_f, bare.C_f)}


def _record(beam: Beam, found: JointMatrix) -> dict[str, object]:
    """Return the record for JSON."""
    pairs = zip(found.levels, found.C_f_levels, strict=True)
    levels = [{**of(x, "edge_size elements K_theta"), "C_f": c, "matrix": x.K} for x, c in pairs]
    factors = {
        name: {"elements": x.value, "error": x.error, "law": law, "difference": x.value / law - 1}
        for name, (x, law) in laws(beam, found).items()
    }
    return {
        "factors": factors,
        "matrix": found.K,
        "order": found.order,
        "motions": [*dict(MOTIONS), *LOADS],
        "bare_bar": dict(zip(("bend", "stretch"), _over_bare(beam, found.K), strict=True)),
        "bar": {"elements": found.bar, "exact": found.exact, "size": found.size},
        "levels": levels,
        "units": {
            "K_theta": "N m",
            "matrix": "E_B and pitches: translations E d, couplings E d^2, rotations and loads E d^3",
            "bare_bar": "stiffness of the pitch, all else free, over that of the bare bar",
            "size": "pitches",
            "levels.K_theta": "E d^3",
            "bar": "E d^3",
        },
        "youngs_modulus": beam.substrate.youngs_modulus,
        "pitch": beam.pitch,
    }


def _summary(beam: Beam, found: JointMatrix) -> Summary:
    """Return the summary: stiffness and inclusion factor with errors, and the deviation of the scaling laws."""
    size, newton = torque_unit(found.stiffness.value)
    words = {"K_theta": ("joint stiffness", size, f"{newton} per rad"), "C_f": ("inclusion factor", 1.0, "")}
    figures, verdict = [], []
    for name, (x, law) in laws(beam, found).items():
        share, (text, factor, unit) = x.error / x.value, words[name]
        error = f" +- {percent(share)}" if math.isfinite(share) else ", error unknown"
        verdict.append(f"{name} = {number(factor * x.value, unit)}{error}")
        by_law = number(factor * law, unit)
        figures.append((text, f"{by_law} by the scaling law; elements differ by {change(x.value / law - 1, '+')}"))
    bend, stretch = _over_bare(beam, found.K)
    meshes = f"{len(found.levels)}, up to {found.levels[-1].elements} elements"
    figures += [
        ("bent, all else free", f"the pitch is {number(bend)} times as stiff as the bare bar"),
        ("stretched, all else free", f"{number(stretch)} times"),
        ("bare bar, twisted", f"{percent(found.bar / found.exact - 1)} stiffer than exact on this mesh"),
        ("meshes", f"{meshes}; extrapolated linearly from the last two" if len(found.levels) > 1 else meshes),
    ]
    return Summary(", ".join(verdict), figures, (), (), _all(beam, found))


def _all(beam: Beam, found: JointMatrix) -> Shown:
    """Yield stiffnesses and motions of a scale, the whole matrix, and every mesh."""
    size, newton = torque_unit(found.stiffness.value)
    head = ("motion of the scale", "unit", "others free", "others held", f"per {TWIST:g} deg of twist per pitch")
    yield _table(head, _motions(beam, found.K, size, newton))
    yield "K_theta is the moment about n_Y with the five other motions free; theta grows by a turn about -n_Y"
    yield "last column: how far a scale moves by itself as the beam is twisted, without contact"
    yield ""
    yield "stiffness in E_B and pitches (shifts E d, rotations and loads E d^3, couplings E d^2)"
    names = (*dict(MOTIONS), *LOADS)
    yield _table(("", *names), [(n, *(number(x) for x in r)) for n, r in zip(names, found.K, strict=True)])
    yield ""
    yield _meshes(found)
    if not math.isnan(found.order):
        yield f"order of convergence: {number(found.order)}"


def _meshes(found: JointMatrix) -> Table:
    """Return the table of the meshes: K_theta and C_f, each with its change from the mesh before."""
    heads = [(number(x.edge_size), str(x.elements)) for x in found.levels]
    values = [(x.K_theta, float(c)) for x, c in zip(found.levels, found.C_f_levels, strict=True)]
    if len(heads) > 1:
        heads.append(("to zero", ""))
        values.append((found.K_theta.value, found.C_f.value))
    rows = []
    for i, (head, pair) in enumerate(zip(heads, values, strict=True)):
        before = zip(pair, values[i - 1], strict=True)
        changes = [number(100 * (x / y - 1), "%", "+") if i else "" for x, y in before]
        rows.append((*head, number(pair[0]), changes[0], number(pair[1]), changes[1]))
    return _table(("edge size, pitches", "elements", "K_theta/(E d^3)", "change", "C_f", "change"), rows)


def _over_bare(beam: Beam, K: Array) -> tuple[float, float]:
    """Return the stiffness of the pitch in bend and in stretch, all else free, over that of the bare bar."""
    from squama.joints import factor
    from squama.model import section

    free, d = freed(K), beam.pitch
    width, thickness = beam.substrate.width / d, beam.substrate.thickness / d
    bend = section.bending_moment_of_area(width, thickness)
    return float(free[factor.BEND] / bend), float(free[factor.STRETCH] / (width * thickness))


def _motions(beam: Beam, K: Array, size: float, newton: str) -> list[tuple[str, ...]]:
    """Return a row per motion: stiffness with the others free and held, and the motion under twist."""
    import numpy as np

    E, d = beam.substrate.youngs_modulus, beam.pitch
    free, held = freed(K[:6, :6]), np.diag(K)[:6]
    rates = -np.linalg.solve(K[:6, :6], K[:6, 6])
    rows = []
    for i, (_, words) in enumerate(MOTIONS):
        unit = "N/mm" if i < 3 else f"{newton} per rad"
        cells = [number(x[i] * (1e-3 * E * d if i < 3 else size * E * d**3)) for x in (free, held)]
        rate, of = (d * 1e3 * math.radians(TWIST), "mm") if i < 3 else (TWIST, "deg")
        rows.append((words, unit, *cells, f"{number(rates[i] * rate, sign='+')} {of}"))
    return rows
