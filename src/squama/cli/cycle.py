"""squama cycle: loading, unloading and reversal, from a beam file."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from squama.cli import flags, output
from squama.cli.flags import flag, settled, whole
from squama.cli.output import Shown, Summary, energy, energy_unit, modelled, touching
from squama.errors import refuse
from squama.loads import LOADS
from squama.people import degrees, figure, per_pitch, rigidity_unit, span, turned
from squama.units import is_number, moment, number, shown, torque_unit

if TYPE_CHECKING:
    from squama.beam.design import Beam
    from squama.curves.labelled import Answer

_HISTORY = 'Twists in turn, instead of --to: "0, 0.15, 0.05, 0.2, 0 rad/pitch"; negative the other way.'
_MANY = "Number of loops, or of times the history is repeated. Default: 1."
_KEYS = "load law joint scales hold margin increment K_theta rigidity history squama_version"
SHOWN = 12
"""Largest number of loops in the table of the summary."""


def cycle(
    beam: flags.BeamFile,
    /,
    *,
    to: Annotated[str | None, flag(f"Largest twist of the loop: {flags.TWISTS}.")] = None,
    history: Annotated[str | None, flag(_HISTORY)] = None,
    loops: Annotated[int, flag(_MANY, read=whole(1, 10_000, "3"))] = 1,
    how: flags.How = flags.HOW,
    ends: flags.Ends = None,
    mu: flags.Mu = None,
    margin: flags.Margin = 0.01,
    points: Annotated[int, flags.points(60)] = 60,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Load and unload a beam: loops, dissipation, damping, jamming."""
    if (to is None) == (history is None):
        what = "both are given" if to else "neither is given"
        flags.problems().add("--to, --history", "", what, 'give one of them, e.g. --to "0.2 rad/pitch"')
    common.check(beam)
    described = settled(common.beam(beam, mu))
    name, text = ("--history", history or "") if to is None else ("--to", to)

    from squama.curves.histories import cycled

    with flags.laid(flags.arguments("ends", twist=name)):
        data = cycled(described, _twists(name, text), margin=margin, points=points, loops=loops, ends=ends, **vars(how))
    written = output.write(common, data.dataset, "cycle_figure")
    parts: dict[str, object] = {"loops": "loop", "senses": "sense", "curve": "point", "each": "point scale"}
    parts |= {key: data[key] for key in ("energy_error",) if key in data.variables}
    record = output.record(described, data, _KEYS, **parts)
    return output.report(common.json, beam, written, record, _summary(described, data).shown(full=full))


def _twists(name: str, text: str) -> str:
    """Return the twists; refuse numbers without a unit (in Python rates in rad/m), and several twists in --to."""
    if name == "--to" and "," in text:
        refuse(name, shown(text), "is more than one twist", "give them to --history")
    if is_number(text.rpartition(",")[2]):
        refuse(name, shown(text), "has no unit", f'write "{text} rad/m", "{text} rad/pitch" or "{text} rad total"')
    return text


def _summary(beam: Beam, data: Answer) -> Summary:
    """Return the summary: damping and dissipation of the last loop, residual twist, engagement."""
    kind = LOADS[data.attrs["load"]]
    angle, torque = kind.angle, kind.torque
    bases, tops = data[f"{angle}_base"], data[f"{angle}_top"]
    verdict, figures = "no loop is closed: the history does not come back to where it turned", []
    if tops.size:
        loop, left = span(bases[-1], tops[-1], beam), float(data[f"{angle}_residual"][-1])
        verdict = f"damping ratio {figure(float(data['zeta_eq'][-1]))} in a loop from {loop}"
        factor, unit = energy_unit(float(data["U_max"][-1]), beam)
        taken, stored = (figure(factor * float(data[name][-1]), unit) for name in ("W_d", "U_max"))
        back = f"the beam stays at {turned(left, beam)}" if left else "the beam comes back"
        figures = [
            ("loops", f"{tops.size}; figures of the last" if tops.size > 1 else ""),
            ("friction takes", taken),
            ("stored at the top", stored),
            ("let go at the top", "" if math.isnan(left) else back),
        ]
    if not (data["N"] > 0).any():
        verdict = f"no contact up to {turned(float(abs(data[angle]).max()), beam)}: no friction, no damping"
    figures.append((f"largest {kind.torque_words}", moment(float(abs(data[torque]).max()))))
    for sense, engaged in zip(data["sense"], data[f"{angle}_e"], strict=True):
        figures.append((f"scales touch, sense {sense}", touching(float(engaged), beam)))
    figures += [("friction", f"mu = {float(data['mu']):g}"), ("model", modelled(beam, data.attrs))]
    return Summary(verdict, figures, (), data.attrs["warnings"], _loops(beam, data))


def _loops(beam: Beam, data: Answer) -> Shown:
    """Yield a table with a row per loop, and figures of the whole history."""
    kind = LOADS[data.attrs["load"]]
    angle, torque, tangent = kind.angle, kind.torque, kind.tangent
    bases, tops = data[f"{angle}_base"], data[f"{angle}_top"]
    if tops.size:
        factor, unit = degrees(beam)
        size, newton = torque_unit(float(abs(data[torque]).max()))
        rigid, newtons = rigidity_unit(float(data["K_sec"].max()))
        joule, joules = energy_unit(float(data["U_max"].max()), beam)
        columns = {
            f"taken, {joules}": joule * data["W_d"],
            f"stored, {joules}": joule * data["U_max"],
            "damping": data["zeta_eq"],
            f"secant, {newtons}": rigid * data["K_sec"],
            f"drop, {newton}": size * data[f"{torque}_drop"],
            f"left, {unit}": factor * data[f"{angle}_residual"],
        }
        loops = enumerate(zip(bases, tops, *columns.values(), strict=True), 1)
        rows = [(str(i), span(base, top, beam), *map(number, cells)) for i, (base, top, *cells) in loops]
        yield output.table(["loop", angle, *columns], rows[:SHOWN], gap=1)
        if tops.size > SHOWN:
            yield f"the first {SHOWN} of {tops.size} loops"
        energies = "taken: by friction; stored: elastic energy at the top; damping: taken/(4 pi stored)"
        left = f"{kind.verb} that stays when the beam is let go at the top"
        yield f"{energies}; drop of {torque} at the top; left: {left}"
    work = float(data["W_fr"][-1])
    rigid, newtons = rigidity_unit(float(data[tangent].max()))
    low, high = (number(rigid * float(v)) for v in (data[tangent].min(), data[tangent].max()))
    yield f"frictional work of the history: {energy(work, beam)}"
    yield f"tangent stiffness {low} to {high} {newtons}"
    if "energy_error" in data.variables:
        balance = f"the work of the {kind.torque_words} is balanced to {abs(float(data['energy_error'])):.1e}"
        yield f"walked in increments of up to {per_pitch(float(data.attrs['increment']))}: {balance}"
    words_of = _range if f"{angle}_most" in data.variables else _contact
    for i, sense in enumerate(data["sense"]):
        yield f"sense {sense}: {words_of(beam, data, i, angle)}"


def _contact(beam: Beam, data: Answer, i: int, angle: str) -> str:
    """Return the first contact in one sense, and the contact that follows."""
    first, other = data["first_contact"][i], data["other_contact"][i]
    words = f"first contact at {turned(float(data[f'{angle}_e'][i]), beam)}: {first}" if first else "no contact"
    return f"{words}; then {other}" if other else words


def _range(beam: Beam, data: Answer, i: int, angle: str) -> str:
    """Return how far a history may go in one sense, and from which twist the beam returns."""
    engaged, jam, end, most = (float(data[f"{angle}_{name}"][i]) for name in ("e", "jam", "end", "most"))
    other = f" ({data['other_contact'][i]})" if data["other_contact"][i] else ""
    upto = f"a history may go to {turned(most, beam)}"
    if not math.isfinite(engaged):
        return f"{data['end'][i]}{other}; {upto}"
    jams = f"let go beyond {turned(jam, beam)} it stays twisted"
    back = jams if math.isfinite(jam) else "let go from anywhere there it comes back"
    ends = f"{data['end'][i]} at {turned(end, beam)}"
    return f"engagement at {turned(engaged, beam)}, {ends}{other}; {upto}; {back}"
