"""States of beams that are bent and twisted at once, for arrays: thin, rigid scales on hinges."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.errors import refuse
from squama.model import screw
from squama.types import Array

PART = 8192
"""Number of states computed at a time, so that intermediate arrays fit a processor's cache."""


class Combined(NamedTuple):
    """States of bent and twisted beams; arrays of one shape, lengths in pitches, moments in K_theta.

    ``theta`` inclination, rad; ``contact``: the pair in contact (``squama.model.screw.CONTACTS``), "" for none,
    "locked" where no inclination is compatible with this bend and twist; ``normal`` force N d/K_theta;
    ``bending_moment`` and ``torque``, the scales' parts; ``mu_lock`` coefficient of friction at which the contact locks
    in this direction (never if negative). NaN where a contact is locked. ``closing`` and ``rolling``: rotation per
    pitch about the scale's width and about its length, rad.
    """

    theta: Array
    contact: Array
    normal: Array
    bending_moment: Array
    torque: Array
    mu_lock: Array
    closing: Array
    rolling: Array


class Held(NamedTuple):
    """Range of moments that friction holds in states at rest; moments in K_theta.

    ``bending_moment`` and ``torque`` (..., n): points of the closed curve, in the scales' parts, inside which nothing
    moves; NaN where friction alone holds moments of any size. ``cone`` (..., 2, 2): the two unit directions (dpsi,
    dphi) between which every motion is locked; NaN where no motion is.
    """

    bending_moment: Array
    torque: Array
    cone: Array


def combined(
    psi: ArrayLike,
    phi: ArrayLike,
    *,
    eta: ArrayLike,
    beta: ArrayLike,
    lam: ArrayLike,
    alpha: ArrayLike,
    theta0: ArrayLike,
    mu: ArrayLike,
    toward: tuple[ArrayLike, ArrayLike],
    neutral_height: ArrayLike = 0.0,
) -> Combined:
    """Return states of beams that are bent and twisted at once (docs, theory: bending and twisting).

    Thin, rigid scales on hinges; only the neighbour k = 1. Inclination and contact depend on bend and twist; the forces
    also depend on the last direction of motion.

    Parameters
    ----------
    psi, phi
        Bend per pitch towards the scaled face, twist per pitch, rad, of any sign; these and all below broadcast.
    eta, beta, lam
        Exposed length, half width and half thickness of the substrate over the pitch.
    alpha, theta0
        Angles, rad; ``alpha`` may be 0.
    mu
        Coefficient of friction.
    toward
        Direction (dpsi, dphi) of the last motion.
    neutral_height
        Height y_n over the bar's middle, in pitches, of the line that keeps its length: 0 for a bar without axial
        force, ``lam`` for the scaled face.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import numpy as np, squama
    >>> s = squama.combined(0.08, [0.05, 0.15], eta=3, beta=1.25, lam=0.45, alpha=np.radians(45),
    ...     theta0=np.radians(10), mu=0.3, toward=(0, 1))
    >>> print(s.contact, s.torque.round(3), s.bending_moment.round(3))
    ['BF' 'TS'] [0.751 6.755] [1.021 3.908]
    """
    if not isinstance(toward, tuple | list) or len(toward) != 2:
        refuse("toward", "", "must be two numbers, (dpsi, dphi)", "write e.g. toward=(0, 1) for twisting last")
    way = {"psi": psi, "phi": phi, "dpsi": toward[0], "dphi": toward[1], "neutral_height": neutral_height}
    columns, shape = arguments.designs(**way, eta=eta, beta=beta, lam=lam, alpha=alpha, theta0=theta0, mu=mu)

    def states(part: list[Array]) -> Combined:
        psi, phi, dpsi, dphi, y_n, *_, mu = part
        posed = screw.Posed.of(psi, phi, y_n, part[5:-1])
        return Combined(*screw.state(posed, mu, (dpsi, dphi), y_n), posed.closing, posed.rolling)

    return Combined._make(np.concatenate(v).reshape(shape) for v in _by_parts(states, columns))


def held(
    psi: ArrayLike,
    phi: ArrayLike,
    *,
    eta: ArrayLike,
    beta: ArrayLike,
    lam: ArrayLike,
    alpha: ArrayLike,
    theta0: ArrayLike,
    mu: ArrayLike,
    neutral_height: ArrayLike = 0.0,
    points: int = 64,
) -> Held:
    """Return the moments under which bent and twisted beams stay at rest, and the locked directions of motion.

    The contact force is N (n + m) with m in the tangent plane, at most mu: the moments M, T of all m fill a region
    within which nothing moves; on its border the contact slides (docs, theory: bending and twisting).

    Parameters
    ----------
    psi, phi, eta, beta, lam, alpha, theta0, mu, neutral_height
        As in :func:`squama.combined`.
    points
        Number of points on the border.

    Returns
    -------
    Held
        NaN where nothing touches or the plates are locked.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import numpy as np, squama
    >>> h = squama.held(0.08, 0.15, eta=3, beta=1.25, lam=0.45, alpha=np.radians(45), theta0=np.radians(10), mu=0.9)
    >>> print(np.degrees(np.arctan2(h.cone[:, 1], h.cone[:, 0])).round(1))
    [77.2 14.5]
    """
    n = arguments.whole("points", points, 3, 1e5)
    columns, shape = arguments.designs(
        psi=psi, phi=phi, neutral_height=neutral_height, eta=eta, beta=beta, lam=lam, alpha=alpha, theta0=theta0, mu=mu
    )
    angles = np.linspace(0.0, 2 * np.pi, n, endpoint=False)

    def border(part: list[Array]) -> Iterable[Array]:
        psi, phi, y_n, *_, theta0, mu = part
        posed = screw.Posed.of(psi, phi, y_n, part[3:-1])
        here = screw.touching(*posed[1:])
        found = screw.Velocities.of(posed.g, y_n, here).held(here.theta - theta0, mu, angles)
        return [np.where(here.contact == screw.NONE, np.nan, v) for v in found]

    with np.errstate(all="ignore"):
        M, T, cone = (np.concatenate(v, axis=-1) for v in _by_parts(border, columns))
    last = np.moveaxis(cone, -1, 0).reshape(*shape, 2, 2)
    return Held(M.T.reshape(*shape, n), T.T.reshape(*shape, n), last)


def _by_parts(f: Callable[[list[Array]], Iterable[Array]], columns: Sequence[Array]) -> Iterator[tuple[Array, ...]]:
    """Yield each field of the results of a function of columns (n,), as a tuple of parts of :data:`PART` rows."""
    parts = (f([v[i : i + PART] for v in columns]) for i in range(0, max(1, columns[0].size), PART))
    return zip(*parts, strict=True)
