"""From a target to designs: read, screen, refine, choose, report."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from squama import checks, response
from squama._version import __version__
from squama.design import Beam
from squama.errors import InputError
from squama.inverse import search, tolerance
from squama.inverse.goals import within
from squama.inverse.limits import LIMITS, Sizes
from squama.inverse.problem import Look, Problem
from squama.inverse.results import Design, InverseDesign, Reached
from squama.inverse.space import FULL, of_beam
from squama.inverse.target import Target, read_target
from squama.model.solve import Array
from squama.study.parameters import text_of
from squama.units import as_text

REFINED = 36
"""Starts that are refined."""
BROKEN = 1e-7
"""A limit that is broken by more than this share counts as broken."""
ACTIVE = 1e-6
"""Bounds and limits nearer than this, in the unit cube and relative, are active."""
DISTINCT = (0.25, 0.1)
"""Least distance of two designs that are both returned: the largest difference of a variable, of its range. The second
holds where there are too few designs as far apart as the first."""
WORSE = 2.0
"""Designs that miss the target are returned up to this times the least merit."""


def inverse_design(
    target: str | os.PathLike[str] | Mapping[str, Any],
    *,
    beam: Beam | None = None,
    designs: int | None = None,
    starts: int = 4096,
    seed: int = 1,
) -> InverseDesign:
    """Find beams that do what is asked: lock at a twist, follow a torque-twist curve, dissipate, stay soft before.

    Parameters
    ----------
    target : path or mapping
        A TOML file, or the same as nested mappings: ``target`` (what is asked), ``vary`` (bounds by dimension),
        ``limits``, ``tolerance``; and ``start`` or the tables of a beam. See docs, how-to: design a beam.
    beam : Beam, optional
        Starting beam, in place of that of the target; what is not varied stays as it is there.
    designs : int, optional
        How many distinct designs at most, in place of the target's (5).
    starts : int
        Points of the bounds that are screened.
    seed : int
        Of the screen's Sobol sequence.

    Returns
    -------
    InverseDesign
        Distinct designs, the best first: those that meet the target ranked by how little their tolerances matter, or,
        where none does, the nearest attainable ones.

    Raises
    ------
    InputError
        One line per mistake; also if no beam within the bounds keeps all limits.

    Examples
    --------
    >>> import squama
    >>> found = squama.inverse_design(
    ...     {"target": {"lock": "0.25 rad/pitch"}, "vary": {"scale.length": ("40 mm", "70 mm")}},
    ...     beam=squama.Beam.from_ratios(mu=0.5),
    ... )
    >>> print(found.met, f"{1e3 * found[0].beam.scale.length:.2f} mm")
    True 57.77 mm
    """
    return find(read_target(target, beam=beam), designs=designs, starts=starts, seed=seed)


def find(target: Target, *, designs: int | None = None, starts: int = 4096, seed: int = 1) -> InverseDesign:
    """Return what :func:`inverse_design` returns, for a target that was read."""
    count = checks.whole("designs", target.designs if designs is None else designs, 1, 100)
    starts, seed = checks.whole("starts", starts, 16, 1 << 20), checks.whole("seed", seed, 0, 2**31)
    problem = Problem(target)
    space = target.space
    first = space.place({v.key: of_beam(space.beam, space.load, v.key) for v in space.variables})
    y = search.screen(problem, first, starts, REFINED, seed)
    if not len(y):
        line = "vary: no point within the bounds is a beam; look at the depth of the tab and at l/d and b/d"
        raise InputError(_prefixed(target, line))
    look = problem.look(y, slopes=True, plates=True)
    idle = _idle(look)
    if idle.size:
        # as in the starting beam, unless the figures are then gone
        still = y.copy()
        still[:, idle] = first[idle]
        same = problem.look(still, slopes=False, plates=True).merit <= look.merit * (1 + 1e-9)
        y[same] = still[same]
    look = search.refine(problem, y)
    limits = look.g[: len(look.g) - len(problem.inside)]
    kept = np.flatnonzero((limits >= -BROKEN).all(axis=0) & np.isfinite(look.merit))
    if not kept.size:
        raise InputError(_prefixed(target, _broken(problem, look)))
    effects = tolerance.effects(problem, look.y)
    chosen, met = _choose(problem, look, effects, kept, count)
    found = tuple(_design(problem, look, effects, int(i), bool(met[i])) for i in chosen)
    notes = [f"{space.variables[int(j)].name} has no effect on what is asked" for j in idle]
    sizes = tolerance.sizes(problem, look.y[chosen[:1]])
    return InverseDesign(
        source=target.source,
        met=found[0].met,
        designs=found,
        bounds={v.name: (v.low, v.high) for v in space.variables},
        tolerance={FULL.get(key, key): float(size[0]) for key, size in sizes.items()},
        settings={
            **target.options._asdict(),
            "accept": target.accept,
            "limits": dict(target.limits),
            "joint_law": bool(target.laws),
            "starts": starts,
            "refined": len(y),
            "seed": seed,
            "squama_version": __version__,
        },
        notes=tuple(notes),
    )


def _idle(look: Look) -> Array:
    """Return the variables that no figure depends on, as far as there are starts that have all figures."""
    whole = np.isfinite(look.found.values).all(axis=0)
    if not whole.any():
        return np.empty(0, int)
    return np.flatnonzero(~look.found.slopes[..., whole].any(axis=(0, 2)))


def _prefixed(target: Target, line: str) -> str:
    return f"{target.source}: {line}" if target.source else line


def _broken(problem: Problem, look: Look) -> str:
    """Say which limits no beam within the bounds keeps together."""
    least = np.maximum(-look.g[: len(look.g) - len(problem.inside)], 0).sum(axis=0)
    i = int(np.argmin(np.where(np.isfinite(look.merit), least, np.inf)))
    names = zip(problem.names[: -len(problem.inside) or None], look.g[:, i], strict=False)
    words = [_limit_words(problem, name, look, i) for name, g in names if g < -BROKEN]
    return f"limits: no beam within the bounds keeps them all; the nearest breaks {' and '.join(words)}"


def _limit_words(problem: Problem, name: str, look: Look, i: int) -> str:
    """Return a limit with its value and what a design has."""
    if name not in LIMITS:
        return f"joint_law ({name})"
    limit, value = LIMITS[name], problem.target.limits[name]
    c = problem.space.cells(look.y[i : i + 1])
    s = Sizes.of(c, problem.space.beam.scales, problem.space.load, problem.rate(c, look.found.values[:, i : i + 1]))
    has = float(np.ravel(limit.measure(s))[0])
    than = "least" if limit.least else "most"
    return f"{name} ({limit.formula} at {than} {as_text(value, limit.dimension)}, is {_short(has, limit.dimension)})"


def _short(value: float, dimension: Any) -> str:
    return f"{value * 1e3:.4g} mm" if dimension == "length" else f"{value:.4g}"


def _choose(problem: Problem, look: Look, effects: Array, kept: Array, count: int) -> tuple[Array, Array]:
    """Return the designs that are reported, in their order, and which designs meet the target."""
    goals = problem.target.goals
    met = np.zeros(look.merit.size, bool)
    for i in kept:
        met[i] = all(_met(problem, look, int(i)))
    # what is asked as "at least" or "at most" has room for its tolerances
    weights = np.array([goal.weight * (goal.sense == "=") for goal in goals])[:, None, None]
    spread = np.sqrt(((weights * effects) ** 2).sum(axis=(0, 1)))
    if met.any():
        order = kept[met[kept]]
        order = order[np.argsort(spread[order], kind="stable")]
    else:
        order = kept[np.argsort(look.merit[kept], kind="stable")]
        order = order[look.merit[order] <= WORSE * look.merit[order[0]]]
    chosen: list[int] = []
    for least in DISTINCT:
        for i in order:
            if len(chosen) < count and all(np.abs(look.y[i] - look.y[j]).max() >= least for j in chosen):
                chosen.append(int(i))
    return np.array(sorted(chosen, key=order.tolist().index)), met


def _met(problem: Problem, look: Look, i: int) -> list[bool]:
    """Whether each goal of a design is met; those of a curve together."""
    target, d = problem.target, float(look.d[i])
    verdicts: list[bool] = []
    groups: dict[str, list[float]] = {}
    for goal, value in zip(target.goals, look.found.values[:, i], strict=False):
        if goal.group:
            groups.setdefault(goal.group, []).append((float(value) - goal.asked) / goal.scale)
        else:
            verdicts.append(within(goal, float(value), d, target.accept))
    return [*verdicts, *(bool(_rms(v) <= target.accept) for v in groups.values())]


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _design(problem: Problem, look: Look, effects: Array, i: int, met: bool) -> Design:
    """Return one design with all there is to say about it."""
    space, options = problem.space, problem.target.options
    beam = space.beam_of(look.y[i])
    at = space.values(look.y[i : i + 1])
    values = {v.name: float(at[v.key][0]) for v in space.variables}
    common: dict[str, Any] = {"margin": options.margin, "points": 3}
    if space.load == "twisting":
        answer = response.twisted(beam, law=options.law, sense=options.sense, **common)
        end, rate = answer["end"].item(), float(answer["Phi_end"])
    else:
        answer = response.bent(beam, **common)
        end, rate = answer["end"].item(), float(answer["kappa_end"])
    return Design(
        beam=beam,
        values=values,
        met=met,
        goals=tuple(_reached(problem, look, effects, i)),
        active=tuple(_active(problem, look, i)),
        end=end,
        rate_end=rate,
        other_contact=answer["other_contact"].item(),
        warnings=tuple(beam.warnings(space.load, options.sense)),
    )


def _reached(problem: Problem, look: Look, effects: Array, i: int) -> list[Reached]:
    target, d = problem.target, float(look.d[i])
    names = [FULL.get(key, key) for key in target.tolerance]
    found, groups = [], dict.fromkeys(goal.group for goal in target.goals if goal.group)
    for k, goal in enumerate(target.goals):
        if goal.group:
            continue
        reached = float(goal.shown(look.found.values[k, i], d))
        by_size = dict(zip(names, (goal.number * effects[k, :, i]).tolist(), strict=True))
        verdict = within(goal, float(look.found.values[k, i]), d, target.accept)
        spread = float(np.linalg.norm(list(by_size.values())))
        off = reached - goal.number
        found.append(Reached(goal.name, goal.unit, goal.sense, goal.number, reached, off, verdict, spread, by_size))
    for group in groups:
        rows = [k for k, goal in enumerate(target.goals) if goal.group == group]
        scale = target.goals[rows[0]].scale
        off = _rms([look.found.values[k, i] - target.goals[k].asked for k in rows])
        by_size = {name: scale * _rms(effects[rows, j, i]) for j, name in enumerate(names)}
        spread = float(np.linalg.norm(list(by_size.values())))
        verdict = bool(off / scale <= target.accept)
        found.append(Reached(f"{group}, rms", "N m", "=", 0.0, off, off, verdict, spread, by_size))
    return found


def _active(problem: Problem, look: Look, i: int) -> list[str]:
    """Name bounds and limits on which a design lies."""
    found = []
    for v, share in zip(problem.space.variables, look.y[i], strict=True):
        if share <= ACTIVE or share >= 1 - ACTIVE:
            side, bound = ("lower", v.low) if share <= ACTIVE else ("upper", v.high)
            found.append(f"{v.name} at its {side} bound {text_of(v.key, bound)}")
    for name, g in zip(problem.names, look.g[:, i], strict=True):
        if g <= ACTIVE:
            if name in LIMITS:
                found.append(f"limit {name} {as_text(problem.target.limits[name], LIMITS[name].dimension)}")
            elif " at the " in name:
                found.append(name)
            else:
                found.append(f"limit joint_law, {name}")
    return found
