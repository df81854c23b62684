"""The twist of an endless beam that is held bent: a path in one sense, solved, for what goes along such paths."""

from __future__ import annotations

import math
from typing import NamedTuple, Unpack

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.beam.matrixfile import MOTIONS
from squama.curves.chosen import COMPLIANT, MODELS
from squama.curves.curve_figures import figures
from squama.curves.doors import How
from squama.curves.labelled import Answer
from squama.curves.polygons import bent_and_twisted
from squama.curves.way import Case, Curve
from squama.errors import refuse
from squama.loads import ENDLESS
from squama.model.outcome import End
from squama.people import per_pitch
from squama.symbols import OTHER
from squama.types import Array

_ROLES = {"T": "torque", "T_scales": "scales", "theta": "theta", "N": "N", "f": "f"} | {
    name: name for name in ("U_el", "W_fr", "RED", "stress", "strain", "p", "s", *MOTIONS)
}


class Twisted(NamedTuple):
    """A bent beam's path as it is twisted, see :class:`squama.curves.way.Solved`; ``sign`` of the twist, its leg."""

    case: Case
    answer: Answer
    sign: int
    legs: int

    @classmethod
    def of(cls, beam: Beam, bend: float, *, sense: str = "+", **how: Unpack[How]) -> Twisted:
        """Bend a beam by ``bend`` (rad per pitch, signed) and twist it; refuse a bend that it does not come to."""
        found = cls.tried(beam, bend, sense=sense, **how)
        if not found.bent:
            answer = found.answer
            where = per_pitch(float(answer["psi_end"]), 4)
            refuse("bend", per_pitch(bend, 4), f"is beyond the beam's {answer['end']} at {where}", "bend it less")
        return found

    @classmethod
    def tried(cls, beam: Beam, bend: float, *, sense: str = "+", **how: Unpack[How]) -> Twisted:
        """Do as :meth:`of`, and take the path as far as it goes: see :attr:`bent`."""
        sign, d, legs = arguments.sense(sense), beam.pitch, 2 if bend else 1
        far = MODELS[how.get("joint") or COMPLIANT].programs().far
        answer = bent_and_twisted(beam, [(bend / d, 0.0), (bend / d, sign * far / d)][-legs:], ends=ENDLESS, **how)
        rigidity = float(answer.attrs.get("rigidity", beam.torsional_rigidity))
        case = Case(d, rigidity, float(answer["K_theta"]), beam.eta, beam.scale.theta0, sign < 0)
        return cls(case, answer, sign, legs)

    @property
    def bent(self) -> bool:
        """Whether the beam comes to its bend, and is twisted."""
        return bool((self.answer["leg"] == self.legs).any() and self.answer["event_leg"][-1] == self.legs)

    @property
    def notes(self) -> list[str]:
        """Where the path leaves what the model was compared with."""
        return [line for line in str(self.answer.attrs["warnings"]).splitlines() if line]

    @property
    def load_e(self) -> float:
        """Twist per pitch at engagement, inf for none."""
        engaged = self.sign * float(self.answer["phi_e"])
        return engaged if math.isfinite(engaged) else math.inf

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at evenly spaced twists (magnitudes), or at twists per pitch; NaN beyond its end."""
        a = self.answer
        twisting = a["leg"] == self.legs
        # the way begins where the bend is held
        twisting[max(0, np.flatnonzero(twisting)[0] - 1)] = True
        loads = self.sign * a["phi"][twisting]
        at = np.linspace(0.0, float(loads[-1]), points) if at is None else at
        along: dict[str, Array] = {}
        for name, role in (_ROLES | {name + OTHER: _ROLES[name] + OTHER for name in _ROLES}).items():
            if name in a.variables:
                values = a[name][twisting] * (self.sign if name in ("T", "T_scales") else 1)
                along[role] = np.interp(at, loads, values, right=np.nan)
        along |= {"load": at, "rate": at / self.case.pitch}
        # where the last point is; rigid scales have no stress
        ends = {role: np.flatnonzero(np.isfinite(values)) for role, values in along.items()}
        last = {role: float(along[role][i[-1]]) if i.size else math.nan for role, i in ends.items()}
        load_e = self.load_e
        found = {
            **figures(self.case, last, load_e, self.sign * float(a["phi_end"]), float(a["theta_end"])),
            "end": End.NONE if load_e == math.inf else str(a["end"]),
            "other_contact": str(a["other_contact"]),
            "neighbour": int(load_e < math.inf),
        }
        return Curve(along, found)
