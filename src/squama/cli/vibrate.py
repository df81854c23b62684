"""squama vibrate and shake: free and forced vibrations from a beam file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from squama.cli import flags, output
from squama.cli.flags import flag, settled, whole
from squama.cli.output import Shown, Summary, joules, modelled, percent, touching
from squama.loads import LOADS, UNIFORM
from squama.people import degrees, figure, turned
from squama.units import number

if TYPE_CHECKING:
    import xarray as xr

    from squama.beam.design import Beam

_KEYS = "load law joint scales mode ends faces damping inertia K_theta rigidity squama_version"
SHOWN = 12
"""Largest number of cycles in the table of the summary."""
_ROTOR = 'Moment of inertia at the end, e.g. "1e-4 kg m2". Default: the beam file\'s.'
_DENSITY = 'Mean density of the bar, e.g. "1100 kg/m3". Default: the beam file\'s.'
_IMPULSE = 'Angular impulse on the rotor at rest, instead of --release: "0.01 N m s".'
_STATIC = f"Amplitude of the torque by the twist it gives the bare beam at rest: {flags.TWISTS}."
_damping = flags.number(0.0, 0.5, "0.01")
_APART = 0.02
"""Relative difference of amplitudes above which two states differ."""
_NAMES = "rotor density damping release impulse mode ends swings static torque"
_BOTH = {"release, impulse": "--release, --impulse", "static, torque": "--static, --torque"}
_LAID = flags.arguments(*_NAMES.split(), **_BOTH, frequencies="--lowest, --highest")


@flags.group
class Swinging(flags.How):
    """Mass, ends and model of a vibrating beam: arguments of :func:`squama.vibrate` and :func:`squama.shake`."""

    mode: flags.Mode = "uniform"
    ends: flags.Ends = None
    rotor: Annotated[str | None, flag(_ROTOR)] = None
    density: Annotated[str | None, flag(_DENSITY)] = None


SWINGING = Swinging()


def vibrate(
    beam: flags.BeamFile,
    /,
    *,
    release: Annotated[str | None, flag(f"Twist from which the beam is let go: {flags.TWISTS}.")] = None,
    impulse: Annotated[str | None, flag(_IMPULSE)] = None,
    swinging: Swinging = SWINGING,
    damping: Annotated[float, flag("Damping ratio of the material. Default: 0.", read=_damping)] = 0.0,
    swings: Annotated[int, flag("Number of cycles. Default: 8.", read=whole(1, 10_000, "8"))] = 8,
    mu: flags.Mu = None,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Let a beam vibrate freely: frequency, decay, damping of every cycle."""
    common.check(beam)
    described = settled(common.beam(beam, mu))

    from squama.dynamics.doors import vibrate

    with flags.laid(_LAID):
        data = vibrate(described, release=release, impulse=impulse, damping=damping, swings=swings, **vars(swinging))
    written = output.write(common, lambda: data, "vibration_figure")
    record = output.record(described, data, _KEYS, figures="", turns="turn", cycles="cycle", record="point")
    return output.report(common.json, beam, written, record, _summary(described, data).shown(full=full))


def _summary(beam: Beam, data: xr.Dataset) -> Summary:
    """Return the summary: damping and frequency of the first and the last cycle, whether the beam jams."""
    attrs = data.attrs
    angle = LOADS[attrs["load"]].angle
    y, zeta, period = (data[name].values for name in (f"{angle}_turn", "zeta_cycle", "period"))
    engaged, jams = float(data[f"{angle}_e"]), data["end"].item() == "jams"
    by, most = _angles_of(beam, attrs)
    if jams:
        last, rest = (turned(float(v), by) for v in (y[-1], data[f"{angle}_rest"]))
        verdict = f"it jams: let go at {last} it stays at {rest}"
    else:
        verdict = f"{figure(1 / period[0], 'Hz')}, damping ratio {figure(zeta[0])} in the first of {zeta.size} cycles"
    below = "friction damps beyond engagement only: below it the beam rings on unless its material damps (--damping)"
    rubs = float(data["mu"]) and math.isfinite(engaged) and not attrs["damping"] and not jams
    figures = [
        ("swings from", f"{turned(float(y[0]), by)}{most}" if y.size else ""),
        ("after the last cycle", turned(float(y[-1]), by) if not jams and y.size > 1 else ""),
        ("damping ratio, last cycle", figure(zeta[-1]) if zeta.size > 1 else ""),
        ("frequency before contact", figure(float(data["f_0"]), "Hz")),
        ("scales touch", touching(engaged, by)),
        ("friction", f"mu = {float(data['mu']):g}"),
        ("model", _modelled(beam, attrs)),
    ]
    return Summary(verdict, figures, [below] if rubs else [], attrs["warnings"], _cycles(by, data))


def _angles_of(beam: Beam, attrs: Mapping[str, Any]) -> tuple[Beam, str]:
    """Return a beam by which angles are shown, per pitch in a mode, and words for the place of a mode's angle."""
    if attrs["mode"] == UNIFORM:
        return beam, ""
    return beam.replace(scales=None, ends=None), ", where it bends most without contact"


def _modelled(beam: Beam, attrs: Mapping[str, Any]) -> str:
    """Return the model of a vibration as text."""
    known = modelled(beam, attrs)
    return known if attrs.get("ends") == attrs["mode"] else f"{known}; {attrs['mode']}"


def _cycles(beam: Beam, data: xr.Dataset) -> Shown:
    """Yield a table with a row per cycle."""
    angle = LOADS[data.attrs["load"]].angle
    columns = ("t_turn", f"{angle}_turn", "U_turn", "zeta_cycle", "period")
    t, y, U, zeta, period = (data[name].values for name in columns)
    n = min(zeta.size, SHOWN)
    peaks, troughs = slice(0, 2 * n, 2), slice(1, 2 * n, 2)
    if n:
        factor, unit = degrees(beam)
        size, joule = joules(float(U.max()))
        cells = {
            "at, s": t[peaks],
            f"peak, {unit}": factor * y[peaks],
            f"trough, {unit}": factor * y[troughs],
            f"energy, {joule}": size * U[peaks],
            "damping ratio": zeta[:n].round(9),
            "frequency, Hz": 1 / period[:n],
        }
        rows = enumerate(zip(*cells.values(), strict=True), 1)
        yield output.table(("cycle", *cells), ([str(i), *map(number, row)] for i, row in rows))
    if zeta.size > SHOWN:
        yield f"the first {SHOWN} of {zeta.size} cycles"
    yield "damping ratio: ln of the elastic energies at two peaks over 4 pi; it depends on the amplitude"


def shake(
    beam: flags.BeamFile,
    /,
    *,
    lowest: Annotated[str, flag('Lowest frequency, e.g. "1 Hz".')],
    highest: Annotated[str, flag('Highest frequency, e.g. "5 Hz".')],
    static: Annotated[str | None, flag(_STATIC)] = None,
    torque: Annotated[str | None, flag('Amplitude of the torque, instead of --static: "0.1 N m".')] = None,
    swinging: Swinging = SWINGING,
    damping: Annotated[float, flag("Damping ratio of the material. Default: 0.01.", read=_damping)] = 0.01,
    points: Annotated[int, flag("Number of frequencies. Default: 25.", read=whole(2, 1000, "25"))] = 25,
    mu: flags.Mu = None,
    full: flags.Full = False,
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
    return output.report(common.json, beam, written, record, _shaken(described, data).shown(full=full))


def _table(data: xr.Dataset) -> xr.Dataset:
    """Return steady states as a table over the frequency, with columns for upward and downward sweeps."""
    both = [name for name in data.data_vars if data[name].dims == ("way", "frequency")]
    ways = {f"{name}_{way}": data[name].sel(way=way, drop=True) for name in both for way in ("up", "down")}
    return data.drop_dims("way").assign(ways)


def _shaken(beam: Beam, data: xr.Dataset) -> Summary:
    """Return the summary: the largest amplitude and its frequency, frequencies with different states up and down."""
    import numpy as np

    kind, attrs = LOADS[data.attrs["load"]], data.attrs
    sizes = np.abs(np.stack([data[f"{kind.angle}_{end}"].values for end in ("high", "low")])).max(axis=0)
    way, i = np.unravel_index(int(sizes.argmax()), sizes.shape)
    top, hertz = float(sizes[way, i]), data["frequency"].values
    by, most = _angles_of(beam, attrs)
    verdict = f"largest {kind.verb} {turned(top, by)}{most}, at {figure(hertz[i], 'Hz')}"
    if i in (0, hertz.size - 1):
        verdict += f", the {'highest' if i else 'lowest'} frequency asked"
    up, down = (sizes[list(data["way"].values).index(name)] for name in ("up", "down"))
    apart = hertz[np.abs(up - down) > _APART * np.maximum(up, down)]
    jumps = f"from {figure(apart[0])} to {figure(apart[-1], 'Hz')}" if apart.size else "nowhere"
    one = data.isel(way=int(way), frequency=int(i))
    rubs = bool(one["settled"]) and float(one["W_fed"]) > 0
    taken = f"; it takes {percent(float(one['W_rubbed'] / one['W_fed']))} of the work there" if rubs else ""
    engaged, loose = float(data[f"{kind.angle}_e"]), int((~data["settled"].values).sum())
    figures = [
        ("states up and down differ", jumps),
        ("not periodic", f"{loose} of {sizes.size} states; their last periods count" if loose else ""),
        ("frequency before contact", figure(float(data["f_0"]), "Hz")),
        ("scales touch", touching(engaged, by)),
        ("damping ratio, material", figure(float(attrs["damping"]))),
        ("friction", f"mu = {float(data['mu']):g}{taken}"),
        ("model", _modelled(beam, attrs)),
    ]
    return Summary(verdict, figures, (), attrs["warnings"], _states(by, data))


def _states(beam: Beam, data: xr.Dataset) -> Shown:
    """Yield a table with a row per frequency, upwards and downwards."""
    kind = LOADS[data.attrs["load"]]
    factor, unit = degrees(beam)
    head, columns = ["Hz"], [map(number, data["frequency"].values)]
    for way in ("up", "down"):
        one = data.sel(way=way)
        high, low = (map(number, factor * one[f"{kind.angle}_{end}"].values) for end in ("high", "low"))
        loose = ["" if settled else " *" for settled in one["settled"].values]
        share = 100 * (one["W_rubbed"] / one["W_fed"]).where(one["settled"])
        head += [f"{way}: largest, {unit}", "smallest", "friction, %"]
        columns += [high, map(str.__add__, low, loose), map(number, share.values)]
    yield output.table(head, zip(*columns, strict=True))
    yield "friction: its share of the torque's work"
    if not data["settled"].values.all():
        yield "*: not periodic with the torque; largest and smallest of its last periods"
