"""Answers for arrays of designs: one problem, several engines that execute the same kernel.

``solve`` checks and broadcasts its arguments, hands flat columns to an engine and gives the results their shape back.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import checks
from squama.model.outcome import CODES
from squama.model.solve import Array

ENGINES = {"numpy": "squama.engines.numpy", "numba": "squama.engines.compiled", "jax": "squama.engines.xla"}
"""Engines by name, and the module whose ``run`` answers a :class:`Problem`."""
WARM, COLD, UNMADE = 64, 20_000, 1_500_000
"""Designs from which "auto" takes Numba: loaded; to be loaded from the disk (some .3 s); to be compiled (some 25 s)."""


class Problem(NamedTuple):
    """Flat columns of one length (lengths in pitches, radians) and what is common to all designs.

    ``sa``, ``ca`` sine (its sign tells the sense) and cosine of alpha; ``ratio`` rigidity over K_theta d.
    """

    eta: Array
    beta: Array
    lam: Array
    alpha: Array
    theta0: Array
    mu: Array
    ratio: Array
    law: str
    sense: str
    margin: float
    load: str


class Solved(NamedTuple):
    """Engagement, end, and figures at the cut-off; every field has the broadcast shape of the inputs.

    ``load_e``, ``theta_end``, ``load_end`` (rad; load = twist phi or bend psi per pitch), ``code`` of the end (see
    ``end``), ``neighbour``; at the cut-off ``theta_c``, ``load_c``, ``f0`` = f l/K_theta, ``torque`` over K_theta,
    ``U_el`` d/K_theta, ``W_fr`` d/K_theta, ``RED``. Where nothing engages: load_e = load_end = inf, and the figures at
    the cut-off are those of the unloaded beam.
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
        return np.array([str(e) for e in CODES])[self.code]


def _fastest(problem: Problem) -> str:
    return fastest(problem.eta.size, problem.load)


def fastest(n: int, load: str) -> str:
    """Name of the engine that is likely to answer first for ``n`` designs."""
    loaded = ENGINES["numba"] in sys.modules
    if load == "bending" or n < (WARM if loaded else COLD) or find_spec("numba") is None:
        return "numpy"
    try:
        made = import_module(ENGINES["numba"]).ready()
    except ImportError:  # a numba that does not fit this Python or NumPy
        return "numpy"
    return "numba" if made or n >= UNMADE else "numpy"


def solve(
    *,
    eta: ArrayLike,
    beta: ArrayLike = 1.0,
    lam: ArrayLike = 1.0,
    alpha: ArrayLike = 0.5,
    theta0: ArrayLike,
    mu: ArrayLike,
    stiffness_ratio: ArrayLike = 0.0,
    law: str = "edge",
    sense: str = "+",
    margin: float = 0.01,
    load: str = "twisting",
    engine: str = "auto",
) -> Solved:
    """Solve arrays of designs: engagement, end, and force, torque, energies and RED at the cut-off.

    Parameters
    ----------
    eta, beta, lam, alpha, theta0, mu
        Ratios, angles (rad), coefficient of friction; broadcast against each other. Bending needs eta, theta0 and mu.
    stiffness_ratio
        C_f C_w G_B I / (K_theta d) of the beam without contact (E_B I / (K d) in bending); 0 leaves the scales alone.
    law, sense
        Force law "edge" or "plate", sense "+" or "-" (both without effect in bending).
    margin
        Fraction of the path left before a lock (docs, theory: energy).
    load
        "twisting" or "bending".
    engine
        "numpy", "numba" (extra fast), "jax" (extra jax), or "auto": Numba for many designs where it is installed, else
        NumPy.

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
    checks.one_of("load", load, ("twisting", "bending"))
    checks.one_of("engine", engine, ("auto", *ENGINES))
    columns, shape = checks.designs(
        eta=eta, beta=beta, lam=lam, alpha=alpha, theta0=theta0, mu=mu, stiffness_ratio=stiffness_ratio
    )
    margin = checks.scalar("margin", margin, 1e-12, 1.0, "at least 1e-12 and below 1")
    checks.sense(sense)
    e, b, la, al, t0, m, ratio = columns
    problem = Problem(e, b, la, al, t0, m, ratio, checks.law(law), sense, margin, load)
    if engine == "numba" and find_spec("numba") is None:
        checks.fail('engine = "numba": Numba is not installed; pip install squama[fast]')
    run = import_module(ENGINES[_fastest(problem) if engine == "auto" else engine]).run
    return Solved._make(v.reshape(shape) for v in run(problem))
