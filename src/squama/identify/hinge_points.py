r"""The torque of hinges at measured twists as a function of the parameters, with its derivatives.

The inclination at a given twist is geometry alone: neither friction, joint stiffness, rigidity nor the inclination at
rest enter the contact condition (paper Eq. 6). So each measured twist is located on the path of the contact once; with
the rates and moments there (docs, theory: cycles) the torque of every trial is the closed form

.. math::
    T = R\,\Phi + T_0 + K_\theta\,\langle\theta-\theta_0\rangle
        \Bigl[\frac{\theta'}{\varphi'} + m\,\frac{r'}{\varphi'}\,\frac{1}{D(m)}\Bigr],
    \qquad D(m) = -(M_N + m M_f), \qquad m = \pm\mu ,

with m = mu while the scales are loaded, -mu while they are unloaded, and < > zero before engagement.

Towards a lock D vanishes and the torque grows without bound. Where D is below a thousandth of its value without
friction, 1/D is continued by its tangent, so that a trial beyond a lock has a value and a derivative too: its torque is
finite, a thousand times too large, and falls towards the lock.
"""

from __future__ import annotations

import copy
from typing import NamedTuple

import numpy as np

from squama.curves.hinge import invert
from squama.curves.hinge_cycles import Senses
from squama.identify.readings import Readings
from squama.model.paths import ARRAY
from squama.model.sensitivity import STEP
from squama.types import Array

FLOOR = 1e-3
"""Share of D without friction below which 1/D is continued by its tangent."""
_STEP = 1e-5
"""Steps of differences by the twist, rad over the whole beam; for the compliance over the largest torque."""


class Physical(NamedTuple):
    """Physical quantities on which the torque depends, SI units; zero and backlash of the twist are of the whole beam.

    ``modulus`` of the bar over that of the given beam scales all other stiffnesses of a joint's matrix.
    """

    mu: float
    stiffness: float
    rigidity: float
    theta0: float
    torque_zero: float = 0.0
    twist_zero: float = 0.0
    backlash: float = 0.0
    drift: float = 0.0
    compliance: float = 0.0
    modulus: float = 1.0


class Forward(NamedTuple):
    """Points on the paths of their contacts; arrays of length n.

    ``rate``: signed twist rate or curvature (rad/m); ``sign`` of the sense; ``way``: +1 loading, -1 unloading;
    ``theta``: inclination (rad; 0 without contact for any theta0); theta'/phi' and r'/phi'; moments.
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
        """Return the points ``index``."""
        return Forward(*(column[index] for column in self))

    def torque(self, v: Physical) -> Array:
        """Return torque or moment (N m); the entries of ``v`` may be columns of many trials, shape (..., 1)."""
        D = -(self.M_N + self.way * v.mu * self.M_f)
        # beyond a lock 1/D continues along its tangent
        safe = np.maximum(D, FLOOR * -self.M_N)
        lift = np.maximum(self.theta - v.theta0, 0.0)
        scales = lift * (self.lift_rate + self.way * v.mu * self.slip_rate * (2 - D / safe) / safe)
        return np.asarray(v.rigidity * self.rate + v.stiffness * self.sign * scales)

    def jacobian(self, v: Physical) -> Array:
        """Return the derivatives of the torque by complex steps, shape (n, 4), in the order of :class:`Physical`."""
        moved = (v._replace(**{name: getattr(v, name) + 1j * STEP}) for name in Physical._fields[:4])
        return np.stack([self.torque(one).imag for one in moved], axis=1) / STEP

    def locks_at(self, theta0: float) -> float:
        """Return the smallest friction at which a loaded point lies beyond a lock; inf for none."""
        seen = (self.theta > theta0) & (self.M_f > 0) & (self.way > 0)
        return float(np.min(-self.M_N[seen] / self.M_f[seen], initial=np.inf))


def build(senses: Senses, load: Array, way: Array) -> Forward:
    """Locate points on their paths: signed ``load`` (rad per pitch) within the range of ``senses``, ``way`` +-1."""
    sign = np.where(load < 0, -1.0, 1.0)
    apart = np.zeros((5, load.size))
    apart[3] = -1
    out = Forward(load / senses.case.pitch, sign, way.astype(float), *apart)
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


class Hinged:
    """Points of a test of scales on hinges: the readings, and the contacts at the specimen's twists."""

    def __init__(self, senses: Senses, readings: Readings) -> None:
        self.senses, self.readings = senses, readings
        self.index = np.arange(readings.load.size)
        self._kept: tuple[tuple[float, ...], Forward] | None = None

    def take(self, index: Array) -> Hinged:
        """Return the points ``index`` of these."""
        other = copy.copy(self)
        other.index, other._kept = self.index[index], None
        return other

    def of(self, _: int | None) -> Hinged:
        """Return the points for a group, on hinges the same for all."""
        return self

    def at(self, v: Physical) -> Forward:
        """Return the points on their paths; twists beyond the range of the senses are clipped."""
        key = float(v.twist_zero), float(v.backlash), float(v.compliance)
        if self._kept is None or self._kept[0] != key:
            x, way = (column[self.index] for column in self.readings.placed(*key))
            most = self.senses.most
            self._kept = key, build(self.senses, np.clip(x, -most["-"], most["+"]), way)
        return self._kept[1]

    def touching(self, v: Physical) -> Array:
        """Return whether scales touch, (points,)."""
        return np.asarray(self.at(v).theta > v.theta0)

    def torque(self, v: Physical) -> Array:
        """Return the torque or moment that the load cell reads (N m)."""
        return np.asarray(self.at(v).torque(v) + v.torque_zero + v.drift * self.readings.order[self.index])

    def whole(self, v: Physical) -> Array:
        """Return the torque at all readings (N m), without zero and drift."""
        return self.at(v).torque(v)

    def jacobian(self, v: Physical, wanted: Array) -> Array:
        """Return the derivatives of the torque, shape (n, 10), in the order of :class:`Physical`, where ``wanted``."""
        out = np.zeros((self.index.size, len(Physical._fields)))
        out[:, :4] = self.at(v).jacobian(v)
        out[:, 4], out[:, 7] = 1.0, self.readings.order[self.index]
        for i in (5, 6, 8):
            if wanted[i]:
                out[:, i] = self._slope(v, Physical._fields[i])
        return out

    def _slope(self, v: Physical, name: str) -> Array:
        """Return a derivative of the torque by central differences; one-sided at zero backlash."""
        value = getattr(v, name)
        step = _STEP / (float(np.abs(self.readings.torque).max()) or 1.0) if name == "compliance" else _STEP
        low, high = max(value - step, 0.0) if name == "backlash" else value - step, value + step
        ends = [v._replace(**{name: at}) for at in (high, low)]
        up, down = (self.torque(end) for end in ends)
        first, last = (self.at(end).way * self.at(end).sign for end in ends)
        # where backlash is just taken up the branch changes: a jump, no derivative
        return np.asarray(np.where(first == last, up - down, 0.0) / (high - low))

    def locks_at(self, v: Physical) -> float:
        """Return the smallest friction at which a loaded point lies beyond a lock; inf for none."""
        return self.at(v).locks_at(v.theta0)

    def engaged(self) -> dict[str, float]:
        """Return the twist or bend per pitch (rad) at engagement, by sense."""
        return {sign: path.load_e for sign, path in self.senses.paths.items()}

    def drawn(self, points: int, *, once: bool) -> tuple[Hinged, Array]:
        """Return evenly spaced readings along each way for a drawing, and the number of their way."""
        readings, leg = self.readings.drawn(points, once=once)
        return Hinged(self.senses, readings).take(np.flatnonzero(leg)), leg[leg > 0]
