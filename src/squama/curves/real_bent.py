"""Bending of the real beam: the curve along psi, by the path of :mod:`squama.curves.real_polygons` that bends alone."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from squama.contacts import events, path
from squama.curves import real
from squama.curves.path import Asked, Case, Curve, States, figures, spaced
from squama.curves.real_polygons import WALKED, Gone, Stations, go
from squama.errors import refuse
from squama.loads import LOADS
from squama.model.outcome import End
from squama.types import Array

BENT = LOADS["bending"].verb
"""The strain that is loaded."""
FINE = 2e-3
"""Distance of the curve's own points, rad per pitch."""
_NEAR = FINE / 2
"""Least distance of the curve's own points from those asked for, rad per pitch."""


class Bent(NamedTuple):
    """A bent beam's path with one coefficient of friction, see :class:`squama.curves.path.Solved`.

    ``ways`` (n,) bends per pitch, ``own`` variables there by role.
    """

    case: Case
    gone: Gone
    ways: Array
    own: dict[str, Array]

    @property
    def notes(self) -> list[str]:
        """Where the path leaves what the model was compared with."""
        return self.gone.notes

    @property
    def load_e(self) -> float:
        """Bend per pitch at engagement, inf for none."""
        return self.gone.engaged

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at evenly spaced bends, or at bends per pitch, NaN beyond its end; linear between states."""
        gone, ways = self.gone, self.ways
        engaged, last = gone.engaged, float(ways[-1])
        if at is None:
            at = spaced(last, points, engaged)
        within = at <= last * (1 + 1e-12)

        def read(values: Array) -> Array:
            if values.dtype.kind == "U":
                return np.where(within, values[np.searchsorted(ways, at * (1 + 1e-12), side="right") - 1], "")
            return np.where(within, np.interp(at, ways, values), np.nan)

        along = {role: read(values) for role, values in self.own.items() if role != "work"}
        along |= {"load": at, "rate": at / self.case.pitch}
        # the slope jumps at engagement
        free = within & (at < gone.onset)
        along["tangent"][free], along["stiffness_ratio"][free] = self.case.rigidity, 1.0
        met, neighbour = gone.faces[0].met[1], gone.one.way.contact.k
        cut = {role: float(values[-1]) for role, values in self.own.items() if values.dtype.kind == "f"}
        second = events.second(gone.faces[0].events)
        end = math.inf if gone.found.end == End.NONE else gone.found.stop
        found = {
            **figures(self.case, cut, engaged, end, cut["theta"]),
            "T_c": cut["T"], "end": gone.found.end, "other_contact": gone.found.other,
            "neighbour": max(0, neighbour), "first_contact": met, "load_second": second.way if second else math.nan,
            **({"load_e_other": gone.touched[1]} if len(gone.touched) > 1 else {}),
            **real.thresholds(gone.onset, gone.one.beam, ways, self.own),
        }  # fmt: skip
        return Curve(along, found)


def solve(asked: Asked) -> tuple[list[Bent], States]:
    """Return the paths of a beam for each coefficient of friction."""
    beam, to = asked.beam, abs(asked.path.values[-1])
    at = np.zeros(0) if asked.at is None else asked.at
    far = min(to, float(at.max(initial=0.0)) or (path.RANGE if to == math.inf else to))
    if far >= math.pi:
        refuse("at" if at.size else "to", f"{far / beam.pitch:.6g} rad/m", "must be below half a turn per pitch")
    found = [_bent(asked, float(mu), far, at) for mu in np.atleast_1d(asked.mus)]
    first = found[0]
    attrs = {**real.attributes(first.gone.one.held, BENT), "rigidity": first.case.rigidity}
    return found, States({}, attrs, list(dict.fromkeys(note for bent in found for note in bent.gone.notes)))


def _bent(asked: Asked, mu: float, far: float, at: Array) -> Bent:
    """Return a beam's path up to the bend ``far`` per pitch, through those of ``at``."""
    d = asked.beam.pitch

    def stations(engaged: float) -> Stations:
        wanted = np.union1d(at[at <= far], [0.0, far])
        if 0 < engaged < far:
            wanted = np.union1d(wanted[np.abs(wanted - engaged) > 1e-9 * engaged], engaged)
        fine = np.linspace(0.0, far, math.ceil(far / FINE) + 1)
        ways = np.union1d(wanted, fine[np.abs(fine[:, None] - wanted).min(axis=1) > _NEAR])
        return Stations(ways, np.column_stack([ways, 0 * ways]), np.ones(ways.size, int))

    gone = go(asked, mu, stations, [(max(far, path.RANGE), 0.0)])
    (own, bare), ways = gone.bending(), gone.along["psi"]
    case = Case(d, bare, gone.one.held.K_theta, asked.beam.eta, asked.beam.scale.theta0)
    own = {role: values for role, values in own.items() if role not in WALKED}
    own |= real.tangents(bare, d, gone.onset, ways, ways, own)
    return Bent(case, gone, ways, own)
