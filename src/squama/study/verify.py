"""A beam by every model there is, beside finite elements: what `squama verify` does."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import checks, compliant, files, response, rows, store, units
from squama.errors import InputError
from squama.fe import facade
from squama.fe.compare import Array, compare

if TYPE_CHECKING:
    import xarray as xr

    from squama.design import Beam

REACH = 0.3
"""Farthest twist to go to unless asked otherwise, rad per pitch."""
_HINGED = [0, 1, 2, 4, 6]


class Verified(NamedTuple):
    """What was found: ``table`` as from :func:`squama.fe.compare.compare`, the ``elements``' run, and all files."""

    table: xr.Dataset
    elements: xr.Dataset
    written: list[Path]


def default_reach(beam: Beam, mu: float, sense: str = "+") -> float:
    """Return the twist rate (rad/m) to go to: where the hinge's curve is cut off, at most 0.3 rad per pitch."""
    answer = response.twist(beam, mu=mu, sense=sense, points=3)
    last = float(answer["Phi"].values[-1])
    return min(last, REACH / beam.pitch) if np.isfinite(last) and last > 0 else REACH / beam.pitch


def verify(
    beam: Beam,
    folder: str | os.PathLike[str],
    *,
    mu: float | None = None,
    to: float | str | None = None,
    sense: str = "+",
    mesh: str | tuple[float, float] = "medium",
    increment: float = facade.INCREMENT,
    hinged: bool = False,
    scales: int | None = None,
    beam_mesh: str | tuple[float, float] = "coarse",
    progress: facade.Listener | None = None,
    announce: Callable[[str], None] | None = None,
) -> Verified:
    """Run finite elements and set the hinge (both laws), the compliant joint and, if asked, finite beams beside them.

    Parameters
    ----------
    beam : Beam
        The beam.
    folder : path
        Where all files go; made if need be. Runs of elements leave their restart files there, and the same call goes
        on from them.
    mu, to, sense, mesh, increment, hinged, progress
        As for :func:`squama.fe.facade.cell`; without ``to`` see :func:`default_reach`.
    scales : int, optional
        Run the elements' beam of so many scales too, and the row of as many hinges (theta: the middle scale, the one
        nearer to the turned end where there are two).
    beam_mesh : str or (float, float)
        Its mesh.
    announce : callable, optional
        Told in words what comes next.

    Returns
    -------
    Verified

    Raises
    ------
    InputError
        As from :func:`squama.fe.facade.cell`, or the folder cannot be used.
    KeyboardInterrupt
        Ctrl-C; what is done stays in the folder.
    """
    place = files.make_folder(folder)
    say = announce or (lambda _: None)
    friction = beam.friction.mu if mu is None else mu
    if friction is None:
        message = "mu is not given: pass mu=0.3, or write mu under [friction] in the beam's file"
        raise InputError(message)
    if to is None:
        to = default_reach(beam, friction, sense)
    # a twist "total" is one of the beam that is described, not of fewer scales
    to = units.twist(to, pitch=beam.pitch, scales=beam.scales)
    say("periodic cell of finite elements")
    common: dict[str, Any] = {"mu": friction, "to": to, "sense": sense, "increment": increment, "hinged": hinged}
    elements = facade.cell(beam, mesh=mesh, restart=place / "elements.npz", progress=progress, **common)
    written = [store.save(elements, place / "elements.nc")]
    rates = np.asarray(elements["Phi"].values, float)
    asked: dict[str, Any] = {"mu": friction, "sense": sense, "at": rates}
    K = own_matrix(beam, mesh)
    own = beam.replace(joint=hinge_of(K, beam, hinged=hinged))
    models = {
        "edge": ("hinge, edge law", response.twist(beam, law="edge", **asked)),
        "plate": ("hinge, plate law", response.twist(beam, law="plate", **asked)),
        "own": ("hinge, edge law, K_theta and C_f of this mesh", response.twist(own, law="edge", **asked)),
    }
    if not hinged:
        say("compliant joint")
        data = response.twist(beam, joint="compliant", **asked)
        models["compliant"] = "compliant joint, stiffness for elements of no size", data
        models["mesh"] = "compliant joint, stiffness of this mesh", compliant_curve(beam, K, friction, rates, sense)
    if scales is not None:
        data = _beam(beam, scales, place, mesh=beam_mesh, progress=progress, announce=say, **common)
        written.append(store.save(data, place / "beam.nc"))
        row = rows.row(beam, scales=scales, mu=friction, to=to, sense=sense)
        middle = scales // 2
        which = f"of {scales} scales, theta of scale {middle + 1}"
        models["beam"] = f"finite beam {which}", data.assign(theta=data["theta"].isel(scale=middle))
        models["row"] = f"row {which.replace('scales', 'hinges', 1)}", row.assign(theta=row["theta"].isel(scale=middle))
    blocked = ", roll and yaw blocked" if hinged else ""
    title = f"Models beside finite elements{blocked}, sense {sense}, mu = {friction:g}"
    table = compare(elements, models, title=title)
    table.attrs["beam"] = beam.to_toml()
    table.attrs["warnings"] = "" if scales is None else data.attrs["warnings"]
    written.append(store.save(flat(table), place / "comparison.csv"))
    from squama import plot

    written.append(plot.save_figure(plot.compare_figure(table), place / "comparison.png"))
    return Verified(table, elements, written)


def flat(table: xr.Dataset) -> xr.Dataset:
    """Return a table in which every row has its twist and the elements' values, as a CSV file wants them."""
    loose = table.reset_coords("phi")
    along = [name for name in ("phi", "T_elements", "theta_elements") if loose[name].dims == ("point",)]
    first = {name: loose[name].broadcast_like(table["dT"]) for name in along}
    return loose.drop_vars(along).assign(first)[[*along, *(name for name in loose.data_vars if name not in along)]]


def own_matrix(beam: Beam, mesh: str | tuple[float, float]) -> Array:
    """Return the stiffness (7, 7) that one mesh gives a scale and the twist, E = 1 and d = 1.

    Parameters
    ----------
    beam : Beam
        The beam.
    mesh : str or (float, float)
        As for :func:`squama.fe.facade.cell`.
    """
    from squama.fe import joint
    from squama.fe.geometry import geometry
    from squama.fe.mesh import pitch_mesh

    shape = geometry(beam)
    return joint.condensed(pitch_mesh(shape, *facade.mesh_sizes(mesh)), shape)


def hinge_of(K: Array, beam: Beam, *, hinged: bool = False) -> dict[str, float]:
    """Return stiffness (N m) and inclusion factor of the hinge that a matrix makes.

    Parameters
    ----------
    K : (7, 7) array
        From :func:`own_matrix`.
    beam : Beam
        The beam.
    hinged : bool
        With roll and yaw blocked; the scale's other motions are free.
    """
    if hinged:
        K = K[np.ix_(_HINGED, _HINGED)]
    held, last = K[:-1, :-1], K[-1, :-1]
    # inclination is the fifth motion, the fourth of those left by a hinge
    i = 3 if hinged else 4
    unit = beam.substrate.youngs_modulus * beam.pitch**3
    rigidity = float(K[-1, -1] - last @ np.linalg.solve(held, last)) * unit * beam.pitch
    return {
        "stiffness": float(1 / np.linalg.inv(held)[i, i]) * unit,
        "inclusion_factor": rigidity / (beam.G_B * beam.J),
    }


def compliant_curve(beam: Beam, K: Array, mu: float, rates: Array, sense: str = "+") -> xr.Dataset:
    """Return phi, T and theta of rigid scales on a stiffness matrix at twist rates (rad/m)."""
    import xarray as xr

    given = hinge_of(K, beam)
    joint = compliant.Stiffness(K, given["stiffness"], given["inclusion_factor"] * beam.G_B * beam.J)
    sign = checks.sense(sense)
    along = compliant.curve(beam, joint, mu, rates * beam.pitch, sign=sign).along
    names = {"phi": "load", "T": "torque", "theta": "theta"}
    return xr.Dataset({name: ("point", np.asarray(along[role], float)) for name, role in names.items()})


def _beam(beam: Beam, scales: int, place: Path, **arguments: Any) -> xr.Dataset:
    from squama.fe.facade_beam import beam as finite

    arguments["announce"](f"finite beam of {scales} scales")
    return finite(beam, scales=scales, restart=place / "beam.npz", **arguments)
