"""The deformed pitch at the end of a run, in SI units, with strains and stresses, for pictures and VTK files."""

from __future__ import annotations

import base64
import os
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama.fe import elements
from squama.fe.elements import Material
from squama.fe.geometry import geometry
from squama.fe.mesh import Index, Pitch
from squama.fe.periodic import Twist
from squama.fe.plate import Attached, Turn
from squama.io import files
from squama.types import Array

if TYPE_CHECKING:
    from squama.beam.design import Beam
    from squama.fe.walk import Walk

IMAGES = (-1, 0, 1)
"""Numbers of the scales shown: the scale of the pitch and its neighbours."""
QUADRATIC_TETRAHEDRON, QUAD = 24, 9
_TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}


class Deformed(NamedTuple):
    """Deformed state of one pitch of the substrate and three scales.

    ``nodes``, ``moved`` (n, 3): places at rest and in the deformed state, m; ``tets`` (m, 10), ``surface`` (q, 6) as in
    :class:`squama.fe.mesh.Pitch`, ``walls`` (q,): whether a triangle is the slot's; per element ``stretch`` (largest
    principal stretch), ``density`` (strain energy per volume at rest, J/m3) and ``mises`` (von Mises stress in the
    deformed state, Pa), means over its Gauss points; ``scales``, ``scales_moved`` (3, 4, 3): corners of the mid-planes
    of the scales -1, 0, 1 with their embedded parts, m; ``phi``: twist, rad per pitch, signed; ``pitch`` and
    ``exposed``, the scale's exposed length: m.
    """

    nodes: Array
    moved: Array
    tets: Index
    surface: Index
    walls: NDArray[np.bool_]
    stretch: Array
    density: Array
    mises: Array
    scales: Array
    scales_moved: Array
    phi: float
    pitch: float
    exposed: float

    def at_nodes(self, values: Array) -> Array:
        """Return values (m,) of the elements averaged at the nodes (n,), weighted by volume."""
        x = self.nodes[self.tets[:, :4]]
        volumes = np.repeat(np.abs(np.linalg.det(x[:, 1:] - x[:, :1])), 10)
        node = self.tets.ravel()
        total = np.bincount(node, volumes, minlength=len(self.nodes))
        sums = np.bincount(node, volumes * np.repeat(values, 10), minlength=len(self.nodes))
        return np.asarray(sums / np.maximum(total, 1e-300))


def deformed(beam: Beam, walk: Walk, pitch: Pitch) -> Deformed:
    """Return the present state of a run of :func:`squama.fe.assembly.make_walk` on a mesh of one pitch."""
    shape, d, E = geometry(beam), beam.pitch, beam.substrate.youngs_modulus
    master, turned, _ = pitch.images
    step = Twist().moves(np.array([walk.phi]), np.ones(1))
    moved = elements.images(walk.places(), master, turned, step)
    stretch, density, mises = _felt(pitch, moved, shape.nu)
    X, Y = (-shape.zeta, shape.eta), (-shape.beta, shape.beta)
    local = np.array([[X[0], Y[0], 0.0], [X[1], Y[0], 0.0], [X[1], Y[1], 0.0], [X[0], Y[1], 0.0]])
    rest = shape.rest.base + local @ shape.rest.axes
    now = Attached(shape.rest, rest).places(walk.v[:6])

    def corners(at: Array, phi: float) -> Array:
        return np.array([(at @ Turn.at(k * phi).Q.T + [0.0, 0.0, k]) * d for k in IMAGES])

    walls = np.asarray(np.isin(pitch.surface, pitch.tied).all(axis=1))
    felt = stretch, density * E, mises * E
    mesh = pitch.nodes * d, moved * d, pitch.tets, pitch.surface, walls
    return Deformed(*mesh, *felt, corners(rest, 0.0), corners(now, walk.phi), walk.phi, d, shape.eta * d)


def _felt(pitch: Pitch, moved: Array, nu: float) -> Array:
    """Return (3, m) per element: largest principal stretch, energy density and von Mises stress, in E = 1.

    Means over four Gauss points of each quadratic tetrahedron, with the material of :mod:`squama.fe.elements`.
    """
    a = (5 - sqrt(5)) / 20
    rates = elements.shape_rates(np.full((4, 4), a) + (1 - 4 * a) * np.eye(4))
    shapes = np.einsum("gnc,mcj->mgnj", rates, elements.gradients(pitch.nodes, pitch.tets)[0])
    F = np.einsum("mni,mgnj->mgij", moved[pitch.tets], shapes)
    L, G = Material(1.0, nu).lame
    B, J = F @ F.swapaxes(-1, -2), np.linalg.det(F)
    stretch = np.sqrt(np.linalg.eigvalsh(B)[..., -1])
    trace = np.trace(B, axis1=-2, axis2=-1)
    density = G / 2 * (trace - 3 - 2 * np.log(J)) + L / 2 * np.log(J) ** 2
    deviator = G * (B - trace[..., None, None] / 3 * np.eye(3)) / J[..., None, None]
    felt = stretch, density, np.sqrt(1.5 * (deviator**2).sum(axis=(-2, -1)))
    return np.asarray(np.mean(felt, axis=-1))


def write_vtu(state: Deformed, path: str | os.PathLike[str]) -> Path:
    """Write tetrahedra and the mid-planes of three scales to a VTK file (.vtu), e.g. for ParaView; return its path.

    Places are those at rest, in m; ``displacement`` (m) belongs to the points, ``largest_stretch`` (1),
    ``strain_energy_density`` (J/m3), ``von_mises_stress`` (Pa) and ``part`` (0 the substrate, 1 a scale) to the cells.
    Scales are rigid: their stretch is 1, the rest 0. Raises InputError where the file cannot be written.
    """
    n, count = len(state.nodes), (len(state.tets), len(state.scales))
    tets, scales = count
    points = np.concatenate([state.nodes, state.scales.reshape(-1, 3)])
    moved = np.concatenate([state.moved, state.scales_moved.reshape(-1, 3)])
    quads = n + np.arange(4 * scales)
    cells = {
        "connectivity": np.concatenate([state.tets.ravel(), quads]),
        "offsets": np.repeat([10, 4], count).cumsum(),
        "types": np.repeat([QUADRATIC_TETRAHEDRON, QUAD], count).astype(np.uint8),
    }
    felt = {
        "largest_stretch": np.append(state.stretch, np.ones(scales)),
        "strain_energy_density": np.append(state.density, np.zeros(scales)),
        "von_mises_stress": np.append(state.mises, np.zeros(scales)),
        "part": np.repeat([0, 1], count).astype(np.uint8),
    }
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        f'<UnstructuredGrid><Piece NumberOfPoints="{len(points)}" NumberOfCells="{tets + scales}">',
    ]
    groups = {"Points": {"points": points}, "Cells": cells, "PointData": {"displacement": moved - points}}
    for name, arrays in {**groups, "CellData": felt}.items():
        lines += [f"<{name}>", *(_array(key, values) for key, values in arrays.items()), f"</{name}>"]
    text = "\n".join([*lines, "</Piece></UnstructuredGrid></VTKFile>\n"])
    return files.atomic_write(path, lambda place: place.write_text(text, encoding="ascii"))


def _array(name: str, values: NDArray[np.generic]) -> str:
    kind = values.dtype.str[1:]
    raw = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
    size = np.array([len(raw)], "<u8").tobytes()
    shape = ' NumberOfComponents="3"' if values.ndim == 2 else ""
    text = base64.b64encode(size + raw).decode("ascii")
    return f'<DataArray type="{_TYPES[kind]}" Name="{name}"{shape} format="binary">\n{text}\n</DataArray>'
