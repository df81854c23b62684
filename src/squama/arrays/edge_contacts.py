"""Array functions over ratios, on hinges: contact, forces and ends. Lengths in pitches, angles in radians."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.arrays import solution
from squama.loads import LawName, SenseName
from squama.model import mechanics, twisting
from squama.model.paths import ARRAY, Twist
from squama.model.plates import Touch
from squama.types import Array


class Contact(NamedTuple):
    """Tip-side contact at given inclinations; every field has the broadcast shape of the inputs.

    ``phi`` twist per pitch (rad), ``p`` and ``s`` places on tip and side edge (pitches), ``dphi_dtheta``,
    ``ds_dtheta``, ``dp_dtheta`` derivatives, ``on_edges`` whether the place lies on both edges. NaN where no twist
    leads to contact.
    """

    phi: Array
    p: Array
    s: Array
    dphi_dtheta: Array
    ds_dtheta: Array
    dp_dtheta: Array
    on_edges: Array


class Forces(NamedTuple):
    """Forces of one contact while it slides; every field has the broadcast shape of the inputs.

    ``normal`` = N l/K_theta, ``friction`` = f l/K_theta (paper Eq. 12), ``torque`` the scales' part of the torque over
    K_theta (paper Eq. 14), ``mu_lock`` coefficient of friction at which the contact locks there, ``dr_dtheta`` slip per
    inclination (pitches, paper Eq. 10).
    """

    normal: Array
    friction: Array
    torque: Array
    mu_lock: Array
    dr_dtheta: Array


class Ends(NamedTuple):
    """Engagement and end of many designs; fields have the inputs' broadcast shape.

    ``phi_e`` twist per pitch at engagement (inf without engagement), ``theta_end``, ``phi_end``, ``end`` (the words of
    :class:`squama.End`), ``neighbour`` whose contact is followed (0 for none), ``other`` pair that ends the path or
    touches instead ("" for none), ``sense`` of the argument, ``phi_touch`` and ``theta_touch`` twist and inclination at
    which that other pair touches (NaN for none). Without engagement phi_end = inf and theta_end = theta0.
    """

    phi_e: Array
    theta_end: Array
    phi_end: Array
    end: Array
    neighbour: Array
    other: Array
    sense: Array = np.asarray("+")
    phi_touch: Array = np.asarray(np.nan)
    theta_touch: Array = np.asarray(np.nan)


def _row(
    theta: ArrayLike, sizes: dict[str, ArrayLike], alpha: ArrayLike, thickness: ArrayLike, sense: str, neighbour: int
) -> Twist:
    """Check the arguments of :func:`contact` and return the row of scales at the inclinations ``theta``."""
    given = {name: arguments.positive(name, v) for name, v in sizes.items()}
    alpha = arguments.between("alpha", alpha, 0.0, np.pi / 2)
    theta = arguments.between("theta", theta, 0.0, np.pi)
    ts = arguments.not_negative("thickness", thickness)
    arguments.together({"theta": theta, **given, "alpha": alpha, "thickness": ts})
    k = arguments.whole("neighbour", neighbour, 1, 1000)
    sa, ca = np.sin(alpha) * arguments.sense(sense), np.cos(alpha)
    return Twist(given["eta"], given["beta"], given["lam"], sa, ca, theta, k, ts)


def contact(
    theta: ArrayLike,
    *,
    eta: ArrayLike,
    beta: ArrayLike,
    lam: ArrayLike,
    alpha: ArrayLike,
    thickness: ArrayLike = 0.0,
    sense: SenseName = "+",
    neighbour: int = 1,
) -> Contact:
    """Tip-side contact at the inclinations ``theta``, on the branch that starts at engagement (paper Eqs. 1-6).

    Parameters
    ----------
    theta
        Inclination, rad, in (0, pi).
    eta, beta, lam, alpha
        Overlap ratio, half width and half thickness over the pitch; alpha in rad, in (0, pi/2).
    thickness
        t_s/d of the scales; for thick scales the lower tip edge touches the upper side edge.
    sense
        "+" or "-", the mirror image; the twist is given as a magnitude.
    neighbour
        k: the tip of scale 1 on the side edge of scale 1 + k.

    Raises
    ------
    InputError
        A value is out of range.

    Examples
    --------
    >>> import numpy as np, squama
    >>> c = squama.contact(np.radians(10), eta=3, beta=1.25, lam=0.45, alpha=np.radians(45))
    >>> print(f"{c.phi:.6f}")
    0.048194
    """
    row = _row(theta, {"eta": eta, "beta": beta, "lam": lam}, alpha, thickness, sense, neighbour)
    with np.errstate(all="ignore"):
        r = row.root(row.theta0, ARRAY)
        q = np.sqrt(r.q2)
        c = twisting.contact(r, q, *row.ratios)
        u = np.where(r.H + q > 0, c.u, np.nan)
        k = row.k
        p, s = c.p * k, c.s * k
        fields = (2 * np.arctan(u) / k, p, s, c.phi_rate / q / k, -c.a_rate / q * k, c.c_rate / q * k)
        on = (abs(p) <= row.beta) & (s >= 0) & (s <= row.eta)
    return Contact(*(np.asarray(v) for v in np.broadcast_arrays(*fields, on)))


def forces(
    theta: ArrayLike,
    *,
    eta: ArrayLike,
    beta: ArrayLike,
    lam: ArrayLike,
    alpha: ArrayLike,
    theta0: ArrayLike,
    mu: ArrayLike,
    thickness: ArrayLike = 0.0,
    law: LawName = "edge",
    sense: SenseName = "+",
    neighbour: int = 1,
) -> Forces:
    """Return forces and torque while the contact slides at the inclinations ``theta`` (paper Eqs. 7-14).

    Parameters
    ----------
    theta
        Inclination, rad; ``theta0`` or more.
    eta, beta, lam, alpha, thickness, sense, neighbour
        As in :func:`contact`.
    theta0, mu
        Initial inclination (rad) and coefficient of friction.
    law
        "edge" (satisfies virtual work) or "plate" (the paper's, of thin scales).

    Returns
    -------
    Forces
        Beyond a lock the values have no meaning: see :func:`ends` for where it is.

    Raises
    ------
    InputError
        A value is out of range.

    Examples
    --------
    >>> import numpy as np, squama
    >>> at = dict(eta=3, beta=1.25, lam=0.45, alpha=np.radians(45), theta0=np.radians(10))
    >>> f = squama.forces(np.radians(50), mu=0, law="plate", **at)
    >>> print(f"{f.torque:.3f}")
    3.604
    """
    theta0 = arguments.between("theta0", theta0, 0.0, np.pi / 2)
    mu = arguments.not_negative("mu", mu)
    row = _row(theta, {"eta": eta, "beta": beta, "lam": lam}, alpha, thickness, sense, neighbour)
    arguments.thin(np.asarray(row.thickness), arguments.law(law))
    with np.errstate(all="ignore"):
        pt = row.point(row.theta0, law, ARRAY)
        f = mechanics.forces(pt, theta0, mu)
        fields = (f.N * row.eta, f.f * row.eta, f.torque, mechanics.mu_lock(pt), pt.slip_rate)
    return Forces(*(np.asarray(v) for v in np.broadcast_arrays(*fields)))


def ends(
    *,
    eta: ArrayLike,
    beta: ArrayLike,
    lam: ArrayLike,
    alpha: ArrayLike,
    theta0: ArrayLike,
    mu: ArrayLike,
    thickness: ArrayLike = 0.0,
    law: LawName = "edge",
    sense: SenseName = "+",
    contacts: Literal["tip", "all"] = "tip",
) -> Ends:
    """Find where every design engages, and how and where its curve ends.

    Parameters
    ----------
    eta, beta, lam, alpha, theta0, mu
        Ratios, angles (rad) and coefficient of friction; arrays are broadcast against each other.
    thickness
        t_s/d of the scales. Where it fills the gap between the scales at rest, the end is "touching at rest".
    law
        "edge" or "plate" (of thin scales).
    sense
        "+" or "-".
    contacts
        "tip": tip-side contacts of all neighbours; "all": every pair of plate edges and faces.

    Raises
    ------
    InputError
        A value is out of range.

    Examples
    --------
    >>> import numpy as np, squama
    >>> e = squama.ends(eta=3, beta=1.25, lam=0.45, alpha=np.radians(45), theta0=np.radians(10), mu=[0.0, 0.5])
    >>> print(*e.end, sep=", ")
    kinematic lock, frictional lock
    """
    flat, shape = arguments.designs(eta=eta, beta=beta, lam=lam, alpha=alpha, theta0=theta0, mu=mu, thickness=thickness)
    arguments.thin(flat[6], arguments.law(law))
    mirrored = arguments.sense(sense) < 0
    arguments.one_of("contacts", contacts, ("tip", "all"))
    sol = solution.solve(dict(zip((*solution.COLUMNS, "thickness"), flat, strict=True)), law=law, sense=sense)
    came = sol.crossing > 0
    touches: list[Touch | None] = [None] * came.size
    if contacts == "all":
        sol, touches = solution.with_touches(sol, (*flat[:5], flat[6]), sense=sense)
    found, other = sol.found, np.full(came.size, "", dtype="U96")
    phi_touch, theta_touch = np.where(came, found.load_end, np.nan), np.where(came, found.theta_end, np.nan)
    for i in np.flatnonzero(came | np.array([hit is not None for hit in touches], bool)):
        hit = touches[i]
        other[i] = solution.other_words(hit, int(sol.crossing[i]), mirrored=mirrored)
        if hit is not None:
            phi_touch[i], theta_touch[i] = hit.phi, hit.theta
    view = (found.load_e, found.theta_end, found.load_end, found.end, found.neighbour)
    return Ends(*(f.reshape(shape) for f in (*view, other, np.full(came.size, sense), phi_touch, theta_touch)))
