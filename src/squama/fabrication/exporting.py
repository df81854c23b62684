"""From a beam to files of solids in a folder: files of others stay as they are, each is complete or not there."""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from squama import arguments, errors
from squama._version import __version__
from squama.beam import mass
from squama.errors import Problems, SquamaError
from squama.fabrication import formats as written
from squama.fabrication import mesh, refuse
from squama.fabrication import plan as plans
from squama.fabrication import solids as made
from squama.fabrication.bodies import Recipe
from squama.fabrication.formats import Placed
from squama.fabrication.kinds import FORMATS, PARTS, FormatName, PartName
from squama.fabrication.mesh import Check, Mesh
from squama.fabrication.plan import Plan
from squama.io import files
from squama.needs import need

if TYPE_CHECKING:
    from squama.beam.design import Beam

RECORD = "export.json"
"""File that says what an export has written."""
PLA, SILICONE = mass.PLASTIC / 1000, mass.SILICONE / 1000
"""Densities in g/cm^3 of printed PLA (solid, without infill) and of silicone (VPS: 1.1 to 1.2)."""


class Row(NamedTuple):
    """One line: ``part``, its ``material``, how it is ``made``, ``number``, ``volume`` (mm^3), ``density`` (g/cm^3)."""

    part: str
    material: str
    made: str
    number: int
    volume: float
    density: float

    @property
    def mass(self) -> float:
        """Mass of one, g."""
        return self.volume * self.density / 1000

    def record(self) -> dict[str, str | int | float]:
        """Return the row with its products, by the names of the columns."""
        return {
            "part": self.part,
            "material": self.material,
            "made": self.made,
            "count": self.number,
            "volume_mm3": self.volume,
            "total_volume_mm3": self.volume * self.number,
            "density_g_cm3": self.density,
            "mass_g": self.mass,
            "total_mass_g": self.mass * self.number,
        }


@dataclass(frozen=True)
class Export:
    """What was made: the ``files`` that were written, and every size in the ``plan``, in mm and rad.

    ``bill`` of materials: rows with ``part``, ``material``, ``made``, ``number``, ``volume`` of one (mm^3), ``density``
    (g/cm^3), ``mass`` of one (g). ``checks``: what was measured of solids and files: ``what``, ``solid``, ``expected``,
    ``measured``, ``unit``, ``tolerance``. ``solids``: meshes by file name without ending, lists of (name, vertices (n,
    3) in mm, triangles (m, 3)).
    """

    files: tuple[Path, ...]
    bill: tuple[Row, ...]
    checks: tuple[Check, ...]
    plan: Plan
    solids: dict[str, list[Mesh]]


def export(
    beam: Beam,
    folder: str | os.PathLike[str],
    *,
    scales: int | None = None,
    parts: Sequence[PartName] = PARTS,
    formats: Sequence[FormatName] = ("stl", "3mf"),
    clearance: float | str = "0.2 mm",
    feature: float | str = "0.4 mm",
    wall: float | str = "3 mm",
    ends: float | str = "30 mm",
    draft: float | str = "0 deg",
    bed: float | str | None = None,
    scale_density: float = PLA,
    substrate_density: float = SILICONE,
    force: bool = False,
) -> Export:
    """Write a beam's solids for the printer and the mould: scales, substrate, mould, the assembled beam.

    Everything is measured before it is written: each solid closed and of the volume of its closed form, no two solids
    in each other, thickness and angles measured on the faces; and each STL and 3MF file again as it is read back.

    Parameters
    ----------
    folder
        Where to write; made if it is not there. Files in it that no export has written are not replaced.
    scales
        Number of scales, 1 to 500; the beam's own if not given.
    parts
        Any of "scale", "substrate", "mould", "assembly".
    formats
        Any of "stl", "3mf" (both in mm) and "step" (needs the extra ``step``).
    clearance, feature, wall, ends, bed
        Lengths, m or text: room between tab and slot on every side, and between blades and the lid of the mould; least
        size that can be printed or cast; thickness of the mould's walls, floor and lid; the plain bar before the first
        and behind the last pitch; longest part that the printer takes (without it none is refused or cut in pieces).
    draft
        Inclination of the tray's sides, rad or text.
    scale_density, substrate_density
        g/cm^3, for the masses: of what is printed (solid PLA) and of the silicone.
    force
        Replace files that no export has written.

    Raises
    ------
    InputError
        The beam cannot be printed, cast or assembled (one line per dimension that causes it); a value that is not
        usable; a package that is missing; a place that cannot be written to.
    SquamaError
        A solid or a file is not as it should be; it is not written.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(beta=0.6, zeta=0.3, slenderness=6, theta0="15 deg")
    >>> made = squama.export(beam, "solids", scales=3, parts=["scale"], formats=["stl"])
    >>> [path.name for path in made.files]
    ['scale.stl', 'scales.stl', 'bill.csv', 'export.json']
    """
    arguments.beam(beam)
    sizes = {"clearance": clearance, "feature": feature, "wall": wall, "ends": ends, "draft": draft}
    if bed is not None:
        sizes["bed"] = bed
    wanted, kinds = arguments.several("parts", parts, PARTS), arguments.several("formats", formats, FORMATS)
    given = {"scale_density": scale_density, "substrate_density": substrate_density}
    allowed = "a density in g/cm^3, 0.01 to 25; write e.g. 1.2"
    densities = [arguments.scalar(name, value, 0.01, 25, allowed) for name, value in given.items()]
    plan = plans.plan(beam, scales, plans.read(sizes))
    refuse.check(plan, wanted)
    for package in ("manifold3d", "trimesh", *(("build123d",) if "step" in kinds else ())):
        need(package)
    solids = made.make(plan, wanted)
    _settle(solids.checks)
    bill = _rows(plan, solids.counts, *densities)
    contents = {f"{stem}.{kind}": _bytes(stem, placed, kind) for stem, placed in solids.files.items() for kind in kinds}
    table = [",".join(v if isinstance(v, str) else f"{v:.10g}" for v in row.record().values()) for row in bill]
    contents["bill.csv"] = ("\n".join([",".join(bill[0].record()), *table]) + "\n").encode()
    _check_folder(folder, [*contents, RECORD], force=force)
    found = list(solids.checks)

    def look(name: str, path: Path) -> None:
        if name.endswith((".stl", ".3mf")):
            seen = list(_read_back(path, name, solids.files[name[:-4]]))
            _settle(seen)
            found.extend(seen)

    record = {
        "by": "squama export",
        "squama_version": __version__,
        "units": {"lengths": "mm", "angles": "rad", "volumes": "mm^3", "masses": "g"},
        "plan": plan._asdict(),
        "bill": [row.record() for row in bill],
        "beam": beam.to_toml(),
    }
    paths = _write(folder, contents, record, look)
    meshes = {stem: [one.seated for one in placed] for stem, placed in solids.files.items()}
    return Export(tuple(paths), tuple(bill), tuple(found), plan, meshes)


def _settle(checks: Iterable[Check]) -> None:
    """Stop if something is not as it should be. Raises SquamaError: one line per check that does not hold."""
    lines = [check.line() for check in checks if not check.holds]
    if lines:
        raise SquamaError("\n".join(lines))


def _rows(plan: Plan, solids: Sequence[tuple[Recipe, int]], printed: float, cast: float) -> list[Row]:
    """Return the bill of solids, each with its number, and of the silicone that the slots' clearance takes up."""
    bar, other = ("silicone", "cast", cast), ("PLA", "printed", printed)
    found = []
    for solid, number in solids:
        material, how, density = bar if solid.name == "substrate" else other
        found.append(Row(solid.name, material, how, number, solid.volume, density))
    if plan.clearance > 0 and "substrate" in {row.part for row in found}:
        glue = math.prod(plan.slot) - plan.embedded * plan.breadth * plan.thickness
        found.append(Row("glue in a slot", "silicone", "filled in", plan.pieces, glue, cast))
    return found


def _bytes(stem: str, placed: list[Placed], kind: str) -> bytes:
    if kind == "step":
        return written.step(stem, placed)
    return written.stl(placed) if kind == "stl" else written.three_mf(placed)


def _read_back(path: Path, name: str, placed: list[Placed]) -> Iterator[Check]:
    """Measure the solids in a file as trimesh reads them; those of an STL file are one."""
    trimesh = need("trimesh")
    volumes = {one.name: one.recipe.volume for one in placed}
    data = io.BytesIO(path.read_bytes())
    if name.endswith(".stl"):
        solid = next(iter(volumes)) if len(volumes) == 1 else ""
        yield from mesh.loaded(trimesh.load_mesh(data, file_type="stl"), name, solid, sum(volumes.values()))
        return
    scene = trimesh.load_scene(data, file_type="3mf")
    seen = {node: scene.geometry[scene.graph[node][1]] for node in scene.graph.nodes_geometry}
    if len(seen) != len(volumes):
        message = f"{path.name}: {len(seen)} solids are in the file, not {len(volumes)}"
        raise SquamaError(message)
    found = sorted(seen.items(), key=lambda pair: pair[1].volume)
    for (solid, body), volume in zip(found, sorted(volumes.values()), strict=True):
        yield from mesh.loaded(body, name, solid, volume)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _check_folder(folder: str | os.PathLike[str], names: list[str], *, force: bool) -> None:
    """Refuse a folder that cannot be written to, or in which files of these names are not those of an export."""
    place, known, problems = Path(folder), _known(Path(folder)), Problems()
    if files.exists(place) or place.is_symlink():
        files.make_folder(place)
    elif not place.parent.is_dir():
        reason = f"its folder {files.label(place.parent)} does not exist"
        errors.refuse("", "", reason, "make it first", source=files.label(folder))
    for name in names:
        path = place / name
        if path.is_dir():
            problems.add("", "", "is a folder", "give another folder to write to", files.label(path))
        elif path.exists() and not force and known.get(name) != _digest(path.read_bytes()):
            reason = "is there and was not written, or was changed since, by squama export"
            problems.add("", "", reason, "give another folder, or --force to replace it", files.label(path))
    problems.settle()


def _write(
    folder: str | os.PathLike[str],
    contents: Mapping[str, bytes],
    record: Mapping[str, object],
    look: Callable[[str, Path], None],
) -> list[Path]:
    """Write files and the record of them; ``look`` is called with each file before it is moved to its place."""
    place = files.make_folder(folder)
    hashes = {name: _digest(data) for name, data in contents.items()}
    # files of an earlier export that are not written now stay known
    earlier = {name: old for name, old in _known(place).items() if name not in hashes and (place / name).is_file()}
    written = []
    for name, data in contents.items():

        def put(path: Path, name: str = name, data: bytes = data) -> None:
            path.write_bytes(data)
            look(name, path)

        written.append(files.atomic_write(place / name, put))
    text = json.dumps({**record, "files": hashes, "earlier": earlier}, indent=1, allow_nan=False) + "\n"
    written.append(files.atomic_write(place / RECORD, lambda path: path.write_text(text, encoding="utf-8")))
    return written


def _known(place: Path) -> dict[str, str | None]:
    """Return the files that exports have written, with their digests; the record itself is known by its content."""
    path = place / RECORD
    with suppress(OSError, ValueError, KeyError, TypeError):
        data = path.read_bytes()
        record = json.loads(data)
        if record["by"] == "squama export":
            return {**record["earlier"], **record["files"], RECORD: _digest(data)}
    return {}
