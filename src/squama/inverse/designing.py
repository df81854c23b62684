"""From a target to designs: read, screen, refine, choose, report."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from squama import arguments
from squama._version import __version__
from squama.beam.design import Beam
from squama.curves import doors
from squama.errors import refuse
from squama.inverse import search
from squama.inverse.limits import LIMITS
from squama.inverse.residuals import BORDERS, Look, Residuals
from squama.inverse.target import Target, read_target
from squama.loads import LOADS
from squama.study.parameters import FULL, of_beam, text_of
from squama.types import Array
from squama.units import Dimension, as_text

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


@dataclass(frozen=True)
class Reached:
    """One goal of a design, in the unit in which it was asked.

    ``difference`` is reached minus asked; ``spread`` the root of the sum of squares of ``effects``, which are
    derivative times tolerance by dimension. A measured curve is one goal: ``reached`` is then the rms difference of its
    points. A figure that the design does not have is NaN.
    """

    name: str
    unit: str
    sense: str
    asked: float
    reached: float
    difference: float
    met: bool
    spread: float
    effects: dict[str, float] = field(repr=False)


@dataclass(frozen=True)
class Design:
    """A beam that was found.

    ``values`` of what was varied (SI), ``active`` bounds and limits that it lies on, ``end`` and ``rate_end`` (rad/m)
    of its curve as :func:`squama.twist` (:func:`squama.bend`) has them, ``other_contact`` in words.
    """

    beam: Beam = field(repr=False)
    values: dict[str, float]
    met: bool
    goals: tuple[Reached, ...]
    active: tuple[str, ...]
    end: str
    rate_end: float
    other_contact: str
    warnings: tuple[str, ...] = field(repr=False)

    def to_toml(self, title: str = "") -> str:
        """Return the text of a beam file, with what it is to do as a comment."""
        lines = [f"# {title}"] if title else []
        for goal in self.goals:
            unit = f" {goal.unit}" if goal.unit else ""
            lines.append(f"# {goal.name}: asked {goal.sense} {goal.asked:.6g}{unit}, reached {goal.reached:.6g}{unit}")
        return "\n".join([*lines, self.beam.to_toml()])


@dataclass(frozen=True)
class InverseDesign:
    """Designs for a target, the best first.

    ``met`` tells whether the first one meets the target; if not it is the nearest attainable one and its ``active``
    names the bounds and limits that hold it. ``bounds`` (SI) of what was varied, ``tolerance`` (SI, of the first
    design) by dimension, ``settings`` of the search. ``notes`` are lines for the reader.
    """

    source: str
    met: bool
    designs: tuple[Design, ...]
    bounds: dict[str, tuple[float, float]]
    tolerance: dict[str, float]
    settings: dict[str, Any]
    notes: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.designs)

    def __getitem__(self, i: int) -> Design:
        return self.designs[i]


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
    beam, designs : Beam, int, optional
        In place of the target's: beam to start from, which keeps what is not varied; distinct designs at most (5).
    starts, seed : int
        Points of the bounds that are screened; seed of their Sobol sequence.

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
    count = arguments.whole("designs", target.designs if designs is None else designs, 1, 100)
    starts, seed = arguments.whole("starts", starts, 16, 1 << 20), arguments.whole("seed", seed, 0, 2**31)
    residuals, space = Residuals(target), target.space
    first = space.place({v.key: of_beam(space.beam, space.load, v.key) for v in space.variables})
    y = search.screen(residuals, first, starts, REFINED, seed)
    if not len(y):
        remedy = "look at the depth of the tab and at l/d and b/d"
        refuse("vary", "", "no point within the bounds is a beam", remedy, target.source)
    look = residuals.look(y, slopes=True, plates=True)
    idle = _idle(look)
    if idle.size:
        # as in the starting beam, unless the figures are then gone
        still = y.copy()
        still[:, idle] = first[idle]
        same = residuals.look(still, slopes=False, plates=True).merit <= look.merit * (1 + 1e-9)
        y[same] = still[same]
    look = search.refine(residuals, y)
    refined = _Refined(residuals, look, residuals.effects(look.y))
    kept = np.flatnonzero((refined.limits >= -BROKEN).all(axis=0) & np.isfinite(look.merit))
    if not kept.size:
        refuse("limits", "", "no beam within the bounds keeps them all", refined.broken(), target.source)
    chosen = refined.chosen(kept, count)
    found = tuple(refined.design(i) for i in chosen)
    sizes = residuals.tolerances(look.y[chosen[:1]])
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
        notes=tuple(f"{space.variables[int(j)].name} has no effect on what is asked" for j in idle),
    )


def _idle(look: Look) -> Array:
    """Return the variables that no figure depends on, as far as there are starts that have all figures."""
    whole = np.isfinite(look.found.values).all(axis=0)
    if not whole.any():
        return np.empty(0, int)
    return np.flatnonzero(~look.found.slopes[..., whole].any(axis=(0, 2)))


class _Refined(NamedTuple):
    """Designs at the end of the search, and what their tolerances do (goals, dimensions, designs)."""

    residuals: Residuals
    look: Look
    effects: Array

    @property
    def limits(self) -> Array:
        """Room to the limits alone, without the borders of the figures' domain."""
        return self.look.g[: len(self.look.g) - len(self.residuals.inside)]

    def broken(self) -> str:
        """Say which limits no beam within the bounds keeps together."""
        look, target = self.look, self.residuals.target
        least = np.maximum(-self.limits, 0).sum(axis=0)
        i = int(np.argmin(np.where(np.isfinite(look.merit), least, np.inf)))
        sizes = self.residuals.sizes(self.residuals.space.cells(look.y[i : i + 1]), look.found.values[:, i : i + 1])
        words = []
        for name, g in zip(self.residuals.names, self.limits[:, i], strict=False):
            if g >= -BROKEN:
                continue
            if name not in LIMITS:
                words.append(f"joint_law ({name})")
                continue
            limit, value = LIMITS[name], target.limits[name]
            has = float(np.ravel(limit.measure(sizes))[0])
            short = f"{has * 1e3:.4g} mm" if limit.dimension is Dimension.LENGTH else f"{has:.4g}"
            bound = f"at {'least' if limit.least else 'most'} {as_text(value, limit.dimension)}"
            words.append(f"{name} ({limit.formula} {bound}, is {short})")
        return f"the nearest breaks {' and '.join(words)}"

    def chosen(self, kept: Array, count: int) -> list[int]:
        """Return the designs that are reported, the best first."""
        look, goals = self.look, self.residuals.target.goals
        met = np.array([all(goal.met for goal in self.reached(int(i))) for i in kept])
        if met.any():
            # what is asked as "at least" or "at most" has room for its tolerances
            weights = np.array([goal.weight * (goal.sense == "=") for goal in goals])[:, None, None]
            spread = np.sqrt(((weights * self.effects) ** 2).sum(axis=(0, 1)))
            order = kept[met]
            order = order[np.argsort(spread[order], kind="stable")]
        else:
            order = kept[np.argsort(look.merit[kept], kind="stable")]
            order = order[look.merit[order] <= WORSE * look.merit[order[0]]]
        chosen: list[int] = []
        for least in DISTINCT:
            for i in order.tolist():
                if len(chosen) < count and all(np.abs(look.y[i] - look.y[j]).max() >= least for j in chosen):
                    chosen.append(i)
        return sorted(chosen, key=order.tolist().index)

    def design(self, i: int) -> Design:
        """Return one design with all there is to say about it."""
        space, options = self.residuals.space, self.residuals.target.options
        beam = space.beam_of(self.look.y[i])
        at = space.values(self.look.y[i : i + 1])
        common = {name: getattr(options, name) for name in ("law", "sense", "margin")}
        answer = doors.respond(beam, space.load, points=3, joint="hinge", **common)
        goals = tuple(self.reached(i))
        return Design(
            beam=beam,
            values={v.name: float(at[v.key][0]) for v in space.variables},
            met=all(goal.met for goal in goals),
            goals=goals,
            active=tuple(self.active(i)),
            end=answer["end"].item(),
            rate_end=float(answer[f"{LOADS[space.load].rate}_end"]),
            other_contact=answer["other_contact"].item(),
            warnings=tuple(beam.warnings(space.load, options.sense)),
        )

    def reached(self, i: int) -> list[Reached]:
        """Return what a design reaches of each goal; those of a curve together."""
        target, values, d = self.residuals.target, self.look.found.values[:, i], float(self.look.d[i])
        names = [FULL.get(key, key) for key in target.tolerance]
        rows, groups = [], dict.fromkeys(goal.group for goal in target.goals if goal.group)
        for k, goal in enumerate(target.goals):
            if goal.group:
                continue
            reached, met = goal.shown(values[k], d), goal.met(float(values[k]), d, target.accept)
            effects = goal.number * self.effects[k, :, i]
            rows.append((goal.name, goal.unit, goal.sense, goal.number, reached, met, effects))
        for group in groups:
            own = [k for k, goal in enumerate(target.goals) if goal.group == group]
            scale = target.goals[own[0]].scale
            off = float(_rms(values[own] - [target.goals[k].asked for k in own]))
            effects = scale * _rms(self.effects[own, :, i])
            rows.append((f"{group}, rms", "N m", "=", 0.0, off, off / scale <= target.accept, effects))
        found = []
        for name, unit, sense, asked, reached, met, effects in rows:
            spread, by_name = float(np.linalg.norm(effects)), dict(zip(names, effects.tolist(), strict=True))
            found.append(Reached(name, unit, sense, asked, reached, reached - asked, met, spread, by_name))
        return found

    def active(self, i: int) -> list[str]:
        """Name bounds and limits on which a design lies."""
        found = []
        for v, share in zip(self.residuals.space.variables, self.look.y[i], strict=True):
            if share <= ACTIVE or share >= 1 - ACTIVE:
                side, bound = ("lower", v.low) if share <= ACTIVE else ("upper", v.high)
                found.append(f"{v.name} at its {side} bound {text_of(v.key, bound)}")
        for name, g in zip(self.residuals.names, self.look.g[:, i], strict=True):
            if g <= ACTIVE and name in LIMITS:
                value = self.residuals.target.limits[name]
                found.append(f"limit {name} {as_text(value, LIMITS[name].dimension)}")
            elif g <= ACTIVE:
                found.append(name if name in BORDERS.values() else f"limit joint_law, {name}")
        return found


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=0)))
