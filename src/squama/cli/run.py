"""What twist and bend do: read and check everything, compute, write the files, report."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from squama.cli.options import (
    Options,
    Problems,
    check_outputs,
    read_mu,
    read_number,
    read_overrides,
    read_points,
)
from squama.errors import InputError

if TYPE_CHECKING:
    from squama.answer import Answer
    from squama.design import Beam
    from squama.measured import Measured


def respond(
    load: str, path: str, options: Options, *, law: str = "edge", sense: str = "+", joint: str = "hinge"
) -> int:
    """Run ``squama twist`` (load "twisting") or ``squama bend`` ("bending"); return the exit status."""
    from squama import checks, files

    problems = Problems()
    mu: float | list[float] | None = None
    numbers: dict[str, Any] = {}
    overrides: dict[str, dict[str, Any]] = {}
    with problems.caught():
        mu = read_mu(options.mu)
    with problems.caught():
        numbers["margin"] = read_number("--margin", options.margin, 1e-12, 1 - 1e-12, "at least 1e-12, below 1", "0.01")
    with problems.caught():
        numbers["points"] = read_points(options.points)
    with problems.caught():
        overrides = read_overrides(options.set_)
    for check, value in ((checks.law, law), (checks.sense, sense), (checks.joint, joint)):
        with problems.caught():
            _checked(check, value)
    problems.lines += check_outputs(options, [path, *([options.data] if options.data else [])])
    if isinstance(mu, float):
        # the one value belongs to the beam, so that files and reports name it there
        overrides.setdefault("friction", {})["mu"] = mu
    beam = None
    with problems.caught():
        beam = read_beam(path, overrides)
    measured: Measured | None = None
    if beam is not None:
        with problems.caught():
            if options.to is not None:
                numbers["to"] = _limit(load, options.to, beam)
        with problems.caught():
            measured = _measured(load, options.data, beam)
        if mu is None and beam.friction.mu is None:
            problems.lines.append(
                f"{files.label(path)}: friction.mu: is missing; write mu = 0.25 under [friction] or give --mu 0.25"
            )
    problems.settle()
    assert beam is not None
    if options.data and not options.plot:
        print("squama: warning: --data has no effect without --plot; add e.g. --plot picture.png", file=sys.stderr)
    if isinstance(mu, list):
        numbers["mu"] = mu
    if joint == "compliant":
        from squama.cli import joints

        laws, law = joints.compute(beam, law, sense, numbers), joint
    else:
        laws = _compute(load, beam, law, sense, numbers)
    written = _write(laws[law], measured, options)
    _report(load, path, beam, law, laws, options, written)
    return 0


def _checked(check: Callable[[str], object], value: str) -> None:
    """Check an argument of :func:`squama.twist` that has a flag of the same name."""
    try:
        check(value)
    except InputError as error:
        message = f"--{error}"
        raise InputError(message) from None


def read_beam(path: str, overrides: dict[str, dict[str, Any]]) -> Beam:
    """Read the beam; a mistake in a value of --set is laid to that flag."""
    from squama.design import Beam
    from squama.files import label

    try:
        return Beam.from_toml(path, overrides=overrides)
    except InputError as error:
        lines = str(error).splitlines()
        for i, line in enumerate(lines):
            for table, content in overrides.items():
                for key in content:
                    start = f"{label(path)}: {table}.{key} = "
                    if line.startswith(start):
                        lines[i] = f"--set {table}.{key} = {line.removeprefix(start)}"
        raise InputError("\n".join(lines)) from None


def _limit(load: str, text: str, beam: Beam) -> float:
    """Return the twist rate or curvature at which to stop, rad/m."""
    from squama import units

    read = units.twist if load == "twisting" else units.curvature
    try:
        rate = read(text, pitch=beam.pitch, scales=beam.scales, bare=False)
    except units.QuantityError as error:
        message = f"--to = {error.shown}: {error.reason}"
        raise InputError(message) from None
    if rate <= 0:
        other = "; for the other way round write --sense -" if load == "twisting" else ""
        message = f'--to = {units.shown(text)}: must be more than 0{other}; write e.g. "0.2 rad/pitch"'
        raise InputError(message)
    return rate


def _measured(load: str, path: str | None, beam: Beam) -> Measured | None:
    if path is None:
        return None
    from squama import measured

    return measured.read(path, pitch=beam.pitch, scales=beam.scales, load=load)


def _compute(load: str, beam: Beam, law: str, sense: str, numbers: dict[str, Any]) -> dict[str, Answer]:
    """Return the responses by law; the law that was not chosen is there for its single figures only."""
    from squama import response
    from squama.model.laws import LAWS

    if load == "bending":
        return {law: response.bent(beam, **numbers)}
    return {
        name: response.twisted(beam, law=name, sense=sense, **(numbers if name == law else {**numbers, "points": 3}))
        for name in sorted(LAWS)
    }


def _write(answer: Answer, measured: Measured | None, options: Options) -> list[Path]:
    written: list[Path] = []
    if not (options.plot or options.csv or options.netcdf):
        return written
    dataset = answer.dataset()
    if options.plot:
        from squama import plot

        figure = plot.response_figure(dataset, measured)
        written += [plot.save_figure(figure, path) for path in options.plot]
    for path_or_none in (options.csv, options.netcdf):
        if path_or_none is not None:
            from squama import store

            written.append(store.save(dataset, path_or_none))
    return written


def _report(
    load: str,
    path: str,
    beam: Beam,
    law: str,
    laws: dict[str, Answer],
    options: Options,
    written: list[Path],
) -> None:
    from squama.files import label

    if options.json:
        from squama.cli import record

        record.show(record.response(label(path), beam, law, laws, [str(place) for place in written]))
        return
    from squama.cli import summary

    summary.show(load, label(path), beam, law, laws, [label(place) for place in written])
