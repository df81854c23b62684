r"""The model's torque at measured twists as a function of what is to be found, with its derivatives.

The inclination at a given twist is geometry alone: neither friction, joint stiffness, rigidity nor the inclination at
rest enter the contact condition (paper Eq. 6). So each measured twist is put on the path of the contact once, and with
the rates and moments there (docs, theory: cycles) every trial is the closed form

.. math::
    T = R\,\Phi + T_0 + K_\theta\,\langle\theta-\theta_0\rangle
        \Bigl[\frac{\theta'}{\varphi'} + m\,\frac{r'}{\varphi'}\,\frac{1}{D(m)}\Bigr],
    \qquad D(m) = -(M_N + m M_f), \qquad m = \pm\mu ,

with m = mu while the scales are loaded, -mu while they are unloaded, and < > zero before engagement.

Towards a lock D vanishes and the torque grows without bound. So that a trial beyond a lock has a value and a slope too,
1/D is continued by its tangent where D is below a thousandth of what it is without friction: the torque of such a
trial is finite, a thousand times too large, and falls towards the lock.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from squama.curve import invert
from squama.histories import Senses
from squama.model.paths import ARRAY
from squama.model.solve import Array

FLOOR = 1e-3
"""Part of the D without friction below which 1/D is continued by its tangent."""


class Physical(NamedTuple):
    """What the torque depends on: friction, joint stiffness (N m), rigidity (N m2), theta0 (rad), zero (N m)."""

    mu: float
    stiffness: float
    rigidity: float
    theta0: float
    zero: float = 0.0


class Forward(NamedTuple):
    """Places of n points on the paths of their contacts; arrays of length n.

    ``rate`` twist rate or curvature (signed), ``sign`` of the sense, ``way`` +1 loading, -1 unloading; ``theta``
    inclination there (0 where there is no contact whatever theta0 is), ``lift_rate`` theta'/phi', ``slip_rate``
    r'/phi', moments ``M_N``, ``M_f``.
    """

    rate: Array
    sign: Array
    way: Array
    theta: Array
    lift_rate: Array
    slip_rate: Array
    M_N: Array
    M_f: Array

    def take(self, index: Array) -> Forward:
        """Return some of the points."""
        return Forward(*(column[index] for column in self))

    def inverse(self, mu: Array | float) -> tuple[Array, Array]:
        """Return 1/D, continued beyond a lock, and its derivative to D."""
        D = -(self.M_N + self.way * mu * self.M_f)
        least = FLOOR * -self.M_N
        safe = np.maximum(D, least)
        return (2 - D / safe) / safe, -1 / safe**2

    def torque(self, v: Physical) -> Array:
        """Torque or moment (N m); the entries of ``v`` may be columns of many trials, shape (..., 1)."""
        inverse = self.inverse(v.mu)[0]
        lift = np.maximum(self.theta - v.theta0, 0.0)
        scales = lift * (self.lift_rate + self.way * v.mu * self.slip_rate * inverse)
        return np.asarray(v.rigidity * self.rate + v.zero + v.stiffness * self.sign * scales)

    def jacobian(self, v: Physical) -> Array:
        """Return the derivatives of the torque, shape (n, 5), in the order of :class:`Physical`."""
        inverse, slope = self.inverse(v.mu)
        touching = self.theta > v.theta0
        lift = np.where(touching, self.theta - v.theta0, 0.0)
        share = self.lift_rate + self.way * v.mu * self.slip_rate * inverse
        to_mu = self.way * self.slip_rate * (inverse - self.way * v.mu * slope * self.M_f)
        return np.stack(
            [
                v.stiffness * self.sign * lift * to_mu,
                self.sign * lift * share,
                self.rate,
                -v.stiffness * self.sign * touching * share,
                np.ones(self.rate.size),
            ],
            axis=1,
        )

    def locks_at(self, theta0: float) -> float:
        """Smallest friction at which one of the points that are loaded is beyond a lock; inf if there is none."""
        seen = (self.theta > theta0) & (self.M_f > 0) & (self.way > 0)
        return float(np.min(-self.M_N[seen] / self.M_f[seen], initial=np.inf))


def build(senses: Senses, load: Array, way: Array) -> Forward:
    """Put points on the paths of their contacts.

    Parameters
    ----------
    senses
        Both senses of loading, solved for the smallest friction and inclination at rest of all trials.
    load
        Load angles per pitch, signed; none beyond what the senses allow.
    way
        +1 for points reached by growing magnitude of the load, -1 by falling.
    """
    sign = np.where(load < 0, -1.0, 1.0)
    zero = np.zeros(load.size)
    rate, apart = load / senses.case.pitch, [zero.copy(), zero.copy(), zero.copy(), zero - 1, zero.copy()]
    out = Forward(rate, sign, way.astype(float), *apart)
    for name, side in senses.sides.items():
        path, s = senses.paths[name], -1.0 if name == "-" else 1.0
        index = np.flatnonzero((sign == s) & (np.abs(load) > path.load_e))
        if not index.size:
            continue
        x = invert(path.row, np.abs(load[index]), path.x0, path.x_c, path.law)
        pt = side.row.point(x, side.law, ARRAY)
        columns = (pt.theta, pt.theta_rate / pt.load_rate, pt.slip_rate / pt.load_rate, pt.M_N, pt.M_f)
        for target, values in zip(out[3:], columns, strict=True):
            target[index] = values
    return out
