"""Beams twisted by finite elements, in SI units: from a beam to a labelled dataset."""

from __future__ import annotations

import hashlib
import math
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama import arguments, units
from squama._version import __version__
from squama.beam.faces import only_one
from squama.beam.parts import PLASTIC
from squama.errors import naming, refuse
from squama.fe import bending
from squama.fe.assembly import ENDS, make_walk
from squama.fe.body import Bent, Body
from squama.fe.deformed import Deformed, deformed
from squama.fe.elements import Helical, Material
from squama.fe.exposed import Exposed, box
from squama.fe.geometry import Geometry, geometry
from squama.fe.mesh import pitch_mesh
from squama.fe.sizes import MESHES, MeshSize
from squama.fe.walk import Doing, Ended, Walk
from squama.interrupt import Interrupted, until_interrupted
from squama.io import files
from squama.loads import SenseName
from squama.people import per_pitch
from squama.symbols import SYMBOLS

if TYPE_CHECKING:
    import xarray as xr

    from squama.beam.design import Beam

INCREMENT = 0.01
"""Largest increment of the twist, rad per pitch."""
SILENCE = 10.0
"""Longest time between reports of progress, s."""
FAR = 0.1
"""Deflection of a scale over its length up to which elements linear in the scale's frame hold."""
MOST = 200
"""Largest number of scales of a beam of elements."""
_SHORT = 0.05
"""Share of a beam over which oblique grips may extend without a warning."""
_OBLIQUE = (
    "the gripped end sections run along the scales' bases, over {:.3g} of {} pitches: the beam is stiffer than "
    "between clamps straight across, before contact 1.4 times for 5 scales of stiff_skin.toml (alpha 50 deg); squama "
    "verify --load holds the ends on average"
)
_LONGER = (
    "around long embedded parts the bar is {} pitches long, {} of them plain at its two ends; twists per pitch are the "
    "turn of the end over {}"
)
_ITERATIONS = 4.5
_OTHER = 2.5
_WORDS = {
    "twist": {"long_name": "twist of a scale's pitch, from cut to cut", "units": "rad"},
    "u_end": {"long_name": "move of the turned end along the axis", "units": "m"},
    "deflection": {"long_name": "farthest move of a point of a scale in the scale's frame", "units": "m"},
    "iterations": {"long_name": "Newton iterations", "units": "1"},
    "contact": {"long_name": "what touches"},
}


class Progress(NamedTuple):
    """Where a run stands: twist reached and wanted (rad per pitch), Newton steps of the increment, largest force left
    on a node (E d^2), increments halved so far, seconds gone and left.

    Within an increment ``toward`` is the twist to which it goes, ``rounds`` are the steps of the contact in it, and
    ``increment_s`` the seconds it took so far; ``toward`` is None once it is done."""  # noqa: D205, D209

    phi: float
    goal: float
    iterations: int
    unbalanced: float
    halvings: int
    elapsed_s: float
    left_s: float | None
    toward: float | None = None
    rounds: int = 0
    increment_s: float = 0.0


Listener = Callable[[Progress], None]


def cell(
    beam: Beam,
    *,
    to: float | str,
    mu: float | None = None,
    sense: SenseName = "+",
    mesh: MeshSize = "medium",
    increment: float = INCREMENT,
    scales: int | None = None,
    ends: str = "free",
    ideal: bool = False,
    hinged: bool = False,
    restart: str | os.PathLike[str] | None = None,
    progress: Listener | None = None,
    announce: Callable[[str], None] | None = None,
    last: Callable[[Deformed], object] | None = None,
) -> xr.Dataset:
    """Twist a beam by finite elements: one pitch with helical periodicity, or N scales between two grips.

    Large strains, Coulomb contact of all scales. Nothing of the analytical model goes in: no joint stiffness, no force
    law, no place of contact. Scales are as thick as the beam says; where their modulus is known, their exposed parts
    bend as solids of quadratic elements, linear in a frame that turns with the rigid embedded part
    (``squama.fe.bending``), which holds for deflections up to a tenth of their length.

    Parameters
    ----------
    beam : Beam
        The beam; its joint stiffness and inclusion factor are not used.
    to : float or str
        Twist to reach: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total" (over ``scales``
        pitches, those of the beam if not given). Of a finite beam it is the turn of the end over the number of pitches.
    mu : float, optional
        Coefficient of friction; the beam's own if not given.
    sense : {"+", "-"}
        Sense of the twist. Twists and torques are magnitudes.
    mesh : str or (float, float)
        "coarse", "medium", "fine", or sizes of the elements in the bulk and along the embedded scale's edges, pitches.
    increment : float
        Largest increment of the twist, rad per pitch; it is halved where one does not converge.
    scales : int, optional
        Number of scales and pitches of a finite beam, 2 to 200; one endless pitch if not given.
    ends : {"free", "held"}
        The end sections (cuts between pitches) of a finite beam are held rigidly, one fixed, the other turned; that one
        may move along the axis, or is held there too. They cannot warp, tilt, or move sideways.
    ideal : bool
        Rigid, thin scales, as in the paper.
    hinged : bool
        Block roll and yaw of the scales, as in a hinge.
    restart : path, optional
        File written after every increment; if it exists, the run continues from it.
    progress : callable, optional
        Called with a ``Progress`` after every increment, and every ten seconds within one.
    announce : callable, optional
        Called before the first increment of a finite beam with a text on the size of the run.
    last : callable, optional
        Called with the deformed pitch at the end, a ``squama.fe.deformed.Deformed``; endless beams only.

    Returns
    -------
    xarray.Dataset
        Dimension ``point`` (the increments): Phi, phi, T, U_el, W_fr, W (per length), gap, deflection, iterations,
        contact (in words). Of the scale theta, the motions u_X .. w_Z, N, f, and p and s, where the tip edge touches a
        side edge.

        Of an endless beam these are along ``point`` too, with the number of the touched ``neighbour``. Of a finite one
        they are along ``point`` and ``scale`` (1 to N): motions in the frame that is turned with the section at the
        scale's base, contact with the next scale (NaN for the last); and ``twist`` of the scale's pitch, the difference
        of the mean turns about z of the two cuts that bound it. T is that of the turned end, ``u_end`` its axial
        displacement.

        Attributes: beam, mesh, ``plates`` (thickness and elasticity of the scales), ``reached`` and ``sentence`` for
        the end of the run, ``energy_error``: (W - U_el - W_fr)/W at the end.

    Raises
    ------
    InputError
        An argument is out of range, a package is missing, the mesh fails, the free memory is too small, or the restart
        file is of another run.
    KeyboardInterrupt
        Ctrl-C, after the present increment; the restart file has all increments so far.
    """
    arguments.beam(beam)
    only_one(beam.faces, "elements")
    if scales is not None:
        scales = arguments.whole("scales", scales, 2, MOST)
    elif ends != "free":
        refuse("ends", "", "is for finite beams", "give scales too")
    if scales is not None and last is not None:
        refuse("last", "", "shows one endless pitch", "leave it out, or leave out scales")
    if restart is not None:
        files.try_place(restart)
    sign = arguments.sense(sense)
    friction = arguments.friction(beam.friction.mu, mu)
    increment = arguments.scalar("increment", increment, 1e-5, 0.1, "0.00001 to 0.1 rad per pitch")
    arguments.one_of("ends", ends, ENDS)
    with naming("to"):
        goal = units.twist(to, pitch=beam.pitch, scales=scales or beam.pitches) * beam.pitch
    if not 0 < goal < np.pi:
        refuse("to", f"{goal / beam.pitch:.6g} rad/m", f"must be above 0 and below {np.pi / beam.pitch:.6g}")
    sizes = mesh_sizes(mesh)
    shape = geometry(beam)
    exposed, plates = (None, "thin, rigid") if ideal else exposed_part(beam, shape)
    pitch = pitch_mesh(shape, *sizes)
    key = {
        "geometry": list(shape),
        "mu": friction,
        "sense": sense,
        "mesh": list(sizes),
        "hinged": hinged,
        "nodes": hashlib.sha256(pitch.nodes.tobytes()).hexdigest()[:16],
        "plates": plates,
    }
    walk = make_walk(pitch, shape, friction, scales=scales, ends=ends, hinged=hinged, exposed=exposed)
    if scales is not None:
        key |= {"scales": scales, "ends": ends}
        if announce is not None:
            announce(size(walk, scales, goal, increment))
    ended = follow(walk, sign * goal, increment, None if restart is None else Path(restart), key, progress)
    data = _dataset(beam, walk, sign, scales)
    if last is not None:
        last(deformed(beam, walk, pitch))
    data.attrs |= {
        "title": f"twisting of a scale-covered beam, {'' if scales else 'one periodic pitch of '}finite elements",
        "load": "twisting",
        "mu": friction,
        "sense": sense,
        "joint": "elements, roll and yaw blocked" if hinged else "elements",
        **({"ends": ends} if scales else {}),
        "mesh": f"{count(walk)} quadratic tetrahedra, {sizes[0]:g} and {sizes[1]:g} pitches",
        "plates": plates,
        "reached": int(ended.reached),
        "sentence": ended.sentence,
        "beam": beam.replace(scales=scales or beam.pitches).to_toml(),
        "squama_version": __version__,
        "warnings": "\n".join([*(warnings(shape, scales) if scales else ()), *_bent_far(walk)]),
    }
    return data.assign_coords(mu=((), friction, SYMBOLS["mu"].attrs))


def exposed_part(beam: Beam, shape: Geometry) -> tuple[Exposed, str]:
    """Return the exposed part of a beam's scales and its description; refuse plates so thick that they touch."""
    eta, beta, h = shape.eta, shape.beta, shape.thickness
    x, y, gap = np.abs(shape.rest.axes[:, 2])
    # the neighbour at rest is parallel, displaced by these
    if h >= gap and x < eta and y < 2 * beta:
        reason = f"plates of {h:.4g} pitches touch their neighbours at rest"
        remedy = f"write less than {gap:.4g} pitches, or take thin ones (ideal)"
        refuse("scale.thickness", f"{beam.scale.thickness:.4g} m", reason, remedy)
    if beam.scale.youngs_modulus is None:
        return box(eta, beta, h), f"{h:.4g} pitches thick, rigid, since their modulus is not given"
    nu = beam.scale.poisson_ratio
    material = Material(beam.modulus_ratio, PLASTIC if nu is None else nu)
    error = bending.mesh_error(eta, beta, h, material)
    counts = " x ".join(map(str, (*bending.BRICKS, bending.LAYERS)))
    words = (
        f"{h:.4g} pitches thick, elastic ({beam.scale.youngs_modulus / 1e9:.4g} GPa, nu {material.nu:.4g}): "
        f"{counts} quadratic bricks, about {100 * error:.1f} % too stiff, of which {bending.MODES} motions are kept"
    )
    return bending.solid(eta, beta, h, material), words


def _bent_far(walk: Walk) -> list[str]:
    share = max(map(float, walk.columns["deflection"])) / walk.contact.row.rest.eta
    if share <= FAR:
        return []
    return [
        f"the scales are bent by {100 * share:.0f} % of their length; their elements are linear in a frame that turns "
        f"with them, which holds up to about {100 * FAR:.0f} %"
    ]


def mesh_sizes(mesh: MeshSize) -> tuple[float, float]:
    """Return the sizes of elements in the bulk and along the scale's edges, pitches, of a mesh by name or sizes."""
    if isinstance(mesh, str):
        return MESHES[arguments.one_of("mesh", mesh, tuple(MESHES))]
    if len(mesh) != 2:
        refuse("mesh", "", "give two sizes, in the bulk and along the scale's edges, in pitches")
    return float(mesh[0]), float(mesh[1])


def follow(
    walk: Walk, goal: float, increment: float, restart: Path | None, key: dict[str, object], progress: Listener | None
) -> Ended:
    """Run to a twist (rad per pitch) with restart file and progress; Ctrl-C raises Interrupted and loses nothing."""
    if restart is not None and files.exists(restart):
        walk.resume(restart, key)
        if abs(walk.phi) > abs(goal):
            reason = f"has gone to {per_pitch(abs(walk.phi), 4)} already"
            refuse("", "", reason, "ask for more, or name another output", str(restart))
    begun, start = time.monotonic(), abs(walk.phi)
    said = entered = begun

    def say(now: float, doing: Doing | None = None) -> None:
        nonlocal said
        if progress is None:
            return
        said, gone, at, far = now, now - begun, abs(walk.phi), abs(goal)
        left = gone / (at - start) * (far - at) if at != start else None
        stands = Progress(at, far, walk.iterations, walk.reduced.unbalanced, walk.halvings, gone, left)
        if doing is not None:
            toward, iterations, rounds = abs(doing.toward), doing.iteration, doing.rounds
            stands = stands._replace(toward=toward, iterations=iterations, rounds=rounds, increment_s=now - entered)
        progress(stands)

    def told() -> None:
        nonlocal entered
        if restart is not None:
            walk.save(restart, key)
        entered = time.monotonic()
        say(entered)

    def watch(doing: Doing) -> None:
        now = time.monotonic()
        if now - said >= SILENCE:
            say(now, doing)

    with until_interrupted() as stopped:
        ended = walk.run(goal, increment, told=told, stop=stopped, watch=watch)
        if stopped() and not ended.reached:
            raise Interrupted(ended.sentence)
    return walk.explained(ended, goal, increment)


def print_progress(at: Progress) -> None:
    """Print the state of a run on standard error, as one line."""
    left = "" if at.left_s is None else f", about {at.left_s:.0f} s left"
    place = f"{math.degrees(at.phi):.4g} of {per_pitch(at.goal, 4)}"
    if at.toward is None:
        words = f"{place}: {at.iterations} iterations, largest force left {at.unbalanced:.1e}{left}"
    else:
        # the remaining time follows from the average pace, this increment included
        halved = f", increments halved so far: {at.halvings}" * (at.halvings > 0)
        words = (
            f"{place}, on the way to {at.toward:.4f}: iteration {at.iterations}, {at.rounds} contact steps, "
            f"{at.increment_s:.0f} s in this increment{halved}{left}"
        )
    print(words, file=sys.stderr, flush=True)


def warnings(shape: Geometry, scales: int) -> list[str]:
    """Return warnings where the oblique grips stiffen the beam, or leave no section of the bar free."""
    plain = shape.oblique.pitches
    skew, pitches = shape.width * np.tan(shape.alpha), scales + plain
    longer = [_LONGER.format(pitches, plain, scales)] if plain else []
    if pitches - skew >= 1:
        return longer + [_OBLIQUE.format(skew, pitches)] * bool(skew > _SHORT * pitches)
    return [
        *longer,
        f"the gripped end sections run along with the scales' bases, over {skew:.3g} pitches of the bar: of {pitches} "
        f"pitches none is free of them, so the beam is far stiffer than an endless one; take {int(skew) + 4} or more",
    ]


def count(walk: Walk) -> int:
    """Return the number of elements of a run."""
    elements = _substrate(walk).elements
    return len((elements.elements if isinstance(elements, Helical) else elements).volumes)


def _substrate(walk: Walk) -> Body:
    body = walk.body.body if isinstance(walk.body, Bent) else walk.body
    assert isinstance(body, Body)
    return body


def size(walk: Walk, scales: int, goal: float, increment: float) -> str:
    """Return a text on the size of a run; its time is a guess from the speed of this machine at dense products."""
    body = _substrate(walk)
    A = np.ones((700, 700))
    A @ A
    begun = time.perf_counter()
    A @ A
    rate = 2 * len(A) ** 3 / (time.perf_counter() - begun)
    steps = int(np.ceil(abs(goal) / increment - 1e-9))
    text = f"{scales} scales, {count(walk)} elements, {body.unknowns} unknowns"
    if not body.solver.needs:
        return f"{text}, {steps} increments; slow and large without pypardiso"
    seconds = _OTHER * body.solver.work / rate + body.unknowns * 1e-5
    return (
        f"{text}; the solver takes {body.solver.needs / 1e9:.2g} GB of memory; about {seconds:.2g} s an iteration, "
        f"{max(1, round(seconds * steps * _ITERATIONS / 60))} minutes for {steps} increments"
    )


def _dataset(beam: Beam, walk: Walk, sign: int, scales: int | None) -> xr.Dataset:
    """Return the recorded columns in SI units; twists and torques as magnitudes."""
    import xarray as xr

    columns = {name: np.array(values) for name, values in walk.columns.items()}
    d, E, n = beam.pitch, beam.substrate.youngs_modulus, scales or 1
    moment, force = E * d**3, E * d**2
    # energies are per length, so over n pitches
    factors = {
        "T": sign * moment,
        **dict.fromkeys(("U_el", "W_fr", "W"), moment / (n * d)),
        "N": force,
        "f": force,
        **dict.fromkeys(("gap", "u_end", "deflection", "p", "s", "u_X", "u_Y", "u_Z"), d),
        "twist": sign,
        "phi": sign,
    }
    words = {name: SYMBOLS[name].attrs for name in columns if name in SYMBOLS} | _WORDS
    if scales is not None:
        words["T"] = {**words["T"], "long_name": "torque at the turned end"}
    data = xr.Dataset({"Phi": ("point", sign * columns["phi"] / d, SYMBOLS["Phi"].attrs)})
    for name in (*(name for name in columns if name not in ("contact", "unbalanced")), "contact"):
        values = columns[name] * factors[name] if name in factors else columns[name]
        data[name] = ("point", "scale")[: values.ndim], values, words[name]
    if scales is not None:
        data = data.assign_coords(scale=("scale", np.arange(1, n + 1), {"long_name": "scale, counted along the beam"}))
    W, U, F = (columns[name][-1] for name in ("W", "U_el", "W_fr"))
    data.attrs["energy_error"] = float((W - U - F) / W) if W else 0.0
    return data
