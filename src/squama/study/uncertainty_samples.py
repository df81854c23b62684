"""Random beams through the batch engine: points of the unit cube, dimensions, figures of every sample.

Samples come in :data:`REPLICATES` independent sets, so that the scatter between the sets gives the standard error of
every statistic, for scrambled Sobol points as for random ones. A sample depends on the seed and its number alone, not
on chunks or threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from squama.design import Beam
from squama.errors import InputError
from squama.model import mechanics
from squama.model.bending import Bend
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY, Twist
from squama.model.solve import Array
from squama.study import columns
from squama.study.cells import Cells
from squama.study.parameters import canonical, text_of
from squama.study.uncertainty_tolerances import Tolerance

REPLICATES = 32
CHUNK = 65_536
"""Samples that are computed at a time; what is kept of them is 8 bytes a figure."""
MOST = 2**24
SAMPLERS = ("sobol", "random")
_BITS = 30
LOCKS = tuple(CODES.index(end) for end in CODES if end.locks)
NONE = CODES.index(End.NONE)


class Case(NamedTuple):
    """What is asked of every sample."""

    beam: Beam
    tolerances: tuple[Tolerance, ...]
    load: str
    law: str
    sense: str
    margin: float
    engine: str = "auto"


def size(wanted: int, sampler: str) -> int:
    """Return the number of samples of a replicate: Sobol points are balanced by powers of two."""
    each = -(-wanted // REPLICATES)
    return 1 << (each - 1).bit_length() if sampler == "sobol" else each


def unit_points(dimensions: int, each: int, sampler: str, seed: int) -> Iterator[tuple[slice, Array]]:
    """Yield points strictly inside the unit cube, chunk by chunk, with their places; ``each`` in every replicate."""
    first, held, count = 0, [], 0
    for points in _sets(dimensions, each, sampler, seed):
        held.append(points)
        count += len(points)
        if count >= CHUNK or first + count == each * REPLICATES:
            yield slice(first, first + count), np.concatenate(held)
            first, held, count = first + count, [], 0


def _sets(dimensions: int, each: int, sampler: str, seed: int) -> Iterator[Array]:
    """Yield the points of one replicate after the other, in parts of a chunk at most."""
    for r in range(REPLICATES):
        rng = np.random.default_rng([seed, r])
        draw: Callable[[int], Array] = partial(_random, rng, dimensions)
        if sampler == "sobol":
            from scipy.stats.qmc import Sobol

            draw = Sobol(dimensions, scramble=True, bits=_BITS, rng=rng).random
        for start in range(0, each, CHUNK):
            yield np.clip(draw(min(CHUNK, each - start)), 2.0 ** -(_BITS + 1), 1 - 2.0 ** -(_BITS + 1))


def _random(rng: np.random.Generator, dimensions: int, n: int) -> Array:
    return rng.random((n, dimensions))


def values(case: Case, points: Array) -> dict[str, Array]:
    """Return the dimensions (SI units) at points (n, parameters) of the unit cube."""
    return {t.name: t.at(points[:, i]) for i, t in enumerate(case.tolerances)}


def figures(case: Case, dimensions: dict[str, Array]) -> dict[str, Array]:
    """Solve a chunk of samples.

    Returns
    -------
    dict of str to array
        By role: ``load_e``, ``rate_e``, ``load_end``, ``rate_end``, ``torque``, ``RED``, ``U_el``, ``W_fr``,
        ``stiffness`` (without contact), ``stiffness_e`` (right after engagement; inf where it locks there), ``code`` of
        the end. NaN, besides those of the stiffness, where nothing engages.

    Raises
    ------
    InputError
        A sample is no beam; one line.
    """
    c = columns.columns(case.beam, dimensions, load=case.load)
    n = next(iter(dimensions.values())).size
    _refuse(case, np.broadcast_to(columns.valid(c), n), dimensions)
    s = columns.solved(c, law=case.law, sense=case.sense, margin=case.margin, load=case.load, engine=case.engine)
    si = columns.in_si(c, s)
    code = np.broadcast_to(s.code, n)
    engaged = code != NONE
    found = {
        "load_e": si["load_e"],
        "rate_e": si["load_e"] / c.d,
        "load_end": si["load_end"],
        "rate_end": si["load_end"] / c.d,
        "torque": si["torque"],
        "RED": si["RED"],
        "U_el": si["U_el"],
        "W_fr": si["W_fr"],
        "stiffness_e": c.rigidity + c.K * c.d * _engaged_slope(case, c, s.neighbour),
    }
    found = {name: np.where(engaged, v, np.nan) for name, v in found.items()}
    return {**found, "stiffness": np.broadcast_to(c.rigidity, n), "code": code}


def _engaged_slope(case: Case, c: Cells, neighbour: Array) -> Array:
    """Scales' torque per load angle right after engagement, over K_theta; inf where friction locks them there.

    There the lift is zero, so the derivative of the torque has no other term.
    """
    if case.load == "bending":
        row: Any = Bend(c.eta, c.theta0)
    else:
        sa = np.sin(c.alpha) * (-1 if case.sense == "-" else 1)
        row = Twist(c.eta, c.beta, c.lam, sa, np.cos(c.alpha), c.theta0, np.maximum(neighbour, 1))
    with np.errstate(all="ignore"):
        pt = row.point(c.theta0, case.law, ARRAY)
        D = mechanics.forces(pt, c.theta0, c.mu).D
        slope = (pt.theta_rate + c.mu * pt.slip_rate / D) * pt.theta_rate / pt.load_rate**2
    return np.asarray(np.where(D > 0, slope, np.inf))


def _refuse(case: Case, good: Array, dimensions: dict[str, Array]) -> None:
    """Refuse samples that are no beam, with the words of the first of them."""
    if good.all():
        return
    i = int(np.flatnonzero(~good)[0])
    at = ", ".join(f"{name} = {text_of(canonical(name), v[i])}" for name, v in dimensions.items())
    changes: dict[str, Any] = {}
    for name, v in dimensions.items():
        table, _, key = name.partition(".")
        if table == "beam":
            changes[key] = float(v[i])
        else:
            changes.setdefault(table, {})[key] = float(v[i])
    try:
        case.beam.replace(**changes)
        why = "its joint has no stiffness that is a number"
    except InputError as error:
        why = "; ".join(str(error).splitlines())
    message = f"tolerances: some samples are no valid beam; at {at}: {why}; make the tolerances narrower"
    raise InputError(message)
