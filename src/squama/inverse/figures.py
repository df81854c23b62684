"""Figures of many designs that a target may name, with their derivatives by whatever was moved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from squama.inverse.along import Part, at_twist, take
from squama.inverse.wants import COLUMNS, PATH, Found, Options, Partials, Want
from squama.model.outcome import CODES, End
from squama.model.plates import Plates
from squama.model.sensitivity import STEP
from squama.model.solution import SEARCH, Solution, solve_bending, solve_twisting, touch, with_touches
from squama.model.solve import Array
from squama.study.cells import Cells

_NONE = CODES.index(End.NONE)
_AT_END = {"RED", "W_fr"}


def flat(c: Cells) -> Cells:
    """Return columns of one length."""
    shape = np.broadcast_shapes(
        *(np.shape(v) for v in c[:-1]), *(np.shape(v) for t in c.sizes.values() for v in t.values())
    )
    n = math.prod(shape)

    def column(v: Any) -> Array:
        return np.ascontiguousarray(np.broadcast_to(v, shape)).reshape(n)

    sizes = {table: {key: column(v) for key, v in content.items()} for table, content in c.sizes.items()}
    return Cells._make([*(column(v) for v in c[:-1]), sizes])


def harmless(c: Cells, good: Array) -> Cells:
    """Return columns in which rows that are no beam stand for something that can be computed."""
    if np.count_nonzero(good) == good.size:
        return c
    fill = {"eta": 2.0, "lam": 0.5, "alpha": 0.5, "theta0": 0.2, "mu": 0.2}
    safe = {name: np.where(good, getattr(c, name), fill.get(name, 1.0)) for name in c._fields[:-1]}
    return Cells(**safe, sizes=c.sizes)


def evaluate(
    c: Cells,
    moved: Sequence[Cells],
    wants: Sequence[Want],
    options: Options,
    *,
    plates: bool,
    followed: tuple[Solution, Array] | None = None,
) -> Found:
    """Evaluate figures of many designs.

    Parameters
    ----------
    c : Cells
        Designs, flat columns.
    moved : sequence of Cells
        The same designs, each time with one variable moved by i STEP.
    wants : sequence of Want
        Figures.
    options : Options
        Force law, sense, margin, load, which ends count as locks.
    plates : bool
        Whether all plates are tested against each other, as :func:`squama.twist` does; else a contact of another kind
        goes unnoticed.
    followed : tuple, optional
        What :func:`follow` has given for the designs.

    Returns
    -------
    Found
    """
    n = c.eta.size
    by_column = {name: np.stack([np.imag(getattr(m, name)) for m in moved]) / STEP for name in COLUMNS if moved}
    sol, limit = follow(c, options, plates=plates) if followed is None else followed
    values, slopes = np.full((len(wants), n), np.nan), np.zeros((len(wants), len(moved), n))

    def put(i: int, index: Array, value: Array, partials: Partials) -> None:
        values[i, index] = value
        for name, partial in partials.items():
            if moved:
                slopes[i][:, index] += np.where(np.isfinite(partial), partial, 0.0) * by_column[name][:, index]

    with np.errstate(all="ignore"):
        used = [p for p in PATH[options.load] if moved and by_column[p].any()]
        for i, want in enumerate(wants):
            if want.figure == "stiffness":
                put(i, np.arange(n), c.rigidity, {"rigidity": np.ones(n)})
            elif want.at is not None:
                # before engagement the beam is straight
                phi = want.at.per_pitch(c.d)
                index = np.flatnonzero(phi <= np.minimum(sol.load_e, limit))
                none = np.zeros(index.size)
                put(i, index, *at_twist(want, take(c, index), phi[index], none, none, {}, {}))
        for index, t in sol.tracks:
            part = Part(take(c, index), t, options, any(w.figure in _AT_END for w in wants), used)
            reached, code = limit[index], sol.code[index]
            for i, want in enumerate(wants):
                if want.figure != "stiffness":
                    lanes, value, partials = part.figure(want, reached, code)
                    put(i, index[lanes], value, partials)
    return Found(values, slopes, sol.code, limit)


def follow(c: Cells, options: Options, *, plates: bool) -> tuple[Solution, Array]:
    """Return the ends of the designs, and how far their curves go."""
    if options.load == "bending":
        sol = solve_bending(c.eta, c.theta0, c.mu)
        return sol, np.where(sol.code == _NONE, SEARCH, sol.load_end)
    sol = solve_twisting(c.eta, c.beta, c.lam, c.alpha, c.theta0, c.mu, law=options.law, sense=options.sense)
    limit = np.where(sol.code == _NONE, SEARCH, sol.load_end)
    if plates:
        sol, touches = with_touches(sol, _plates(c, options), c.theta0, mirrored=options.sense == "-")
        met = np.array([np.inf if hit is None else hit.phi for hit in touches])
        limit = np.where(sol.code == _NONE, np.minimum(SEARCH, met), sol.load_end)
    return sol, limit


def _plates(c: Cells, options: Options) -> list[Plates]:
    sign = 1 if options.sense == "+" else -1
    shapes = (c.eta, c.beta, c.lam, sign * np.sin(c.alpha), np.cos(c.alpha))
    return [Plates(*map(float, row)) for row in zip(*shapes, strict=True)]


def touched(c: Cells, sol: Solution, index: Array, options: Options) -> Array:
    """Tell for some of the engaged designs whether other plates meet before their paths end."""
    if options.load == "bending":
        return np.zeros(index.size, bool)
    places = {int(i): (t, n) for lanes, t in sol.tracks for n, i in enumerate(lanes)}
    every = _plates(take(c, index), options)
    found = np.zeros(index.size, bool)
    for k, i in enumerate(index.tolist()):
        t, n = places[i]
        before = float(sol.load_e[i])
        mirrored = options.sense == "-"
        found[k] = touch(every[k], float(c.theta0[i]), before, t, n, mirrored=mirrored) is not None
    return found
