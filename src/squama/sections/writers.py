"""Tables of a section's law as files: CSV, npz, and sections of Abaqus, Ansys and LS-DYNA; SI units.

Sources of the formats: Abaqus Keywords Reference (``*BEAM GENERAL SECTION``, ``*AXIAL``, ``*M1``, ``*M2``, ``*TORQUE``:
load, then strain); Ansys Mechanical APDL, Structural Analysis Guide, "Using Nonlinear General Beam Sections"
(``SECTYPE,,GENB``; BSAX, BSM1, BSM2, BSTQ, BSS1, BSS2: strain, then load; at most 20 points); LS-DYNA Keyword Manual,
``*MAT_GENERAL_NONLINEAR_6DOF_DISCRETE_BEAM`` (119), which Radioss reads, too.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama.beam import mass
from squama.errors import refuse
from squama.io import files
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

    from squama.beam.design import Beam

POINTS = 20
"""Largest number of points of a load in an Ansys section."""
_LOADS = {"M": "kappa", "T": "Phi"}


class Format(NamedTuple):
    """A file format: extension, prefix of comment lines, function from a table to lines of text.

    ``alone``: only for tables of single loads; ``smooth``: only for tables without friction.
    """

    extension: str
    comment: str
    text: Callable[[xr.Dataset], Iterable[str]]
    alone: bool = False
    smooth: bool = False


class Bar(NamedTuple):
    """Linear properties of a section: stiffness in tension and in both shears (N), in lateral bend (N m^2); mass, kg/m.

    Tension and shear are those of the bar without scales.
    """

    axial: float
    shear: float
    lateral: float
    mass: float

    @classmethod
    def of(cls, data: xr.Dataset) -> Bar:
        """Return the properties of a table's beam; the mass is 0 where a density is not known."""
        beam = _beam(data)
        bar, scale = beam.substrate, beam.scale.density
        area, lateral = bar.width * bar.thickness, float(data.attrs["lateral_rigidity"])
        weight = 0.0 if beam.density is None or scale is None else mass.of(beam, beam.density, scale).mass
        return cls(bar.youngs_modulus * area, 5 / 6 * beam.G_B * area, lateral, weight)


def write(data: xr.Dataset, place: str | Path, format: str | None = None) -> Path:  # noqa: A002 - as in Path and NumPy
    """Write a table to a file.

    Parameters
    ----------
    data
        The table's dataset; ``abaqus``, ``ansys`` and ``dyna`` need single loads (``uncoupled=True``), the first two
        without friction.
    place
        The file; an existing one is replaced once the new one is complete.
    format
        A key of :data:`FORMATS`; by the extension if not given (.csv, .npz, .inp, .mac, .k).

    Returns
    -------
    Path
        The file as given.

    Raises
    ------
    InputError
        The format is not known, cannot hold the table, or the place cannot take the file.
    """
    files.place(place, "law.csv")
    known = {one.extension: name for name, one in FORMATS.items()}
    name = known.get(Path(place).suffix.lower(), "") if format is None else format
    if name not in FORMATS:
        refuse("format", files.label(str(format or place)), f"must be one of {', '.join(FORMATS)}", "name one")
    check(name, alone="w" not in data, mu=float(data.attrs["mu"]))
    if name == "npz":
        arrays = {str(key): v.values for key, v in data.variables.items()}
        about = np.array([*_about(data)])
        return files.atomic_write(place, lambda at: _npz(at, arrays | {"about": about}))
    return files.atomic_write(place, lambda at: at.write_text(text(data, name), encoding="utf-8"))


def text(data: xr.Dataset, name: str) -> str:
    """Return a table as the text of a file, in a format ``name`` that is text."""
    made = FORMATS[name]
    return "\n".join([*(f"{made.comment} {line}" for line in _about(data)), *made.text(data), ""])


def check(name: str, *, alone: bool, mu: float) -> None:
    """Refuse a format that cannot hold a table of single loads (``alone``) or of the plane, or with friction ``mu``."""
    made = FORMATS[name]
    if made.alone and not alone:
        refuse("format", f'"{name}"', "takes each load alone, not a plane", "write uncoupled=True")
    if made.smooth and mu:
        refuse("mu", f"{mu:g}", f'must be 0 in a section of format "{name}", which knows no unloading', 'take "dyna"')


def _npz(at: Path, arrays: dict[str, Array]) -> None:
    """Write arrays to a new file of any extension."""
    with at.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def _beam(data: xr.Dataset) -> Beam:
    """Return the beam of a table."""
    from squama.beam.design import Beam

    return Beam.from_toml_text(data.attrs["beam"])


def _about(data: xr.Dataset) -> Iterator[str]:
    """Yield the lines on beam, model and range of a table that every file begins with."""
    attrs, enough = data.attrs, data.attrs["scales_for_10_percent"]
    many = f"{enough:.0f} scales" if math.isfinite(enough) else "a number of scales that is not known"
    kind = "bend and twist coupled by one potential w" if "w" in data else "uncoupled: each load alone, the other's "
    kind += "" if "w" in data else "strain free (no moment or torque) unless it is held"
    yield f"squama {attrs['squama_version']}: law of a scale-covered beam's section, SI units (rad/m, N m, N, J/m)"
    yield f"endless beam; good to 10 % from {many} on, with free ends; {kind}; mu = {attrs['mu']:g}"
    yield f"hold: {attrs['hold']}; bend is positive towards the scaled face"
    yield f"strain limit: {attrs['strain_limit']:.6g} rad/m, up to which the model was compared with finite elements"
    for name, load in (("end_M", "bend"), ("end_T", "twist")):
        for sense, word in zip("-+", data[name].values if name in data else (), strict=False):
            if word:
                yield f"{load} in sense {sense} ends before the table: {word}"
    for line in attrs["warnings"].splitlines():
        yield f"warning: {line}"


def _csv(data: xr.Dataset) -> Iterator[str]:
    """Yield a header and a row for each node, or for each point of each branch."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    if "w" in data:
        names = ("w", "M", "T", "dM_dkappa", "dM_dPhi", "dT_dPhi")
        rows.writerow(["kappa (rad/m)", "Phi (rad/m)", *(f"{n} ({data[n].attrs['units']})" for n in names), "state"])
        for i, kappa in enumerate(data.kappa.values):
            for j, Phi in enumerate(data.Phi.values):
                cells = [repr(float(data[n].values[i, j])) for n in names]
                rows.writerow([repr(float(kappa)), repr(float(Phi)), *cells, data.state.values[i, j]])
    else:
        rows.writerow(["load", "branch", "strain (rad/m)", "moment (N m)"])
        for name, (strain, branches) in _curves(data).items():
            for branch, load in zip(data.branch.values, branches, strict=True):
                rows.writerows([_LOADS[name], branch, repr(x), repr(y)] for x, y in zip(strain, load, strict=True))
    yield from text.getvalue().splitlines()


def _curves(data: xr.Dataset) -> dict[str, tuple[list[float], list[list[float]]]]:
    """Return strains and both branches of each load by its name, at points where both are known."""
    found = {}
    for name, strain in _LOADS.items():
        if name in data:
            loads, at = data[name].values, data[strain].values
            known = np.isfinite(loads).all(axis=0)
            found[name] = at[known].tolist(), [v[known].tolist() for v in loads]
    return found


def _section(data: xr.Dataset, name: str) -> tuple[list[float], list[float]]:
    """Return strains and loads of the loading branch; a straight line for a load that the table does not have."""
    curves = _curves(data)
    if name in curves:
        strains, (loading, _) = curves[name]
        if len(strains) < 2:
            refuse("format", "", f"the branch of {name} has fewer than two points with a state", "take a shorter range")
        if 0.0 not in strains and strains[0] * strains[-1] < 0:
            i = int(np.searchsorted(strains, 0.0))
            strains, loading = [*strains[:i], 0.0, *strains[i:]], [*loading[:i], 0.0, *loading[i:]]
        return strains, loading
    bare = float(data.attrs["bare_" + name])
    return [-1.0, 0.0, 1.0], [-bare, 0.0, bare]


def _abaqus(data: xr.Dataset) -> Iterator[str]:
    """Yield the lines of a section; the second data line, the direction of the 1-axis, is left to its default."""
    beam, bar = _beam(data), Bar.of(data)
    b, t = beam.substrate.width, beam.substrate.thickness
    across, up = b * t**3 / 12, t * b**3 / 12
    density = f", DENSITY={bar.mass / (b * t):.9g}" if bar.mass else ""
    yield "** *M1 is the bend across the scales: turn the section so that positive M1 bends towards them"
    yield "** tension and shear are the bar's alone; lateral bend (*M2) is linear in the model, too"
    yield "** DENSITY, where it is given, is the mass per length over the area"
    yield f"*BEAM GENERAL SECTION, ELSET=SQUAMA, SECTION=NONLINEAR GENERAL{density}"
    yield f"{b * t:.9g}, {across:.9g}, 0., {up:.9g}, {beam.J:.9g}"
    yield ""
    yield from ("*AXIAL, LINEAR", f"{bar.axial:.9g}", "*M1, ELASTIC")
    yield from (f"{y:.9g}, {x:.9g}" for x, y in zip(*_section(data, "M"), strict=True))
    yield from ("*M2, LINEAR", f"{bar.lateral:.9g}", "*TORQUE, ELASTIC")
    yield from (f"{y:.9g}, {x:.9g}" for x, y in zip(*_section(data, "T"), strict=True))


def _ansys(data: xr.Dataset) -> Iterator[str]:
    """Yield the lines of a section: strains above 0 only, which Ansys mirrors to negative ones."""
    bar = Bar.of(data)
    yield "! for BEAM188 and BEAM189; BSM1 is the bend across the scales, positive towards them"
    yield f"! strains above 0 alone, {POINTS} points at most; tension and shear are the bar's alone"
    yield "! Ansys' guide asks for slopes below the first one; scales stiffen: try the section on one element first"
    yield "SECTYPE,1,GENB,ELASTIC,SQUAMA"
    yield f"BSAX,1,{bar.axial:.9g}"
    for command, name in (("BSM1", "M"), ("BSTQ", "T")):
        strains, loads = (np.array(v) for v in _section(data, name))
        above = strains > 0
        if not above.any():
            refuse("format", '"ansys"', f"has no strain above 0 of {name}", "let the table reach above 0")
        x, y = _thinned(np.append(0.0, strains[above]), np.append(0.0, loads[above]), POINTS + 1)
        yield from (f"{command},{a:.9g},{b:.9g}" for a, b in zip(x[1:], y[1:], strict=True))
    yield f"BSM2,1,{bar.lateral:.9g}"
    yield from (f"BSS1,1,{bar.shear:.9g}", f"BSS2,1,{bar.shear:.9g}")
    if bar.mass:
        yield f"BSMD,{bar.mass:.9g}"


def _thinned(x: Array, y: Array, most: int) -> tuple[Array, Array]:
    """Return at most ``most`` points of a curve, added in turn where the polygon so far is farthest off."""
    kept = [0, len(x) - 1]
    while len(kept) < min(most, len(x)):
        off = np.abs(y - np.interp(x, x[kept], y[kept]))
        off[kept] = -1.0
        kept = sorted([*kept, int(off.argmax())])
    return x[kept], y[kept]


def _dyna(data: xr.Dataset) -> Iterator[str]:
    """Yield a material of discrete beams, each one pitch long, with its curves of loading and unloading."""
    d, bar, mu = float(data.attrs["pitch"]), Bar.of(data), float(data.attrs["mu"])
    line = {"TR": bar.axial / d, "TS": bar.shear / d, "TT": bar.shear / d, "RT": bar.lateral / d}
    curves = {name: ([-1.0, 0.0, 1.0], [-k, 0.0, k]) for name, k in line.items()}
    back = dict(curves)
    for way, name in (("RR", "T"), ("RS", "M")):
        x, y = _section(data, name)
        curves[way] = back[way] = [d * v for v in x], y
        if mu and name in data:
            strains, (_, unloading) = _curves(data)[name]
            back[way] = [d * v for v in strains], unloading
    order = ("TR", "TS", "TT", "RR", "RS", "RT")
    number = {way: 119001 + i for i, way in enumerate(order)}
    other = {way: 119011 + i if back[way] is not curves[way] else number[way] for i, way in enumerate(order)}
    weight = bar.mass * d

    def card(*values: float | int | str) -> str:
        return "".join(f"{v:>10.4g}" if isinstance(v, float) else f"{v:>10}" for v in values)

    yield f"$ one element (*SECTION_BEAM, ELFORM = 6) for each pitch of {d:.9g} m; curves are over angles in rad"
    yield "$ r along the beam, s across the scales (bend towards them is positive), t upwards"
    yield "$ unloading is that from the end of the table; the manual asks it to be no flatter than loading"
    yield f"$ RO is 1: give SECTION_BEAM a volume of the element's mass in kg{f', {weight:.6g}' if weight else ''}"
    yield "*MAT_GENERAL_NONLINEAR_6DOF_DISCRETE_BEAM"
    yield "$#     mid        ro        kt        kr     iunld    offset     dampf     iflag"
    yield card(119, 1.0, 0.0, 0.0, 1 if mu else 0, 0.0, 0.0, 0)
    yield "$#  lcidtr    lcidts    lcidtt    lcidrr    lcidrs    lcidrt"
    yield card(*(number[way] for way in order))
    yield card(*(other[way] for way in order))
    # no damping, no failure, no initial displacement
    yield from [card(*[0] * 6)] * 2
    yield from (card(*[0.0] * 7), card(*[0.0] * 6), card(*[0.0] * 6))
    for way in order:
        yield from _curve(number[way], *curves[way])
        if other[way] != number[way]:
            yield from _curve(other[way], *back[way])


def _curve(number: int, x: list[float], y: list[float]) -> Iterator[str]:
    """Yield the lines of a curve of LS-DYNA."""
    yield "*DEFINE_CURVE"
    yield f"{number:>10}"
    yield from (f"{a:>20.12g}{b:>20.12g}" for a, b in zip(x, y, strict=True))


FORMATS = {
    "csv": Format(".csv", "#", _csv),
    "npz": Format(".npz", "", _csv),
    "abaqus": Format(".inp", "**", _abaqus, alone=True, smooth=True),
    "ansys": Format(".mac", "!", _ansys, alone=True, smooth=True),
    "dyna": Format(".k", "$", _dyna, alone=True),
}
"""Formats by their names."""
