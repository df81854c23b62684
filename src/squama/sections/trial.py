"""The law of a section as an object with a memory: ``squama.law``; what a rod program asks of its cells.

Each cell is an endless beam in a state of its own. A trial is one straight leg of the contact solver in bend and twist
from the committed state (:mod:`squama.contacts.onward`); a state is kept as a snapshot, so a trial costs its own leg
alone, however long the history.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from squama import arguments
from squama.beam.design import Beam
from squama.contacts import increments, onward, path
from squama.curves import compliant, doors
from squama.curves.chosen import COMPLIANT
from squama.curves.way import VERBS, Way
from squama.errors import refuse
from squama.types import Array

OUT = "out of range"
"""End of a trial to half a turn per pitch or more, or to what is no number."""
MOST = 100_000
"""Largest number of cells."""
_APART = 1e-5
"""Distance, rad per pitch, of states whose difference is a slope where derivatives are not known."""
_TOLD = ("energy", "W_fr", "W_snap", "contacts")


class _State(NamedTuple):
    """States of n cells: snapshots (n, size), bend and twist per pitch (n, 2), moment and torque (n, 2).

    ``told`` (n, 4): energies and number of contacts. ``before``, ``begin``: snapshots and strains at which the leg
    began that led there.
    """

    snapshots: Array
    strains: Array
    loads: Array
    told: Array
    before: Array
    begin: Array

    def where(self, cells: Array, other: _State) -> _State:
        """Return the states with those of some cells (n,) in their place."""
        return _State._make(np.where(cells[:, None], new, own) for own, new in zip(self, other, strict=True))


class Law:
    """Moment and torque of an array of cells by bend and twist, with friction's memory; made by :func:`law`.

    ``pitch`` (m) and ``mu``: of the beam; ``cells``: how many; ``end`` (n,): why a cell of the last trial has no
    state, "" if it has. Arrays that are returned are copies.
    """

    def __init__(self, one: compliant.Path, cells: int) -> None:
        self._one, self._beams, self._unit = one, one.way.beams, one.unit_moment
        self.pitch, self.mu, self.cells = one.beam.pitch, one.way.mu, cells
        rest, zeros = onward.at_rest(self._beams, cells), np.zeros((cells, 2))
        self._committed = _State(rest, zeros, zeros, np.zeros((cells, 4)), rest, zeros)
        self._trial, self.end = self._committed, np.full(cells, "", "U40")

    def trial(self, kappa: ArrayLike, Phi: ArrayLike) -> tuple[Array, Array]:
        """Try strains, straight from those that are committed.

        Parameters
        ----------
        kappa, Phi
            Curvature (positive towards the scaled face) and twist rate, rad/m: numbers, or arrays (n,) of the cells.

        Returns
        -------
        M, T : (n,) arrays
            Bending moment and torque, N m; NaN of cells whose ``end`` says why there is no state.

        Raises
        ------
        InputError
            The arrays have the wrong shape, or are no numbers. NaN, inf and half a turn per pitch are ends.
        """
        goals = self.pitch * np.column_stack([self._of_cells("kappa", kappa), self._of_cells("Phi", Phi)])
        here = self._committed
        known = np.asarray((np.abs(goals) < math.pi).all(axis=1))
        go = known & np.asarray((goals != here.strains).any(axis=1))
        self.end = np.where(known, "", OUT).astype("U40")
        loads, told, strains = here.loads.copy(), here.told.copy(), np.where(known[:, None], goals, here.strains)
        snapshots, before, begin = here.snapshots.copy(), here.before.copy(), here.begin.copy()
        if go.any():
            leg = onward.onward(self._beams, here.snapshots[go], here.strains[go], goals[go])
            column = path.named(leg.rows)
            loads[go] = self._unit * np.column_stack([column["M"], column["torque"]])
            per_length = self._unit / self.pitch
            told[go] = np.column_stack([column[name] for name in _TOLD]) * [*[per_length] * 3, 1.0]
            codes = leg.answers.ends[:, 0].astype(int)
            self.end[go] = np.where(codes == increments.RANGE, "", path.WORDS[codes])
            snapshots[go], before[go], begin[go] = leg.snapshots, here.snapshots[go], here.strains[go]
        lost = self.end != ""
        loads[lost], told[lost] = np.nan, np.nan
        self._trial = _State(snapshots, strains, loads, told, before, begin)
        return loads[:, 0].copy(), loads[:, 1].copy()

    def tangent(self) -> Array:
        """Return the derivatives (n, 2, 2) of the trial's moment and torque by curvature and twist rate, N m^2.

        [[dM/dkappa, dM/dPhi], [dT/dkappa, dT/dPhi]] of all that the leg of the trial does, which is what Newton's
        method needs: the committed state stays, the leg's end moves. Symmetric without friction. Without a trial that
        moves, of the leg that was committed last; at rest of the beam without contact. Where the scales have snapped on
        the leg or an event stands at its end, by differences; NaN where there is no state.
        """
        state, beams = self._trial, self._beams
        bare = self._one.rigidities[::-1, ::-1] / (self._unit * self.pitch)
        out = np.broadcast_to(bare, (self.cells, 2, 2)).copy()
        moved = (state.strains != state.begin).any(axis=1) & (self.end == "")
        out[self.end != ""] = np.nan
        if moved.any():
            parts = [v[moved] for v in (state.before, state.begin, state.strains)]
            found = onward.slopes(beams, *parts)
            open_ = np.isnan(found).any(axis=(1, 2))
            if open_.any():
                found[open_] = self._differences(*(v[open_] for v in parts))
            out[moved] = found
        return out * (self._unit * self.pitch)

    def commit(self) -> None:
        """Make the trial's state the committed one; cells without a state stay where they are."""
        self._committed = self._committed.where(self.end == "", self._trial)
        self._trial = self._committed

    def revert(self) -> None:
        """Forget the trial."""
        self._trial = self._committed
        self.end = np.full(self.cells, "", "U40")

    def copy(self) -> Law:
        """Return a law in the same states that goes its own way."""
        other = Law.__new__(Law)
        vars(other).update(vars(self))
        return other

    @property
    def kappa(self) -> Array:
        """Committed curvatures (n,), rad/m."""
        return np.asarray(self._committed.strains[:, 0] / self.pitch)

    @property
    def Phi(self) -> Array:
        """Committed twist rates (n,), rad/m."""
        return np.asarray(self._committed.strains[:, 1] / self.pitch)

    @property
    def U_el(self) -> Array:
        """Elastic energies (n,) of the trial, J/m."""
        return self._trial.told[:, 0].copy()

    @property
    def W_fr(self) -> Array:
        """Frictional work (n,) from rest to the trial, J/m."""
        return self._trial.told[:, 1].copy()

    @property
    def W_snap(self) -> Array:
        """Energy (n,) that jumps of the scales have lost from rest to the trial, J/m."""
        return self._trial.told[:, 2].copy()

    @property
    def contacts(self) -> Array:
        """Number of contacts of a scale (n,) in the trial, with scales further on; NaN where there is no state."""
        return self._trial.told[:, 3].copy()

    def _of_cells(self, name: str, value: ArrayLike) -> Array:
        """Return numbers of all cells (n,); numbers that are not finite are kept."""
        try:
            array = np.asarray(value, float)
            return np.broadcast_to(array, self.cells)
        except (TypeError, ValueError):
            refuse(name, "", f"must be a number or an array of {self.cells} numbers", "give one for each cell")

    def _differences(self, before: Array, begin: Array, strains: Array) -> Array:
        """Return derivatives (n, 2, 2) over E d^3 by central differences, one-sided where there is no other state."""
        out = np.empty((len(strains), 2, 2))
        for axis in range(2):
            off = np.zeros(2)
            off[axis] = _APART
            legs = (onward.onward(self._beams, before, begin, strains + s * off).rows for s in (1, 0, -1))
            above, here, below = (np.column_stack([path.named(r)[name] for name in ("M", "torque")]) for r in legs)
            up, down = (above - here) / _APART, (here - below) / _APART
            out[:, :, axis] = np.where(np.isnan(up), down, np.where(np.isnan(down), up, (up + down) / 2))
        return out


def law(
    beam: Beam, *, mu: float | None = None, cells: int = 1, ideal: bool | None = None, hold: str | None = None
) -> Law:
    """Return the law of a beam's section for a rod program of your own: moment and torque by curvature and twist.

    It is the endless beam's, so it stands for a part of many scales: its ``decay`` r, which :func:`squama.row` tells,
    says from which number on within 10 %, about 10/(1 - r). The lateral bend and the stretch are free, with no moment
    and force, unless they are held.

    Parameters
    ----------
    beam
        The beam.
    mu
        Coefficient of friction; the beam's own if not given. 0 has no memory, but for snaps.
    cells
        Number of cells, each in a state of its own.
    ideal
        Thin, rigid scales, as in :func:`squama.twist`.
    hold
        "lateral bend", "stretch" or both, in place of the beam's own ``hold``.

    Returns
    -------
    Law
        With ``trial``, ``tangent``, ``commit``, ``revert`` and ``copy``.

    Raises
    ------
    InputError
        An argument is out of range, or the joint of the beam is not known in bend.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45)
    >>> law = squama.law(beam, mu=0.2, cells=2)
    >>> M, T = law.trial(kappa=[0.0, 0.1 / beam.pitch], Phi=0.05 / beam.pitch)
    >>> law.commit()
    >>> law.tangent().shape
    (2, 2, 2)
    """
    one = compliant_path(beam, mu, ideal=ideal, hold=hold, loaded=VERBS)
    return Law(one, arguments.whole("cells", cells, 1, MOST))


def compliant_path(
    beam: Beam, mu: float | None, *, loaded: tuple[str, ...], ideal: bool | None, hold: str | None
) -> compliant.Path:
    """Return a beam for the contact solver with strains ``loaded``; refuse one whose joint is not known in bend."""
    arguments.beam(beam)
    analysis = doors.analysis(beam, Way(()), None, points=3, mu=mu, ideal=ideal, hold=hold)
    if analysis.joint != COMPLIANT:
        reason = analysis.note or "the line of the bar that keeps its length is for hinges only"
        refuse("beam", "", f"has no law of bend and twist: {reason}", "write all nine motions (squama joint --matrix)")
    return compliant.Path.of(analysis.beam, float(analysis.mus), loaded, ideal=analysis.ideal)
