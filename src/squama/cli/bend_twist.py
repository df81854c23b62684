"""squama bend-twist: bending and twisting at once, along a path, from a beam file."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli import flags, output
from squama.cli.flags import flag, one_of, settled
from squama.cli.output import Summary, energy, modelled, percent
from squama.errors import refuse
from squama.loads import ENDLESS, LOADS, THIN
from squama.model.outcome import SENTENCES, End
from squama.people import degrees, figure, tidy
from squama.units import moment, number, torque_unit

if TYPE_CHECKING:
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.curves.labelled import Answer

_PATH = 'Path: "bend 5 rad/m; twist 8 rad/m"; semicolons separate legs, commas changes on one leg.'
_FREE = "Load that is left free, twisting or bending; on hinges, without friction (--mu 0)."
_MAP = "Plot and write the plane around the path: contacts, locks, theta, M, T, each point straight from rest."
_KEYS = "load free law joint scales joint_source band neutral hold ends margin path squama_version"
_SMALL = 1e-6
"""Ratio of moment and torque below which the smaller is rounding."""
SHOWN = 24
"""Largest number of events in the table of the summary."""
_AT_ENDS = ("psi", "phi", "M", "T", "theta", "stress")
"""Figures at the end of each way."""


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
    ends: flags.Ends = None,
    plane: Annotated[bool, Parameter("--map", negative="", help=_MAP)] = False,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Bend and twist a beam along a path: moment, torque, contacts, end."""
    common.check(beam)
    described = settled(common.beam(beam, mu))

    from squama.curves.polygons import bend_twist_map, bent_and_twisted

    given: dict[str, Any] = {"path": path, "margin": margin, "points": points}
    with flags.laid(flags.arguments("path", "neutral", "free", "ends")):
        data = bent_and_twisted(described, **given, **vars(joints), free=free, ends=ends)
        found = {data.attrs["joint"]: data}
        beside_it = common.json or full or bool(common.plot)
        if beside_it and "ends" in data.attrs:
            found[ENDLESS] = bent_and_twisted(described, **given, **vars(joints), ends=ENDLESS)
        if beside_it and "compliant" in found:
            found["hinge"] = bent_and_twisted(described, **given, joint="hinge")
        if plane and free:
            refuse("--map", "", "has both loads imposed", "leave out --free")
    how: dict[str, Any] = {"neutral": joints.neutral}
    also: dict[str, Any] = {}
    if plane:
        also["paths"] = [data.dataset()] if common.plot else []
        how |= {"joint": data.attrs["joint"], "ideal": joints.ideal}
        written = output.write(common, lambda: bend_twist_map(described, path, **how), "plane_figure", **also)
    else:
        if common.plot and "hinge" in found and found["hinge"] is not data:
            also["hinge"] = found["hinge"].dataset()
        elif common.plot:
            also["plane"] = bend_twist_map(described, path, **how, joint="hinge", mu=0.0)
        written = output.write(common, data.dataset, "path_figure", **also)
    parts: dict[str, object] = {"figures": output.figures(data), "events": "event"}
    parts["ways"] = {name: {**ways(one), "end": one["end"]} for name, one in found.items()}
    # a beam with a number of scales has curves of each scale, too
    parts |= {"curve": data.curves, "each": data.each} if "ends" in data.attrs else {"curve": "point"}
    record = output.record(described, data, _KEYS, **parts)
    return output.report(common.json, beam, written, record, _summary(described, found).shown(full=full))


def ways(data: Answer) -> dict[str, list[float]]:
    """Return strains, loads, inclination and stress (the larger of both faces) at the ends of the ways; NaN beyond."""
    import numpy as np

    from squama.curves.both_faces import worst

    along = {name: data.along(name) for name in _AT_ENDS if name in data.variables}
    if "stress" in along:
        along["stress"] = worst(data.curves, "stress")
    # a path that ended early did not complete its last way
    complete = data["leg"].max() - (str(data["end"].item()) not in (End.RANGE, End.NONE))
    legs = range(1, len(data.attrs["path"]) + 1)
    lasts = [np.flatnonzero((data["leg"] == leg) & (leg <= complete))[-1:] for leg in legs]
    return {name: [float(v[last[0]]) if last.size else math.nan for last in lasts] for name, v in along.items()}


def _summary(beam: Beam, found: Mapping[str, Answer]) -> Summary:
    """Return the summary: whether the whole path is followed, where scales touch, figures at the ends of the ways."""
    data = next(iter(found.values()))
    attrs, end = data.attrs, End(data["end"].item())

    def of(ending: str) -> str:
        return _place(beam, *(float(data[f"{angle}_{ending}"]) for angle in ("psi", "phi")))

    other = f" ({data['other_contact'].item()})" if end is End.OTHER else ""
    whole = end in (End.RANGE, End.NONE)
    verdict = "the whole path is followed; nothing locks" if whole else f"{end} at {of('end')}"
    figures = [("scales touch", of("e"))]
    ends = ways(data)
    for i, values in enumerate(zip(*ends.values(), strict=True), 1):
        at = dict(zip(ends, values, strict=True))
        if math.isfinite(at["M"]):
            stress = f", stress in a scale {figure(1e-6 * at['stress'], 'MPa')}" if at.get("stress", 0) > 0 else ""
            size, newton = torque_unit(max(abs(at["M"]), abs(at["T"])))
            M, T = (figure(size * at[name], newton) for name in ("M", "T"))
            figures.append((f"end of way {i}", f"{_place(beam, at['psi'], at['phi'])}: moment {M}, torque {T}{stress}"))
    figures.append(("end of the path", "" if whole else f"{SENTENCES[end]}{other}"))
    lost = "" if end.locks else f"; it takes {percent(float(data['RED_c']))} of the work of the path"
    figures.append(("friction", f"mu = {float(data['mu']):g}{lost}"))
    freed = f"; {attrs['free']} is left free" if "free" in attrs else ""
    figures.append(("model", f"{modelled(beam, attrs)}{freed}"))
    return Summary(verdict, figures, (), attrs["warnings"], _all(beam, found))


def _place(beam: Beam, psi: float, phi: float) -> str:
    """Return bend and twist (rad per pitch) as text in degrees."""
    factor, unit = degrees(beam)
    bend, twist = (figure(tidy(factor * float(angle)), unit) for angle in (psi, phi))
    return f"bend {bend}, twist {twist}" if math.isfinite(psi + phi) else "never"


def _all(beam: Beam, found: Mapping[str, Answer]) -> Iterable[str | Table]:
    """Yield the events along the path, figures at the ends of the ways for each model, and the end."""
    from squama.cli.report import held

    data = next(iter(found.values()))
    yield from _events(beam, data)
    yield ""
    yield _ends(beam, found)
    if ENDLESS in found:
        yield from _ratios(beam, data, found[ENDLESS])
    yield ""
    for joint, one in found.items():
        end, other = one["end"].item(), one["other_contact"].item()
        place = _place(beam, float(one["psi_end"]), float(one["phi_end"]))
        whose = end if one is data else f"{joint}: {end} at {place}"
        yield f"{whose}: {SENTENCES[End(end)]}{f' ({other})' if other else ''}"
    if not End(data["end"].item()).locks:
        yield f"frictional work at the last point: {energy(float(data['W_fr_c']), beam)}"
    K = f"K_theta = {moment(float(data['K_theta']))}"
    if "energy_error" in data.variables:
        yield held(data.attrs)
        yield f"{K}; the work is balanced to {abs(float(data['energy_error'])):.1e}"
    else:
        yield f"joint of a scale: {K}"


def _events(beam: Beam, data: Answer) -> Iterable[str | Table]:
    """Yield the table of events along the path; equal consecutive events of several scales share a line."""
    from squama.model.screw import WORDS

    factor, unit = degrees(beam)
    jumps = [name for name in ("M_jump", "T_jump") if name in data.variables]
    same = [(str(word), int(leg)) for word, leg in zip(data["event"], data["event_leg"], strict=True)]
    scales = data["event_scale"].tolist() if "event_scale" in data.variables else []
    runs: list[list[int]] = []
    for i, one in enumerate(same):
        if not (scales and scales[i] and runs and same[runs[-1][0]] == one):
            runs.append([])
        runs[-1].append(i)
    rows = (
        (
            same[i][0],
            *([_ranges([scales[i] for i in run])] if scales else []),
            str(same[i][1]),
            *(number(tidy(factor * float(data[name][i]))) for name in ("psi_event", "phi_event")),
            number(math.degrees(data["theta_event"][i])),
            *(moment(float(data[jump][i])) if data[jump][i] else "" for jump in jumps),
        )
        for run in (runs if len(runs) <= SHOWN else [*runs[: SHOWN - 1], runs[-1]])
        for i in run[:1]
    )
    head = ("", *(["scales"] if scales else []), "way", f"bend, {unit}", f"twist, {unit}", "theta, deg")
    titles = (*head, *(jump.replace("_jump", " jumps by") for jump in jumps))
    yield output.table(titles, rows, left=2 if scales else 1, gap=1)
    if scales and len(runs) > SHOWN:
        yield f"the first {SHOWN - 1} of {len(runs)} events, and the last; of several scales the place of the first"
    elif scales:
        yield "an event of several scales has the place of the first"
    met = {name for word, _ in same for name in re.findall(r"\b[A-Z]{2}\b", word)}
    if known := [f"{name} {words}" for name, words in WORDS.items() if name in met]:
        yield f"contacts: {'; '.join(known)}"


def _ranges(scales: Iterable[int]) -> str:
    """Return numbers of scales as text: "1-4, 7"; empty for the whole beam."""
    parts: list[list[int]] = []
    for i in sorted({*scales} - {0}):
        if not (parts and i == parts[-1][-1] + 1):
            parts.append([])
        parts[-1].append(i)
    return ", ".join(str(p[0]) if len(p) == 1 else f"{p[0]}-{p[-1]}" for p in parts)


def _ratios(beam: Beam, data: Answer, endless: Answer) -> Iterable[str]:
    """Yield the ratio of the loads of N scales to those of the endless beam at the end of each way."""
    own, other = ways(data), ways(endless)
    for i in range(len(data.attrs["path"])):
        both = {name: (own[name][i], other[name][i]) for name in ("M", "T")}
        most = max(abs(b) for _, b in both.values())
        known = {name: (a, b) for name, (a, b) in both.items() if abs(b) > _SMALL * most and math.isfinite(a)}
        shares = [f"{name} {number(a / b)}" for name, (a, b) in known.items()]
        if most > 0 and shares:
            yield f"{beam.extent} over the endless beam at the end of way {i + 1}: {', '.join(shares)} times"


def _ends(beam: Beam, found: Mapping[str, Answer]) -> Table:
    """Return the table of figures at the ends of the ways, a column for each model."""
    from squama.cli.report import HINGE, IDEAL, THICK, column

    data, at_ends = next(iter(found.values())), [ways(one) for one in found.values()]
    whole, unit = degrees(beam)
    loads = [abs(v) for name in ("M", "T") for v in at_ends[0][name] if math.isfinite(v)]
    size, newton = torque_unit(max(loads, default=0.0))
    figures = {
        "psi": (f"bend, {unit}", whole),
        "phi": (f"twist, {unit}", whole),
        "M": (f"moment M, {newton}", size),
        "T": (f"torque T, {newton}", size),
        "theta": ("theta, deg", math.degrees(1)),
        "stress": ("largest stress in a scale, MPa", 1e-6),
    }
    rows = []
    for i in range(len(data.attrs["path"])):
        rows.append([f"end of way {i + 1}", *[""] * len(found)])
        for name, (words, factor) in figures.items():
            cells = [factor * one[name][i] if name in one else math.nan for one in at_ends]
            if not all(map(math.isnan, cells)):
                rows.append([f"  {words}", *map(number, cells)])
    own = THICK if data.attrs["scales"] != THIN else IDEAL
    named = {"compliant": beam.extent if "ends" in data.attrs else own, ENDLESS: ENDLESS, "hinge": HINGE}
    return output.table(["", *(column(named[joint]) for joint in found)], rows)
