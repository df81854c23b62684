"""squama twist, bend and row: torque-twist or moment-curvature curves from a beam file."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli import flags, output
from squama.cli.fit import TABLES, Tables
from squama.cli.flags import flag, settled
from squama.cli.output import Shown, Summary, largest_stress, modelled, percent, touching
from squama.errors import refuse
from squama.loads import ENDLESS, LOADS, fixed
from squama.model.outcome import SENTENCES, End
from squama.people import figure, tidy, turned
from squama.units import moment, number, shown, torque_unit

if TYPE_CHECKING:
    from squama.beam.design import Beam
    from squama.curves.doors import How
    from squama.curves.labelled import Answer


_DATA = 'CSV file of measured points to draw too; header "Phi (deg/mm), T (N mm)", bent "kappa (1/m), M (N mm)".'
_COMPARE = "Compare with simpler models: the endless beam, thin rigid scales, hinges."
_SCALES = "Number of scales of the row. Default: the file's; allowed:"
_END = f"End of the curve: {flags.TWISTS}. Default: 0.3 rad in a pitch; hinges: a lock."
_TO = f"Twist at the end: {flags.TWISTS}. Default: where a pitch twists by 0.3 rad; on hinges the end of the curve."


@flags.group
class Curve:
    """Flags of twist and bend."""

    mu: flags.Family = ()
    margin: flags.Margin = 0.01
    points: Annotated[int, flags.points(200)] = 200
    to: Annotated[str | None, flag(_END)] = None
    ends: flags.Ends = None
    data: Annotated[flags.File | None, flag(_DATA)] = None
    compare: Annotated[bool, Parameter(help=_COMPARE)] = False
    full: flags.Full = False


CURVE = Curve()


def twist(
    beam: flags.BeamFile,
    /,
    *,
    curve: Curve = CURVE,
    law: flags.Law = "edge",
    sense: flags.Sense = "+",
    joints: flags.Joints = flags.JOINTS,
    tables: Tables = TABLES,
    common: flags.Common = flags.COMMON,
) -> int:
    """Twist a beam: free range, torque, stiffness, stress, friction."""
    return respond("twisting", beam, curve, joints, tables, common, law, sense)


def bend(
    beam: flags.BeamFile,
    /,
    *,
    curve: Curve = CURVE,
    joints: flags.Joints = flags.JOINTS,
    tables: Tables = TABLES,
    common: flags.Common = flags.COMMON,
) -> int:
    """Bend a beam: free range, moment, stiffness, stress, friction."""
    return respond("bending", beam, curve, joints, tables, common)


def respond(
    load: str,
    path: str,
    curve: Curve,
    joints: flags.Joints,
    tables: Tables,
    common: flags.Common,
    law: str = "edge",
    sense: str = "+",
) -> int:
    """Run twist or bend, and return the exit status."""
    mu, data = curve.mu, curve.data
    common.check(path, *([data] if data else []))
    # a single friction coefficient becomes the beam's, so that files and reports have it
    beam = common.beam(path, mu[0] if len(mu) == 1 else None, friction=not mu)
    stop = flags.asked("--to", curve.to, beam, load)
    measured = None
    if beam is not None and data is not None:
        with flags.problems().caught():
            (measured,) = tables.read([data], beam, load)
    for name, text in vars(tables).items():
        if data is None and text is not None:
            remedy = "give --data too, e.g. --data test.csv, or leave it out"
            flags.problems().add(f"--{name}", shown(text), "says how --data is read", remedy)
    beam = settled(beam)
    if data and not common.plot:
        print("squama: warning: --data has no effect without --plot; add e.g. --plot picture.png", file=sys.stderr)
    from squama.cli import report
    from squama.curves.chosen import chosen

    how: dict[str, Any] = {"law": law, "sense": sense, "margin": curve.margin, "points": curve.points, "to": stop}
    how |= {"mu": list(mu) if len(mu) > 1 else None, "neutral": joints.neutral}
    with flags.laid(flags.arguments("neutral", "ends")):
        means = chosen(beam, LOADS[load], law=law, joint=joints.joint, neutral=joints.neutral)
        if means.note:
            print(f"squama: warning: {means.note}", file=sys.stderr)
        if not means.compliant and curve.ends not in (None, ENDLESS):
            why = "is not available on hinges, which are endless here"
            refuse("ends", shown(curve.ends), why, "write squama row")
        if means.compliant:
            beside = common.json or curve.compare or curve.full or bool(common.plot)
            how |= {"ideal": bool(joints.ideal), "ends": curve.ends}
            laws = report.ladder(load, beam, how, simpler=beside)
            law = next(iter(laws))
        else:
            laws = report.responses(load, beam, how)
    hinge = laws[report.HINGE].dataset() if common.plot and report.HINGE in laws else None
    written = output.write(common, laws[law].dataset, "response_figure", measured=measured, hinge=hinge)
    answer = beam, law, laws, report.beside(beam, laws, asked=stop is not None)
    said = report.summary(*answer, asked=stop is not None, compare=curve.compare, full=curve.full)
    return output.report(common.json, path, written, report.record(*answer), said)


def row(
    beam: flags.BeamFile,
    /,
    *,
    scales: Annotated[int | None, flags.scales(2000, _SCALES)] = None,
    mu: flags.Mu = None,
    to: Annotated[str | None, flag(_TO)] = None,
    sense: flags.Sense = "+",
    joint: flags.Joint = None,
    ideal: flags.Ideal = False,
    ends: flags.Ends = None,
    points: Annotated[int, flags.points(100)] = 100,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Twist a row of N scales, whose end scales lack a neighbour: inclination and force of every scale."""
    common.check(beam)
    found = common.beam(beam, mu, scales=scales)
    stop = flags.asked("--to", to, found)
    described = settled(found)

    from squama.curves import finite_rows

    how: How = {"joint": joint, "ideal": ideal or None}
    with flags.laid(flags.arguments()):
        answer = finite_rows.rowed(described, scales=scales, to=stop, sense=sense, points=points, ends=ends, **how)
    written = output.write(common, answer.dataset, "row_figure")
    keys = "load law joint scales sense ends squama_version"
    parts = {"figures": output.figures(answer), "curve": "point", "each": "point scale"}
    record = output.record(described, answer, keys, **parts)
    return output.report(common.json, beam, written, record, _summary(described, answer).shown(full=full))


_ROW_ENDS = {
    "free": "free ends: the same torque in all cells, and each has its own twist and bow",
    "couple": "a couple at both ends, which may shift and tilt, and each cell has its own twist and bow",
    "gripped": "gripped ends: the grips stay on one axis, and each cell has its own twist and bow",
    "equal": "equal cells: all have the same twist and bow",
}


def _summary(beam: Beam, data: Answer) -> Summary:
    """Return the summary: the row at its last point, compared with the endless beam."""
    n, last, end = data["scale"].size, data.at(-1), End(str(data["end"].item()))
    beam = beam.replace(scales=n)
    torque, endless = float(last["T"]), float(last["T_periodic"])
    place = turned(float(last["phi"]), beam)
    verdict = f"{n} scales take {moment(torque)} at {place}"
    if math.isfinite(endless):
        verdict += f", {percent(torque / endless)} of an endless beam's torque"
    theta = [number(tidy(math.degrees(float(last["theta"][i])))) for i in (0, n // 2, -1)]
    decay = figure(float(data["decay"]))
    stress = largest_stress(last["stress"], beam) if "stress" in last else ""
    other, which = str(data["other_contact"].item()), int(data["scale_end"])
    why = f"{SENTENCES[end]}{f' (scale {which}: {other})' if which and other and end is not End.RANGE else ''}"
    figures = [
        ("scales touch", touching(float(data["phi_e"]), beam)),
        ("inclination, first to last", f"{theta[0]} deg, in the middle {theta[1]} deg, {theta[2]} deg"),
        ("end effect", f"falls to {decay} from a scale to the next, at engagement" if decay else ""),
        ("largest stress in a scale", stress),
        ("end of the curve", f"{place}: {why}"),
        ("friction", f"mu = {float(data['mu']):g}; it takes {percent(float(last['RED']))} of the work"),
        ("model", modelled(beam, data.attrs)),
    ]
    return Summary(verdict, figures, (), data.attrs["warnings"], _all(data))


def _all(data: Answer) -> Shown:
    """Yield figures of the row at its last point, and a table of its scales."""
    import numpy as np

    from squama.cli.report import held

    n, last = data["scale"].size, data.at(-1)
    down, endless = np.flatnonzero(last["Q"] > 0) + 1, float(last["T_periodic"])
    size, newton = torque_unit(max(abs(float(last["T"])), abs(endless) if math.isfinite(endless) else 0.0))
    yield f"{held(data.attrs)}; {fixed(data.attrs)}"
    yield _ROW_ENDS[data.attrs["ends"]]
    if math.isfinite(endless):
        theta = number(math.degrees(float(last["theta_periodic"])), "deg")
        yield f"endless beam there: torque {number(size * endless, newton)}, inclination {theta}"
    else:
        yield "the endless beam's curve ends before"
    if "M_cell" in last:
        bending = float(np.abs(last["M_cell"]).max())
        yield f"largest bending moment in a pitch: {number(size * bending, newton)}"
    if down.size:
        yield f"scales that lie on the substrate: {', '.join(map(str, down))}"
    columns = {
        "theta, deg": ("theta", math.degrees(1)),
        "twist of its pitch, deg": ("phi_cell", math.degrees(1)),
        "N, N": ("N", 1.0),
        "f, N": ("f", 1.0),
        "stress, MPa": ("stress", 1e-6),
    }
    known = {head: last[name] * factor + 0.0 for head, (name, factor) in columns.items() if name in last}
    rows = ([str(i + 1), *(number(float(v[i])) for v in known.values())] for i in range(n))
    yield output.table(("scale", *known), rows)
