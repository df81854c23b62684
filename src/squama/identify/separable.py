"""What the data tell apart, what they do not, and which further measurement would.

The linearised model at the estimates says it: the covariance of the parameters, and what it becomes with points
added that have not been measured.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama import histories
from squama.histories import Senses
from squama.identify.estimate import derivatives
from squama.identify.forward import Forward, build
from squama.identify.parameters import Asked, ask
from squama.model.outcome import End
from squama.model.paths import ARRAY
from squama.model.solve import Array

HARDLY = 0.95
"""Correlation from which two parameters are called hardly separable."""
UNSEEN = 0.5
"""Standard error over the estimate from which a parameter is called not determined."""
FEW = 0.2
"""Part of the points below which more of a kind are proposed."""
FAR = 0.5
"""How far towards the end of the path further points are proposed."""


class Remedy(NamedTuple):
    """A further measurement: what, and the standard errors expected with it, in the order of the parameters."""

    what: str
    errors: Array


def condition(jacobian: Array) -> float:
    """Condition number of the derivatives with columns of one length: 1 if no parameter resembles another."""
    s = np.linalg.svd(jacobian / np.linalg.norm(jacobian, axis=0), compute_uv=False)
    return float(s[0] / s[-1])


def correlations(covariance: Array) -> Array:
    """Correlation matrix of a covariance."""
    error = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(error, error))


def pairs(names: tuple[str, ...], correlation: Array) -> list[tuple[str, str, float]]:
    """Pairs of parameters that are hardly separable, with their correlations."""
    found = [(a, b, float(correlation[i, j])) for i, a in enumerate(names) for j, b in enumerate(names) if i < j]
    return [pair for pair in found if abs(pair[2]) > HARDLY]


def remedies(
    asked: Asked, values: Array, senses: Senses, forward: Forward, jacobian: Array, noise: float
) -> list[Remedy]:
    """Further measurements with as much noise, and the standard errors that they would bring.

    Parameters
    ----------
    senses
        Both senses at the estimates.
    forward, jacobian
        Points that are used, and the derivatives there.
    noise
        Standard deviation of a measured torque.
    """
    theta0 = asked.physical(values).theta0
    touching = forward.theta > theta0
    pitch = senses.case.pitch
    added: list[tuple[str, Forward]] = []
    loaded, back = touching & (forward.way > 0), touching & (forward.way < 0)
    for one, other, seen, missing in ((loaded, back, "loading", "unloading"), (back, loaded, "unloading", "loading")):
        if one.any() and np.count_nonzero(other) < FEW * np.count_nonzero(one):
            turned = forward.take(np.flatnonzero(one))
            added.append((f"{missing} measured too, at the twists of the {seen}", turned._replace(way=-turned.way)))
    n = max(int(np.count_nonzero(loaded)), 10)
    sign = "-" if touching.any() and np.all(forward.sign[touching] < 0) else "+"
    path, s = senses.paths[sign], -1.0 if sign == "-" else 1.0
    if np.isfinite(path.load_e) and np.count_nonzero(~touching) < FEW * forward.rate.size:
        load = s * np.linspace(0, path.load_e, n)
        added.append((f"{n} points before engagement", build(senses, load, np.ones(n))))
    far = float(np.abs(forward.rate).max()) * pitch
    end = max(far, path.load_e)
    end += FAR * (senses.most[sign] - end)
    if path.end is not End.NONE and np.isfinite(path.load_e) and end > 1.02 * far:
        load = s * np.linspace(max(far, path.load_e), end, n + 1)[1:]
        added.append((f"{n} points more of loading, up to {end:.3g} rad/pitch", build(senses, load, np.ones(n))))
    further = [(what, derivatives(more, asked, values)) for what, more in added]
    if asked.load == "twisting" and touching.any():
        further += _bending(asked, values, float(forward.theta.max()), forward, n)
    found = []
    with np.errstate(all="ignore"):
        for what, more in further:
            J = np.concatenate([jacobian, more])
            norm = np.linalg.norm(J, axis=0)
            half = np.linalg.pinv(J / norm)
            found.append(Remedy(what, noise * np.linalg.norm(half, axis=1) / norm))
    return found


def _bending(asked: Asked, values: Array, theta: float, forward: Forward, n: int) -> list[tuple[str, Array]]:
    """Return a bending test up to the largest inclination of these points, with as much noise for its largest moment.

    Friction, joint and inclination at rest are those of the twisting test; its own rigidity is known.
    """
    if asked.beam.eta < 1:
        return []
    at = asked.physical(values)
    bent = ask(asked.fitted(values), "bending", asked.names)
    senses = histories.senses(bent.beam, "bending", at.mu, "edge", 0.1)
    path = senses.paths["+"]
    if not path.engaged:
        return []
    last = min(float(path.row.point(np.array([theta]), path.law, ARRAY).load[0]), senses.most["+"])
    if last <= path.load_e:
        return []
    points = build(senses, np.linspace(path.load_e, last, n), np.ones(n))
    J = derivatives(points, bent, values)
    for name in ("C_f", "E_B", "zero"):
        i = asked.place(name)
        if i is not None:
            J[:, i] = 0.0
    largest = np.abs(forward.torque(at)).max() / np.abs(points.torque(bent.physical(values))).max()
    return [(f"a bending test too, {n} points of loading up to {last:.3g} rad/pitch", J * largest)]
