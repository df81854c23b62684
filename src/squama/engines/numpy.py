"""The NumPy engine: the solution of :mod:`squama.model.solution`, and figures at its cut-offs."""

from __future__ import annotations

import numpy as np

from squama.engines import Problem, Solved
from squama.model import energy, mechanics
from squama.model.outcome import CODES, End
from squama.model.solution import solve_bending, solve_twisting
from squama.model.solve import point, take

FRICTIONAL = CODES.index(End.FRICTIONAL)
LOCKS = (FRICTIONAL, CODES.index(End.KINEMATIC))


def run(p: Problem) -> Solved:
    """Answer every design of a problem."""
    # memory that was asked for and given back at once: from then on the C library keeps blocks of that size for the
    # next request, instead of returning them to the system and having them cleared again
    np.empty(1 << 21)
    if p.load == "bending":
        sol = solve_bending(p.eta, p.theta0, p.mu)
    else:
        sol = solve_twisting(p.eta, p.beta, p.lam, p.alpha, p.theta0, p.mu, law=p.law, sense=p.sense)
    n = p.eta.size
    theta_c, load_c = p.theta0.copy(), np.where(np.isfinite(sol.load_end), sol.load_end, 0.0)
    f0, torque, work = np.zeros((3, n))
    for index, t in sol.tracks:
        mu = p.mu[index]
        x_c = energy.cutoff(t.row, t.x0, t.x_end, np.isin(t.code, LOCKS), p.margin)
        pt = point(t.row, x_c, p.law)
        with np.errstate(all="ignore"):
            f = mechanics.forces(pt, t.row.theta0, mu)
        # a path that ends where it begins bears no load yet
        moved = x_c > t.x0
        theta_c[index], load_c[index] = (
            np.where(moved, pt.theta, p.theta0[index]),
            np.where(moved, pt.load, sol.load_e[index]),
        )
        f0[index] = np.where(moved, f.f * p.eta[index], 0.0)
        torque[index] = np.where(moved, f.torque, 0.0)
        pole, away = t.x_end.copy(), np.flatnonzero(~energy.ends_at_pole(t.row, t.x_end, t.code == FRICTIONAL))
        if away.size:
            pole[away] = energy.pole(take(t.row, away), t.x_end[away], mu[away], p.law, t.x0[away])
        work[index] = energy.works(t.row, t.x0, x_c, pole, mu, p.law, p.margin)
    elastic = (p.ratio * load_c**2 + (theta_c - p.theta0) ** 2) / 2
    total = elastic + work
    red = np.divide(work, total, out=np.zeros(n), where=total > 0)
    return Solved(
        sol.load_e,
        sol.theta_end,
        sol.load_end,
        sol.code,
        sol.neighbour,
        theta_c,
        load_c,
        f0,
        torque + p.ratio * load_c,
        elastic,
        work,
        red,
    )
