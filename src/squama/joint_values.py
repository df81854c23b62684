"""K_theta and C_f of a beam: as given, from the joint's matrix, or by the scaling laws of `squama.model.joint`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from squama.matrixfile import SCALING, SHAPE, StoredMatrix
from squama.model import joint

if TYPE_CHECKING:
    from squama.design import Beam
    from squama.model.solve import Array


def stiffness(beam: Beam, load: str) -> float:
    """Return K_theta of one scale, N m; the matrix is one for twisting."""
    given, matrix = beam.joint.stiffness, beam.joint.matrix
    if given is not None:
        return given
    if load == "twisting" and matrix is not None:
        return matrix.K_theta * beam.substrate.youngs_modulus * beam.pitch**3
    width = beam.scale.width / 2 if load == "twisting" else beam.scale.width
    law = joint.LAWS[f"stiffness {load}"]
    return law.value(beam.substrate.youngs_modulus, beam.scale.thickness, width, beam.scale.embedded)


def inclusion(beam: Beam, load: str) -> float:
    """Return C_f; the matrix is one for twisting."""
    given, matrix = beam.joint.inclusion_factor, beam.joint.matrix
    if given is not None:
        return given
    if load == "twisting" and matrix is not None:
        return matrix.rigidity * beam.substrate.youngs_modulus * beam.pitch**4 / (beam.G_B * beam.J)
    return joint.LAWS[f"inclusion {load}"].value(beam.zeta, beam.beta, beam.lam)


def made_for(beam: Beam) -> dict[str, float]:
    """Return what a joint's matrix depends on, SI values by "table.key"."""
    parts = {"scale": beam.scale, "substrate": beam.substrate, "beam": beam}
    return {name: float(getattr(parts[name.partition(".")[0]], name.partition(".")[2])) for name in (*SCALING, *SHAPE)}


def stored(beam: Beam, K: Array, name: str = "matrix") -> StoredMatrix:
    """Return a matrix (7, 7) in units of the pitch and the substrate's modulus as a file holds it, SI."""
    import numpy as np

    d, E = beam.pitch, beam.substrate.youngs_modulus
    unit = np.array([d, d, d, 1.0, 1.0, 1.0, 1.0])
    return StoredMatrix(K * E * d**3 / np.outer(unit, unit), made_for(beam), name)
