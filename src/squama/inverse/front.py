"""Trade-offs: the Pareto front of two or more figures, each as large or small as possible, by NSGA-II (pymoo)."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from contextlib import suppress
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import arguments
from squama._version import __version__
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.curves.chosen import idealisation
from squama.errors import InputError, Problems, refuse
from squama.inverse import joint_figures, limits
from squama.inverse.named_figures import AT_TWIST, OF_BEAM, OF_LOCKS, At, Found, Want
from squama.inverse.search import sobol
from squama.inverse.space import built
from squama.inverse.target import Target, read_target
from squama.inverse.targetfile import Context, Table, twist
from squama.io.tabular import guess
from squama.loads import ENDLESS, FREE, STRAIGHT
from squama.model.outcome import named
from squama.progress import steps, work
from squama.study.columns import Cells, valid
from squama.study.compliant_columns import ENDS
from squama.study.parameters import ALIASES, PARAMETERS
from squama.types import Array
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

BATCH = 4
"""Populations of offspring that are evaluated together, because larger batches are faster."""
NEAR = 0.002
"""Least improvement of a design that is tested for the front, as a share of the front's range."""
DECADES = ("tangent", "torque", "stiffness", "stiffness_ratio", "W_fr")
"""Objectives that span decades: the search takes their logarithm."""
OBJECTIVES = {
    "hinge": {name: AT_TWIST[name] for name in ("tangent", "torque")}
    | {name: OF_BEAM[name] for name in ("stiffness", "engagement")}
    | OF_LOCKS,
    "compliant": AT_TWIST | OF_BEAM,
}
"""Figures that may be traded off, by the joint."""
AGREES = 0.02
"""Relative deviation allowed between a figure in the search and in the beam's own curve with all contacts."""
SCREENED = 256
"""Least number of points within the bounds from which the first population is taken; else twice the population."""
NAMED = 3
"""Number of limits and figures that the message names where there is no front."""
MOST = 5
WAYS = {1: "max", -1: "min"}
"""Words for the better direction, by the sense of an objective."""


def pareto(
    target: str | os.PathLike[str] | Mapping[str, object] | Target,
    *,
    beam: Beam | None = None,
    population: int | None = None,
    generations: int | None = None,
    seed: int | None = None,
) -> xr.Dataset:
    """Find the beams of which none is better in one objective without being worse in another.

    The search takes beams as endless. Those with a number of scales are then judged by all of their scales, and the
    front is of the designs that remain undominated.

    Parameters
    ----------
    target, beam
        As in :func:`squama.inverse_design`; a table ``front`` names the objectives in its lists ``maximise`` and
        ``minimise``. On compliant joints ``tangent``, ``torque``, ``stiffness_ratio``, ``stress``, ``strength_share``,
        ``W_fr``, ``RED`` (at the twist ``at``), ``stiffness``, ``engagement``, ``length``. With one of ``range``,
        ``lock``, ``critical_mu`` (or ``W_fr``, ``RED`` without ``at``: up to the lock) the model is hinges, which also
        have ``tangent`` and ``torque`` at ``at``. A table ``target`` is ignored.
    population, generations, seed
        Settings of NSGA-II in place of the target's (200, 100, 1): population times generations beams are evaluated,
        after a screen of the bounds that supplies the first population.

    Returns
    -------
    xarray.Dataset
        Dimension ``design``, sorted by the first objective: the objectives, for beams with a number of scales also
        those of the endless beams (``torque_endless`` ...), the varied dimensions (SI, named ``scale.length`` ...),
        ``end`` and the twist ``rate_end`` there, of the endless beams. Every design is a beam that keeps all limits,
        has all figures, and whose plates meet nowhere else before; beams on compliant joints are rounded to dimensions
        that can be made and obey the rules of printer files. Attributes hold the starting beam.

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
    if beam is not None:
        arguments.beam(beam)
    target = target if isinstance(target, Target) else read_target(target, beam=beam, need="front")
    if find_spec("pymoo") is None:
        refuse("pareto", "", "pymoo is not installed", "pip install squama[fit]")
    assert target.front is not None
    given = {"population": population, "generations": generations, "seed": seed}
    table = {**target.front, **{k: v for k, v in given.items() if v is not None}}
    start, load = target.space.beam, target.space.load
    if not target.compliant:
        only_one(start.faces, "a front on hinges")
    context = Context(start.pitches, load, bare=not target.source, joint=target.options.joint)
    chosen = read_settings(table, context, target.source)
    trade = Trade(target, chosen)
    if target.own:
        # ends that the beam cannot have are refused before the search
        joint_figures.followed(start, [Want("engagement")], target.options)
    y, values, endless = search(trade, chosen)
    if not len(y):
        tried = chosen.population * chosen.generations
        reason = f"none of {tried} beams within the bounds has all these figures and keeps all limits"
        remedy = f"widen the bounds, ease the limits, or raise population; {trade.in_the_way()}"
        refuse("front", "", reason, remedy, target.source)
    return _dataset(target, chosen, y, values, endless)


class Objective(NamedTuple):
    """A figure to be maximised (``sense`` 1) or minimised (-1)."""

    name: str
    sense: int
    want: Want


class Settings(NamedTuple):
    """Objectives and settings of NSGA-II; ``at`` is the stated twist, ``given`` its text."""

    objectives: tuple[Objective, ...]
    population: int
    generations: int
    seed: int
    at: At | None
    given: str


def read_settings(table: Table, context: Context, source: str = "") -> Settings:
    """Read the table [front]; one InputError names all mistakes."""
    problems = Problems()
    known = OBJECTIVES[context.joint]
    at_twist = [name for name in known if known[name] == AT_TWIST.get(name)]
    at: At | None = None
    if table["at"] is not None:
        with problems.caught():
            at = twist("front.at", table["at"], context).at
    found: dict[str, Objective] = {}
    for key, sense in (("maximise", 1), ("minimise", -1)):
        names, where = table[key], f"front.{key}"
        if not isinstance(names, list | tuple):
            problems.add(where, shown(names), "is no list", f'write e.g. {key} = ["tangent", "range"]')
            continue
        for name in names:
            if name not in known:
                allowed = f"{guess(str(name), known)}allowed: {', '.join(known)}"
                problems.add(where, "", f"{shown(name)} is not known", allowed)
                continue
            if name in found:
                problems.add(where, "", f"{name} is given twice", "keep one")
            elif name in at_twist and table["at"] is None:
                problems.add("front.at", "", "is missing", f'{name} needs a twist, write e.g. at = "60 deg total"')
            found.setdefault(name, Objective(name, sense, Want(name, at if name in at_twist else None)))
    if not problems and not 2 <= len(found) <= MOST:
        remedy = f"give 2 to {MOST} in maximise and minimise"
        problems.add("[front]", "", f"names {len(found)} objectives", remedy)
    numbers: dict[str, int] = {}
    for key, low, high in (("population", 8, 10_000), ("generations", 1, 100_000), ("seed", 0, 2**31 - 1)):
        value = table[key]
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            problems.add(f"front.{key}", shown(value), f"is not a whole number from {low} to {high}")
        else:
            numbers[key] = value
    problems.settle(source)
    return Settings(tuple(found.values()), **numbers, at=at, given="" if at is None else str(table["at"]))


class Seen(NamedTuple):
    """Evaluated designs: objectives (n, k), violations (n,), figures, columns, and masks (n,) of what is ``broken``."""

    values: Array
    violation: Array
    found: Found
    cells: Cells
    broken: dict[str, Array]


class Trade:
    """Objectives and limits of many designs; ``best``: points (n, m), costs, objectives (n, k) of the front so far."""

    def __init__(self, target: Target, chosen: Settings) -> None:
        self.target, self.chosen = target, chosen
        self.space = target.space
        self.lock = "strain" in target.limits and not target.compliant
        self.wants = [o.want for o in chosen.objectives] + [Want("lock")] * self.lock
        m, k = self.space.start.size, len(chosen.objectives)
        self.best = [np.empty((0, n)) for n in (m, k, k)]

    def evaluate(self, y: Array, *, plates: bool) -> Seen:
        """Evaluate points (n, m) of the unit cube; ``plates``: test all plates for contact with each other."""
        c = self.space.cells(y)
        good = valid(c)
        found = self.target.figures(c, [], self.wants, plates=plates)
        k = len(self.chosen.objectives)
        values = found.values[:k].T
        if self.chosen.at is not None:
            # stiffness at a twist counts in contact only: "stiffness" is that before engagement
            apart = found.load_e >= self.chosen.at.per_pitch(c.d, c.sizes["beam"]["scales"])
            of_contact = np.array([o.name in ("tangent", "stiffness_ratio") for o in self.chosen.objectives])
            values[np.ix_(apart, of_contact)] = np.nan
        at = [] if self.chosen.at is None else [self.chosen.at]
        sizes = limits.Sizes.of(c, self.space.load, limits.farthest(c, at, found.values[-1] if self.lock else None))
        room = self.target.rooms(c, sizes)
        short = {name: np.maximum(-np.broadcast_to(v, len(y)), 0.0) for name, v in room.items()}
        missing = {f"no {o.name}": ~np.isfinite(v) for o, v in zip(self.chosen.objectives, values.T, strict=True)}
        violation = np.where(good, np.nan_to_num(sum(short.values()), nan=1.0), 2.0)
        violation += np.any([*missing.values()], axis=0)
        return Seen(values, violation, found, c, {name: v > 0 for name, v in short.items()} | missing)

    def costs(self, values: Array) -> Array:
        """Return objectives (n, k) as costs, less is better; logarithms of objectives that span decades."""
        columns = []
        for o, column in zip(self.chosen.objectives, values.T, strict=True):
            decades = o.name in DECADES
            good = np.isfinite(column) & ((column > 0) | (not decades))
            value = np.log(np.where(good, column, 1.0)) if decades else column
            columns.append(-o.sense * np.where(good, value, 0.0))
        return np.stack(columns, axis=1)

    def ask(self, y: Array) -> tuple[Array, Array]:
        """Return costs (n, k) and violations (n,) of points y (n, m); add good designs to ``best``."""
        values, violation = self.evaluate(y, plates=False)[:2]
        costs, there = self.costs(values), self.best[1]
        # the test of all plates takes longest: only designs that move the front by more than NEAR get it
        new = np.flatnonzero(violation <= 0)
        known = there - NEAR * np.ptp(there, axis=0) if len(there) else there
        first = undominated(np.vstack([known, costs[new]])) - len(known)
        new = new[first[first >= 0]]
        if new.size and not self.target.compliant:
            # where another contact comes first the curve ends earlier, which may break a limit or remove a figure
            violation[new] = self.evaluate(y[new], plates=True).violation
            new = new[violation[new] <= 0]
        if new.size:
            columns = zip(self.best, (y, costs, values), strict=True)
            every = [np.vstack([old, rows[new]]) for old, rows in columns]
            stay = undominated(every[1])
            self.best = [rows[stay] for rows in every]
        return costs, violation

    def screened(self) -> Array:
        """Return the starting beam and points spread over the bounds (n, m), in the unit cube."""
        start = self.space.start
        return np.vstack([start, sobol(max(SCREENED, 2 * self.chosen.population), start.size, self.chosen.seed)])

    def in_the_way(self) -> str:
        """Return the limits and figures that most beams within the bounds break or lack, as text."""
        shares = {name: float(v.mean()) for name, v in self.evaluate(self.screened(), plates=True).broken.items()}
        worst = sorted((name for name in shares if shares[name]), key=lambda name: -shares[name])[:NAMED]
        return f"most often missed: {', '.join(f'{name} ({shares[name]:.0%})' for name in worst)}"

    def made(self, y: Array) -> tuple[Array, Array, Array]:
        """Return the rounded beams that can be made and remain on a front.

        Points (n, m), objectives (n, k) of the beams' own scales, and of endless beams.
        """
        y = np.unique(self.space.nearest(y), axis=0)
        values, violation = self.evaluate(y, plates=True)[:2]
        kept = np.flatnonzero(violation <= 0)
        kept = kept[[self._sound(y[i], values[i]) for i in kept.tolist()]] if kept.size else kept
        endless = values[kept]
        own = np.array([self._own(y[i]) for i in steps(kept.tolist(), kept.size, "designs with their own scales")])
        found = own.reshape(endless.shape) if self.target.own else endless
        kept, found, endless = (v[np.isfinite(found).all(axis=1)] for v in (kept, found, endless))
        stay = undominated(self.costs(found))
        return y[kept[stay]], found[stay], endless[stay]

    def _own(self, y: Array) -> list[float]:
        """Return the objectives of a beam with its own number of scales and ends; none without a number.

        NaN where the model refuses them, as more scales than it follows between grips.
        """
        if not self.target.own:
            return []
        wants = [o.want for o in self.chosen.objectives]
        with suppress(InputError):
            return joint_figures.followed(self.space.beam_of(y), wants, self.target.options)[0]
        return [math.nan] * len(wants)

    def _sound(self, y: Array, values: Array) -> bool:
        beam, wants = self.space.beam_of(y), [o.want for o in self.chosen.objectives]
        if limits.refused(beam, self.target.printer):
            return False
        again, _ = joint_figures.followed(beam, wants, self.target.options, ends=ENDLESS)
        return bool(np.allclose(again, values, rtol=AGREES))


def search(trade: Trade, chosen: Settings) -> tuple[Array, Array, Array]:
    """Return points (n, m) and objectives (n, k) of the front, at most as many as the population.

    The objectives are those of the beams' own scales, then those of endless beams.
    """
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    asked = 0

    class Wrapped(Problem):  # type: ignore[misc]
        def _evaluate(self, x: Array, out: dict[str, Array], *_: object, **__: object) -> None:
            nonlocal asked
            out["F"], violation = trade.ask(np.clip(x, 0.0, 1.0))
            out["G"] = violation[:, None]
            tell(asked := asked + len(x))

    problem = Wrapped(n_var=trade.space.start.size, n_obj=len(chosen.objectives), n_ieq_constr=1, xl=0.0, xu=1.0)
    batch = min(BATCH, chosen.generations)
    first = trade.screened()
    first = first[np.argsort(trade.ask(first)[1], kind="stable")[: chosen.population]]
    more = batch * chosen.population
    algorithm = NSGA2(chosen.population, sampling=first, n_offsprings=more, eliminate_duplicates=False)
    most = chosen.generations * chosen.population
    with work("designs", most) as tell:
        minimize(problem, algorithm, ("n_eval", most), seed=chosen.seed, verbose=False)
    y, costs, values = trade.best
    keep = spread(costs, chosen.population)
    return trade.made(y[keep]) if trade.target.compliant else (y[keep], values[keep], values[keep])


def undominated(costs: Array) -> NDArray[np.int64]:
    """Return the indices of the points (n, k) that no other point dominates, ascending; less is better."""
    from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

    return np.sort(np.asarray(NonDominatedSorting().do(costs, only_non_dominated_front=True), int))


def spread(costs: Array, most: int) -> NDArray[np.int64]:
    """Return the indices of the points to keep: duplicates and the most crowded go until ``most`` are left."""
    from pymoo.operators.survival.rank_and_crowding.metrics import get_crowding_function

    left = np.sort(np.unique(costs, axis=0, return_index=True)[1])
    while left.size > most:
        room = get_crowding_function("cd").do(costs[left])
        left = np.sort(left[np.argsort(room, kind="stable")[max(1, (left.size - most) // 8) :]])
    return left


def _dataset(target: Target, chosen: Settings, y: Array, values: Array, endless: Array) -> xr.Dataset:
    import xarray as xr

    order, space = np.argsort(values[:, 0], kind="stable"), target.space
    y, values, endless = y[order], values[order], endless[order]
    seen = Trade(target, chosen).evaluate(y, plates=True)
    c, found = seen.cells, seen.found
    variables: dict[str, object] = {}
    for o, column, other in zip(chosen.objectives, values.T, endless.T, strict=True):
        unit, words = OBJECTIVES[target.options.joint][o.name]
        about: dict[str, object] = {"units": unit, "long_name": words, **({"at": chosen.given} if o.want.at else {})}
        variables[o.name] = ("design", column, about | {"objective": WAYS[o.sense]})
        if target.own:
            about["long_name"] = f"{words} (endless beam)"
            variables[f"{o.name}_endless"] = ("design", other, about)
    for v in space.variables:
        about = PARAMETERS[v.key].symbol.attrs | {"low": v.low, "high": v.high}
        variables[v.name] = ("design", [v.rounded(x) for x in space.values(y)[v.key].tolist()], about)
    for choice, share in zip(space.choices, y.T[len(space.variables) :], strict=True):
        words_of = np.array(choice.words)[choice.number(share)]
        variables[f"chosen.{choice.name}"] = ("design", words_of, {"long_name": "what is chosen"})
        for name in choice.options[0]:
            key = ALIASES.get(name, name)
            variables[name] = ("design", space.values(y)[key], PARAMETERS[key].symbol.attrs)
    ends = np.array(ENDS)[found.code] if target.compliant else named(found.code)
    variables["end"] = ("design", ends, {"long_name": "how the curve ends"})
    variables["rate_end"] = ("design", found.load_end / c.d, {"units": "rad/m", "long_name": "twist rate at the end"})
    attrs = {
        "title": "Pareto front of scale-covered beams",
        **{name: getattr(target.options, name) for name in ("load", "law", "sense", "margin")},
        "joint": target.options.joint,
        "hold": space.beam.holding if target.compliant else STRAIGHT,
        "scales": idealisation(space.beam, target.options.joint, ideal=not target.compliant),
        **({"ends": space.beam.ends or FREE} if target.own else {}),
        "objectives": [f"{WAYS[o.sense]} {o.name}" for o in chosen.objectives],
        **{name: getattr(chosen, name) for name in ("population", "generations", "seed")},
        "start": space.beam.to_toml(),
        "squama_version": __version__,
    }
    return xr.Dataset(variables, coords={"design": np.arange(1, len(y) + 1)}, attrs=attrs)


def beams(front: xr.Dataset) -> list[Beam]:
    """Return the beams of a front, in its order.

    >>> import xarray as xr
    >>> start = Beam.from_ratios(mu=0.3)
    >>> front = xr.Dataset({"scale.length": ("design", [0.05])}, attrs={"start": start.to_toml()})
    >>> beams(front)[0].scale.length
    0.05
    """
    start = Beam.from_toml_text(front.attrs["start"])
    names = [str(name) for name in front.data_vars if "." in str(name) and not str(name).startswith("chosen.")]
    columns = zip(*(front[name].values.tolist() for name in names), strict=True)
    return [built(start, dict(zip(names, row, strict=True))) for row in columns]
