"""Arrays of real beams: thick, elastic scales on the joint by its law, followed along the twist."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.batch.threads import in_parts
from squama.beam.parts import PLASTIC
from squama.errors import refuse
from squama.joints import law
from squama.joints.factor import K_THETA, TWIST, pivots
from squama.model import section
from squama.real import path
from squama.types import Array

PART, LEAST = 512, 64
"""Designs a thread takes at a time, at most and at least."""
COLUMNS = {"T": 1, "N": 2, "f": 3, "W_fr": 8}
"""Fields that are columns of the model's states."""


class Response(NamedTuple):
    """Curves of many real beams, E = d = 1; shapes: that of the designs, or that and the twists' (...).

    ``phi_e`` twist per pitch at engagement (inf where nothing touches), ``phi_end`` where the curve ends and ``end``
    why, in the words of :class:`squama.End`: beyond another contact, or where a contact leaves its edge, general
    contact would go on (``squama.twist``). ``in_range``: whether the law of the joint knows the design; figures of the
    others are NaN. ``K_theta`` and ``rigidity`` (torque per twist of the beam without contact) over E d^3.

    At the twists (...): ``T`` torque over E d^3, the bar's included; ``stiffness_ratio`` its slope between the twists
    over the rigidity; ``N``, ``f`` forces of a contact over E d^2, ``W_fr`` frictional work per pitch over E d^3; NaN
    beyond the end.
    """

    phi_e: Array
    phi_end: Array
    end: Array
    in_range: Array
    K_theta: Array
    rigidity: Array
    T: Array
    stiffness_ratio: Array
    N: Array
    f: Array
    W_fr: Array


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
    >>> print(r.phi_e.round(3), r.stiffness_ratio[:, -1].round(0), r.end)
    [0.052 0.038] [ 5. 12.] ['range end' 'range end']
    """
    twists = arguments.not_negative("phi", phi)
    if twists.ndim != 1 or not twists.size or (np.diff(twists) <= 0).any() or twists[-1] >= np.pi:
        refuse("phi", "", "must be a rising sequence of twists below pi", "write e.g. np.linspace(0, 0.2, 40)")
    sign = arguments.sense(sense)
    columns, shape = arguments.designs(
        eta=eta, beta=beta, lam=lam, zeta=zeta, alpha=alpha, theta0=theta0, thickness=thickness, width=width, nu=nu,
        mu=mu, scale_nu=scale_nu, modulus_ratio=modulus_ratio,
    )  # fmt: skip
    eta, beta, lam, zeta, alpha, theta0, thickness, width, nu, friction, scale_nu, ratio = columns
    joint = law.Shape(width, lam, zeta, beta, thickness, alpha, theta0, nu)
    D = section.plate_rigidity(ratio, thickness, scale_nu)
    scales = path.Scale(eta, beta, lam, alpha, theta0, thickness, D, scale_nu)
    known = law.within(joint)
    which, n = np.flatnonzero(known), known.size
    alone, along = np.full((4, n), np.nan), np.full((len(COLUMNS), n, twists.size), np.nan)
    ends = np.full(n, "", dtype=path.WORDS.dtype)

    def begin() -> Callable[[int, int], None]:
        def work(low: int, high: int) -> None:
            at = which[low:high]
            K = law.stiffness(joint.at(at))
            beams = path.beams(path.Scale(*(v[at] for v in scales)), K, friction[at], sense=sign)
            found = path.follow_all(beams, np.broadcast_to(twists, (at.size, twists.size)), most=float(twists[-1]))
            alone[:2, at] = found.contacts[:, 3], found.ends[:, 1]
            alone[2:, at] = pivots(K)[:, [K_THETA, TWIST]].T
            ends[at] = path.endings(found.contacts, found.ends)
            along[:, at] = np.moveaxis(found.rows[..., list(COLUMNS.values())], -1, 0)

        return work

    in_parts(begin, which.size, most=PART, least=LEAST, threads=threads)
    T, N, f, W_fr = along
    phi_e, phi_end, K_theta, rigidity = alone
    slope = _slopes(twists, T, phi_e) / rigidity[:, None]
    fields = (phi_e, phi_end, ends, known, K_theta, rigidity, T, slope, N, f, W_fr)
    return Response._make(v.reshape((*shape, *v.shape[1:])) for v in fields)


def _slopes(x: Array, y: Array, start: Array) -> Array:
    """Return the slopes of y (n, m) over x (m,), those before ``start`` (n,) and after it taken apart."""
    each = np.diff(y) / np.diff(x)
    touching = x >= start[:, None]
    each[touching[:, 1:] != touching[:, :-1]] = np.nan
    sides = np.full((2, *y.shape), np.nan)
    sides[0, :, 1:], sides[1, :, :-1] = each, each
    weights = np.zeros((2, x.size))
    weights[0, 1:], weights[1, :-1] = 1 / np.diff(x), 1 / np.diff(x)
    there = np.isfinite(sides)
    total = (weights[:, None] * there).sum(axis=0)
    summed = (weights[:, None] * np.where(there, sides, 0.0)).sum(axis=0)
    return np.asarray(np.divide(summed, total, out=np.full(y.shape, np.nan), where=total > 0))
