"""squama cell, verify and deck: finite elements of a beam, comparison of the models with them, an input deck."""

from __future__ import annotations

import math
import sys
from collections.abc import Hashable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama import units
from squama.cli import flags, output
from squama.cli.flags import flag, number, one_of, settled, whole
from squama.cli.output import Summary, percent
from squama.errors import refuse
from squama.fe.sizes import MESHES, MeshSize
from squama.interrupt import kept
from squama.io.files import label, table_place
from squama.people import apart_by, figure, per_pitch, tidy, turned

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.fe.deformed import Deformed
    from squama.study.verification import Verified

UNTESTED = 1
"""Exit status of a verification without contact."""
ROWS = 12
"""Number of twists in the printed table of differences."""
_size = number(1e-4, 10.0, "0.2,0.02")
_MESH = "Mesh: coarse, medium, fine, or sizes in pitches of the bulk and along the scale's edges, e.g. 0.2,0.02"


def _mesh(name: str, text: str) -> MeshSize:
    """Read the name of a mesh, or two element sizes."""
    for mesh in MESHES:
        if text == mesh:
            return mesh
    sizes = text.split(",")
    if len(sizes) != 2:
        refuse(name, f'"{text}"', f"must be {', '.join(MESHES)}, or two sizes in pitches such as 0.2,0.02")
    return _size.read(name, sizes[0]), _size.read(name, sizes[1])


_mesh_read = flags.Reader[MeshSize](_mesh, "medium")
_INCREMENT = "Largest increment of the twist, rad per pitch. Default: 0.01."
_ENDS = "Axial motion of the turned end of a finite beam: free or held. Default: free. The other end is fixed."
_LOAD = 'Deformation of a part of --scales scales, instead of --to: "10 mm up at tip", "60 deg bend", "90 deg twist".'
_SCALES = "Number of scales of a finite beam. Default: one pitch of an endless beam; allowed:"
_FOLDER = "Folder to write to. Default: verify_ and the file's name."
_FINITE = "Number of scales of the part, or of a finite beam to compute too,"
_FINITE_MESH = "Mesh of the part or finite beam (--mesh: that of one pitch). Default: coarse."
_SUPPORT = "Support of the part: clamped, or gripped with a twist. Default: clamped."
_PICTURE = "Picture of the deformed pitch with its strain (.png, .svg, .pdf); may be repeated."
_RESTART = "File written after every increment; a run continues from it if it exists."
_REACH = f"Twist at the end: {flags.TWISTS}. Default: the end of the hinge's curve, 0.3 rad/pitch at most."
_SIZE = "Size of the substrate's elements, in pitches. Default: 0.3."
_EDGE = "Size of elements along the embedded scales' edges, in pitches. Default: 0.08."
_SUBSTRATE = "Material of the substrate: neo-hookean or elastic. Default: neo-hookean."
_PROGRAM = "Program for the deck: calculix or abaqus. Default: calculix."


Ideal = Annotated[bool, Parameter(help="Thin, rigid scales, as in the paper. Default: thick and elastic.")]


@flags.group
class Run:
    """Settings of finite elements of a pitch: arguments of :func:`squama.cell`."""

    increment: Annotated[float, flag(_INCREMENT, read=number(1e-5, 0.1, "0.01"))] = 0.01
    mesh: Annotated[MeshSize, flag(f"{_MESH}. Default: medium.", read=_mesh_read)] = "medium"
    sense: flags.Sense = "+"
    hinged: Annotated[bool, Parameter(help="Block roll and yaw of the scales, as a hinge does.")] = False
    ideal: Ideal = False


@flags.group
class Deck:
    """Settings of an input deck: arguments of :func:`squama.fe.deck.model`."""

    size: Annotated[float, flag(_SIZE, read=number(0.01, 10, "0.3"))] = 0.3
    edge_size: Annotated[float, flag(_EDGE, read=number(1e-3, 10, "0.08"))] = 0.08
    increments: Annotated[int, flag("Number of increments. Default: 25.", read=whole(1, 10_000, "25"))] = 25
    material: Annotated[str, flag(_SUBSTRATE, read=one_of("neo-hookean", "elastic"))] = "neo-hookean"
    ideal: Ideal = False


RUN, DECK = Run(), Deck()


def announce(text: str) -> None:
    """Print the name of the next step on standard error."""
    print(text, file=sys.stderr, flush=True)


def cell(
    beam: flags.BeamFile,
    /,
    *,
    to: Annotated[str, flag(f"Twist at the end: {flags.TWISTS}.")],
    mu: flags.Mu = None,
    run: Run = RUN,
    scales: Annotated[int | None, flags.scales(200, _SCALES)] = None,
    ends: Annotated[str, flag(_ENDS, read=one_of("free", "held"))] = "free",
    vtk: Annotated[flags.File | None, flag("File (.vtu) of the deformed pitch for ParaView.")] = None,
    picture: Annotated[tuple[flags.File, ...], flag(_PICTURE)] = (),
    full: flags.Full = False,
    restart: Annotated[flags.File | None, flag(_RESTART)] = None,
    quiet: flags.Quiet = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Twist one pitch (helical periodicity) or a finite beam by finite elements; needs the extra fe."""
    common.check(beam, plots=picture)
    flags.check_places([(vtk, (".vtu",))])
    if scales is None and ends != "free" and "--scales" not in flags.problems().flags:
        flags.problems().add("--ends", "", "is for finite beams", "give --scales too")
    if scales is not None and (vtk is not None or picture):
        remedy = "leave them out, or leave out --scales"
        flags.problems().add("--vtk and --picture", "", "show one endless pitch", remedy)
    found = common.beam(beam, mu, scales=scales)
    twist = flags.asked("--to", to, found)
    described = settled(found)

    from squama.fe import runs

    states: list[Deformed] = []
    how: dict[str, Any] = {"scales": scales, "ends": ends, "restart": restart, **vars(run)}
    how |= {} if quiet else {"progress": runs.print_progress, "announce": announce}
    with kept(label(beam), f"; {label(restart)} holds what is done" if restart else ""):
        last = states.append if vtk is not None or picture else None
        data = runs.cell(described, to=settled(twist), last=last, **how)
    written = output.write(common, lambda: data, "elements_figure" if scales is None else "finite_figure")
    for state in states:
        if vtk is not None:
            from squama.fe.deformed import write_vtu

            written.append(write_vtu(state, vtk))
        written += output.draw(picture, "deformed_figure", state)
    return output.report(common.json, beam, written, _record(data), _solved(described, data).shown(full=full))


def _record(data: xr.Dataset) -> dict[str, object]:
    from squama.beam.design import Beam

    # "ends" of other records are the loads of the ends, here the axial motion of the turned end
    return {
        **{"axial" if key == "ends" else str(key): value for key, value in data.attrs.items()},
        "warnings": data.attrs["warnings"].splitlines(),
        "beam": Beam.from_toml_text(data.attrs["beam"], source="elements").model_dump(),
        "mu": float(data["mu"]),
        "curve": output.part(data, "point"),
        "each": output.part(data, "point", "scale"),
        "units": output.units(data.data_vars.items()),
    }


def _solved(beam: Beam, data: xr.Dataset) -> Summary:
    """Return the summary of a run: final torque and inclination, contact, energy balance."""
    last, n, attrs = data.isel(point=-1), data.sizes.get("scale", 0), data.attrs
    beam = beam.replace(scales=n) if n else beam
    theta = [f"{units.number(tidy(math.degrees(v)))} deg" for v in last["theta"].values.ravel()]
    verdict = f"{units.moment(float(last['T']))} at {turned(float(last['phi']), beam)}"
    met = [(phi, words) for phi, words in zip(data["phi"].values, data["contact"].values, strict=True) if words]
    N, f = (figure(float(last[name].max()), "N") for name in ("N", "f"))
    long = "; the turned end is held along the axis" if attrs.get("ends") == "held" else ""
    blocked = "; roll and yaw of the scales are blocked" if "blocked" in attrs["joint"] else ""
    figures = [
        ("inclination, first to last" if n else "inclination", f"{theta[0]}, {theta[-1]}" if n else theta[0]),
        ("scales touch", f"at {turned(float(met[0][0]), beam)}, or one increment before" if met else "never"),
        ("contact", f"{met[-1][1]}" if met and not n else ""),
        ("largest contact force" if n else "contact force", f"{N}; friction {f}" if met else ""),
        ("end of the run", str(attrs["sentence"])),
        ("energy balance", f"{percent(abs(attrs['energy_error']))} of the work is not accounted for"),
        ("friction", f"mu = {float(data['mu']):g}{'; sense -' if attrs['sense'] == '-' else ''}"),
        ("model", f"finite elements; {beam.extent if n else 'one pitch of an endless beam'}{long}{blocked}"),
        ("mesh", str(attrs["mesh"])),
    ]
    return Summary(verdict, figures, (), attrs["warnings"], _run_in_full(beam, data))


def _run_in_full(beam: Beam, data: xr.Dataset) -> Iterable[str | Table]:
    """Yield the model of the scales, each change of contact with its twist, and a table of a finite beam's scales."""
    yield f"scales {data.attrs['plates']}"
    before = ""
    for phi, words in zip(data["phi"].values, data["contact"].values, strict=True):
        if words != before:
            yield f"from {turned(float(phi), beam)}: {words or 'no contact'}"
            before = words
    if "scale" in data.sizes:
        last = data.isel(point=-1)
        angles = ([math.degrees(v) + 0.0 for v in last[name].values] for name in ("theta", "twist"))
        cells = zip(*angles, *(last[name].values for name in ("N", "f")), strict=True)
        rows = ((str(i), *map(units.number, row)) for i, row in enumerate(cells, 1))
        yield output.table(("scale", "theta, deg", "twist of its pitch, deg", "N, N", "f, N"), rows)


def verify(
    beam: flags.BeamFile,
    /,
    *,
    mu: flags.Mu = None,
    to: Annotated[str | None, flag(_REACH)] = None,
    run: Run = RUN,
    load: Annotated[str | None, flag(_LOAD)] = None,
    support: Annotated[str | None, flag(_SUPPORT)] = None,
    scales: Annotated[int | None, flags.scales(200, _FINITE)] = None,
    beam_mesh: Annotated[MeshSize, flag(_FINITE_MESH, read=_mesh_read)] = "coarse",
    out: Annotated[flags.File | None, flag(_FOLDER, "--out", "-o")] = None,
    full: flags.Full = False,
    quiet: flags.Quiet = False,
    base: flags.Base = flags.BASE,
) -> int:
    """Compare the models with finite elements along the twist; exit status 1 where no scale touches: no test then."""
    given = base.beam(beam, mu)
    twist = flags.asked("--to", to, given)
    described = settled(given)

    from squama.fe.runs import print_progress
    from squama.study import verification as study

    folder = Path(f"verify_{Path(beam).stem}" if out is None else out)
    how: dict[str, Any] = {"load": load, "support": support, "scales": scales, "beam_mesh": beam_mesh, **vars(run)}
    how |= {} if quiet else {"progress": print_progress, "announce": announce}
    with kept(label(beam), f"; {label(folder)} holds what is done"):
        found = study.verify(described, folder, to=twist, **how)
    written = found.written
    if load is None:
        record, made = _verified(found), _summary(found)
        written = [*written, *output.draw([str(folder / "comparison.png")], "compare_figure", found.table)]
    else:
        record, made = _part(found), _part_summary(found)
    return output.report(base.json, beam, written, record, made.shown(full=full)) or (0 if found.tested else UNTESTED)


def _about(found: Verified) -> tuple[dict[str, object], dict[str, object]]:
    """Return what a comparison is about and its verdict, and how the elements ran, for JSON."""
    head = {**{key: found.table.attrs[key] for key in ("title", "load")}, **output.of(found, "tested verdict")}
    return head, {key: found.elements.attrs[key] for key in ("mesh", "sentence", "reached", "energy_error")}


def _verified(found: Verified) -> dict[str, object]:
    table, (head, elements) = found.table, _about(found)
    each = ("words", "within", "last", "dT_last", "dtheta_last", "T", "theta", "dT", "dtheta")
    models = [table.isel(model=i) for i in range(table.sizes["model"])]
    return {
        **head,
        "contact_from": found.touched,
        "elements": elements,
        "share": table.attrs["share"],
        "curve": {name: table[name].values for name in ("phi", "T_elements", "theta_elements")},
        "models": {str(one["model"].item()): {key: one[key].values for key in each} for one in models},
        "units": {str(name): v.attrs.get("units", "") for name, v in table.variables.items() if name != "model"},
    }


def _part(found: Verified) -> dict[str, object]:
    table, (head, elements) = found.table, _about(found)
    return {
        **head,
        "elements": elements,
        "curve": {str(name): v.values for name, v in table.variables.items() if name != "model"},
        "compared": table["model"].values.tolist(),
        "units": output.units(table.variables.items()),
    }


def _part_summary(found: Verified) -> Summary:
    """Return the summary of a part: its load by finite elements and by both joints."""
    data, attrs = found.table, found.elements.attrs
    by = "turn" if "turn" in data.coords else "travel"
    size, unit = (math.degrees(1.0), "deg") if by == "turn" else (1e3, "mm")
    load, of = (1e3, "N mm") if by == "turn" else (1.0, "N")
    rows = []
    for at in _some(data):
        off = ["-" if math.isnan(v) else f"{100 * v:+.1f}" for v in at["off"].values.tolist()]
        rows.append([units.number(size * float(at[by])), units.number(load * float(at["elements"])), *off])
    figures = [
        ("about", data.attrs["title"]),
        ("elements", f"{attrs['mesh']}; {attrs['sentence']}"),
        ("energy balance", f"(W - U_el - W_fr)/W = {attrs['energy_error']:.0e}"),
    ]
    words = "difference from the load of the elements, %: joint of the beam (law), joint of this mesh (mesh)"
    table = output.table((f"{by} ({unit})", f"elements ({of})", "law", "mesh"), rows, left=0)
    verdict = found.verdict if found.tested else data.attrs["title"]
    return Summary(verdict, figures, [words, table], () if found.tested else [found.verdict])


def _summary(found: Verified) -> Summary:
    """Return the summary: agreement of the beam's own model, then of each model, with finite elements."""
    data, attrs = found.table, found.elements.attrs
    about = f"{data.attrs['title']}: {found.verdict}" if found.tested else data.attrs["title"]
    if not found.tested:
        return Summary(about, (), (), [found.verdict, *data.attrs["warnings"].splitlines()], _all(data, attrs))
    names = data["model"].values.tolist()
    one = data.sel(model="compliant" if "compliant" in names else names[0])
    share = percent(float(data.attrs["share"]))
    off = f"{units.number(100 * float(one['dT_last']), sign='+')} % at {per_pitch(float(one['last']))}"
    verdict = f"{one['words'].item()} differ from finite elements in torque by {off}"
    last = float(one["within"])
    near = f"{share} up to {per_pitch(last)}" if last else f"{share} nowhere"
    figures = [("within", near), ("tested", found.verdict), ("about", data.attrs["title"])]
    unit = f"deg per pitch up to which a model is within {share} in torque; then torque and theta (deg) at its end"
    table = output.table(("model", "holds to", "torque", "theta"), ranges(data), left=1)
    return Summary(verdict, figures, [table, unit, *finite(data)], data.attrs["warnings"], _all(data, attrs))


def _all(data: xr.Dataset, attrs: Mapping[Hashable, object]) -> Iterable[str | Table]:
    """Yield mesh, energy balance and tables of all differences; ``attrs`` of the elements' run."""
    yield f"elements: {attrs['mesh']}; {attrs['sentence']}"
    yield f"energy balance: (W - U_el - W_fr)/W = {attrs['energy_error']:.0e}"
    yield ""
    yield "difference from the torque of the elements, %"
    yield _table(data, "dT", 100.0, "T_elements", 1e3, "N mm")
    yield ""
    yield "difference from the inclination of the elements, deg"
    yield _table(data, "dtheta", math.degrees(1.0), "theta_elements", math.degrees(1.0), "deg")


def _some(data: xr.Dataset) -> Iterable[xr.Dataset]:
    """Return at most :data:`ROWS` points of a comparison, evenly spaced, without the first."""
    import numpy as np

    places = np.unique(np.linspace(0, data.sizes["point"] - 1, ROWS + 1).round().astype(int))
    return (data.isel(point=int(i)) for i in places[1:])


def _table(data: xr.Dataset, name: str, factor: float, own: str, scale: float, unit: str) -> Table:
    """Return the differences of all models at some twists, with the elements' own value."""
    rows = []
    for at in _some(data):
        cells = factor * at[name].values
        texts = ["-" if math.isnan(cell) else units.number(cell, sign="+") for cell in cells]
        rows.append([units.number(math.degrees(float(at["phi"]))), units.number(scale * float(at[own])), *texts])
    return output.table(("deg per pitch", f"elements, {unit}", *map(str, data["model"].values)), rows, left=0)


def ranges(data: xr.Dataset) -> list[tuple[str, ...]]:
    """Return a row per model of the endless beam: range of agreement (deg per pitch), and final differences."""
    from squama.fe.agreement import FINITE

    rows: list[tuple[str, ...]] = []
    for name in data["model"].values:
        if name not in FINITE:
            one = data.sel(model=name)
            within, torque, theta = (float(one[key]) for key in ("within", "dT_last", "dtheta_last"))
            cells = units.number(math.degrees(within)), apart_by(torque), units.number(math.degrees(theta), sign="+")
            rows.append((one["words"].item(), *(("-",) * 3 if math.isnan(within) else cells)))
    return rows


def finite(data: xr.Dataset) -> list[str]:
    """Return lines that compare the elements' finite beam with their endless beam, and the row with the finite beam."""
    import numpy as np

    if "beam" not in data["model"].values:
        return []
    beam, row = data.sel(model="beam"), data.sel(model="row")
    endless = data[["T_elements", "theta_elements"]].rename(T_elements="T", theta_elements="theta")
    lines = []
    for one, other, name in ((beam, endless, "endless one"), (row, beam, "finite beam")):
        words = f"{one['words'].item()}: beside the {name}"
        off = 100 * (one["T"] / other["T"] - 1).values
        both = np.flatnonzero(np.isfinite(off) & (data["phi"].values > 0))
        if not both.size:
            lines.append(f"{words} there is no twist that both have")
            continue
        angle = math.degrees(float((one["theta"] - other["theta"])[both[-1]]))
        first, last = (
            f"{units.number(off[i], sign='+')} % at {per_pitch(float(data['phi'][i]))}" for i in (both[0], both[-1])
        )
        lines.append(f"{words} the torque is {first} and {last}, theta {angle:+.2f} deg there")
    return lines


def deck(
    beam: flags.BeamFile,
    /,
    *,
    out: Annotated[flags.File, flag("Input deck (.inp) to write; - prints it.", "--out", "-o")],
    program: Annotated[str, flag(_PROGRAM, "--for", read=one_of("calculix", "abaqus"))] = "calculix",
    scales: Annotated[int | None, flags.scales(100, "Number of scales. Default: the file's; allowed:")] = None,
    mu: flags.Mu = None,
    to: Annotated[str, flag(f"Twist at the end: {flags.TWISTS}. Default: 0.15 rad/pitch.")] = "0.15 rad/pitch",
    made: Deck = DECK,
    base: flags.Base = flags.BASE,
) -> int:
    """Write an input deck of a finite beam for CalculiX or Abaqus."""
    place = table_place(flags.problems(), "-o", out, as_json=base.json)
    flags.check_places([(place, (".inp",))])
    found = base.beam(beam, mu, scales=scales)
    rate = flags.asked("--to", to, found)
    described = settled(found)
    twist = settled(rate) * described.pitch

    from squama.fe import deck as decks

    friction = settled(described.friction.mu)
    model = decks.model(described, mu=friction, scales=described.pitches, twist=twist, **vars(made))
    written, name = output.write_text(out, decks.write(model, program)), label(out)
    if place is None:
        return 0
    facts = {"scales": model.scales, "nodes": len(model.nodes), "elements": len(model.tets)}
    record = {"out": str(written), "program": program, **facts, "twist_per_pitch": twist}
    wrote = f"wrote {name}: {model.scales} scales, {len(model.tets)} quadratic tetrahedra, {per_pitch(twist)}"
    stem = name.removesuffix(".inp")
    more = f"run it with: ccx -i {stem}  (CalculiX; on Debian and Ubuntu: apt-get install calculix-ccx)"
    if program == "abaqus":
        more = "this deck was never run in Abaqus, only its syntax was checked; look at the contact in every increment"
    return output.say(base.json, record, [wrote, more])
