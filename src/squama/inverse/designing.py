"""Inverse design: read a target, screen and refine beams, round and select them, report."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from squama import arguments
from squama._version import __version__
from squama.beam.card import card
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.curves.chosen import idealisation
from squama.errors import refuse
from squama.inverse import beside, by_elements, joint_figures, limits, search
from squama.inverse.beside import Beside
from squama.inverse.goals import SENSES, Pitches, Reached, reached
from squama.inverse.residuals import Look, Residuals
from squama.inverse.target import Target, read_target
from squama.loads import ENDLESS, LOADS
from squama.progress import steps
from squama.study.parameters import FULL, of_beam, text_of
from squama.types import Array
from squama.units import Dimension, as_text

ROUNDED = 10
"""Number of designs that are rounded, beyond two per wanted design."""
REFINED = 36
"""Number of starting points that are refined."""
LOCK = "only thin, rigid scales on hinges lock: thick scales bend, and their joints give (squama twist)"
BROKEN = 1e-7
"""Relative excess above which a limit counts as broken."""
ACTIVE = 1e-6
"""Distance (unit cube, or relative) within which a bound or limit is active."""
DISTINCT = (0.25, 0.1)
"""Least distance of two returned designs: the largest difference of a variable as a share of its range. The second
value holds where the first leaves too few designs.
"""
ASKED = 5
"""Number of designs whose joint may come from finite elements for the check by `squama.twist` or `squama.bend`."""
WORSE = 2.0
"""Designs that miss the target are returned up to this multiple of the least merit."""


@dataclass(frozen=True)
class Design:
    """A beam found by the search, with its goals and checks.

    ``values``: varied dimensions (SI); ``chosen``: options of lists in words; ``active``: bounds and limits on which
    the design lies; ``end`` and ``rate_end`` (rad/m): end of its curve as of :func:`squama.twist`
    (:func:`squama.bend`); ``other_contact``: another contact in words; ``refused``: why it cannot be printed, or why
    its joint is not covered (thick scales then do not meet the target). ``met`` and ``goals`` belong to the model in
    ``found_by`` ("(10 scales, free to bow)"); ``beside`` has the goals by other models, and ``confirmed`` tells whether
    all agree.
    """

    beam: Beam = field(repr=False)
    values: dict[str, float]
    chosen: dict[str, str]
    met: bool
    goals: tuple[Reached, ...]
    active: tuple[str, ...]
    end: str
    rate_end: float
    other_contact: str
    refused: tuple[str, ...]
    warnings: tuple[str, ...] = field(repr=False)
    found_by: str = ""
    beside: tuple[Beside, ...] = field(default=(), repr=False)

    @property
    def confirmed(self) -> bool:
        """Whether the design meets the target by the model of the search and by all other models."""
        return self.met and all(other.agrees for other in self.beside)

    def said(self, goal: Reached, *, missed: bool = False) -> list[str]:
        """Return the values of a goal by other models as text; with ``missed`` only by models that miss it."""
        pairs = ((other, one) for other in self.beside for one in other.goals if one.name == goal.name)
        return [other.says(one) for other, one in pairs if not (missed and (one.met or other.agrees))]

    @property
    def verdict(self) -> str:
        """Sentence on whether the target is reached by the model of the search, and by the other models."""
        if not self.met:
            return f"target not reached, nearest attainable {self.found_by}".strip()
        against = [(goal, self.said(goal, missed=True)) for goal in self.goals]
        lines = [f"{', '.join(said)} ({goal.name}, asked {goal.wanted})" for goal, said in against if said]
        lines += [f"{other.words} is {other.note}" for other in self.beside if not other.goals and other.note]
        also = " and ".join(o.words.replace("squama", "by squama") for o in self.beside if o.key != ENDLESS)
        agree = f", {also}, too" if also and not lines else ""
        return "; ".join([f"target reached {self.found_by}{agree}", *lines])

    @property
    def words(self) -> str:
        """Reached goals, varied dimensions and choices, in one line."""
        own = ((f"{goal.name} {goal.reached:.4g} {goal.unit}".strip(), *self.said(goal)) for goal in self.goals)
        goals = map(", ".join, own)
        values = (f"{name} {text_of(name, value)}" for name, value in self.values.items())
        return "; ".join([*goals, *values, *(f"{k} {v}" for k, v in self.chosen.items())])

    def to_toml(self, title: str = "") -> str:
        """Return the text of a beam file, with the goals in comments."""
        lines = [f"# {title}"] if title else []
        for goal in self.goals:
            unit = f" {goal.unit}" if goal.unit else ""
            line = f"# {goal.name}: asked {goal.sense} {goal.asked:.6g}{unit}, reached {goal.reached:.6g}{unit}"
            lines.append("; ".join([f"{line} {self.found_by}".rstrip(), *self.said(goal)]))
        return "\n".join([*lines, self.beam.to_toml()])


@dataclass(frozen=True)
class InverseDesign:
    """Designs for a target, best first.

    ``met`` tells whether the first design meets the target by the model of the search; if not it is the nearest
    attainable design, and its ``active`` names the bounds and limits that hold it. ``verdict`` names the model and the
    results of other models; ``confirmed`` tells whether all agree. ``bounds``: SI, by varied dimension; ``tolerance``:
    SI, of the first design, by dimension; ``settings`` of the search; ``notes``: lines for the reader.
    """

    source: str
    met: bool
    designs: tuple[Design, ...]
    bounds: dict[str, tuple[float, float]]
    tolerance: dict[str, float]
    settings: dict[str, object]
    notes: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """Verdict on the first design: :attr:`Design.verdict`."""
        return self.designs[0].verdict

    @property
    def confirmed(self) -> bool:
        """Whether other models agree that the first design meets the target: :attr:`Design.confirmed`."""
        return self.designs[0].confirmed

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the first design: :attr:`Design.warnings`."""
        return self.designs[0].warnings

    def __len__(self) -> int:
        return len(self.designs)

    def __getitem__(self, i: int) -> Design:
        return self.designs[i]

    def _repr_html_(self) -> str:
        """Return the HTML card of a notebook: the designs with their goals."""
        rows = [(f"design {i + 1}{'' if d.met else ', not on target'}", d.words) for i, d in enumerate(self.designs)]
        return card(f"{self.verdict}; {self.settings['scales']}", rows, self.notes)


def inverse_design(
    target: str | os.PathLike[str] | Mapping[str, object] | Target,
    *,
    beam: Beam | None = None,
    designs: int | None = None,
    starts: int = 4096,
    seed: int = 1,
    elements: bool = False,
) -> InverseDesign:
    """Find beams that reach a target: stiffen at a twist, keep within a torque and a stress, follow a curve, lock.

    Designs have thick, elastic scales on compliant joints, whose stiffness follows from the joint's law; targets with a
    lock take hinges. Each design is rounded to dimensions that can be made, computed again with all contacts, and
    checked against the rules of printer files. Designs with a number of scales are judged with all of them and their
    ends, others as endless beams.

    Parameters
    ----------
    target : path or mapping
        A TOML file, or the same as nested mappings: ``target`` (the goals), ``vary`` (bounds by dimension), ``choose``
        (lists of values or materials), ``limits``, ``rounding``, ``tolerance``; and ``start`` or the tables of a beam.
        See docs, how-to: design a beam. Or a ``Target``.
    beam, designs : Beam, int, optional
        In place of the target's: the starting beam, which supplies all values that do not vary; largest number of
        distinct designs (5).
    starts, seed : int
        Number of points within the bounds that are screened; seed of their Sobol sequence.
    elements : bool
        Compare the first design with finite elements (extra ``fe``, minutes to half an hour): of its own scales under a
        couple, at most 25, or of one pitch where it is endless or held straight.

    Returns
    -------
    InverseDesign
        Distinct designs, best first: those that meet the target, most robust against their tolerances first, or, where
        none does, the nearest attainable designs.

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
    if beam is not None:
        arguments.beam(beam)
    target = target if isinstance(target, Target) else read_target(target, beam=beam)
    if not target.compliant:
        only_one(target.space.beam.faces, "inverse design on hinges")
    count = arguments.whole("designs", target.designs if designs is None else designs, 1, 100)
    starts, seed = arguments.whole("starts", starts, 16, 1 << 20), arguments.whole("seed", seed, 0, 2**31)
    if elements:
        by_elements.check(target)
    residuals, space = Residuals(target), target.space
    first = space.start
    y = search.screen(residuals, first, starts, REFINED, seed)
    if not len(y):
        remedy = "look at the depth of the tab and at l/d and b/d"
        refuse("vary", "", "no point within the bounds is a beam", remedy, target.source)
    look = residuals.look(y, slopes=True, plates=True)
    idle = _idle(look)
    if idle.size:
        # a variable without effect keeps its starting value, unless figures then vanish
        still = y.copy()
        still[:, idle] = first[idle]
        same = residuals.look(still, slopes=False, plates=True).merit <= look.merit * (1 + 1e-9)
        y[same] = still[same]
    look, rates = search.refine(residuals, y), residuals.ends.rates
    if target.own and any(goal.want.at is not None for goal in target.goals):
        look, rates = search.with_ends(target, look, count, seed)
    elif any(v.step for v in space.variables):
        best = np.argsort(look.merit, kind="stable")[: ROUNDED + 2 * count]
        look = residuals.look(search.rounded(residuals, look.y.T[best], seed), slopes=True, plates=True)
    refined = _Refined(residuals, look, residuals.effects(look.y.T) * np.expand_dims(rates, 1))
    kept = np.flatnonzero((refined.limits >= -BROKEN).all(axis=0) & np.isfinite(look.merit))
    if not kept.size:
        refuse("limits", "", "no beam within the bounds keeps them all", refined.broken(), target.source)
    made = {i: refined.design(i) for i in kept.tolist()}
    chosen = refined.chosen(made, count)
    found = tuple(made[i] for i in chosen)
    asked = steps(enumerate(found), len(found), "designs asked by other models")
    found = tuple(replace(d, beside=beside.beside(target, d.beam, elements=i < ASKED)) for i, d in asked)
    notes = [f"{space.variables[j].name} has no effect on the goals" for j in idle.tolist()]
    if any(goal.want.figure == "lock" for goal in target.goals):
        notes.append(LOCK)
    if elements:
        told, lines = by_elements.of_design(target, found[0].beam)
        found = (replace(found[0], beside=found[0].beside + told), *found[1:])
        notes += lines
    sizes = residuals.tolerances(look.y.T[chosen[:1]])
    return InverseDesign(
        source=target.source,
        met=found[0].met,
        designs=found,
        bounds={v.name: (v.low, v.high) for v in space.variables},
        tolerance={FULL.get(key, key): float(size[0]) for key, size in sizes.items()},
        settings={
            **target.options._asdict(),
            "scales": idealisation(found[0].beam, target.options.joint, ideal=not target.compliant),
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
    """Return the indices of variables on which no figure depends, judged from starts that have all figures."""
    whole = np.isfinite(look.values).all(axis=0)
    if not whole.any():
        return np.empty(0, int)
    return np.flatnonzero(~look.slopes[..., whole].any(axis=(0, 2)))


class _Refined(NamedTuple):
    """Designs at the end of the search, and the effects of tolerances on them (goals, dimensions, designs)."""

    residuals: Residuals
    look: Look
    effects: Array

    @property
    def limits(self) -> Array:
        """Room to the limits (limits, designs) without the borders of the figures' domain; negative: broken."""
        return self.look.g[: len(self.look.g) - len(self.residuals.inside)]

    def broken(self) -> str:
        """Return the limits that the nearest beam breaks, with their values, as text."""
        look, target = self.look, self.residuals.target
        least = np.maximum(-self.limits, 0).sum(axis=0)
        i = int(np.argmin(np.where(np.isfinite(look.merit), least, np.inf)))
        sizes = self.residuals.sizes(self.residuals.space.cells(look.y[:, [i]].T), look.values[:, i : i + 1])
        words = []
        for name, g in zip(self.residuals.names, self.limits[:, i], strict=False):
            limit = limits.LIMITS.get(name)
            if g < -BROKEN and limit is not None:
                has = float(np.ravel(limit.measure(sizes))[0])
                short = f"{has * 1e3:.4g} mm" if limit.dimension is Dimension.LENGTH else f"{has:.4g}"
                bound = f"at {'least' if limit.least else 'most'} {as_text(target.limits[name], limit.dimension)}"
                words.append(f"{name} ({limit.formula} {bound}, is {short})")
            elif g < -BROKEN:
                words.append(name)
        return f"the nearest breaks {' and '.join(words)}"

    def chosen(self, made: Mapping[int, Design], count: int) -> list[int]:
        """Return the indices of the reported designs, best first, among those in ``made``; ``count`` at most."""
        look, kept = self.look, np.array(list(made))
        met = np.array([design.met for design in made.values()])
        near = met if met.any() else look.merit[kept] <= WORSE * look.merit[kept].min()
        price = self.spread() if met.any() else look.merit
        order = sorted(kept[near].tolist(), key=price.tolist().__getitem__)
        chosen: list[int] = []
        for least in DISTINCT:
            for i in order:
                if len(chosen) < count and all(np.abs(look.y[:, i] - look.y[:, j]).max() >= least for j in chosen):
                    chosen.append(i)
        return sorted(chosen, key=order.index)

    def spread(self) -> Array:
        """Return the relative deviation from the target that tolerances cause (designs,); less is better."""
        target, found = self.residuals.target, np.zeros(self.look.merit.size)
        for k, goal in enumerate(target.goals):
            size = np.sqrt((self.effects[k] ** 2).sum(axis=0))
            if goal.sense != "=":
                room = goal.relative(self.look.values[k], self.look.d, self.look.scales)
                size = np.maximum(size - room * (1 if goal.sense == ">=" else -1), 0.0) * target.compliant
            found += (goal.weight * size) ** 2
        return np.sqrt(found)

    def design(self, i: int) -> Design:
        """Return one complete design."""
        space, target = self.residuals.space, self.residuals.target
        y, load, names = self.look.y[:, i], LOADS[space.load], [FULL.get(key, key) for key in target.tolerance]
        beam = space.beam_of(y)
        # the single beam: all contacts, its own steps
        wants = [goal.want for goal in target.goals]
        values, answer = joint_figures.followed(beam, wants, target.options, target.options.joint)
        lines = limits.refused(beam, target.printer if target.compliant else {}, sided=load.sided)
        own, effects = Pitches(beam.pitch, beam.pitches), self.effects[:, :, i]
        goals = tuple(reached(target.goals, np.array(values), own, target.accept, effects, names))
        return Design(
            beam=beam,
            values={v.name: of_beam(beam, space.load, v.key) for v in space.variables},
            chosen={c.name: words for c, (words, _) in zip(space.choices, space.chosen(y), strict=True)},
            met=all(goal.met for goal in goals) and not (target.compliant and lines),
            goals=goals,
            active=tuple(self.active(i)),
            end=answer["end"].item(),
            rate_end=float(answer[f"{load.rate}_end"]),
            other_contact=answer["other_contact"].item(),
            refused=tuple(lines),
            warnings=tuple(filter(None, answer.attrs["warnings"].split("\n"))),
            found_by=beside.found_by(target, beam),
        )

    def active(self, i: int) -> list[str]:
        """Return the bounds and limits on which a design lies, and the goals that it just meets, as text."""
        found, target = [], self.residuals.target
        for v, share in zip(self.residuals.space.variables, self.look.y[:, i], strict=False):
            if share <= ACTIVE or share >= 1 - ACTIVE:
                side, bound = ("lower", v.low) if share <= ACTIVE else ("upper", v.high)
                found.append(f"{v.name} at its {side} bound {text_of(v.key, bound)}")
        before = float(self.look.d[i]), float(self.look.scales[i])
        for goal, value in zip(target.goals, self.look.values[:, i], strict=False):
            just = abs(value / goal.value(*before) - 1) <= 2 * target.accept
            if target.compliant and goal.sense != "=" and just:
                found.append(f"{goal.name} {SENSES[goal.sense]}{goal.number:g} {goal.unit}".strip())
        for name, g in zip(self.residuals.names, self.look.g[:, i], strict=True):
            if g <= ACTIVE and name in limits.LIMITS:
                value = target.limits[name]
                found.append(f"limit {name} {as_text(value, limits.LIMITS[name].dimension)}")
            elif g <= ACTIVE:
                found.append(name)
        return found


design = inverse_design
""":func:`inverse_design` under the name of its command."""
