"""Arrays of real beams: thick, elastic scales on the joint by its law, followed along the twist."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments, loads
from squama.batch.threads import in_parts
from squama.beam.joint_law import Given
from squama.beam.parts import PLASTIC
from squama.contacts import entry, path, states
from squama.contacts.moved import moved
from squama.errors import naming, refuse
from squama.joints import law
from squama.joints.factor import K_THETA, pivots
from squama.loads import NOTHING
from squama.model import section
from squama.types import Array

PART = 256
"""Designs a thread takes at a time: always as many, for products of matrices of other sizes end in other digits."""
COLUMNS = {"torque": "T", "N": "N", "f": "f", "W_fr": "W_fr", "W_snap": "W_snap", "W": "W"}
"""Fields that are columns of the model's states."""


class Designs(NamedTuple):
    """Many real beams, E = d = 1: arrays (n,), arguments of :func:`response` by name."""

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

    @property
    def shape(self) -> law.Shape:
        """What their joints depend on."""
        return law.Shape(*(getattr(self, name) for name in law.Shape._fields))

    def scales(self, *, ideal: bool) -> path.Scale:
        """Return their scales, thin and rigid or as they are."""
        one = path.Scale(self.eta, self.beta, self.lam, self.alpha, self.theta0, self.thickness, nu=self.scale_nu)
        if ideal:
            return one._replace(h=0.0 * self.thickness, D=np.full(self.eta.size, np.inf))
        return one._replace(D=section.plate_rigidity(self.modulus_ratio, self.thickness, self.scale_nu))


class Response(NamedTuple):
    """Curves of many real beams, E = d = 1; shapes: that of the designs, or that and the twists' (...).

    ``phi_e`` twist per pitch at engagement (inf where nothing touches), ``phi_end`` where the curve ends and ``end``
    why, in the words of :class:`squama.End`: range end, no engagement, no equilibrium, side entry, touching at rest.
    A second contact, another pair of edges or a snap ends no curve. ``in_range``: whether the law of the joint knows
    the design; figures of the others are NaN. ``K_theta`` and ``rigidity`` (torque per twist of the beam without
    contact) over E d^3.

    At the twists (...): ``torque`` over E d^3, the bar's included; ``stiffness_ratio`` its slope between the twists
    over the rigidity; ``N``, ``f`` forces of a cell's contacts over E d^2; ``W_fr``, ``W_snap``, ``W`` frictional work,
    energy lost in snaps, and the torque's work, per pitch over E d^3 (elastic energy is W - W_fr - W_snap); ``stress``
    the largest (von Mises) in an elastic scale over E; NaN beyond the end.
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
    sense: str = "+",
    hold: str = NOTHING,
    threads: int | None = None,
) -> Response:
    """Twist arrays of real beams: thick, elastic scales on a joint of six motions (docs, theory: the real beam).

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
        What is held, as in :func:`squama.twist`: by default nothing, the beams bow.
    threads
        By default as many as there are cores, or as NUMBA_NUM_THREADS says.

    Returns
    -------
    Response

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
    columns, shape = arguments.designs(
        eta=eta, beta=beta, lam=lam, zeta=zeta, alpha=alpha, theta0=theta0, thickness=thickness, width=width, nu=nu,
        mu=mu, modulus_ratio=modulus_ratio, scale_nu=scale_nu,
    )  # fmt: skip
    with naming("hold"):
        free = Given(None, None, None, held=loads.hold(hold)).free("twist")
    found = follow(Designs(*columns), twists, free=free, sense=sign, threads=threads)
    return Response._make(v.reshape((*shape, *v.shape[1:])) for v in found)


def follow(
    designs: Designs,
    twists: Array,
    *,
    free: path.Free,
    K: Callable[[Array], Array] | None = None,
    known: Array | None = None,
    most: Array | float | None = None,
    ideal: bool = False,
    sense: int = 1,
    copies: int = 0,
    held: Array | None = None,
    load: str = "twisting",
    stressed: slice = slice(None),
    threads: int | None = None,
) -> Response:
    """Follow beams along twists, rising, (m,) for all or (n, m); what :func:`response` returns, nothing checked.

    With complex steps in designs and twists, each beam ``copies`` times, one after the other, all that depends on them
    is complex: derivatives of what is followed, to all digits (:mod:`squama.contacts.derivatives`). Stresses are taken
    at some of the twists, ``stressed``. ``free``: strains without a moment or force, joints (i, 9, 9).
    ``held`` (n,): bends per pitch in which they are held;
    twists are above 0 then, joints (i, 9, 9), ``W_fr`` and ``W`` from rest, ``phi_e`` and ``phi_end`` 0 where they come
    while a beam is bent. With ``load`` "bending" beams are bent alone, joints as well: twists are bends then, torques
    moments, the rigidity that of bending.

    ``K`` returns the joints (i, 9, 9) or (i, 7, 7) of the designs with the numbers (i,), ``known`` (n,) tells which of
    them have one; by default it is the law's, of designs in its range. First contacts are looked for below the twists
    ``most``, by default the last ones. ``ideal``: scales are thin and rigid, whatever holds them.
    """
    n, known = designs.eta.size, law.within(designs.shape) if known is None else known
    upto = np.broadcast_to(np.real(twists[..., -1]) if most is None else most, n)
    at_all, scales = np.broadcast_to(twists, (n, twists.shape[-1])), designs.scales(ideal=ideal)
    m, kind = at_all.shape[1], designs.eta.dtype
    alone, along = np.full((4, n), np.nan, kind), np.full((len(COLUMNS) + 1, n, m), np.nan, kind)
    ends, bends = np.full(n, "", dtype=path.WORDS.dtype), load == "bending"
    which = np.flatnonzero(known).reshape((-1, copies) if copies else -1)

    def begin() -> Callable[[int, int], None]:
        def work(low: int, high: int) -> None:
            at = which[low:high]
            joints = law.stiffness(designs.shape.at(at)) if K is None else K(at)
            joints, at = joints.reshape(-1, *joints.shape[-2:]), at.ravel()
            scale = path.Scale(*(v[at] for v in scales))
            aside = (designs.width[at] / (2 * designs.lam[at])) ** 2
            beams = path.beams(scale, joints, designs.mu[at], sense=sense, free=free, aside=aside)
            if bends:
                corners = np.stack([at_all[at], 0 * at_all[at]], axis=-1)
                found = path.follow_all(beams, at_all[at], corners=corners, most=upto[at])
            elif held is not None:
                found = _held_bent(beams, held[at], at_all[at], upto[at])
            elif copies:
                found = moved(beams, at_all[at], copies, most=upto[at])
            else:
                found = path.follow_all(beams, at_all[at], most=upto[at])
            places = np.stack([found.contacts[:, 3], found.ends[:, 1]])
            alone[:2, at] = places if held is None else np.maximum(places - np.abs(held[at]), 0.0)
            alone[2, at], alone[3, at] = pivots(joints)[:, K_THETA], states.bare(beams)[:, int(bends), int(bends)]
            ends[at], known = path.endings(found.contacts, found.ends), path.named(found.rows)
            for i, name in enumerate(COLUMNS.values()):
                along[i, at] = known[name]
            along[-1, at, stressed] = states.stresses_of(scale, found._replace(rows=found.rows[:, stressed]))

        return work

    from threadpoolctl import threadpool_limits

    # threads of BLAS beside the others only wait for each other
    with threadpool_limits(1, user_api="blas"):
        part = max(1, PART // max(1, copies))
        in_parts(begin, len(which), most=part, least=part, threads=threads)
    phi_e, phi_end, K_theta, rigidity = alone
    slope = _slopes(at_all, along[0], phi_e) / rigidity[:, None]
    return Response(phi_e, phi_end, ends, known, K_theta, rigidity, along[0], slope, *along[1:])


def _held_bent(beams: entry.Beams, bends: Array, twists: Array, most: Array) -> path.Answers:
    """Bend beams by ``bends`` (n,) and twist them to rising twists (n, m) above 0; rows at these.

    What touches first is looked for below the twists ``most`` (n,).
    """
    ways = np.column_stack([0 * bends, twists]) + np.abs(bends)[:, None]
    # as far as the way goes, to the last digit
    corners = np.stack(np.broadcast_arrays(bends[:, None], ways - ways[:, :1]), axis=-1)
    found = path.follow_all(beams, ways, corners=corners, most=np.abs(bends) + most)
    return found._replace(rows=found.rows[:, 1:])


def _slopes(x: Array, y: Array, start: Array) -> Array:
    """Return the slopes of y (n, m) over x (n, m), those before ``start`` (n,) and after it taken apart."""
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
