"""Histories of twists as they are given, and how far the model follows a beam along them."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from squama import checks, units
from squama.curve import Case, Path, invert, path
from squama.design import Beam
from squama.errors import InputError
from squama.model import history, solution
from squama.model.outcome import End
from squama.model.paths import FLOAT
from squama.model.plates import Plates
from squama.model.solve import Array

_SAME = 1e-12
_LOCKS = (End.FRICTIONAL, End.KINEMATIC)


class Senses(NamedTuple):
    """Both senses of loading of a beam, by "+" and "-": solved paths, sides in contact, largest load angles allowed."""

    case: Case
    mu: float
    paths: dict[str, Path]
    sides: dict[str, history.Side]
    most: dict[str, float]

    @property
    def bar(self) -> float:
        """Rigidity of the bar without contact over K_theta d."""
        return self.case.rigidity / (self.case.stiffness * self.case.pitch)

    def place(self, sign: str, load: float) -> float:
        """Path parameter at a load angle (magnitude, beyond engagement)."""
        p = self.paths[sign]
        return float(invert(p.row, np.array([load]), p.x0, p.x_c, p.law)[0])


def read(given: Any, beam: Beam, load: str) -> list[float]:
    """Return a history as load angles per pitch, from rest at 0 on, and no two in a row equal.

    Parameters
    ----------
    given
        A number (rad/m), a text, or a sequence of them; a single one is gone to and back. In a text with commas a
        number without a unit has that of the last one.

    Raises
    ------
    InputError
        A twist that cannot be read, that is not finite, that stands twice in a row, or no twist other than 0.
    """
    if isinstance(given, str):
        items: list[Any] = _parts(given)
    elif isinstance(given, Sequence | np.ndarray):
        items = list(given)
    else:
        items = [given]
    rates = [_rate(item, i, len(items), beam, load) for i, item in enumerate(items)]
    if not rates:
        checks.fail("twist: is empty; give twists one after the other, such as [0, 5, 0]")
    rates = [0.0, *rates, 0.0] if len(rates) == 1 else rates
    values = [rate * beam.pitch for rate in rates]
    if values[0] != 0:
        values.insert(0, 0.0)
    elif len(values) > 1 and values[1] == 0 and len(items) == 1:
        checks.fail("twist = 0: nothing moves; give a twist other than 0")
    for i, (a, b) in enumerate(itertools.pairwise(values)):
        if a == b:
            place = i + 1 + len(items) - len(values)
            checks.fail(f"twist[{place}] = {b / beam.pitch:.6g} rad/m: is the same as the one before; give it once")
    return values


def _parts(text: str) -> list[str]:
    """Split a text at its commas and hand the last unit on to the numbers without one."""
    parts = [part.strip() for part in text.split(",")]
    unit = re.sub(r"^[+-]?[\d.]+(?:[eE][+-]?\d+)?", "", parts[-1]).strip()
    return [f"{p} {unit}" if unit and re.fullmatch(r"[+-]?[\d.]+(?:[eE][+-]?\d+)?", p) else p for p in parts]


def _rate(item: Any, i: int, n: int, beam: Beam, load: str) -> float:
    name = "twist" if n == 1 else f"twist[{i}]"
    reader = units.twist if load == "twisting" else units.curvature
    if isinstance(item, np.generic):
        item = item.item()
    try:
        return reader(item, pitch=beam.pitch, scales=beam.scales)
    except units.QuantityError as error:
        message = f"{name} = {error.shown}: {error.reason}"
        raise InputError(message) from None


def repeated(values: list[float], times: int) -> list[float]:
    """Return a history gone through several times; where it starts as it ended, that twist stands once."""
    once = values[1:] if values[-1] == values[0] else values
    return values + once * (times - 1)


def senses(beam: Beam, load: str, mu: float, law: str, margin: float) -> Senses:
    """Solve a beam in both senses of loading."""
    solve = _twisting if load == "twisting" else _bending
    paths = {sign: solve(beam, sign, mu, law, margin) for sign in ("+", "-")}
    if load == "twisting":
        rigidity, stiffness = beam.torsional_rigidity, beam.joint_stiffness
    else:
        rigidity, stiffness = beam.bending_rigidity, beam.bending_joint_stiffness
    case = Case(beam.pitch, rigidity, stiffness, beam.eta, beam.scale.theta0)
    sides, most = {}, {}
    for sign, p in paths.items():
        most[sign] = p.load_end
        if p.engaged:
            sides[sign] = history.Side(p.row, p.x0, p.x_c, p.pole, mu, p.law)
            if p.end in _LOCKS:
                most[sign] = float(p.row.point(p.x_c, p.law, FLOAT).load)
    return Senses(case, mu, paths, sides, most)


def _case(beam: Beam, sign: str) -> Case:
    return Case(beam.pitch, 1.0, 1.0, beam.eta, beam.scale.theta0, sign == "-")


def _twisting(beam: Beam, sign: str, mu: float, law: str, margin: float) -> Path:
    columns: list[Array] = [np.array([v]) for v in (*beam.ratios.values(), mu)]
    s = math.sin(beam.scale.alpha) * (1 if sign == "+" else -1)
    plates = Plates(beam.eta, beam.beta, beam.lam, s, math.cos(beam.scale.alpha))
    sol = solution.solve_twisting(*columns, law=law, sense=sign)
    sol, touches = solution.with_touches(sol, [plates], columns[4], mirrored=sign == "-")
    return path(_case(beam, sign), sol, touches[0], mu, law, margin, None)


def _bending(beam: Beam, sign: str, mu: float, law: str, margin: float) -> Path:
    case = _case(beam, sign)
    if sign == "-":
        # bent away from the scales, they spread: nothing touches
        far = solution.SEARCH
        return Path(None, 0, 0, 0, 1, math.inf, far, case.theta0, End.NONE, 0, "", mu, law)
    sol = solution.solve_bending(np.array([beam.eta]), np.array([case.theta0]), np.array([mu]))
    return path(case, sol, None, mu, "edge", margin, None)


def check(values: list[float], found: Senses) -> None:
    """Refuse a history that the model does not cover.

    Raises
    ------
    InputError
        The first twist beyond the largest that is allowed, or at which the scales do not slide back; one line.
    """
    ways = set()
    for i, value in enumerate(values):
        sign = "-" if value < 0 else "+"
        if abs(value) > found.most[sign] * (1 + _SAME):
            checks.fail(f"twist = {value:.6g} rad/pitch: is beyond {_beyond(found, sign)}")
        if i and (values[i - 1], value) not in ways:
            ways.add((values[i - 1], value))
            _slides_back(values[i - 1], value, found)


def _beyond(found: Senses, sign: str) -> str:
    p, most = found.paths[sign], found.most[sign]
    minus = "-" if sign == "-" else ""
    here, end = f"{minus}{most:.6g}", f"{minus}{p.load_end:.6g} rad/pitch"
    words = {
        End.STATIC: "where friction locks the scales as soon as they touch (static lock)",
        End.OFF_TIP: "where the contact runs off the end of the tip edge, and a cycle does not follow it",
        End.OFF_SIDE: "where the contact runs off the end of the side edge, and a cycle does not follow it",
        End.RELEASED: "where the contact opens beyond a fold, and a cycle does not follow it",
        End.RANGE: "where half a turn of scale or beam is reached",
        End.NONE: "the range in which contacts are looked for",
    }
    if p.end in _LOCKS:
        why = f"the cut-off before the {p.end} at {end} (mu = {found.mu:g})"
    elif p.other:
        why = f"where another contact comes in that a cycle does not follow: {p.other}"
    else:
        why = words[p.end]
    digits = 10.0 ** (math.floor(math.log10(most)) - 4)
    return f'{here} rad/pitch, {why}; give at most "{minus}{math.floor(most / digits) * digits:.5g} rad/pitch"'


def _slides_back(start: float, stop: float, found: Senses) -> None:
    sign = "-" if start < 0 else "+"
    p = found.paths[sign]
    if abs(start) <= p.load_e or (abs(stop) > abs(start) and start * stop > 0):
        return
    side, high = found.sides[sign], found.place(sign, abs(start))
    low = side.x0 if start * stop <= 0 or abs(stop) <= p.load_e else found.place(sign, abs(stop))
    x = history.held(side, low, high)
    if x is not None:
        at = float(p.row.point(x, p.law, FLOAT).load) * (-1 if sign == "-" else 1)
        checks.fail(
            f"twist = {stop:.6g} rad/pitch: coming from {start:.6g} the scales do not slide back beyond {at:.6g} "
            f"rad/pitch, friction holds them there (mu = {found.mu:g}, {p.law} law); turn round before"
        )
