"""Comparison of the models of a beam with finite elements, for `squama verify`."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import arguments, units
from squama.beam import matrixfile
from squama.beam.faces import only_one
from squama.curves import doors, finite_rows
from squama.errors import naming, refuse
from squama.fe import runs
from squama.fe.agreement import compare
from squama.fe.geometry import geometry
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import response
from squama.fe.sizes import MeshSize
from squama.io import datasets, files
from squama.loads import ENDLESS, STRAIGHT, SenseName, model
from squama.people import at_most, per_pitch
from squama.study import parts
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

    from squama.beam.design import Beam

REACH = 0.3
"""Largest default twist, rad per pitch."""
_HINGED = [0, 1, 2, 4, 6]


class Verified(NamedTuple):
    """Result of a verification: ``table`` of ``squama.fe.agreement.compare``, the ``elements``' dataset, all files.

    ``touched``: twist per pitch (rad), or deformation of a part (m or rad), at the first contact in the elements or a
    model; inf for none. Without contact only the bar was compared, no model is ``tested``, and ``verdict`` says so.
    """

    table: xr.Dataset
    elements: xr.Dataset
    written: list[Path]
    touched: float

    @property
    def tested(self) -> bool:
        """Whether scales touched, so that the models were put to a test."""
        return self.touched < math.inf

    @property
    def verdict(self) -> str:
        """The result of the comparison in words."""
        return str(self.table.attrs["verdict"])


def default_reach(beam: Beam, mu: float, sense: SenseName = "+") -> float:
    """Return the default twist rate (rad/m): the cut-off of the curve on hinges, at most 0.3 rad per pitch."""
    last = float(doors.twist(beam, mu=mu, sense=sense, points=3, joint="hinge")["Phi"].values[-1])
    return min(last, REACH / beam.pitch) if last > 0 else REACH / beam.pitch


def verify(
    beam: Beam,
    folder: str | os.PathLike[str],
    *,
    mu: float | None = None,
    to: float | str | None = None,
    load: str | None = None,
    support: str | None = None,
    sense: SenseName = "+",
    mesh: MeshSize = "medium",
    increment: float = runs.INCREMENT,
    hinged: bool = False,
    ideal: bool = False,
    scales: int | None = None,
    beam_mesh: MeshSize = "coarse",
    progress: runs.Listener | None = None,
    announce: Callable[[str], None] | None = None,
) -> Verified:
    """Twist a beam of finite elements and compare compliant joints, hinges and, if asked, finite beams with it.

    Elements of one pitch, and the models compared with them, are held straight. With ``load`` a part of N scales is
    compared with :func:`squama.load`, see ``squama.study.parts``. Where no scale touches up to ``to``, no model is
    tested, see ``Verified``.

    Parameters
    ----------
    folder : path
        Folder of all files, made if missing. Runs of finite elements keep their restart files there, and the same call
        continues from them.
    mu, to, sense, mesh, increment, hinged, ideal, progress
        As for :func:`squama.cell`; without ``to`` see ``default_reach``. The hinge's scales are thin and rigid, but
        thick with ``hinged`` elements that are not ``ideal``.
    load, support : str, optional
        Imposed deformation of a part, in place of ``to``: "10 mm up at tip", "60 deg bend", "90 deg twist"; "clamped"
        (if not given), or "gripped" with a twist.
    scales : int, optional
        Number of scales of a finite beam of elements, computed as well with a row of as many hinges (theta: that of the
        middle scale; of two middle scales, the one nearer to the turned end). For a part: the beam's own number by
        default.
    beam_mesh : str or (float, float)
        Mesh of the finite beam or part.
    announce : callable, optional
        Called with the name of each step in words.

    Raises
    ------
    InputError
        As from :func:`squama.cell`, or the folder cannot be used.
    KeyboardInterrupt
        Ctrl-C; finished results stay in the folder.
    """
    arguments.beam(beam)
    only_one(beam.faces, "elements")
    say = announce or (lambda _: None)
    friction = arguments.friction(beam.friction.mu, mu)
    if load is not None:
        if to is not None or hinged or sense != "+":
            refuse("load", "", "stands for to, and has no sense and no hinges", "leave these out")
        n = arguments.whole("scales", scales if scales is not None else beam.pitches, 2, parts.MOST)
        part = parts.Run(n, parts.led(load, support, beam, n), friction, beam_mesh, increment, ideal)
        return Verified(*parts.verify(beam, Path(folder), part, progress, say))
    if support is not None:
        refuse("support", "", "is of a part", "give load too")
    if to is None:
        to = default_reach(beam, friction, sense)
    # a twist "total" refers to the beam as described, not to one of fewer scales
    with naming("to"):
        to = units.twist(to, pitch=beam.pitch, scales=beam.pitches)
    common: dict[str, Any] = {"mu": friction, "to": to, "sense": sense, "increment": increment}
    common |= {"hinged": hinged, "ideal": ideal}
    with files.folder_for(folder) as place:
        say("periodic cell of finite elements")
        elements = runs.cell(beam, mesh=mesh, restart=place / "elements.npz", progress=progress, **common)
    written = [datasets.save(elements, place / "elements.nc")]
    curves = _curves(beam, elements, friction, sense, mesh, hinged=hinged, ideal=ideal, say=say)
    models = {name: (f"{model(data.attrs)}{more}", data) for name, (more, data) in curves.items()}
    if scales is not None:
        say(f"finite beam of {scales} scales")
        data = runs.cell(
            beam, scales=scales, mesh=beam_mesh, restart=place / "beam.npz", progress=progress, announce=say, **common
        )
        written.append(datasets.save(data, place / "beam.nc"))
        row = finite_rows.row(beam, scales=scales, mu=friction, to=to, sense=sense, joint="hinge")
        middle = scales // 2
        which = f"of {scales} scales, theta of scale {middle + 1}"
        models["beam"] = f"finite beam {which}", data.assign(theta=data["theta"].isel(scale=middle))
        models["row"] = f"row {which.replace('scales', 'hinges', 1)}", row.assign(theta=row["theta"].isel(scale=middle))
    blocked = ", roll and yaw blocked" if hinged else ""
    title = f"Models compared with finite elements{blocked}, twisted in sense {sense}, mu = {friction:g}"
    table = compare(elements, models, title=title)
    touched = min(parts.touched(data, "phi") for data in (elements, *(data for _, data in models.values())))
    meets = min(float(data["phi_e"]) for _, data in models.values() if "phi_e" in data)
    last = float(table["phi"].values[-1])
    table.attrs |= {"load": "twisting", "verdict": verdict(touched, last, meets, math.degrees(beam.pitches))}
    table.attrs["beam"] = beam.to_toml()
    table.attrs["warnings"] = "" if scales is None else data.attrs["warnings"]
    written.append(datasets.save(flat(table), place / "comparison.csv"))
    return Verified(table, elements, written, touched)


def _curves(
    beam: Beam,
    elements: xr.Dataset,
    mu: float,
    sense: str,
    mesh: MeshSize,
    *,
    hinged: bool,
    ideal: bool,
    say: Callable[[str], None],
) -> dict[str, tuple[str, xr.Dataset]]:
    """Return the models' curves at the elements' twists by name, each with what its title adds to the model's name."""
    rates = np.asarray(elements["Phi"].values, float)
    points: dict[str, Any] = {"mu": mu, "sense": sense, "at": rates, "ends": ENDLESS}
    K = own_matrix(beam, mesh)
    own = beam.replace(joint=hinge_of(K, beam, hinged=hinged))
    # with hinged elements the hinge model takes thick scales too
    hinge: dict[str, Any] = {"joint": "hinge", "ideal": ideal or not hinged, **points}
    curves = {
        "edge": ("", doors.twist(beam, **hinge)),
        "plate": ("", doors.twist(beam, law="plate", joint="hinge", **points)),
        "own": (", K_theta and C_f of this mesh", doors.twist(own, **hinge)),
    }
    if not hinged:
        say("compliant joint")
        # a periodic cell of elements is held straight and at constant length
        straight: dict[str, Any] = {"joint": "compliant", "ideal": ideal, "hold": STRAIGHT, **points}
        if not ideal:
            curves["thin"] = "", doors.twist(beam, **straight | {"ideal": True})
        curves["compliant"] = "", doors.twist(beam, **straight)
        curves["mesh"] = (
            ", stiffness of this mesh",
            doors.twist(beam.replace(joint=parts.joint_of(beam, K)), **straight),
        )
    return curves


def verdict(touched: float, last: float, meets: float, degrees: float) -> str:
    """Return a sentence on the comparison up to the twist ``last`` (rad per pitch); ``degrees``: total twist per rad.

    ``touched``: twist per pitch at which scales touch; ``meets``: the first contact by the models; inf for none.
    """
    reach = f"{last * degrees:.3g} deg ({per_pitch(last)})"
    if touched < math.inf:
        return f"twisted to {reach}, the scales touch from {touched * degrees:.3g} deg on"
    more = f'; they touch at {meets * degrees:.3g} deg: write --to "{at_most(1.5 * meets, 3)}"'
    return f"twisted to {reach}, no contact up to here: nothing was tested{more if meets < math.inf else ''}"


def flat(table: xr.Dataset) -> xr.Dataset:
    """Return a table with the twist and the elements' values in every row, for a CSV file."""
    loose = table.reset_coords("phi")
    along = [name for name in ("phi", "T_elements", "theta_elements") if loose[name].dims == ("point",)]
    first = {name: loose[name].broadcast_like(table["dT"]) for name in along}
    return loose.drop_vars(along).assign(first)[[*along, *(name for name in loose.data_vars if name not in along)]]


def own_matrix(beam: Beam, mesh: MeshSize) -> Array:
    """Return the stiffness matrix (7, 7) of one pitch from one mesh (as for :func:`squama.cell`), E = 1, d = 1."""
    shape = geometry(beam)
    return response(pitch_mesh(shape, *runs.mesh_sizes(mesh)), shape).K[:7, :7]


def hinge_of(K: Array, beam: Beam, *, hinged: bool = False) -> dict[str, float]:
    """Return stiffness (N m) and inclusion factor of the hinge from a matrix (7, 7), roll and yaw blocked or not."""
    if hinged:
        K = K[np.ix_(_HINGED, _HINGED)]
    unit = beam.unit_moment
    # inclination is the fifth motion, the fourth of those left by a hinge
    return {
        "stiffness": matrixfile.inclination_stiffness(K, 3 if hinged else 4) * unit,
        "inclusion_factor": matrixfile.twisting_stiffness(K) * unit * beam.pitch / (beam.G_B * beam.J),
    }
