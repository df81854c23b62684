"""Stiffness of a scale's joint and of the pitch around it, by linear elements with helical periodicity.

K (9, 9) is that of :mod:`squama.fe.pitch_stiffness`, over the six motions of the plate, the twist, the bend and the
stretch per pitch. From its part over the motions and the twist (neither bent nor stretched) follow
    K_theta = 1 / (A^-1)_55 with A = K_vv: moment about n_Y over the angle about n_Y at phi = 0, the plate's other five
        motions left free (inclination is the fifth motion; with the others blocked it is K_55, 1.7 times as much)
    C_f = (K_phiphi - K_phiv A^-1 K_vphi) / K_bar: torque over twist with the plate's six motions free, over the same of
        the bare bar in elements of the same size; over the exact G J it is .1 % more at the default size.
Both do not depend on which section is held, since a plate with these motions free bears no net force.

Mesh convergence. Along the plate's edges stresses are singular: like r^-1/2 around a thin rigid plate and at the mouth
of the slot, so energies, and K with them, fall in proportion to the size h of the elements there. Three sizes h, h/2,
h/4 are computed and K is extrapolated linearly from the last two. The error bar is the larger of half that last
correction and the change of the extrapolated value by the last halving; with two sizes it is the whole correction.

Measured (width 1.28, lambda .32, zeta .18, beta .6, t_s .004, alpha 45 deg, theta0 10 deg, nu .25):
    h         .04     .02     .01     .005    .0025
    K_theta   .01316  .01262  .01225  .01205  .01198      E d^3
    C_f       1.4324  1.4265  1.4214  1.4187  1.4175
so K_theta = .0119 (to about .5 %) and C_f = 1.417 (.1 %). The order seen rises from .5 to 1.5 as h falls below the
thickness, hence the bar. Elements that grow more slowly with the distance from the edges (grading .3 in place of .5)
give 1.2 % less K_theta at h = .02, .7 % less at .01, and the same extrapolated value to .2 %.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from math import log2
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, get_args

import numpy as np

from squama import arguments
from squama._version import __version__
from squama.beam.faces import only_one
from squama.beam.matrixfile import inclination_stiffness, twisting_stiffness
from squama.errors import InputError, refuse
from squama.fe.elements import Material
from squama.fe.geometry import Geometry, geometry
from squama.fe.mesh import SIZE, MeshError, bar_mesh, pitch_mesh
from squama.fe.pitch_stiffness import response
from squama.io import files
from squama.progress import not_kept
from squama.types import Array

if TYPE_CHECKING:
    from squama.beam.design import Beam

TabName = Literal["rigid", "elastic"]
TABS: tuple[str, ...] = get_args(TabName)
"""Models of the embedded part of a scale."""
LEVELS, ENOUGH = 3, 2
"""Number of meshes; each halves the size of the one before. How many suffice where the next cannot be meshed."""
_MOST = 20_000
_WHAT = "joint's stiffness"
"""Name of the cached results in messages."""
_SCHEME = 3
"""Version of the cached numbers, raised whenever their meaning changes."""


class Value(NamedTuple):
    """A number and its error bar, both in the same unit."""

    value: float
    error: float


class Level(NamedTuple):
    """Results of one mesh: edge size (pitches), elements, K (9, 9), seconds (0: from the cache), strain (4, 9, 9)."""

    edge_size: float
    elements: int
    K: Array
    seconds: float
    strain: Array

    @property
    def K_theta(self) -> float:
        """Stiffness against inclination, E d^3."""
        return inclination_stiffness(self.K[:7, :7])

    @property
    def rigidity(self) -> float:
        """Torque per twist per pitch without contact, E d^3."""
        return twisting_stiffness(self.K[:7, :7])


class JointMatrix(NamedTuple):
    """Stiffness of the substrate over the motions of one scale, twist, bend and stretch; in E = 1 and d = 1.

    ``K`` (9, 9) over (u_X, u_Y, u_Z, w_X, w_Y, w_Z, phi, psi, epsilon), extrapolated to elements of zero size, from
    ``levels``; ``bar``: torque per twist per pitch of the bare bar, in elements of the same size in the bulk, ``size``;
    ``exact``: the same by Saint-Venant's series, G J / d; ``unit``: E d^3 of the beam, N m.
    """

    K: Array
    levels: tuple[Level, ...]
    size: float
    bar: float
    exact: float
    unit: float = 1.0

    @property
    def strain(self) -> Array:
        """Forms (4, 9, 9) of the strain near the scale's edges, from the finest mesh."""
        return self.levels[-1].strain

    @property
    def stiffness(self) -> Value:
        """Stiffness against inclination, N m, as in [joint] of a beam file."""
        return Value(*(self.unit * x for x in self.K_theta))

    @property
    def K_theta(self) -> Value:
        """Stiffness against inclination, the other motions free, E d^3."""
        return Value(inclination_stiffness(self.K[:7, :7]), _error([level.K_theta for level in self.levels]))

    @property
    def C_f(self) -> Value:
        """Torque per twist of the pitch without contact over that of the bare bar."""
        return Value(twisting_stiffness(self.K[:7, :7]) / self.bar, _error(self.C_f_levels))

    @property
    def C_f_levels(self) -> list[float]:
        """C_f of each mesh."""
        return [level.rigidity / self.bar for level in self.levels]

    @property
    def order(self) -> float:
        """Observed order of convergence of K_theta in the last three sizes; NaN with fewer sizes or no order."""
        K = [level.K_theta for level in self.levels[-3:]]
        if len(K) < 3 or (K[0] - K[1]) * (K[1] - K[2]) <= 0:
            return float("nan")
        return log2((K[0] - K[1]) / (K[1] - K[2]))


Listener = Callable[[Level], None]


def joint(
    beam: Beam,
    *,
    edge_size: float | None = None,
    levels: int = LEVELS,
    tab: TabName = "rigid",
    fresh: bool = False,
    progress: Listener | None = None,
) -> JointMatrix:
    """Return the stiffness of a beam's joint by finite elements, extrapolated to elements of zero size.

    Small strains; over the scale's six motions, twist, bend and stretch. K_theta and C_f, for which the theory has
    scaling laws, come with error bars; set them in a beam by ``beam.replace(joint={"stiffness": found.stiffness.value,
    "inclusion_factor": found.C_f.value})``.

    Parameters
    ----------
    beam : Beam
        The beam; its joint's stiffness and inclusion factor are not used.
    edge_size : float, optional
        Size of the elements along the embedded scale's edges in the coarsest mesh, pitches; a fifth of the embedded
        length or half width, whichever is smaller, if not given.
    levels : int
        Number of meshes, 1 to 6; each halves the size. Those behind two that cannot be meshed are left out.
    tab : {"rigid", "elastic"}
        Whether the embedded part of a scale is rigid or a solid of the scale's modulus, glued to the bar and driven at
        its root, the section at the base line.
    fresh : bool
        Compute anew, without the results of earlier runs in the user's cache, XDG_CACHE_HOME/squama/joints.
    progress : callable, optional
        Called with each `Level` when it is done.

    Returns
    -------
    JointMatrix
        ``stiffness`` (N m), ``C_f``, the matrix ``K`` and all meshes.

    Raises
    ------
    InputError
        A package is missing, the scale does not fit into the substrate, has no modulus to bend by, or the mesher or
        solver fails. Levels computed before stay in the cache.
    """
    arguments.beam(beam)
    only_one(beam.faces, "elements")
    # rounded, so that beams that are equal but for rounding have one result; the exposed part plays no role
    shape = Geometry(*(float(f"{x:.12g}") for x in geometry(beam)._replace(eta=1.0)))
    shape.check()
    if not 1 <= levels <= 6:
        refuse("levels", str(levels), "must be 1 to 6")
    arguments.one_of("tab", tab, TABS)
    material = _of_tab(beam) if tab == "elastic" else None
    size, edges = sizes(shape, levels, edge_size)
    done: list[Level] = []

    def of_mesh(edge: float) -> tuple[Array, int]:
        found = response(pitch_mesh(shape, size, edge, tab=material is not None), shape, material)
        return np.concatenate([found.K[None], found.strain]), found.elements

    for edge in edges:
        began = time.perf_counter()
        try:
            forms, count, now = kept(("pitch", *shape, *(material or ()), size, edge), fresh, partial(of_mesh, edge))
        except MeshError:
            # the mesher gives up on some fine meshes: two coarser ones have an error bar, too
            if len(done) < ENOUGH:
                raise
            break
        done.append(Level(edge, count, forms[0], time.perf_counter() - began if now else 0.0, forms[1:]))
        if progress is not None:
            progress(done[-1])
    bar = kept(("bar", *shape, size), fresh, lambda: (response(bar_mesh(shape, size), shape).K[6:, 6], 0))[0]
    unit = beam.unit_moment
    exact = beam.G_B * beam.J / (unit * beam.pitch)
    return JointMatrix(extrapolated(done), tuple(done), size, float(bar[0]), exact, unit)


def _of_tab(beam: Beam) -> Material:
    """Return the material of the embedded part; its modulus is over that of the substrate."""
    if beam.scale.youngs_modulus is None:
        refuse("scale.youngs_modulus", "", "is needed for an elastic tab", 'write e.g. "3 GPa", or ask for a rigid one')
    ratio = beam.scale.youngs_modulus / beam.substrate.youngs_modulus
    return Material(float(f"{ratio:.12g}"), beam.scale.nu)


def sizes(shape: Geometry, levels: int, edge_size: float | None = None) -> tuple[float, list[float]]:
    """Return the size of elements in the bulk, and those along the scale's edges, each half the one before; pitches."""
    coarse = min(shape.zeta, shape.beta) / 5
    if shape.lean:
        # between long embedded parts, twice the remaining distance
        coarse = min(coarse, 2 * (shape.gap - shape.thickness))
    coarse = coarse if edge_size is None else edge_size
    # in the bulk at least three elements through the thickness and two across, and not too many
    bulk = min(SIZE, 0.75 * shape.lam, 0.4 * shape.width), (12 * shape.width * shape.lam / _MOST) ** (1 / 3)
    return max(*bulk, coarse / 2**levels), (coarse / 2.0 ** np.arange(levels)).tolist()


def extrapolated(levels: Sequence[Level]) -> Array:
    """Return K (9, 9) for elements of zero size along the edges: linear from the last two levels, or the last."""
    K = levels[-1].K
    if len(levels) > 1:
        K = 2 * K - levels[-2].K
    # meshes too coarse for the trend must not make a joint that gives energy away
    return np.asarray(K if np.linalg.eigvalsh(K).min() > 0 else levels[-1].K)


def _error(values: Sequence[float]) -> float:
    """Return the error bar of a value extrapolated linearly from the last two levels, each of half the size before."""
    if len(values) < 2:
        return np.inf
    correction = abs(values[-1] - values[-2])
    if len(values) < 3:
        return correction
    return max(correction / 2, abs(2 * values[-1] - 3 * values[-2] + values[-3]))


def kept(key: tuple[object, ...], fresh: bool, compute: Callable[[], tuple[Array, int]]) -> tuple[Array, int, bool]:
    """Return an array and a count from the user's cache, or by ``compute``, and whether they were computed.

    There is a file for each key, which determines the numbers. The folder can be deleted at any time. Where it cannot
    be written, which is reported once, or a file is damaged, numbers are computed; ``fresh`` neither reads nor writes
    it.
    """
    if fresh:
        return *compute(), True
    text = json.dumps([_SCHEME, __version__, *key])
    given = os.environ.get("XDG_CACHE_HOME", "")
    try:
        base = Path(given) if Path(given).is_absolute() else Path("~/.cache").expanduser()
    except RuntimeError as error:
        # there is no home
        not_kept(_WHAT, "~/.cache", error)
        return *compute(), True
    place = base / "squama" / "joints" / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"
    with suppress(ValueError, KeyError, TypeError):
        record = json.loads(files.read_text(place))
        array, count = np.array(record["array"], float), int(record["count"])
        if record["key"] == text and np.isfinite(array).all():
            return array, count, False
    array, count = compute()
    record = json.dumps({"key": text, "array": array.tolist(), "count": count})
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        files.atomic_write(place, lambda beside: beside.write_text(record, encoding="utf-8"))
    except (OSError, InputError) as error:
        not_kept(_WHAT, place.parent, error)
    return array, count, True
