r"""Which test would tell the parameters of a beam: the errors that are expected of loops before any is measured.

At the beam's own values the derivatives J of the torques of a loop that is not measured yet are those of the fit
(:func:`squama.identify.estimate.derivatives`). With noise s of the torque and t of the twist (over the whole beam) the
variance of a reading is :math:`s^2 + (T' t)^2`, with the slope T', and the covariance of estimates by least squares

.. math:: C = F^{-1} J^\mathsf{T} V J F^{-1}, \qquad F = J^\mathsf{T} J, \qquad V = \mathrm{diag}(s^2 + T'^2 t^2) .

A machine of compliance c in series reads m = x + c T; at the same readings the derivatives are J/(1 + c T'), and that
to the compliance is -T T'/(1 + c T'). Loops that are repeated divide C by their number.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from squama import arguments, units
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.errors import InputError, naming, refuse
from squama.identify import estimate, prepare, records
from squama.identify.expected import Candidate, Plan
from squama.identify.hinge_points import Hinged, Physical
from squama.identify.prepare import Prepared, Wanted
from squama.identify.unknowns import ask
from squama.io.measured import Measured
from squama.loads import LOADS
from squama.progress import steps
from squama.types import Array

FIND = ("mu", "K_theta", "E_B")
"""Parameters whose errors are told if none are named."""
TIMES = (1.2, 1.5, 2.0, 3.0)
"""Tops of loops over the twist of the engagement."""
SHAPES = ("loading", "loop", "two heights", "both senses")
"""Loading alone; there and back; first half-way from the engagement, then to the top; to the top in either sense."""
MOST = 20
"""Loops, and tops, at most."""
_BEFORE_LOCK = 0.8
"""Way from the engagement to the end of a path on hinges beyond which no loop goes unasked."""
_SLIGHT = 1e-3
"""A twist by which the engagement is asked, rad per pitch."""


class _Test(NamedTuple):
    """What is known of the test: noises (N m, and rad over the whole beam), compliance (rad/(N m)), readings a loop."""

    wanted: Wanted
    kind: str
    noise: float
    twist_noise: float
    compliance: float
    points: int


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
    load: str = "twisting",
    law: str = "edge",
    joint: str | None = None,
    ends: str | None = None,
) -> Plan:
    """Say which loops would tell the parameters of a beam best: expected standard errors, before anything is measured.

    Parameters
    ----------
    beam, parameters
        The beam with its expected values, and what is to be found, as for :func:`squama.fit`; friction is 0.25 where
        the beam has none.
    noise
        Standard deviation of a measured torque: N m or text such as "0.2 N mm".
    twist_noise
        Standard deviation of a measured twist: rad/m or text such as "0.2 deg total".
    machine
        Stiffness of the testing machine in series with the specimen: N m/rad or text such as "2 N m/rad"; rigid if not
        given.
    to, tops
        Largest twist of the test, if there is one; tops of the loops, by default 1.2, 1.5, 2 and 3 times the twist of
        the engagement. Twists are rad/m or texts such as "0.1 rad/pitch" or "140 deg total".
    points
        Readings of a loop, at even steps of the twist.
    accuracy
        Relative standard error that is wanted of each parameter.
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
    only_one(beam.faces, "a plan of a test")
    arguments.load(load)
    law, kind = LOADS[load].law(arguments.law(law)), LOADS[load]
    test = _test(beam, parameters, noise, twist_noise, machine, points, load, law, joint, ends)
    with naming("accuracy"):
        wanted = units.bounded(accuracy, "ratio", units.Bounds(1e-4, 1.0, "1e-4 to 1", closed=True, example="0.05"))
    engaged, last = _engaged(test)
    given = [_angle(f"tops[{i}]", top, test) for i, top in enumerate(tops if tops is not None else ())]
    limit = math.inf if to is None else _angle("to", to, test)
    # near a lock no real joint follows its law
    near = engaged + _BEFORE_LOCK * (last - engaged) if math.isfinite(last) else math.inf
    heights = given or [math.copysign(min(times * abs(engaged), abs(near)), engaged) for times in TIMES]
    heights = sorted({math.copysign(min(abs(top), limit), top) for top in heights}, key=abs)
    if len(heights) > MOST:
        refuse("tops", "", f"{len(heights)} are too many", f"give {MOST} at most")
    shapes = SHAPES if kind.sided else SHAPES[:3]
    wishes = [(shape, top) for shape in shapes for top in heights]
    found = [_candidate(test, shape, top, engaged) for shape, top in steps(wishes, len(wishes), "loops of the plan")]
    good = [one for one in found if not one.problem]
    if not good:
        refuse("", "", f"no loop of the plan can be followed: {found[0].problem}")
    best = min(good, key=lambda one: one.worst)
    rows = ask(beam, load, parameters, joint=test.kind).rows
    free = tuple(
        (words, _candidate(test, best.shape, best.top, engaged, more))
        for words, more in (
            ("With zeros of torque and twist found too", ("torque_zero", "twist_zero")),
            ("With the compliance of the machine found too", ("compliance",)),
        )
    )
    return Plan(
        beam=beam,
        rows=rows,
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
        free=free,
    )


def _test(
    beam: Beam,
    parameters: Sequence[str] | str,
    noise: float | str,
    twist_noise: float | str,
    machine: float | str | None,
    points: int,
    load: str,
    law: str,
    joint: str | None,
    ends: str | None,
) -> _Test:
    """Check what is told of the test."""
    with naming("noise"):
        sigma = units.bounded(noise, "torque", records.TORQUES)
    with naming("machine"):
        compliance = 0.0 if machine is None else 1 / units.bounded(machine, "torque", records.TORQUES)
    names = ask(beam, load, parameters, joint="hinge" if joint == "hinge" else "compliant").names
    wanted = Wanted(beam, [], names, load, law, None, records.ALL, sigma, 1, ())
    kind, _ = prepare.kind(joint, wanted, 0)
    wanted = wanted._replace(ends=prepare.ends(kind, wanted, ends))
    test = _Test(wanted, kind, sigma, 0.0, compliance, arguments.whole("points", points, 10, 10_000))
    return test._replace(twist_noise=_angle("twist_noise", twist_noise, test) * beam.pitches)


def _angle(name: str, value: float | str, test: _Test) -> float:
    """Return a load angle per pitch (rad) from a rate or text."""
    beam = test.wanted.beam
    with naming(name):
        return LOADS[test.wanted.load].read(value, pitch=beam.pitch, scales=beam.pitches) * beam.pitch


def _prepared(test: _Test, angle: Array) -> Prepared:
    """Return the points of readings of the twist (rad per pitch); their torques do not matter."""
    pitch = test.wanted.beam.pitch
    return prepare.prepared(test.kind, test.wanted._replace(specimens=[Measured(angle / pitch, angle, "plan")]))


def _engaged(test: _Test) -> tuple[float, float]:
    """Return the twist of the engagement and the last one, rad per pitch; both negative in the other sense only."""
    points = _prepared(test, np.array([_SLIGHT / 2, _SLIGHT])).points
    found = {sense: at for sense, at in points.engaged().items() if math.isfinite(at)}
    if not found:
        refuse("beam", "", "the scales do not engage", "check the geometry in the beam file")
    sense = "+" if "+" in found else "-"
    last = points.senses.most[sense] if isinstance(points, Hinged) else math.inf
    return (found[sense], last) if sense == "+" else (-found[sense], -last)


def _readings(shape: str, top: float, engaged: float, points: int) -> Array:
    """Return the readings of a loop from rest, rad per pitch, at even steps; each turning point is read."""
    half = (top + engaged) / 2
    corners = {"loading": (0, top), "loop": (0, top, 0), "two heights": (0, half, 0, top, 0)}.get(
        shape, (0, top, -top, 0)
    )
    lengths = np.abs(np.diff(corners))
    numbers = np.maximum(np.rint(points * lengths / lengths.sum()).astype(int), 2)
    parts = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(corners[:-1], corners[1:], numbers.tolist(), strict=True)]
    return np.concatenate(parts)


def _candidate(test: _Test, shape: str, top: float, engaged: float, more: tuple[str, ...] = ()) -> Candidate:
    """Return a loop with its errors; ``more``: what is found beside what is asked. What cannot be, is its problem."""
    angle = _readings(shape, top, engaged, test.points)
    names = test.wanted.names
    try:
        made = _prepared(test, angle)
        torque, covariance = _expected(test, made, [n for n in more if n not in names])
    except InputError as error:
        return Candidate(shape, top, angle.size, math.nan, np.empty(0), np.empty((0, 0)), str(error))
    n = len(names)
    return Candidate(shape, top, angle.size, torque, made.asked.start, covariance[:n, :n], "")


def _expected(test: _Test, made: Prepared, more: Sequence[str]) -> tuple[float, Array]:
    """Return the largest torque of a loop, N m, and the covariance of what is asked and of ``more``."""
    _, points, _, _ = made.used
    at, p = made.asked.physical(made.asked.start), made.asked.start
    torque = points.torque(at)
    wanted = np.array([name == "twist_zero" for name in Physical._fields])
    zero = points.jacobian(at, wanted)[:, Physical._fields.index("twist_zero")]
    steep = 1 - test.compliance * zero
    columns: dict[str, Any] = {
        "torque_zero": np.ones(torque.size),
        "twist_zero": zero / steep,
        "compliance": torque * zero / steep,
    }
    J = estimate.derivatives(points, made.asked, p) / steep[:, None]
    J = np.column_stack([J, *(columns[name] for name in more)])
    inner = estimate.covariance(J, 1.0, (*made.asked.names, *more))
    spread = np.hypot(test.noise, zero / steep * test.twist_noise)
    half = inner @ (J * spread[:, None]).T
    return float(np.abs(torque).max()), half @ half.T
