"""Arrays of designs with hinges, solved together.

``solve`` checks and broadcasts its arguments, solves the flattened designs (:mod:`squama.batch.answers`) and returns
the results in the broadcast shape.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.batch.answers import Answers, answers
from squama.loads import LawName, LoadName, SenseName
from squama.model.evaluation import FOLDED
from squama.model.outcome import named
from squama.types import Array


class Solved(NamedTuple):
    """Engagement, end, and values at the cut-off; every field has the broadcast shape of the inputs.

    ``load_e``, ``theta_end``, ``load_end`` (rad; load = twist phi or bend psi per pitch), ``code`` of the end (see
    ``end``), ``neighbour``; at the cut-off ``theta_c``, ``load_c``, ``f0`` = f l/K_theta, ``torque`` over K_theta,
    ``U_el`` d/K_theta, ``W_fr`` d/K_theta, ``RED``. Without engagement load_e = load_end = inf, and the values at the
    cut-off are those of the unloaded beam.
    """

    load_e: Array
    theta_end: Array
    load_end: Array
    code: Array
    neighbour: Array
    theta_c: Array
    load_c: Array
    f0: Array
    torque: Array
    U_el: Array
    W_fr: Array
    RED: Array

    @property
    def end(self) -> Array:
        """Ends in words."""
        return named(self.code)

    @classmethod
    def of(cls, a: Answers, theta0: Array, ratio: Array | float = 0.0) -> Solved:
        """Return the results (n,) of flat answers; ``theta0`` at rest (rad), stiffness ``ratio`` of :func:`solve`."""
        theta_end = np.where(a.kind == FOLDED, a.theta_f - a.x_end**2, a.x_end)
        elastic = (ratio * a.load_c**2 + (a.theta_c - theta0) ** 2) / 2
        total = elastic + a.work
        return cls(
            load_e=a.load_e,
            theta_end=np.where(a.x_end == a.x0, theta0, theta_end),
            load_end=a.load_end,
            code=a.code,
            neighbour=a.neighbour,
            theta_c=a.theta_c,
            load_c=a.load_c,
            f0=a.f0,
            torque=a.torque + ratio * a.load_c,
            U_el=elastic,
            W_fr=a.work,
            RED=np.divide(a.work, total, out=0 * total, where=total > 0),
        )


def solve(
    *,
    eta: ArrayLike,
    beta: ArrayLike | None = None,
    lam: ArrayLike | None = None,
    alpha: ArrayLike | None = None,
    theta0: ArrayLike,
    mu: ArrayLike,
    stiffness_ratio: ArrayLike = 0.0,
    thickness: ArrayLike = 0.0,
    law: LawName = "edge",
    sense: SenseName = "+",
    margin: float = 0.01,
    load: LoadName = "twisting",
) -> Solved:
    """Solve arrays of designs: engagement, end, and force, torque, energies and RED at the cut-off.

    Parameters
    ----------
    eta, beta, lam, alpha, theta0, mu
        Ratios, angles (rad), coefficient of friction; broadcast against each other. ``lam`` is the height of the
        scales' face over the axis of the load: t/d in twisting and, for a bent bar whose middle keeps its length, in
        bending; 0 if the face keeps its length. In bending beta, lam and alpha may be left out: edges across the beam,
        on a face that keeps its length.
    stiffness_ratio
        C_f C_w G_B I / (K_theta d) of the beam without contact (E_B I/(K d) in bending); 0 for the scales alone.
    thickness
        t_s/d of the scales; 0 is the paper's thin plate, required with law "plate" and in bending.
    law, sense
        Force law "edge" or "plate", sense "+" or "-" (both without effect in bending).
    margin
        Fraction of the path left before a lock (docs, theory: energy).
    load
        "twisting" or "bending".

    Returns
    -------
    Solved

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import numpy as np, squama
    >>> s = squama.solve(eta=3, beta=1.25, lam=0.45, alpha=np.pi / 4, theta0=np.radians(10), mu=[0.2, 0.5])
    >>> print(s.end[1], f"W_fr d/K_theta = {s.W_fr[1]:.5f}")
    frictional lock W_fr d/K_theta = 1.77519
    """
    arguments.load(load)
    contact = {"eta": eta, "beta": beta, "lam": lam, "alpha": alpha, "theta0": theta0, "mu": mu}
    columns, shape = arguments.designs(load, **contact, stiffness_ratio=stiffness_ratio, thickness=thickness)
    margin = arguments.margin(margin)
    arguments.sense(sense)
    arguments.thin(columns[7], arguments.law(law), load)
    found = solved(tuple(columns), law=law, sense=sense, margin=margin, load=load)
    return Solved._make(v.reshape(shape) for v in found)


def solved(
    columns: tuple[Array, ...],
    *,
    law: str,
    sense: str,
    margin: float,
    load: str,
    threads: int | None = None,
    few: int | None = None,
) -> Solved:
    """Solve flat columns, in the order of :func:`solve` (thickness may be missing), without checks.

    ``threads``, ``few`` as in :func:`squama.batch.answers.answers`.
    """
    contact, ratio, thick = columns[:6], columns[6], columns[7:]
    a = answers(contact, *thick, law=law, sense=sense, load=load, margin=margin, threads=threads, few=few)
    return Solved.of(a, columns[4], ratio)
