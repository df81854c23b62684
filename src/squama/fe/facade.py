"""Curves by finite elements in SI units: a beam in, a labelled dataset out."""

from __future__ import annotations

import hashlib
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import checks, units
from squama._version import __version__
from squama.errors import InputError
from squama.fe.cell import COLUMNS, make_cell
from squama.fe.deformed import Deformed, deformed
from squama.fe.geometry import geometry
from squama.fe.mesh import pitch_mesh
from squama.fe.plate import MOTIONS
from squama.fe.snap import explained
from squama.fe.walk import Ended, Increment, Walk
from squama.interrupt import Interrupted, until_interrupted
from squama.symbols import SYMBOLS

if TYPE_CHECKING:
    import xarray as xr

    from squama.design import Beam

MESHES = {"coarse": (0.2, 0.06), "medium": (0.15, 0.013), "fine": (0.12, 0.0075)}
"""Sizes of the elements in the bulk and along the embedded scale's edges, pitches."""
INCREMENT = 0.01
"""Largest increment of the twist, rad per pitch."""


class Progress(NamedTuple):
    """Where a run stands: twist reached and wanted (rad per pitch), Newton steps of the increment, largest force left
    on a node (E d^2), increments halved so far, seconds gone and left."""  # noqa: D205, D209

    phi: float
    goal: float
    iterations: int
    unbalanced: float
    halvings: int
    elapsed_s: float
    left_s: float | None


Listener = Callable[[Progress], None]


def cell(
    beam: Beam,
    *,
    mu: float | None = None,
    to: float | str,
    sense: str = "+",
    mesh: str | tuple[float, float] = "medium",
    increment: float = INCREMENT,
    hinged: bool = False,
    restart: str | os.PathLike[str] | None = None,
    progress: Listener | None = None,
    last: Callable[[Deformed], object] | None = None,
) -> xr.Dataset:
    """Twist one pitch of a beam by finite elements: helical periodicity, large strains, Coulomb contact of the scales.

    Nothing of the analytical model goes in: no joint stiffness, no force law, no place of contact.

    Parameters
    ----------
    beam : Beam
        The beam; its joint stiffness and inclusion factor are not used.
    mu : float, optional
        Coefficient of friction; the beam's own if not given.
    to : float or str
        Twist to reach: a rate in rad/m or text such as "0.2 rad/pitch".
    sense : {"+", "-"}
        Which way the beam is twisted. Twists and torques are magnitudes.
    mesh : str or (float, float)
        "coarse", "medium", "fine", or sizes of the elements in the bulk and along the embedded scale's edges, pitches.
    increment : float
        Largest increment of the twist, rad per pitch; it is halved where needed.
    hinged : bool
        Block roll and yaw of the scales: what a hinge leaves of the joint's motions.
    restart : path, optional
        File that is written after every increment; where it is there already, the run goes on from it.
    progress : callable, optional
        Told after every increment, see :class:`Progress`.
    last : callable, optional
        Given the deformed pitch at the end, see :class:`squama.fe.deformed.Deformed`.

    Returns
    -------
    xarray.Dataset
        Dimension ``point`` (the increments); Phi, phi, theta, T, N, f, U_el, W_fr, W, the motions u_X .. w_Z of the
        scale, gap, p and s (where the tip edge touches a side edge), neighbour, contact (in words). Attributes: beam,
        mesh, ``reached`` and ``sentence`` for the end of the run, ``energy_error``: (W - U_el - W_fr)/W at the end.

    Raises
    ------
    InputError
        An argument is out of range, a package is missing, the mesh fails, or the restart file is of another run.
    KeyboardInterrupt
        Ctrl-C, after the increment under way; the restart file holds what is done.
    """
    sign = checks.sense(sense)
    friction = beam.friction.mu if mu is None else mu
    if friction is None:
        checks.fail("mu is not given: pass mu=0.3, or write mu under [friction] in the beam's file")
    friction = float(checks.not_negative("mu", friction))
    increment = checks.scalar("increment", increment, 1e-5, 0.1, "0.00001 to 0.1 rad per pitch")
    goal = units.twist(to, pitch=beam.pitch, scales=beam.scales) * beam.pitch
    if not 0 < goal < np.pi:
        checks.fail(f"to = {goal / beam.pitch:.6g} rad/m: must be above 0 and below {np.pi / beam.pitch:.6g}")
    sizes = mesh_sizes(mesh)
    shape = geometry(beam)
    pitch = pitch_mesh(shape, *sizes)
    walk = make_cell(pitch, shape, friction, hinged=hinged)
    key = {
        "geometry": list(shape), "mu": friction, "sense": sense, "mesh": list(sizes), "hinged": hinged,
        "nodes": hashlib.sha256(pitch.nodes.tobytes()).hexdigest()[:16],
    }  # fmt: skip
    ended = follow(walk, sign * goal, increment, None if restart is None else Path(restart), key, progress)
    data = _dataset(beam, walk, sign)
    if last is not None:
        last(deformed(beam, walk, pitch))
    data.attrs |= {
        "title": "twisting of a scale-covered beam, one periodic pitch of finite elements",
        "load": "twisting",
        "mu": friction,
        "sense": sense,
        "joint": "elements, roll and yaw blocked" if hinged else "elements",
        "mesh": f"{len(pitch.tets)} quadratic tetrahedra, {sizes[0]:g} and {sizes[1]:g} pitches",
        "reached": int(ended.reached),
        "sentence": ended.sentence,
        "beam": beam.to_toml(),
        "squama_version": __version__,
        "warnings": "",
    }
    return data.assign_coords(mu=((), friction, SYMBOLS["mu"].attrs))


def mesh_sizes(mesh: str | tuple[float, float]) -> tuple[float, float]:
    """Return the two sizes of a mesh, in pitches, from its name or from themselves."""
    if isinstance(mesh, str):
        checks.one_of("mesh", mesh, tuple(MESHES))
        return MESHES[mesh]
    if len(mesh) != 2:
        checks.fail("mesh: give two sizes, in the bulk and along the scale's edges, in pitches")
    return float(mesh[0]), float(mesh[1])


def follow(
    walk: Walk, goal: float, increment: float, restart: Path | None, key: dict[str, Any], progress: Listener | None
) -> Ended:
    """Run to a twist with a restart file, progress, and Ctrl-C that keeps what is done.

    Raises
    ------
    InputError
        The restart file belongs to another run, or cannot be written.
    Interrupted
        Ctrl-C.
    """
    if restart is not None and restart.exists():
        walk.load(restart, key)
        if abs(walk.phi) > abs(goal):
            checks.fail(
                f"{restart}: has gone to {abs(walk.phi):.4g} rad per pitch already; "
                "ask for more, or name another output"
            )
    begun, start = time.monotonic(), abs(walk.phi)

    def told(at: Increment) -> None:
        if restart is not None:
            try:
                walk.save(restart, key)
            except OSError as error:
                message = f"{restart}: cannot be written ({error.strerror or error}); name another place"
                raise InputError(message) from None
        if progress is not None:
            gone, done = time.monotonic() - begun, abs(at.phi) - start
            left = gone / done * (abs(goal) - abs(at.phi)) if done else None
            progress(Progress(abs(at.phi), abs(goal), *at[2:], gone, left))

    with until_interrupted() as stopped:
        ended = walk.run(goal, increment, told=told, stop=stopped)
        if stopped() and not ended.reached:
            raise Interrupted(ended.sentence)
    return explained(walk, ended, goal, increment)


def print_progress(at: Progress) -> None:
    """Write a line on standard error."""
    left = "" if at.left_s is None else f", about {at.left_s:.0f} s left"
    print(
        f"phi = {at.phi:.4f} of {at.goal:.4g} rad/pitch: {at.iterations} iterations, "
        f"largest force left {at.unbalanced:.1e}{left}",
        file=sys.stderr,
        flush=True,
    )


def _dataset(beam: Beam, walk: Walk, sign: int) -> xr.Dataset:
    """Return the rows in SI units; twists and torques as magnitudes."""
    import xarray as xr

    d, E = beam.pitch, beam.substrate.youngs_modulus
    force, work = E * d**2, E * d**2
    columns = dict(zip(COLUMNS, np.array(walk.rows).T, strict=True))
    phi = sign * columns["phi"]
    values = {
        "Phi": phi / d,
        "phi": phi,
        "theta": columns["theta"],
        "T": sign * columns["T"] * E * d**3,
        "N": columns["N"] * force,
        "f": columns["f"] * force,
        **{name: columns[name] * (d if name.startswith("u") else 1) for name in MOTIONS},
        **{name: columns[name] * work for name in ("U_el", "W_fr", "W")},
        **{name: columns[name] * d for name in ("gap", "p", "s")},
    }
    data = xr.Dataset({name: ("point", value, SYMBOLS[name].attrs) for name, value in values.items()})
    data["neighbour"] = "point", columns["neighbour"].astype(int), SYMBOLS["neighbour"].attrs
    data["iterations"] = "point", columns["iterations"].astype(int), {"long_name": "Newton iterations", "units": "1"}
    data["contact"] = "point", np.array(walk.words, dtype=str), {"long_name": "what touches"}
    W, U, F = (columns[name][-1] for name in ("W", "U_el", "W_fr"))
    data.attrs["energy_error"] = float((W - U - F) / W) if W else 0.0
    return data
