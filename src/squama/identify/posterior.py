"""Samples of the parameters from their posterior distribution, by the affine-invariant ensemble of emcee.

The prior is uniform within the bounds. Where the noise of a point is not known it has the prior 1/noise and is
integrated out, which leaves the likelihood S^(-n/2) of n points with the sum of squares S.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.identify.forward import Forward
from squama.model.solve import Array

if TYPE_CHECKING:
    from squama.identify.result import Fit

WALKERS = 32
BURN = 200
THIN = 15
_LEAST = 50


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


def sample(forward: Forward, fit: Fit, number: int, seed: int) -> Posterior:
    """Draw samples.

    Parameters
    ----------
    forward
        Points that are used.
    fit
        The fit, whose estimates and covariance the chains start from.
    number
        How many samples.
    seed
        The same seed gives the same samples.

    Raises
    ------
    InputError
        emcee is not installed.
    """
    emcee = needed()
    asked, torque = fit.asked, fit.record.torque[fit.used]
    low, high = asked.low, asked.high
    given = fit.noise if fit.given_noise else None
    size = float(np.abs(torque).max())

    def log_probability(p: Array) -> Array:
        inside: Any = np.all((p >= low) & (p <= high), axis=1)
        trial = np.where(inside[:, None], p, fit.estimates)
        r = (forward.torque(asked.physical(trial[:, None, :])) - torque) / size
        square = np.einsum("ij,ij->i", r, r)
        if given is None:
            value = -0.5 * torque.size * np.log(np.maximum(square, 1e-300))
        else:
            value = -0.5 * square * (size / given) ** 2
        return np.where(inside, value, -np.inf)

    random = np.random.RandomState(seed)
    p = len(asked.rows)
    walkers = max(WALKERS, 4 * p)
    start = random.multivariate_normal(np.zeros(p), fit.correlation, walkers) * np.sqrt(np.diag(fit.covariance))
    start = fit.estimates + start
    # walkers that start outside are put as far inside
    start = np.where(start < low, np.minimum(2 * low - start, 0.5 * (low + high)), start)
    start = np.where(start > high, np.maximum(2 * high - start, 0.5 * (low + high)), start)
    steps = THIN * math.ceil(number / walkers)
    sampler = emcee.EnsembleSampler(walkers, p, log_probability, vectorize=True)
    state = emcee.State(start, random_state=random.get_state())
    state = sampler.run_mcmc(state, BURN, skip_initial_state_check=True)
    sampler.reset()
    sampler.run_mcmc(state, steps, skip_initial_state_check=True)
    time = float(np.max(sampler.get_autocorr_time(tol=0))) if steps >= 100 else math.nan
    time = time if math.isfinite(time) else float(steps)
    chain = sampler.get_chain(thin=THIN, flat=True)[:number]
    return Posterior(np.asarray(chain), float(np.mean(sampler.acceptance_fraction)), steps, time)


def needed() -> Any:
    """Return emcee.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        import emcee
    except ImportError:
        message = "posterior samples need emcee, which is not installed; install it with: pip install 'squama[fit]'"
        raise InputError(message) from None
    return emcee
