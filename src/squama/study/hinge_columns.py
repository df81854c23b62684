"""Figures of many beams with thin or thick, rigid scales on hinges; compare :mod:`squama.study.compliant_columns`.

Straight beams are solved together, in closed form; of beams that are held bent each path is followed alone.
"""

from __future__ import annotations

import math

import numpy as np

from squama import arguments, batch
from squama.beam.design import Beam
from squama.curves.bent_twist import Twisted
from squama.model.outcome import CODES, End
from squama.study.columns import Cells, beam_of
from squama.types import Array

_CONTACT = ("eta", "beta", "lam", "alpha", "theta0", "mu")
_ENDS, AT_CUT = ("load_e", "load_end", "theta_end", "neighbour"), ("torque", "U_el", "W_fr", "RED")
"""Figures at the ends of a curve, and at its cut-off."""


def solved(
    c: Cells,
    *,
    law: str = "edge",
    sense: str = "+",
    margin: float = 0.01,
    load: str = "twisting",
    few: int | None = None,
    ideal: bool = True,
) -> dict[str, Array]:
    """Solve the beams of columns; arguments as of :func:`squama.solve`; ``ideal``: scales are thin.

    Returns the fields of its result in SI units: torque in N m, energies in J/m, twists in rad per pitch (divide by
    ``c.d`` for rates). A beam whose joint has no stiffness responds as without contact; rows that are no valid beam are
    refused. Up to ``few`` rows are solved in Python, more in compiled code, whose last digits differ: a caller that
    solves in parts sets ``few`` by the size of the whole (0: compiled), so that results do not depend on the parts.
    """
    given = {name: getattr(c, name) for name in _CONTACT} | {"stiffness_ratio": c.ratio}
    if not ideal:
        given["thickness"] = c.sizes["scale"]["thickness"] / c.d
    rows, shape = arguments.designs(load, **given)
    flat = batch.solved(tuple(rows), law=law, sense=sense, margin=margin, load=load, few=few)
    found: dict[str, Array] = {name: v.reshape(shape) for name, v in flat._asdict().items()}
    for name, unit in (("torque", c.K), ("U_el", c.K / c.d), ("W_fr", c.K / c.d)):
        found[name] = found[name] * unit
    if not np.all(c.K > 0):
        bare, rate = ~np.broadcast_to(c.K > 0, found["torque"].shape), found["load_c"] / c.d
        found["torque"] = np.where(bare, c.rigidity * rate, found["torque"])
        found["U_el"] = np.where(bare, c.rigidity * rate**2 / 2, found["U_el"])
        found["RED"] = np.where(bare, 0.0, found["RED"])
    return found


def bent(beam: Beam, c: Cells, shape: tuple[int, ...], *, sense: str, margin: float) -> dict[str, Array]:
    """Return figures of beams that are twisted while they are held bent, arrays of shape ``shape``.

    Names and units as of :func:`solved`, only the variables of a sweep. Twists count from the bent, untwisted beam; a
    beam that ends before any twist has ``load_e`` = ``load_end`` = 0 and NaN at the cut-off.
    """
    found: dict[str, Array] = {name: np.full(shape, math.nan) for name in (*_ENDS, "code", "f0", *AT_CUT)}
    psi, mu = (np.broadcast_to(np.asarray(v), shape) for v in (c.psi, c.mu))
    for cell in np.ndindex(shape):
        one = beam_of(beam, c, shape, cell)
        for name, value in _figures(one, float(psi[cell]), float(mu[cell]), sense, margin).items():
            found[name][cell] = value
    return found


def _figures(beam: Beam, psi: float, mu: float, sense: str, margin: float) -> dict[str, float]:
    """Return the figures of one beam by name; figures that are NaN are left out."""
    path = Twisted.tried(beam, psi, mu=mu, sense=sense, margin=margin, joint="hinge")
    if not path.bent:
        theta, end = float(path.answer["theta_end"]), str(path.answer["end"])
        found = {"load_e": 0.0, "load_end": 0.0, "theta_end": theta, "neighbour": 1}
    else:
        curve = path.curve(points=2)
        f, end = curve.figures, str(curve.figures["end"])
        found = {name: float(f[name]) for name in _ENDS} | {name: float(f[f"{name}_c"]) for name in AT_CUT}
        found["f0"] = float(curve.along["f"][-1]) * beam.scale.length / path.case.stiffness
    return found | {"code": CODES.index(End(end))}
