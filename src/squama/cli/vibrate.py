"""squama vibrate, shake: a beam that swings freely, or is shaken, from a beam file."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

from squama.cli import flags, output
from squama.cli.flags import flag, number, settled, whole
from squama.cli.summary import Summary, figure, modelled, turned
from squama.loads import LOADS, ended
from squama.units import number as shown_number

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from squama.beam.design import Beam

_KEYS = "load law joint scales mode ends faces damping inertia K_theta rigidity squama_version"
SHOWN = 12
"""Cycles in the table of the summary at most."""
_NAMES = "rotor density damping release impulse mode ends swings static torque"
_BOTH = {"release, impulse": "--release, --impulse", "static, torque": "--static, --torque"}
_LAID = flags.arguments(*_NAMES.split(), **_BOTH, frequencies="--lowest, --highest")


@flags.group
class Swinging(flags.How):
    """What swings, and by which model: arguments of :func:`squama.vibrate` and :func:`squama.shake`."""

    mode: flags.Mode = "uniform"
    ends: flags.Ends = None
    rotor: Annotated[
        str | None, flag('Moment of inertia at the end, e.g. "1e-4 kg m2". Default: the beam file\'s.')
    ] = None
    density: Annotated[str | None, flag('Mean density of the bar, e.g. "1100 kg/m3". Default: the beam file\'s.')] = (
        None
    )


SWINGING = Swinging()


def vibrate(
    beam: flags.BeamFile,
    /,
    *,
    release: Annotated[str | None, flag(f"Twist from which the beam is let go: {flags.TWISTS}.")] = None,
    impulse: Annotated[
        str | None, flag('Angular impulse on the rotor at rest, instead of --release: "0.01 N m s".')
    ] = None,
    swinging: Swinging = SWINGING,
    damping: Annotated[float, flag("Damping ratio of the material. Default: 0.", read=number(0.0, 0.5, "0.01"))] = 0.0,
    swings: Annotated[int, flag("Number of cycles. Default: 8.", read=whole(1, 10_000, "8"))] = 8,
    mu: flags.Mu = None,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Let a beam vibrate freely: frequency, decay, damping of every cycle."""
    common.check(beam)
    described = settled(common.beam(beam, mu))

    from squama.curves.labelled import flat_cycle
    from squama.dynamics.doors import vibrate

    with flags.laid(_LAID):
        data = vibrate(described, release=release, impulse=impulse, damping=damping, swings=swings, **vars(swinging))
    written = output.write(common, lambda: data, "vibration_figure", flat_cycle)
    record = output.record(described, data, _KEYS, figures="", turns="turn", cycles="cycle", record="point")
    return output.report(common.json, beam, written, record, _summary(described, data).shown(full=full))


def _summary(beam: Beam, data: xr.Dataset) -> Summary:
    """Return the summary: damping and frequency of the first and the last cycle, whether the beam jams."""
    attrs = data.attrs
    angle = LOADS[attrs["load"]].angle
    y, zeta, period = (data[name].values for name in (f"{angle}_turn", "zeta_cycle", "period"))
    engaged, jams = float(data[f"{angle}_e"]), data["end"].item() == "jams"
    if jams:
        last, rest = (turned(float(v), beam) for v in (y[-1], data[f"{angle}_rest"]))
        verdict = f"it jams: let go at {last} it stays at {rest}"
    else:
        verdict = f"{figure(1 / period[0], 'Hz')}, damping ratio {figure(zeta[0])} in the first of {zeta.size} cycles"
    below = "friction damps beyond engagement only: below it the beam rings on unless its material damps (--damping)"
    rubs = float(data["mu"]) and math.isfinite(engaged) and not attrs["damping"] and not jams
    figures = [
        ("swings from", turned(float(y[0]), beam) if y.size else ""),
        ("after the last cycle", turned(float(y[-1]), beam) if not jams and y.size > 1 else ""),
        ("damping ratio, last cycle", figure(zeta[-1]) if zeta.size > 1 else ""),
        ("frequency before contact", figure(float(data["f_0"]), "Hz")),
        ("scales touch", f"at {turned(engaged, beam)}" if math.isfinite(engaged) else "never"),
        ("friction", f"mu = {float(data['mu']):g}"),
        ("model", f"{modelled(beam, attrs)}; {attrs['mode']}"),
    ]
    return Summary(verdict, figures, [below] if rubs else [], attrs["warnings"], _cycles(data))


def _cycles(data: xr.Dataset) -> Iterable[str | Table]:
    """Yield a row per cycle, and how the record ends."""
    angle = LOADS[data.attrs["load"]].angle
    columns = ("t_turn", f"{angle}_turn", "U_turn", "zeta_cycle", "period")
    t, y, U, zeta, period = (data[name].values for name in columns)
    n = min(zeta.size, SHOWN)
    peaks, troughs = slice(0, 2 * n, 2), slice(1, 2 * n, 2)
    cycles = zip(t[peaks], y[peaks], y[troughs], U[peaks], zeta[:n].round(9), 1 / period[:n], strict=True)
    if n:
        head = ("cycle", "at s", f"peak {angle} rad/pitch", "trough", "energy J", "damping", "frequency Hz")
        yield output.table(head, ([str(i), *map(shown_number, row)] for i, row in enumerate(cycles, 1)))
    if zeta.size > SHOWN:
        yield f"the first {SHOWN} of {zeta.size} cycles"
    f_0, engaged = float(data["f_0"]), float(data[f"{angle}_e"])
    yield f"without contact {f_0:.4g} Hz; scales engage at {shown_number(engaged, 'rad/pitch')}"
    if data["end"].item() == "jams":
        yield f"it jams: let go at {y[-1]:.4g} rad/pitch it stays at {float(data[f'{angle}_rest']):.4g} rad/pitch"
    yield "damping: ln of the elastic energies at two peaks over 4 pi; a number of its amplitude, not of the beam"


def shake(
    beam: flags.BeamFile,
    /,
    *,
    lowest: Annotated[str, flag('Lowest frequency, e.g. "1 Hz".')],
    highest: Annotated[str, flag('Highest frequency, e.g. "5 Hz".')],
    static: Annotated[
        str | None, flag(f"Amplitude of the torque by the twist it gives the bare beam at rest: {flags.TWISTS}.")
    ] = None,
    torque: Annotated[str | None, flag('Amplitude of the torque, instead of --static: "0.1 N m".')] = None,
    swinging: Swinging = SWINGING,
    damping: Annotated[
        float, flag("Damping ratio of the material. Default: 0.01.", read=number(0.0, 0.5, "0.01"))
    ] = 0.01,
    points: Annotated[int, flag("Number of frequencies. Default: 25.", read=whole(2, 1000, "25"))] = 25,
    mu: flags.Mu = None,
    common: flags.Common = flags.COMMON,
) -> int:
    """Shake a beam by a harmonic torque: steady states over the frequency, up and down."""
    import numpy as np

    from squama.dynamics.doors import frequency, shake

    common.check(beam)
    with flags.problems().caught():
        first = frequency("--lowest", lowest)
    with flags.problems().caught():
        last = frequency("--highest", highest)
    described = settled(common.beam(beam, mu))
    frequencies = np.linspace(first, last, points)
    with flags.laid(_LAID):
        data = shake(described, frequencies, static=static, torque=torque, damping=damping, **vars(swinging))
    written = output.write(common, lambda: data, "shaken_figure", _table)
    record = output.record(described, data, _KEYS, figures="", frequency=frequencies, states="way frequency")
    return output.report(common.json, beam, written, record, _states(data))


def _table(data: xr.Dataset) -> xr.Dataset:
    """Return steady states as a table over the frequency, a column for each way."""
    both = [name for name in data.data_vars if data[name].dims == ("way", "frequency")]
    ways = {f"{name}_{way}": data[name].sel(way=way, drop=True) for name in both for way in ("up", "down")}
    return data.drop_dims("way").assign(ways)


def _states(data: xr.Dataset) -> Iterable[str | Table]:
    """Yield the summary: a row per frequency, upwards and downwards."""
    kind, attrs = LOADS[data.attrs["load"]], data.attrs
    yield f" shaken {ended(attrs)} in {kind.name} ({attrs['mode']}): {output.about(data)}"
    head, columns = ["Hz"], [map(shown_number, data["frequency"].values)]
    for way in ("up", "down"):
        one = data.sel(way=way)
        high, low = (map(shown_number, one[f"{kind.angle}_{end}"].values) for end in ("high", "low"))
        loose = ["" if settled else " *" for settled in one["settled"].values]
        share = (one["W_rubbed"] / one["W_fed"]).where(one["settled"])
        head += [f"{way}: {kind.angle} largest", "smallest", "friction"]
        columns += [high, map(str.__add__, low, loose), map(shown_number, share.values)]
    yield output.table(head, zip(*columns, strict=True))
    yield (
        f"{kind.angle}: largest and smallest, rad/pitch; friction: its share of the torque's work; without contact "
        f"{float(data['f_0']):.4g} Hz"
    )
    if not data["settled"].values.all():
        yield "*: not periodic with the torque; largest and smallest of its last periods"
    yield from output.warnings(attrs["warnings"])
