"""Trade-offs: the Pareto front of two or more figures, by NSGA-II (pymoo) over the batch engine."""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from squama import checks
from squama._version import __version__
from squama.design import Beam
from squama.errors import InputError
from squama.inverse import read
from squama.inverse.objectives import NAMES, Settings, Trade, dominated, settings
from squama.inverse.schema import fail
from squama.inverse.target import Target, read_target
from squama.model.outcome import CODES
from squama.model.solve import Array
from squama.study.parameters import PARAMETERS

if TYPE_CHECKING:
    import xarray as xr

BATCH = 4
"""Populations of offspring that are made and evaluated at once: the batch engine is quicker with more at a time."""
NEAR = 0.002
"""A design counts as new on the front where it is better than what is there by this share of the front's range."""


def pareto(
    target: str | os.PathLike[str] | Mapping[str, Any],
    *,
    beam: Beam | None = None,
    population: int | None = None,
    generations: int | None = None,
    seed: int | None = None,
) -> xr.Dataset:
    """Find the beams of which none is better in one objective without being worse in another.

    Parameters
    ----------
    target, beam
        As in :func:`squama.inverse_design`; a table ``front`` names the objectives in its lists ``maximise`` and
        ``minimise``: ``tangent`` and ``torque`` (at the twist ``at``), ``stiffness``, ``range``, ``lock``,
        ``engagement``, ``W_fr``, ``RED``, ``critical_mu``. A table ``target`` is not looked at.
    population, generations, seed
        Of NSGA-II, in place of the target's (200, 100, 1): population times generations beams are evaluated.

    Returns
    -------
    xarray.Dataset
        Dimension ``design``, sorted by the first objective: the objectives, the varied dimensions (SI, named
        ``scale.length`` ...), ``end`` and the twist ``rate_end`` there. Every design is a beam that keeps all limits,
        has all figures, and whose plates meet nowhere else before; attributes hold the starting beam.

    Raises
    ------
    InputError
        One line per mistake; also if pymoo (extra fit) is not installed, or no beam within the bounds keeps all limits.

    Examples
    --------
    >>> import squama
    >>> front = squama.pareto(
    ...     {
    ...         "vary": {"scale.length": ("40 mm", "70 mm"), "scale.alpha": ("40 deg", "60 deg")},
    ...         "front": {"maximise": ["range", "RED"], "population": 20, "generations": 5},
    ...     },
    ...     beam=squama.Beam.from_ratios(mu=0.3),
    ... )
    >>> sorted(map(str, front.data_vars))
    ['RED', 'end', 'range', 'rate_end', 'scale.alpha', 'scale.length']
    """
    return trade(read_target(target, beam=beam, need="front"), population, generations, seed)


def trade(
    target: Target, population: int | None = None, generations: int | None = None, seed: int | None = None
) -> xr.Dataset:
    """Return what :func:`pareto` returns, for a target that was read."""
    if find_spec("pymoo") is None:
        checks.fail("pareto: pymoo is not installed; pip install squama[fit]")
    assert target.front is not None
    given = {"population": population, "generations": generations, "seed": seed}
    table = target.front.model_copy(update={k: v for k, v in given.items() if v is not None})
    context = read.Context(target.space.beam.scales, target.space.load, bare=not target.source)
    try:
        chosen = settings(table, context)
    except InputError as error:
        fail(str(error).splitlines(), target.source)
        raise
    y, values = search(Trade(target, chosen), chosen)
    if not len(y):
        tried = chosen.population * chosen.generations
        line = f"front: none of {tried} beams within the bounds has all these figures and keeps all limits"
        fail([f"{line}; widen the bounds, ease the limits, or raise population"], target.source)
    return _dataset(target, chosen, y, values)


class Archive:
    """All designs so far that no other dominates, each tested for every contact of its plates."""

    def __init__(self, trade: Trade) -> None:
        self.trade = trade
        k = len(trade.chosen.objectives)
        self.y, self.costs, self.values = np.empty((0, len(trade.space.variables))), np.empty((0, k)), np.empty((0, k))

    def ask(self, y: Array) -> tuple[Array, Array]:
        """Return costs (n, k), less is better, and violations (n,) of designs; keep the good ones."""
        seen = self.trade.evaluate(y, plates=False)
        values, violation = seen.values, seen.violation
        costs = self.trade.costs(values)
        # testing plates against each other takes longest: only what comes to the front by more than NEAR is tested
        new = np.flatnonzero(violation <= 0)
        near = NEAR * np.ptp(self.costs, axis=0) if len(self.costs) else 0.0
        new = new[~dominated(costs[new], self.costs - near)]
        new = new[~dominated(costs[new], costs[new])]
        if new.size:
            same = self.trade.alone(seen, new)
            if not same.all():
                # another contact comes first: what is left of the design is what counts
                short = new[~same]
                violation[short] = self.trade.evaluate(y[short], plates=True).violation
            new = new[violation[new] <= 0]
        if new.size:
            stay = ~dominated(self.costs, costs[new])
            for name, rows in (("y", y), ("costs", costs), ("values", values)):
                setattr(self, name, np.vstack([getattr(self, name)[stay], rows[new]]))
        return costs, violation


def search(trade: Trade, chosen: Settings) -> tuple[Array, Array]:
    """Return points of the front (n, m) and their objectives (n, k), as many as the population at most."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    archive = Archive(trade)

    class Wrapped(Problem):  # type: ignore[misc]
        def _evaluate(self, x: Array, out: dict[str, Any], *_: Any, **__: Any) -> None:
            out["F"], violation = archive.ask(np.clip(x, 0.0, 1.0))
            out["G"] = violation[:, None]

    problem = Wrapped(n_var=len(trade.space.variables), n_obj=len(chosen.objectives), n_ieq_constr=1, xl=0.0, xu=1.0)
    batch = min(BATCH, chosen.generations)
    algorithm = NSGA2(chosen.population, n_offsprings=batch * chosen.population, eliminate_duplicates=False)
    evaluations = ("n_eval", chosen.generations * chosen.population)
    minimize(problem, algorithm, evaluations, seed=chosen.seed, verbose=False)
    keep = spread(archive.costs, chosen.population)
    return archive.y[keep], archive.values[keep]


def spread(costs: Array, most: int) -> Array:
    """Return which points to keep: drop the most crowded one after the other until there are ``most``."""
    unique = np.unique(costs, axis=0, return_index=True)[1]
    left = np.sort(unique)
    width = np.maximum(np.ptp(costs, axis=0), 1e-300) if len(costs) else 1.0
    while left.size > most:
        c = costs[left] / width
        crowd = np.zeros(left.size)
        for column in c.T:
            order = np.argsort(column, kind="stable")
            gaps = np.full(left.size, np.inf)
            gaps[1:-1] = column[order][2:] - column[order][:-2]
            crowd[order] += gaps
        drop = max(1, (left.size - most) // 8)
        left = np.sort(left[np.argsort(crowd, kind="stable")[drop:]])
    return left


def _dataset(target: Target, chosen: Settings, y: Array, values: Array) -> xr.Dataset:
    import xarray as xr

    order = np.argsort(values[:, 0], kind="stable")
    y, values = y[order], values[order]
    space = target.space
    seen = Trade(target, chosen).evaluate(y, plates=True)
    c, found = seen.cells, seen.found
    variables: dict[str, Any] = {}
    for o, column in zip(chosen.objectives, values.T, strict=True):
        unit, words, _ = NAMES[o.name]
        about = {"units": unit, "long_name": words, "objective": o.word}
        variables[o.name] = ("design", column, about | ({"at": chosen.given} if o.want.at else {}))
    for v in space.variables:
        symbol = PARAMETERS[v.key].symbol
        variables[v.name] = (
            "design",
            space.values(y)[v.key],
            {"units": symbol.unit, "long_name": symbol.long_name, "low": v.low, "high": v.high},
        )
    ends = np.array([str(e) for e in CODES])[found.code]
    variables["end"] = ("design", ends, {"long_name": "how the curve ends"})
    variables["rate_end"] = ("design", found.load_end / c.d, {"units": "rad/m", "long_name": "twist rate at the end"})
    attrs = {
        "title": "Pareto front of scale-covered beams",
        **{name: getattr(target.options, name) for name in ("load", "law", "sense", "margin")},
        "objectives": [f"{o.word} {o.name}" for o in chosen.objectives],
        "population": chosen.population,
        "generations": chosen.generations,
        "seed": chosen.seed,
        "start": space.beam.to_toml(),
        "squama_version": __version__,
    }
    return xr.Dataset(variables, coords={"design": np.arange(1, len(y) + 1)}, attrs=attrs)


def beams(front: xr.Dataset) -> list[Beam]:
    """Return the beams of a front, in its order.

    Examples
    --------
    >>> import xarray as xr
    >>> start = Beam.from_ratios(mu=0.3)
    >>> front = xr.Dataset({"scale.length": ("design", [0.05])}, attrs={"start": start.to_toml()})
    >>> beams(front)[0].scale.length
    0.05
    """
    start = Beam.from_toml_text(front.attrs["start"])
    names = [str(name) for name in front.data_vars if "." in str(name)]
    found = []
    for i in range(front.sizes["design"]):
        changes: dict[str, Any] = {}
        for name in names:
            table, _, key = name.partition(".")
            value = float(front[name].values[i])
            if table == "beam":
                changes[key] = value
            else:
                changes.setdefault(table, {})[key] = value
        found.append(start.replace(**changes))
    return found
