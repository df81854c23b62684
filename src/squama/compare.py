"""How far two responses of a beam are apart along the twist."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.answer import Answer
from squama.model.solve import Array

SHARE = 0.05
"""Difference of the torque within which a model counts as holding."""


class Difference(NamedTuple):
    """A curve against a reference: it holds up to the twist ``within``; differences at ``last``, the last common twist.

    Twists in rad per pitch; ``torque`` is the torque over the reference's, less 1; ``theta`` the inclination less the
    reference's, rad; NaN where the curves have no twist in common.
    """

    mu: float
    within: float
    last: float
    torque: float
    theta: float


def differences(answer: Answer, reference: Answer, share: float = SHARE) -> list[Difference]:
    """Compare curves at the same twists, one result per coefficient of friction.

    Parameters
    ----------
    answer, reference : Answer
        Twisting responses with the same ``phi``.
    share : float
        Difference of the torque that is allowed.
    """
    found = []
    for i, mu in enumerate(np.atleast_1d(answer["mu"])):
        one, two = (a if a.family is None else a.pick(i) for a in (answer, reference))
        phi, T, T0 = two["phi"], one["T"], two["T"]
        common = np.flatnonzero(np.isfinite(T) & np.isfinite(T0) & (phi > 0))
        if common.size == 0:
            found.append(Difference(float(mu), np.nan, np.nan, np.nan, np.nan))
            continue
        off = T[common] / T0[common] - 1
        end = int(common[-1])
        theta = float(one["theta"][end] - two["theta"][end])
        found.append(Difference(float(mu), _within(phi[common], off, share), float(phi[end]), float(off[-1]), theta))
    return found


def _within(phi: Array, off: Array, share: float) -> float:
    """Twist at which the difference leaves the share for the first time; the last one if it does not."""
    beyond = np.flatnonzero(np.abs(off) > share)
    if beyond.size == 0:
        return float(phi[-1])
    i = int(beyond[0])
    if i == 0:
        return 0.0
    a, b = abs(float(off[i - 1])), abs(float(off[i]))
    return float(phi[i - 1] + (phi[i] - phi[i - 1]) * (share - a) / (b - a))
