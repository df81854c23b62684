r"""Planning of a test: expected errors of a beam's parameters for several loops, before any is measured.

At the beam's own values the derivatives J of the torques of a loop are those of the fit
(:func:`squama.identify.estimate.derivatives`). With noise s of the torque and t of the twist (over the whole beam) the
variance of a reading is :math:`s^2 + (T' t)^2`, with the slope T', and the covariance of estimates by least squares

.. math:: C = F^{-1} J^\mathsf{T} V J F^{-1}, \qquad F = J^\mathsf{T} J, \qquad V = \mathrm{diag}(s^2 + T'^2 t^2) .

A machine of compliance c in series reads m = x + c T; at the same readings the derivatives are J/(1 + c T'), and the
derivative by the compliance is -T T'/(1 + c T'). Repeating a loop divides C by the number of repetitions.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama import arguments, units
from squama.beam.design import Beam
from squama.errors import InputError, naming, refuse
from squama.identify import estimate, prepare, records
from squama.identify.expected import Candidate, Plan
from squama.identify.hinge_points import Hinged, Physical
from squama.identify.prepare import Prepared, Wanted
from squama.identify.unknowns import ask
from squama.io.measured import Measured
from squama.loads import LOADS, EndsName, JointName, LawName, LoadName
from squama.progress import steps
from squama.types import Array

FIND = ("mu", "K_theta", "E_B")
"""Parameters of a plan by default."""
TIMES = (1.2, 1.5, 2.0, 3.0)
"""Default tops of loops, over the twist at engagement."""
SHAPES = {"loading": (0,), "loop": (0, 1), "both senses": (0, 1, 2, 3)}
"""Ways of each loop: 0 to the top, 1 back to 0, 2 to the top in the other sense, 3 back again."""
MOST = 20
"""Largest number of tops."""
_BEFORE_LOCK = 0.8
"""Farthest default top on hinges, as a share of the way from engagement to the end of the path."""
_LEAST = 10
"""Least number of readings of a way for its errors."""
_FREE = {
    "With zeros of torque and twist found too": ("torque_zero", "twist_zero"),
    "With the compliance of the machine found too": ("compliance",),
}
_SLIGHT = 1e-3
"""A twist before engagement, rad per pitch."""


class _Test(NamedTuple):
    """Settings of the test: noises (N m, and rad over the whole beam), compliance (rad/(N m)), readings per loop."""

    wanted: Wanted
    kind: str
    noise: float
    twist_noise: float
    compliance: float
    points: int


class _Walked(NamedTuple):
    """Readings along the ways of loops to a top, at even steps of the twist; none with a ``problem``.

    ``J`` (readings, parameters) and ``zero``: derivatives of the torque by the parameters and by the zero of the twist;
    ``torque`` N m; ``way``: numbers of the ways, of ``ways`` in all; ``values`` of the parameters.
    """

    J: Array
    zero: Array
    torque: Array
    way: Array
    ways: int
    values: Array
    problem: str


def plan(
    beam: Beam,
    parameters: Sequence[str] | str = FIND,
    *,
    noise: float | str,
    twist_noise: float | str = 0.0,
    machine: float | str | None = None,
    to: float | str | None = None,
    tops: Sequence[float | str] | None = None,
    points: int = 100,
    accuracy: float | str = 0.05,
    load: LoadName = "twisting",
    law: LawName = "edge",
    joint: JointName | None = None,
    ends: EndsName | None = None,
) -> Plan:
    """Compare loops of a test by the standard errors of a beam's parameters expected from each.

    Parameters
    ----------
    beam, parameters
        The beam with its expected values, and the parameters to find, as for :func:`squama.fit`; friction is 0.25 where
        the beam has none.
    noise
        Standard deviation of a measured torque: N m or text such as "0.2 N mm".
    twist_noise
        Standard deviation of a measured twist: rad/m or text such as "0.2 deg total".
    machine
        Stiffness of the testing machine in series with the specimen: N m/rad or text such as "2 N m/rad"; rigid if not
        given.
    to, tops
        Largest twist of the test; tops of the loops, by default 1.2, 1.5, 2 and 3 times the twist at engagement. Twists
        are rad/m or texts such as "0.1 rad/pitch" or "140 deg total".
    points
        Readings of a loop, at even steps of the twist.
    accuracy
        Required relative standard error of each parameter.
    load, law, joint, ends
        As for :func:`squama.fit`.

    Returns
    -------
    Plan
        ``candidates`` (loops with their errors), ``best``, ``summary()``, ``dataset()``, ``plot()``.

    Raises
    ------
    InputError
        An argument is out of range, the scales do not engage, or the model follows none of the loops.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
    >>> found = squama.plan(beam, ("mu", "K_theta"), noise="0.5 N mm", joint="hinge", to="0.2 rad/pitch")
    >>> found.best.shape, found.loops(found.best)
    ('loop', 1)
    """
    arguments.beam(beam)
    arguments.load(load)
    law, kind = LOADS[load].law(arguments.law(law)), LOADS[load]
    with naming("noise"):
        sigma = units.bounded(noise, "torque", records.TORQUES)
    with naming("machine"):
        compliance = 0.0 if machine is None else 1 / units.bounded(machine, "torque", records.TORQUES)
    names = ask(beam, load, parameters, joint="hinge" if joint == "hinge" else "compliant").names
    asked = Wanted(beam, [], names, load, law, None, records.ALL, sigma, 1, ())
    model, _ = prepare.kind(joint, asked)
    asked = asked._replace(ends=prepare.ends(model, asked, ends))
    points = arguments.whole("points", points, 10, 10_000)

    def angle(name: str, value: float | str) -> float:
        return records.angle(name, value, beam, load, signed=True)

    test = _Test(asked, model, sigma, angle("twist_noise", twist_noise) * beam.pitches, compliance, points)
    with naming("accuracy"):
        wanted = units.bounded(accuracy, "ratio", units.Bounds(1e-4, 1.0, "1e-4 to 1", closed=True, example="0.05"))
    engaged, last = _engaged(test)
    given = [angle(f"tops[{i}]", top) for i, top in enumerate(tops if tops is not None else ())]
    limit = math.inf if to is None else angle("to", to)
    # near a lock a printed joint no longer follows the model of hinges
    near = engaged + _BEFORE_LOCK * (last - engaged) if math.isfinite(last) else math.inf
    heights = given or [math.copysign(min(times * abs(engaged), abs(near)), engaged) for times in TIMES]
    heights = sorted({math.copysign(min(abs(top), limit), top) for top in heights}, key=abs)
    if len(heights) > MOST:
        refuse("tops", "", f"{len(heights)} are too many", f"give {MOST} at most")
    found, free = list[Candidate](), dict[float, _Walked]()
    for top in steps(heights, len(heights), "loops of the plan"):
        free[top] = _walked(test, top)
        found += [_candidate(test, free[top], shape, top) for shape in SHAPES if kind.sided or shape != "both senses"]
    good = [one for one in found if not one.problem]
    if not good:
        refuse("", "", f"no loop of the plan can be followed: {found[0].problem}")
    best = min(good, key=lambda one: one.worst)
    more = {words: _candidate(test, free[best.top], best.shape, best.top, names) for words, names in _FREE.items()}
    return Plan(
        beam=beam,
        rows=ask(beam, load, parameters, joint=test.kind).rows,
        load=load,
        law=law,
        joint=test.kind,
        ends=test.wanted.ends,
        noise=test.noise,
        twist_noise=test.twist_noise,
        compliance=test.compliance,
        accuracy=wanted,
        engaged=engaged,
        candidates=tuple(found),
        best=best,
        free=tuple(more.items()),
    )


def _prepared(test: _Test, angle: Array) -> Prepared:
    """Return the points of readings at twists ``angle`` (rad per pitch); their torques are placeholders."""
    pitch = test.wanted.beam.pitch
    return prepare.prepared(test.kind, test.wanted._replace(specimens=[Measured(angle / pitch, angle, "plan")]))


def _engaged(test: _Test) -> tuple[float, float]:
    """Return the twists at engagement and at the end, rad per pitch; negative where only the other sense engages."""
    points = _prepared(test, np.array([_SLIGHT / 2, _SLIGHT])).points
    found = {sense: at for sense, at in points.engaged().items() if math.isfinite(at)}
    if not found:
        refuse("beam", "", "the scales do not engage", "check the geometry in the beam file")
    sense = "+" if "+" in found else "-"
    last = points.senses.most[sense] if isinstance(points, Hinged) else math.inf
    return (found[sense], last) if sense == "+" else (-found[sense], -last)


def _walked(test: _Test, top: float) -> _Walked:
    """Return the ways of loops to a top (rad per pitch), without the other sense where the beam cannot follow it."""
    n, problem = max(test.points // 2, _LEAST), ""
    for corners in ((0.0, top, 0.0, -top, 0.0), (0.0, top, 0.0)):
        angle = np.concatenate([np.linspace(a, b, n + 1)[1:] for a, b in itertools.pairwise(corners)])
        try:
            made = _prepared(test, angle)
            index, points, _, _ = made.used
            at = made.asked.physical(made.asked.start)
            wanted = np.array([name == "twist_zero" for name in Physical._fields])
            zero = points.jacobian(at, wanted)[:, Physical._fields.index("twist_zero")]
            J = estimate.derivatives(points, made.asked, made.asked.start)
            return _Walked(J, zero, points.torque(at), index // n, len(corners) - 1, made.asked.start, "")
        except InputError as error:
            problem = problem or str(error)
    none = np.empty(0)
    return _Walked(none, none, none, none, 0, none, problem)


def _candidate(test: _Test, walked: _Walked, shape: str, top: float, more: tuple[str, ...] = ()) -> Candidate:
    """Return a loop with its errors, or with its problem; ``more``: parameters found beside those of the plan."""
    ways, names = SHAPES[shape], test.wanted.names
    own = np.isin(walked.way, ways)
    none = Candidate(shape, top, test.points, math.nan, np.empty(0), np.empty((0, 0)), "")
    if walked.ways <= max(ways):
        return none._replace(problem=walked.problem or "the beam cannot be twisted in the other sense")
    zero, torque = walked.zero[own], walked.torque[own]
    steep = 1 - test.compliance * zero
    columns = {"torque_zero": np.ones(zero.size), "twist_zero": zero, "compliance": torque * zero}
    columns = {name: column for name, column in columns.items() if name in more and name not in names}
    # the readings of a loop are divided among its ways
    weight = test.points / (len(ways) * (walked.way == 0).sum())
    J = np.sqrt(weight) * np.column_stack([walked.J[own], *(columns.values())])
    J[:, : len(names)] /= steep[:, None]
    J[:, len(names) :] /= np.where(np.array([n == "torque_zero" for n in columns]), 1.0, steep[:, None])
    try:
        inner = estimate.covariance(J, 1.0, (*names, *columns))
    except InputError as error:
        return none._replace(problem=str(error))
    half = inner @ (J * np.hypot(test.noise, zero / steep * test.twist_noise)[:, None]).T
    covariance = (half @ half.T)[: len(names), : len(names)]
    return none._replace(torque=float(np.abs(torque).max()), values=walked.values, covariance=covariance)
