"""squama sweep and squama map: a beam over ranges of parameters, into a store; a slice of it as a picture or as CSV."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from squama.cli import flags, output
from squama.cli.flags import flag, pair, settled, whole
from squama.errors import refuse
from squama.interrupt import kept
from squama.io.files import label, table_place
from squama.loads import model

if TYPE_CHECKING:
    from squama.study.slices import Slice

_OVER = (
    "Parameter and its values: mu=0:2:401 (low:high:number), alpha=15deg:75deg:601, margin=0.001,0.01; may be repeated."
)
_RANGE, _AT = pair("name=low:high:count", "mu=0:2:401"), pair("name=value", "eta=3")
_TILE = "Largest number of cells solved and written at once. Default: by the memory."
_CELLS = "CSV file to write: a row for each cell of the slice, units in its header; - prints it alone."
_PROGRESS = "Progress on standard error: bar, json or none. Default: bar on a terminal."
_DRAWN = "Variable to draw, e.g. phi_e, end; on hinges also lock. Default: stiffness_ratio; on hinges RED."
_HELD = "Value of a dimension that is not drawn, e.g. eta=3; may be repeated."
_PATHS = "Values of x whose paths are drawn too (--variable lock, y = mu), e.g. 30deg,45deg."


@flags.group
class Solving(flags.How):
    """Settings for the cells: arguments of :func:`squama.sweep`."""

    law: Annotated[str, flag("Force law: edge, plate, or both (edge,plate). Default: edge.")] = "edge"
    at: Annotated[str | None, flag(flags.AT)] = None
    sense: flags.Sense = "+"
    margin: flags.Margin = 0.01
    tile: Annotated[int | None, flag(_TILE, read=whole(1, 10**9, "16384"))] = None


SOLVING = Solving()


def sweep(
    beam: flags.BeamFile,
    /,
    *,
    over: Annotated[tuple[flags.Pair, ...], flag(_OVER, read=_RANGE, many=True)] = (),
    out: Annotated[flags.File, flag("Store (.zarr) to write or to continue.", "--out", "-o")],
    solving: Solving = SOLVING,
    mu: flags.Mu = None,
    shard: Annotated[str | None, flag("Share of the tiles for a job of an array, e.g. 1/4. Default: all.")] = None,
    dask: Annotated[str | None, flag("Cluster (dask.distributed): local:2 or tcp://host:8786. Default: none.")] = None,
    progress: Annotated[str | None, flag(_PROGRESS)] = None,
    base: flags.Base = flags.BASE,
) -> int:
    """Solve a beam over ranges of its parameters, into a store that can be resumed."""
    from squama.study import cluster
    from squama.study import sweeping as study
    from squama.study.parameters import ALIASES
    from squama.study.store import open_sweep

    ranges = flags.once("--over", over, ALIASES)
    if not over and "--over" not in flags.problems().flags:
        flags.problems().add("--over", "", "is missing", "name a parameter and its range, e.g. --over mu=0:2:401")
    if mu is not None and {"mu", "friction.mu"} & set(ranges):
        flags.problems().add("--mu", "", "mu is swept too", "keep one of --mu and --over mu")
    if not out.strip():
        flags.problems().add("--out", "", "is empty", "write e.g. map.zarr")
    chosen = progress or ("bar" if sys.stderr.isatty() else "none")
    names = flags.arguments("at", "tile", "shard", "dask", "progress")
    for check, text in ((study.known, chosen), (study.read_shard, shard or "1/1"), (cluster.check, dask or "local:1")):
        with flags.problems().caught(), flags.laid(names):
            check(text)
    described = base.beam(beam, mu, friction=False)
    flags.asked("--at", solving.at, described, solving.load)
    described = settled(described)

    laws = {"law": tuple(part.strip() for part in solving.law.split(","))} if "," in solving.law else {}
    with flags.laid(names | {name: f"--over {name}" for name in ranges}):
        plan = study.make_plan(described, ranges, bare=False, **vars(solving) | laws)
    name = label(out)
    with kept(name):
        done, tiles = study.run(plan, Path(out), shard=shard, dask=dask, progress=chosen)
    sides = " x ".join(f"{n} {dim}" for n, dim in zip(plan.shape, plan.dims, strict=True))
    dataset = open_sweep(out)
    at, own = plan.model.at, plan.model.own
    verdict = f"all {plan.cells} beams are computed ({sides})"
    if done < tiles:
        verdict = f"{f'shard {shard} is done; ' if shard else ''}{done} of {tiles} tiles are done"
    figures = [
        ("figures at", at.words(described.pitches) if at else ""),
        ("model", f"{model(dataset.attrs)}; endless beams"),
        ("finite_torque", f"and finite_stiffness_ratio: of {own.words}" if own else ""),
        ("draw it with", f"squama map {name} --plot map.png" if done == tiles else ""),
    ]
    facts = {"cells": plan.cells, "tiles": tiles, "tiles_done": done, "sha256": plan.digest}
    notes = study.notes(plan, solving.joint, dataset)
    facts |= {**plan.model.attrs(described), "notes": notes}
    return output.report(base.json, beam, [out], facts, output.Summary(verdict, figures, (), notes).shown())


MOST_ROWS = 5_000_000
_NAMES = ("x", "y", "panels", "at", "lines", "paths", "variable")


def map(  # noqa: A001 - the command's name
    store: Annotated[flags.File, Parameter(help="Store (.zarr) of a sweep, finished or not.")],
    /,
    *,
    plot: flags.Plot = (),
    csv: Annotated[flags.File | None, flag(_CELLS)] = None,
    variable: Annotated[str | None, flag(_DRAWN)] = None,
    x: Annotated[str | None, flag("Dimension of the horizontal axis.")] = None,
    y: Annotated[str | None, flag("Dimension of the vertical axis; of the lines with --variable lock.")] = None,
    panels: Annotated[str | None, flag("Dimension that gets a panel for each value, e.g. margin.")] = None,
    at: Annotated[tuple[flags.Pair, ...], flag(_HELD, read=_AT, many=True)] = (),
    lines: Annotated[str | None, flag("Lines to draw with --variable lock, e.g. 0.2,0.5,1. Default: six.")] = None,
    paths: Annotated[str | None, flag(_PATHS)] = None,
    json: flags.Json = False,
) -> int:
    """Draw a slice of a sweep, or write it as CSV: contours, regimes, lock envelopes."""
    from squama.study import slices
    from squama.study.store import open_sweep

    held = flags.once("--at", at)
    if not plot and csv is None:
        flags.problems().add("", "", "there is nothing to write", "give --plot map.png or --csv map.csv")
    place = table_place(flags.problems(), "--csv", csv, as_json=json)
    flags.check_places([*((path, flags.PLOTS) for path in plot), (place, (".csv",))])
    for name, text in (("lines", lines), ("paths", paths)):
        if text is not None and variable != "lock":
            flags.problems().add(f"--{name}", "", "belongs to --variable lock", "leave it out")
    flags.problems().settle()

    dataset = open_sweep(store)
    hinged = dataset.attrs["joint"] == "hinge"
    variable = variable or ("RED" if hinged else "stiffness_ratio")
    known = [*(str(name) for name in dataset.data_vars if name != "status"), *(["lock"] if hinged else [])]
    if variable not in known:
        refuse("--variable", label(variable), f"must be one of {', '.join(known)}")
    names = {name: f"--{name}" for name in _NAMES}
    with flags.laid({**names, **{str(name): f"--at {name}" for name in dataset["RED"].dims}}):
        part = slices.take(dataset, x=x, y=y, panels=panels, at=held, bare=False)
    chosen = drawn_paths = None
    if variable == "lock":
        with flags.laid({**names, str(part.y): f"--lines {part.y}"}):
            chosen = _lines(part, lines)
    if paths is not None:
        with flags.laid({**names, part.x: f"--paths {part.x}"}):
            drawn_paths = slices.paths(part, [text.strip() for text in paths.split(",")], bare=False)
    size = part.data["RED"].size
    if csv is not None and size > MOST_ROWS:
        refuse("--csv", "", f"the slice has {size:,} rows, {MOST_ROWS:,} at most", "hold more with --at")
    name, written, tiles = label(store), [], dataset["status"].size
    axes = {"x": part.x, "y": part.y, "panels": part.panels}
    missing = int((dataset["status"] == 0).sum())
    if plot:
        thin = slices.thinned(part, 1200)
        written += output.draw(plot, "map_figure", thin.data, variable, **axes, lines=chosen, paths=drawn_paths)
    if csv is not None:
        written.append(output.write_csv(csv, slices.worded(part.data.load())))
    facts = {"variable": variable, **axes, "cells": size, "tiles": tiles, "tiles_missing": missing}
    facts |= {key: dataset.attrs[key] for key in ("joint", "scales", "at") if key in dataset.attrs}
    notes = output.warnings([f"{name}: {missing} of {tiles} tiles are not computed yet"] if missing else [])
    if csv is not None and place is None:
        return output.report(False, store, written, {}, notes)
    notes += [f"wrote {label(path)}" for path in written]
    return output.say(json, {"file": name, **facts, "written": [str(path) for path in written]}, notes)


def _lines(part: Slice, lines: str | None) -> list[float]:
    """Return the values of y whose lock lines are drawn: six by default."""
    import numpy as np

    from squama.study import slices

    if part.y is None:
        refuse("--variable", "lock", "needs two dimensions, one along the lines and one from line to line")
    if lines is not None:
        return slices.values_of(part, [text.strip() for text in lines.split(",")], bare=False)
    values = part.data[part.y].values
    return [float(values[i]) for i in dict.fromkeys(np.linspace(0, values.size - 1, 6).round().astype(int).tolist())]
