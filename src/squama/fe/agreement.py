"""Models compared with a curve by finite elements: differences over the twist, and the range of each model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from squama.symbols import SYMBOLS
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr


SHARE = 0.05
"""Relative difference of the torque up to which a model counts as holding."""
FINITE = ("beam", "row")
"""Names of curves of finite beams; their difference from the endless beam is no error of a model."""


def compare(
    elements: xr.Dataset, models: Mapping[str, tuple[str, xr.Dataset]], *, share: float = SHARE, title: str = ""
) -> xr.Dataset:
    """Compare models with a curve by finite elements, at the twists of the elements.

    ``elements``: ``phi`` (rad per pitch, from 0 on), ``T``, ``theta`` along ``point``; ``models``: by name a
    description and a curve with the same variables, interpolated linearly; ``share``: allowed difference of the torque,
    relative.

    Returns along ``point``: ``phi``, ``T_elements``, ``theta_elements``; along ``model`` and ``point``: ``T``,
    ``theta`` (NaN beyond a model's end), ``dT`` = T/T_elements - 1, ``dtheta`` = theta - theta_elements; along
    ``model``: ``words``, ``within``: twist per pitch at which ``dT`` first leaves the share, ``last``: last twist at
    which both curves have values, ``dT_last``, ``dtheta_last``: the differences there.

    >>> import numpy as np, xarray as xr
    >>> phi = np.array([0.0, 0.1, 0.2, 0.3])
    >>> def curve(T):
    ...     return xr.Dataset({"phi": ("point", phi), "T": ("point", T), "theta": ("point", 0.1 + phi)})
    >>> table = compare(curve(phi), {"hinge": ("a hinge", curve(phi * [1, 1, 1.1, 1.3]))})
    >>> round(float(table.within[0]), 3)
    0.15
    """
    import xarray as xr

    phi, T, theta = (np.asarray(elements[name].values, float) for name in ("phi", "T", "theta"))
    order = list(models)

    def ours(name: str) -> Array:
        return np.array([_at(phi, curve, name) for _, curve in models.values()]).reshape(-1, phi.size)

    with np.errstate(divide="ignore", invalid="ignore"):
        dT = np.where((T != 0) & (phi > 0), ours("T") / T - 1, np.nan)
    dtheta = ours("theta") - theta
    within, ends = zip(*(holds(phi, off, share) for off in dT), strict=True)
    last = np.arange(len(order)), np.array(ends)
    both, twist, rad = ("model", "point"), SYMBOLS["phi"].attrs, {"units": "rad"}
    reach = f"twist per pitch up to which the torque is within {share:.0%}"
    return xr.Dataset(
        {
            "T_elements": ("point", T, {"long_name": "torque of the elements", "units": "N m"}),
            "theta_elements": ("point", theta, {"long_name": "inclination of the elements' scale", **rad}),
            "T": (both, ours("T"), SYMBOLS["T"].attrs),
            "theta": (both, ours("theta"), SYMBOLS["theta"].attrs),
            "dT": (both, dT, {"long_name": "torque over the elements', less 1", "units": "1"}),
            "dtheta": (both, dtheta, {"long_name": "inclination less the elements'", **rad}),
            "words": ("model", np.array([words for words, _ in models.values()], dtype=str), {"long_name": "model"}),
            "within": ("model", np.array(within), {**twist, "long_name": reach}),
            "last": ("model", phi[last[1]], {**twist, "long_name": "last twist per pitch that both curves have"}),
            "dT_last": ("model", dT[last], {"long_name": "difference of the torque there", "units": "1"}),
            "dtheta_last": ("model", dtheta[last], {"long_name": "difference of the inclination there", **rad}),
        },
        coords={"model": ("model", np.array(order, dtype=str)), "phi": ("point", phi, twist)},
        attrs={"title": title, "elements": str(elements.attrs.get("mesh", "")), "share": share},
    )


def _at(phi: Array, curve: xr.Dataset, name: str) -> Array:
    """Return variable ``name`` of a model at twists (n,), rad per pitch; NaN outside the range of the model."""
    x, y = (np.asarray(curve[key].values, float) for key in ("phi", name))
    good = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if not good.size:
        return np.full(phi.size, np.nan)
    order = good[np.argsort(x[good], kind="stable")]
    return np.asarray(np.interp(phi, x[order], y[order], left=np.nan, right=np.nan))


def holds(phi: Array, off: Array, share: float = SHARE) -> tuple[float, int]:
    """Return the twist up to which a relative difference ``off`` (n,) at rising twists (n,) stays within a share.

    It is linear between points; 0 if the difference is outside at the first point, the last twist if it never is, NaN
    if all are NaN. The second value is the index of the last point with a difference; 0 if there is none.

    >>> holds(np.array([0.1, 0.2, 0.3]), np.array([0.0, 0.04, -0.06]), 0.05)
    (0.25, 2)
    """
    there = np.flatnonzero(np.isfinite(off))
    if not there.size:
        return float("nan"), 0
    size = np.abs(off[there])
    beyond = np.flatnonzero(size > share)
    if not beyond.size:
        return float(phi[there[-1]]), int(there[-1])
    i = int(beyond[0])
    if i == 0:
        return 0.0, int(there[-1])
    a, b = size[i - 1], size[i]
    x, y = phi[there[i - 1]], phi[there[i]]
    return float(x + (y - x) * (share - a) / (b - a)), int(there[-1])
