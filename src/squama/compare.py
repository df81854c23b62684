"""How far two responses of a beam are apart along the twist."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.answer import Answer
from squama.fe.compare import SHARE, holds

__all__ = ["SHARE", "Difference", "differences"]


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
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.where(phi > 0, T / T0 - 1, np.nan)
        within, end = holds(phi, off, share)
        if np.isnan(within):
            found.append(Difference(float(mu), np.nan, np.nan, np.nan, np.nan))
            continue
        theta = float(one["theta"][end] - two["theta"][end])
        found.append(Difference(float(mu), within, float(phi[end]), float(off[end]), theta))
    return found
