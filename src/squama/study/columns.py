"""From dimensions of a beam to the columns of the batch engine, for many designs at once.

:func:`columns` is :func:`squama.study.cells.cells` with the laws of joint and section in array form: a million designs
a second, and a complex step goes through it. :func:`solved` hands the columns to the engine, :func:`in_si` gives its
answers their units, :func:`valid` tells which rows are a beam at all, :func:`squama.study.cells.beam_at` builds one.
Names of the values are those of :data:`squama.study.parameters.PARAMETERS` or its aliases (``scale.alpha``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from squama.design import Beam
from squama.engines import Solved, solve
from squama.model import reach, section
from squama.model.solve import Array
from squama.study.cells import Cells, cells
from squama.study.parameters import PARAMETERS, canonical

_ARRAYS: dict[Callable[..., Any], Callable[..., Any]] = {section.torsion_constant: section.torsion_constants}
"""Array form of the laws that are not of one form for numbers and arrays."""


def _whole(law: Callable[..., Any], *arguments: Array) -> Array:
    """Evaluate a law for whole arrays."""
    return np.asarray(_ARRAYS.get(law, law)(*arguments))


def columns(beam: Beam, values: Mapping[str, Any], *, load: str = "twisting") -> Cells:
    """Return the designs of a beam with some values replaced.

    Parameters
    ----------
    beam : Beam
        The beam; what is not replaced stays as it is.
    values : mapping
        Numbers or arrays that broadcast, by name, SI units. Nothing is checked; see :func:`valid`.
    load : {"twisting", "bending"}
        Which laws of joint and section apply.

    Returns
    -------
    Cells
        Columns ``eta``, ``beta``, ``lam``, ``alpha``, ``theta0``, ``mu``, ``K`` (N m), ``d`` (m), ``rigidity`` (N m^2),
        ``ratio``, and ``sizes`` by table and key. Complex where values are complex.

    Examples
    --------
    >>> c = columns(Beam.from_ratios(mu=0.3), {"beam.pitch": np.array([0.0177, 0.02])})
    >>> print(c.eta.round(3), c.rigidity.shape)
    [3.013 2.667] (2,)
    """
    named = {canonical(name): value for name, value in values.items()}
    with np.errstate(all="ignore"):
        return cells(beam, load, named, each=_whole)


def solved(
    c: Cells,
    *,
    law: str = "edge",
    sense: str = "+",
    margin: float = 0.01,
    load: str = "twisting",
    engine: str = "auto",
) -> Solved:
    """Solve columns with the batch engine; arguments and result as of :func:`squama.solve`.

    Raises
    ------
    InputError
        A row is no beam (see :func:`valid`).
    """
    return solve(
        eta=c.eta,
        beta=c.beta,
        lam=c.lam,
        alpha=c.alpha,
        theta0=c.theta0,
        mu=c.mu,
        stiffness_ratio=c.ratio,
        law=law,
        sense=sense,
        margin=margin,
        load=load,
        engine=engine,
    )


def in_si(c: Cells, s: Solved) -> dict[str, Array]:
    """Return the answers of the engine by the names of :class:`squama.Solved`, with their units.

    Torque in N m, energies in J/m; twists stay in rad per pitch (divide by ``c.d`` for rates). A joint without
    stiffness leaves the beam as it is without contact.
    """
    found: dict[str, Array] = s._asdict()
    per_length = c.K / c.d
    found |= {"torque": s.torque * c.K, "U_el": s.U_el * per_length, "W_fr": s.W_fr * per_length}
    if not np.all(c.K > 0):
        bare = np.broadcast_to(c.K > 0, np.broadcast_shapes(c.K.shape, s.torque.shape)) == 0
        rate = s.load_c / c.d
        found["torque"] = np.where(bare, c.rigidity * rate, found["torque"])
        found["U_el"] = np.where(bare, c.rigidity * rate**2 / 2, found["U_el"])
        found["RED"] = np.where(bare, 0.0, s.RED)
    return found


def valid(c: Cells) -> Array:
    """Tell which rows :class:`squama.Beam` would take: every value in its bounds, eta and beta, the tab inside.

    Returns
    -------
    array of bool
        In the broadcast shape of the columns.
    """
    with np.errstate(all="ignore"):
        good = (c.eta <= reach.MOST) & (c.beta <= reach.MOST)
        good = good & (c.sizes["scale"]["embedded"] * np.sin(c.theta0) < c.sizes["substrate"]["thickness"])
        held = {f"{table}.{key}": value for table, content in c.sizes.items() for key, value in content.items()}
        held |= {"scale.alpha": c.alpha, "scale.theta0": c.theta0, "mu": c.mu, "beam.pitch": c.d}
        for name, value in held.items():
            low, high, _, closed, _ = PARAMETERS[canonical(name)].bounds
            good = good & ((value >= low) & (value <= high) if closed else (value > low) & (value < high))
        # a soft joint may be 0 with no embedded part; one that is not finite is none
        good = good & np.isfinite(c.K) & np.isfinite(c.rigidity) & (c.K >= 0)
    return np.asarray(np.broadcast_to(good, np.broadcast_shapes(good.shape, c.eta.shape, c.K.shape)))
