"""From a beam to files of solids in a folder."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from squama import checks as arguments
from squama._version import __version__
from squama.errors import InputError, SquamaError
from squama.fabrication import bill as bills
from squama.fabrication import folder as folders
from squama.fabrication import formats as written
from squama.fabrication import measure, refuse
from squama.fabrication import plan as plans
from squama.fabrication import solids as made
from squama.fabrication import step as steps
from squama.fabrication.measure import Check
from squama.fabrication.place import Plan
from squama.fabrication.solids import PARTS, Item
from squama.needs import need

if TYPE_CHECKING:
    from squama.design import Beam

FORMATS = ("stl", "3mf", "step")


@dataclass(frozen=True)
class Export:
    """What was made.

    Attributes
    ----------
    files : tuple of Path
        The files that were written.
    bill : tuple
        Bill of materials: rows with ``part``, ``material``, ``made``, ``number``, ``volume`` of one (mm^3), ``density``
        (g/cm^3), ``mass`` of one (g).
    checks : tuple
        What was measured of solids and files: ``what``, ``solid``, ``expected``, ``measured``, ``unit``, ``tolerance``.
    plan : tuple
        Every size, in mm and rad.
    solids : dict
        Meshes by file name without ending: lists of (name, vertices (n, 3) in mm, triangles (m, 3)).
    """

    files: tuple[Path, ...]
    bill: tuple[bills.Row, ...]
    checks: tuple[Check, ...]
    plan: Plan
    solids: dict[str, list[Any]]


def export(
    beam: Beam,
    folder: str | os.PathLike[str],
    *,
    scales: int | None = None,
    parts: Sequence[str] = PARTS,
    formats: Sequence[str] = ("stl", "3mf"),
    clearance: float | str = "0.2 mm",
    feature: float | str = "0.4 mm",
    wall: float | str = "3 mm",
    ends: float | str = "30 mm",
    draft: float | str = "0 deg",
    bed: float | str | None = None,
    scale_density: float = bills.PLA,
    substrate_density: float = bills.SILICONE,
    force: bool = False,
) -> Export:
    """Write a beam's solids for the printer and the mould: scales, substrate, mould, the assembled beam.

    Everything is measured before it is written: each solid closed and of the volume of its closed form, no two solids
    in each other, thickness and angles measured on the faces; and each STL and 3MF file again as it is read back.

    Parameters
    ----------
    beam
        The beam.
    folder
        Where to write; made if it is not there. Files in it that no export has written are not replaced.
    scales
        Number of scales, 1 to 500; the beam's own if not given.
    parts
        Any of "scale", "substrate", "mould", "assembly".
    formats
        Any of "stl", "3mf" (both in mm) and "step" (needs the extra ``step``).
    clearance
        Room between tab and slot on every side, m or text; the same between blades and the lid of the mould.
    feature
        Least size that can be printed or cast, m or text.
    wall
        Thickness of the mould's walls, floor and lid, m or text.
    ends
        Plain length of the bar before the first and behind the last pitch, m or text.
    draft
        Inclination of the tray's sides, rad or text.
    bed
        Longest part that the printer takes, m or text; without it no size is refused and nothing is cut in pieces.
    scale_density, substrate_density
        g/cm^3, for the masses: of what is printed (solid PLA) and of the silicone.
    force
        Replace files that no export has written.

    Returns
    -------
    Export

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
    sizes = {"clearance": clearance, "feature": feature, "wall": wall, "ends": ends, "draft": draft}
    if bed is not None:
        sizes["bed"] = bed
    wanted, kinds = several("parts", parts, PARTS), several("formats", formats, FORMATS)
    densities = tuple(
        arguments.scalar(name, value, 0.01, 25, "a density in g/cm^3, 0.01 to 25; write e.g. 1.2")
        for name, value in (("scale_density", scale_density), ("substrate_density", substrate_density))
    )
    plan = plans.plan(beam, scales, plans.read(sizes))
    refuse.check(plan, wanted)
    for package in ("manifold3d", "trimesh", *(("build123d",) if "step" in kinds else ())):
        need(package)
    solids = made.make(plan, wanted)
    _settle(solids.checks)
    bill = bills.rows(plan, solids.counts, *densities)
    contents: dict[str, bytes] = {}
    for stem, items in solids.files.items():
        for kind in kinds:
            contents[f"{stem}.{kind}"] = _bytes(stem, items, kind)
    contents["bill.csv"] = bills.table(bill).encode()
    folders.check(folder, [*contents, folders.RECORD], force=force)
    found = list(solids.checks)

    def look(name: str, path: Path) -> None:
        stem, _, kind = name.rpartition(".")
        if kind in ("stl", "3mf"):
            seen = list(measure.read_back(_read(path, kind, solids.files[stem]), name))
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
    paths = folders.write(folder, contents, record, look)
    meshes = {stem: [p.seated for item in items for p in item.placed] for stem, items in solids.files.items()}
    return Export(tuple(paths), tuple(bill), tuple(found), plan, meshes)


def several(name: str, value: Sequence[str], allowed: tuple[str, ...]) -> tuple[str, ...]:
    """Return some of the allowed words in their order, each once."""
    given: Iterable[str] = [value] if isinstance(value, str) else value
    words = [arguments.one_of(name, word, allowed) for word in given]
    if not words:
        message = f"{name}: is empty; write e.g. {allowed[0]}"
        raise InputError(message)
    return tuple(word for word in allowed if word in words)


def _settle(checks: Iterable[Check]) -> None:
    """Stop if something is not as it should be.

    Raises
    ------
    SquamaError
        One line per check that does not hold.
    """
    lines = [check.line() for check in checks if not check.holds]
    if lines:
        raise SquamaError("\n".join(lines))


def _bytes(stem: str, items: list[Item], kind: str) -> bytes:
    writers: dict[str, Callable[[], bytes]] = {
        "stl": lambda: written.stl([p for item in items for p in item.placed]),
        "3mf": lambda: written.three_mf([p for item in items for p in item.placed]),
        "step": lambda: steps.step(stem, [(item.recipe, item.copies) for item in items]),
    }
    return writers[kind]()


def _read(path: Path, kind: str, items: list[Item]) -> list[tuple[str, Any, float]]:
    """Return the solids in a file as trimesh reads them: name, mesh, volume that it should have."""
    trimesh = need("trimesh")
    volumes = {name: item.recipe.volume for item in items for name, _, _ in item.copies}
    data = io.BytesIO(path.read_bytes())
    if kind == "stl":
        mesh = trimesh.load_mesh(data, file_type="stl")
        return [(next(iter(volumes)) if len(volumes) == 1 else "", mesh, sum(volumes.values()))]
    scene = trimesh.load_scene(data, file_type="3mf")
    seen = {node: scene.geometry[scene.graph[node][1]] for node in scene.graph.nodes_geometry}
    if len(seen) != len(volumes):
        message = f"{path.name}: {len(seen)} solids are in the file, not {len(volumes)}"
        raise SquamaError(message)
    copies = [item.recipe.volume for item in items for _ in item.copies]
    found = sorted(seen.items(), key=lambda pair: pair[1].volume)
    return [(name, mesh, volume) for (name, mesh), volume in zip(found, sorted(copies), strict=True)]
