"""Motion of a part under load for pictures: every scale and pitch along the points of its load."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.contacts.path import deflections
from squama.curves.chosen import COMPLIANT, idealisation
from squama.curves.labelled import Answer
from squama.errors import refuse
from squama.loads import HELD, LOADS
from squama.model.outcome import End
from squama.part import door
from squama.part.definition import Part
from squama.part.told import Told
from squama.people import figure
from squama.scene import picture
from squama.scene.geometry import Placed
from squama.scene.motion import ENDED, SLIDING, Motion, Setting, State

SIZES = ("length", "width", "thickness")
"""What is drawn alike for all scales."""


class PartMotion(Motion):
    """A part under load: its "load" is the number of a point, with states interpolated between the points.

    Clamped or gripped parts are drawn with their root at rest, parts on rollers with their middle.
    """

    def __init__(self, answer: Answer, told: Told) -> None:
        ones, (beam, ideal) = told.ones, (told.ones[0].beam, not told.ones[0].way.scale.h)
        self.graded: Sequence[Beam] = [one.beam for one in ones]
        for name in SIZES if len(ones) > 1 else ():
            if len({getattr(one.scale, name) for one in self.graded}) > 1:
                refuse(f"scale.{name}", "", "differs along the part", "draw it from the side (--gif)")
        self.setting = Setting(beam.replace(scales=told.course.n), float(answer["mu"]))
        self.kind, self.joint, self.ideal = LOADS["twisting"], COMPLIANT, ideal
        self.model = f"{idealisation(beam, COMPLIANT, ideal=ideal)} on {HELD[COMPLIANT]}"
        self.place = f"{told.course.n} scales, {answer.attrs['loads']}, {answer.attrs['support']}"
        self.notes = list(answer.attrs["warnings"])
        by_dim = told.by_dim()
        self.points, self.each = by_dim["point",], by_dim["point", "scale"]
        number = np.arange(len(told.at), dtype=float)
        self.curve = {"load": number, "torque": np.zeros(number.size)}
        cells = told.track.cells[..., :4]
        faces = zip(ones[0].seen, told.track.faces, strict=True)
        self.shapes = [(cells * [*seen, 1], deflections(face.rows)) for seen, face in faces]
        self.hinge, self.drawn, self.other_drawn, self.whole = None, False, False, len(self.shapes) > 1
        self.neighbour, self.figures, self.on = 1, {}, told.on
        self.end = self.own_end = told.track.end.word if told.track.end.code else End.RANGE
        self.last = self.own_last = self.most = float(number[-1])
        self.other = self._of_other() if self.whole else None
        self.still = 0.0 if answer.attrs["support"].startswith("simple") else -told.course.n / 2

    @property
    def verb(self) -> str:
        """What the load does, in a word."""
        return "load"

    def shape(self) -> Placed:
        """Return the design for the geometry, see :func:`squama.scene.motion.shape`."""
        return {**super().shape(), "still": self.still}

    def touches(self, load: float) -> bool:
        """Return whether scales are in contact at a point."""
        return self.pressed(load)

    def words(self, state: State) -> str:
        """Return a state as text: share of the load, load and travel, friction."""
        v = {role: float(np.interp(state.load, self.curve["load"], column)) for role, column in self.points.items()}
        turns = "turn" in v
        size = figure(1e3 * v["moment"], "N mm") if turns else figure(v["F"], "N")
        moved = figure(math.degrees(v["turn"]), "deg") if turns else figure(1e3 * v["travel"], "mm")
        return f"{figure(100 * v['share'])} % of the load: {size} at {moved}, µ = {self.setting.mu:g}"

    def _named(self) -> str:
        """Return the name of the scales' state at the last point."""
        return SLIDING if self.on else ENDED


def view_part(
    part: Part, *paths: str | os.PathLike[str], name: str = "", dark: bool = False, frames: int = picture.FRAMES,
    **given: Any,
) -> picture.View:  # fmt: skip
    """Draw a part under its loads in space: pictures, animations of loading and unloading, pages to turn it.

    Parameters
    ----------
    part
        The part, with its loads, support and grading.
    *paths, name, dark, frames
        As of :func:`squama.view`.
    **given
        ``scales``, ``mu``, ``points``, ``back``, ``ideal``, ``hold`` as of :func:`squama.load`.

    Returns
    -------
    View
        As of :func:`squama.view`; its loads are numbers of points.

    Raises
    ------
    InputError
        An argument is out of range, a file cannot be written, or scales differ in size along the part.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45)
    >>> squama.view_part(squama.Part(beam, "40 deg bend"), scales=8, mu=0.2).state.name
    'sliding'
    """
    picture.known(paths)
    count = arguments.whole("frames", frames, 2, 500)
    return drawn(*door.followed(door.of(part), **given), *paths, name=name, dark=dark, frames=count)


def drawn(answer: Answer, told: Told, *paths: str | os.PathLike[str], name: str = "", **looks: Any) -> picture.View:
    """Draw a part that was followed, under the largest load, as :func:`view_part`."""
    motion = PartMotion(answer, told)
    top = float(np.argmax(motion.points["share"]))
    written: list[Path] = [picture.save(motion, top, path, name=name, **looks) for path in paths]
    return picture.viewed(motion, top, written)
