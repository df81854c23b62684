"""One tile: its cells solved, in the units of the store."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from squama.design import Beam
from squama.model.solve import Array
from squama.study.cells import cells
from squama.study.columns import in_si, solved
from squama.study.plan import VARIABLES, Plan, Tile

_FAR = np.iinfo(np.int16).max


@functools.lru_cache(maxsize=4)
def _beam(text: str) -> Beam:
    return Beam.from_toml_text(text)


def compute(plan: Plan, tile: Tile) -> dict[str, Array]:
    """Solve the cells of a tile.

    Parameters
    ----------
    plan : Plan
        The sweep.
    tile : tuple of int
        Which tile.

    Returns
    -------
    dict of str to array
        Every variable of the store, in the shape of the tile. Torque in N m, energies in J/m, angles in rad.
    """
    place = dict(zip(plan.dims, plan.place(tile), strict=True))
    law = plan.laws[place.pop("law").start if "law" in place else 0]
    mesh = np.ix_(*(axis.values[place[axis.name]] for axis in plan.axes))
    values: dict[str, Any] = {axis.name: v for axis, v in zip(plan.axes, mesh, strict=True)}
    margin = float(values.pop("margin").item() if plan.margin is None else plan.margin)
    c = cells(_beam(plan.beam_toml), plan.load, values)
    s = solved(c, law=law, sense=plan.sense, margin=margin, load=plan.load, engine=plan.engine)
    found = in_si(c, s)
    found["neighbour"] = np.minimum(s.neighbour, _FAR)
    shape = tuple(part.stop - part.start for part in plan.place(tile))
    whole = tuple(n for n, dim in zip(shape, plan.dims, strict=True) if dim != "law")
    return {
        name: np.broadcast_to(found[variable.field], whole).astype(variable.dtype).reshape(shape)
        for name, variable in VARIABLES[plan.load].items()
    }
