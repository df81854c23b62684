"""Polygons in the plane of bend and twist, of thin, rigid scales on hinges: states along them in SI units, and events.

One hinge has one stiffness: K_theta is that of twisting, in bend and in twist.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from squama.curves.path import Asked, States
from squama.loads import LOADS, neutral_height
from squama.model import energy
from squama.model.outcome import End
from squama.model.screw import CONTACTS, NONE
from squama.model.screw_free import relaxed
from squama.model.screw_path import Design, Piece, follow
from squama.types import Array

FEWEST = 4
"""Points of a piece at least, both its ends among them."""
SOFT = "contact {} bears on the root of the next scale, where a real bar bulges"
_FIGURES = ("psi", "phi", "kappa", "Phi", "theta")


def walk(asked: Asked) -> States:
    """Return the states along a path, its events, and how it ends."""
    beam, design = asked.beam, of(asked, float(asked.mus))
    pieces = list(follow(design, asked.path.points))
    parts: list[dict[str, Array]] = []
    legs: list[int] = []
    done = 0.0
    for piece in pieces:
        legs.append(legs[-1] + (piece.leg != pieces[len(parts) - 1].leg) if legs else 1)
        part = _evaluate(asked, piece, done)
        done = float(part["W_fr"][-1]) if part["W_fr"].size else done
        parts.append(part | {"leg": np.full(part["theta"].size, legs[-1])})
    along = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    last = pieces[-1]
    figures: dict[str, Array] = {
        "end": np.asarray(str(last.end or End.RANGE)),
        "other_contact": np.asarray(last.other),
        "K_theta": np.asarray(LOADS["twisting"].stiffness(beam)),
    }
    ends = dict(zip(_FIGURES, _place(asked, last, last.x1), strict=True))
    first = next((piece for piece in pieces if piece.contact), None)
    engaged = _place(asked, first, first.x0) if first else [math.nan] * len(_FIGURES)
    figures |= {f"{name}_end": np.asarray(v) for name, v in ends.items()}
    figures |= {f"{name}_e": np.asarray(v) for name, v in zip(_FIGURES[:-1], engaged, strict=False)}
    figures |= {f"{name}_c": along[name][-1] for name in ("M", "T", "W_fr", "RED")}
    attrs: dict[str, float | str] = {"margin": asked.margin, "neutral": asked.neutral, "load": "bending and twisting"}
    return States(
        {("point",): along, ("event",): _events(asked, pieces, parts, legs), (): figures},
        attrs,
        soft(pieces),
    )


def of(asked: Asked, mu: float) -> Design:
    """Return the ratios of a beam."""
    beam = asked.beam
    return Design(**beam.ratios, mu=mu, y_n=neutral_height(asked.neutral, beam.lam))


def soft(pieces: Sequence[Piece]) -> list[str]:
    """Return a warning for each contact at the base of a scale."""
    bases = dict.fromkeys(p.contact for p in pieces if p.contact and not CONTACTS[p.contact].tip)
    return [*map(SOFT.format, bases)]


def pole_of(piece: Piece) -> float:
    """Return where on a piece, or beyond it, its friction force has its pole."""
    ends = np.array([piece.x1]), np.array([piece.leg.design.mu]), "", np.array([piece.x0])
    return float(energy.pole(piece, *ends)[0])


def _place(asked: Asked, piece: Piece, x: float) -> list[float]:
    """Return bend and twist per pitch and per length, and inclination."""
    psi, phi = (float(v) for v in piece.leg.loads(np.asarray(x)))
    d = asked.beam.pitch
    return [psi, phi, psi / d, phi / d, float(piece.states(np.array([x]))["theta"][0])]


def _evaluate(asked: Asked, piece: Piece, done: float) -> dict[str, Array]:
    """Return every variable on a piece, ends (the cut-off before a lock) included."""
    beam, mu, x0 = asked.beam, float(asked.mus), piece.x0
    d, K = beam.pitch, LOADS["twisting"].stiffness(beam)
    unbounded = piece.end in (End.FRICTIONAL, End.KINEMATIC)
    x1 = float(energy.cutoff(piece, np.array([x0]), np.array([piece.x1]), np.array([unbounded]), asked.margin)[0])
    # what locks as soon as it touches or turns has no forces
    w = np.linspace(0, 1, max(FEWEST, round(asked.points * (piece.x1 - x0)))) if x1 > x0 else np.zeros(0)
    # closer together where the curve steepens
    x = x0 + (x1 - x0) * (1 - (1 - w) ** 2 if piece.end else w)
    state, (psi, phi) = piece.states(x), piece.leg.loads(x)
    work = np.zeros(x.size)
    if piece.contact and mu and x.size:
        work = energy.work(piece, x0, x1, pole_of(piece), mu, "")(x)
    return in_si(asked, np.full(x.size, piece.contact, "U5"), psi, phi, state, done + work * K / d)


def in_si(
    asked: Asked, contact: Array, psi: Array, phi: Array, state: Mapping[str, Array], W_fr: Array
) -> dict[str, Array]:
    """Give states their units, with the bar's part, energies and RED."""
    beam, mu = asked.beam, float(asked.mus)
    d, K = beam.pitch, LOADS["twisting"].stiffness(beam)
    kappa, Phi = psi / d, phi / d
    bar = {"M": LOADS["bending"].rigidity(beam) * kappa, "T": LOADS["twisting"].rigidity(beam) * Phi}
    joints = K / d * (state["theta"] - beam.scale.theta0) ** 2
    U_el = (bar["M"] * kappa + bar["T"] * Phi + joints) / 2
    total = U_el + W_fr
    return {
        "contact": contact,
        "psi": psi, "phi": phi, "kappa": kappa, "Phi": Phi, "theta": state["theta"],
        "M": bar["M"] + K * state["M"], "M_scales": K * state["M"],
        "T": bar["T"] + K * state["T"], "T_scales": K * state["T"],
        "N": K / d * state["N"], "f": mu * K / d * state["N"], "mu_lock": state["mu_lock"],
        "U_el": U_el, "W_fr": W_fr, "RED": np.divide(W_fr, total, out=np.zeros(psi.size), where=total > 0),
    }  # fmt: skip


def relax(asked: Asked, free: int) -> States:
    """Return the states of one load imposed and the other left free (axis ``free``), up to where it has no value."""
    beam = asked.beam
    load = LOADS["twisting" if free else "bending"]
    K, d = LOADS["twisting"].stiffness(beam), beam.pitch
    imposed = np.linspace(0.0, asked.path.points[0][1 - free], asked.points)
    found = relaxed(of(asked, float(asked.mus)), imposed, load.rigidity(beam) / (K * d), free=free)
    kept = np.isfinite(found.theta)
    psi, phi, contact = found.psi[kept], found.phi[kept], found.contact[kept]
    none = np.full(psi.size, np.nan)
    state = {"theta": found.theta[kept], "N": found.N[kept], "M": found.M[kept], "T": found.T[kept], "mu_lock": none}
    along = in_si(asked, contact, psi, phi, state, 0 * psi) | {"leg": np.ones(psi.size, int)}
    # rounding of the balance
    along["T" if free else "M"] *= 0
    changed = np.flatnonzero(contact[1:] != contact[:-1]) + 1
    end = str(End.RANGE if kept.all() else End.STOPPED)
    words = [
        f"engagement ({b})" if not a else f"{a} to {b}" if b else "release" for a, b in pairwise(contact[[0, *changed]])
    ]
    places = np.append(changed, psi.size - 1)
    events = {name: along[name.removesuffix("_event")][places] for name in (f"{n}_event" for n in _FIGURES)}
    events |= {"event": np.array([*words, end]), "event_leg": np.ones(places.size, int)}
    first = changed[0] if changed.size else None
    figures = {"end": np.asarray(end), "other_contact": np.asarray(""), "K_theta": np.asarray(K)}
    figures |= {f"{name}_end": along[name][-1] for name in _FIGURES}
    figures |= {f"{n}_e": np.asarray(math.nan) if first is None else along[n][first] for n in _FIGURES[:-1]}
    figures |= {f"{name}_c": along[name][-1] for name in ("M", "T", "W_fr", "RED")}
    attrs = {"neutral": asked.neutral, "load": "bending and twisting", "free": load.name}
    return States({("point",): along, ("event",): events, (): figures}, attrs)


def _events(
    asked: Asked, pieces: Sequence[Piece], parts: Sequence[dict[str, Array]], legs: Sequence[int]
) -> dict[str, Array]:
    """Return what happens at the ends of pieces, where, and by how much M and T jump there."""
    rows = []
    for i, piece in enumerate(pieces):
        after = pieces[i + 1] if i + 1 < len(pieces) else None
        # no force where scales come together or part
        held = after and piece.contact and after.contact and parts[i + 1]["M"].size
        jumps = [float(parts[i + 1][name][0] - parts[i][name][-1]) if held else 0.0 for name in ("M", "T")]
        rows.append((_words(piece, after), legs[i], *_place(asked, piece, piece.x1), *jumps))
    names = ("event", "event_leg", *(f"{name}_event" for name in _FIGURES), "M_jump", "T_jump")
    return {name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}


def _words(piece: Piece, after: Piece | None) -> str:
    """Say what happens at the end of a piece."""
    if after is None:
        return str(piece.end or End.RANGE)
    if piece.contact == after.contact:
        return "corner"
    if piece.contact == NONE:
        return f"engagement ({after.contact})"
    return f"{piece.contact} to {after.contact}" if after.contact else "release"
