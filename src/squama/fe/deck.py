"""A beam of N scales as an input deck for CalculiX or Abaqus: mesh, scales, contact, and the twisted end.

Lengths in mm, forces in N, stresses in MPa. The substrate is N pitches of quadratic tetrahedra with the slots of the
scales in their true thickness. A scale is a rigid body: the walls of its slot, a coarse plate whose upper face is the
scale's upper face (master of the contact), and a fine strip along its tip edge whose lower face is the scale's lower
one (slave). If they are ``ideal`` both faces are the mid-plane: the plates are thin to each other, as in the theory.
Where the scales' modulus is known, the exposed part is a solid of bricks with incompatible modes (C3D8I) whose root
belongs to the rigid body; its own faces touch, and the coarse plate only shows the scale's attitude. The front end is
fixed; the back end is rigid, turned about the axis by N times the twist per pitch, and free to move along it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import arguments
from squama._version import __version__
from squama.beam.faces import only_one
from squama.beam.parts import PLASTIC
from squama.fe.closed import row_mesh
from squama.fe.geometry import Geometry, geometry
from squama.fe.mesh import Index, Tiled, pitch_mesh
from squama.types import Array

if TYPE_CHECKING:
    from squama.beam.design import Beam

SIZE, EDGE_SIZE = 0.3, 0.08
"""Sizes of the substrate's elements, and along the embedded scales' edges, in pitches."""
PENALTY = 300.0
"""Contact stiffness over E/d: pressure per penetration."""
STICK = 3.0
"""Slope of friction over slip while sticking, over the contact stiffness."""
INCREMENTS = 25
STRIP = 0.04
"""Size of the facets along the tip edge, in pitches."""
BLADE = 0.25
"""Size of bricks along an elastic scale, pitches; across the scale they have the size of the strip."""
LAYERS = 2
BODY = 0.02
"""Thickness of the rigid bodies of the contact faces, pitches; of no influence on results."""
MARK = "** squama: "
MOST_SCALES = 100
MATERIALS = ("neo-hookean", "elastic")


class Plate(NamedTuple):
    """Mesh of a scale: bricks (m, 8) of its contact bodies, their nodes, nodes of the slot's walls; numbered from 1.

    ``corners`` D, A, B, C of the exposed part (nodes of the coarse plate); ``tip`` and ``side``: nodes in order along
    the edges in contact; ``ref`` and ``rot``: reference nodes of translation and rotation. An elastic scale has a
    ``blade`` of bricks in place of the strip; ``under`` and ``upon`` are the numbers, from 0, of its bricks at the
    lower face of the tip and at the upper face.
    """

    plate: Index
    strip: Index
    nodes: Index
    tied: Index
    corners: Index
    tip: Index
    side: Index
    ref: int
    rot: int
    blade: Index
    under: Index
    upon: Index


class Model(NamedTuple):
    """Content of a deck in mm, N and MPa; node and element numbers begin with 1.

    ``nodes`` (n, 3), ``tets`` (m, 10), a ``Plate`` for each scale, ``sets`` of nodes with printed results or
    conditions, reference nodes of the turned end, its angle (rad, clockwise seen against the axis), material and
    contact; ``about``: data written to the head of the deck.
    """

    nodes: Array
    tets: Index
    plates: list[Plate]
    sets: dict[str, Index]
    ref: int
    rot: int
    angle: float
    material: str
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
    increments: int = INCREMENTS,
    ideal: bool = False,
) -> Model:
    """Mesh a beam of ``scales`` pitches (2 to 100) and return all data of its deck.

    ``twist``: per pitch at the end, rad, above 0; ``size``, ``edge_size`` of elements, pitches; ``material`` of the
    substrate, one of :data:`MATERIALS`; ``increments``: their number if none is cut; ``ideal``: rigid, thin scales.
    Raises InputError where an argument is out of range, or the mesher is missing or fails.
    """
    only_one(beam.faces, "a deck")
    scales = arguments.whole("scales", scales, 2, MOST_SCALES)
    increments = arguments.whole("increments", increments, 1, 10_000)
    arguments.not_negative("mu", mu)
    arguments.positive("twist", twist)
    arguments.one_of("material", material, MATERIALS)
    shape = geometry(beam)
    mesh = row_mesh(pitch_mesh(shape, size, edge_size), shape.oblique, scales)
    d, E = beam.pitch * 1e3, beam.substrate.youngs_modulus * 1e-6
    elastic = not ideal and beam.scale.youngs_modulus is not None
    points, plates = _plates(shape, mesh, 0.0 if ideal else shape.thickness, elastic=elastic)
    count = len(mesh.nodes) + len(points)
    middle = np.array([[0.0, 0.0, shape.oblique.start + scales + shape.oblique.pitches]])
    # the two edges of the face without scales tell the local twist
    x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
    edges = np.flatnonzero((abs(y + shape.lam) < 1e-6) & (abs(abs(x) - shape.width / 2) < 1e-6)) + 1
    sets = {"FIXED": np.unique(mesh.ends[0]) + 1, "TURNED": np.unique(mesh.ends[1]) + 1, "EDGES": edges}
    about = {"version": __version__, "scales": scales, "pitch_mm": d, "twist_per_pitch": twist, "E_MPa": E, "mu": mu}
    if elastic:
        nu = beam.scale.poisson_ratio
        about |= {"E_scale_MPa": beam.modulus_ratio * E, "nu_scale": PLASTIC if nu is None else nu}
    for name in ("corners", "tip", "side"):
        sets[name.upper()] = np.concatenate([getattr(plate, name) for plate in plates])
    return Model(
        nodes=np.concatenate([mesh.nodes, points, middle, middle]) * d,
        tets=mesh.tets + 1,
        plates=plates,
        sets=sets,
        ref=count + 1,
        rot=count + 2,
        angle=twist * scales,
        material=material,
        penalty=PENALTY * E / d,
        increments=increments,
        about={**about, **shape._asdict()},
    )


def _grid(X: Array, Y: Array, Z: Array) -> tuple[Array, Index]:
    """Return the nodes (n, 3) of layers of bricks and the bricks (m, 8), bottom face first, numbers from 0."""
    x, y = (v.ravel() for v in np.meshgrid(X, Y, indexing="ij"))
    nodes = np.concatenate([np.column_stack([x, y, np.full(x.size, z)]) for z in Z])
    i, j = (v.ravel() for v in np.meshgrid(np.arange(X.size - 1), np.arange(Y.size - 1), indexing="ij"))
    low = np.stack([i, i + 1, i + 1, i]) * Y.size + np.stack([j, j, j + 1, j + 1])
    bricks = np.concatenate([low, low + x.size]).T
    return nodes, np.concatenate([bricks + k * x.size for k in range(Z.size - 1)])


def _along(nodes: Array, where: Array, axis: int) -> Index:
    """Return the numbers of the nodes where ``where`` (n,) is true, sorted along an axis."""
    found = np.flatnonzero(where)
    return found[np.argsort(nodes[found, axis])]


def _plates(shape: Geometry, mesh: Tiled, h: float, *, elastic: bool) -> tuple[Array, list[Plate]]:
    """Return the nodes of all scales and reference points (pitches), and the scales, of contact thickness h."""
    eta, beta = shape.eta, shape.beta
    across = np.linspace(-beta, beta, 1 + 2 * max(2, round(beta / 0.25)))
    coarse, plate = _grid(np.linspace(0, eta, 1 + max(2, round(eta / 0.5))), across, np.array([-BODY, 0.0]) + h / 2)
    fine = np.linspace(-beta, beta, 1 + 2 * max(8, round(beta / STRIP)))
    last = eta - np.array([0.12, 0.04, 0.0]) * min(1, eta)
    if elastic:
        X = np.concatenate([np.linspace(0, last[0], 1 + max(2, round(last[0] / BLADE))), last[1:]])
        Z = np.linspace(-h / 2, h / 2, 1 + LAYERS)
    else:
        X, Z = last, np.array([0.0, BODY]) - h / 2
    own, bricks = _grid(X, fine, Z)
    nodes = np.concatenate([coarse, own, [[0.0, 0, 0]] * 2])
    low, high = own[:, 2] == Z[0], coarse[:, 2] == h / 2
    top = np.flatnonzero(high)
    corners = [(0, -beta), (0, beta), (eta, beta), (eta, -beta)]
    corner = np.array([top[np.argmin(np.hypot(*(coarse[top, :2] - at).T))] for at in corners])
    begin, end = len(coarse), len(nodes) - 2
    tip = begin + _along(own, low & (own[:, 0] == eta), 1)
    side = _along(coarse, high & (coarse[:, 1] == -beta), 0)
    moved, blade, under, upon = np.arange(end), bricks[:0], bricks[:0, 0], bricks[:0, 0]
    if elastic:
        side = begin + _along(own, (own[:, 2] == Z[-1]) & (own[:, 1] == -beta), 0)
        moved, blade = np.append(np.arange(begin), begin + np.flatnonzero(own[:, 0] == 0)), bricks + begin
        middle = own[bricks].mean(axis=1)
        under = np.flatnonzero((middle[:, 2] < Z[1]) & (middle[:, 0] > last[0]))
        upon = np.flatnonzero(middle[:, 2] > Z[-2])
        bricks = bricks[:0]
    points, plates = [], []
    for i in range(len(mesh.tied)):
        points.append(shape.rest.base + [0, 0, i] + nodes @ shape.rest.axes)
        n = len(mesh.nodes) + 1 + i * len(nodes)
        bodies, lines = (plate + n, begin + bricks + n, moved + n, mesh.tied[i] + 1), (corner + n, tip + n, side + n)
        plates.append(Plate(*bodies, *lines, n + end, n + end + 1, blade + n, under, upon))
    return np.concatenate(points), plates


def rows(numbers: Iterable[int], each: int = 16) -> list[str]:
    """Return numbers as data lines of at most ``each`` entries."""
    flat = [str(int(n)) for n in numbers]
    return [", ".join(flat[i : i + each]) for i in range(0, len(flat), each)]


def write(m: Model, dialect: str) -> str:
    """Return the text of the deck for a program, one of :data:`DIALECTS`; refuse another name."""
    arguments.one_of("dialect", dialect, tuple(DIALECTS))
    return "\n".join(DIALECTS[dialect](m)) + "\n"


def _lines(
    m: Model, words: Iterable[str], sets: list[str], bodies: list[str], friction: str, held: list[str], moved: list[str]
) -> list[str]:
    """Return the lines of a deck; marked comments carry the data for `squama.fe.ccx`.

    Parts that depend on the dialect: comments of the head, sets, rigid bodies, the line of friction, initial
    conditions, and conditions and output of the step.
    """
    said = f"scale-covered beam, {m.scales} scales, twisted to {m.about['twist_per_pitch']:.6g} rad per pitch"
    axes = "mm, N, MPa; z is the torsion axis, y points out of the scaled face"
    out = ["*HEADING", f"squama {__version__}: {said}", *(f"** {line}" for line in (said, axes, *words))]
    out += [MARK + json.dumps({key: value}) for key, value in m.about.items()]
    out.append("*NODE, NSET=NALL")
    out += [f"{i}, {x:.9g}, {y:.9g}, {z:.9g}" for i, (x, y, z) in enumerate(m.nodes.tolist(), start=1)]
    elastic = len(m.plates[0].blade) > 0
    kinds = ("PLATE", "BLADE") if elastic else ("PLATE", "STRIP")
    parts = {f"{name}{i}": getattr(p, name.lower()) for i, p in enumerate(m.plates, 1) for name in kinds}
    number, faces = 1, []
    for name, cells in {"SUBSTRATE": m.tets, **parts}.items():
        kind = "C3D10" if name == "SUBSTRATE" else "C3D8I" if name.startswith("BLADE") else "C3D8"
        out.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        out += [", ".join(map(str, [i, *cell])) for i, cell in enumerate(cells.tolist(), start=number)]
        if kind == "C3D8I":
            i = int(name.removeprefix("BLADE"))
            for label, some in (("UNDER", m.plates[i - 1].under), ("UPON", m.plates[i - 1].upon)):
                faces += [f"*ELSET, ELSET={label}{i}", *rows(some + number)]
        number += len(cells)
    out += faces
    for name, numbers in m.sets.items():
        out += [f"*NSET, NSET={name}", *rows(numbers)]
    E, nu = m.about["E_MPa"], m.about["nu"]
    if m.material == "elastic":
        law = ["*ELASTIC", f"{E:.9g}, {nu:.9g}"]
    else:
        G, bulk = E / (2 * (1 + nu)), E / (3 * (1 - 2 * nu))
        law = ["*HYPERELASTIC, NEO HOOKE", f"{G / 2:.9g}, {2 / bulk:.9g}"]
    out += [*sets, "*MATERIAL, NAME=SUBSTRATE", *law, "*MATERIAL, NAME=RIGID", "*ELASTIC", f"{E:.9g}, 0.3"]
    if elastic:
        out += ["*MATERIAL, NAME=SCALE", "*ELASTIC", f"{m.about['E_scale_MPa']:.9g}, {m.about['nu_scale']:.9g}"]
    out.append("*SOLID SECTION, ELSET=SUBSTRATE, MATERIAL=SUBSTRATE")
    for name in parts:
        out.append(f"*SOLID SECTION, ELSET={name}, MATERIAL={'SCALE' if name.startswith('BLADE') else 'RIGID'}")
    below, above = ("UNDER", "UPON") if elastic else ("STRIP", "PLATE")
    for i in range(1, m.scales + 1):
        out += [f"*SURFACE, NAME=TIP{i}, TYPE=ELEMENT", f"{below}{i}, S1"]
        out += [f"*SURFACE, NAME=FACE{i}, TYPE=ELEMENT", f"{above}{i}, S2"]
    out += [*bodies, "*SURFACE INTERACTION, NAME=DRY", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    out += [f"{m.penalty:.9g}", *(["*FRICTION", friction] if m.about["mu"] > 0 else [])]
    # a tip's strip on the next face
    for i in range(1, m.scales):
        out += ["*CONTACT PAIR, INTERACTION=DRY, TYPE=SURFACE TO SURFACE", f"TIP{i}, FACE{i + 1}"]
    first = f"{1 / m.increments:.9g}"
    out += ["*BOUNDARY", "FIXED, 1, 3, 0.", *held, f"*STEP, NLGEOM, INC={max(500, 20 * m.increments)}", "*STATIC"]
    return [*out, f"{first}, 1., 1e-6, {first}", "*BOUNDARY", *moved, "*END STEP"]


# ---- the dialects ---------------------------------------------------------------------------------------------------


def _calculix(m: Model) -> list[str]:
    """Return a CalculiX deck: rigid bodies with a rotation node each, friction with a stick slope."""
    words = (
        "for CalculiX 2.20 or later: run it with ccx and the name of this file without .inp",
        "every increment prints what squama.fe.ccx reads: corners of the scales, two edges of the bar, reactions",
    )
    sets, bodies, moved = [], [], [f"{m.rot}, 3, 3, {-m.angle:.9g}"]
    for i, plate in enumerate(m.plates, start=1):
        sets += [f"*NSET, NSET=BODY{i}", *rows([*plate.tied, *plate.nodes])]
        bodies.append(f"*RIGID BODY, NSET=BODY{i}, REF NODE={plate.ref}, ROT NODE={plate.rot}")
    bodies.append(f"*RIGID BODY, NSET=TURNED, REF NODE={m.ref}, ROT NODE={m.rot}")
    for name, what in (("CORNERS", "U"), ("TIP", "U"), ("SIDE", "U"), ("EDGES", "U"), ("FIXED", "RF")):
        moved += [f"*NODE PRINT, NSET={name}", what]
    moved += ["*NODE FILE", "U", "*EL FILE", "S"]
    friction, held = f"{m.about['mu']:.9g}, {STICK * m.penalty:.9g}", [f"{m.ref}, 1, 2, 0.", f"{m.rot}, 1, 2, 0."]
    return _lines(m, words, sets, bodies, friction, held, moved)


def _abaqus(m: Model) -> list[str]:
    """Return an Abaqus deck by the keyword reference; it was never run in Abaqus."""
    words = (
        "for Abaqus/Standard: THIS DECK WAS NEVER RUN IN ABAQUS, only its syntax was checked; look at the contact in",
        "every increment before you trust a curve",
    )
    moved = [f"HAND, 6, 6, {-m.angle:.9g}", "*OUTPUT, FIELD, FREQUENCY=1", "*NODE OUTPUT", "U, RF", "*ELEMENT OUTPUT"]
    moved += ["S, LE", "*CONTACT OUTPUT", "CSTRESS, CDISP", "*OUTPUT, HISTORY, FREQUENCY=1"]
    moved += ["*NODE OUTPUT, NSET=HAND", "UR3, RM3"]
    sets, bodies = [], []
    for i, plate in enumerate(m.plates, start=1):
        # the root of an elastic scale is tied like the walls of the slot
        root = plate.nodes[np.isin(plate.nodes, plate.blade)]
        sets += [f"*NSET, NSET=TIED{i}", *rows([*plate.tied, *root])]
        sets += [f"*NSET, NSET=REF{i}", str(plate.ref), f"*ELSET, ELSET=SCALE{i}"]
        sets.append(f"PLATE{i}" if len(plate.blade) else f"PLATE{i}, STRIP{i}")
        bodies.append(f"*RIGID BODY, REF NODE={plate.ref}, ELSET=SCALE{i}, PIN NSET=TIED{i}")
        moved += [f"*NODE OUTPUT, NSET=REF{i}", "U1, U2, U3, UR1, UR2, UR3"]
    sets += ["*NSET, NSET=HAND", str(m.ref)]
    bodies.append(f"*RIGID BODY, REF NODE={m.ref}, PIN NSET=TURNED")
    return _lines(m, words, sets, bodies, f"{m.about['mu']:.9g}", ["HAND, 1, 2, 0.", "HAND, 4, 5, 0."], moved)


DIALECTS: dict[str, Callable[[Model], list[str]]] = {"calculix": _calculix, "abaqus": _abaqus}
"""Function that returns the lines of a deck, by program."""
