"""squama export: solids for the printer and the mould, from a beam file."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from squama import units
from squama.beam.faces import described
from squama.cli import flags, output
from squama.cli.flags import flag, number, settled, words_of
from squama.fabrication.kinds import FORMATS, PARTS, FormatName, PartName
from squama.io.files import exists, label

if TYPE_CHECKING:
    from rich.table import Table

    from squama.fabrication.exporting import Export
    from squama.fabrication.mesh import Check

KEPT = ("thickness", "theta0", "alpha", "depth of slots", "thickness of slots", "distance of slots")
"""Measured sizes that are printed with --full."""


def _read_size(name: str, text: str) -> float:
    """Read a size of the plan (m or rad)."""
    from squama.fabrication import plan

    key = name.removeprefix("--")
    return plan.read({key: text}, "--", bare=False)[key]


_size = flags.Reader(_read_size, 0.0)


_density = number(0.01, 24.99, "1.2", "0.01 to 24.99 g/cm3")
_PARTS = f"Parts to write. Default: {','.join(PARTS)}."
_PLA = "Density of printed parts, g/cm3. Default: 1.24 (solid PLA)."
_KINDS = "Formats: stl, 3mf (both in mm), step (extra step). Default: stl,3mf."
_CLEARANCE = "Clearance of tabs in their slots, and of blades in the lid, on every side. Default: 0.2 mm."
_PICTURE = "Picture of the assembled beam and the mould (.png, .svg, .pdf); may be repeated."
_BED = 'Longest part that fits the printer, e.g. "200 mm"; longer moulds are split. Default: no limit.'


@flags.group
class Made:
    """Parts, formats and sizes of an export: arguments of :func:`squama.export`."""

    scales: Annotated[int | None, flags.scales(500, "Number of scales. Default: the file's; allowed:", least=1)] = None
    parts: Annotated[tuple[PartName, ...], flag(_PARTS, read=words_of(PARTS))] = PARTS
    formats: Annotated[tuple[FormatName, ...], flag(_KINDS, read=words_of(FORMATS))] = ("stl", "3mf")
    clearance: Annotated[float, flag(_CLEARANCE, read=_size)] = 0.2e-3
    feature: Annotated[float, flag("Smallest size that can be printed or cast. Default: 0.4 mm.", read=_size)] = 0.4e-3
    wall: Annotated[float, flag("Thickness of the mould's walls, floor and lid. Default: 3 mm.", read=_size)] = 3e-3
    ends: Annotated[float, flag("Plain length of the bar at each end, for grips. Default: 30 mm.", read=_size)] = 30e-3
    draft: Annotated[float, flag("Draft angle of the tray's sides. Default: 0 deg.", read=_size)] = 0.0
    bed: Annotated[float | None, flag(_BED, read=_size)] = None
    scale_density: Annotated[float, flag(_PLA, read=_density)] = 1.24
    substrate_density: Annotated[float, flag("Density of the silicone, g/cm3. Default: 1.15.", read=_density)] = 1.15


MADE = Made()


def export(
    beam: flags.BeamFile,
    /,
    *,
    out: Annotated[flags.File, flag("Folder to write to.", "--out", "-o")],
    made: Made = MADE,
    picture: Annotated[tuple[flags.File, ...], flag(_PICTURE)] = (),
    force: Annotated[bool, Parameter(help="Replace files that no export has written.")] = False,
    full: flags.Full = False,
    base: flags.Base = flags.BASE,
) -> int:
    """Write scales, substrate, mould and assembled beam as STL, 3MF or STEP, checked, with a bill of materials."""
    # a picture may lie in the folder that is made here
    folder = Path(os.path.realpath(out))
    into = {path: Path(os.path.realpath(path)).parent == folder for path in picture}
    inside = () if exists(folder) else tuple(path for path in picture if into[path])
    flags.check_places([(path, flags.PLOTS) for path in picture if path not in inside], [beam])
    flags.check_places([(Path(path).name, flags.PLOTS) for path in inside])
    if picture and not {"assembly", "mould"} & set(made.parts):
        flags.problems().add("--picture", "", "shows the assembly and the mould", "write one of them in --parts")
    described = settled(base.beam(beam, friction=False))

    from squama.fabrication import exporting

    found = exporting.export(described, out, force=force, **vars(made))
    written = [*found.files, *output.draw(picture, "solids_figure", found)]
    wrote = [f"wrote {len(written)} files: {label(out)}", *(f"  {label(path)}" for path in written if full)]
    return output.report(base.json, beam, written, _record(found), _summary(found).shown(full=full), wrote)


def _record(made: Export) -> dict[str, object]:
    return {
        "plan": made.plan._asdict(),
        "bill": [row.record() for row in made.bill],
        "checks": [{**check._asdict(), "holds": check.holds} for check in made.checks],
        "units": {"lengths": "mm", "angles": "rad", "volumes": "mm^3", "masses": "g"},
    }


def _summary(made: Export) -> output.Summary:
    """Return the summary: sizes, result of the checks, bill of materials."""
    plan = made.plan
    where = f", on {described(plan.faces)}" if plan.pieces > plan.scales else ""
    verdict = f"{plan.scales} scales on a bar of {plan.total:g} x {plan.width:g} x {plan.height:g} mm{where}"
    closed = f"{len(made.checks)} checks hold: every solid is closed, in one piece, and a manifold"
    return output.Summary(verdict, [("solids", closed)], _bill(made), (), _measured(made.checks))


def _bill(made: Export) -> Iterable[Table]:
    """Yield the table of the bill of materials."""
    rows: list[tuple[str, ...]] = []
    for row in made.bill:
        volume, n = row.volume / 1000, row.number
        figures = (volume, row.mass, n * volume, n * row.mass)
        rows.append((row.part, f"{row.material}, {row.made}", str(n), *(units.number(v) for v in figures)))
    for printed, words in ((True, "all that is printed"), (False, "all silicone")):
        if those := [row for row in made.bill if (row.made == "printed") == printed]:
            volume, mass = (sum(getattr(row, key) * row.number for row in those) for key in ("volume", "mass"))
            rows.append((words, "", "", "", "", units.number(volume / 1000), units.number(mass)))
    yield output.table(("part", "made of", "number", "volume cm3", "mass g", "all cm3", "all g"), rows, left=2)


def _measured(checks: tuple[Check, ...]) -> list[str]:
    """Return the measured properties of the solids as lines."""
    volumes = [c for c in checks if c.what == "volume"]
    memory = [abs(c.measured / c.expected - 1) for c in volumes if "." not in c.solid]
    read = [abs(c.measured / c.expected - 1) for c in volumes if "." in c.solid]
    within = f"volumes are the analytic ones within {max(memory):.1g}"
    lines = [f"{within}, read back from the files within {max(read):.1g}" if read else within]
    common = [c for c in checks if c.what.startswith("common volume")]
    if common:
        lines.append(f"common volume of all pairs of solids: {max(c.measured for c in common):.1g} mm3")
    lines += [f"{c.what}: {c.measured:.6g} mm" for c in checks if c.what.startswith("gap")]
    kinds = {(c.what, c.solid.replace("-", " ").split(" ")[0]): c for c in reversed(checks) if c.what in KEPT}
    firsts = sorted(kinds.values(), key=checks.index)
    return [*lines, *(f"{c.what}, measured on {c.solid}: {c.measured:.6g} {c.unit}" for c in firsts)]
