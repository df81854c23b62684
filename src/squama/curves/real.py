"""The real beam in SI units: thick, elastic scales on a joint that gives, by :mod:`squama.contacts`.

A scale has six motions against the substrate (:mod:`squama.joints`) and bends where its modulus is known; ``ideal``
makes it thin and rigid. All contacts of neighbouring scales are followed (:mod:`squama.contacts`).
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypedDict

import numpy as np

from squama.beam.design import Beam
from squama.beam.joint_law import Free
from squama.beam.matrixfile import MOTIONS, SHAPE
from squama.contacts import increments, path, states
from squama.curves.both_faces import worst
from squama.curves.path import FINE, Asked, Case, Curve, States, figures, first_at, in_si, spaced, stiffened
from squama.errors import refuse
from squama.joints.choice import Joint, joint_of
from squama.joints.factor import MIRROR
from squama.loads import LOADS, STRAIGHT, STRAINS, holding
from squama.model.elastic_plate import SIDE_D, TIP
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
    *OWN,
)  # fmt: skip


class Bar(TypedDict):
    """Which strains of the bar are free, and its stiffness against lateral bend over that against bend."""

    free: Free
    aside: float


class Held(NamedTuple):
    """What holds a beam's scales, and its figures in SI units.

    ``K`` and the rigidity ``alone`` are those of scales on one face, ``rigidity`` is the beam's, in twisting. ``free``:
    strains without a moment or force; ``aside``: the bar's stiffness against lateral bend over that against bend.
    """

    joint: Joint
    K: Array
    K_theta: float
    rigidity: float
    alone: float
    free: Free
    aside: float

    @property
    def bar(self) -> Bar:
        """What the contact solver takes of the bar, by argument."""
        return {"free": self.free, "aside": self.aside}

    @property
    def more(self) -> float:
        """What tabs of the other face add to the rigidity, N m^2."""
        return self.rigidity - self.alone

    @classmethod
    def of(cls, beam: Beam, *loaded: str) -> Held:
        """Return that of a beam with strains ``loaded``, by default the twist; refuse one whose joint is not known."""
        joint = joint_of(beam)
        if joint.K is None:
            refuse("joint", '"compliant"', joint.note, 'write joint="hinge" (--joint hinge)')
        K = np.asarray(joint.K, float)
        case = Case.held(beam, K, 1)
        bare = beam.G_B * beam.J
        rigidity = float(beam.given.gathered(case.rigidity / bare)) * bare if beam.other else case.rigidity
        bar, free = beam.substrate, beam.given.free(*(loaded or (LOADS["twisting"].verb,)))
        return cls(joint, K, case.stiffness, rigidity, case.rigidity, free, (bar.width / bar.thickness) ** 2)


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
    def hinged(self) -> bool:
        """Whether the contact is that of hinges: a tip edge on the side edge that a hinge's comes to."""
        return self.way.contact[:2] == (TIP, SIDE_D)

    @property
    def case(self) -> Case:
        """What the beam and its joint bring."""
        beam, held = self.beam, self.held
        return Case(beam.pitch, held.rigidity, held.K_theta, beam.eta, beam.scale.theta0, self.sign < 0)

    @property
    def load_e(self) -> float:
        """Twist per pitch at engagement, inf for none."""
        return self.way.contact.phi

    @property
    def mirror(self) -> Array:
        """Signs of the nine motions: the other sense is followed as the mirror image."""
        return MIRROR if self.sign < 0 else np.ones(9)

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at evenly spaced twists, or at twists per pitch; NaN beyond an earlier end."""
        engaged = self.way.contact.phi
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
        engaged = self.way.contact.phi
        most = float(at.max(initial=0.0))
        fine = np.linspace(0.0, most, max(3, math.ceil(most / FINE) + 1))
        wanted = np.union1d(at, engaged) if engaged < most else np.unique(at)
        # no step may be much smaller than the others; twists that are all but equal are put between their neighbours
        bounds = np.concatenate([[-np.inf], wanted, [np.inf]])
        after = np.searchsorted(bounds, fine)
        apart = np.minimum(fine - bounds[after - 1], bounds[after] - fine)
        twists = np.union1d(wanted, fine[apart > _NEAR])
        kept = np.append(True, np.diff(twists) > _SAME) | (twists == engaged)
        kept[:-1] &= ~(twists[1:] == engaged) | (engaged - twists[:-1] > _SAME)
        answers = self.way.follow(twists[kept])
        rows, end = answers.rows[0], answers.end()
        if not kept.all():
            rows = np.column_stack([np.interp(twists, twists[kept], column) for column in rows.T])
        own = values(self, twists, rows)
        own |= tangents(self.held.rigidity, self.beam.pitch, engaged, twists[kept], twists, own)
        which = np.searchsorted(twists, at)
        reached = np.flatnonzero(np.isfinite(own["torque"]))
        last = {role: float(v[reached[-1]]) if reached.size else math.nan for role, v in own.items()}
        found = {
            **figures(self.case, last, engaged, end.phi, last["theta"]),
            **ending(self.way, answers),
            **thresholds(engaged, self.beam, twists, own),
            "load_bent": first_at(twists, states.bent(self.way.scale, rows), states.THIN),
        }
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
    if not beam.given.may and set(beam.held) < set(STRAINS) and not beam.other:
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


def values(one: Path, twists: Array, rows: Array) -> dict[str, Array]:
    """Return every variable at the states of ``rows``, SI units, by role."""
    way = one.way
    column = path.named(rows)
    own = {name: column[name] * sign for name, sign in zip(MOTIONS, one.mirror, strict=False)}
    own |= {name: column[name] for name in ("slip", "N", "f", "W_fr", "W_snap")} | {"p": column["x"], "s": column["y"]}
    own |= states.energies(way, rows)
    own["U_el"] = own["U_joint"] + own["U_plate"] + own["U_bar"]
    own["torque"], own["onset"], own["work"] = column["torque"], column["T_slip"], column["W"]
    own |= bar(one.held, column, mirrored=one.sign < 0)
    if one.beam.other:
        # what each face alone would take beside M and T is not told
        own = {role: v for role, v in own.items() if role not in ("psi", "chi", "M_lat", "P")}
    if one.held.more:
        more = one.held.more / (one.beam.pitch * one.beam.unit_moment)
        own |= {role: own[role] + more * twists for role in ("torque", "onset")}
        own |= {role: own[role] + more * twists**2 / 2 for role in ("U_bar", "U_el", "work")}
    own["theta"] = states.inclinations(way, rows)
    own |= states.plate_figures(way.scale, path.deflections(rows))
    for role in ("scale_twist", "stress_y"):
        own[role] = own[role] * one.mirror[1]
    v = in_si(one.case, one.beam.substrate.youngs_modulus, twists, own)
    return v | embedded(one, path.motions(rows))


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
    rigidity: float, d: float, engaged: float, steps: Array, twists: Array, v: dict[str, Array]
) -> dict[str, Array]:
    """Return the tangent stiffness at load angles, from the steps among them, and over that without contact.

    ``rigidity`` is the one without contact, N m^2, ``engaged`` the load angle per pitch at engagement, ``d`` the pitch.
    """
    torque = np.interp(steps, twists, v["torque"])
    slope = np.where(np.isfinite(torque), rigidity, np.nan)
    contact = np.flatnonzero(steps >= engaged)
    if contact.size > 1:
        slope[contact] = np.gradient(torque[contact], steps[contact] / d, edge_order=2 if contact.size > 2 else 1)
    found = np.interp(twists, steps, slope)
    # it jumps at engagement
    found[twists < engaged] = rigidity
    found[np.isnan(v["torque"])] = np.nan
    return {"tangent": found, "stiffness_ratio": found / rigidity}


def impossible(beam: Beam) -> str:
    """Return why a beam's joint is not known; empty where it is."""
    joint = joint_of(beam)
    return joint.note if joint.K is None else ""


def ending(way: path.Path, answers: path.Answers) -> dict[str, float | int | str]:
    """Return how a curve ends, what touches first, and what comes in next, by role."""
    c = way.contact
    (name,) = path.endings(np.array([c], float), answers.ends)
    events = answers.events[0, : int(answers.ends[0, 2])]
    second = events[(events[:, 0] == increments.ENGAGE) & (events[:, 13] > 1)][:1]
    at, words = math.nan, ""
    if second.size:
        ((one,), (other,)), at = path.features(*second[:, 8:11].T), float(second[0, 1])
        words = f"{path.words(int(one), int(other), int(second[0, 7]))} at {at:.4g} rad/pitch"
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
