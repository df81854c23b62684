"""squama load: a beam of N scales on its supports, under forces, moments, a tendon or its weight."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any

from squama.beam import beamfile
from squama.cli import flags, output
from squama.cli.flags import flag, settled
from squama.io.files import label
from squama.units import moment, number, shown

if TYPE_CHECKING:
    import xarray as xr

    from squama.part.definition import Part

_LOAD = (
    'What loads it: "0.2 N up at tip", "10 mm down at middle", "0.5 N down over all", "weight down", "30 N mm twist", '
    '"90 deg bend", "3 N tendon at 4 mm"; may be repeated ([[load]] of the file).'
)
_SUPPORT = (
    'Supports: clamped (the root), gripped (both ends), "simple, span 180 mm" (two rollers) ([support] of the file, '
    "clamped without it)."
)
_ALONG = (
    'What differs along the beam, of the first and the last scale: scale.theta0="5 deg, 10 deg"; may be repeated. Or a '
    "table (CSV) with a row for each scale ([along] of the file)."
)
_KEYS = "load loads support graded joint hold K_theta rigidity joint_source band squama_version"
_PAIR = flags.pair("name=first, last", 'scale.theta0="5 deg, 10 deg"')


def _grade(name: str, text: str) -> flags.Pair:
    """Read a grade; what has no sign of equality is the name of a table."""
    return _PAIR(name, text) if "=" in text else flags.Pair("", text)


def load(
    beam: flags.BeamFile,
    /,
    *,
    load: Annotated[tuple[str, ...], flag(_LOAD, read=flags.Reader(lambda _, text: text, ""), many=True)] = (),
    support: Annotated[str | None, flag(_SUPPORT)] = None,
    scales: Annotated[int | None, flags.scales(200, "Number of scales (that of the file)")] = None,
    along: Annotated[tuple[flags.Pair, ...], flag(_ALONG, read=flags.Reader(_grade, _PAIR.failed), many=True)] = (),
    mu: flags.Mu = None,
    back: Annotated[bool, flags.Parameter(help="Take the load off again.")] = False,
    ideal: flags.Ideal = False,
    points: Annotated[int, flags.points(50)] = 50,
    gif: Annotated[flags.File | None, flag("Animation of the part as it deforms (.gif).")] = None,
    common: flags.Common = flags.COMMON,
) -> int:
    """Load a part: a beam of N scales on its supports, under forces, moments, a tendon or its weight."""
    flags.check_places([(gif, (".gif",))])
    common.check(beam, *(grade.text for grade in along if not grade.name))
    given: dict[str, Any] = {"load": list(load) or None, "support": support, "along": _grades(along)}
    given = {name: value for name, value in given.items() if value is not None}
    part = settled(_part(common, beam, mu, load))

    from squama import plot
    from squama.part import door

    how: dict[str, Any] = {"scales": scales, "points": points, "back": back, "ideal": ideal or None}
    own = {name: f"{label(beam)}: {beamfile.heading(name)}" for name in beamfile.PART}
    with flags.laid(flags.arguments("scales") | own | {name: f"--{name}" for name in given}):
        data = door.load(part, **given, **how)
    written = output.write(common, lambda: data, "part_figure", lambda d: output.flat(d.drop_dims(_OTHERS), "theta"))
    if gif is not None:
        written.append(plot.part_animation(data, gif))
    parts = {"figures": output.figures(data), "curve": "point", "root": "point axis", "sections": "point section"}
    record = output.record(part.beam, data, _KEYS, **parts, scales="point scale")
    record["idealisation"] = data.attrs["scales"]
    replaced = [f"--{name} in place of {own[name]}" for name in given if getattr(part, name)]
    return output.report(common.json, beam, written, record, (*_shown(data), *replaced))


def _grades(along: tuple[flags.Pair, ...]) -> dict[str, list[str]] | str | None:
    """Return what --along gives: values by name, or the one table; mistakes are kept."""
    tables = [grade.text for grade in along if not grade.name]
    if tables and len(along) > 1:
        flags.problems().add("--along", shown(tables[0]), "stands beside others", "give a table alone")
    if tables:
        return tables[0]
    return {name: [v.strip() for v in text.split(",")] for name, text in flags.once("--along", along).items()} or None


def _part(common: flags.Common, path: str, mu: float | None, load: tuple[str, ...]) -> Part | None:
    """Read the part; mistakes are kept, as is that neither the file nor a flag loads it."""
    from squama.part.definition import Part

    found = None
    with flags.problems().caught(), flags.laid({s.place: s.name for s in common.settings}):
        found = Part.from_toml(path, overrides=common.overrides(mu))
        flags.check_friction(path, found.beam)
    if found is not None and not (load or found.load):
        remedy = 'give it, e.g. --load "0.2 N up at tip", or write [[load]] in the beam file'
        flags.problems().add("--load", "", "is missing", remedy)
    return found


_OTHERS = ["section", "axis"]
_SUPPORTS = {
    "clamped": "clamped at its root, free at its tip",
    "gripped": "both ends in grips that stay on one axis and may come nearer",
    "simple": "on two rollers",
}


def _shown(data: xr.Dataset) -> Iterable[str]:
    """Return the summary: the part under all of its load."""
    import numpy as np

    from squama.cli.report import held

    n, top = data.sizes["scale"], int(np.argmax(data["share"].values))
    most = data.isel(point=top)
    force = "F" in data
    name, way = ("F", "travel") if force else ("moment", "turn")
    size, bare, travel = (float(most[v]) for v in (name, f"{name}_bare", way))
    say = (lambda v: number(v, "N")) if force else moment
    far = number(1e3 * travel, "mm") if force else f"{math.degrees(travel):.4g} deg"
    yield f" as a part of {n} scales: {data.attrs['loads']}; mu = {float(data['mu']):g}"
    yield held(data.attrs)
    yield f"{_SUPPORTS[data.attrs['support'].split(',')[0].strip()]}" + (
        f"; graded: {data.attrs['graded']}" if "graded" in data.attrs else ""
    )
    on, engaged = float(most["share"]), float(data["share_e"])
    reached = "all of it is on" if on > 1 - 1e-6 else f"{on:.3g} of it is on: {data['end'].item()}"
    yield f"{'force' if force else 'moment'} {say(size)} at {far}; {reached}"
    if math.isfinite(bare) and bare:
        yield f"without contact it would be {say(bare)} there: {number(size / bare)} of it"
    yield f"scales first touch at {number(engaged)} of the load" if math.isfinite(engaged) else "no scales touch"
    tip = [1e3 * float(most[f"{v}_axis"][-1] - data[f"{v}_axis"][0, -1]) for v in "xyz"]
    yield f"the tip moves by {tip[0]:.4g}, {tip[1]:.4g} and {tip[2]:.4g} mm across, up and along"
    for what, unit, factor in (("root_force", "N", 1.0), ("root_moment", "N mm", 1e3)):
        if np.any(most[what].values):
            x, y, z = (factor * most[what].values + 0.0).round(12)
            yield f"the root is held by a {what.removeprefix('root_')} of {x:.4g}, {y:.4g}, {z:.4g} {unit} (x, y, z)"
    bends, twists = most["psi_cell"].values, most["phi_cell"].values
    yield (
        f"cells bend by {bends.min():.3g} to {bends.max():.3g} and twist by {twists.min():.3g} to "
        f"{twists.max():.3g} rad/pitch"
    )
    N = most["N"].values[:-1]
    if np.nanmax(N) > 0:
        yield f"largest contact force: {number(float(np.nanmax(N)), 'N')}, of scale {int(np.nanargmax(N)) + 1}"
    stress = most["stress"].values
    if np.isfinite(stress).all() and stress.max() > 0:
        yield f"largest stress: {stress.max() / 1e6:.4g} MPa, in scale {stress.argmax() + 1}"
    rubbed, error = float(most["RED"]), float(data["energy_error"])
    yield f"relative energy dissipation RED = {rubbed:.4g}; the work of the load is balanced to {error:.1e}"
    if top < data.sizes["point"] - 1:
        back, work = data.isel(point=-1), float(data["W_fr"][-1]) * n * data.attrs["pitch"]
        left = round(float(back[way]) / travel, 9) + 0.0  # no -0
        yield f"off again: {left:.4g} of the deformation is left; friction has taken {number(1e3 * work, 'mJ')}"
    yield from output.warnings(data.attrs["warnings"])
