"""Curves of finite beams by finite elements in SI units: a beam in, a labelled dataset out."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squama import checks, units
from squama._version import __version__
from squama.fe.beam import ALONG, EACH, ENDS, make_beam
from squama.fe.beam_body import BeamBody
from squama.fe.facade import INCREMENT, Listener, follow, mesh_sizes
from squama.fe.geometry import Geometry, geometry
from squama.fe.mesh import pitch_mesh
from squama.fe.plate import MOTIONS
from squama.fe.walk import Walk
from squama.symbols import SYMBOLS

if TYPE_CHECKING:
    import xarray as xr

    from squama.design import Beam

MOST = 200
"""Largest number of scales of a beam of elements."""
_ITERATIONS = 4.5
_OTHER = 2.5
_WORDS = {
    "twist": {"long_name": "twist of a scale's pitch, from cut to cut", "units": "rad"},
    "u_end": {"long_name": "move of the turned end along the axis", "units": "m"},
    "iterations": {"long_name": "Newton iterations", "units": "1"},
    "T": {**SYMBOLS["T"].attrs, "long_name": "torque at the turned end"},
}


def beam(
    beam: Beam,
    *,
    scales: int | None = None,
    mu: float | None = None,
    to: float | str,
    sense: str = "+",
    mesh: str | tuple[float, float] = "coarse",
    increment: float = INCREMENT,
    ends: str = "free",
    hinged: bool = False,
    restart: str | os.PathLike[str] | None = None,
    progress: Listener | None = None,
    announce: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Twist a beam of N scales by finite elements: gripped at both ends, large strains, Coulomb contact of all scales.

    Parameters
    ----------
    beam : Beam
        The beam; its joint stiffness and inclusion factor are not used.
    scales : int, optional
        Number of scales and pitches, 2 to 200; the beam's own if not given.
    mu : float, optional
        Coefficient of friction; the beam's own if not given.
    to : float or str
        Twist to reach: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total" (over ``scales``
        pitches): the turn of the end over the number of pitches.
    sense : {"+", "-"}
        Which way the beam is twisted. Twists and torques are magnitudes.
    mesh : str or (float, float)
        As in :func:`squama.fe.facade.cell`.
    increment : float
        Largest increment of the twist, rad per pitch; it is halved where needed.
    ends : {"free", "held"}
        The end sections (cuts between pitches) are held rigidly, one fixed, the other turned; that one may move along
        the axis, or is held there too. They cannot warp, tilt, or move sideways.
    hinged : bool
        Block roll and yaw of the scales.
    restart, progress
        As in :func:`squama.fe.facade.cell`.
    announce : callable, optional
        Told in words, before the first increment, how large the run is.

    Returns
    -------
    xarray.Dataset
        Dimensions ``point`` (the increments) and ``scale`` (1 to N). Along the twist: Phi, phi (means over the beam),
        T (at the end), U_el, W_fr, W (per length), gap, u_end, contact (in words). Of every scale: theta and the
        motions u_X .. w_Z, in the frame that is turned with the section at its base; N, f, p, s of its contact with the
        next (NaN for the last); ``twist`` of its pitch: difference of the mean turns about z of the two cuts that
        bound it. Attributes as those of :func:`squama.fe.facade.cell`.

    Raises
    ------
    InputError
        An argument is out of range, a package is missing, the mesh fails, the memory that is free does not do, or the
        restart file is of another run.
    KeyboardInterrupt
        Ctrl-C, after the increment under way; the restart file holds what is done.
    """
    n = checks.whole("scales", beam.scales if scales is None else scales, 2, MOST)
    sign = checks.sense(sense)
    friction = beam.friction.mu if mu is None else mu
    if friction is None:
        checks.fail("mu is not given: pass mu=0.3, or write mu under [friction] in the beam's file")
    friction = float(checks.not_negative("mu", friction))
    increment = checks.scalar("increment", increment, 1e-5, 0.1, "0.00001 to 0.1 rad per pitch")
    checks.one_of("ends", ends, ENDS)
    goal = units.twist(to, pitch=beam.pitch, scales=n) * beam.pitch
    if not 0 < goal < np.pi:
        checks.fail(f"to = {goal / beam.pitch:.6g} rad/m: must be above 0 and below {np.pi / beam.pitch:.6g}")
    sizes = mesh_sizes(mesh)
    shape = geometry(beam)
    pitch = pitch_mesh(shape, *sizes)
    walk = make_beam(pitch, shape, n, friction, ends=ends, hinged=hinged)
    if announce is not None:
        announce(size(walk, goal, increment))
    key = {
        "geometry": list(shape), "scales": n, "mu": friction, "sense": sense, "mesh": list(sizes), "ends": ends,
        "hinged": hinged, "nodes": hashlib.sha256(pitch.nodes.tobytes()).hexdigest()[:16],
    }  # fmt: skip
    ended = follow(walk, sign * goal, increment, None if restart is None else Path(restart), key, progress)
    data = _dataset(beam, walk, sign, n)
    data.attrs |= {
        "title": "twisting of a scale-covered beam, finite elements",
        "load": "twisting",
        "mu": friction,
        "sense": sense,
        "joint": "elements, roll and yaw blocked" if hinged else "elements",
        "ends": ends,
        "mesh": f"{n * len(pitch.tets)} quadratic tetrahedra, {sizes[0]:g} and {sizes[1]:g} pitches",
        "reached": int(ended.reached),
        "sentence": ended.sentence,
        "beam": beam.replace(scales=n).to_toml(),
        "squama_version": __version__,
        "warnings": "\n".join(warnings(shape, n)),
    }
    return data.assign_coords(mu=((), friction, SYMBOLS["mu"].attrs))


def warnings(shape: Geometry, scales: int) -> list[str]:
    """Say where the grips leave no section of the bar free: they run along the scales' bases."""
    skew = shape.width * np.tan(shape.alpha)
    if scales - skew >= 1:
        return []
    return [
        f"the gripped end sections run along with the scales' bases, over {skew:.3g} pitches of the bar: of {scales} "
        f"pitches none is free of them, so the beam is far stiffer than an endless one; take {int(skew) + 4} or more"
    ]


def size(walk: Walk, goal: float, increment: float) -> str:
    """Return in words how much there is to do; the time is a guess from this machine's speed at dense products."""
    body = walk.body
    assert isinstance(body, BeamBody)
    A = np.ones((700, 700))
    A @ A
    begun = time.perf_counter()
    A @ A
    rate = 2 * len(A) ** 3 / (time.perf_counter() - begun)
    steps = int(np.ceil(abs(goal) / increment - 1e-9))
    text = f"{body.scales} scales, {len(body.mesh.tets)} elements, {body.unknowns} unknowns"
    if not body.solver.needs:
        return f"{text}, {steps} increments; slow and large without pypardiso"
    seconds = _OTHER * body.solver.work / rate + body.unknowns * 1e-5
    return (
        f"{text}; the solver takes {body.solver.needs / 1e9:.2g} GB of memory; about {seconds:.2g} s an iteration, "
        f"{max(1, round(seconds * steps * _ITERATIONS / 60))} minutes for {steps} increments"
    )


def _dataset(beam: Beam, walk: Walk, sign: int, n: int) -> xr.Dataset:
    """Return the rows in SI units; twists and torques as magnitudes."""
    import xarray as xr

    d, E = beam.pitch, beam.substrate.youngs_modulus
    table = np.array(walk.rows)
    along = dict(zip(ALONG, table[:, : len(ALONG)].T, strict=True))
    each = dict(zip(EACH, table[:, len(ALONG) :].reshape(len(table), len(EACH), n).transpose(1, 0, 2), strict=True))
    moment, force = E * d**3, E * d**2
    # energies are per length, so over n pitches
    factors = {
        "T": sign * moment, **dict.fromkeys(("U_el", "W_fr", "W"), moment / (n * d)), "gap": d, "u_end": d, "N": force,
        "f": force, "p": d, "s": d, "twist": sign, **{name: d for name in MOTIONS if name.startswith("u")},
    }  # fmt: skip

    def column(name: str, dims: tuple[str, ...], values: Any) -> tuple[Any, ...]:
        return dims, values * factors.get(name, 1.0), _WORDS.get(name) or SYMBOLS[name].attrs

    phi = sign * along["phi"]
    data = xr.Dataset(
        {
            "Phi": ("point", phi / d, SYMBOLS["Phi"].attrs),
            "phi": ("point", phi, SYMBOLS["phi"].attrs),
            **{name: column(name, ("point",), along[name]) for name in ("T", "U_el", "W_fr", "W", "gap", "u_end")},
            **{name: column(name, ("point", "scale"), each[name]) for name in EACH},
            "iterations": ("point", along["iterations"].astype(int), _WORDS["iterations"]),
            "contact": ("point", np.array(walk.words, dtype=str), {"long_name": "what touches"}),
        },
        coords={"scale": ("scale", np.arange(1, n + 1), {"long_name": "scale, counted along the beam"})},
    )
    W, U, F = (along[name][-1] for name in ("W", "U_el", "W_fr"))
    data.attrs["energy_error"] = float((W - U - F) / W) if W else 0.0
    return data
