"""What an inverse design gives: beams, how well each meets the target, and how much its tolerances matter."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from squama.design import Beam


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
