"""squama load: a beam of N scales on its supports, under forces, moments, a tendon or its weight."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from squama.beam import beamfile
from squama.cli import flags, output
from squama.cli.flags import flag, settled
from squama.cli.output import Summary, largest_stress, modelled, percent
from squama.io.files import label
from squama.people import figure
from squama.units import moment, number, shown

if TYPE_CHECKING:
    from squama.beam.design import Beam
    from squama.curves.labelled import Answer
    from squama.part.definition import Part
    from squama.types import Array

_LOAD = (
    'Load: "0.2 N up at tip", "10 mm down at middle", "0.5 N down over all", "weight down", "30 N mm twist", '
    '"90 deg bend", "3 N tendon at 4 mm"; may be repeated. Default: [[load]] of the file.'
)
SUPPORT = (
    'Support: clamped (the root), gripped (both ends), "simple, span 180 mm" (two rollers). Default: [support] of the '
    "file, or clamped."
)
_ALONG = (
    'Values that differ along the beam, at the first and last scale: scale.theta0="5 deg, 10 deg"; may be repeated. '
    "Or a CSV table with a row for each scale. Default: [along] of the file."
)
_KEYS = "load loads support graded joint scales hold K_theta rigidity joint_source band squama_version"
_PAIR = flags.pair("name=first, last", 'scale.theta0="5 deg, 10 deg"')


def _grade(name: str, text: str) -> flags.Pair:
    """Read a value that varies along the beam; a text without "=" is the name of a table."""
    return _PAIR.read(name, text) if "=" in text else flags.Pair("", text)


def load(
    beam: flags.BeamFile,
    /,
    *,
    load: Annotated[tuple[str, ...], flag(_LOAD, read=flags.Reader(lambda _, text: text, ""), many=True)] = (),
    support: Annotated[str | None, flag(SUPPORT)] = None,
    scales: Annotated[int | None, flags.scales(200, "Number of scales. Default: the file's; allowed:")] = None,
    along: Annotated[tuple[flags.Pair, ...], flag(_ALONG, read=flags.Reader(_grade, _PAIR.failed), many=True)] = (),
    mu: flags.Mu = None,
    back: Annotated[bool, flags.Parameter(help="Unload afterwards.")] = False,
    ideal: flags.Ideal = False,
    points: Annotated[int, flags.points(50)] = 50,
    full: flags.Full = False,
    gif: Annotated[flags.File | None, flag("Animation of the part from the side as it deforms (.gif).")] = None,
    view: Annotated[tuple[flags.File, ...], flag("The part in space (.png, .gif, .html); may be repeated.")] = (),
    common: flags.Common = flags.COMMON,
) -> int:
    """Load a part of N scales on its supports: forces, moments, a tendon, its weight."""
    flags.check_places([(gif, (".gif",))])
    if view:
        from squama.scene import picture, standalone

        flags.check_places([(path, picture.FORMATS) for path in view])
        with flags.problems().caught():
            if any(path.lower().endswith(".html") for path in view):
                standalone.find()
    common.check(beam, *(grade.text for grade in along if not grade.name))
    given: dict[str, Any] = {"load": list(load) or None, "support": support, "along": _grades(along)}
    given = {name: value for name, value in given.items() if value is not None}
    found = read(common, beam, mu)
    if found is not None and not (load or found.load):
        remedy = 'give it, e.g. --load "0.2 N up at tip", or write [[load]] in the beam file'
        flags.problems().add("--load", "", "is missing", remedy)
    part = settled(found)

    from squama.part import door

    own = {name: f"{label(beam)}: {beamfile.heading(name)}" for name in beamfile.PART}
    with flags.laid(flags.arguments("scales") | own | {name: f"--{name}" for name in given}):
        whole = replace(part, **given)
        beside = full or common.json or bool(common.plot or common.csv or common.netcdf)
        how: dict[str, Any] = {"ideal": ideal or None, "endless": beside}
        answer, told = door.followed(whole, scales=scales, points=points, back=back, **how)
    written = output.write(common, answer.dataset, "part_figure")
    if gif is not None:
        from squama import plot

        written.append(plot.part_animation(answer.dataset(), gif))
    if view:
        from squama.scene import part_motion

        written += part_motion.drawn(answer, told, *view, name=Path(beam).stem).files
    parts = {"figures": output.figures(answer), "curve": "point", "root": "point axis", "sections": "point section"}
    record = output.record(part.beam, answer, _KEYS, **parts, each="point scale")
    replaced = [f"--{name} in place of {own[name]}" for name in given if getattr(part, name)]
    return output.report(common.json, beam, written, record, _summary(part.beam, answer, replaced).shown(full=full))


def _grades(along: tuple[flags.Pair, ...]) -> dict[str, list[str]] | str | None:
    """Return the values of --along by name, or its table; mistakes are collected."""
    tables = [grade.text for grade in along if not grade.name]
    if tables and len(along) > 1:
        flags.problems().add("--along", shown(tables[0]), "stands beside others", "give a table alone")
    if tables:
        return tables[0]
    return {name: [v.strip() for v in text.split(",")] for name, text in flags.once("--along", along).items()} or None


def read(common: flags.Base, path: str, mu: float | None = None, *, friction: bool = True) -> Part | None:
    """Read a part, as :meth:`squama.cli.flags.Base.beam` reads the beam alone."""
    from squama.part.definition import Part

    with flags.problems().caught(), flags.laid({s.place: s.name for s in common.settings}):
        found = Part.from_toml(path, overrides=common.overrides(mu))
        if friction:
            flags.check_friction(path, found.beam)
        return found
    return None


_SUPPORTS = {
    "clamped": "clamped at its root, free at its tip",
    "gripped": "both ends in grips that stay on one axis and may come nearer",
    "simple": "on two rollers",
}


def _summary(beam: Beam, data: Answer, replaced: list[str]) -> Summary:
    """Return the summary: the part under its full load; ``replaced``: values of the file that flags replace."""
    attrs, top, n = data.attrs, int(data["share"].argmax()), data["scale"].size
    most = data.at(top)
    force = "F" in most
    name, way = ("F", "travel") if force else ("moment", "turn")
    size, bare, travel = (float(most[v]) for v in (name, f"{name}_bare", way))
    far = figure(1e3 * travel, "mm") if force else figure(math.degrees(travel), "deg")
    on, engaged = float(most["share"]), float(data["share_e"])
    verdict = f"{figure(size, 'N') if force else moment(size)} at {far}"
    if bare and math.isfinite(bare):
        ratio = figure(size / bare)
        verdict += ", as without contact" if ratio == "1" else f", {ratio} times the load without contact"
    moved = [1e3 * float(most[f"{v}_axis"][-1] - data[f"{v}_axis"][0, -1]) for v in "xyz"]
    # rounding is no motion
    tip = [figure(v if abs(v) > 1e-6 * max(map(abs, moved)) else 0.0, "mm") for v in moved]
    # the strain at which all of it is on is located to a part in a thousand
    whole = "all of it is on" if on > 1 - 1e-3 else f"only {percent(on)} of it is on: {data['end'].item()}"
    graded = f"; graded: {attrs['graded']}" if "graded" in attrs else ""
    figures = [
        ("load", f"{attrs['loads']}; {whole}"),
        ("support", f"{_SUPPORTS[attrs['support'].split(',')[0].strip()]}{graded}"),
        ("scales touch", f"from {percent(engaged)} of the load on" if math.isfinite(engaged) else "never"),
        ("the tip moves", f"{tip[0]} across, {tip[1]} up, {tip[2]} along"),
        ("largest stress in a scale", largest_stress(most["stress"], beam)),
    ]
    if top < data["share"].size - 1:
        # no -0
        left = percent(round(float(data[way][-1]) / travel, 9) + 0.0)
        work = figure(1e3 * float(data["W_fr"][-1]) * n * attrs["pitch"], "mJ")
        figures.append(("unloaded", f"{left} of the deformation is left; friction took {work}"))
    figures.append(("friction", f"mu = {float(data['mu']):g}; it takes {percent(float(most['RED']))} of the work"))
    figures.append(("model", modelled(beam, attrs, f"{n} scales")))
    return Summary(verdict, figures, replaced, attrs["warnings"], _all(data, most))


def _all(data: Answer, most: Mapping[str, Array]) -> Iterable[str]:
    """Yield the endless beam's load, reactions, strains, contact force, energy balance; ``most``: at the top."""
    import numpy as np

    name, size = ("F", partial(figure, unit="N")) if "F" in most else ("moment", moment)
    if math.isfinite(endless := float(most[f"{name}_periodic"])):
        ratio = percent(float(most[name]) / endless)
        yield f"with the law of the endless beam at each place: {size(endless)}; the part has {ratio} of it"
    else:
        yield "with the law of the endless beam at each place the part ends before"

    for what, unit, factor in (("root_force", "N", 1.0), ("root_moment", "N mm", 1e3)):
        if np.any(most[what]):
            held = ", ".join(number(v) for v in (factor * most[what] + 0.0).round(9))
            yield f"{what.removeprefix('root_')} at the root: {held} {unit} (x, y, z)"
    bends, twists = (np.degrees(most[name]) for name in ("psi_cell", "phi_cell"))
    yield f"bend of the pitches: {number(bends.min())} to {number(bends.max(), 'deg')}"
    yield f"twist of the pitches: {number(twists.min())} to {number(twists.max(), 'deg')}"
    N = most["N"][:-1]
    if np.nanmax(N) > 0:
        yield f"largest contact force: {number(float(np.nanmax(N)), 'N')}, of scale {int(np.nanargmax(N)) + 1}"
    yield f"the work of the load is balanced to {float(data['energy_error']):.0e}"
