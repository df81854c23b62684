"""The spine: a load path is followed by a model to states, and the states become one labelled answer.

``MODELS`` is the one table of how a scale is held. A model solves what is asked in one sense (:class:`Solved` for each
coefficient of friction) and walks a history; what comes out is the same for all of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.curves import both_faces, hinge, hinge_cycles
from squama.curves.labelled import Answer, attributes, labelled
from squama.curves.path import Asked, LoadPath, Solved, States
from squama.loads import LOADS, Load
from squama.types import Array


class Model(NamedTuple):
    """How a scale is held.

    ``solve`` gives a solved path for each coefficient of friction, and what attributes and warnings it adds; ``walk``
    the states of a history.
    """

    solve: Callable[[Asked], tuple[Sequence[Solved], States]]
    walk: Callable[[Asked], States]


def _compliant_solve(asked: Asked) -> tuple[Sequence[Solved], States]:
    from squama.curves import real_path

    return real_path.solve(asked)


def _compliant_walk(asked: Asked) -> States:
    from squama.curves import real_cycles

    return real_cycles.walk(asked)


MODELS = {
    "hinge": Model(hinge.solve, hinge_cycles.walk),
    "compliant": Model(_compliant_solve, _compliant_walk),
}
"""A hinge with one spring (closed form), or six motions of a scale against the substrate."""


def solved(
    beam: Beam,
    load: str = "twisting",
    *,
    mu: float,
    law: str = "edge",
    sense: str = "+",
    margin: float = 0.01,
    to: float = math.inf,
    joint: str,
    ideal: bool,
) -> Solved:
    """Return the path of a beam in one sense, solved: what `squama.view` and the explorer go along.

    Arguments as of :func:`squama.twist`; ``to`` is a load angle per pitch (rad, a magnitude), by default the path's end
    (the compliant joint goes to 0.3 rad per pitch).
    """
    kind = LOADS[load]
    way = LoadPath.of(load, [math.copysign(to, arguments.sense(sense))])
    mus = np.asarray(mu, float)
    asked = Asked(beam, way, mus, kind.law(law), margin, 3, ideal=ideal)
    return MODELS[joint].solve(asked)[0][0]


def curves(asked: Asked, joint: str) -> Answer:
    """Follow a path in one sense: a curve for each coefficient of friction."""
    way = asked.path
    solve = MODELS[joint].solve
    one_face, more = solve(asked)
    # the real beam is followed on all its faces at once
    whole = joint == "compliant"
    solved_paths = one_face if whole else both_faces.gather(asked, one_face, lambda other: solve(other)[0])
    found = [path.curve(points=asked.points, at=asked.at) for path in solved_paths]
    family = ("mu",) * asked.mus.ndim

    def stack(values: Sequence[object]) -> Array:
        return np.stack([np.asarray(v) for v in values]) if family else np.asarray(values[0])

    along = {role: stack([c.along[role] for c in found]) for role in found[0].along}
    figures = {role: stack([c.figures[role] for c in found]) for role in found[0].figures}
    by_dim = {(*family, "point"): along, family: figures}
    attrs = attributes(asked, f"{way.load.name} of a scale-covered beam", way.sense, joint, more.notes)
    attrs |= {"mu": asked.mus.tolist(), **more.attrs}
    if way.load.sided:
        by_dim.setdefault((), {})["phi_e_small"] = np.asarray(_small(asked.beam, way.sense))
        attrs["sense"] = way.sense
    return Answer(labelled(way.load, States(by_dim), asked.mus, theory(way.load, joint)), attrs)


def cycles(asked: Asked, joint: str) -> Answer:
    """Follow a path that is loaded and unloaded: the states along it, its loops, and what holds for each sense."""
    load = asked.path.load
    states = MODELS[joint].walk(asked)
    attrs = attributes(asked, f"cycles of a scale-covered beam in {load.name}", "+", joint, states.notes)
    attrs |= {"history": [v / asked.beam.pitch for v in asked.path.values], **states.attrs}
    return Answer(labelled(load, states, asked.mus, theory(load, joint)), attrs)


def theory(load: Load, joint: str) -> str:
    """Return the page of the theory that a model's equations are from; empty for the paper's, which twists hinges."""
    if joint == "compliant":
        return "real beam"
    return "" if load.sided else "bending"


def _small(beam: Beam, sense: str) -> float:
    """Twist per pitch at engagement by the paper's formula for small angles."""
    alpha, sign = beam.scale.alpha, arguments.sense(sense)
    # with scales on both faces that of the one whose scales touch first
    signs = {sign, sign * (both_faces.sense(beam, "twisting") or 1)}
    slope = max(s * (beam.eta * math.tan(alpha) - math.sin(alpha)) + beam.beta for s in signs)
    return beam.scale.theta0 / slope if slope > 0 else math.inf
