"""STL, 3MF and STEP files as bytes; equal solids give equal bytes. Lengths are in mm."""

from __future__ import annotations

import io
import itertools
import re
import zipfile
from collections.abc import Iterable, Sequence
from types import ModuleType
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np

from squama.errors import SquamaError
from squama.fabrication.bodies import QUADS, Recipe
from squama.fabrication.mesh import Mesh
from squama.needs import need
from squama.types import Array

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_TYPES = (
    f'<?xml version="1.0" encoding="UTF-8"?>\n<Types xmlns="{_PACKAGE}/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>\n'
)
_RELATIONS = (
    f'<?xml version="1.0" encoding="UTF-8"?>\n<Relationships xmlns="{_PACKAGE}/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n'
)
VOLUME = 1e-6
"""Largest relative difference of a volume from the closed form."""
_OCCURRENCE = re.compile(
    rb"=\s*(NEXT_ASSEMBLY_USAGE_OCCURRENCE)\(\s*'\d+'"
    rb",\s*('[^']*'),\s*('[^']*'),\s*(#\d+),\s*(#\d+),\s*(\$|'[^']*')\s*\)"
)
_DATE = "1980-01-01T00:00:00"
"""Fixed date in the file's head, so that equal solids give equal bytes."""


class Placed(NamedTuple):
    """A solid in its place: ``name`` of the copy, recipe and mesh of all copies, rotation ``turn``, ``shift`` (mm)."""

    name: str
    recipe: Recipe
    mesh: Mesh
    turn: Array = np.eye(3)
    shift: Array = np.zeros(3)

    @property
    def seated(self) -> Mesh:
        """The mesh in its place."""
        return self.mesh.moved(self.turn, self.shift, self.name)


def stl(solids: Sequence[Placed]) -> bytes:
    """Return a binary STL file of all solids."""
    parts = []
    for mesh in (solid.seated for solid in solids):
        part = np.zeros(len(mesh.triangles), _TRIANGLE)
        part["normal"] = mesh.normals / np.linalg.norm(mesh.normals, axis=1)[:, None]
        part["corners"] = mesh.vertices[mesh.triangles]
        parts.append(part)
    triangles = np.concatenate(parts)
    header = b"squama, lengths in mm".ljust(80)
    return b"".join([header, len(triangles).to_bytes(4, "little"), triangles.tobytes()])


def three_mf(solids: Sequence[Placed]) -> bytes:
    """Return a 3MF file with a named object for each solid; copies share their mesh."""
    kinds: dict[int, int] = {}
    objects, items = list[str](), list[str]()
    for solid in solids:
        alone = sum(other.mesh is solid.mesh for other in solids) == 1
        if id(solid.mesh) not in kinds:
            kinds[id(solid.mesh)] = len(objects) + 1
            objects.append(_object(len(objects) + 1, solid.name if alone else solid.mesh.name, _mesh(solid.mesh)))
        number = kinds[id(solid.mesh)]
        transform = " ".join(_number(v) for v in [*solid.turn.T.ravel(), *solid.shift])
        if alone:
            items.append(f'<item objectid="{number}" transform="{transform}"/>')
        else:
            part = f'<components><component objectid="{number}" transform="{transform}"/></components>'
            objects.append(_object(len(objects) + 1, solid.name, part))
            items.append(f'<item objectid="{len(objects)}"/>')
    made, placed = "\n".join(objects), "\n".join(items)
    model = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">\n'
        f'<metadata name="Application">squama</metadata>\n<resources>\n{made}\n</resources>\n'
        f"<build>\n{placed}\n</build>\n</model>\n"
    )
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as package:
        for name, text in (("[Content_Types].xml", _TYPES), ("_rels/.rels", _RELATIONS), ("3D/3dmodel.model", model)):
            # a fixed date and system, so that equal content gives equal bytes
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type, entry.create_system, entry.external_attr = zipfile.ZIP_DEFLATED, 3, 0o644 << 16
            package.writestr(entry, text)
    return out.getvalue()


def _object(number: int, name: str, content: str) -> str:
    return f'<object id="{number}" type="model" name={quoteattr(name)}>{content}</object>'


def _mesh(mesh: Mesh) -> str:
    vertices = "".join(
        f'<vertex x="{_number(x)}" y="{_number(y)}" z="{_number(z)}"/>' for x, y, z in mesh.vertices.tolist()
    )
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.triangles.tolist())
    return f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"


def _number(value: float) -> str:
    return f"{float(value) + 0.0:.17g}"


def step(name: str, solids: Iterable[Placed]) -> bytes:
    """Return a STEP file (mm) named ``name``. Raises SquamaError where a volume differs from the closed form."""
    cad = need("build123d")
    children = []
    for one in solids:
        # a separate shape for each copy, because names belong to shapes
        child = _solid(cad, one.recipe.moved(one.turn, one.shift))
        child.label = one.name
        children.append(child)
    whole = cad.Compound(label=name, children=children) if len(children) > 1 else children[0]
    out = io.BytesIO()
    cad.export_step(whole, out, unit=cad.Unit.MM, timestamp=_DATE)
    return _numbered(out.getvalue())


def _numbered(data: bytes) -> bytes:
    """Return a file with occurrences numbered from 1; the kernel continues its count from file to file."""
    count = itertools.count(1)

    def line(found: re.Match[bytes]) -> bytes:
        return b"= %s('%d',%s)" % (found[1], next(count), b",".join(found.groups()[1:]))

    return _OCCURRENCE.sub(line, data)


def _solid(cad: ModuleType, recipe: Recipe) -> Any:
    whole, *cuts = (_block(cad, corners) for corners in (recipe.whole, *recipe.cuts))
    found = whole.cut(*cuts) if cuts else whole
    solids = found.solids()
    if len(solids) != 1:
        message = f"{recipe.name}: the STEP solid is in {len(solids)} pieces"
        raise SquamaError(message)
    found = solids[0]
    if abs(found.volume / recipe.volume - 1) > VOLUME:
        message = f"{recipe.name}: the STEP solid has {found.volume:.9g} mm^3, not {recipe.volume:.9g} mm^3"
        raise SquamaError(message)
    return found


def _block(cad: ModuleType, corners: Array) -> Any:
    loops = (cad.Wire.make_polygon([tuple(map(float, corners[i])) for i in quad], close=True) for quad in QUADS)
    return cad.Solid(cad.Shell([cad.Face(loop) for loop in loops]))
