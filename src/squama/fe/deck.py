"""A beam of N scales as an input deck for CalculiX or Abaqus: mesh, rigid scales, contact, and the twisted end.

Lengths in mm, forces in N, stresses in MPa. The substrate is N pitches of quadratic tetrahedra with the slots of the
scales in their true thickness. A scale is a rigid body: the walls of its slot, a coarse plate whose upper face is the
scale's mid-plane (master of the contact), and a fine strip along its tip edge whose lower face is the same mid-plane
(slave). So the plates are thin to each other, as in the theory. The front end is fixed; the back end is rigid, turned
about the axis by N times the twist per pitch, and free to move along it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama._version import __version__
from squama.errors import InputError
from squama.fe.geometry import Geometry, geometry
from squama.fe.mesh import Tiled, pitch_mesh, tile

if TYPE_CHECKING:
    from squama.design import Beam

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SIZE, EDGE_SIZE = 0.3, 0.08
"""Sizes of the substrate's elements, and along the embedded scales' edges, in pitches."""
PENALTY = 300.0
"""Contact stiffness over E/d: pressure per penetration."""
STICK = 3.0
"""Slope of friction against slip before it slides, over the contact stiffness."""
INCREMENTS = 25
STRIP = 0.04
"""Size of the facets along the tip edge, in pitches."""
BODY = 0.02
"""Thickness of the bodies that carry the contact faces, in pitches; rigid, so without meaning."""
MARK = "** squama: "
MOST_SCALES = 100
MATERIALS = ("neo-hookean", "elastic")


class Plate(NamedTuple):
    """The contact bodies of one scale: bricks (m, 8) by 1-based node numbers, the numbers of its own nodes.

    ``corners`` D, A, B, C of the exposed mid-plane (nodes of the coarse plate), ``ref`` and ``rot`` node.
    """

    plate: Index
    strip: Index
    nodes: Index
    tied: Index
    corners: Index
    ref: int
    rot: int


class Model(NamedTuple):
    """All that a deck says, in mm, N and MPa; node and element numbers begin with 1.

    ``nodes`` (n, 3), ``tets`` (m, 10), a ``Plate`` for each scale, nodes of the fixed and of the turned end, of the
    two edges of the face without scales, reference nodes of the turned end, its angle (rad, clockwise seen against the
    axis), material and contact.
    """

    nodes: Array
    tets: Index
    plates: list[Plate]
    fixed: Index
    turned: Index
    edges: Index
    ref: int
    rot: int
    angle: float
    E: float
    nu: float
    material: str
    mu: float
    penalty: float
    increments: int
    about: dict[str, Any]

    @property
    def scales(self) -> int:
        """Number of scales."""
        return len(self.plates)


def model(
    beam: Beam,
    *,
    scales: int,
    mu: float,
    twist: float = 0.2,
    size: float = SIZE,
    edge_size: float = EDGE_SIZE,
    material: str = "neo-hookean",
    penalty: float = PENALTY,
    increments: int = INCREMENTS,
) -> Model:
    """Mesh a beam of ``scales`` pitches and gather what its deck needs.

    Parameters
    ----------
    beam : Beam
        The beam.
    scales : int
        Number of scales and pitches, 2 to 100.
    mu : float
        Coefficient of friction.
    twist : float
        Twist per pitch at the end, rad; above 0.
    size, edge_size : float
        Sizes of elements, pitches.
    material : {"neo-hookean", "elastic"}
        The substrate.
    penalty : float
        Contact stiffness over E/d.
    increments : int
        Increments if none has to be cut.

    Returns
    -------
    Model

    Raises
    ------
    InputError
        An argument is out of range, the mesher is missing or fails.
    """
    if not 2 <= scales <= MOST_SCALES:
        message = f"scales = {scales}: must be 2 to {MOST_SCALES}; a single scale touches nothing"
        raise InputError(message)
    for name, value, least in (("mu", mu, 0.0), ("twist", twist, 1e-9), ("penalty", penalty, 1e-9)):
        if not least <= value < np.inf:
            message = f"{name} = {value:.6g}: must be {'0 or more' if not least else 'above 0'}"
            raise InputError(message)
    if material not in MATERIALS:
        message = f'material = "{material}": must be {" or ".join(MATERIALS)}'
        raise InputError(message)
    if increments < 1:
        message = f"increments = {increments}: must be 1 or more"
        raise InputError(message)
    shape = geometry(beam)
    mesh = tile(pitch_mesh(shape, size, edge_size), scales)
    d = beam.pitch * 1e3
    E = beam.substrate.youngs_modulus * 1e-6
    points, plates = _plates(shape, mesh, scales)
    count = len(mesh.nodes) + len(points)
    middle = np.array([[0.0, 0.0, shape.cut + scales]])
    about = {
        "version": __version__,
        "scales": scales,
        "pitch_mm": d,
        "twist_per_pitch": twist,
        "E_MPa": E,
        "mu": mu,
        **shape._asdict(),
    }
    return Model(
        nodes=np.concatenate([mesh.nodes, points, middle, middle]) * d,
        tets=mesh.tets + 1,
        plates=plates,
        fixed=np.unique(mesh.front) + 1,
        turned=np.unique(mesh.back) + 1,
        edges=_edges(shape, mesh),
        ref=count + 1,
        rot=count + 2,
        angle=twist * scales,
        E=E,
        nu=shape.nu,
        material=material,
        mu=mu,
        penalty=penalty * E / d,
        increments=increments,
        about=about,
    )


def _edges(shape: Geometry, mesh: Tiled) -> Index:
    """Return the nodes on the two edges of the face without scales, which tell the local twist."""
    x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
    on = (abs(y + shape.lam) < 1e-6) & (abs(abs(x) - shape.width / 2) < 1e-6)
    return np.flatnonzero(on) + 1


def _grid(X: Array, Y: Array, Z: tuple[float, float]) -> tuple[Array, Index]:
    """Return the nodes (n, 3) of a layer of bricks and the bricks (m, 8), bottom face first, numbers from 0."""
    x, y = np.meshgrid(X, Y, indexing="ij")
    flat = np.stack([x.ravel(), y.ravel()], axis=1)
    nodes = np.concatenate([np.column_stack([flat, np.full(len(flat), z)]) for z in Z])
    i, j = (v.ravel() for v in np.meshgrid(np.arange(X.size - 1), np.arange(Y.size - 1), indexing="ij"))
    low = np.stack([i, i + 1, i + 1, i]) * Y.size + np.stack([j, j, j + 1, j + 1])
    return nodes, np.concatenate([low, low + len(flat)]).T


def _plates(shape: Geometry, mesh: Tiled, scales: int) -> tuple[Array, list[Plate]]:
    """Return the nodes of all contact bodies and reference points (pitches), and the bodies."""
    eta, beta = shape.eta, shape.beta
    across = np.linspace(-beta, beta, 1 + 2 * max(2, round(beta / 0.25)))
    coarse, plate = _grid(np.linspace(0, eta, 1 + max(2, round(eta / 0.5))), across, (-BODY, 0.0))
    fine = np.linspace(-beta, beta, 1 + 2 * max(8, round(beta / STRIP)))
    strip_nodes, strip = _grid(eta - np.array([0.12, 0.04, 0.0]) * min(1, eta), fine, (0.0, BODY))
    own = np.concatenate([coarse, strip_nodes, [[0.0, 0, 0]] * 2])
    top = np.flatnonzero(coarse[:, 2] == 0)
    places = [(0, -beta), (0, beta), (eta, beta), (eta, -beta)]
    corners = np.array([top[np.argmin(np.hypot(*(coarse[top, :2] - at).T))] for at in places])
    points, plates = [], []
    start = len(mesh.nodes) + 1
    for i in range(scales):
        points.append(shape.base + [0, 0, i] + own @ shape.axes)
        n = start + i * len(own)
        body = n + np.arange(len(own) - 2)
        plates.append(
            Plate(
                plate + n,
                strip + n + len(coarse),
                body,
                mesh.tied[i] + 1,
                corners + n,
                n + len(own) - 2,
                n + len(own) - 1,
            )
        )
    return np.concatenate(points), plates


# ---- what both dialects write alike ---------------------------------------------------------------------------------


def rows(numbers: Iterable[int], each: int = 16) -> list[str]:
    """Return numbers as data lines of at most ``each`` entries."""
    flat = [str(int(n)) for n in numbers]
    return [", ".join(flat[i : i + each]) for i in range(0, len(flat), each)]


def header(m: Model, words: Sequence[str]) -> list[str]:
    """Return the comment lines at the head of a deck; the marked one is read back by `squama.fe.ccx`."""
    lines = [
        f"scale-covered beam, {m.scales} scales, twisted to {m.about['twist_per_pitch']:.6g} rad per pitch",
        "mm, N, MPa; z is the torsion axis, y points out of the scaled face",
        *words,
    ]
    known = [MARK + json.dumps({key: value}) for key, value in m.about.items()]
    return ["*HEADING", f"squama {__version__}: {lines[0]}", *(f"** {line}" for line in lines), *known]


def mesh_lines(m: Model) -> list[str]:
    """Return nodes, elements and sets."""
    out = ["*NODE, NSET=NALL"]
    out += [f"{i}, {x:.9g}, {y:.9g}, {z:.9g}" for i, (x, y, z) in enumerate(m.nodes.tolist(), start=1)]
    out.append("*ELEMENT, TYPE=C3D10, ELSET=SUBSTRATE")
    number = 1
    for tet in m.tets.tolist():
        out.append(", ".join(map(str, [number, *tet])))
        number += 1
    for i, plate in enumerate(m.plates, start=1):
        for name, bricks in (("PLATE", plate.plate), ("STRIP", plate.strip)):
            out.append(f"*ELEMENT, TYPE=C3D8, ELSET={name}{i}")
            for brick in bricks.tolist():
                out.append(", ".join(map(str, [number, *brick])))
                number += 1
    sets = {"FIXED": m.fixed, "TURNED": m.turned, "EDGES": m.edges}
    sets["CORNERS"] = np.concatenate([plate.corners for plate in m.plates])
    for name, numbers in sets.items():
        out += [f"*NSET, NSET={name}", *rows(numbers)]
    return out


def section_lines(m: Model) -> list[str]:
    """Return materials and sections."""
    out = ["*MATERIAL, NAME=SUBSTRATE"]
    G = m.E / (2 * (1 + m.nu))
    if m.material == "elastic":
        out += ["*ELASTIC", f"{m.E:.9g}, {m.nu:.9g}"]
    else:
        bulk = m.E / (3 * (1 - 2 * m.nu))
        out += ["*HYPERELASTIC, NEO HOOKE", f"{G / 2:.9g}, {2 / bulk:.9g}"]
    out += ["*MATERIAL, NAME=RIGID", "*ELASTIC", f"{m.E:.9g}, 0.3"]
    out.append("*SOLID SECTION, ELSET=SUBSTRATE, MATERIAL=SUBSTRATE")
    for i in range(1, m.scales + 1):
        out += [f"*SOLID SECTION, ELSET={name}{i}, MATERIAL=RIGID" for name in ("PLATE", "STRIP")]
    for i in range(1, m.scales + 1):
        out += [f"*SURFACE, NAME=TIP{i}, TYPE=ELEMENT", f"STRIP{i}, S1"]
        out += [f"*SURFACE, NAME=FACE{i}, TYPE=ELEMENT", f"PLATE{i}, S2"]
    return out


def pair_lines(m: Model) -> list[str]:
    """Return the contact pairs: the tip strip of each scale on the face of the next."""
    out = []
    for i in range(1, m.scales):
        out += ["*CONTACT PAIR, INTERACTION=DRY, TYPE=SURFACE TO SURFACE", f"TIP{i}, FACE{i + 1}"]
    return out


def step_lines(m: Model) -> list[str]:
    """Return the beginning of the step."""
    first = 1 / m.increments
    return [
        f"*STEP, NLGEOM, INC={max(500, 20 * m.increments)}",
        "*STATIC",
        f"{first:.9g}, 1., 1e-6, {first:.9g}",
    ]


def write(m: Model, dialect: str) -> str:
    """Return the text of the deck.

    Parameters
    ----------
    m : Model
        From `model`.
    dialect : {"calculix", "abaqus"}
        The program that is to read it.

    Raises
    ------
    InputError
        Another dialect.
    """
    from squama.fe import deck_abaqus, deck_calculix

    dialects: dict[str, Callable[[Model], list[str]]] = {"calculix": deck_calculix.lines, "abaqus": deck_abaqus.lines}
    if dialect not in dialects:
        message = f'"{dialect}": is no program that a deck can be written for; give {" or ".join(dialects)}'
        raise InputError(message)
    return "\n".join(dialects[dialect](m)) + "\n"
