r"""Fit of a decay: friction, joint and material damping of a beam from a record of twist against time.

Every point of the record is compared with the motion of a trial beam (:mod:`squama.dynamics.motion`),

.. math::
    y(t) = y_0 + Y\bigl(2\pi f_0 (t - t_0)\bigr), \qquad
    \ddot Y + 2\zeta\dot Y + Y + q(Y, \mathrm{sign}\,\dot Y) = 0, \quad Y(0) = A, \quad \dot Y(0) = 0

with the branches q of the beam. f_0 of the bar without contact, the first turning point A, its time t_0 and the zero
y_0 of the reading are found, too. The search starts on the first swings: a small error of f_0 shifts later ones.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import arguments
from squama._version import __version__
from squama.beam.design import Beam
from squama.curves.chosen import idealisation
from squama.dynamics import doors, motion, systems
from squama.dynamics.motion import Drive, Part, State
from squama.dynamics.systems import Model
from squama.errors import InputError, refuse
from squama.identify import estimate, noise, records
from squama.identify.estimated import Estimated, of
from squama.identify.records import Swings
from squama.identify.unknowns import PARAMETERS, Parameter, ask, named
from squama.io.columns import TIME
from squama.loads import ENDLESS, MODES, EndsName, JointName, LawName, LoadName, ModeName
from squama.people import per_pitch
from squama.types import Array
from squama.units import Dimension

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

DEFAULT = ("mu", "K_theta", "damping")
"""Parameters that are found by default."""
CONTACT = ("mu", "K_theta", "C_f", "E_B", "theta0")
"""Parameters that show only in a record with contact between scales."""
OWN = {
    row.name: row
    for row in (
        Parameter("damping", Dimension.RATIO, "damping ratio of the bar's material", doors.DAMPING[:2], ""),
        Parameter("f_0", Dimension.FREQUENCY, "frequency without contact", (1e-6, 1e9), ""),
        Parameter("release", Dimension.ANGLE, "first turning point, per pitch", (-math.pi, math.pi), ""),
        Parameter("start", Dimension.TIME, "time of the first turning point", (-math.inf, math.inf), ""),
        PARAMETERS["twist_zero"],
    )
}
_READ = ("f_0", "start", "twist_zero")
"""Parameters that change the reading of a motion, not the motion."""
_TURNS = (4, 16)
"""Numbers of turning points up to which the search goes first."""
_STEP = {"hinge": 1e-5, "compliant": 3e-3}
"""Steps of the differences over the sizes of the parameters: motions of thick scales are known to some 1e-6."""
_STILL, _BEGIN = {"hinge": 1e-8, "compliant": 1e-6}, 1e-3
"""Relative change of the sum of squares, and of the parameters, below which the search ends, and its first parts."""
_STARTS = (0.4, 2.5)
"""Friction of further starts, over that of the beam."""
_AGAIN, _MISSES = 1.15, 1.5
"""Residual over the noise of a point above which other starts are tried, and above which a note reports misfit."""
_ROUNDING = {True: 1e-6, False: 1e-4}
"""Residuals over the first turning point that count as rounding: of endless beams, of interpolated unloading."""
_FARTHER = 1.1  # ratio of the angles to one of which branches are followed, whatever the release
_sides = functools.lru_cache(maxsize=16)(systems.sides)


class Trials(NamedTuple):
    """Trial beams, and the names of the parameters in the order of their values."""

    beam: Beam
    model: Model
    mode: str
    names: tuple[str, ...]

    def fitted(self, p: Array) -> Beam:
        """Return the beam with the parameters set to values ``p``, SI."""
        values = zip(self.names, p.tolist(), strict=True)
        return self.beam._with({PARAMETERS[n].place: v for n, v in values if n in CONTACT})

    def parts(self, p: Array, until: float) -> tuple[State, list[Part]]:
        """Return the first state of a motion and its parts up to the time ``until``, 1/omega0."""
        v = dict(zip(self.names, p.tolist(), strict=True))
        model, sign = self.model._replace(mu=v.get("mu", self.model.mu)), -1 if v["release"] < 0 else 1
        far = _FARTHER ** math.ceil(math.log(max(abs(v["release"]), _STILL["hinge"]), _FARTHER))
        sides = _sides(self.fitted(p), model, self.mode, sign, far)
        # a trial beam that locks before the release angle is released at its lock
        first = State(0.0, sign * min(abs(v["release"]), sides.of(sign).last), 0.0)
        drive = Drive(v.get("damping", 0.0), tolerance=systems.tolerance(model))
        return first, list(motion.follow(sides, drive, first, until, dense=motion.DENSE))

    def reading(self, p: Array, t: Array) -> tuple[Array, Array]:
        """Return readings at times t (s), rad per pitch, and their derivatives (n, 3) by f_0, start and twist_zero."""
        from scipy.interpolate import CubicHermiteSpline

        f, start, zero = (p[self.names.index(name)] for name in _READ)
        tau = 2 * math.pi * f * (t - start)
        first, parts = self.parts(p, max(float(tau[-1]), 1e-3))
        x, y, v = motion.joined(first, parts)
        new = np.diff(x, prepend=-1.0) > 0
        way = CubicHermiteSpline(x[new], y[new], v[new])
        # at rest before the release; after a trial that stops or leaves the model, at its end
        at = np.clip(tau, 0.0, x[-1])
        speed = np.where(at == tau, way(at, 1), 0.0)
        zeros = np.full(t.size, 1 / self.beam.pitches)
        return way(at) + zero / self.beam.pitches, np.array([speed * tau / f, -2 * math.pi * f * speed, zeros]).T

    def derivatives(self, p: Array, t: Array, sizes: Array, limits: tuple[Array, Array], *, central: bool) -> Array:
        """Return the derivatives (n, parameters) of the readings by the parameters over ``sizes``, inside limits."""
        low, high = limits
        here, of_reading = self.reading(p, t)
        columns = dict(zip(_READ, of_reading.T, strict=True))
        for i, name in enumerate(self.names):
            if name not in columns:
                step, ends = _STEP[self.model.joint] * sizes[i], []
                for way in (1, -1) if central else (1 if p[i] + step <= high[i] else -1,):
                    q = p.copy()
                    q[i] = min(max(p[i] + way * step, low[i]), high[i])
                    ends.append((q[i], self.reading(q, t)[0] if q[i] != p[i] else here))
                (first, up), (last, down) = ends[0], ends[1] if central else (p[i], here)
                columns[name] = (up - down) / (first - last)
        return np.array([columns[name] for name in self.names]).T * sizes


@dataclass(frozen=True, repr=False, eq=False)
class DecayFit(Estimated):
    """Parameters of a beam found from the record of a decay.

    ``beam`` has the estimates, with the rotor (in a mode the density) that gives the fitted frequency. ``parameters``
    are the names of the estimates: the given ones, then ``f_0`` (Hz), ``release`` (first turning point, rad per pitch),
    ``start`` (its time, s) and ``twist_zero`` (reading at rest, rad over the whole beam). In this order ``estimates``,
    ``covariance`` and ``correlation``, by name ``values`` and standard ``errors``, SI units. Arrays of one length, the
    points: ``t`` (s), measured ``angle`` and ``fitted`` angle (rad per pitch). ``noise`` of a point from its
    neighbours, ``rms`` of the residuals (rad per pitch); ``at_bound`` by parameter; ``notes`` on the fit.
    """

    beam: Beam
    initial: Beam
    model: Model
    mode: str
    found: tuple[Parameter, ...]
    estimates: Array
    covariance: Array
    t: Array
    angle: Array
    fitted: Array
    noise: float
    at_bound: NDArray[np.bool_]
    notes: tuple[str, ...]

    @property
    def rows(self) -> tuple[Parameter, ...]:
        """The parameters that were found."""
        return self.found

    @property
    def rms(self) -> float:
        """Root mean square of the residuals, rad per pitch."""
        return math.sqrt(float(np.mean((self.angle - self.fitted) ** 2)))

    @property
    def attrs(self) -> dict[str, str]:
        """Settings of the fit in words: load, law, joint, scales, mode."""
        model = self.model
        return {
            "load": model.load.name,
            "law": model.law,
            "joint": model.joint,
            "scales": idealisation(self.beam, model.joint, ideal=model.ideal),
            "mode": self.mode,
            "ends": model.held_in(self.mode),
            **({"faces": self.beam.faces} if self.beam.other else {}),
        }

    def report(self) -> dict[str, object]:
        """Return the whole result as plain data, for JSON."""
        angle = self.model.load.angle
        return {
            **self.attrs,
            "parameters": self._parameters(at_bound=self.at_bound),
            **of(self, "correlation", "noise", "rms"),
            "points": {"t": self.t, angle: self.angle, f"{angle}_fit": self.fitted},
            "notes": list(self.notes),
            "beam": self.beam.model_dump(),
            "squama_version": __version__,
        }

    def __repr__(self) -> str:
        return f"DecayFit({', '.join(self.lines)}; {self.t.size} points, rms {per_pitch(self.rms)})"

    @property
    def sizes(self) -> list[tuple[str, str]]:
        """Residuals and number of points as text, each with its name."""
        rms, noise = (per_pitch(v) for v in (self.rms, self.noise))
        return [("residual", f"rms {rms}; noise of a point {noise}"), ("points", f"{self.t.size}")]

    def dataset(self) -> xr.Dataset:
        """Return all results as an ``xarray.Dataset``: dimensions ``point`` and ``parameter``."""
        load = self.model.load
        return self._labelled(
            f"decay in {load.name}",
            {
                "t": ("point", self.t, "time", "s"),
                load.angle: ("point", self.angle, load.angle_words, "rad"),
                f"{load.angle}_fit": ("point", self.fitted, f"fitted {load.angle}", "rad"),
                "noise": ("", self.noise, "noise of a point", "rad"),
            },
            {**self.attrs, "notes": "\n".join(self.notes)},
        )

    def plot(self) -> Figure:
        """Draw the record, the fitted motion and the residuals, see :func:`squama.plot.decay_figure`."""
        from squama.plot import decay_figure

        drawn: Figure = decay_figure(self.dataset())
        return drawn


def fit_decay(
    data: object,
    beam: Beam,
    parameters: Sequence[str] | str = DEFAULT,
    *,
    load: LoadName = "twisting",
    law: LawName = "edge",
    mode: ModeName = "uniform",
    joint: JointName | None = None,
    ideal: bool | None = None,
    ends: EndsName | None = None,
) -> DecayFit:
    """Find friction, joint stiffness and material damping of a beam from the record of a free vibration.

    A beam with a number of scales is modelled with all of them, as by :func:`squama.vibrate`.

    Parameters
    ----------
    data
        A CSV file with units in its header, "t (s), phi (deg/pitch)", twists named as for :func:`squama.fit`; a dataset
        of :func:`squama.vibrate`, or another mapping with ``t`` (s) and ``Phi`` (rad/m), ``phi`` (rad) or ``total``.
        The record begins while the beam is held, at the release, or before a first turning point.
    beam, parameters
        The beam, and the parameters to find: ``mu``, ``K_theta``, ``damping`` (ratio of the bar's material; 0 if not
        found) and, as for :func:`squama.fit`, ``C_f``, ``E_B`` and, on hinges, ``theta0``. The frequency without
        contact, the first turning point, its time and the zero of the reading are found in any case.
    load, law, mode, joint, ideal, ends
        As for :func:`squama.vibrate`.

    Returns
    -------
    DecayFit

    Raises
    ------
    InputError
        An argument is out of range, the record cannot be used, or it does not show the parameters: a record without
        contact shows neither friction nor joint.

    Examples
    --------
    >>> import squama
    >>> beam, how = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3), {"joint": "hinge", "ideal": True}
    >>> v = squama.vibrate(beam, release="0.15 rad/pitch", rotor="0.01 kg m2", damping=0.01, swings=3, **how)
    >>> f = squama.fit_decay(v, beam.replace(friction={"mu": 0.1}), "mu, damping", **how)
    >>> print(f"mu = {f.values['mu']:.4f}, damping = {f.values['damping']:.4f}, rotor {f.beam.rotor:.4f} kg m2")
    mu = 0.3000, damping = 0.0100, rotor 0.0100 kg m2
    """
    arguments.beam(beam)
    names = named(parameters, (*CONTACT, "damping"))
    mu = 0.25 if "mu" in names and beam.friction.mu is None else None
    arguments.one_of("mode", mode, MODES)
    model, _ = doors.model_of(beam, mu, law, load, joint, ideal, doors.ends_in(mode, ends))
    systems.bar(beam, model, mode, 1.0, 1.0)
    if model.joint == "compliant" and "theta0" in names:
        refuse("parameters", "", "theta0 is not found on the compliant joint", 'leave it out, or give joint="hinge"')
    contact = [n for n in names if n in CONTACT]
    asked = ask(beam, load, contact, joint=model.joint) if contact else None
    record = records.swings(records.read(data, beam, load, TIME), beam.pitch)
    own = {"damping": 0.01} if "damping" in names else {}
    own |= {"f_0": 1.0, "release": record.release, "start": record.start, "twist_zero": 0.0}
    columns = list(zip(asked.start, asked.low, asked.high, strict=True)) if asked else []
    p, low, high = np.array([*columns, *((value, *OWN[name].limits) for name, value in own.items())]).T
    rows = (*(asked.rows if asked else ()), *(OWN[name] for name in own))
    trials = Trials(beam, model, mode, tuple(row.name for row in rows))
    p = _started(trials, p, record)
    _check_engagement(trials, p, record, contact)
    return _found(trials, rows, p, (low, high), record)


def _started(trials: Trials, p: Array, record: Swings) -> Array:
    """Return a start at which the trial beam swings, with f_0 from the first two swings of the record."""
    p, mu = p.copy(), trials.names.index("mu") if "mu" in trials.names else None
    while True:
        turned = [part.last.t for part in trials.parts(p, 4 * math.pi)[1] if part.why == motion.TURNED]
        if len(turned) > 1:
            p[trials.names.index("f_0")] = turned[1] / (record.t[record.turns[1]] - record.start) / (2 * math.pi)
            return p
        if mu is None or p[mu] < 1e-3:
            reason = f"the beam as given stays at {per_pitch(record.release, 4)}, where the record begins"
            refuse("data", "", reason, "check the beam and the unit of the twist")
        p[mu] /= 2


def _check_engagement(trials: Trials, p: Array, record: Swings, contact: list[str]) -> None:
    """Refuse parameters of the contact for a record without contact."""
    peaks = np.array([record.release, *record.y[record.turns]])
    sides = _sides(trials.fitted(p), trials.model, trials.mode, 1, float(np.abs(peaks).max()))
    if contact and peaks.max() < sides.plus.y_e and -peaks.min() < sides.minus.y_e:
        what = f"{' and '.join(contact)} {'are' if len(contact) > 1 else 'is'} not to be found"
        far, engaged = (per_pitch(x, 4) for x in (np.abs(peaks).max(), sides.plus.y_e))
        reason = f"{what}: the record never engages; it goes to {far}, and scales engage at {engaged}"
        refuse("parameters", "", reason, 'let the beam go from farther, or find "damping" only')


class _Try(NamedTuple):
    """End of a search: parameters, derivatives over their sizes, sum of squares, whether the search converged."""

    p: Array
    jacobian: Array
    square: float
    ended: bool


class _Search(NamedTuple):
    """A search: trial beams, sizes and limits of the parameters, the record, residuals that count as rounding."""

    trials: Trials
    sizes: Array
    limits: tuple[Array, Array]
    record: Swings
    rounding: float

    def descend(self, p: Array, n: int) -> _Try:
        """Return the least squares over the first n points, from the start ``p``."""
        from scipy.optimize import least_squares

        t, y, sizes, limits = self.record.t[:n], self.record.y[:n], self.sizes, self.limits
        unit, joint, last = abs(self.record.release), self.trials.model.joint, n == self.record.t.size
        still, most = (_STILL[joint], 40) if last else (_BEGIN, 12)

        def residuals(u: Array) -> Array:
            return (self.trials.reading(u * sizes, t)[0] - y) / unit

        def slope(u: Array) -> Array:
            # one-sided derivatives suffice to begin with, but not for parameters that resemble each other
            return self.trials.derivatives(u * sizes, t, sizes, limits, central=last and joint == "compliant") / unit

        low, high = (limit / sizes for limit in limits)
        start = np.clip(p / sizes, low + 1e-9, high - 1e-9)
        fit = least_squares(residuals, start, slope, bounds=(low, high), max_nfev=most, ftol=still, xtol=still)
        return _Try(fit.x * sizes, np.asarray(fit.jac) * unit, 2 * float(fit.cost) * unit**2, bool(fit.success))

    def quiet(self, tried: _Try, n: int) -> bool:
        """Return whether a search over the first n points left residuals like noise and, over all points, ended."""
        residual = self.record.y[:n] - self.trials.reading(tried.p, self.record.t[:n])[0]
        least, rms = noise.scatter(residual, np.zeros(n)), math.sqrt(float(residual @ residual) / n)
        return (tried.ended or n < self.record.t.size) and rms < max(_AGAIN * least, self.rounding)

    def best(self, p: Array) -> _Try:
        """Return the best search of several starts; the others are tried only where residuals exceed the noise."""
        turns, every = self.record.turns, self.record.t.size
        few, *more = [*(turns[n - 1] for n in _TURNS if n < len(turns)), every]
        found: _Try | None = None
        for first in self.first(p, few):
            # from search to search over more points
            tried = functools.reduce(lambda last, n: self.descend(last.p, n), more, first)
            found = tried if found is None or tried.square < found.square else found
            if self.quiet(found, every):
                break
        assert found is not None
        return found

    def first(self, p: Array, n: int) -> Iterator[_Try]:
        """Yield searches over the first n points from p, then from other starts; best first where p leaves more."""
        one = self.descend(p, n)
        others = (self.descend(q, n) for q in self.starts(p))
        if self.quiet(one, n):
            yield one
            yield from others
        else:
            yield from sorted([one, *others], key=lambda tried: tried.square)

    def starts(self, p: Array) -> list[Array]:
        """Return further starts with other frictions; none where friction is not to be found."""
        if "mu" not in self.trials.names:
            return []
        found, i = list[Array](), self.trials.names.index("mu")
        for factor in _STARTS:
            q = p.copy()
            q[i] = min(max(factor * p[i], self.limits[0][i]), self.limits[1][i])
            try:
                found.append(_started(self.trials, q, self.record))
            except InputError:
                continue
        return found


def _found(
    trials: Trials, rows: tuple[Parameter, ...], p: Array, limits: tuple[Array, Array], record: Swings
) -> DecayFit:
    t, y, (low, high) = record.t, record.y, limits
    own = {"mu": 0.1, "damping": 0.01, "theta0": 0.1, "release": abs(record.release)}
    own |= {"twist_zero": own["release"] * trials.beam.pitches, "start": (t[record.turns[0]] - record.start) / math.pi}
    sizes = np.array([own.get(row.name, value) for row, value in zip(rows, p, strict=True)])
    rounding = _ROUNDING[trials.model.ends == ENDLESS] * abs(record.release)
    tried = _Search(trials, sizes, limits, record, rounding).best(p)
    p, fitted = tried.p, trials.reading(tried.p, t)[0]
    residual = y - fitted
    sigma, least = math.sqrt(float(residual @ residual) / (t.size - p.size)), noise.scatter(residual, np.zeros(t.size))
    names, tau = tuple(row.name for row in rows), noise.dependence(residual, np.zeros(t.size))
    # with slow noise each parameter absorbs as much as tau points, at most half of the noise in all
    alone = (t.size - p.size) / max(t.size - tau * p.size, t.size / 2)
    covariance = estimate.covariance(tried.jacobian / sizes, sigma, names) * tau * max(alone, 1.0)
    at_bound = np.minimum(p - low, high - p) < 1e-6 * sizes
    beam = _swinging(trials, p)
    notes = [f"{names[i]} is at its bound: errors are as without bounds" for i in np.flatnonzero(at_bound)]
    if not tried.ended:
        notes.append("the search did not come to an end: take the estimates as a start")
    elif sigma > max(_MISSES * least, rounding):
        more = f"residuals are {sigma / least:.1f} times the noise of a point"
        notes.append(f"{more}: the noise is slow, or the model misses something")
    hard = [pair for pair in estimate.hardly_separable(names, covariance) if {*pair[:2]} <= {*CONTACT}]
    notes += [f"{a} and {b} are hardly separable by this record (correlation {c:+.3f})" for a, b, c in hard]
    notes += systems.notes(beam, trials.model, None, float(y.min()), float(y.max()))
    estimated = (rows, p, covariance, t, y, fitted, least, at_bound, tuple(notes))
    return DecayFit(beam, trials.beam, trials.model, trials.mode, *estimated)


def _swinging(trials: Trials, p: Array) -> Beam:
    """Return the fitted beam with the rotor, or in a mode the density, that gives the fitted frequency."""
    beam, omega = trials.fitted(p), 2 * math.pi * float(p[trials.names.index("f_0")])
    uniform = trials.mode == "uniform"
    densities = (beam.density, beam.density) if uniform else (1.0, 2.0)
    unit, twice = (systems.bar(beam, trials.model, trials.mode, 1.0, density) for density in densities)
    found = unit.inertia * (unit.omega / omega) ** 2
    if uniform:
        return beam.replace(rotor=found - unit.inertia + 1.0)
    # the mass per length is linear in the density of the bar
    return beam.replace(density=1.0 + (found - unit.inertia) / (twice.inertia - unit.inertia))
