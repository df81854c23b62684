"""squama design: beams that do what is asked, from a target file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Options, Problems, check_outputs, flag, read_number, read_overrides
from squama.errors import InputError

if TYPE_CHECKING:
    from squama.inverse.results import Design, InverseDesign

SHOWN = 6
"""Dimensions whose tolerances are listed."""


def design(
    target: str,
    /,
    *,
    out: Annotated[
        str | None,
        Parameter(name=("--out", "-o"), help="Folder for design_1.toml, design_2.toml ...", allow_leading_hyphen=True),
    ] = None,
    force: Annotated[bool, Parameter(help="Replace designs that are in the folder.")] = False,
    designs: Annotated[str | None, flag("How many different designs at most (the file's, or 5).")] = None,
    starts: Annotated[str, flag("How many points of the bounds are screened (4096).")] = "4096",
    seed: Annotated[str, flag("Seed of the screened points (1).")] = "1",
    set_: Annotated[
        tuple[str, ...],
        flag("A value in place of the starting beam's, e.g. friction.mu=0.3; may be repeated.", "--set"),
    ] = (),
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = (),
    json: Annotated[bool, Parameter(help="Print everything as JSON instead of the summary.")] = False,
) -> int:
    """Find beams that do what is asked: lock at a twist, follow a curve, within bounds and limits.

    Exit status 0 also where the target is not reached; the summary then says "not reached".

    Parameters
    ----------
    target
        Target file (TOML); see docs, how-to: design a beam.
    """
    from squama import files
    from squama.cli import folder
    from squama.inverse import designs as inverse
    from squama.inverse.target import read_target

    problems = Problems()
    numbers: dict[str, int] = {}
    overrides: dict[str, dict[str, Any]] = {}
    for name, text, low, high, example in (
        ("designs", designs, 1, 100, "5"),
        ("starts", starts, 16, 1 << 20, "4096"),
        ("seed", seed, 0, 2**31 - 1, "1"),
    ):
        with problems.caught():
            if text is not None:
                numbers[name] = whole(f"--{name}", text, low, high, example)
    with problems.caught():
        overrides = read_overrides(set_)
    problems.lines += check_outputs(Options(plot=plot), [target])
    with problems.caught():
        if out is not None:
            folder.check(out, force=force)
    read = None
    with problems.caught():
        read = read_target(target, overrides=overrides)
    problems.settle()
    assert read is not None

    found = inverse.find(read, **numbers)
    written: list[Path] = []
    if out is not None:
        title = f"design {{}} of {len(found)} for {files.label(target)}"
        written += folder.write(out, [d.to_toml(title.format(i + 1)) for i, d in enumerate(found.designs)])
    if plot:
        from squama import plot as figures

        figure = figures.inverse_figure(found, read)
        written += [figures.save_figure(figure, path) for path in plot]
    if json:
        _record(files.label(target), found, written)
    else:
        _show(files.label(target), found, written)
    return 0


def whole(name: str, text: str, low: int, high: int, example: str) -> int:
    """Return a whole number of a flag."""
    value = read_number(name, text, low, high, f"{low} to {high}", example)
    if value != int(value):
        message = f"{name} = {text}: is not a whole number; write e.g. {example}"
        raise InputError(message)
    return int(value)


def _record(file: str, found: InverseDesign, written: list[Path]) -> None:
    from squama.cli import record

    def one(d: Design) -> dict[str, Any]:
        return {
            "met": d.met,
            "values": d.values,
            "goals": [vars(goal) for goal in d.goals],
            "active": d.active,
            "end": d.end,
            "rate_end": d.rate_end,
            "other_contact": d.other_contact,
            "warnings": d.warnings,
            "beam": d.beam.model_dump(),
        }

    record.show(
        {
            "file": file,
            "met": found.met,
            "designs": [one(d) for d in found.designs],
            "bounds": found.bounds,
            "tolerance": found.tolerance,
            "settings": found.settings,
            "notes": found.notes,
            "written": [str(path) for path in written],
        }
    )


def _show(file: str, found: InverseDesign, written: list[Path]) -> None:
    """Print designs side by side, then what holds for the first."""
    from rich.console import Console
    from rich.table import Table

    from squama import files

    console = Console(highlight=False, markup=False, emoji=False)
    console = Console(highlight=False, markup=False, emoji=False, width=max(console.width, 100))
    verdict = "target reached" if found.met else "target not reached, nearest attainable"
    many = f"{len(found)} designs" if len(found) > 1 else "1 design"
    console.print(f"{file}: {verdict}, {many}", style="bold", soft_wrap=True)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for i, name in enumerate(("", "asked", *(str(k + 1) for k in range(min(len(found), 8))))):
        table.add_column(name, header_style="bold", justify="left" if i < 2 else "right", no_wrap=i < 2)
    shown = found.designs[:8]
    for k, goal in enumerate(shown[0].goals):
        sense = {"=": "", ">=": "at least ", "<=": "at most "}[goal.sense]
        name = f"{goal.name} ({goal.unit})" if goal.unit else goal.name
        table.add_row(name, f"{sense}{goal.asked:.5g}", *(_reached(d, k) for d in shown))
        table.add_row("  by tolerances", "", *(f"+- {d.goals[k].spread:.2g}" for d in shown))
    for name, (low, high) in found.bounds.items():
        factor, unit = _unit(name)
        values = (f"{factor * d.values[name]:.5g}" for d in shown)
        table.add_row(f"{name} ({unit})" if unit else name, f"{factor * low:.4g} to {factor * high:.4g}", *values)
    table.add_row("end", "", *(d.end for d in shown))
    console.print(table)
    for line in [*_notes(found), *(f"wrote {files.label(path)}" for path in written)]:
        console.print(line, soft_wrap=True)


def _reached(d: Design, k: int) -> str:
    goal = d.goals[k]
    if goal.reached != goal.reached:
        return "none"
    return f"{goal.reached:.5g}" + ("" if goal.met else " (missed)")


def _unit(name: str) -> tuple[float, str]:
    """Return factor and unit in which a dimension is shown."""
    from squama.inverse.space import Variable
    from squama.study.parameters import PARAMETERS

    kind = PARAMETERS[Variable(name, 0, 1).key].dimension
    return {
        "length": (1e3, "mm"),
        "angle": (57.29577951308232, "deg"),
        "pressure": (1e-6, "MPa"),
        "torque": (1.0, "N m"),
    }.get(str(kind), (1.0, ""))


def _notes(found: InverseDesign) -> list[str]:
    """Return what is to be said below the table."""
    best = found[0]
    lines = [f"note: {note}" for note in found.notes]
    if not found.met:
        for goal in best.goals:
            if not goal.met:
                unit = f" {goal.unit}" if goal.unit else ""
                if goal.reached != goal.reached:
                    lines.append(f"not reached: {goal.name}: asked {goal.asked:.5g}{unit}, there is none; {_end(best)}")
                else:
                    off = f"{goal.difference:+.4g}{unit}"
                    lines.append(
                        f"not reached: {goal.name}: asked {goal.asked:.5g}{unit}, nearest {goal.reached:.5g} ({off})"
                    )
    for i, d in enumerate(found.designs[:8]):
        if d.active:
            lines.append(f"design {i + 1} lies on: {'; '.join(d.active)}")
    for goal in best.goals:
        by = sorted(goal.effects.items(), key=lambda item: -abs(item[1]))[:SHOWN]
        words = ", ".join(f"{name} ({_tolerance(found, name)}) {value:+.2g}" for name, value in by if value)
        if words:
            lines.append(f"tolerances, design 1, {goal.name} ({goal.unit or '1'}): {words}")
    lines += [f"warning, design 1: {line}" for line in best.warnings]
    return lines


def _tolerance(found: InverseDesign, name: str) -> str:
    factor, unit = _unit(name)
    return f"+- {factor * found.tolerance[name]:.3g} {unit}".strip()


def _end(d: Design) -> str:
    return f"the curve ends with {d.end}" + (f" ({d.other_contact})" if d.other_contact else "")
