"""Reports of twist and bend: a summary for people, simpler models on request, a record for JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import loads
from squama.cli import output
from squama.cli.output import Shown, Summary, modelled, percent, rigidity, table
from squama.cli.verdict import Curve, free_until
from squama.curves import bench
from squama.curves.both_faces import worst
from squama.fe.agreement import SHARE, holds
from squama.loads import ENDLESS, LOADS, THIN, Load
from squama.model.laws import LAWS
from squama.model.outcome import SENTENCES, End
from squama.people import apart_by, degrees, figure, per_pitch, rigidity_unit, turned
from squama.symbols import OTHER
from squama.units import moment, number, torque_unit

if TYPE_CHECKING:
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.curves.bench import Bench
    from squama.curves.labelled import Answer
    from squama.types import Array

THICK, IDEAL, HINGE = "thick scales", "thin, rigid", "hinge"
"""Names of the models, from the beam as made to the paper's model."""
_KEEPS = "  torque T that keeps it from twisting"


def beside(beam: Beam, laws: Mapping[str, Answer], *, asked: bool) -> Bench | None:
    """Return simpler beams at the load of the figures, to compare compliant joints with; None for hinges, families."""
    data = next(iter(laws.values()))
    if data.family is not None or data.attrs.get("joint") != "compliant":
        return None
    at = Curve(LOADS[data.attrs["load"]], beam, data, asked).at
    return bench.bench(beam, data, ideal=data.attrs["scales"] == THIN, at=at)


def summary(
    beam: Beam, law: str, laws: Mapping[str, Answer], found: Bench | None, *, asked: bool, compare: bool, full: bool
) -> Shown:
    """Return the summary of ``laws[law]``; ``compare`` adds simpler models (``found``), ``full`` all figures."""
    data = laws[law]
    words = LOADS[data.attrs["load"]]
    table: Shown = ()
    figures: Iterable[tuple[str, str]]
    if data.family is None:
        one = Curve(words, beam, data, asked, found)
        verdict, figures = one.verdict, one.figures
    else:
        verdict = free_until(words, beam, float(np.min(data[f"{words.angle}_e"])))
        figures = [("angles", "over the whole beam"), ("model", modelled(beam, data.attrs))]
        table = [_family(words, beam, data, loads=law != HINGE)]
    more = _compared(words, beam, law, laws, found) if compare or full else ()
    rest = [*more, *(_notes(words, beam, law, laws) if full else ())]
    return Summary(verdict, figures, table, data.attrs["warnings"], rest).shown(full=bool(rest))


def _compared(
    words: Load, beam: Beam, law: str, laws: Mapping[str, Answer], found: Bench | None
) -> Iterable[str | Table]:
    """Yield the results of :func:`beside`, and a table with a column for each simpler model (families: one each)."""
    data = laws[law]
    margin = next(float(a.attrs["margin"]) for a in laws.values() if "margin" in a.attrs)
    if found is not None:
        yield f"at {turned(found.at, beam)}:"
        yield from found.lines
        yield ""
    if data.family is None:
        yield _table(words, beam, laws)
        if any(End(end).locks for answer in laws.values() for end in answer["end"].ravel()):
            yield f"cut-off: {margin:g} of the path before the lock"
        return
    for name, response in laws.items():
        yield column(name)
        yield _family(words, beam, response, loads=name != HINGE)
        yield ""
    torque = words.torque
    yield f"{torque}, {torque}/{torque}0 (over the bare beam's) and RED at the cut-off, margin {margin:g}"


def column(name: str) -> str:
    """Return the column title of a response: its law, or its joint."""
    return f"{name} law" if name in LAWS else name


def singles(data: Answer) -> list[Answer]:
    """Return the curves of a family, or the single curve, as a list."""
    return [data] if data.family is None else [data.pick(i) for i in range(data.family)]


def _figure(data: Answer, name: str, factor: float = 1.0) -> str:
    """Return a single figure of a curve as text; "-" if missing, or at the end of a curve without engagement."""
    if name not in data.variables or (name.endswith(("_end", "_c")) and data["end"].item() == End.NONE):
        return "-"
    value = data[name].item()
    return value if isinstance(value, str) else number(value * factor)


def _family(words: Load, beam: Beam, data: Answer, *, loads: bool) -> Table:
    """Return a table with a row per friction coefficient; ``loads``: with torques, which are unbounded near a lock."""
    rate, torque = words.rate, words.torque
    whole = math.degrees(beam.length)
    columns = {
        "end": ("end", 1.0),
        "engages, deg": (f"{rate}_e", whole),
        "ends, deg": (f"{rate}_end", whole),
        "theta, deg": ("theta_end", math.degrees(1)),
    }
    if loads:
        newton = torque_unit(_largest(data[f"{torque}_c"]))
        columns |= {f"{torque}, {newton[1]}": (f"{torque}_c", newton[0]), f"{torque}/{torque}0": ("stiffening", 1.0)}
    columns["RED"] = ("RED_c", 1.0)
    rows = ([f"{one['mu']:g}", *(_figure(one, *figure) for figure in columns.values())] for one in singles(data))
    return table(["mu", *columns], rows, gap=1)


def _notes(kind: Load, beam: Beam, law: str, laws: Mapping[str, Answer]) -> list[str]:
    """Return the lines below the table: the joint, and a sentence for each kind of end."""
    lines = _compliant(kind, beam, laws) if HINGE in laws else _stiffnesses(kind, beam)
    ends = dict.fromkeys(str(end) for data in laws.values() for end in data["end"].ravel())
    lines += [f"{end}: {SENTENCES[End(end)]}" for end in ends]
    lines += _others(beam, laws)
    if any(str(End.NONE) in data["end"] for data in laws.values()):
        lines.append("without engagement the curve is that of the beam without contact")
    if len(laws) > 1:
        thick = {THICK: "beam with thick scales", IDEAL: "beam with thin, rigid scales"}
        whose = f"beam of {law}" if law == beam.extent else thick.get(law, column(law))
        lines.append(f"the curve, files and pictures are those of the {whose}")
    return lines


def _largest(values: Array) -> float:
    """Return the largest magnitude among finite values, for the unit of a table; else 0."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def _others(beam: Beam, laws: Mapping[str, Answer]) -> list[str]:
    """Return a line for each other contact, with its laws and friction coefficients."""
    found: dict[str, dict[str, list[str]]] = {}
    for name, data in laws.items():
        for one in singles(data):
            if other := one["other_contact"].item():
                phi = float(one["phi_touch"]) if "phi_touch" in one.variables else math.nan
                at = f" at {turned(phi, beam)}" if math.isfinite(phi) else ""
                found.setdefault(f"{other}{at}", {}).setdefault(name, []).append(f"{one['mu']:g}")
    lines = []
    for text, by_law in found.items():
        pieces = [f"{column(name)}, mu = {', '.join(mus)}" for name, mus in by_law.items()]
        if len(by_law) == len(laws) and len({*map(tuple, by_law.values())}) == 1:
            pieces = [f"mu = {', '.join(next(iter(by_law.values())))}"]
        lines += [f"other contact ({piece}): {text}" for piece in pieces]
    return lines


def _stiffnesses(kind: Load, beam: Beam) -> list[str]:
    matrix, without = beam.joint.matrix, rigidity(kind.rigidity(beam))
    given = "given", f"from {matrix.name}" if matrix is not None else "by its scaling law"
    line = f"joint of a scale: K_theta = {moment(beam.joint_stiffness)} per rad, {given[beam.joint.stiffness is None]}"
    if not kind.sided:
        return [line, f"beam without contact: C_f E_B I = {without}"]
    factor = f"inclusion factor C_f = {figure(beam.C_f)}, {given[beam.joint.inclusion_factor is None]}"
    return [line, f"beam without contact: C_f J G_B = {without}, {factor}"]


def record(beam: Beam, law: str, laws: Mapping[str, Answer], found: Bench | None) -> dict[str, object]:
    """Return the record of a twisted or bent beam for JSON; ``found``: the result of :func:`beside`.

    ``figures``: single figures of the curve, lists for a family over ``mu``; ``laws``: the same for each law;
    ``curve``: the points, lists of lists for a family; ``each``: those of each of N scales; ``derived``: ratios and
    stiffnesses that follow from the beam.
    """
    data, kind = laws[law], LOADS[laws[law].attrs["load"]]
    derived: dict[str, object] = {**beam.ratios}
    derived |= {key: getattr(beam, key) for key in ("zeta", "slenderness", "length")}
    derived |= {"K_theta": beam.joint_stiffness, "rigidity": kind.rigidity(beam)}
    if kind.sided:
        derived |= {key: getattr(beam, key) for key in ("C_f", "C_w", "J", "I", "G_B")}
    if data.attrs.get("joint") == "compliant":
        derived |= {key: data.attrs[key] for key in ("K_theta", "rigidity")}
        # deviations of simpler models, a record per friction coefficient
        others = {name: answer for name, answer in laws.items() if answer is not data}
        derived["off"] = {name: [d._asdict() for d in differences(answer, data)] for name, answer in others.items()}
    figures = {name: _figures(response) for name, response in laws.items()}
    keys = "load law joint scales sense margin neutral hold ends followed squama_version"
    parts = {"laws": figures, "curve": data.curves, "each": data.each, "bench": found and found.record}
    return output.record(beam, data, keys, derived=derived, figures=figures[law], **parts)


def _figures(data: Answer) -> dict[str, object]:
    words = [SENTENCES[End(end)] for end in data["end"].ravel()]
    return {**data.figures, "sentence": words[0] if data.family is None else words}


def responses(load: str, beam: Beam, how: dict[str, Any]) -> dict[str, Answer]:
    """Return the responses on hinges by law; the law that was not chosen has three points, for its single figures."""
    from squama.curves.doors import respond

    names = sorted(LAWS) if LOADS[load].sided else [how["law"]]
    few = {name: {} if name == how["law"] else {"points": 3} for name in names}
    return {name: respond(beam, load, joint="hinge", **how | {"law": name} | more) for name, more in few.items()}


def ladder(load: str, beam: Beam, how: dict[str, Any], *, simpler: bool) -> dict[str, Answer]:
    """Return the response of the beam and, if ``simpler``, those of simpler models at the same loads, by name."""
    from squama.curves.doors import respond

    ours, ideal = respond(beam, load, joint="compliant", **how), how["ideal"]
    own = beam.extent if "ends" in ours.attrs else IDEAL if ideal else THICK
    if not simpler:
        return {own: ours}
    rates = ours[LOADS[load].rate] if ours.family is None else ours[LOADS[load].rate][0]
    # the ends of simpler models are searched within the same range
    same = how | {"points": 3, "to": float(rates[-1]), "at": rates, "ends": ENDLESS}
    found = {own: ours}
    if "ends" in ours.attrs:
        found[ENDLESS] = respond(beam, load, joint="compliant", **same)
    elif not ideal:
        found[IDEAL] = respond(beam, load, joint="compliant", **same | {"ideal": True})
    # in bending the neutral line of hinges is the bar's middle
    hinged = same | {"ideal": True, "neutral": None if LOADS[load].sided else "middle"}
    return {**found, HINGE: respond(beam, load, joint="hinge", **hinged)}


def _table(words: Load, beam: Beam, laws: Mapping[str, Answer]) -> Table:
    """Return a table with a row per figure and a column per model, at loads of the first; empty rows are left out."""
    angle, torque, first = words.angle, words.torque, next(iter(laws.values()))
    whole, deg = degrees(beam)
    size, newton = torque_unit(max(_largest(a[f"{torque}_c"]) for a in laws.values() if f"{torque}_c" in a.variables))

    def row(label: str, name: str, factor: float = 1.0) -> list[str]:
        return [label, *(_figure(data, name, factor) for data in laws.values())]

    def at(label: str, name: str) -> list[str]:
        return row(f"{label}, {deg}", f"{angle}_{name}", whole)

    cut_off = [
        row("  theta at the end, deg", "theta_end", math.degrees(1)),
        row(f"{words.torque_words} {torque} at the cut-off, {newton}", f"{torque}_c", size),
        row(f"{words.torque_words} over the bare beam's", "stiffening"),
        *([] if words.sided else [row(f"{_KEEPS}, {newton}", "T_c", size)]),
    ]
    rows = [
        row("end", "end"),
        at("  at", "end"),
        at("scales touch at", "e"),
        at("  by the small-angle formula", "e_small"),
        *(_states(words, beam, laws) if "stiffness_ratio" in first.variables else cut_off),
        row("relative energy dissipation RED", "RED_c"),
        row("mu that locks at engagement", "mu_static"),
        row("neighbour in contact", "neighbour"),
        at("twice as stiff as bare from", "twofold"),
        at("five times as stiff from", "fivefold"),
        at(f"{words.torque_words} has its peak at", "peak"),
        at("stress comes to strength at", "strength"),
        at("strain comes to its limit at", "strain"),
        at("a second contact comes in at", "second"),
        at("a scale is bent by a tenth of its length at", "bent"),
    ]
    kept = [line for line in rows if line[1] == "" or {*line[1:]} != {"-"}]
    return table(["", *map(column, laws)] if len(laws) > 1 else ["", ""], kept)


def _states(words: Load, beam: Beam, laws: Mapping[str, Answer]) -> Iterable[list[str]]:
    """Yield rows with the models' figures at twice the engagement of the first model, and at its end."""
    angle, rate, torque, first = words.angle, words.rate, words.torque, next(iter(laws.values()))
    whole, deg = degrees(beam)
    size, newton = torque_unit(_largest(first.along(torque)))
    rigid, unit = rigidity_unit(_largest(first.along(words.tangent)))
    if loads.holds(first.attrs["hold"], words):
        label, name = ("  moment M that holds it straight", "M") if words.sided else (_KEEPS, "T")
        unloaded = {f"{label}, {newton}": (name, size)}
    else:
        unloaded = {f"  bend, {deg}": ("psi", whole)} if words.sided else {f"  twist, {deg}": ("phi", whole)}
    figures = {
        f"  {words.torque_words} {torque}, {newton}": (torque, size),
        **unloaded,
        f"  d{torque}/d{rate}, {unit}": (words.tangent, rigid),
        f"  d{torque}/d{rate} over that without contact": ("stiffness_ratio", 1.0),
        f"  theta{', mean of the scales' if 'ends' in first.attrs else ''}, deg": ("theta", math.degrees(1)),
        "  largest stress in a scale, MPa": ("stress", 1e-6),
        "  largest strain around a scale": ("strain", 1.0),
    }
    reach = [float(data[angle][np.isfinite(data[torque])].max(initial=0.0)) for data in laws.values()]

    def at(name: str, load: float, factor: float) -> Iterable[str]:
        for data, last in zip(laws.values(), reach, strict=True):
            value = math.nan
            if name in data.variables and load <= last * (1 + 1e-9):
                along = worst(data.curves, name) if name in ("stress", "strain") else data.along(name)
                value = float(np.interp(load, data[angle], along))
            yield number(value * factor)

    engaged = float(first[f"{angle}_e"])
    places = {"at twice the engagement": 2 * engaged} if 2 * engaged < reach[0] else {}
    for place, load in (places | {"at the end": reach[0]}).items():
        yield [f"{place}, {turned(load, beam)}", *[""] * len(laws)]
        yield from ([label, *at(name, load, factor)] for label, (name, factor) in figures.items())


def held(attrs: Mapping[str, Any]) -> str:
    """Return the joint and the idealisation of the scales as text, from a response's attributes."""
    if attrs["joint"] == "hinge":
        return f"joint of a scale: hinge; {attrs['scales']}"
    sources = {"matrix": "from the beam's matrix", "law": "by the law of the joint", "elements": "by finite elements"}
    # the accuracy of the joint's law is known in twisting only
    known = math.isfinite(attrs["band"]) and attrs["load"] != "bending"
    about = f", torque to about {100 * attrs['band']:.2g} %" if known else ""
    return f"joint of a scale: six motions, {sources[str(attrs['joint_source'])]}{about}; {attrs['scales']}"


def _compliant(words: Load, beam: Beam, laws: Mapping[str, Answer]) -> list[str]:
    """Return the lines on the compliant joint, and on the deviations of simpler models."""
    ours = next(iter(laws.values()))
    attrs = ours.attrs
    K, without = (float(attrs[key]) for key in ("K_theta", "rigidity"))
    size, newton = torque_unit(K)
    lines = [
        held(attrs),
        f"K_theta = {number(size * K)} {newton} per rad (hinge {number(size * beam.joint_stiffness)}); without contact "
        f"d{words.torque}/d{words.rate} = {rigidity(without)} (hinge {rigidity(words.rigidity(beam))})",
    ]
    if attrs["scales"] == "thick, rigid scales":
        lines.append("scale.youngs_modulus is not given: the scales are taken as rigid, and their torque is too high")
    off = {name: differences(answer, ours) for name, answer in laws.items() if answer is not ours}
    for i, one in enumerate(singles(ours)):
        of_mu = f"mu = {one['mu']:g}: " if ours.family is not None else ""
        if first := one["first_contact"].item():
            work = f"the {words.torque_words}'s work is balanced to {abs(float(one['energy_error'])):.1e}"
            lines.append(f"{of_mu}first contact: {first}; {work}")
            lines += [f"{of_mu}{line}" for line in _borne(words, beam, one)]
        for name, found in off.items():
            if not math.isnan(found[i].within):
                lines.append(f"{of_mu}{name}: {found[i].said(words.torque_words)}")
    return lines


def _borne(words: Load, beam: Beam, data: Answer) -> list[str]:
    """Return lines on the largest stress in a scale and the load on its tab, at the last point that has them."""
    lines, loads, curves = [], data[words.angle], data.curves

    def where_most(name: str, i: int) -> tuple[str, tuple[int, ...], str]:
        """Return suffix of the names, index, and words for the face or scale with the largest value."""
        if name in data.each:
            scale = int(np.nanargmax(data[name][i]))
            return "", (i, scale), f" of scale {scale + 1}"
        other = float(worst(curves, name)[i]) > data[name][i]
        return (OTHER, (i,), " on the other face") if other else ("", (i,), "")

    for i in np.flatnonzero(np.isfinite(data.along("stress_x")))[-1:]:
        tail, place, where = where_most("stress", i)
        x, stress = float(data[f"stress_x{tail}"][place]), float(data[f"stress{tail}"][place])
        along = f"{number(x * 1e3)} mm from the root" if x else "at the root"
        at = turned(loads[i], beam)
        lines.append(f"largest stress in a scale: {number(stress / 1e6)} MPa {along}{where}, at {at}")
    for i in np.flatnonzero(np.isfinite(data.along("tab_force")) & (loads > data[f"{words.angle}_e"]))[-1:]:
        tail, place, where = where_most("tab_force", i)
        names = "tab_force", "pull_out", "tab_bending", "tab_torsion"
        force, pull, bend, twist = (float(data[f"{name}{tail}"][place]) for name in names)
        size, newton = torque_unit(max(abs(bend), abs(twist)))
        out = f"{number(abs(pull), 'N')} {'pulling out' if pull > 0 else 'pushing in'}"
        M, T = (number(size * abs(moment), newton) for moment in (bend, twist))
        tab = f"load on the embedded tab{where or ' of a scale'}: {number(force, 'N')} ({out})"
        lines.append(f"{tab}, bending moment {M}, twisting moment {T}, at {turned(loads[i], beam)}")
    return lines


class Difference(NamedTuple):
    """A curve against a reference: agreement up to ``within``; differences at ``last``, the last common load."""

    mu: float
    within: float
    last: float
    torque: float
    theta: float

    def said(self, torque: str) -> str:
        """Return the range of agreement and the final deviation as text; ``torque``: the load in words."""
        if self.within >= self.last:
            return f"within {percent(SHARE)} in {torque} as far as both go, {per_pitch(self.last)}"
        holds = f"within {percent(SHARE)} in {torque} up to {per_pitch(self.within)}"
        holds = holds if self.within else f"more than {percent(SHARE)} off in {torque} from the start"
        theta = number(math.degrees(self.theta), sign="+")
        return f"{holds}; at {per_pitch(self.last)} {apart_by(self.torque)}, theta {theta} deg"


def differences(answer: Answer, reference: Answer) -> list[Difference]:
    """Compare curves of one load, a result per friction coefficient."""
    found, words = [], LOADS[reference.attrs["load"]]
    angle, torque = words.angle, words.torque
    for one, two in zip(singles(answer), singles(reference), strict=True):
        # in a family a curve may have the twists of another friction
        phi, theta = two[angle], np.interp(two[angle], one[angle], one.along("theta"), right=np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.where(phi > 0, np.interp(phi, one[angle], one[torque], right=np.nan) / two[torque] - 1, np.nan)
        within, end = holds(phi, off, SHARE)
        last = (phi[end], off[end], theta[end] - two.along("theta")[end]) if math.isfinite(within) else [math.nan] * 3
        found.append(Difference(float(one["mu"]), within, *map(float, last)))
    return found
