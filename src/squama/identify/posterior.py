"""Draws of the parameters: samples of their posterior distribution by emcee.

The prior is that of the tolerances, else uniform within the bounds. An unknown noise of a point has the prior 1/noise
and is integrated out, which leaves the likelihood S^(-n/2) of n points with the sum of squares S.

On compliant joints the ensemble draws from the posterior q with torques linearised about the estimates. Up to
:data:`WALKED` of its samples are then computed with the full model; each has the weight w = p/q of the model's
posterior p (importance sampling), and the samples are drawn anew by these weights. They are worth (sum w)^2/sum w^2
independent samples (Kish), a measure of how far the linear torques are from the model's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama import progress
from squama.identify import estimate, groups
from squama.identify.joint_points import Walked
from squama.identify.prepare import Prepared
from squama.identify.selection import Found
from squama.interrupt import Interrupted, until_interrupted
from squama.needs import need
from squama.types import Array

WALKERS, BURN, THIN, _LEAST = 32, 200, 15, 50
LINEAR, WALKED, _WORTH = 4000, 400, 0.25
"""Least number of samples with linear torques; largest number with the full model; worth of each that gets a note."""


class Posterior(NamedTuple):
    """Samples (samples, parameters) and their independence.

    ``steps`` of the chains; ``autocorrelation``: the longest of the integrated times, in steps; ``walked``: samples
    that are computed with the full model on compliant joints (0 on hinges), worth ``worth`` independent ones.
    """

    samples: Array
    acceptance: float
    steps: int
    autocorrelation: float
    walked: int = 0
    worth: float = math.inf

    @property
    def effective(self) -> float:
        """Number of independent samples with the same information."""
        return min(self.steps * WALKERS / max(self.autocorrelation, 1.0), float(len(self.samples)), self.worth)

    def note(self) -> str | None:
        """Return a note on chains that are too short or a model far from linear; None without."""
        if self.worth < _WORTH * self.walked:
            worth = f"{self.walked} samples of linear torques are worth {self.worth:.0f} of the model's own posterior"
            remedy = "narrow the bounds, or measure what tells the parameters apart"
            return f"{worth}, which is far from theirs: {remedy}"
        if self.steps >= _LEAST * self.autocorrelation:
            return None
        times = f"{self.steps / self.autocorrelation:.0f} times their autocorrelation time; {_LEAST} are wanted"
        return f"the chains of the samples are short ({self.steps} steps, {times}): ask for more samples"


def sample(made: Prepared, found: Found, number: int, seed: int) -> Posterior:
    """Draw samples from the posterior of a fit's used points; equal seeds give equal samples."""
    emcee, asked, estimates, noise = need("emcee"), found.asked, found.estimates, made.noise
    used, torque = np.flatnonzero(found.used), made.record.torque[found.used]
    low, high, size = asked.low, asked.high, float(np.abs(torque).max())
    points, (mean, spread) = groups.about(made.points, asked, estimates).take(used), asked.known
    shifts = estimate.shifts(points, asked)

    def weighed(modelled: Array, p: Array) -> Array:
        r = modelled + sum(shift * (p[:, i, None] - value) for i, (value, shift) in shifts.items()) - torque
        square = np.einsum("ij,ij->i", r / size, r / size)
        known = -0.5 * np.sum(((p - mean) / spread) ** 2, axis=1)
        if noise is None:
            return np.asarray(known - 0.5 * torque.size * np.log(np.maximum(square, 1e-300)))
        return np.asarray(known - 0.5 * square * (size / noise) ** 2)

    def log_probability(p: Array) -> Array:
        inside = np.asarray(np.all((p >= low) & (p <= high), axis=1))
        trial = np.where(inside[:, None], p, estimates)
        return np.where(inside, weighed(points.torque(asked.physical(trial[:, None, :])), trial), -np.inf)

    random = np.random.RandomState(seed)
    p = len(asked.rows)
    walkers = max(WALKERS, 4 * p)
    start = estimates + random.multivariate_normal(np.zeros(p), found.correlation, walkers) * found.deviations
    # walkers that start outside are reflected at the bound
    start = np.where(start < low, np.minimum(2 * low - start, 0.5 * (low + high)), start)
    start = np.where(start > high, np.maximum(2 * high - start, 0.5 * (low + high)), start)
    walked = isinstance(made.points, Walked)
    steps = THIN * math.ceil(max(number, LINEAR * walked) / walkers)
    sampler = emcee.EnsembleSampler(walkers, p, log_probability, vectorize=True)
    state = emcee.State(start, random_state=random.get_state())
    # emcee prints its state when it is interrupted inside a step
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
    chain = np.asarray(sampler.get_chain(thin=THIN, flat=True))
    drawn_from = Posterior(chain[:number], float(np.mean(sampler.acceptance_fraction)), steps, time)
    if not walked:
        return drawn_from
    some, own = chain[random.permutation(len(chain))[: min(number, WALKED)]], made.points.take(used)
    walks = [own.torque(asked.physical(one)) for one in progress.steps(list(some), len(some), "samples walked")]
    ratio = weighed(np.array(walks), some) - log_probability(some)
    weights = np.exp(ratio - ratio.max())
    weights /= weights.sum()
    # evenly spaced over the sum of the weights, from a random offset
    drawn = np.searchsorted(np.cumsum(weights), (np.arange(number) + random.uniform()) / number)
    worth = float(1 / np.sum(weights**2))
    return drawn_from._replace(samples=some[np.minimum(drawn, len(some) - 1)], walked=len(some), worth=worth)


def draws(fit: Found, posterior: Posterior | None, number: int, seed: int) -> Array:
    """Return draws (number, parameters): of the posterior samples, else of estimates and covariance within bounds."""
    r = np.random.default_rng(seed)
    if posterior is not None:
        return np.asarray(posterior.samples[r.integers(0, len(posterior.samples), number)])
    drawn = r.multivariate_normal(np.zeros(len(fit.rows)), fit.correlation, number) * fit.deviations
    return np.clip(fit.estimates + drawn, fit.asked.low, fit.asked.high)
