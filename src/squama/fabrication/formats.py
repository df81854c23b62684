"""STL and 3MF, as bytes; the same solids give the same bytes. Lengths are in millimetres."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np

from squama.fabrication.mesh import Mesh
from squama.fabrication.recipe import Array

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


class Placed(NamedTuple):
    """A mesh in its place: ``name`` of this copy, ``mesh`` shared by its copies, rotation ``turn`` and ``shift``."""

    name: str
    mesh: Mesh
    turn: Array
    shift: Array

    @property
    def seated(self) -> Mesh:
        """The mesh where it belongs."""
        return self.mesh.moved(self.turn, self.shift, self.name)


def still(mesh: Mesh, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> Placed:
    """Return a mesh that is only moved."""
    return Placed(mesh.name, mesh, np.eye(3), np.asarray(shift, float))


def stl(solids: Sequence[Placed]) -> bytes:
    """Return a binary STL file of all solids."""
    parts = []
    for mesh in (solid.seated for solid in solids):
        corners = mesh.vertices[mesh.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        part = np.zeros(len(corners), _TRIANGLE)
        part["normal"] = normals / np.linalg.norm(normals, axis=1)[:, None]
        part["corners"] = corners
        parts.append(part)
    triangles = np.concatenate(parts)
    header = b"squama, lengths in mm".ljust(80)
    return b"".join([header, len(triangles).to_bytes(4, "little"), triangles.tobytes()])


def three_mf(solids: Sequence[Placed]) -> bytes:
    """Return a 3MF file with an object for each solid, named; copies share their mesh."""
    kinds: dict[int, int] = {}
    objects: list[str] = []
    items: list[str] = []
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
    model = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">\n'
        '<metadata name="Application">squama</metadata>\n<resources>\n'
        + "\n".join(objects)
        + "\n</resources>\n<build>\n"
        + "\n".join(items)
        + "\n</build>\n</model>\n"
    )
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as package:
        for name, text in (("[Content_Types].xml", _TYPES), ("_rels/.rels", _RELATIONS), ("3D/3dmodel.model", model)):
            # a fixed date and system, so that the bytes follow from the content
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
