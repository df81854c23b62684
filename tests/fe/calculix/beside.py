"""A finite beam by our elements beside the same beam and mesh in CalculiX: torque, inclination, gaps along the twist.

The two programs count a scale's attitude against the bar near its base in different ways (mean turn of the cuts; edges
of the face without scales). Here both are put into one frame, that of CalculiX.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from squama.errors import InputError
from squama.fe.geometry import Geometry, geometry
from squama.fe.plate import Turn, inclination, turned
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

    from squama.beam.design import Beam


def beside(beam: Beam, ours: xr.Dataset, theirs: xr.Dataset) -> xr.Dataset:
    """Set our finite beam beside CalculiX' at the twists of the latter.

    Parameters
    ----------
    beam : Beam
        The beam.
    ours : xarray.Dataset
        From :func:`squama.fe.runs.cell`.
    theirs : xarray.Dataset
        From :func:`squama.fe.ccx.run_calculix`, with as many scales.

    Returns
    -------
    xarray.Dataset
        Along ``point`` (twists ``phi`` that both have reached, rad per pitch, beyond 0): ``T`` and ``T_calculix``
        (N m), ``dT`` = T_calculix/T - 1, ``gap`` (ours) and ``gap_calculix``, the least of all pairs, in pitches, NaN
        where no edges cross. Along ``point`` and ``scale``: ``theta``, ``theta_calculix``, rad, against the section
        that CalculiX sees. Ours is interpolated linearly.

    Raises
    ------
    InputError
        The numbers of scales differ.
    """
    import xarray as xr

    if ours.sizes["scale"] != theirs.sizes["scale"]:
        message = f"{ours.sizes['scale']} scales here, {theirs.sizes['scale']} in CalculiX: run both with as many"
        raise InputError(message)
    shape = geometry(beam)
    own = np.asarray(ours["phi"].values, float)
    theirs = theirs.isel(point=(theirs["phi"].values > 0) & (theirs["phi"].values <= own[-1] * (1 + 1e-9)))
    phi = np.asarray(theirs["phi"].values, float)

    def at(values: Array) -> Array:
        flat = values.reshape(own.size, -1)
        return np.stack([np.interp(phi, own, column) for column in flat.T], -1).reshape(phi.size, *values.shape[1:])

    turns = np.concatenate([np.zeros((own.size, 1)), np.cumsum(ours["twist"].values, axis=1)], axis=1)
    # the base of a scale lies between two cuts, as in squama.fe.assembly
    local = at((1 + shape.cut) * turns[:, :-1] - shape.cut * turns[:, 1:])
    w = at(np.stack([ours[name].values for name in ("w_X", "w_Y", "w_Z")], -1))
    other = np.stack([theirs["w_X"], shape.theta0 - theirs["theta"], theirs["w_Z"]], -1)
    seen = np.asarray(theirs["local_twist"].values, float)
    along, each = ("point",), ("point", "scale")
    T, T_other = at(ours["T"].values), np.asarray(theirs["T"].values, float)
    gap = theirs["gap"].values[:, :-1]
    empty = np.isnan(gap).all(axis=1)
    least = np.where(empty, np.nan, np.min(np.where(np.isnan(gap), np.inf, gap), axis=1))
    rad: dict[str, Any] = {"units": "rad"}
    return xr.Dataset(
        {
            "T": (along, T, {"long_name": "torque, squama", "units": "N m"}),
            "T_calculix": (along, T_other, {"long_name": "torque, CalculiX", "units": "N m"}),
            "dT": (along, T_other / T - 1, {"long_name": "torque of CalculiX over squama's, less 1", "units": "1"}),
            "theta": (each, _seen(shape, w, local - seen), {"long_name": "inclination, squama", **rad}),
            "theta_calculix": (each, _seen(shape, other, 0 * seen), {"long_name": "inclination, CalculiX", **rad}),
            "gap": (along, _least(own, ours, phi, beam.pitch), {"long_name": "least gap, squama, in pitches"}),
            "gap_calculix": (along, least, {"long_name": "least gap of the edges, CalculiX, in pitches"}),
        },
        coords={"phi": (along, phi, rad), "scale": theirs["scale"].values},
    )


def _seen(shape: Geometry, w: Array, turn: Array) -> Array:
    """Return the inclination of scales whose frame, with rotation vectors w (.., 3) in it, is turned by ``turn``."""
    A, out = shape.rest.axes, np.empty(turn.shape)
    for i in np.ndindex(out.shape):
        E = A @ Turn.at(float(turn[i])).Q @ A.T @ turned(w[i])
        out[i] = inclination(shape.rest, _vector(E))
    return out


def _vector(E: Array) -> Array:
    """Return six motions whose rotation has the matrix E (3, 3)."""
    from scipy.spatial.transform import Rotation

    return np.append(np.zeros(3), Rotation.from_matrix(E).as_rotvec())


def _least(own: Array, ours: xr.Dataset, phi: Array, pitch: float) -> Array:
    """Return our least gap, in pitches, at the increments next to the twists; NaN where nothing is near."""
    nearest = np.abs(own[:, None] - phi).argmin(axis=0)
    gap = np.asarray(ours["gap"].values, float)[nearest] / pitch
    return np.where(np.isfinite(gap), gap, np.nan)
