"""The model of a study: kind of joint, thin or thick scales, and the twist at which figures are taken.

Beams on compliant joints are solved by :mod:`squama.study.compliant_columns`, with the joint of a beam's matrix or of
the law; beams on hinges by :mod:`squama.study.hinge_columns`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama import loads
from squama.beam.design import Beam
from squama.beam.joint_law import Each, whole
from squama.contacts.own_scales import Own
from squama.contacts.path import RANGE
from squama.contacts.ties import KINDS
from squama.curves import compliant
from squama.curves.chosen import Chosen, chosen, idealisation, thin
from squama.errors import naming, refuse
from squama.joints import choice
from squama.loads import LOADS
from squama.model.outcome import End
from squama.people import per_pitch
from squama.study import compliant_columns, hinge_columns
from squama.study.columns import Cells, columns
from squama.types import Array
from squama.units import shown

AHEAD = 2.0
"""Default twist at which figures are taken, over the twist at which the beam engages."""


class Twist(NamedTuple):
    """A twist (curvature in bending) above 0: ``unit`` "rad/pitch", the same for every pitch, or "rad/m"."""

    value: float
    unit: str

    @classmethod
    def read(cls, name: str, given: float | str, load: str, beam: Beam) -> Twist:
        """Read a rate (rad/m) or a text under the name of an argument; a twist in total becomes one per pitch."""
        with naming(name):
            one, two = (float(LOADS[load].read(given, pitch=d, scales=beam.pitches)) for d in (1.0, 2.0))
        if one <= 0:
            refuse(name, shown(given), "must be more than 0", 'write e.g. "0.2 rad/pitch"')
        # a rate that changes with the pitch was given as an angle
        return cls(one, "rad/m" if one == two else "rad/pitch")

    @classmethod
    def from_text(cls, text: str) -> Twist:
        """Read a twist from its :attr:`text`."""
        value, unit = text.split()
        return cls(float(value), unit)

    @property
    def text(self) -> str:
        """The twist as text, to the last digit."""
        return f"{self.value!r} {self.unit}"

    def words(self, scales: int) -> str:
        """Return the twist as text, per pitch or of a whole beam of ``scales`` scales, whichever number is rounder.

        >>> Twist(math.radians(130) / 25, "rad/pitch").words(25), Twist(0.08, "rad/pitch").words(25)
        ('130 deg total', '0.08 rad/pitch')
        >>> Twist(0.123456789, "rad/pitch").words(25)
        '176.8 deg total'
        """
        ways = [(self.value, self.unit)]
        if self.unit == "rad/pitch":
            ways.append((math.degrees(self.value) * scales, "deg total"))

        def digits(way: tuple[float, str]) -> int:
            exact = (n for n in range(1, 7) if math.isclose(float(f"{way[0]:.{n}g}"), way[0], rel_tol=1e-12))
            return next(exact, 7)

        # where neither is round, in degrees
        number, unit = min(reversed(ways), key=digits)
        return f"{number:.{6 if digits((number, unit)) < 7 else 4}g} {unit}"

    def per_pitch(self, d: Array | float) -> Array:
        """Return the load angle per pitch (rad) for pitches ``d`` (m)."""
        return np.asarray(self.value * d if self.unit == "rad/m" else self.value)


class Model(NamedTuple):
    """Kind of joint, whether scales are thin and rigid, and the twist at which figures are taken (None: the cut-off).

    ``own``: number of scales and ends of the finite beam that is compared with the endless beam; None without.
    """

    joint: str = "hinge"
    ideal: bool = True
    at: Twist | None = None
    own: Own | None = None

    @classmethod
    def chosen(
        cls,
        beam: Beam,
        load: str,
        laws: Sequence[str],
        sense: str,
        joint: str | None,
        ideal: bool | None,
        at: float | str | None,
        *,
        bent: bool = False,
    ) -> Model:
        """Return the model for a load, laws and options as of :func:`squama.twist`; ``bent``: beams are held bent."""
        law = LOADS[load].law(max(laws))
        found = _chosen(beam, load, laws, joint, ideal, bent=bent)
        ideal = found.ideal
        if not found.compliant:
            if at is not None:
                refuse(
                    "at", shown(at), "is for compliant joints; hinges give their figures at the cut-off", "leave it out"
                )
            if bent and (law != "edge" or not ideal):
                what = ("law", law) if law != "edge" else ("ideal", "False")
                refuse(*what, "is not available on hinges in bending", "leave it out, or do not sweep psi")
            return cls(found.joint, thin(LOADS[load], law, found.joint, ideal=ideal))
        if at is not None:
            twist = Twist.read("at", at, load, beam)
        elif 0 < (engaged := _engagement(beam, load, sense, ideal=ideal)) < RANGE:
            twist = Twist(AHEAD * engaged, "rad/pitch")
        else:
            refuse("at", "", f"the beam itself does not engage below {per_pitch(RANGE)}", "give the twist")
        if (angle := float(twist.per_pitch(beam.pitch))) >= np.pi:
            refuse("at", per_pitch(angle, 6), "must be below half a turn per pitch")
        return cls(found.joint, ideal, twist, own_scales(beam, load, bent=bent))

    @property
    def compliant(self) -> bool:
        """Whether joints are compliant."""
        return self.joint == "compliant"

    def cells(self, beam: Beam, load: str, values: Mapping[str, object], each: Each = whole) -> Cells:
        """Return the columns of a beam with some values replaced; for compliant joints those of twisting always."""
        return columns(beam, values, load="twisting" if self.compliant else load, each=each)

    def solved(
        self, beam: Beam, c: Cells, shape: tuple[int, ...], *, load: str, law: str, sense: str, margin: float, few: int
    ) -> dict[str, Array]:
        """Return figures of cells in arrays of a shape, by field, SI units; ``few`` as of the hinges' ``solved``."""
        if self.at is not None:
            at = np.broadcast_to(self.at.per_pitch(c.d), shape)
            found = compliant_columns.solved(c, at, load=load, sense=sense, ideal=self.ideal, own=self.own)._asdict()
            return {name: v.reshape(shape) for name, v in found.items()}
        if c.psi is not None:
            return hinge_columns.bent(beam, c, shape, sense=sense, margin=margin)
        found = hinge_columns.solved(c, load=load, law=law, sense=sense, margin=margin, few=few, ideal=self.ideal)
        return {name: np.broadcast_to(v, shape) for name, v in found.items()}

    @property
    def record(self) -> dict[str, object]:
        """The model as plain data; empty for the paper's model, thin scales on hinges."""
        if self == Model():
            return {}
        own = {"own": [self.own.scales, self.own.kind]} if self.own else {}
        return {"joint": self.joint, "ideal": self.ideal, "at": self.at and self.at.text, **own}

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Model:
        """Read a model from its :attr:`record`, which may stand among other data."""
        if "joint" not in record:
            return cls()
        at = record["at"]
        own = record.get("own")
        return cls(record["joint"], record["ideal"], at and Twist.from_text(at), own and Own(*own))

    def attrs(self, beam: Beam) -> dict[str, str]:
        """Return the attributes of a dataset that name the model."""
        found = {"joint": self.joint, "scales": idealisation(beam, self.joint, ideal=self.ideal)}
        found |= {"neutral": beam.given.line} if self.compliant else {}
        found |= {"at": self.at.text} if self.at else {}
        return found | ({"finite": self.own.words} if self.own else {})

    def warnings(self, beam: Beam, load: str, sense: str) -> list[str]:
        """Return warnings where the beam leaves the range in which the model was verified."""
        lines = beam.warnings(load, sense, self.joint)
        if self.at and choice.known(beam):
            far = float(self.at.per_pitch(beam.pitch))
            lines += compliant.notes(compliant.Held.of(beam), beam, far, ideal=self.ideal)
        return lines


def note(beam: Beam, load: str, laws: Sequence[str], joint: str | None, *, bent: bool = False) -> str:
    """Return why hinges replace the default compliant joint, which does not cover this case; else an empty text."""
    return _chosen(beam, load, laws, joint, None, bent=bent).note


def _chosen(beam: Beam, load: str, laws: Sequence[str], joint: str | None, ideal: bool | None, *, bent: bool) -> Chosen:
    """Choose the model of many beams: no joints by finite elements, and of two laws the plate law decides."""
    kind = LOADS[load]
    return chosen(beam, None if bent else kind, law=kind.law(max(laws)), joint=joint, ideal=ideal, elements=False)


def own_scales(beam: Beam, load: str, *, bent: bool) -> Own | None:
    """Return number of scales and ends of a finite beam, None for others; grips count only in twisting alone."""
    if beam.scales is None or beam.scales > loads.MANY_SCALES:
        return None
    loose = bent or beam.ends is None or (beam.ends == loads.GRIPPED and not LOADS[load].sided)
    return Own(beam.scales, KINDS[loads.FREE if loose else str(beam.ends)])


def _engagement(beam: Beam, load: str, sense: str, *, ideal: bool) -> float:
    """Return the load angle per pitch (rad) at engagement, inf for none within reach; refuse an unknown joint."""
    if why := choice.unknown(beam):
        refuse("joint", '"compliant"', why, "give at, the twist at which figures are taken")
    return float(compliant_columns.solved(columns(beam, {}), RANGE, load=load, sense=sense, ideal=ideal).load_e[0])


def shares(counts: Array) -> list[str]:
    """Return notes on the share of beams with thick scales that lack figures, from the counts (codes,) of the ends."""
    lines = []
    of = {
        compliant_columns.UNKNOWN: "the law of the joint does not know them: they have no figures",
        End.STOPPED: "no equilibrium was found up to the twist: they have no figures there",
        End.SIDE: "a plate comes in from the side before the twist, where figures end",
        End.JOINT: "a scale turns or moves too far in its joint before the twist, where figures end",
    }
    for end, what in of.items():
        share = counts[compliant_columns.ENDS.index(end)] / max(1, counts.sum())
        if share:
            lines.append(f"{100 * share:.3g} % of the beams: {what}")
    return lines
