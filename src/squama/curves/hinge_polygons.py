"""Paths in the plane of bend and twist for thin, rigid scales on hinges: states in SI units, and events."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from squama.arrays.combined_states import Combined, combined
from squama.curves import both_faces
from squama.curves.curve_figures import PLACES, dissipation, path_figures, table
from squama.curves.way import OPEN, SLIDING, VERBS, Analysis, States
from squama.loads import LOADS, STRAINS, holding, neutral_height
from squama.model import energy
from squama.model.outcome import End
from squama.model.screw import CONTACTS, LOCKED, NONE
from squama.model.screw_free import relaxed
from squama.model.screw_path import Design, Piece, follow
from squama.types import Array

FEWEST = 4
"""Smallest number of points of a piece, both ends included."""
SOFT = "contact {} bears on the root of the next scale, where a real bar bulges"
SAMPLES, HALVINGS = 32, 8
"""Samples on the way to a state of a plane in the search of a lock, and halvings that locate it."""
_NEXT = "on hinges the next scale's eight contacts are looked at; other pairs of plates are not"
_SAME = 1e-9
"""Difference of places on a way that is due to rounding."""


class Span(NamedTuple):
    """A part of a way, from x0 to x1, on which no face's contact changes: a piece of each face's path.

    ``leg`` is the number of the way, from 1; ``end`` is why the path ends there, else "".
    """

    pieces: tuple[Piece, ...]
    leg: int
    x0: float
    x1: float
    end: End | str = ""
    other: str = ""

    @property
    def contacts(self) -> tuple[str, ...]:
        """Contact on each face."""
        return tuple(piece.contact for piece in self.pieces)


def polygon(analysis: Analysis) -> States:
    """Return the states along a way, its events, and its end; with a free load those of :func:`relax`."""
    if analysis.way.free is not None:
        return relax(analysis, analysis.way.free)
    beam, spans = analysis.beam, _spans(analysis)
    parts: list[dict[str, Array]] = []
    done = 0.0
    for span in spans:
        part = _evaluate(analysis, span, done)
        done = float(part["W_fr"][-1]) if part["W_fr"].size else done
        parts.append(part | {"leg": np.full(part["theta"].size, span.leg)})
    along = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    last = spans[-1]
    ended, first = _place(analysis, last, last.x1), next((span for span in spans if any(span.contacts)), None)
    engaged = _place(analysis, first, first.x0) if first else dict.fromkeys(PLACES, math.nan)
    end, K = str(last.end or End.RANGE), beam.joint_stiffness
    figures = path_figures(along, engaged, ended, end, last.other, K)
    attrs: dict[str, float | str] = {
        "margin": analysis.margin,
        "neutral": analysis.beam.neutral,
        "load": "bending and twisting",
    }
    return States(
        {("point",): along, ("event",): _events(analysis, spans, parts), (): figures},
        attrs,
        soft([piece for span in spans for piece in span.pieces]),
    )


def _spans(analysis: Analysis) -> list[Span]:
    """Return the parts of a path with scales on every face, up to where the first face ends."""
    design, faces = of(analysis, float(analysis.mus)), []
    for bend, twist in both_faces.views(analysis.beam):
        pieces = list(follow(design, [(bend * psi, twist * phi) for psi, phi in analysis.way.corners]))
        legs = np.cumsum([1, *(a.leg != b.leg for a, b in pairwise(pieces))]).tolist()
        faces.append([Span((p,), leg, p.x0, p.x1, p.end, p.other) for leg, p in zip(legs, pieces, strict=True)])
    if len(faces) == 1:
        return faces[0]
    lasts = [face[-1] for face in faces]
    which = min((0, 1), key=lambda i: (lasts[i].leg, lasts[i].x1))
    last, found = lasts[which], []
    cuts = sorted({(one.leg, one.x1) for face in faces for one in face if (one.leg, one.x1) <= (last.leg, last.x1)})
    leg, x0 = 1, 0.0
    for number, x1 in cuts:
        x0 = x0 if number == leg else 0.0
        leg = number
        if x1 - x0 > _SAME:
            at = (leg, (x0 + x1) / 2)
            both = tuple(next(one for one in face if (one.leg, one.x1) >= at).pieces[0] for face in faces)
            found.append(Span(both, leg, x0, x1))
            x0 = x1
    other = both_faces.WHOSE * bool(which and last.other) + last.other
    return [*found[:-1], found[-1]._replace(end=last.end, other=other)]


def of(analysis: Analysis, mu: float) -> Design:
    """Return the design of a beam with the friction ``mu``."""
    beam = analysis.beam
    return Design(**beam.ratios, mu=mu, y_n=neutral_height(beam.neutral, beam.lam))


def soft(pieces: Sequence[Piece]) -> list[str]:
    """Return a warning for each contact at the base of a scale."""
    bases = dict.fromkeys(p.contact for p in pieces if p.contact and not CONTACTS[p.contact].tip)
    return [*map(SOFT.format, bases)]


def _place(analysis: Analysis, span: Span, x: float) -> dict[str, float]:
    """Return bend, twist and inclination of a span at a place on its way."""
    piece, d = span.pieces[0], analysis.beam.pitch
    psi, phi = (float(v) for v in piece.leg.loads(np.asarray(x)))
    theta = float(piece.states(np.array([x]))["theta"][0])
    return dict(zip(PLACES, (psi, phi, psi / d, phi / d, theta), strict=True))


def _evaluate(analysis: Analysis, span: Span, done: float) -> dict[str, Array]:
    """Return the variables on a span, ends (the cut-off before a lock) included.

    ``done``: frictional work before it, J/m.
    """
    beam, mu, x0, x1 = analysis.beam, float(analysis.mus), span.x0, span.x1
    d, K = beam.pitch, beam.joint_stiffness
    if span.end in (End.FRICTIONAL, End.KINEMATIC):
        locks = [p for p in span.pieces if p.end == span.end]
        start, stop, unbounded = np.array([x0]), np.array([x1]), np.array([True])
        x1 = min(float(energy.cutoff(p, start, stop, unbounded, analysis.margin)[0]) for p in locks)
    # a contact that locks at engagement or at a reversal has no forces
    w = np.linspace(0, 1, max(FEWEST, round(analysis.points * (span.x1 - x0)))) if x1 > x0 else np.zeros(0)
    # closer together where the curve steepens
    x = x0 + (x1 - x0) * (1 - (1 - w) ** 2 if span.end else w)
    psi, phi = span.pieces[0].leg.loads(x)
    states, work = [piece.states(x) for piece in span.pieces], np.zeros(x.size)
    for piece in span.pieces:
        if piece.contact and mu and x.size:
            pole = energy.pole(piece, np.array([piece.x1]), np.array([mu]), "", np.array([piece.x0]))
            work += energy.work(piece, x0, x1, float(pole[0]), mu, "")(x)
    contacts = [np.full(x.size, contact, "U5") for contact in span.contacts]
    return in_si(analysis, contacts, psi, phi, states, done + work * K / d)


def in_si(
    analysis: Analysis,
    contacts: Sequence[Array],
    psi: Array,
    phi: Array,
    states: Sequence[Mapping[str, Array]],
    W_fr: Array,
) -> dict[str, Array]:
    """Return the states of all faces in SI units, with the bar's part, energies and RED."""
    beam = analysis.beam
    d, K = beam.pitch, beam.joint_stiffness
    kappa, Phi = psi / d, phi / d
    bar = {"M": LOADS["bending"].rigidity(beam) * kappa, "T": LOADS["twisting"].rigidity(beam) * Phi}
    seen = list(zip(both_faces.views(beam), states, strict=True))
    M, T = (K * np.sum([signs[i] * one[name] for signs, one in seen], axis=0) for i, name in enumerate("MT"))
    joints = K / d * np.sum([(one["theta"] - beam.scale.theta0) ** 2 for one in states], axis=0)
    other = {}
    if len(states) > 1:
        other = both_faces.of_other({"contact": contacts[1], **_of_scale(analysis, states[1])})
    U_el = (bar["M"] * kappa + bar["T"] * Phi + joints) / 2
    return {
        "contact": contacts[0],
        "psi": psi,
        "phi": phi,
        "kappa": kappa,
        "Phi": Phi,
        **_of_scale(analysis, states[0]),
        "M": bar["M"] + M,
        "M_scales": M,
        "T": bar["T"] + T,
        "T_scales": T,
        "U_el": U_el,
        "W_fr": W_fr,
        "RED": dissipation(U_el, W_fr),
        **other,
    }


def _of_scale(analysis: Analysis, state: Mapping[str, Array]) -> dict[str, Array]:
    """Return the variables of a scale in SI units."""
    N = analysis.beam.joint_stiffness / analysis.beam.pitch * state["N"]
    return {"theta": state["theta"], "N": N, "f": float(analysis.mus) * N, "mu_lock": state["mu_lock"]}


def relax(analysis: Analysis, free: int) -> States:
    """Return the states with one load imposed and the other free (axis ``free``), as far as there is a solution."""
    beam = analysis.beam
    load = LOADS["twisting" if free else "bending"]
    K, d = beam.joint_stiffness, beam.pitch
    imposed = np.linspace(0.0, analysis.way.corners[0][1 - free], analysis.points)
    found = relaxed(of(analysis, float(analysis.mus)), imposed, load.rigidity(beam) / (K * d), free=free)
    kept = np.isfinite(found.theta)
    psi, phi, contact = found.psi[kept], found.phi[kept], found.contact[kept]
    none = np.full(psi.size, np.nan)
    state = {"theta": found.theta[kept], "N": found.N[kept], "M": found.M[kept], "T": found.T[kept], "mu_lock": none}
    along = in_si(analysis, [contact], psi, phi, [state], 0 * psi) | {"leg": np.ones(psi.size, int)}
    # rounding of the balance
    along["T" if free else "M"] *= 0
    changed = np.flatnonzero(contact[1:] != contact[:-1]) + 1
    end = str(End.RANGE if kept.all() else End.STOPPED)
    words = [
        f"engagement ({b})" if not a else f"{a} to {b}" if b else "release" for a, b in pairwise(contact[[0, *changed]])
    ]
    places = np.append(changed, psi.size - 1)
    events = {f"{name}_event": along[name][places] for name in PLACES}
    events |= {"event": np.array([*words, end]), "event_leg": np.ones(places.size, int)}
    engaged, ended = ({name: float(along[name][i]) for name in PLACES} for i in (changed[0] if changed.size else 0, -1))
    engaged = engaged if changed.size else dict.fromkeys(PLACES, math.nan)
    figures = path_figures(along, engaged, ended, end, "", K)
    attrs = {"neutral": analysis.beam.neutral, "load": "bending and twisting", "free": load.name}
    attrs["hold"] = holding(name for name in STRAINS if name not in VERBS)
    return States({("point",): along, ("event",): events, (): figures}, attrs)


def _events(analysis: Analysis, spans: Sequence[Span], parts: Sequence[dict[str, Array]]) -> dict[str, Array]:
    """Return the events at the ends of spans, their places, and the jumps of M and T."""
    rows: list[dict[str, float | int | str]] = []
    for i, span in enumerate(spans):
        after = spans[i + 1] if i + 1 < len(spans) else None
        # no force jumps where scales engage or part
        held = after and parts[i + 1]["M"].size and any(map(min, zip(span.contacts, after.contacts, strict=True)))
        jumps = {f"{v}_jump": float(parts[i + 1][v][0] - parts[i][v][-1]) if held else 0.0 for v in ("M", "T")}
        places = {f"{name}_event": v for name, v in _place(analysis, span, span.x1).items()}
        rows.append({"event": _words(span, after), "event_leg": span.leg, **places, **jumps})
    return table(rows)


def _words(span: Span, after: Span | None) -> str:
    """Return the event at the end of a span in words."""
    if after is None:
        return str(span.end or End.RANGE)
    found = []
    for face, (a, b) in zip(("", both_faces.WHOSE), zip(span.contacts, after.contacts, strict=True), strict=False):
        if a != b:
            found.append(face + (f"engagement ({b})" if a == NONE else f"{a} to {b}" if b else "release"))
    return "; ".join(found) or "corner"


def plane(analysis: Analysis, psi: Array, phi: Array) -> States:
    """Return the states at bends and twists (n,), each straight from rest, or the end of the way there."""
    beam, mu, height = analysis.beam, float(analysis.mus), neutral_height(analysis.beam.neutral, analysis.beam.lam)

    def at(w: Array, which: Array) -> Combined:
        ways = psi[which][:, None], phi[which][:, None]
        return combined(w * ways[0], w * ways[1], **beam.ratios, mu=mu, toward=ways, neutral_height=height)

    def stops(s: Combined) -> Array:
        return np.asarray((s.contact == LOCKED) | ((s.contact != "") & (s.mu_lock > 0) & (s.mu_lock <= mu)))

    w, every = np.arange(1, SAMPLES + 1) / SAMPLES, np.arange(psi.size)
    s = at(w, every)
    ended = stops(s).any(axis=1)
    which = np.flatnonzero(ended)
    high = w[stops(s)[which].argmax(axis=1)][:, None]
    low = high - 1 / SAMPLES
    for _ in range(HALVINGS):
        beyond = stops(at((low + high) / 2, which))
        low, high = np.where(beyond, low, (low + high) / 2), np.where(beyond, (low + high) / 2, high)
    state = np.where(s.contact[:, -1] == "", OPEN, SLIDING).astype("U40")
    state[which] = np.where(at(high, which).contact[:, 0] == LOCKED, End.LINE, End.FRICTIONAL)
    forces = {"N": s.normal, "M": s.bending_moment, "T": s.torque, "theta": s.theta, "mu_lock": s.mu_lock}
    last = {name: np.where(ended, np.nan, v[:, -1]) for name, v in forces.items()}
    contact = np.where(s.contact[:, -1] == LOCKED, "", s.contact[:, -1])
    v = in_si(analysis, [contact], psi, phi, [last], np.full(psi.size, np.nan))
    kept = ("contact", "theta", "N", "M", "M_scales", "T", "T_scales", "mu_lock")
    return States({(): {"state": state} | {name: v[name] for name in kept}}, notes=[_NEXT])
