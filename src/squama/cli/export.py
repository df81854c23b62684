"""squama export: solids for the printer and the mould, from a beam file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Problems, flag, read_number, read_overrides
from squama.errors import InputError, SquamaError

if TYPE_CHECKING:
    from squama.fabrication.facade import Export
    from squama.fabrication.measure import Check

KEPT = ("thickness", "theta0", "alpha", "depth of slots", "thickness of slots", "distance of slots")
"""Sizes that are printed beside what was asked for."""


def export(
    beam: str,
    /,
    *,
    out: Annotated[str, Parameter(name=("--out", "-o"), help="Folder to write to.", allow_leading_hyphen=True)],
    scales: Annotated[str | None, flag("Number of scales, 1 to 500 (that of the file).")] = None,
    parts: Annotated[str, flag("What to write (scale,substrate,mould,assembly).")] = "scale,substrate,mould,assembly",
    formats: Annotated[str, flag("stl, 3mf (both in mm), step (extra step), or several (stl,3mf).")] = "stl,3mf",
    clearance: Annotated[
        str, flag("Room between tab and slot, and between blades and the mould's lid, on every side (0.2 mm).")
    ] = "0.2 mm",
    feature: Annotated[str, flag("Least size that can be printed or cast (0.4 mm).")] = "0.4 mm",
    wall: Annotated[str, flag("Thickness of the mould's walls, floor and lid (3 mm).")] = "3 mm",
    ends: Annotated[str, flag("Plain length of the bar at each end, for the grips (30 mm).")] = "30 mm",
    draft: Annotated[str, flag("Inclination of the tray's sides (0 deg).")] = "0 deg",
    bed: Annotated[str | None, flag("Longest part that the printer takes; longer moulds are made in pieces.")] = None,
    scale_density: Annotated[str, flag("Density of what is printed, g/cm3 (1.24, solid PLA).")] = "1.24",
    substrate_density: Annotated[str, flag("Density of the silicone, g/cm3 (1.15).")] = "1.15",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    picture: Annotated[
        tuple[str, ...], flag("Picture of the assembled beam and the mould: .png, .svg or .pdf; may be repeated.")
    ] = (),
    force: Annotated[bool, Parameter(help="Replace files in the folder that no export has written.")] = False,
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
) -> int:
    """Write scales, substrate, mould and assembled beam as STL, 3MF or STEP, checked, with a bill of materials.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import files
    from squama.cli import run
    from squama.cli.options import Options, check_outputs
    from squama.fabrication import facade, plan, solids

    problems = Problems()
    arguments: dict[str, Any] = {"force": force}
    overrides: dict[str, dict[str, Any]] = {}
    for name, text, allowed in (("parts", parts, solids.PARTS), ("formats", formats, facade.FORMATS)):
        with problems.caught():
            arguments[name] = facade.several(f"--{name}", [word.strip() for word in text.split(",")], allowed)
    with problems.caught():
        if scales is not None:
            arguments["scales"] = _scales(scales)
    sizes = {"clearance": clearance, "feature": feature, "wall": wall, "ends": ends, "draft": draft}
    with problems.caught():
        arguments |= plan.read(sizes | ({} if bed is None else {"bed": bed}), "--", bare=False)
    for name, text in (("scale_density", scale_density), ("substrate_density", substrate_density)):
        with problems.caught():
            flag_name = "--" + name.replace("_", "-")
            arguments[name] = read_number(flag_name, text, 0.01, 24.99, "0.01 to 24.99 g/cm3", "1.2")
    with problems.caught():
        overrides = read_overrides(set_)
    # a picture may go into the folder that is made here
    inside = () if Path(out).exists() else tuple(p for p in picture if Path(p).parent.resolve() == Path(out).resolve())
    problems.lines += check_outputs(Options(plot=tuple(p for p in picture if p not in inside)), [beam])
    problems.lines += check_outputs(Options(plot=tuple(Path(p).name for p in inside)), [])
    if picture and not {"assembly", "mould"} & set(arguments.get("parts", solids.PARTS)):
        problems.lines.append("--picture: shows the assembly and the mould; write one of them in --parts")
    described = None
    with problems.caught():
        described = run.read_beam(beam, overrides)
    problems.settle()
    assert described is not None

    try:
        made = facade.export(described, out, **arguments)
    except InputError:
        raise
    except SquamaError as error:
        raise InputError(str(error)) from None
    written = list(made.files)
    if picture:
        from squama import plot as figures

        figure = figures.solids_figure(made)
        written += [figures.save_figure(figure, path) for path in picture]
    if json:
        _record(files.label(beam), made, written)
    else:
        _show(files.label(beam), made, written, out)
    return 0


def _scales(text: str) -> int:
    from squama.fabrication.plan import MOST_SCALES

    value = read_number("--scales", text, 1, MOST_SCALES, f"1 to {MOST_SCALES}", "25")
    if value != int(value):
        message = f"--scales = {text}: is not a whole number; write e.g. 25"
        raise InputError(message)
    return int(value)


def _record(file: str, made: Export, written: list[Path]) -> None:
    from squama.cli import record

    record.show(
        {
            "file": file,
            "plan": made.plan._asdict(),
            "bill": [row.record() for row in made.bill],
            "checks": [{**check._asdict(), "holds": check.holds} for check in made.checks],
            "units": {"lengths": "mm", "angles": "rad", "volumes": "mm^3", "masses": "g"},
            "written": [str(path) for path in written],
        }
    )


def _show(file: str, made: Export, written: list[Path], folder: str) -> None:
    """Print the bill, what was measured, and the files."""
    from rich.console import Console
    from rich.table import Table

    from squama import files

    plan = made.plan
    console = Console(highlight=False, markup=False, emoji=False)
    console = Console(highlight=False, markup=False, emoji=False, width=max(console.width, 100))
    console.print(
        f"{file}: {plan.scales} scales on a bar of {plan.total:g} x {plan.width:g} x {plan.height:g} mm",
        style="bold",
        soft_wrap=True,
    )
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for i, name in enumerate(("part", "made of", "number", "volume cm3", "mass g", "all cm3", "all g")):
        table.add_column(name, header_style="bold", justify="left" if i < 2 else "right")
    for row in made.bill:
        volume, n = row.volume / 1000, row.number
        figures = (volume, row.mass, n * volume, n * row.mass)
        table.add_row(row.part, f"{row.material}, {row.made}", str(n), *(f"{v:.4g}" for v in figures))
    for words in ("printed", "cast"):
        rows = [row for row in made.bill if (row.made == "printed") == (words == "printed")]
        if rows:
            volume, mass = (sum(getattr(row, key) * row.number for row in rows) for key in ("volume", "mass"))
            what = "all that is printed" if words == "printed" else "all silicone"
            table.add_row(what, "", "", "", "", f"{volume / 1000:.4g}", f"{mass:.4g}")
    console.print(table)
    for line in [*_measured(made.checks), f"wrote {len(written)} files: {files.label(folder)}"]:
        console.print(line, soft_wrap=True)
    for path in written:
        console.print(f"  {files.label(path)}", soft_wrap=True)


def _measured(checks: tuple[Check, ...]) -> list[str]:
    """Return in words what was measured."""
    volumes = [c for c in checks if c.what == "volume"]
    memory = [abs(c.measured / c.expected - 1) for c in volumes if "." not in c.solid]
    read = [abs(c.measured / c.expected - 1) for c in volumes if "." in c.solid]
    lines = [f"{len(checks)} checks hold: every solid is closed, in one piece, and a manifold"]
    within = f"volumes are the analytic ones within {max(memory):.1g}"
    lines.append(f"{within}, read back from the files within {max(read):.1g}" if read else within)
    common = [c for c in checks if c.what.startswith("common volume")]
    if common:
        lines.append(f"common volume of all pairs of solids: {max(c.measured for c in common):.1g} mm3")
    lines += [f"{c.what}: {c.measured:.6g} mm" for c in checks if c.what.startswith("gap")]
    done: set[tuple[str, str]] = set()
    for c in checks:
        kind = c.solid.replace("-", " ").split(" ")[0]
        if c.what in KEPT and (c.what, kind) not in done:
            done.add((c.what, kind))
            lines.append(f"{c.what}, measured on {c.solid}: {c.measured:.6g} {c.unit}")
    return lines
