"""squama law: the law of a beam's section as a file for rod and section programs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from squama.cli import flags, output
from squama.cli.flags import flag, one_of, settled, whole
from squama.errors import refuse
from squama.io.files import label, table_place
from squama.loads import LOADS
from squama.units import number

if TYPE_CHECKING:
    from squama.sections.table import LawTable

FORMATS = {"csv": ".csv", "npz": ".npz", "abaqus": ".inp", "ansys": ".mac", "dyna": ".k"}
"""Formats and their file extensions."""
_FORMAT = (
    "csv, npz, abaqus (*BEAM GENERAL SECTION), ansys (GENB), dyna (MAT_119, also Radioss). Default: by the ending."
)
_UNCOUPLED = "Write each load alone (loading and unloading) in csv and npz, instead of a potential over both."
_POINTS = "Number of values of each load, odd (0 is one of them). Default: 41."
_KEPT = "load joint hold mu pitch scales_for_10_percent strain_limit lateral_rigidity squama_version"


def _far(verb: str) -> str:
    return f'Largest {verb}, both ways: "5 rad/m", "0.2 rad/pitch". Default: 0.3 rad/pitch if neither is given.'


def law(
    beam: flags.BeamFile,
    /,
    *,
    out: Annotated[flags.File, flag("File to write: .csv, .npz, .inp, .mac or .k; - prints it alone.", "--out", "-o")],
    format: Annotated[str | None, flag(_FORMAT, read=one_of(*FORMATS))] = None,  # noqa: A002 - the flag
    bend: Annotated[str | None, flag(_far("bend"))] = None,
    twist: Annotated[str | None, flag(_far("twist"))] = None,
    points: Annotated[int, flag(_POINTS, read=whole(3, 401, "41"))] = 41,
    uncoupled: Annotated[bool, flags.Parameter(help=_UNCOUPLED)] = False,
    mu: flags.Mu = None,
    ideal: flags.Ideal = None,
    base: flags.Base = flags.BASE,
) -> int:
    """Write the law of a beam's section, of the endless beam, for rod and section programs."""
    place = table_place(flags.problems(), "-o", out, as_json=base.json)
    flags.check_places([(place, tuple(FORMATS.values()) if format is None else (FORMATS[format],))], [beam])
    if place is None and format == "npz":
        flags.problems().add("-o", "-", "cannot print a binary file", "give -o a file, such as law.npz")
    if points % 2 == 0:
        flags.problems().add("--points", str(points), "is even, so 0 is none of the values", f"write {points + 1}")
    described = settled(base.beam(beam, mu))
    given = {"--bend": bend, "--twist": twist}
    if bend is None and twist is None:
        given = dict.fromkeys(given, "0.3 rad/pitch")
    pairs = zip(given.items(), (LOADS["bending"], LOADS["twisting"]), strict=True)
    rates = {load.rate: flags.asked(name, text, described, load.name) for (name, text), load in pairs}
    far = {name: rate for name, rate in rates.items() if rate is not None}
    kind = format or {ending: name for name, ending in FORMATS.items()}.get(Path(out).suffix.lower(), "csv")
    alone = uncoupled or len(far) < 2 or kind not in ("csv", "npz")
    friction = settled(described.friction.mu)

    import numpy as np

    from squama.sections import writers
    from squama.sections.table import law_table

    with flags.laid(flags.arguments(kappa="--bend", Phi="--twist", format="--format")):
        writers.check(kind, alone=alone, mu=friction)
        if not alone and friction:
            why = "must be 0 over the plane: with friction the order of bending and twisting counts"
            refuse("--mu", f"{friction:g}", why, "write --mu 0, or --uncoupled for each load alone")
        grids = {rate: np.linspace(-v, v, points) for rate, v in far.items()}
        table = law_table(
            described, kappa=grids.get("kappa"), Phi=grids.get("Phi"), mu=friction, uncoupled=alone, ideal=ideal
        )
        written = table.save(out, kind) if place else output.write_text(out, writers.text(table.data, kind))
    attrs = table.data.attrs
    record = {
        **{key: attrs[key] for key in _KEPT.split() if key in attrs},
        "format": kind,
        "uncoupled": alone,
        "warnings": attrs["warnings"].splitlines(),
        "beam": described.model_dump(),
        "table": {str(name): v.values for name, v in table.data.variables.items()},
    }
    return output.report(base.json, beam, [written], record, _shown(table, kind))


def _shown(table: LawTable, kind: str) -> Iterable[str]:
    """Yield the contents of the file, and their range of validity, as lines."""
    import numpy as np

    from squama.cli.report import held

    data, enough = table.data, float(table.data.attrs["scales_for_10_percent"])
    yield f": law of the section for {label(kind)}, mu = {data.attrs['mu']:g}, endless beam"
    yield held({**data.attrs, "band": math.nan})
    if table.plane:
        states, counts = np.unique(data.state.values, return_counts=True)
        told = ", ".join(f"{n} {state}" for state, n in zip(states, counts, strict=True))
        yield f"potential over {data.sizes['kappa']} x {data.sizes['Phi']} values of bend and twist: {told}"
    for name, strain in (("M", "kappa"), ("T", "Phi")):
        if name in data and not table.plane:
            loading, grid = data[name].values[0], data[strain].values
            last = np.flatnonzero(np.isfinite(loading))[-1]
            yield f"{name} = {loading[last]:.4g} N m at {strain} = {grid[last]:.4g} rad/m, the other load's strain free"
            for sense, word in zip("-+", data[f"end_{name}"].values, strict=True):
                if word:
                    yield f"{name} in sense {sense} ends before the table: {word}"
    if math.isfinite(enough):
        yield f"good to 10 % from {enough:.0f} scales on, with free ends (squama row, squama load: a number of scales)"
    yield f"compared with finite elements up to {number(data.attrs['strain_limit'], 'rad/m')}"
    if kind == "ansys":
        yield "warning: Ansys' guide asks for slopes below the first one; scales stiffen: try it on one element first"
    yield from output.warnings(data.attrs["warnings"])
