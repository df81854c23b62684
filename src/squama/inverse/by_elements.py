"""Finite elements of a design: its own scales, or a pitch of an endless beam held straight, beside the model.

All scales are under a couple, or between grips where the design has them. Elements of a coarse mesh are too stiff, and
their bar has plain ends, by which a row under a couple bows farther. So the model is also followed with the joint
stiffness of the same mesh and with these ends. The goals are told by elements times the model's figure of the design
over that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.contacts.system import PHI
from squama.curves import doors
from squama.errors import refuse
from squama.fe import runs
from squama.fe.geometry import geometry
from squama.fe.loaded import BLANK
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import response
from squama.fe.sizes import MeshName
from squama.inverse import joint_figures
from squama.inverse.beside import Beside
from squama.inverse.goals import Goal, Pitches, reached
from squama.inverse.target import Target
from squama.joints import choice, law
from squama.loads import COUPLE, ENDLESS, GRIPPED, LOADS, STRAIGHT, Load, SenseName, ending, holds
from squama.people import per_pitch
from squama.study import parts
from squama.types import Array
from squama.units import change, moment

if TYPE_CHECKING:
    import xarray as xr

MESH: MeshName = "coarse"
INCREMENTS = 24
"""Mesh of the elements, and the number of increments of their deformation."""
FIGURES = ("torque", "tangent", "stiffness_ratio", "W_fr", "RED")
"""Figures at a twist that elements give."""
ACCEPT = 0.1
"""Largest relative difference from a goal at which elements of a coarse mesh count as reaching it."""
_BEYOND = 1.1
"""Deformation of a run over that of the model at the goal, because elements may take more torque."""


def check(target: Target) -> None:
    """Refuse targets of which elements give no goal."""
    source, load = target.source, LOADS[target.space.load]
    if not (target.compliant and _goals(target)):
        refuse("elements", "", "check compliant joints at points of the target only", "leave it out", source)
    if not load.sided and not _finite(target, target.space.beam):
        refuse("elements", "", "of an endless beam are for twisting", "give the target a number of scales", source)
    if target.options.sense == "-" and _finite(target, target.space.beam):
        refuse("elements", "", "of all scales are twisted in sense +", 'leave it out, or write sense = "+"', source)
    only_one(target.space.beam.faces, "elements of a design")


def of_design(target: Target, beam: Beam) -> tuple[tuple[Beside, ...], list[str]]:
    """Compute a design by elements: its goals, and lines that tell each figure beside the model's."""
    if not _finite(target, beam):
        rates = sorted({goal.want.at.per_length(beam) for goal in _goals(target) if goal.want.at is not None})
        return (), _of_pitch(beam, target.options.sense, rates)
    goals, load = _goals(target), LOADS[target.space.load]
    if beam.pitches > parts.MOST:
        return (), [f"elements: not computed, {beam.pitches} scales are more than the {parts.MOST} they may have"]
    wants = [goal.want for goal in goals]
    K = response(pitch_mesh(geometry(beam), *runs.mesh_sizes(MESH)), geometry(beam)).K
    meshed, ends = beam.replace(joint=parts.joint_of(beam, K)), _ends(beam, load)
    own = np.array(joint_figures.followed(beam, wants, target.options, ends=ends)[0])
    found, same, ended = _of_part(meshed, load, goals)
    best = found * own / same
    pitches = Pitches(beam.pitch, beam.pitches)
    words = f"by elements of {beam.pitches} scales"
    told = Beside("elements", words, tuple(reached(goals, best, pitches, ACCEPT)), ended * bool(np.isnan(best).any()))
    lines = []
    for goal, *values in zip(goals, found, same, own, strict=True):
        at, by, mine = (goal.shown(float(v), *pitches) for v in values)
        where = f"{goal.name}: elements ({MESH} mesh, {beam.pitches} scales {ending(ends)}) {at:.3g}"
        if math.isnan(at):
            lines.append(f"{goal.name}: elements end before, {ended}")
            continue
        with_mesh = f"model with the joint of that mesh and these ends {by:.3g} ({change(at / by - 1, '+')})"
        lines.append(f"{where}, {with_mesh}, with its own joint {mine:.3g} {goal.unit}".rstrip())
    return (told,), lines


def _finite(target: Target, beam: Beam) -> bool:
    """Say whether elements of all scales answer: the beam has a number of scales and no guide."""
    return bool(target.own) and not holds(beam.holding, LOADS[target.space.load])


def _ends(beam: Beam, load: Load) -> str:
    """Return the ends of a beam's elements: grips of a twisted beam that has them, else a couple."""
    return GRIPPED if beam.ends == GRIPPED and load.axis == PHI else COUPLE


def _goals(target: Target) -> list[Goal]:
    """Return the goals of a target that elements can give, without measured curves."""
    return [g for g in target.goals if g.want.at is not None and g.want.figure in FIGURES and not g.group]


def _of_part(beam: Beam, load: Load, goals: Sequence[Goal]) -> tuple[Array, Array, str]:
    """Return the figures (goals,) of N scales by elements and by the model of the same part, and how elements ended.

    NaN beyond the end of the run.

    The bar of elements has a pitch without exposed scale at either end, and plain bar beyond. Their compliance, which
    is what the whole bar has before contact beyond that of N pitches of an endless beam of the same mesh (the joint of
    ``beam``), is taken away, with the energy in it.
    """
    n, d = beam.pitches, beam.pitch
    at = [goal.want.at.per_length(beam) for goal in goals if goal.want.at is not None]
    most = max(at)
    ends = _ends(beam, load)
    answer = doors.respond(beam, load.name, at=[most], ends=ends, joint="compliant")
    cell = float(answer.attrs["rigidity"]) / d
    bar = float(law.bare(choice.shape(beam))[0 if load.axis == PHI else 1]) * beam.substrate.youngs_modulus * d**3
    compliance = 2 * BLANK / cell + geometry(beam).square.pitches / bar
    beyond = compliance * float(answer.along(load.torque)[0])
    turn = _BEYOND * (most * n * d + beyond)
    word = "twist" if load.axis == PHI else "bend"
    led = parts.led(f"{turn} rad {word}", GRIPPED if ends == GRIPPED else None, beam, n)
    run = parts.Run(n, led, beam.friction.mu or 0.0, MESH, abs(led.way) / INCREMENTS, ideal=False)
    data, model = parts.elements(beam, run), parts.model(beam, run)
    bar, long = cell / n, n * d
    found = _reduced(data, data["W"].values, data["W_fr"].values, bar, long, goals, at)
    stored, rubbed = ((model[name].values * model.sizes["scale"] * d) for name in ("U_el", "W_fr"))
    same = _reduced(model, stored + rubbed, rubbed, bar, long, goals, at)
    return found, same, str(data.attrs["sentence"])


def _reduced(
    data: xr.Dataset,
    work: Array,
    friction: Array,
    bar: float,
    long: float,
    goals: Sequence[Goal],
    at: list[float],
) -> Array:
    """Return the figures (goals,) at deformations per length (rad/m), without the compliance of what is beside the row.

    ``bar``: stiffness (N m/rad) of the row's length (m), ``long``, of endless beam before contact.
    """
    x, T = (np.abs(data[name].values) for name in ("turn", "moment"))
    # nothing touches in the first increment
    blank = x[1] / T[1] - 1 / bar
    rate = (x - blank * T) / long
    work = work - blank * T**2 / 2
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(work > 0, friction / work, 0.0)
    tangent = np.gradient(T, rate)
    columns = {
        "torque": T,
        "tangent": tangent,
        "stiffness_ratio": tangent / (bar * long),
        "W_fr": friction / long,
        "RED": share,
    }
    values = [
        float(np.interp(phi, rate, columns[goal.want.figure], right=math.nan))
        for goal, phi in zip(goals, at, strict=True)
    ]
    return np.array(values)


def _of_pitch(beam: Beam, sense: str, rates: Sequence[float]) -> list[str]:
    """Return lines that compare finite elements of a pitch, held straight, with the model at twist rates (rad/m)."""
    way: SenseName = "-" if sense == "-" else "+"
    run = runs.cell(beam, to=max(rates), sense=way, mesh=MESH, increment=max(rates) * beam.pitch / INCREMENTS)
    x, T = run["Phi"].values, run["T"].values
    how = doors.How(joint="compliant", hold=STRAIGHT)
    own = doors.respond(beam, "twisting", at=x.tolist(), sense=sense, ends=ENDLESS, **how)["T"]
    # slopes of both between the same twists
    ratios = [np.gradient(torque, x) / (torque[1] / x[1]) for torque in (T, own)]
    lines = []
    for rate in rates:
        where = f"elements ({MESH} mesh), held straight, {per_pitch(rate * beam.pitch)}"
        if rate > x[-1] * (1 + 1e-9):
            lines.append(f"{where}: the run ends before, {run.attrs['sentence']}")
            continue
        torque, own_torque, stiffer, as_stiff = (float(np.interp(rate, x, v)) for v in (T, own, *ratios))
        beside = f"stiffness ratio {stiffer:.3g} (model: {as_stiff:.3g})"
        lines.append(f"{where}: torque {moment(torque)} ({change(torque / own_torque - 1, '+')}), {beside}")
    return lines
