"""Free vibration of designs given by ratios: hinged scales, in units of K_theta and the pitch."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.arrays import solution
from squama.curves import hinge
from squama.curves.path import Case
from squama.dynamics import branches
from squama.dynamics.branches import APART
from squama.dynamics.decay import BEYOND, Decay, Sides, damping, decay
from squama.errors import refuse
from squama.loads import MODES
from squama.types import Array


class FreeVibration(NamedTuple):
    """A decay; arrays of the designs' broadcast shape, with a last dimension for cycles. NaN beyond its end.

    ``peaks`` and ``troughs`` (rad per pitch, signed), ``peak_times`` and ``trough_times`` (1/omega0), ``zeta`` of each
    cycle by the elastic energy at its peaks; ``end``: "rings" (as many cycles as asked), "jams" (it stays at ``rest``),
    "beyond" (a swing has more energy than the model can take up; it had ``energy``, over K_theta per pitch).
    """

    peaks: Array
    troughs: Array
    peak_times: Array
    trough_times: Array
    zeta: Array
    end: Array
    rest: Array
    energy: Array


def free_vibration(
    *,
    eta: ArrayLike,
    beta: ArrayLike,
    lam: ArrayLike,
    alpha: ArrayLike,
    theta0: ArrayLike,
    mu: ArrayLike,
    kappa: ArrayLike,
    amplitude: ArrayLike | None = None,
    impulse: ArrayLike | None = None,
    thickness: ArrayLike = 0.0,
    swings: int = 8,
    load: str = "twisting",
    mode: str = "uniform",
    law: str = "edge",
    sides: str = "one",
) -> FreeVibration:
    """Let beams of hinged scales swing: peaks, times and damping of every cycle, without steps in time.

    Parameters
    ----------
    eta, beta, lam, alpha, theta0, mu, thickness
        As in :func:`squama.solve`; broadcast against each other.
    kappa
        C_f J G_B/(K_theta d) of the bar without contact (E_B I/(K d) in bending); above 0.
    amplitude
        Load angle per pitch (rad) from which the beam is let go; in a mode the largest along the beam.
    impulse
        Or its rate where it passes 0, rad per pitch and per 1/omega0.
    swings
        Number of cycles.
    load
        "twisting" or "bending".
    mode
        "uniform" (a rotor at the end); in bending also "simply supported" or "cantilever", the first mode.
    law
        "edge" or "plate".
    sides
        Scales on "one" side (in the other sense the bar is taken as bare) or on "both".

    Returns
    -------
    FreeVibration

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import numpy as np, squama
    >>> v = squama.free_vibration(
    ...     eta=3, beta=1.25, lam=0.45, alpha=np.pi / 4, theta0=np.radians(10), mu=0.5, kappa=2, amplitude=0.22
    ... )
    >>> print(np.round(v.peaks[:3], 5), np.round(v.zeta[:2], 4))
    [0.22    0.16359 0.13096] [0.0685 0.0518]
    """
    kind = arguments.load(load)
    arguments.one_of("mode", mode, MODES)
    arguments.one_of("sides", sides, ("one", "both"))
    if mode != "uniform" and kind.sided:
        refuse("mode", f'"{mode}"', "is one of bending", 'write load="bending"')
    if (amplitude is None) == (impulse is None):
        refuse("amplitude, impulse", "", "one of them is to be given", "write e.g. amplitude=0.2")
    given = amplitude if impulse is None else impulse
    assert given is not None
    columns, shape = arguments.designs(
        load, eta=eta, beta=beta, lam=lam, alpha=alpha, theta0=theta0, mu=mu, kappa=kappa, thickness=thickness,
        **{"amplitude" if impulse is None else "impulse": given},
    )  # fmt: skip
    arguments.thin(columns[7], arguments.law(law), load)
    n = arguments.whole("swings", swings, 1, 10_000)
    named = dict(zip((*solution.COLUMNS, "kappa", "thickness"), columns, strict=False))
    law = kind.law(law)
    sol = solution.solve(named, load=kind.name, law=law, sense="+")
    found = []
    for i, value in enumerate(columns[-1].tolist()):
        one = {name: float(column[i]) for name, column in named.items()}
        case = Case(1.0, one["kappa"], 1.0, one["eta"], one["theta0"])
        path = hinge.path(case, sol.one(i), None, one["mu"], law, branches.FINEST)
        found.append(_one(path, one["kappa"], value, mode, n, pushed=impulse is not None, both=sides == "both"))
    peaks, troughs = slice(0, None, 2), slice(1, None, 2)
    turns = np.array([_filled(one, 2 * n + 1) for one in found]).reshape(*shape, 3, 2 * n + 1)
    t, y, stored = (turns[..., i, :] for i in range(3))
    ends, rest, energy = (np.array([getattr(one, name) for one in found]).reshape(shape)
                          for name in ("end", "rest", "energy"))  # fmt: skip
    return FreeVibration(
        y[..., peaks], y[..., troughs], t[..., peaks], t[..., troughs], damping(stored[..., peaks]), ends, rest, energy
    )


def _filled(one: Decay, size: int) -> Array:
    """Return times, angles and energies of turning points, NaN beyond the end."""
    rows = np.full((3, size), np.nan)
    rows[:, : one.t.size] = one.t, one.y, one.stored
    return rows


def _one(path: hinge.Path, kappa: float, given: float, mode: str, swings: int, *, pushed: bool, both: bool) -> Decay:
    """Return the decay of one design; what it had too much of energy is over K_theta."""
    # a swing that passes 0 with a speed goes no further than without scales
    plus = branches.modal(branches.of_path(path, kappa, given), mode)
    found = Sides(plus, plus if both else APART)
    if not pushed and given > plus.last * (1 + 1e-12):
        return Decay.of([], BEYOND, math.nan, math.nan)
    how = {"speed": given} if pushed else {"start": min(given, plus.last)}
    made = decay(found, **how, turns=2 * swings + 1)
    return made._replace(energy=made.energy * kappa if made.end == BEYOND else math.nan)
