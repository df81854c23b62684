"""Derived quantities of states: energies, stresses, inclinations, loads on the embedded part; E = d = 1."""

from __future__ import annotations

import numpy as np

from squama.beam.matrixfile import of_strains
from squama.contacts import entry
from squama.contacts.path import COLUMNS, TILTED, Answers, Path, Scale, deflections, motions, named
from squama.contacts.system import EPS, PHI, PSI, STRAINS
from squama.model import elastic_plate as plate
from squama.model.screw import rotations
from squama.types import Array

THIN = 0.1
"""Deflection over the length from which the model of small deflections is not valid."""
_GRID = np.array([(x, y) for x in np.linspace(0.0, 1.0, 13) for y in np.linspace(-1.0, 1.0, 9)])
"""Places at which stresses are evaluated: shares of length and half width."""
_CURVED = plate.curvatures(*_GRID.T)
_BLOCK = 64
"""States whose stresses are computed at once, to fit the cache; fixed, because other sizes differ in the last digits.
"""


def energies(path: Path, rows: Array, other: Array | None = None) -> dict[str, Array]:
    """Return the elastic energy (n,) of joint, plate and bar, E d^3 per pitch: roles U_joint, U_plate, U_bar.

    ``other``: states of the other face, if it has scales.
    """
    whole, alone = of_springs(path, rows, other), bare(path.beams)[0]
    loads = motions(rows)[:, 6 : 6 + len(alone)]
    bar = np.einsum("ni,ij,nj->n", loads, alone, loads) / 2
    return {"U_joint": whole - bar, "U_plate": named(rows)["energy"] - whole, "U_bar": bar}


def of_springs(path: Path, rows: Array, other: Array | None = None) -> Array:
    """Return the elastic energy (n,) of joint and bar, E d^3 per pitch; arguments as in :func:`energies`."""
    K, aside = path.beams.K[0], named(rows)["aside"]
    q = motions(rows)[:, : len(K)]
    whole = np.einsum("ni,ij,nj->n", q, K, q) / 2 + named(rows)["tilt"] ** 2 / 2
    if len(K) == 9:
        whole = whole + path.beams.aside[0] * K[7, 7] * aside**2 / 2
    if other is None:
        return np.asarray(whole)
    strains = rows[:, [COLUMNS.index(name) for name in ("psi", "twist", "aside", "stretch")]]
    bar = strains**2 @ path.beams.own[0] / 2
    # with the strains that the other face sees
    seen = other.copy()
    for name, sign in zip(("psi", "twist", "aside"), path.beams.seen[0], strict=True):
        seen[:, COLUMNS.index(name)] *= sign
    return np.asarray(whole + of_springs(path, seen) - bar)


def bare(beams: entry.Beams) -> Array:
    """Return the stiffness (n, 1, 1) of beams without contact against twist, or (n, 2, 2) against twist and bend.

    All beams have the same free strains; the stiffness against a free strain is 0.
    """
    K, free = beams.K, np.real(beams.free[0]) > 0 if len(beams.K) else np.zeros(STRAINS, bool)
    scales, strains = 6, K.shape[1] - 6
    if beams.seen.shape[1]:
        K, scales = of_strains(K, beams.seen, beams.own), 0
    gives = [scales + row for row, strain in enumerate((PHI, PSI, EPS)[:strains]) if free[strain]]
    loose = [*range(scales), *gives]
    loads = [row for row in range(scales, scales + min(2, strains)) if row not in loose]
    across = K[:, loose][:, :, loads]
    given = np.linalg.solve(K[:, loose][:, :, loose], across)
    out, place = np.zeros((len(K), *[min(2, strains)] * 2), K.dtype), np.array(loads, int) - scales
    out[:, place[:, None], place] = K[:, loads][:, :, loads] - across.swapaxes(1, 2) @ given
    return out


def stresses(scale: Scale, bent: Array) -> tuple[Array, Array]:
    """Return the largest stress (von Mises, E) in a scale, by Kirchhoff's moments 6 m / h^2, and its place (n, 2).

    From deflections (n, 24) of one scale or of n; the place is NaN without stress.
    """
    n, most = len(bent), np.zeros(len(bent), int)
    eta, beta, _, _, _, h, D, nu = (np.broadcast_to(np.reshape(v, (-1, 1)), (n, 1)) for v in scale)
    # m_x^2 - m_x m_y + m_y^2 + 3 m_xy^2 by the curvatures along the length and the width, and their twist
    own, mixed, twist = 1 - nu + nu * nu, 4 * nu - 1 - nu * nu, 3 * (1 - nu) ** 2
    scaled, squared = (bent / eta**2, bent / beta**2, bent / (eta * beta)), np.zeros(n, bent.dtype)
    for low in range(0, n, _BLOCK):
        some = slice(low, min(n, low + _BLOCK))
        part = [np.zeros((_BLOCK, 24), bent.dtype) for _ in scaled]
        for room, v in zip(part, scaled, strict=True):
            room[: some.stop - low] = v[some]
        xx, yy, xy = ((v @ C)[: some.stop - low] for v, C in zip(part, _CURVED, strict=True))
        whole = own[some] * (xx * xx + yy * yy) + mixed[some] * (xx * yy) + twist[some] * (xy * xy)
        most[some] = np.real(whole).argmax(axis=1)
        squared[some] = whole[np.arange(len(whole)), most[some]]
    largest = 6 * (D / h**2).ravel() * np.sqrt(squared)
    places = _GRID[most] * np.column_stack([eta.ravel(), beta.ravel()])
    return largest, np.where(np.real(largest[:, None]) > 0, places, np.nan)


def stresses_of(scale: Scale, found: Answers) -> Array:
    """Return the largest stresses (n, m) of n beams at their targets; NaN for rigid scales."""
    rows = found.rows
    told = np.real(rows[..., 0])
    stress = np.where(np.asarray(scale.elastic)[:, None] & np.isfinite(told), 0.0 * rows[..., 0], np.nan)
    # without contact nothing bends
    which, column = np.nonzero(np.isfinite(stress) & (np.real(named(rows)["N"]) > 0))
    one = Scale(*(np.asarray(v)[which] for v in scale))
    stress[which, column] = stresses(one, deflections(rows[which, column]))[0]
    return stress


def plate_figures(scale: Scale, bent: Array) -> dict[str, Array]:
    """Return the deformation of a scale from its deflections (n, 24), by role; E = d = 1.

    Deflection of the middle of its tip along its normal, rotation of the tip about its length from that of its corners,
    largest stress and its place; NaN stress in a rigid scale.
    """
    b = bent.reshape(len(bent), 6, 4)
    told = {"deflection": b[:, :, 0].sum(axis=1), "scale_twist": b[:, :, 1::2].sum(axis=(1, 2)) / scale.beta}
    if not scale.elastic:
        return told | dict.fromkeys(("stress", "stress_x", "stress_y"), np.full(len(b), np.nan))
    stress, places = stresses(scale, bent)
    return told | {"stress": stress, "stress_x": places[:, 0], "stress_y": places[:, 1]}


def bent(scale: Scale, rows: Array) -> Array:
    """Return the largest deflection of the tip's corners over the length (n,) in states."""
    b = deflections(rows).reshape(len(rows), 6, 4)
    even, odd = b[:, :, ::2].sum(axis=(1, 2)), b[:, :, 1::2].sum(axis=(1, 2))
    return np.asarray((np.abs(even) + np.abs(odd)) / scale.eta)


def inclinations(path: Path, rows: Array) -> Array:
    """Return the angle (n,) of n_X to the beam's face, seen along the width at rest, rad."""
    theta0 = path.scale.theta0
    x = rotations(displaced(path, rows)[:, 3:])[:, :, 0]
    # n_X and n_Z at rest are turned by theta0 from the face, about n_Y
    return np.asarray(theta0 + np.arctan2(x[:, 2], x[:, 0]))


def displaced(path: Path, rows: Array) -> Array:
    """Return the six motions (n, 6) of a scale in states, with its tilt."""
    whole = motions(rows)[:, :6]
    whole[:, TILTED] += named(rows)["tilt"][:, None] * path.beams.tilts[0]
    return whole


def on_tab(path: Path, q: Array) -> tuple[Array, Array]:
    """Return force (E d^2) and moment (E d^3) of the contacts on the embedded part, about its base midpoint.

    Both (n, 3) from its :func:`motions`, in the scale's own axes, which turn with it; a force along n_X pulls it out.
    """
    K = path.beams.K[0]
    loads, w, turns = q[:, : len(K)] @ K[:6].T, q[:, 3:6], rotations(q[:, 3:6])
    # the quantity conjugate to a rotation vector is not yet the moment
    t = np.linalg.norm(w, axis=1)[:, None]
    k = (1 - np.cos(t / 2) / np.sinc(t / (2 * np.pi))) / np.maximum(t, 1e-100) ** 2
    once = np.cross(w, loads[:, 3:])
    force, moment = loads[:, :3], loads[:, 3:] + once / 2 + k * np.cross(w, once)
    return np.einsum("ni,nij->nj", force, turns), np.einsum("ni,nij->nj", moment, turns)
