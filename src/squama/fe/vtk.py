"""The deformed pitch as a VTK file (.vtu) for ParaView and its like.

The format is written here: a few lines, where a library would be one more package to install.
"""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from squama import files
from squama.fe.deformed import Deformed

QUADRATIC_TETRAHEDRON, QUAD = 24, 9
_TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}


def write_vtu(state: Deformed, path: str | os.PathLike[str]) -> Path:
    """Write quadratic tetrahedra and the mid-planes of the scale and its neighbours.

    Parameters
    ----------
    state : Deformed
        From :func:`squama.fe.deformed.deformed`.
    path : path
        Where to write, ending in .vtu. Places are those at rest, in m; ``displacement`` (m) belongs to the points,
        ``largest_stretch`` (1), ``strain_energy_density`` (J/m3), ``von_mises_stress`` (Pa) and ``part`` (0 the
        substrate, 1 a scale) to the cells. Scales are rigid: their stretch is 1, the rest 0.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        The file cannot be written.
    """
    n, tets, scales = len(state.nodes), len(state.tets), len(state.scales)
    points = np.concatenate([state.nodes, state.scales.reshape(-1, 3)])
    moved = np.concatenate([state.moved, state.scales_moved.reshape(-1, 3)])
    quads = n + np.arange(4 * scales)
    cells = {
        "connectivity": np.concatenate([state.tets.ravel(), quads]),
        "offsets": np.concatenate([10 * np.arange(1, tets + 1), 10 * tets + 4 * np.arange(1, scales + 1)]),
        "types": np.repeat([QUADRATIC_TETRAHEDRON, QUAD], [tets, scales]).astype(np.uint8),
    }
    felt = {
        "largest_stretch": np.append(state.stretch, np.ones(scales)),
        "strain_energy_density": np.append(state.density, np.zeros(scales)),
        "von_mises_stress": np.append(state.mises, np.zeros(scales)),
        "part": np.repeat([0, 1], [tets, scales]).astype(np.uint8),
    }
    text = "\n".join(
        (
            '<?xml version="1.0"?>',
            '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
            f'<UnstructuredGrid><Piece NumberOfPoints="{len(points)}" NumberOfCells="{tets + scales}">',
            _group("Points", {"points": points}),
            _group("Cells", cells),
            _group("PointData", {"displacement": moved - points}),
            _group("CellData", felt),
            "</Piece></UnstructuredGrid></VTKFile>\n",
        )
    )
    return files.atomic_write(path, lambda place: place.write_text(text, encoding="ascii"))


def _group(name: str, arrays: Mapping[str, Any]) -> str:
    lines = [f"<{name}>"]
    for key, values in arrays.items():
        kind = np.asarray(values).dtype.str[1:]
        raw = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
        size = np.array([len(raw)], "<u8").tobytes()
        shape = ' NumberOfComponents="3"' if values.ndim == 2 else ""
        lines.append(f'<DataArray type="{_TYPES[kind]}" Name="{key}"{shape} format="binary">')
        lines.append(base64.b64encode(size + raw).decode("ascii"))
        lines.append("</DataArray>")
    return "\n".join([*lines, f"</{name}>"])
