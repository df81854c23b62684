"""squama bend-twist: bending and twisting at once, along a path, from a beam file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli import flags, output
from squama.cli.flags import flag, one_of, settled
from squama.errors import refuse
from squama.loads import LOADS, THIN, fixed
from squama.model.outcome import SENTENCES, End
from squama.units import moment, number

if TYPE_CHECKING:
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.curves.labelled import Answer

_PATH = 'Where to go, way by way: "bend 5 rad/m; twist 8 rad/m"; a comma joins what changes at once; below 0 is back.'
_FREE = "Load that is left free on hinges, twisting or bending, while the other is imposed; without friction (--mu 0)."
_MAP = "Pictures and tables are of the plane around the path: contacts, locks, theta, M and T, each straight from rest."
_KEYS = "load free law joint scales joint_source band neutral hold margin path squama_version"
_AT_ENDS = {
    "psi": ("bend psi, rad/pitch", 1.0),
    "phi": ("twist phi, rad/pitch", 1.0),
    "M": ("moment M, N m", 1.0),
    "T": ("torque T, N m", 1.0),
    "theta": ("theta, deg", math.degrees(1)),
    "stress": ("largest stress in a scale, MPa", 1e-6),
}


def bend_twist(
    beam: flags.BeamFile,
    /,
    *,
    path: Annotated[str, flag(_PATH)],
    mu: flags.Mu = None,
    margin: flags.Margin = 0.01,
    points: Annotated[int, flags.points(200)] = 200,
    joints: flags.Joints = flags.JOINTS,
    free: Annotated[str | None, flag(_FREE, read=one_of(*LOADS))] = None,
    plane: Annotated[bool, Parameter("--map", negative="", help=_MAP)] = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Bend and twist a beam as it is made along a path, beside hinges: contacts, moment and torque, ends."""
    common.check(beam)
    described = settled(common.beam(beam, mu))

    from squama.curves.polygons import bend_twist_map, bent_and_twisted

    given: dict[str, Any] = {"path": path, "margin": margin, "points": points}
    with flags.laid(flags.arguments("path", "neutral", "free")):
        data = bent_and_twisted(described, **given, **vars(joints), free=free)
        found = {data.attrs["joint"]: data}
        if "compliant" in found:
            found["hinge"] = bent_and_twisted(described, **given, joint="hinge")
        if plane and free:
            refuse("--map", "", "has both loads imposed", "leave out --free")
    if plane:
        shown_in = [data.dataset()] if common.plot else []
        how = {"joint": data.attrs["joint"], "neutral": joints.neutral, "ideal": joints.ideal}
        written = output.write(common, lambda: bend_twist_map(described, path, **how), "plane_figure", paths=shown_in)
    else:
        beside: dict[str, Any] = {}
        if common.plot and len(found) > 1:
            beside["hinge"] = found["hinge"].dataset()
        elif common.plot:
            beside["plane"] = bend_twist_map(described, path, neutral=joints.neutral, joint="hinge", mu=0.0)
        written = output.write(common, data.dataset, "path_figure", lambda d: d.drop_dims("event"), **beside)
    figures, at_ends = output.figures(data), {name: {**ways(one), "end": one["end"]} for name, one in found.items()}
    record = output.record(described, data, _KEYS, figures=figures, events="event", ways=at_ends, curve="point")
    return output.report(common.json, beam, written, record, _shown(described, found))


def ways(data: Answer) -> dict[str, list[float]]:
    """Return strains, loads, inclination and stress at the end of each way, NaN where the path ended before.

    With scales on both faces the stress is the larger of the two.
    """
    import numpy as np

    from squama.curves.both_faces import worst

    along = {name: data[name] for name in _AT_ENDS if name in data.variables}
    if "stress" in along:
        along["stress"] = worst(data.curves, "stress")
    # where the path ended before, its last way was not gone to the end
    complete = data["leg"].max() - (str(data["end"].item()) not in (End.RANGE, End.NONE))
    legs = range(1, len(data.attrs["path"]) + 1)
    lasts = [np.flatnonzero((data["leg"] == leg) & (leg <= complete))[-1:] for leg in legs]
    return {name: [float(v[last[0]]) if last.size else math.nan for last in lasts] for name, v in along.items()}


def _shown(beam: Beam, found: Mapping[str, Answer]) -> Iterable[str | Table]:
    """Return the summary: what happens on the way, the ends of ways on the joint and on hinges, how it ends."""
    from squama.cli.report import covered, held

    data = next(iter(found.values()))
    attrs = data.attrs
    freed = f"; {attrs['free']} is left free" if "free" in attrs else ""
    yield (
        f" bent and twisted as an endless beam: {covered(beam)}, mu = {float(data['mu']):g}, "
        f"{LOADS['twisting'].model(joint=attrs['joint'], scales=attrs['scales'])}; {fixed(attrs)}{freed}"
    )
    yield ""
    yield _events(data)
    yield ""
    yield _ends(found)
    yield ""
    for joint, one in found.items():
        end, other = one["end"].item(), one["other_contact"].item()
        place = ", ".join(number(float(one[name])) for name in ("psi_end", "phi_end"))
        whose = end if one is data else f"{joint}: {end} at psi, phi = {place}"
        yield f"{whose}: {SENTENCES[End(end)]}{f' ({other})' if other else ''}"
    if not End(data["end"].item()).locks:
        work, red = number(float(data["W_fr_c"]), "J/m"), float(data["RED_c"])
        yield f"at the last point: frictional work {work}, RED = {red:.4g}"
    K = f"K_theta = {moment(float(data['K_theta']))}"
    if "energy_error" in data.variables:
        yield held(attrs)
        yield f"{K}; the work is balanced to {abs(float(data['energy_error'])):.1e}"
    else:
        yield f"joint of a scale: {K}"
    yield from output.warnings(attrs["warnings"])


def _events(data: Answer) -> Table:
    """Return the table of what happens on the way."""
    pairs = [[data[f"{name}_event"] for name in names] for names in (("psi", "phi"), ("kappa", "Phi"))]
    jumps = [name for name in ("M_jump", "T_jump") if name in data.variables]
    rows = (
        (
            str(data["event"][i]),
            str(data["event_leg"][i]),
            *(", ".join(number(float(v[i])) for v in pair) for pair in pairs),
            number(math.degrees(data["theta_event"][i])),
            *(moment(float(data[jump][i])) if data[jump][i] else "" for jump in jumps),
        )
        for i in range(data["event"].size)
    )
    head = ("", "way", "psi, phi rad/pitch", "kappa, Phi rad/m", "theta deg")
    return output.table((*head, *(jump.replace("_jump", " jumps by") for jump in jumps)), rows, left=1, gap=1)


def _ends(found: Mapping[str, Answer]) -> Table:
    """Return the table of the ends of ways, a column for each kind of joint."""
    from squama.cli.report import HINGE, IDEAL, REAL

    data, at_ends = next(iter(found.values())), [ways(one) for one in found.values()]
    rows = []
    for i in range(len(data.attrs["path"])):
        rows.append([f"end of way {i + 1}", *[""] * len(found)])
        for name, (words, factor) in _AT_ENDS.items():
            cells = [factor * one[name][i] if name in one else math.nan for one in at_ends]
            if not all(map(math.isnan, cells)):
                rows.append([f"  {words}", *map(number, cells)])
    named = {"compliant": REAL if data.attrs["scales"] != THIN else IDEAL, "hinge": HINGE}
    return output.table(["", *(named[joint] for joint in found)], rows)
