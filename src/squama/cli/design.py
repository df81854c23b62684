"""squama design and squama pareto: inverse design and trade-offs from a target file."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from squama import loads
from squama.cli import flags, output
from squama.cli.flags import flag, settled, whole
from squama.cli.output import of
from squama.io.files import label
from squama.loads import LOADS, ending, model
from squama.people import PITCH, figure
from squama.units import for_people, number

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.inverse.designing import Design, InverseDesign
    from squama.inverse.goals import Reached
    from squama.inverse.target import Target

SHOWN = 6
"""Largest number of dimensions with listed tolerances."""
MOST = 8
"""Largest number of designs in a table."""
FEW = 4
"""Number of designs of a front in its summary."""
Out = Annotated[flags.File | None, flag("Folder to write design_1.toml, design_2.toml ... to.", "--out", "-o")]
_MANY, _STARTS = "Largest number of designs. Default: the file's, or 5.", whole(16, 1 << 20, "4096")
Force = Annotated[bool, Parameter(help="Replace designs in the folder.")]
_ELEMENTS = "Compute the first design by finite elements too, with all its scales (extra fe; minutes)."
_FRONT = "Target file (TOML) with a table [front]; docs: how to design a beam."
_PICK = flags.several(whole(1, 100_000, "1,40,200"))
_GENERATIONS = "Number of generations. Default: the file's, or 100."
_SEED = "Seed of the search. Default: the file's, or 1."
_POPULATION = "Designs of a generation, and at most of the front. Default: the file's, or 200."


def design(
    target: Annotated[flags.File, Parameter(help="Target file (TOML); docs: how to design a beam.")],
    /,
    *,
    out: Out = None,
    force: Force = False,
    designs: Annotated[int | None, flag(_MANY, read=whole(1, 100, "5"))] = None,
    starts: Annotated[int, flag("Number of points screened within the bounds. Default: 4096.", read=_STARTS)] = 4096,
    seed: Annotated[int, flag("Seed of the screened points. Default: 1.", read=whole(0, 2**31 - 1, "1"))] = 1,
    plot: flags.Plot = (),
    elements: Annotated[bool, Parameter(help=_ELEMENTS)] = False,
    full: flags.Full = False,
    base: flags.Base = flags.BASE,
) -> int:
    """Find beams that meet a target; the exit status is 0 also where the summary says "not reached"."""
    flags.check_places([(path, flags.PLOTS) for path in plot], [target])
    read = settled(read_target(base, target, out, force=force))

    from squama.inverse import designing as inverse

    found = inverse.inverse_design(read, designs=designs, starts=starts, seed=seed, elements=elements)
    written = []
    if out is not None:
        title = f"design {{}} of {len(found)} for {label(target)}"
        written += output.write_beams(out, {i: d.to_toml(title.format(i)) for i, d in enumerate(found.designs, 1)})
    written += output.draw(plot, "inverse_figure", found, read)
    return output.report(base.json, target, written, _record(found), _summary(found, read).shown(full=full))


def read_target(base: flags.Base, path: str, out: str | None, *, force: bool, need: str = "target") -> Target | None:
    """Check the folder for beam files, and read the target; mistakes are collected."""
    from squama.inverse import target

    if force and out is None:
        flags.problems().add("--force", "", "replaces designs in the folder that -o names", "give -o too")
    with flags.problems().caught():
        if out is not None:
            output.check_folder(out, force=force)
    with flags.problems().caught():
        return target.read_target(path, need=need, overrides=base.overrides())
    return None


_DESIGN = "met confirmed found_by verdict values chosen active end rate_end other_contact refused warnings"
_ALL = "met confirmed verdict bounds tolerance settings notes"
_GOAL = "name unit sense asked reached difference met"


def _record(found: InverseDesign) -> dict[str, object]:
    designs: list[dict[str, object]] = []
    for d in found.designs:
        beside = {
            one.key: of(one, "words agrees note") | {"goals": [of(goal, _GOAL) for goal in one.goals]}
            for one in d.beside
        }
        own = {"goals": [vars(goal) for goal in d.goals], "beam": d.beam.model_dump(), "beside": beside}
        designs.append(of(d, _DESIGN) | own)
    return {**of(found, _ALL), **{key: found.settings[key] for key in ("joint", "scales")}, "designs": designs}


def _summary(found: InverseDesign, target: Target) -> output.Summary:
    """Return the summary: whether the target is reached, the first design, a line for each other design."""
    best, many = found[0], len(found)
    reached, *but = found.verdict.split("; ")
    if best.refused:
        # the reasons of a model that is not computed are those for which the design cannot be made
        but = [line.partition(", ")[0] if "not computed" in line else line for line in but]
        but = [line for line in but if not any(line in reason for reason in best.refused)]
    verdict = f"{reached}; {many} design{'s' * (many > 1)}"
    figures = [*((goal.name, _reached(goal)) for goal in best.goals), ("model", model(found.settings))]
    lines = [*_missed(found)]
    for i, d in enumerate(found.designs[1:], 2):
        words = ", ".join(f"{goal.name} {_with_unit(goal, goal.reached)}" for goal in d.goals)
        lines.append(f"design {i}{'' if d.met else ' (not reached)'}: {words}")
    lines += [f"note: {note}" for note in found.notes]
    first = _dimensions(found, target.space.beam)
    return output.Summary(verdict, figures, [*but, "design 1:", first, *lines], _warned(best), _all(found))


def _warned(best: Design) -> Iterable[str]:
    """Yield what speaks against the first design, one short line each; --full has the whole sentences."""
    places: dict[str, list[str]] = {}
    for line in best.refused:
        where, what, *_ = line.split(": ")
        places.setdefault(where, []).append(what)
    if places:
        said = "; ".join(f"{', '.join(what)} ({where})" for where, what in places.items())
        yield f"design 1 cannot be made as it is: {said}; --full says why"
    yield from dict.fromkeys(re.split(r"; | \(", line)[0] for line in best.warnings)


def _with_unit(goal: Reached, value: float) -> str:
    return "none" if math.isnan(value) else figure(value, goal.unit)


def _reached(goal: Reached) -> str:
    """Return the reached value of a goal, the effect of tolerances on it, and the required value, as text."""
    spread = f" +- {figure(goal.spread)}" if goal.spread > 0 else ""
    missed = "" if goal.met else ", missed"
    return f"{_with_unit(goal, goal.reached)}{spread} (asked {goal.wanted}{missed})"


def _dimensions(found: InverseDesign, start: Beam) -> Table:
    """Return a row for each dimension of the first design: value, tolerance, change from the starting beam."""
    from squama.study.parameters import own, people

    best, rows = found[0], []
    for name, value in best.values.items():
        (factor, unit), size, first = people(name), found.tolerance.get(name), own(start, name)
        tolerance = f"+- {figure(factor * size)}" if size else ""
        change = number(factor * (value - first), sign="+") if first else ""
        rows.append((name, f"{factor * value:.4g} {unit}".strip(), tolerance, change))
    rows += [(name, chosen, "", "") for name, chosen in best.chosen.items()]
    return output.table(("dimension", "value", "tolerance", "change"), rows, left=1)


def _missed(found: InverseDesign) -> Iterable[str]:
    """Yield the goals that the first design misses, and the bounds and limits on which designs lie."""
    best = found[0]
    for goal in best.goals:
        if not (found.met or goal.met):
            other = f" ({best.other_contact})" if best.other_contact else ""
            nearest = f"nearest {_with_unit(goal, goal.reached)} ({figure(goal.difference)} from it)"
            how = f"there is none; the curve ends with {best.end}{other}" if math.isnan(goal.reached) else nearest
            yield f"not reached: {goal.name}: asked {_with_unit(goal, goal.asked)}, {how}"
    for i, d in enumerate(found.designs[:MOST], 1):
        if d.active:
            yield f"design {i} lies on: {'; '.join(d.active)}"


def _all(found: InverseDesign) -> Iterable[str | Table]:
    """Yield the table of the designs, the effects of tolerances on the first, and its warnings as whole sentences."""
    from squama.inverse.goals import SENSES
    from squama.study.parameters import people

    shown = found.designs[:MOST]
    rows: list[tuple[str, ...]] = []
    for goals in zip(*(d.goals for d in shown), strict=True):
        goal = goals[0]
        name = f"{goal.name} ({goal.unit})" if goal.unit else goal.name
        rows.append((name, f"{SENSES[goal.sense]}{goal.asked:.5g}", *map(_value, goals)))
        rows += _beside(goal.name, shown)
        rows.append(("  by tolerances", "", *(f"+- {g.spread:.2g}" for g in goals)))
    for name, (low, high) in found.bounds.items():
        factor, unit = people(name)
        values = (f"{factor * d.values[name]:.5g}" for d in shown)
        rows.append((f"{name} ({unit})" if unit else name, f"{factor * low:.4g} to {factor * high:.4g}", *values))
    rows += [(name, "chosen", *(d.chosen[name] for d in shown)) for name in shown[0].chosen]
    rows.append(("end", "", *(d.end for d in shown)))
    yield output.table(("", "asked", *(str(k + 1) for k in range(len(shown)))), rows, left=2)
    yield from _notes(found)


def _value(goal: Reached, digits: int = 5) -> str:
    """Return the reached value of a goal for a table."""
    return "none" if math.isnan(goal.reached) else f"{goal.reached:.{digits}g}{'' if goal.met else ' (missed)'}"


def _beside(name: str, designs: Sequence[Design]) -> Iterable[tuple[str, ...]]:
    """Yield table rows with a goal's values by other models."""
    for key in dict.fromkeys(other.key for d in designs for other in d.beside):
        cells, words = [], set()
        for d in designs:
            here = [(other, g) for other in d.beside if other.key == key for g in other.goals if g.name == name]
            cells += [_value(g, 3) for _, g in here] or ["-"]
            words |= {other.words for other, _ in here}
        if words:
            # numbers of scales may differ
            label = "with its own scales" if len(words) > 1 else words.pop()
            yield f"  {label}", "", *cells


def _notes(found: InverseDesign) -> Iterable[str]:
    """Yield notes on other models, and the effects of tolerances on the first design."""
    from squama.study.parameters import people

    for i, d in enumerate(found.designs[:MOST], 1):
        yield from (f"design {i}, {other.words}: {other.note}" for other in d.beside if other.note)
    for goal in found[0].goals:
        words = []
        for name, value in sorted(goal.effects.items(), key=lambda item: -abs(item[1]))[:SHOWN]:
            factor, unit = people(name)
            if value:
                words.append(f"{name} ({f'+- {number(factor * found.tolerance[name])} {unit}'.strip()}) {value:+.2g}")
        if words:
            yield f"tolerances, design 1, {goal.name} ({goal.unit or '1'}): {', '.join(words)}"
    if others := [str(i) for i, d in enumerate(found.designs[1:], 2) if d.refused]:
        yield f"other designs that cannot be made as they are: {', '.join(others)}"
    yield from output.warnings([*found[0].refused, *found[0].warnings])


# ---- a front ---------------------------------------------------------------------------------------------


def pareto(
    target: Annotated[flags.File, Parameter(help=_FRONT)],
    /,
    *,
    out: Out = None,
    pick: Annotated[tuple[int, ...], flag("Designs that -o writes, e.g. 1,40,200. Default: all.", read=_PICK)] = (),
    force: Force = False,
    population: Annotated[int | None, flag(_POPULATION, read=whole(8, 10_000, "200"))] = None,
    generations: Annotated[int | None, flag(_GENERATIONS, read=whole(1, 100_000, "100"))] = None,
    seed: Annotated[int | None, flag(_SEED, read=whole(0, 2**31 - 1, "1"))] = None,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Trade figures of beams off against each other: a front, each point a beam that can be built (extra fit)."""
    if pick and out is None:
        flags.problems().add("--pick", "", "says which designs -o writes", "give -o too")
    common.check(target)
    read = settled(read_target(common, target, out, force=force, need="front"))

    from squama.inverse import front as inverse

    found = inverse.pareto(read, population=population, generations=generations, seed=seed)
    many = found.sizes["design"]
    folder: list[Path] = []
    wrote = []
    if out is not None:
        chosen = dict.fromkeys(pick or range(1, many + 1))
        if far := [str(i) for i in chosen if i > many]:
            print(f"squama: warning: --pick: the front has {many} designs, no {', '.join(far)}", file=sys.stderr)
        beams = inverse.beams(found)
        texts = {i: _text(label(target), found, beams[i - 1], i) for i in chosen if i <= many}
        folder = output.write_beams(out, texts)
        wrote.append(f"wrote {len(folder)} beam files into {label(out)}")
    files = output.write(common, lambda: found, "front_figure")
    wrote += [f"wrote {label(path)}" for path in files]
    shown = _front_summary(found).shown(full=full)
    return output.report(common.json, target, [*folder, *files], _front(found), shown, wrote)


def _text(file: str, front: xr.Dataset, beam: Beam, number: int) -> str:
    one = front.sel(design=number)
    values = [f"{name} = {float(one[name]):.6g} {one[name].attrs['units']}" for name in _objectives(front)]
    return f"# design {number} of {front.sizes['design']} on the front of {file}: {', '.join(values)}\n{beam.to_toml()}"


def _objectives(front: xr.Dataset) -> list[str]:
    return [str(name) for name, v in front.data_vars.items() if "objective" in v.attrs]


def _figures_of(front: xr.Dataset) -> list[str]:
    """Return the names of the objectives, each before that of the endless beam where it is told."""
    both = (name for one in _objectives(front) for name in (one, f"{one}_endless"))
    return [name for name in both if name in front]


def _front(front: xr.Dataset) -> dict[str, object]:
    return {
        **{str(name): value for name, value in front.attrs.items()},
        "front": {str(name): v.values for name, v in front.data_vars.items()},
        "units": output.units(front.data_vars.items()),
    }


def _front_summary(front: xr.Dataset) -> output.Summary:
    """Return the summary of a front: ranges of its objectives, and a few of its designs."""
    names, held = _objectives(front), "; held straight" * loads.holds(front.attrs["hold"], LOADS[front.attrs["load"]])
    spans, figures = list[str](), list[tuple[str, str]]()
    for name in names:
        factor, unit = _people(front, name)
        low, high = (factor * float(limit) for limit in (front[name].min(), front[name].max()))
        spans.append(f"{name} {figure(low)} to {figure(high, unit)}")
        at = f" ({front[name].attrs['at']})" if "at" in front[name].attrs else ""
        figures.append((name, f"{front[name].attrs['long_name']}{at}"))
    which = f"their own scales {ending(front.attrs['ends'])}" if "ends" in front.attrs else "endless beam"
    figures.append(("model", f"{model(front.attrs)}; {which}{held}"))
    verdict = f"{front.sizes['design']} designs; {', '.join(spans)}"
    return output.Summary(verdict, figures, [_designs(front, FEW, _figures_of(front))], (), _whole(front))


def _people(front: xr.Dataset, name: str) -> tuple[float, str]:
    """Return the unit in which texts show a figure or a dimension, after its factor from SI."""
    from squama.study.parameters import people

    if "." in name:
        return people(name)
    factor, unit = for_people(str(front[name].attrs["units"]))
    return factor, PITCH if unit == "deg" else unit


def _designs(front: xr.Dataset, most: int, names: Sequence[str]) -> Table:
    """Return a table of at most ``most`` designs, evenly spaced along the first objective; columns ``names``."""
    import numpy as np

    n = front.sizes["design"]
    few = front.isel(design=np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(int)))
    heads, columns = [], []
    for name in names:
        factor, unit = _people(front, name) if few[name].dtype.kind == "f" else (1.0, "")
        words = name.removeprefix("chosen.").replace(".", ".\n")
        heads.append(f"{words} ({unit})" if unit else words)
        values = few[name].values.tolist()
        columns.append([number(factor * x) if isinstance(x, float) else str(x) for x in values])
    numbers = few.design.values.astype(str).tolist()
    return output.table(("design", *heads), zip(numbers, *columns, strict=True), left=0)


def _whole(front: xr.Dataset) -> Iterable[str | Table]:
    """Yield a table of more designs, with their dimensions."""
    names = [str(name) for name in front.data_vars]
    dimensions = [name for name in names if "low" in front[name].attrs]
    words = [name for name in names if name.startswith("chosen.")]
    yield _designs(front, 4 * FEW, [*_figures_of(front), *dimensions, *words])
