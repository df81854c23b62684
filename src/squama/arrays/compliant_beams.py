"""Curves of thick, elastic scales on compliant joints for arrays of designs, in twisting or bending."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments, loads
from squama.batch.threads import in_parts
from squama.beam import joint_law
from squama.beam.faces import FACES, FacesName
from squama.beam.faces import read as faces_word
from squama.beam.joint_law import Given
from squama.beam.parts import PLASTIC
from squama.contacts import entry, path, states
from squama.contacts.moved import moved
from squama.contacts.own_scales import Own, ratios
from squama.contacts.system import PHI
from squama.errors import naming, refuse
from squama.joints import lateral, law, tilt
from squama.joints.factor import K_THETA, pivots, scaled
from squama.loads import LOADS, MANY_SCALES, NOTHING, STRAINS, SenseName
from squama.model import section
from squama.types import Array

PART = 256
"""Designs that a thread follows at a time; fixed, because matrix products of other sizes differ in the last digits."""
COLUMNS = {"torque": "T", "N": "N", "f": "f", "W_fr": "W_fr", "W_snap": "W_snap", "W": "W"}
"""Columns of the model's states by the fields of :class:`Response`."""


class Designs(NamedTuple):
    """Many beams with thick scales, E = d = 1: arguments of :func:`response` as arrays (n,), and optional ones.

    ``K_theta`` and ``rigidity`` replace those of the joint's law, ``factor`` multiplies K_theta; ``psi``: bend per
    pitch (rad) at which a beam is held while it is twisted.
    """

    eta: Array
    beta: Array
    lam: Array
    zeta: Array
    alpha: Array
    theta0: Array
    thickness: Array
    width: Array
    nu: Array
    mu: Array
    modulus_ratio: Array
    scale_nu: Array
    K_theta: Array | None = None
    rigidity: Array | None = None
    factor: Array | None = None
    psi: Array | None = None

    @property
    def shape(self) -> law.Shape:
        """Arguments of the law of the joint."""
        return law.Shape(*(getattr(self, name) for name in law.Shape._fields))

    def at(self, i: Array) -> Designs:
        """Return the designs with the indices ``i``."""
        return Designs(**{name: v[i] for name, v in self._asdict().items() if v is not None})

    def scales(self, *, ideal: bool) -> path.Scale:
        """Return the scales of the designs; thin and rigid with ``ideal``."""
        one = path.Scale(self.eta, self.beta, self.lam, self.alpha, self.theta0, self.thickness, nu=self.scale_nu)
        if ideal:
            return one._replace(h=0.0 * self.thickness, D=np.full(self.eta.size, np.inf))
        return one._replace(D=section.plate_rigidity(self.modulus_ratio, self.thickness, self.scale_nu))

    def joints(self, given: Given) -> Array:
        """Return the joints (n, 9, 9) or (n, 7, 7): the beam's matrix or the law's, scaled to given stiffnesses."""
        if given.matrix is None:
            K = law.stiffness(self.shape)
        else:
            K = np.tile(given.matrix.K, (self.eta.size, 1, 1)).astype(self.eta.dtype)
        K_theta = self.K_theta
        if self.factor is not None:
            K_theta = self.factor * (pivots(K)[..., K_THETA] if K_theta is None else K_theta)
        # with scales on both faces the rigidity is that of both
        rigidity = None if given.seen else self.rigidity
        if K_theta is None and rigidity is None:
            return K
        return scaled(K, K_theta=K_theta, rigidity=rigidity, free=given.free("twist"))

    def beams(self, scale: path.Scale, given: Given, loaded: Sequence[str], sense: int) -> entry.Beams:
        """Return the beams for the compiled solver, with the strains ``loaded``."""
        K, bar = self.joints(given), np.zeros((0,))
        aside = lateral.stiffness(K, self.shape) / K[:, 7, 7] if K.shape[1] > 7 else 1.0
        if given.seen:
            sizes = joint_law.Sizes(
                1.0, self.nu, self.width, 2 * self.lam, 1.0, self.beta, self.thickness, self.zeta, self.beta, self.lam,
                self.zeta,
            )  # fmt: skip
            bar = np.stack(joint_law.own(sizes, joint_law.whole), axis=-1)
            if K.shape[1] < 9:
                bar[:, [0, 2, 3]] = 0.0
        seen, free = given.seen, given.free(*loaded)
        found = path.beams(
            scale, K, self.mu, sense=sense, free=free, aside=aside, seen=seen, own=bar,
            tilt=tilt.tilts(self.shape) * (K.shape[1] > 7),
        )  # fmt: skip
        if seen and self.rigidity is not None:
            # the bar's own stiffness against twist is that with which the whole beam has the given rigidity
            found.own[:, 1] = 0.0
            twisted = found._replace(free=np.tile(np.array(given.free("twist"), float), (len(K), 1)))
            found.own[:, 1] = states.bare(twisted)[:, 0, 0] - self.rigidity
        return found

    def legs(self, at: Array, load: str) -> tuple[Array, Array | None]:
        """Return ways (n, m) to twists or bends ``at`` (n, m), and the (psi, phi) there; None for twist alone.

        A beam that is held bent is bent first; its way then has one more place, the end of the bending.
        """
        if self.psi is None:
            return at, np.stack([at, 0 * at], axis=-1) if load == "bending" else None
        ways = np.column_stack([0 * self.psi, at]) + np.abs(self.psi)[:, None]
        # exactly the length of the way, to the last digit
        return ways, np.stack(np.broadcast_arrays(self.psi[:, None], ways - ways[:, :1]), axis=-1)


class Response(NamedTuple):
    """Curves of many beams with thick scales, E = d = 1; arrays of the designs' shape, or (..., m) over the twists.

    ``phi_e`` twist per pitch at engagement (inf without contact), ``phi_end`` and ``end`` the end of the curve, in the
    words of :class:`squama.End`: range end, no engagement, no equilibrium, side entry, touching at rest. A second
    contact, another pair of edges or a snap does not end a curve. ``in_range``: whether the law of the joint covers the
    design; the results of other designs are NaN. ``K_theta`` and ``rigidity`` (torque per twist of the beam without
    contact) over E d^3.

    At the twists (..., m): ``torque`` over E d^3, bar included; ``stiffness_ratio`` its slope between the twists over
    the rigidity; ``N``, ``f`` forces of a cell's contacts over E d^2; ``W_fr``, ``W_snap``, ``W`` frictional work,
    energy lost in snaps, and work of the torque, per pitch over E d^3 (the elastic energy is W - W_fr - W_snap);
    ``stress`` the largest (von Mises) in an elastic scale over E; NaN beyond the end.

    At the last twist ``finite_ratio`` and ``finite_tangent``: torque of a beam with the given number of scales, and its
    slope from the previous twist, over those of the endless beam; NaN without a number, or if not found.
    """

    phi_e: Array
    phi_end: Array
    end: Array
    in_range: Array
    K_theta: Array
    rigidity: Array
    torque: Array
    stiffness_ratio: Array
    N: Array
    f: Array
    W_fr: Array
    W_snap: Array
    W: Array
    stress: Array
    finite_ratio: Array
    finite_tangent: Array


def response(
    phi: ArrayLike,
    *,
    eta: ArrayLike,
    beta: ArrayLike,
    lam: ArrayLike,
    zeta: ArrayLike,
    alpha: ArrayLike,
    theta0: ArrayLike,
    thickness: ArrayLike,
    width: ArrayLike,
    nu: ArrayLike,
    mu: ArrayLike,
    modulus_ratio: ArrayLike = np.inf,
    scale_nu: ArrayLike = PLASTIC,
    sense: SenseName = "+",
    hold: str = NOTHING,
    faces: FacesName = "one",
    scales: int | None = None,
    threads: int | None = None,
) -> Response:
    """Twist arrays of beams with thick, elastic scales on a joint of six motions (docs, theory: thick scales).

    Parameters
    ----------
    phi
        Twists per pitch, rad, rising, a sequence (m,); all beams are followed along them.
    eta, beta, lam, zeta, thickness, width
        Exposed length, half width, half thickness of the substrate, embedded length, thickness of a scale and width of
        the substrate, over the pitch; these and all below broadcast against each other.
    alpha, theta0
        Angles, rad.
    nu, mu
        Poisson's ratio of the substrate, coefficient of friction.
    modulus_ratio, scale_nu
        Young's modulus of the scales over the substrate's (inf: rigid), their Poisson's ratio.
    sense
        "+" or "-"; twists are magnitudes.
    hold
        Held strains, as in :func:`squama.twist`; by default none, so that the beams bow.
    faces
        "one", or scales on both faces: "mirrored" or "turned", as in a beam file. ``N``, ``f`` and ``phi_e`` are then
        those of the face that touches first, ``stress`` is the larger one.
    scales
        Number of scales (of each face) of beams with free ends, for ``finite_ratio``.
    threads
        Number of threads; by default the number of cores, or NUMBA_NUM_THREADS.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import numpy as np, squama
    >>> r = squama.response(np.linspace(0, 0.12, 25), eta=4, beta=0.5, lam=0.4, zeta=0.35, alpha=np.radians(45),
    ...     theta0=np.radians(15), thickness=[0.04, 0.08], width=1.2, nu=0.48, mu=0.3, modulus_ratio=3e4)
    >>> print(r.phi_e.round(3), r.stiffness_ratio[:, -1].round(1), r.end)
    [0.049 0.036] [2.  2.2] ['range end' 'range end']
    """
    twists = arguments.not_negative("phi", phi)
    if twists.ndim != 1 or not twists.size or (np.diff(twists) <= 0).any() or twists[-1] >= np.pi:
        refuse("phi", "", "must be a rising sequence of twists below pi", "write e.g. np.linspace(0, 0.2, 40)")
    sign = arguments.sense(sense)
    contact = {"eta": eta, "beta": beta, "lam": lam, "zeta": zeta, "alpha": alpha, "theta0": theta0}
    rest = {"thickness": thickness, "width": width, "nu": nu, "mu": mu}
    columns, shape = arguments.designs(**contact, **rest, modulus_ratio=modulus_ratio, scale_nu=scale_nu)
    with naming("hold"):
        held = loads.hold(hold)
    with naming("faces"):
        other = FACES[faces_word(faces)]
    given = Given(None, None, None, other.seen if other else (), held)
    found = follow(
        Designs(*columns),
        np.broadcast_to(twists, (columns[0].size, twists.size)),
        given,
        sense=sign,
        own=None if scales is None else Own(arguments.whole("scales", scales, 2, MANY_SCALES)),
        threads=threads,
    )
    return Response._make(v.reshape((*shape, *v.shape[1:])) for v in found)


def follow(
    designs: Designs,
    at: Array,
    given: Given,
    *,
    load: str = "twisting",
    most: Array | None = None,
    ideal: bool = False,
    sense: int = 1,
    copies: int = 0,
    stressed: slice = slice(None),
    own: Own | None = None,
    threads: int | None = None,
) -> Response:
    """Follow n beams along rising twists ``at`` (n, m) and return their :class:`Response`; arguments are not checked.

    ``given``: data of the joint and held strains. With ``load`` "bending" the beams are bent alone: ``at`` are bends,
    torques are moments, and the rigidity is that of bending. For beams that are held bent the twists are above 0,
    ``W_fr`` and ``W`` count from rest, and ``phi_e`` and ``phi_end`` are 0 if they come during the bending.

    With complex steps in designs and twists, each beam ``copies`` times in a row, all dependent results are complex:
    exact derivatives (:mod:`squama.contacts.derivatives`). Stresses are computed only at the twists ``stressed``. First
    contacts are searched up to the twists ``most`` (n,), by default the last ones. ``ideal``: thin, rigid scales on the
    same joints. ``own``: number of scales and ends of the finite beams to compare with.
    """
    (n, m), kind = at.shape, designs.eta.dtype
    known = np.ones(n, bool) if given.matrix else law.within(designs.shape)
    upto = np.real(at[:, -1]) if most is None else most
    loaded = (LOADS[load].verb,) if designs.psi is None else ("bend", "twist")
    strains, strain = tuple(map(STRAINS.index, loaded)), int(load == "bending")
    before = np.zeros(n) if designs.psi is None else np.abs(designs.psi)
    alone, along = np.full((6, n), np.nan, kind), np.full((len(COLUMNS) + 1, n, m), np.nan, kind)
    ends = np.full(n, "", dtype=path.WORDS.dtype)
    which = np.flatnonzero(known).reshape((-1, copies) if copies else -1)

    def begin() -> Callable[[int, int], None]:
        def work(low: int, high: int) -> None:
            i = which[low:high].ravel()
            some = designs.at(i)
            scale = some.scales(ideal=ideal)
            beams = some.beams(scale, given, loaded, sense)
            ways, corners = some.legs(at[i], load)
            far = upto[i] + before[i].real
            if copies:
                found = moved(beams, ways, copies, most=far, corners=corners)
            else:
                found = path.follow_all(beams, ways, most=far, corners=corners, room=path.ROOM if own else 1)
            if own:
                alone[4:, i] = ratios(beams, found, own, *strains)
            faces = [face._replace(rows=face.rows[:, -m:]) for face in found.faces]
            # in twisting that of the face that touches first
            lead = np.real([face.contacts[:, 3] for face in faces]).argmin(axis=0)
            first = _of(lead, [face.contacts for face in faces])
            told = path.named(_of(lead * (strains == (PHI,)), [face.rows for face in faces]))
            places = np.stack([first[:, 3], found.ends[:, 1]])
            alone[:2, i] = places if designs.psi is None else np.maximum(places - before[i], 0.0)
            alone[2, i], alone[3, i] = pivots(beams.K)[:, K_THETA], states.bare(beams)[:, strain, strain]
            ends[i] = path.endings(first, found.ends)
            for row, name in zip(along, COLUMNS.values(), strict=False):
                row[i] = told[name]
            stress = [states.stresses_of(scale, face._replace(rows=face.rows[:, stressed])) for face in faces]
            along[-1, i, stressed] = np.fmax.reduce(stress)

        return work

    from threadpoolctl import threadpool_limits

    # BLAS threads beside these would only wait for each other
    with threadpool_limits(1, user_api="blas"):
        part = max(1, PART // max(1, copies))
        in_parts(begin, len(which), most=part, least=part, threads=threads)
    phi_e, phi_end, K_theta, rigidity, *finite = alone
    slope = _slopes(at, along[0], phi_e) / rigidity[:, None]
    beams = phi_e, phi_end, ends, known, K_theta, rigidity
    return Response._make([*beams, along[0], slope, *along[1:], *finite])


def _of(face: Array, values: Sequence[Array]) -> Array:
    """Return the values of n beams on one of the faces with scales, by its index (n,)."""
    if len(values) == 1:
        return values[0]
    one, other = values
    return np.where(face.reshape(-1, *[1] * (one.ndim - 1)) > 0, other, one)


def _slopes(x: Array, y: Array, start: Array) -> Array:
    """Return the slopes of y (n, m) over x (n, m), leaving out the interval that contains ``start`` (n,)."""
    steps = np.diff(x)
    each, weights = np.diff(y) / steps, 1 / steps
    touching = np.real(x) >= np.real(start)[:, None]
    each[touching[:, 1:] != touching[:, :-1]] = np.nan
    total, summed = np.zeros((2, *y.shape), y.dtype)
    there, each = np.isfinite(each), np.nan_to_num(each)
    for side in (np.s_[:, 1:], np.s_[:, :-1]):
        total[side] += weights * there
        summed[side] += weights * each
    return np.asarray(np.divide(summed, total, out=np.full(y.shape, np.nan, y.dtype), where=total.real > 0))
