"""Cells of a sweep that are held bent while they are twisted: thin, rigid scales on hinges, path by path."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from squama.beam.design import Beam
from squama.curves.bent_twist import Twisted
from squama.model.outcome import CODES, End
from squama.study.columns import beam_at
from squama.study.parameters import HELD
from squama.types import Array

_ENDS, _AT_CUT = ("load_e", "load_end", "theta_end", "neighbour"), ("torque", "U_el", "W_fr", "RED")


def twisted(
    beam: Beam, values: Mapping[str, Array], shape: tuple[int, ...], *, sense: str, margin: float
) -> dict[str, Array]:
    """Return the figures of cells whose parameters are ``values`` (broadcasting), in arrays of a shape.

    By the names and units of :func:`squama.study.columns.solved`; twists count from the bent beam on, 0 where it comes
    to no twist; NaN at the cut-off then.
    """
    columns = np.broadcast_arrays(*values.values(), np.empty(shape))[:-1]
    found: dict[str, Array] = {name: np.full(shape, math.nan) for name in (*_ENDS, "code", "f0", *_AT_CUT)}
    for cell in np.ndindex(shape):
        here = {name: float(v[cell]) for name, v in zip(values, columns, strict=True)}
        for name, value in _figures(beam_at(beam, "twisting", here), here[HELD], sense, margin).items():
            found[name][cell] = value
    return found


def _figures(beam: Beam, psi: float, sense: str, margin: float) -> dict[str, float]:
    """Return the figures of one beam; NaN is left out."""
    path = Twisted.tried(beam, psi, mu=float(beam.friction.mu or 0.0), sense=sense, margin=margin, joint="hinge")
    if not path.bent:
        theta, end = float(path.answer["theta_end"]), str(path.answer["end"])
        found = {"load_e": 0.0, "load_end": 0.0, "theta_end": theta, "neighbour": 1}
    else:
        curve = path.curve(points=2)
        f, end = curve.figures, str(curve.figures["end"])
        found = {name: float(f[name]) for name in _ENDS} | {name: float(f[f"{name}_c"]) for name in _AT_CUT}
        found["f0"] = float(curve.along["f"][-1]) * beam.scale.length / path.case.stiffness
    return found | {"code": CODES.index(End(end))}
