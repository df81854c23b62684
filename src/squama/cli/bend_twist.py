"""squama bend-twist: bending and twisting at once, along a path, from a beam file."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

from squama.cli import flags, output
from squama.cli.flags import flag, one_of, settled
from squama.loads import KEPT, LOADS, PAPER, THIN
from squama.model.outcome import SENTENCES, End
from squama.units import moment, number

if TYPE_CHECKING:
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.curves.labelled import Answer

_PATH = 'Where to go, way by way: "bend 5 rad/m; twist 8 rad/m"; a comma joins what changes at once; below 0 is back.'
_FREE = "Load that is left free, twisting or bending, while the other is imposed; without friction (--mu 0)."
_KEYS = "load free law joint scales neutral margin path squama_version"


def bend_twist(
    beam: flags.BeamFile,
    /,
    *,
    path: Annotated[str, flag(_PATH)],
    mu: flags.Mu = None,
    margin: flags.Margin = 0.01,
    points: Annotated[int, flags.points(200)] = 200,
    neutral: flags.Neutral = "middle",
    free: Annotated[str | None, flag(_FREE, read=one_of(*LOADS))] = None,
    common: flags.Common = flags.COMMON,
) -> int:
    """Bend and twist a beam of hinged scales along a path: contacts, jumps, locks, moment and torque."""
    common.check(beam)
    described = settled(common.beam(beam, mu))

    from squama.curves.polygons import bent_and_twisted, plane

    with flags.laid(flags.arguments("path", "neutral", "free")):
        data = bent_and_twisted(described, path, margin=margin, points=points, neutral=neutral, free=free)
    around = plane(data) if common.plot else None
    written = output.write(common, data.dataset, "path_figure", lambda d: d.drop_dims("event"), plane=around)
    return output.report(common.json, beam, written, lambda: _record(described, data), lambda: _shown(described, data))


def _record(beam: Beam, data: Answer) -> dict[str, object]:
    figures = {name: value for name, value in output.part(data).items() if name != "mu"}
    events, curve = output.part(data, "event"), output.part(data, "point")
    return output.record(beam, data, _KEYS, figures=figures, events=events, curve=curve)


def _shown(beam: Beam, data: Answer) -> Iterable[str | Table]:
    """Return the summary: what happens on the way, and how it ends."""
    freed = f"; {data.attrs['free']} is left free" if "free" in data.attrs else ""
    yield (
        f" bent and twisted: {beam.scales} scales on {beam.length * 1e3:.4g} mm, mu = {float(data['mu']):g}, "
        f"{THIN} on {PAPER['joint']}s, edge law; {KEPT.format(data.attrs['neutral'])}"
        f"{freed}"
    )
    yield ""
    pairs = [[data[f"{name}_event"] for name in names] for names in (("psi", "phi"), ("kappa", "Phi"))]
    jumps = [data[name] for name in ("M_jump", "T_jump") if name in data.variables]
    rows = (
        (
            str(data["event"][i]),
            str(data["event_leg"][i]),
            *(", ".join(number(float(v[i])) for v in pair) for pair in pairs),
            number(math.degrees(data["theta_event"][i])),
            *(moment(float(jump[i])) if jump[i] else "" for jump in jumps),
        )
        for i in range(data["event"].size)
    )
    head = (
        "",
        "way",
        "psi, phi rad/pitch",
        "kappa, Phi rad/m",
        "theta deg",
        *("M jumps by", "T jumps by")[: len(jumps)],
    )
    yield output.table(head, rows, gap=1)
    yield ""
    end, other = data["end"].item(), data["other_contact"].item()
    yield f"{SENTENCES[End(end)]}{f' ({other})' if other else ''}"
    near = f" (margin {data.attrs['margin']:g} before a lock)" if "margin" in data.attrs else ""
    yield (
        f"there{near}: M = {moment(float(data['M_c']))}, "
        f"T = {moment(float(data['T_c']))}, frictional work {number(float(data['W_fr_c']), 'J/m')}, "
        f"RED = {float(data['RED_c']):.4g}"
    )
    yield f"joint of a scale: K_theta = {moment(float(data['K_theta']))}, that of twisting, in bend and in twist"
    yield from output.warnings(data.attrs["warnings"])
