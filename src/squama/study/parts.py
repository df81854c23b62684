"""A finite part under load: finite elements and :func:`squama.load` side by side, for `squama verify --load`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama._version import __version__
from squama.beam import matrixfile
from squama.contacts.system import PHI, PSI
from squama.errors import refuse
from squama.fe import runs
from squama.fe.geometry import geometry
from squama.fe.loaded import BLANK, Lead, length, make_loaded
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import response
from squama.fe.sizes import MeshSize
from squama.io import datasets, files
from squama.joints import law
from squama.part import door, loading
from squama.part.definition import Part
from squama.symbols import SYMBOLS
from squama.types import Array
from squama.units import Dimension, shown

if TYPE_CHECKING:
    import xarray as xr

    from squama.beam.design import Beam

MOST = 25
"""Largest number of scales of a part of finite elements."""
IMPOSED = '"10 mm up at tip", "60 deg bend", "90 deg twist"'
"""Examples of loads that finite elements can impose."""
_POINTS = 100
_BLANK_LENGTH = 0.01
"""Length of the scales of blank pitches, so short that they cannot touch, in pitches."""
_NAMES = {True: ("turn", "moment"), False: ("travel", "F")}
"""Names of deformation and load in :func:`squama.load`, by whether the load is a turn."""


class Led(NamedTuple):
    """Imposed deformation of a part of finite elements: its ``size`` (m or rad), the end of the ``way``, its text."""

    lead: Lead
    size: float
    way: float
    text: str
    support: str


def led(load: str, support: str | None, beam: Beam, scales: int) -> Led:
    """Read the imposed deformation of a part's far end; refuse a text that is none elements can impose."""
    pitches = length(geometry(beam), scales)
    found = loading.loads(load, beam, pitches)
    one, held = found[0], loading.support(support or "clamped", beam, pitches)
    if not one.given:
        refuse("load", shown(load), "is a force or a moment; a part of elements is led", f"write e.g. {IMPOSED}")
    at, force = one.tie.forces[0] if one.tie.forces else (float(pitches), None)
    if at != pitches:
        refuse("load", shown(load), "is not at the tip; a part of elements is led there", 'write "at tip"')
    turn = "twist" if one.turns == PHI else "bend" if one.turns == PSI else ""
    if held.word == "simple" or (held.word == "gripped" and turn != "twist"):
        refuse("support", shown(held.word), "of a part of elements: clamped, or gripped with a twist", "write clamped")
    lead = Lead(force, turn, coaxial=held.word == "gripped")
    size = one.size / (beam.pitch if one.measures is Dimension.LENGTH else 1.0)
    return Led(lead, one.size, size / lead.per_way(pitches), load, held.word)


@dataclass(frozen=True)
class Closed(Part):
    """A part with cells of plain bar where elements have it: ``before`` the scales at the root, ``behind`` them."""

    before: int = 0
    behind: int = 0

    @classmethod
    def of(cls, beam: Beam, scales: int, load: str, support: str, plain: int, blank: int = BLANK) -> Closed:
        """Return the part of N scales with ``blank`` pitches beside them whose scales are too short to touch."""
        part = cls(beam, load, support, before=plain - plain // 2, behind=plain // 2)
        lengths = np.full(scales + 2 * blank + plain, _BLANK_LENGTH * beam.pitch)
        first = part.before + blank
        lengths[first : first + scales] = beam.scale.length
        return replace(part, along={"scale.length": [f"{length!r} m" for length in lengths.tolist()]})

    def graded(self, n: int) -> list[Beam]:
        """Return the beam of each of n cells; a plain one has a scale that is held and stiffens nothing."""
        g = geometry(self.beam)
        K = np.diag([*np.ones(6), *law.bare(law.Shape(*g[:3], *g[4:]))])
        bare = joint_of(self.beam, K)
        plain = [*range(self.before), *range(n - self.behind, n)]
        return [one.replace(joint=bare) if i in plain else one for i, one in enumerate(super().graded(n))]


def joint_of(beam: Beam, K: Array) -> dict[str, object]:
    """Return the joint of a beam whose stiffness is a matrix (7, 7) or (9, 9), E = 1, d = 1."""
    return {"matrix": matrixfile.stored(beam, K), "stiffness": None, "inclusion_factor": None}


class Run(NamedTuple):
    """Settings of a part of finite elements; ``increment``: largest step; ``ideal``: thin, rigid scales."""

    scales: int
    led: Led
    mu: float
    mesh: MeshSize
    increment: float
    ideal: bool


def verify(
    beam: Beam, folder: Path, run: Run, progress: runs.Listener | None, announce: Callable[[str], None]
) -> tuple[xr.Dataset, xr.Dataset, list[Path], float]:
    """Load a part by elements and by :func:`squama.load`: table, elements, files, deformation of the first contact."""
    with files.folder_for(folder) as place:
        data = elements(beam, run, restart=place / "part.npz", progress=progress, announce=announce)
    written = [datasets.save(data, place / "part.nc")]
    announce("the same part by squama.load")
    table = beside(beam, data, run)
    written.append(datasets.save(table.reset_coords(), place / "part.csv"))
    return table, data, written, min(float(table["touch_elements"]), float(table["touch"].min()))


def elements(
    beam: Beam,
    run: Run,
    *,
    restart: Path | None = None,
    progress: runs.Listener | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> xr.Dataset:
    """Load a part of N scales by finite elements: clamped on average at one end, deformation imposed at the other.

    Each end has one more pitch of bar without exposed scales, and plain bar up to a section across it, see
    :mod:`squama.fe.loaded`. Returns along ``point`` the deformation ``travel`` (m) and force ``F`` (N), or ``turn``
    (rad) and ``moment`` (N m); ``U_el``, ``W_fr``, ``W`` (J); along ``scale`` too: ``theta`` (rad), ``N`` and ``f`` (N)
    on the next scale, ``contact`` (kind of contact). Attributes and errors as of :func:`squama.cell`.
    """
    import xarray as xr

    scales, asked, mu = run.scales, run.led, run.mu
    shape, sizes = geometry(beam), runs.mesh_sizes(run.mesh)
    exposed, plates = (None, "thin, rigid") if run.ideal else runs.exposed_part(beam, shape)
    pitch = pitch_mesh(shape, *sizes)
    walk = make_loaded(pitch, shape, mu, scales, asked.lead, exposed)
    key: dict[str, object] = {
        "part": [scales, asked.text, asked.support],
        "geometry": list(shape),
        "mu": mu,
        "mesh": list(sizes),
        "plates": plates,
    }
    count = runs.count(walk)
    announce(f"a part of {scales} scales, {count} elements, {walk.body.start().size} unknowns")
    ended = runs.follow(walk, asked.way, run.increment, restart, key, progress)
    columns = {name: np.array(values) for name, values in walk.columns.items()}
    d, E = beam.pitch, beam.substrate.youngs_modulus
    by, name = _NAMES[bool(asked.lead.turn)]
    moment = E * d**3
    turned = bool(asked.lead.turn)
    imposed = {"long_name": "deformation that is imposed", "units": "rad" if turned else "m"}
    carried = {"long_name": "load", "units": "N m" if turned else "N"}
    along = {
        by: (columns["way"] * asked.size / asked.way, imposed),
        name: (columns["load"] * (moment if turned else E * d**2), carried),
        **{k: (columns[k] * moment, {**SYMBOLS[k].attrs, "units": "J"}) for k in ("U_el", "W_fr", "W")},
        "theta": (columns["theta"], SYMBOLS["theta"].attrs),
        **{k: (columns[k] * E * d**2, SYMBOLS[k].attrs) for k in ("N", "f")},
        "contact": (columns["contact"], {"long_name": "what touches"}),
    }
    W, U, F = (columns[k][-1] for k in ("W", "U_el", "W_fr"))
    return xr.Dataset(
        {k: (("point", "scale")[: v.ndim], v, attrs) for k, (v, attrs) in along.items()},
        coords={"scale": np.arange(1, scales + 1), "mu": ((), mu, SYMBOLS["mu"].attrs)},
        attrs={
            "title": f"a part of {scales} scales under load, finite elements",
            "load": asked.text,
            "support": asked.support,
            "plates": plates,
            "mesh": f"{count} quadratic tetrahedra, {sizes[0]:g} and {sizes[1]:g} pitches",
            "reached": int(ended.reached),
            "sentence": ended.sentence,
            "energy_error": float((W - U - F) / W) if W else 0.0,
            "beam": beam.replace(scales=scales).to_toml(),
            "squama_version": __version__,
        },
    )


def model(beam: Beam, run: Run) -> xr.Dataset:
    """Return the part that :func:`elements` computes by :func:`squama.load`, with its plain bar."""
    shape, asked = geometry(beam), run.led
    part = Closed.of(beam, run.scales, asked.text, asked.support, shape.square.pitches)
    return door.load(part, scales=length(shape, run.scales), mu=run.mu, ideal=run.ideal, points=_POINTS)


def beside(beam: Beam, data: xr.Dataset, run: Run) -> xr.Dataset:
    """Compare :func:`squama.load` with finite elements of the same part.

    Returns along ``point``: the deformation, ``elements`` (the load by finite elements); along ``model`` too: ``load``
    and ``off`` = load/elements - 1, for the beam's own joint ("law") and the joint stiffness of the elements' mesh
    ("mesh"). ``touch`` by model and ``touch_elements``: deformation (m or rad) at which scales first touch.
    """
    import xarray as xr

    shape, asked = geometry(beam), run.led
    K = response(pitch_mesh(shape, *runs.mesh_sizes(run.mesh)), shape).K
    own = beam.replace(joint=joint_of(beam, K))
    by, name = _NAMES[bool(asked.lead.turn)]
    x, F = (np.asarray(data[key].values, float) for key in (by, name))
    loads, touch = [], []
    for one in (beam, own):
        r = model(one, run)
        at = np.append(0.0, r[by].values)
        # (the last point is reached but for rounding)
        loads.append(np.interp(x * (1 - 1e-9), at, np.append(0.0, r[name].values), right=np.nan))
        share = float(r["share_e"])
        touch.append(share * asked.size if math.isfinite(share) else math.inf)
    load = np.array(loads)
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.where(x > 0, load / F - 1, np.nan)
    kind = data[by].attrs
    table = xr.Dataset(
        {
            "elements": ("point", F, data[name].attrs),
            "load": (("model", "point"), load, data[name].attrs),
            "off": (("model", "point"), off, {"long_name": "load over the elements', less 1", "units": "1"}),
            "touch": ("model", np.array(touch), {**kind, "long_name": "deformation at which scales touch"}),
            "touch_elements": ((), touched(data, by), {**kind, "long_name": "the same of the elements"}),
        },
        coords={"model": np.array(["law", "mesh"]), by: ("point", x, kind)},
        attrs={
            "title": f"{run.scales} scales, {asked.text}, {asked.support}, mu = {run.mu:g}: model and elements",
            "load": asked.text,
            "beam": data.attrs["beam"],
            "warnings": "",
        },
    )
    table.attrs["verdict"] = verdict(table, by)
    return table


def touched(data: xr.Dataset, by: str) -> float:
    """Return the deformation (m or rad) ``by`` at which the first scales touch, as a magnitude; inf for none."""
    force = np.nan_to_num(np.asarray(data["N"].transpose("point", ...).values, float))
    pressed = force.reshape(data.sizes["point"], -1).max(axis=1) > 0
    return float(np.abs(data[by].values[pressed]).min(initial=math.inf))


def verdict(table: xr.Dataset, by: str) -> str:
    """Return a sentence: largest deviation of the beam's own joint from the elements, before and after contact."""
    factor, unit = (math.degrees(1.0), "deg") if by == "turn" else (1e3, "mm")
    x, off = table[by].values, table["off"].values[0]
    ours, theirs = float(table["touch"][0]), float(table["touch_elements"])
    first = min(ours, theirs)
    last = f"{factor * x[-1]:.3g} {unit}"
    if not first < math.inf:
        return f"led to {last}, no contact up to here: nothing was tested; give a larger deformation"
    parts = []
    for words, there in (("before contact", (x > 0) & (x < first)), ("beyond it", x >= max(ours, theirs))):
        known = off[there & np.isfinite(off)]
        if known.size:
            parts.append(f"{100 * known[np.abs(known).argmax()]:+.1f} % at most {words}")
    at = [f"{factor * touch:.3g} {unit}" if touch < math.inf else "nowhere" for touch in (ours, theirs)]
    return f"scales touch at {at[0]} (elements: {at[1]}); load against elements, up to {last}: {', '.join(parts)}"
