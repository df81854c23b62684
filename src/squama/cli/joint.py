"""squama joint: stiffness of a scale's joint by finite elements, beside the paper's scaling laws."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Problems, flag, read_number, read_overrides

if TYPE_CHECKING:
    from squama.design import Beam
    from squama.fe.joint import JointMatrix, Level

MOTIONS = (
    ("u_X", "shift up the scale (n_X)"),
    ("u_Y", "shift along its width (n_Y)"),
    ("u_Z", "shift out of its face (n_Z)"),
    ("w_X", "roll (about n_X)"),
    ("w_Y", "inclination (about n_Y)"),
    ("w_Z", "yaw (about n_Z)"),
)
"""Symbols of the six motions, and in words."""


def joint(
    beam: str,
    /,
    *,
    edge_size: Annotated[
        str | None,
        flag(
            "Elements along the embedded scale's edges in the coarsest mesh, pitches (a fifth of the embedded length)."
        ),
    ] = None,
    levels: Annotated[str, flag("Number of meshes, each with half the size of the one before (3).")] = "3",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    toml: Annotated[
        str | None, flag("Beam file to write: this beam with K_theta and C_f from the elements under [joint].")
    ] = None,
    matrix: Annotated[
        str | None,
        flag(
            'File to write (.csv): the stiffness in all motions, for matrix = "joint.csv" under [joint] of a beam file.'
        ),
    ] = None,
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
    quiet: Annotated[bool, Parameter(help="No lines of progress.")] = False,
    fresh: Annotated[bool, Parameter(help="Compute anew, without the results kept in the cache.")] = False,
) -> int:
    """Stiffness of a scale's joint by finite elements, beside the scaling laws; needs the extra fe.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import files, joint_values, matrixfile
    from squama.cli import run
    from squama.store import check_place

    problems = Problems()
    overrides: dict[str, dict[str, Any]] = {}
    size, count = None, 3
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if edge_size is not None:
            size = read_number("--edge-size", edge_size, 1e-3, 0.5, "0.001 to 0.5 pitches", "0.04")
    with problems.caught():
        count = int(read_number("--levels", levels, 1, 6, "1 to 6", "3"))
    with problems.caught():
        if toml is not None:
            check_place(toml, (".toml",))
    with problems.caught():
        if matrix is not None:
            check_place(matrix, (".csv",))
    described = None
    with problems.caught():
        described = run.read_beam(beam, overrides)
    problems.settle()
    assert described is not None

    from squama.fe.joint import joint_matrix

    told = None if quiet else tell
    try:
        found = joint_matrix(described, edge_size=size, levels=count, store=not fresh, progress=told)
    except KeyboardInterrupt:
        kept = "" if fresh else "; meshes that are done are kept: run it again to go on"
        print(f"squama: {files.label(beam)}: interrupted{kept}", file=sys.stderr)
        return 130
    changed = described.replace(
        joint={"stiffness": _si(described, found).value, "inclusion_factor": found.C_f.value, "matrix": None}
    )
    written = []
    if toml is not None:
        changed.to_toml(toml)
        written.append(files.label(toml))
    if matrix is not None:
        written.append(files.label(matrixfile.write(joint_values.stored(described, found.K, matrix), matrix)))
    if json:
        record(files.label(beam), described, found, written)
    else:
        show(files.label(beam), described, found, written)
    return 0


def tell(level: Level) -> None:
    """Say on standard error that a mesh is done."""
    took = f"{level.seconds:.1f} s" if level.seconds else "from the cache"
    print(
        f"squama: {level.elements} elements, {level.edge_size:.4g} pitches along the scale's edges: "
        f"K_theta = {level.K_theta:.4g} E d^3 ({took})",
        file=sys.stderr,
        flush=True,
    )


def _si(beam: Beam, found: JointMatrix) -> Any:
    """Return K_theta with its error bar, N m."""
    unit = beam.substrate.youngs_modulus * beam.pitch**3
    return type(found.K_theta)(*(x * unit for x in found.K_theta))


def laws(beam: Beam) -> tuple[float, float]:
    """Return K_theta (N m) and C_f by the scaling laws, whatever the file gives."""
    bare = beam.replace(joint={"stiffness": None, "inclusion_factor": None, "matrix": None})
    return bare.joint_stiffness, bare.C_f


def record(file: str, beam: Beam, found: JointMatrix, written: list[str]) -> None:
    """Print all there is as JSON."""
    from squama.cli import record as printed

    K, C_f, (law_K, law_C) = _si(beam, found), found.C_f, laws(beam)
    printed.show(
        {
            "file": file,
            "K_theta": {"elements": K.value, "error": K.error, "law": law_K, "difference": K.value / law_K - 1},
            "C_f": {"elements": C_f.value, "error": C_f.error, "law": law_C, "difference": C_f.value / law_C - 1},
            "matrix": found.K,
            "order": found.order,
            "motions": [*dict(MOTIONS), "phi"],
            "bar": {"elements": found.bar, "exact": found.exact, "size": found.size},
            "levels": [
                {"edge_size": x.edge_size, "elements": x.elements, "K_theta": x.K_theta, "C_f": x.rigidity / found.bar}
                | {"matrix": x.K}
                for x in found.levels
            ],
            "units": {
                "K_theta": "N m",
                "matrix": "E_B and pitches: translations E d, couplings E d^2, rotations and twist E d^3",
                "size": "pitches",
                "levels.K_theta": "E d^3",
                "bar": "E d^3",
            },
            "youngs_modulus": beam.substrate.youngs_modulus,
            "pitch": beam.pitch,
            "written": written,
        }
    )


def show(file: str, beam: Beam, found: JointMatrix, written: list[str]) -> None:
    """Print the summary."""
    from rich.console import Console

    from squama.cli.summary import moment

    console = Console(highlight=False, markup=False, emoji=False)
    console = Console(highlight=False, markup=False, emoji=False, width=max(console.width, 100))
    K, C_f, (law_K, law_C) = _si(beam, found), found.C_f, laws(beam)
    console.print(f"{file}: the joint of a scale by finite elements", style="bold", soft_wrap=True)
    console.print()
    rows = [
        ("joint stiffness K_theta", moment(K.value), _bar(K.error / K.value), moment(law_K), K.value / law_K),
        ("inclusion factor C_f", f"{C_f.value:.4f}", _bar(C_f.error / C_f.value), f"{law_C:.4f}", C_f.value / law_C),
    ]
    console.print(
        _table(
            ("", "elements", "error", "scaling law", "elements to law"), [(*r[:4], f"{r[4] - 1:+.1%}") for r in rows]
        )
    )
    console.print()
    console.print(
        _table(("motion of the scale", "others free", "others held", "per rad/pitch"), _motions(beam, found.K))
    )
    console.print("K_theta is the moment about n_Y with the five other motions free; theta grows by a turn about -n_Y")
    console.print("last column: how far a scale moves by itself as the beam is twisted, without contact")
    console.print()
    console.print(
        "stiffness in E_B and pitches (shifts E d, rotations and twist E d^3, couplings E d^2)", soft_wrap=True
    )
    names = (*dict(MOTIONS), "phi")
    console.print(_table(("", *names), [(n, *(f"{x:.5f}" for x in r)) for n, r in zip(names, found.K, strict=True)]))
    console.print()
    console.print(_table(("edge size", "elements", "K_theta/(E d^3)", "C_f"), _levels(found)))
    order = "" if math.isnan(found.order) else f"; order seen {found.order:.2f}"
    console.print(f"sizes in pitches; extrapolated linearly from the last two{order}", soft_wrap=True)
    console.print(f"bare bar: {found.bar / found.exact:.5f} of the exact G J with elements of {found.size:.3g} pitches")
    for place in written:
        console.print(f"wrote {place}", soft_wrap=True)


def _bar(share: float) -> str:
    return f"{100 * share:.2g} %" if math.isfinite(share) else "unknown"


def _motions(beam: Beam, K: Any) -> list[tuple[str, ...]]:
    """Return a row per motion: stiffness with the others free and held, and motion per twist."""
    import numpy as np

    from squama.cli.summary import moment

    E, d = beam.substrate.youngs_modulus, beam.pitch
    free, rates = 1 / np.diag(np.linalg.inv(K[:6, :6])), -np.linalg.solve(K[:6, :6], K[:6, 6])
    rows: list[tuple[str, ...]] = []
    for i, (_, words) in enumerate(MOTIONS):
        if i < 3:
            texts = [f"{x * E * d:.4g} N/m" for x in (free[i], K[i, i])]
            rows.append((words, *texts, f"{rates[i] * d * 1e3:+.4g} mm"))
        else:
            texts = [moment(x * E * d**3) for x in (free[i], K[i, i])]
            rows.append((words, *texts, f"{rates[i]:+.4g} rad"))
    return rows


def _levels(found: JointMatrix) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = [
        (f"{x.edge_size:.4g}", str(x.elements), f"{x.K_theta:.6f}", f"{x.rigidity / found.bar:.4f}")
        for x in found.levels
    ]
    if len(rows) > 1:
        rows.append(("to zero", "", f"{found.K_theta.value:.6f}", f"{found.C_f.value:.4f}"))
    return rows


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> Any:
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for i, name in enumerate(head):
        table.add_column(name, header_style="", justify="right" if i else "left")
    for row in rows:
        table.add_row(*row)
    return table
