"""Derivatives of every output of :func:`squama.solve` with respect to every parameter, for arrays of designs.

The derivatives are exact, not by differences: a complex step through the kernel, and the implicit function theorem at
the end (:mod:`squama.model.sensitivity`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.arrays import solution
from squama.batch import Solved
from squama.loads import LawName, LoadName, SenseName
from squama.model.outcome import named
from squama.model.sensitivity import STEP, Moved, Tracked, move, seed, tracked
from squama.types import Array

OUTPUTS = ("load_e", "theta_end", "load_end", "theta_c", "load_c", "f0", "torque", "U_el", "W_fr", "RED")
"""Outputs that can be differentiated; names as in :class:`squama.Solved`."""
PARAMETERS = ("eta", "beta", "lam", "alpha", "theta0", "mu", "stiffness_ratio", "margin")
"""Parameters of :func:`squama.solve`."""


@dataclass(frozen=True, eq=False)
class Gradient:
    """Derivatives by name: ``g["W_fr", "mu"]`` is an array with the broadcast shape of the designs.

    ``array`` holds all of them, outputs ``of`` along its first axis, parameters ``wrt`` along its second. ``code`` is
    the number of each design's end (see ``end``).
    """

    of: tuple[str, ...]
    wrt: tuple[str, ...]
    array: Array
    code: Array

    def __getitem__(self, names: tuple[str, str]) -> Array:
        """Return the derivative of an output with respect to a parameter."""
        of, wrt = names
        arguments.one_of("output", of, self.of)
        arguments.one_of("parameter", wrt, self.wrt)
        found: Array = self.array[self.of.index(of), self.wrt.index(wrt)]
        return found

    @property
    def end(self) -> Array:
        """Ends in words."""
        return named(self.code)


def gradient(
    *,
    eta: ArrayLike,
    beta: ArrayLike | None = None,
    lam: ArrayLike | None = None,
    alpha: ArrayLike | None = None,
    theta0: ArrayLike,
    mu: ArrayLike,
    stiffness_ratio: ArrayLike = 0.0,
    law: LawName = "edge",
    sense: SenseName = "+",
    margin: float = 0.01,
    load: LoadName = "twisting",
    of: str | Sequence[str] | None = None,
    wrt: str | Sequence[str] | None = None,
) -> Gradient:
    """Differentiate outputs of :func:`squama.solve` with respect to its parameters.

    A derivative holds while the end keeps its name. Where nothing engages, those of ``load_e`` and ``load_end`` are
    NaN. At mu = 0 the derivative with respect to mu is that for growing mu.

    Parameters
    ----------
    eta, beta, lam, alpha, theta0, mu, stiffness_ratio, law, sense, margin, load
        As in :func:`squama.solve`.
    of, wrt
        Names of outputs and of parameters, or None for all of them.

    Raises
    ------
    InputError
        An argument is out of range, or a name is unknown.

    Examples
    --------
    >>> import numpy as np, squama
    >>> design = dict(eta=3, beta=1.25, lam=0.45, alpha=np.pi / 4, theta0=np.radians(10))
    >>> g = squama.gradient(**design, mu=[0.2, 0.5], of=["load_end", "RED"], wrt="mu")
    >>> print(g["load_end", "mu"].round(5))
    [-0.04412 -0.08261]
    """
    of = OUTPUTS if of is None else arguments.words("of", of, OUTPUTS)
    wrt = PARAMETERS if wrt is None else arguments.words("wrt", wrt, PARAMETERS)
    arguments.load(load)
    columns, shape = arguments.designs(
        load, eta=eta, beta=beta, lam=lam, alpha=alpha, theta0=theta0, mu=mu, stiffness_ratio=stiffness_ratio
    )
    margin = arguments.margin(margin)
    given = dict(zip(PARAMETERS, columns, strict=False))
    mu, sign = given["mu"], arguments.sense(sense)
    cut = margin if {"W_fr", "RED"} & set(of) else None
    sol = solution.solve(given, load=load, law=arguments.law(law), sense=sense, margin=cut)
    array = np.zeros((len(of), len(wrt), mu.size))
    with np.errstate(all="ignore"):
        tracks = [(index, tracked(t, mu[index], margin, law, sol.found.W_fr[index])) for index, t in sol.tracks]
        for j, name in enumerate(wrt):
            moved = _derivatives(
                sol.found, given["theta0"], given["stiffness_ratio"], tracks, name, sign, cut is not None
            )
            array[:, j] = [moved[key] for key in of]
    return Gradient(of, wrt, array.reshape(len(of), len(wrt), *shape), sol.found.code.reshape(shape))


def _derivatives(
    found: Solved, theta0: Array, ratio: Array, tracks: list[tuple[Array, Tracked]], name: str, sign: int, work: bool
) -> dict[str, Array]:
    """Return the derivatives (n,) of all outputs with respect to the parameter ``name``.

    ``work``: whether to include the frictional work, which is the most expensive output.
    """
    ih = STEP * 1j
    theta0, ratio = theta0 + ih * (name == "theta0"), ratio + ih * (name == "stiffness_ratio")
    out: dict[str, Array] = {key: np.zeros(theta0.size, complex) for key in Moved._fields}
    # designs that do not engage stay at theta0
    engaged = np.isfinite(found.load_e)
    out["theta_end"], out["theta_c"] = theta0.copy(), theta0.copy()
    out["load_e"][~engaged] = out["load_end"][~engaged] = complex(0, np.nan)
    for index, t in tracks:
        moved = move(t, seed(t, name, sign), with_work=work)
        for key, values in zip(Moved._fields, moved, strict=True):
            out[key][index] = values
    out["torque"] = out["scales"] + ratio * out["load_c"]
    lift = out["theta_c"] - theta0
    out["U_el"] = (ratio * out["load_c"] ** 2 + lift * lift) / 2
    total = out["U_el"] + out["W_fr"]
    out["RED"] = np.divide(out["W_fr"], total, out=np.zeros_like(total), where=total.real > 0)
    return {key: value.imag / STEP for key, value in out.items()}
