"""The real beam in SI units: thick, elastic scales on a joint that gives, by :mod:`squama.contacts`.

A scale has six motions against the substrate (:mod:`squama.joints`) and bends where its modulus is known; ``ideal``
makes it thin and rigid. All contacts of neighbouring scales are followed (:mod:`squama.contacts`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, TypedDict

import numpy as np

from squama.beam import joint_law
from squama.beam.design import Beam
from squama.beam.joint_law import Free
from squama.beam.matrixfile import MOTIONS, SHAPE
from squama.contacts import increments, path, states
from squama.curves.both_faces import WHOSE, of_other, worst
from squama.curves.path import FINE, Asked, Case, Curve, States, figures, first_at, in_si, spaced, stiffened
from squama.errors import refuse
from squama.joints.choice import Joint, joint_of
from squama.joints.factor import MIRROR
from squama.loads import LOADS, STRAIGHT, STRAINS, holding
from squama.model.elastic_plate import BASE, SIDE_D, TIP
from squama.symbols import OF_A_SCALE, OTHER
from squama.types import Array
from squama.units import change

TAB_LIMIT = 0.025
"""Error of a torque by :func:`rigid_tab` from which on it is told; it may then be twice as large."""
STRAIN_LIMIT = 0.3
"""Twist per pitch, rad, up to which the model was compared with nonlinear elements."""
_NEAR, _SAME = 1e-5, 1e-6
OWN = (
    *(*MOTIONS, "stiffness_ratio", "slip", "deflection", "scale_twist", "stress", "stress_x", "stress_y", "strain"),
    *("pull_out", "tab_force", "tab_bending", "tab_torsion", "U_joint", "U_plate", "U_bar"),
    *("phi", "psi", "chi", "stretch", "T", "M", "M_lat", "P"),
)
"""Roles of variables that simpler models have not; strains and what holds them where the joint's matrix knows them."""
_ALONG = (
    "rate", "load", "torque", "scales", "tangent", "p", "s", "theta", "N", "f", "f0", "U_el", "W_fr", "W_snap", "RED",
    *OWN, *(role + OTHER for role in OF_A_SCALE),
)  # fmt: skip


class Bar(TypedDict):
    """What the contact solver takes of the bar: see :func:`squama.contacts.path.beams`."""

    free: Free
    aside: float
    seen: tuple[int, ...]
    own: tuple[float, ...]


class Held(NamedTuple):
    """What holds a beam's scales, and its figures in SI units.

    ``K`` is of scales on one face, ``rigidity`` is the beam's, in twisting. ``free``: strains without a moment or
    force; ``aside``: the bar's stiffness against lateral bend over that against bend. With scales on both faces
    ``seen`` and ``own`` as of :func:`squama.contacts.path.beams`.
    """

    joint: Joint
    K: Array
    K_theta: float
    rigidity: float
    free: Free
    aside: float
    seen: tuple[int, ...] = ()
    own: tuple[float, ...] = ()

    @property
    def bar(self) -> Bar:
        """What the contact solver takes of the bar, by argument."""
        return {"free": self.free, "aside": self.aside, "seen": self.seen, "own": self.own}

    @classmethod
    def of(cls, beam: Beam, *loaded: str) -> Held:
        """Return that of a beam with strains ``loaded``, by default the twist; refuse one whose joint is not known."""
        joint = joint_of(beam)
        if joint.K is None:
            refuse("joint", '"compliant"', joint.note, 'write joint="hinge" (--joint hinge)')
        K = np.asarray(joint.K, float)
        own = _own(beam, K) if beam.other else ()
        case = Case.held(beam, K, 1, own)
        bar, free = beam.substrate, beam.given.free(*(loaded or (LOADS["twisting"].verb,)))
        aside = (bar.width / bar.thickness) ** 2
        return cls(joint, K, case.stiffness, case.rigidity, free, aside, beam.given.seen, own)


def _own(beam: Beam, K: Array) -> tuple[float, ...]:
    """Return what the matrices K of both faces hold alike, E d^3: the bar's own stiffness against its four strains.

    A given inclusion factor is the whole beam's: what both hold of the twist is so large that it becomes that.
    """
    bend, twist, aside, stretch = joint_law.own(beam.sizes)
    if beam.joint.inclusion_factor is not None:
        whole = Case.held(beam, K, 1, (bend, 0.0, aside, stretch)).rigidity
        twist = (whole - beam.torsional_rigidity) / (beam.pitch * beam.unit_moment)
    # a matrix (7, 7) knows the twist alone
    return (bend, twist, aside, stretch) if len(K) == 9 else (0.0, twist, 0.0, 0.0)


def scale(beam: Beam, *, ideal: bool) -> path.Scale:
    """Return a beam's scale; ``ideal``: thin and rigid, elastic else where its modulus is known."""
    s, d = beam.scale, beam.pitch
    thin = path.Scale(beam.eta, beam.beta, beam.lam, s.alpha, s.theta0, 0.0)
    if ideal:
        return thin
    thick = thin._replace(h=s.thickness / d)
    if s.youngs_modulus is None:
        return thick
    return thick._replace(D=beam.plate_rigidity / beam.unit_moment, nu=s.nu)


class Path(NamedTuple):
    """A beam's path in one sense, see :class:`squama.curves.path.Solved`."""

    beam: Beam
    held: Held
    way: path.Path
    sign: int
    far: float

    @property
    def notes(self) -> list[str]:
        """Where the path leaves what the model was compared with."""
        return notes(self.held, self.beam, self.far, ideal=self.way.scale.h == 0)

    @property
    def faces(self) -> int:
        """On how many faces there are scales."""
        return len(self.way.contacts)

    @property
    def lead(self) -> int:
        """Number of the face whose scales touch first: 0 the scaled one, 1 the other."""
        return int(np.argmin([c.phi for c in self.way.contacts]))

    @property
    def seen(self) -> list[tuple[int, ...]]:
        """Signs of bend, twist and lateral bend that each face sees, that of the scaled one first."""
        return [(1, 1, 1), *([self.held.seen] if self.held.seen else [])]

    def contact(self, face: int) -> path.Contact:
        """Return what touches first on a face, as where the twist that the face sees is above 0."""
        met = self.way.contacts[face]
        return met if self.seen[face][1] > 0 else met.mirrored

    def hinged(self, face: int) -> bool:
        """Say whether the contact of a face is that of hinges: a tip edge on the side edge that a hinge's comes to."""
        return self.contact(face)[:2] == (TIP, SIDE_D)

    @property
    def case(self) -> Case:
        """What the beam and its joint bring."""
        beam, held = self.beam, self.held
        return Case(beam.pitch, held.rigidity, held.K_theta, beam.eta, beam.scale.theta0, self.sign < 0)

    @property
    def load_e(self) -> float:
        """Twist per pitch at the first engagement, inf for none."""
        return self.way.engaged

    @property
    def mirror(self) -> Array:
        """Signs of the nine motions: the other sense is followed as the mirror image."""
        return MIRROR if self.sign < 0 else np.ones(9)

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at evenly spaced twists, or at twists per pitch; NaN beyond an earlier end."""
        engaged = self.load_e
        if at is None:
            at = spaced(self.far, points, engaged)
            found = self._curve(at)
            cut = float(found.figures["load_end"])
            if math.isfinite(cut) and cut < self.far:
                # as many points up to an earlier end
                ended, found = found.figures, self._curve(spaced(cut * (1 - _NEAR), points, engaged))
                found.figures.update({role: ended[role] for role in ("end", "load_end", "rate_end") if role in ended})
            return found
        return self._curve(np.asarray(at, float))

    def _curve(self, at: Array) -> Curve:
        """Return the curve at twists per pitch; NaN beyond an earlier end."""
        engaged = self.load_e
        most = float(at.max(initial=0.0))
        fine = np.linspace(0.0, most, max(3, math.ceil(most / FINE) + 1))
        met = np.unique([c.phi for c in self.way.contacts])
        wanted = np.union1d(at, met[met < most])
        # no step may be much smaller than the others; twists that are all but equal are put between their neighbours
        bounds = np.concatenate([[-np.inf], wanted, [np.inf]])
        after = np.searchsorted(bounds, fine)
        apart = np.minimum(fine - bounds[after - 1], bounds[after] - fine)
        twists = np.union1d(wanted, fine[apart > _NEAR])
        meets, apart = np.isin(twists, met), np.diff(twists) > _SAME
        kept = np.append(True, apart) | meets
        kept[:-1] &= ~meets[1:] | apart
        answers = self.way.follow(twists[kept])
        faces, end = [face.rows[0] for face in answers.faces], answers.end()
        if not kept.all():
            faces = [np.column_stack([np.interp(twists, twists[kept], column) for column in rows.T]) for rows in faces]
        own = values(self, twists, *faces)
        own |= tangents(self.held.rigidity, self.beam.pitch, met, twists[kept], twists, own)
        which = np.searchsorted(twists, at)
        reached = np.flatnonzero(np.isfinite(own["torque"]))
        last = {role: float(v[reached[-1]]) if reached.size else math.nan for role, v in own.items()}
        found = {
            **figures(self.case, last, engaged, end.phi, last["theta"]),
            **ending(self, answers),
            **thresholds(engaged, self.beam, twists, own),
            "load_bent": _bent(self.way.scale, twists, faces),
        }
        if len(faces) > 1:
            found["load_e_other"] = self.way.contacts[1 - self.lead].phi
        return Curve({role: own[role][which] for role in _ALONG if role in own}, found)

    def states(self, twists: Array) -> tuple[Array, path.End]:
        """Follow the model's path, see :meth:`squama.contacts.path.Path.states`."""
        return self.way.states(twists)


def solve(asked: Asked) -> tuple[list[Path], States]:
    """Return the paths of a beam for each coefficient of friction."""
    beam, to, ideal = asked.beam, abs(asked.path.values[-1]), asked.ideal
    far = path.RANGE if to == math.inf else to
    if far >= math.pi:
        refuse("to", f"{far / beam.pitch:.6g} rad/m", "must be below half a turn per pitch")
    held, sign = Held.of(beam), -1 if asked.path.sense == "-" else 1
    plate = scale(beam, ideal=ideal)
    # engagement is told wherever it is, a short curve may end before
    last = 0.0 if asked.at is None else float(np.max(asked.at, initial=0.0))
    most = max(far, path.RANGE, last)
    found = []
    for mu in np.atleast_1d(asked.mus):
        way = path.Path.of(plate, held.K, float(mu), sense=sign, most=most, **held.bar)
        found.append(Path(beam, held, way, sign, far))
    far = far if asked.at is None else last
    return found, States({}, attributes(held, asked.path.load.verb), notes(held, beam, far, ideal=ideal))


def attributes(held: Held, *loaded: str) -> dict[str, float | str]:
    """Return what answers say of the joint, and of what holds a beam with strains ``loaded``."""
    fixed = [name for name, free in zip(STRAINS, held.free, strict=True) if not free and name not in loaded]
    straight = len(fixed) + len(loaded) == len(STRAINS)
    return {
        "K_theta": held.K_theta, "rigidity": held.rigidity, "joint_source": held.joint.source,
        "band": held.joint.band, "hold": STRAIGHT if straight else holding(fixed),
        "neutral": "free" if held.free[-1] else "middle",
    }  # fmt: skip


def rigid_tab(group: float, inclusion: float) -> float:
    """Return by about how much a torque is too high since the joint takes the embedded part as rigid (theory: joint).

    By the group (E_s/E)(t_s/L)^3 and the torque per twist over that of the bare bar, fitted to elements.
    """
    return 0.11 * (inclusion - 1) / (1 + group / 1.5)


def notes(held: Held, beam: Beam, far: float, *, ideal: bool) -> list[str]:
    """Say where a curve to the twist ``far`` (rad per pitch) leaves what the model was compared with."""
    lines = [held.joint.note] if held.joint.note else []
    if not beam.given.may and set(beam.held) < set(STRAINS):
        lines.append(
            "the beam is held straight: joint.matrix knows no bend (squama joint --matrix writes all nine motions)"
        )
    # a matrix of elements says for which shape it was made; in one that does not, or a factor, the tab's give is in
    matrix, factor = beam.joint.matrix, beam.joint.inclusion_factor
    measured = factor is not None or (matrix is not None and matrix.made.keys().isdisjoint(SHAPE))
    if beam.scale.youngs_modulus is not None and beam.zeta > 0 and not (ideal or measured):
        group = beam.modulus_ratio / beam.slenderness**3
        error = rigid_tab(group, held.rigidity / (beam.G_B * beam.J))
        if error > TAB_LIMIT:
            lines.append(
                f"the joint takes the embedded part of a scale as rigid, but it bends, with (E_s/E)(t_s/L)^3 = "
                f"{group:.2g}: the torque is too high by about {change(error)}"
            )
    if far > STRAIN_LIMIT:
        lines.append(
            f"the joint's stiffness is that of small strains: it was compared with nonlinear elements up to "
            f"{STRAIN_LIMIT:g} rad per pitch, and the curve goes to {far:.3g}"
        )
    return lines


def _bent(scale: path.Scale, twists: Array, faces: Sequence[Array]) -> float:
    """Return the twist at which a scale is first bent beyond the plate model, by the states of each face; else NaN."""
    found = [first_at(twists, states.bent(scale, rows), states.THIN) for rows in faces]
    return float(np.fmin.reduce(found))


def values(one: Path, twists: Array, *faces: Array) -> dict[str, Array]:
    """Return every variable at states, SI units, by role.

    ``faces``: rows of each face, that of the scaled one first. Figures of a scale are of the face that touches first.
    """
    column, lead = path.named(faces[0]), one.lead
    own = {name: column[name] for name in ("W_fr", "W_snap")} | states.energies(one.way, *faces)
    own["U_el"] = own["U_joint"] + own["U_plate"] + own["U_bar"]
    own["torque"], own["onset"], own["work"] = column["torque"], column["T_slip"], column["W"]
    own |= bar(one.held, column, mirrored=one.sign < 0) | _of_scale(one, faces[lead], lead)
    own |= of_other(_of_scale(one, faces[1 - lead], 1 - lead)) if faces[1:] else {}
    v = in_si(one.case, one.beam.substrate.youngs_modulus, twists, own)
    for face, rows in enumerate(faces):
        tab = embedded(one, path.motions(rows, one.seen[face]))
        v |= tab if face == lead else of_other(tab)
    return v


def _of_scale(one: Path, rows: Array, face: int) -> dict[str, Array]:
    """Return the figures of a scale at the states of its face, E = d = 1, by role.

    Places are told as where the twist that the face sees is above 0, all else along the scale's own axes.
    """
    column, scale = path.named(rows), one.way.scale
    own = {name: column[name] * sign for name, sign in zip(MOTIONS, one.mirror, strict=False)}
    own |= {name: column[name] for name in ("slip", "N", "f")} | {"p": column["x"], "s": column["y"]}
    if one.seen[face][1] < 0:
        own |= {role: np.where(across, -own[role], own[role]) for role, across in _across(column).items()}
    own["theta"] = states.inclinations(one.way, rows)
    own |= states.plate_figures(scale, path.deflections(rows))
    for role in ("scale_twist", "stress_y"):
        own[role] = own[role] * one.mirror[1]
    return own


def _across(column: dict[str, Array]) -> dict[str, Array]:
    """Return whether the places of the first contact, p and s, run across the scale, by states (n,)."""
    one, other = column["first"], column["second"]
    faced = (one == path.FACE) | (other == path.FACE)
    return {"p": ~faced & np.isin(one, (TIP, BASE)), "s": faced | np.isin(other, (TIP, BASE))}


def bar(held: Held, column: dict[str, Array], *, mirrored: bool = False) -> dict[str, Array]:
    """Return strains of the bar and what holds them, E = d = 1, by role: 0 of what is free; none of a matrix (7, 7).

    Of the mirror image lateral bends are the other way.
    """
    if len(held.K) < 9:
        return {}
    side = -1.0 if mirrored else 1.0
    psi, _, chi, eps = held.free
    # (adding 0 leaves no -0)
    loads = {"M": column["M"] * (1 - psi), "M_lat": side * column["B"] * (1 - chi), "P": column["P"] * (1 - eps)}
    strains = {"psi": column["psi"], "chi": side * column["aside"], "stretch": column["stretch"]}
    return {role: v + 0.0 for role, v in (strains | loads).items()}


def embedded(one: Path, q: Array) -> dict[str, Array]:
    """Return what acts on the embedded part, and strains around it, by role (:func:`squama.contacts.path.motions`)."""
    force, moment = states.on_tab(one.way, q)
    moment_unit = one.beam.unit_moment
    unit = moment_unit / one.beam.pitch
    strain = np.full(len(q), np.nan)
    if one.held.joint.strain is not None:
        n = min(q.shape[1], one.held.joint.strain.shape[-1])
        form, own = one.held.joint.strain[:, :n, :n], q[:, :n] * one.mirror[:n]
        strain = np.sqrt(np.einsum("ni,eij,nj->ne", own, form, own).max(axis=1))
    return {
        "pull_out": force[:, 0] * unit,
        "tab_force": np.linalg.norm(force, axis=1) * unit,
        "tab_bending": moment[:, 1] * moment_unit,
        "tab_torsion": moment[:, 0] * moment_unit * one.mirror[3],
        "strain": strain,
    }


def tangents(
    rigidity: float, d: float, engaged: Sequence[float] | Array, steps: Array, twists: Array, v: dict[str, Array]
) -> dict[str, Array]:
    """Return the tangent stiffness at load angles, from the steps among them, and over that without contact.

    ``rigidity`` is the one without contact, N m^2, ``engaged`` the rising load angles per pitch at engagement of each
    face, ``d`` the pitch.
    """
    torque = np.interp(steps, twists, v["torque"])
    slope = np.where(np.isfinite(torque), rigidity, np.nan)
    # it jumps at engagement
    jumps = [at for i, at in enumerate(engaged) if i == 0 or at - engaged[i - 1] > _NEAR]
    for begin, end in pairwise([*jumps, math.inf]):
        contact = np.flatnonzero((steps >= begin) & (steps <= end))
        if contact.size > 1:
            slopes = np.gradient(torque[contact], steps[contact] / d, edge_order=2 if contact.size > 2 else 1)
            slope[contact[steps[contact] < end]] = slopes[steps[contact] < end]
    found = np.interp(twists, steps, slope)
    found[twists < engaged[0]] = rigidity
    found[np.isnan(v["torque"])] = np.nan
    return {"tangent": found, "stiffness_ratio": found / rigidity}


def impossible(beam: Beam) -> str:
    """Return why a beam's joint is not known; empty where it is."""
    joint = joint_of(beam)
    return joint.note if joint.K is None else ""


def ending(one: Path, answers: path.Answers) -> dict[str, float | int | str]:
    """Return how a curve ends, what touches first, and what comes in next on a face, by role."""
    c, at, words = one.contact(one.lead), math.nan, ""
    (name,) = path.endings(np.array([c], float), answers.ends)
    for i, face in enumerate(answers.faces):
        events = face.events[0, : int(face.ends[0, 2])]
        second = events[(events[:, 0] == increments.ENGAGE) & (events[:, 13] > 1)][:1]
        if second.size and not second[0, 1] >= at:
            (first,), (other,) = path.features(*second[:, 8:11].T)
            met = path.Contact(int(first), int(other), int(second[0, 7]), at := float(second[0, 1]), 0.0, 0.0)
            met = met if one.seen[i][1] > 0 else met.mirrored
            words = f"{WHOSE * (i != one.lead)}{met.words} at {at:.4g} rad/pitch"
    return {
        "end": str(name),
        "neighbour": max(0, c.k) if c.first != -1 else 0,
        "other_contact": words,
        "first_contact": c.words,
        "load_second": at,
    }


def thresholds(engaged: float, beam: Beam, twists: Array, v: dict[str, Array]) -> dict[str, float]:
    """Return what replaces a lock: load angles, NaN where they are not reached, and the energy's error."""
    reached = np.isfinite(v["torque"])
    touching = reached & (twists >= engaged)
    x, torque = twists[reached], v["torque"][reached]
    found = stiffened(twists[touching], v["stiffness_ratio"][touching], x, torque)
    strength = beam.scale.strength
    found["load_strength"] = math.nan if strength is None else first_at(x, worst(v, "stress")[reached], strength)
    limit = beam.substrate.strain_limit
    found["load_strain"] = math.nan if limit is None else first_at(x, worst(v, "strain")[reached], limit)
    own = np.flatnonzero(np.isfinite(v["work"]))
    work, stored = (float(x[own[-1]]) for x in (v["work"], v["U_el"] + v["W_fr"] + v["W_snap"]))
    found["energy_error"] = (work - stored) / work if work > 0 else 0.0
    return found
