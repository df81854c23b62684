"""What can be made: designs rounded and still on target, what printer and joint refuse, and what elements say."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from squama.beam.design import Beam
from squama.curves import doors
from squama.errors import InputError
from squama.fabrication import refuse
from squama.fabrication.plan import MOST_SCALES, plan
from squama.fabrication.solids import PARTS
from squama.fe import runs
from squama.inverse.residuals import Residuals
from squama.inverse.space import Space
from squama.joints import law
from squama.joints.choice import shape
from squama.loads import ENDLESS, STRAIGHT
from squama.types import Array
from squama.units import change, moment

INCREMENTS = 20
"""Increments of the twist of such a run."""
MESH = "coarse"
"""Mesh of the elements that a design is held against."""
CORNERS = 8
"""Dimensions all of whose roundings up and down are tried together; of more as many are drawn."""
ROUNDS = 4
"""How often neighbours on the grid are looked at."""
GOOD = 1e-12
"""Merit below which a design does all that is asked."""
AWAY = 1e-9
"""Price of the distance from the design before it is rounded, in steps squared: among equals the nearest is taken."""


def rounded(residuals: Residuals, y: Array, seed: int = 1) -> Array:
    """Return designs (n, m) on the grid of the steps: of each the best neighbour."""
    space = residuals.space
    on_grid = [j for j, v in enumerate(space.variables) if v.step]
    if not on_grid:
        return y
    steps = np.array([space.variables[j].step for j in on_grid])
    low, high = np.array([space.variables[j].multiples for j in on_grid], float).T
    values = space.values(y)
    exact = np.stack([values[space.variables[j].key] for j in on_grid], axis=1) / steps

    def place(which: Array, multiples: Array) -> Array:
        """Return points of designs (k,) with multiples (k, g)."""
        at = {key: column[which] for key, column in values.items()}
        at |= {space.variables[j].key: n * step for j, n, step in zip(on_grid, multiples.T, steps, strict=True)}
        return space.place(at)

    rng = np.random.default_rng(seed)
    best = np.clip(np.round(exact), low, high)
    merit = np.full(len(y), np.inf)
    for turn in range(ROUNDS):
        live = np.flatnonzero(merit > GOOD)
        if not live.size:
            break
        moves = _corners(len(on_grid), rng) if turn == 0 else _around(len(on_grid))
        base = np.floor(exact[live]) if turn == 0 else best[live]
        tried = np.clip(base[:, None] + moves, low, high)
        points = place(np.repeat(live, len(moves)), tried.reshape(-1, len(on_grid)))
        found = residuals.look(points, slopes=False, plates=True).merit.reshape(live.size, -1)
        first = np.argmin(found + AWAY * ((tried - exact[live, None]) ** 2).sum(axis=2), axis=1)
        lanes = np.arange(live.size)
        better = found[lanes, first] < merit[live]
        best[live[better]] = tried[lanes, first][better]
        merit[live[better]] = found[lanes, first][better]
        if turn and not better.any():
            break
    return place(np.arange(len(y)), best)


def nearest(space: Space, y: Array) -> Array:
    """Return points (n, m) with every dimension rounded to the nearest multiple of its step."""
    values = space.values(y)
    for v in space.variables:
        values[v.key] = np.array([v.rounded(x) for x in values[v.key].tolist()])
    return space.place(values)


def _corners(k: int, rng: np.random.Generator) -> Array:
    """Return roundings down (0) and up (1) of k numbers."""
    if k <= CORNERS:
        return np.array(list(itertools.product((0.0, 1.0), repeat=k)))
    return rng.integers(0, 2, (2**CORNERS, k)).astype(float)


def _around(k: int) -> Array:
    """Return steps of one or two of k numbers."""
    one = np.concatenate([np.eye(k), -np.eye(k)])
    two = [a + b for a, b in itertools.combinations(one, 2) if np.any(a + b)]
    return np.array([*one, *two])


def refused(beam: Beam, sizes: dict[str, float] | None, *, sided: bool = True) -> list[str]:
    """Return reasons, one a line, why a beam cannot be printed with a workshop's sizes, or its joint is not known.

    The joint is looked at where the load is ``sided``: the law is that of twisting.
    """
    unknown = sided and beam.joint.matrix is None
    lines = [f"joint: {p}" for p in law.outside(shape(beam))] if unknown else []
    if sizes is not None:
        try:
            refuse.check(plan(beam, min(beam.pitches, MOST_SCALES), sizes), PARTS)
        except InputError as error:
            lines += [f"printer files: {p}" for p in error.problems]
    return lines


def by_elements(beam: Beam, sense: str, rates: Sequence[float]) -> list[str]:
    """Return lines that compare finite elements with the real beam's curve at twist rates (rad/m).

    Both are of one pitch that is held straight.

    Raises
    ------
    InputError
        The extra ``fe`` is not installed, or the mesh is refused.
    """
    run = runs.cell(beam, to=max(rates), sense=sense, mesh=MESH, increment=max(rates) * beam.pitch / INCREMENTS)
    x, T = run["Phi"].values, run["T"].values
    how = doors.How(joint="compliant", hold=STRAIGHT)
    own = doors.respond(beam, "twisting", at=x.tolist(), sense=sense, ends=ENDLESS, **how)["T"]
    # slopes of both between the same twists
    ratios = [np.gradient(torque, x) / (torque[1] / x[1]) for torque in (T, own)]
    lines = []
    for rate in rates:
        where = f"elements ({MESH} mesh), held straight, {rate * beam.pitch:.4g} rad per pitch"
        if rate > x[-1] * (1 + 1e-9):
            lines.append(f"{where}: the run ends before, {run.attrs['sentence']}")
            continue
        torque, real, stiffer, as_stiff = (float(np.interp(rate, x, v)) for v in (T, own, *ratios))
        beside = f"stiffness ratio {stiffer:.3g} (real beam: {as_stiff:.3g})"
        lines.append(f"{where}: torque {moment(torque)} ({change(torque / real - 1, '+')}), {beside}")
    return lines
