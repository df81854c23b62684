"""Samples of the parameters from their posterior distribution, by the affine-invariant ensemble of emcee.

The prior is uniform within the bounds. Where the noise of a point is not known it has the prior 1/noise and is
integrated out, which leaves the likelihood S^(-n/2) of n points with the sum of squares S.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama import progress
from squama.identify.prepare import Prepared
from squama.identify.selection import Found
from squama.interrupt import Interrupted, until_interrupted
from squama.needs import need
from squama.types import Array

WALKERS, BURN, THIN, _LEAST = 32, 200, 15, 50


class Posterior(NamedTuple):
    """Samples, shape (samples, parameters), and how independent they are.

    ``acceptance`` is the part of the proposals that was taken; ``steps`` steps of the chains; ``autocorrelation`` the
    largest of the integrated autocorrelation times, in steps.
    """

    samples: Array
    acceptance: float
    steps: int
    autocorrelation: float

    @property
    def effective(self) -> float:
        """Number of independent samples that those are worth."""
        return min(self.steps * WALKERS / max(self.autocorrelation, 1.0), float(len(self.samples)))

    def note(self) -> str | None:
        """Say that the chains are short, if they are."""
        if self.steps >= _LEAST * self.autocorrelation:
            return None
        return (
            f"the chains of the samples are short ({self.steps} steps, {self.steps / self.autocorrelation:.0f} times "
            f"their autocorrelation time; {_LEAST} are wanted): ask for more samples"
        )


def sample(made: Prepared, found: Found, number: int, seed: int) -> Posterior:
    """Draw samples by the points that a fit on hinges uses, from the estimates on; the same seed gives the same."""
    emcee, asked, estimates, noise = need("emcee"), found.asked, found.estimates, made.noise
    points, torque = made.points.take(np.flatnonzero(found.used)), made.record.torque[found.used]
    low, high, size = asked.low, asked.high, float(np.abs(torque).max())

    def log_probability(p: Array) -> Array:
        inside = np.asarray(np.all((p >= low) & (p <= high), axis=1))
        trial = np.where(inside[:, None], p, estimates)
        r = (points.torque(asked.physical(trial[:, None, :])) - torque) / size
        square = np.einsum("ij,ij->i", r, r)
        if noise is None:
            value = -0.5 * torque.size * np.log(np.maximum(square, 1e-300))
        else:
            value = -0.5 * square * (size / noise) ** 2
        return np.where(inside, value, -np.inf)

    random = np.random.RandomState(seed)
    p = len(asked.rows)
    walkers = max(WALKERS, 4 * p)
    start = estimates + random.multivariate_normal(np.zeros(p), found.correlation, walkers) * found.deviations
    # walkers that start outside are put as far inside
    start = np.where(start < low, np.minimum(2 * low - start, 0.5 * (low + high)), start)
    start = np.where(start > high, np.maximum(2 * high - start, 0.5 * (low + high)), start)
    steps = THIN * math.ceil(number / walkers)
    sampler = emcee.EnsembleSampler(walkers, p, log_probability, vectorize=True)
    state = emcee.State(start, random_state=random.get_state())
    # emcee prints what it was doing when it is interrupted inside a step
    with until_interrupted() as stopped:
        for length in (BURN, steps):
            sampler.reset()
            chain = sampler.sample(state, iterations=length, skip_initial_state_check=True)
            for step in progress.steps(chain, length, "steps of the chains"):
                state = step
                if stopped():
                    message = "interrupted while samples were drawn; nothing is written"
                    raise Interrupted(message)
    time = float(np.max(sampler.get_autocorr_time(tol=0))) if steps >= 100 else math.nan
    time = time if math.isfinite(time) else float(steps)
    chain = sampler.get_chain(thin=THIN, flat=True)[:number]
    return Posterior(np.asarray(chain), float(np.mean(sampler.acceptance_fraction)), steps, time)
