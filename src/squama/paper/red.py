"""The relative energy dissipation of many designs, and its maps (paper Eqs. 15, 16 and Fig. 7)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from squama.design import Beam
from squama.model import energy, solution
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY
from squama.model.solve import Array
from squama.paper.maps import Ratios, ends, mu_static, sweep, touch
from squama.symbols import SYMBOLS


def dissipation(beam: Beam, r: Ratios, mu: Array, law: str, margin: float) -> tuple[Array, solution.Solution]:
    """RED at the cut-off of many designs on one substrate (paper Eqs. 15, 16), and their ends."""
    sol = ends(r, mu, law)
    red = np.zeros(r.eta.size)
    softness = beam.torsional_rigidity / (beam.joint_stiffness * beam.pitch)
    for index, t in sol.tracks:
        locks = np.isin(t.code, (CODES.index(End.FRICTIONAL), CODES.index(End.KINEMATIC)))
        x_c = energy.cutoff(t.row, t.x0, t.x_end, locks, margin)
        pole = energy.pole(t.row, t.x_end, mu[index], law, t.x0)
        W = energy.works(t.row, t.x0, x_c, pole, mu[index], law)
        with np.errstate(all="ignore"):
            pt = t.row.point(x_c, law, ARRAY)
            lift = pt.theta - r.theta0[index]
            elastic = (softness * pt.load**2 + lift**2) / 2
        red[index] = np.where(W > 0, W / (elastic + W), 0.0)
    return red, sol


def red_map(
    beam: Beam,
    over: str,
    values: Array,
    mus: Array,
    laws: Sequence[str] = ("plate", "edge"),
    margin: float = 0.01,
) -> xr.Dataset:
    """Compute RED over one ratio and the coefficient of friction; the substrate and the joint stay as they are.

    Parameters
    ----------
    beam : Beam
        The design.
    over : {"eta", "alpha"}
        The ratio that is varied.
    values, mus : array
        Its values, and coefficients of friction.
    laws : sequence of str
        Force laws.
    margin : float
        Cut-off before a lock.

    Returns
    -------
    xarray.Dataset
        ``RED``, ``end``, ``phi_end`` over ``law``, ``value`` and ``mu``; ``mu_static`` over ``law`` and ``value``;
        ``phi_touch`` over ``value``.
    """
    v, m = (a.ravel() for a in np.meshgrid(values, mus, indexing="ij"))
    shape = (len(laws), values.size, mus.size)
    red, phi, end = np.empty(shape), np.empty(shape), np.empty(shape, "U24")
    r = sweep(beam, over, v)
    words = np.array([str(e) for e in CODES])
    for i, law in enumerate(laws):
        flat, sol = dissipation(beam, r, m, law, margin)
        red[i], phi[i] = flat.reshape(shape[1:]), sol.load_end.reshape(shape[1:])
        end[i] = words[sol.code].reshape(shape[1:])
    axes = ("law", "value", "mu")
    data: dict[str, Any] = {
        "RED": (axes, red, SYMBOLS["RED"].attrs),
        "phi_end": (axes, phi, SYMBOLS["phi_end"].attrs),
        "end": (axes, end, SYMBOLS["end"].attrs),
        "phi_touch": (
            "value",
            touch(sweep(beam, over, values))[0],
            {"long_name": "twist per pitch where other plates touch", "units": "rad"},
        ),
    }
    static = np.stack([mu_static(sweep(beam, over, values), law) for law in laws])
    data["mu_static"] = (("law", "value"), static, SYMBOLS["mu_static"].attrs)
    coords = {
        "value": ("value", values, SYMBOLS[over].attrs),
        "mu": ("mu", mus, SYMBOLS["mu"].attrs),
        "law": list(laws),
    }
    return xr.Dataset(data, coords, {"over": over, "margin": margin, "beam": beam.to_toml()})
