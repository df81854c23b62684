"""Free vibration of designs given by ratios: hinged scales, in units of K_theta and the pitch."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.arrays import solution
from squama.beam.faces import FACES, FacesName, sense
from squama.dynamics import hinge_branches
from squama.dynamics.branches import APART, Side
from squama.dynamics.decay import BEYOND, RINGS, Sides, damping, decay
from squama.errors import refuse
from squama.loads import MODES, LawName, LoadName, ModeName
from squama.types import Array

AT_ONCE = 1024
"""Designs whose branches are worked on together: what they need stays in the processor's cache."""


class FreeVibration(NamedTuple):
    """A decay; arrays of the designs' broadcast shape, with a last dimension for cycles. NaN beyond its end.

    ``peaks`` and ``troughs`` (rad per pitch, signed), ``peak_times`` and ``trough_times`` (1/omega0), ``zeta`` of each
    cycle by the elastic energy at its peaks; ``end``: "rings" (all cycles), "jams" (it stays at ``rest``),
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
    beta: ArrayLike | None = None,
    lam: ArrayLike | None = None,
    alpha: ArrayLike | None = None,
    theta0: ArrayLike,
    mu: ArrayLike,
    kappa: ArrayLike,
    amplitude: ArrayLike | None = None,
    impulse: ArrayLike | None = None,
    thickness: ArrayLike = 0.0,
    swings: int = 8,
    load: LoadName = "twisting",
    mode: ModeName = "uniform",
    law: LawName = "edge",
    faces: FacesName = "one",
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
    faces
        Which of the bar's faces have scales, as of :class:`squama.Beam`; where scales do not close by their tips the
        bar is taken as bare.

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
    arguments.one_of("faces", faces, tuple(FACES))
    if mode != "uniform" and kind.sided:
        refuse("mode", f'"{mode}"', "is a mode of bending", 'write load="bending"')
    if (amplitude is None) == (impulse is None):
        refuse("amplitude, impulse", "", "needs exactly one of the two", "write e.g. amplitude=0.2")
    given = amplitude if impulse is None else impulse
    assert given is not None
    asked = {"eta": eta, "beta": beta, "lam": lam, "alpha": alpha, "theta0": theta0, "mu": mu, "kappa": kappa}
    asked |= {"thickness": thickness, "amplitude" if impulse is None else "impulse": given}
    columns, shape = arguments.designs(load, **asked)
    named = dict(zip(asked, columns, strict=True))
    arguments.thin(named["thickness"], arguments.law(law), load)
    n = arguments.whole("swings", swings, 1, 10_000)
    law = kind.law(law)
    sol = solution.solve(named, load=kind.name, law=law, sense="+")
    given, kappa = columns[-1], named["kappa"]
    # scales of the other face that see the same sense work together, those that see the other one take turns
    seen = sense(faces, kind.axis, float(named["alpha"].max(initial=0.0)))
    turns = np.full((3, 2 * n + 1, given.size), np.nan)
    end, rest, energy = np.full(given.size, RINGS, "<U6"), *np.full((2, given.size), np.nan)
    for index, side in _groups(sol, named["mu"], kappa / 2 if seen > 0 else kappa, given, law, mode):
        # a swing that passes 0 with a speed goes no further than without scales
        both = Sides(side, side if seen < 0 else APART)
        over = (given[index] > side.last * (1 + 1e-12)) & (impulse is None)
        how = {"speed": given[index]} if impulse is not None else {"start": np.minimum(given[index], side.last)}
        made = decay(both, **how, turns=2 * n + 1)
        turns[:, :, index] = np.where(over, np.nan, made[:3])
        end[index], rest[index] = np.where(over, BEYOND, made.end), np.where(over, np.nan, made.rest)
        energy[index] = np.where(~over & (made.end == BEYOND), made.energy * kappa[index], np.nan)
    zeta = damping(turns[2, ::2])
    peaks, troughs = slice(0, None, 2), slice(1, None, 2)
    rows = (turns[1, peaks], turns[1, troughs], turns[0, peaks], turns[0, troughs], zeta)
    along = [np.moveaxis(v.reshape(len(v), *shape), 0, -1) for v in rows]
    return FreeVibration(*along, *(v.reshape(shape) for v in (end, rest, energy)))


def _groups(
    sol: solution.Solution, mu: Array, kappa: Array, given: Array, law: str, mode: str
) -> Iterator[tuple[Array, Side]]:
    """Return designs in groups, and their branches as far as they are needed."""
    # where nothing touches, or what is given does not engage, the bar is linear
    bare = np.where(sol.found.code == solution.TOUCHING, 0.0, np.inf)
    for every, track in sol.tracks:
        whole = hinge_branches.Paths.solved(track, law, mu[every], kappa[every])
        engages = given[every] > sol.found.load_e[every]
        bare[every] = np.where(engages, track.load_end, np.inf)
        far = np.flatnonzero(engages & (whole.x1 > whole.x0))
        for low in range(0, far.size, AT_ONCE):
            some = far[low : low + AT_ONCE]
            index = every[some]
            bare[index] = np.nan
            for own, side in hinge_branches.sides(whole.take(some).up_to(given[index]), mode):
                yield index[own], side
    index = np.flatnonzero(~np.isnan(bare))
    if index.size:
        yield index, APART._replace(last=bare[index])
