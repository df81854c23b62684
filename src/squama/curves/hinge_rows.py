"""A row of N hinged scales without periodicity: the inclination of every scale along the twist, in SI units."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import cumulative_simpson

from squama.beam.design import Beam
from squama.curves import doors
from squama.curves.hinge import before
from squama.curves.labelled import Answer
from squama.curves.path import Asked, States
from squama.model import chain, chain_track
from squama.model.outcome import End
from squama.model.reach import SEARCH
from squama.types import Array

STEPS = 40
"""Steps that a row takes at least, however few points are asked for."""


def solve(asked: Asked) -> States:
    """Follow a row to the asked twist, or to the cut-off of the endless beam's curve."""
    beam, n, d, m = asked.beam, asked.beam.scales, asked.beam.pitch, float(asked.mus)
    (to,), sense = asked.path.values, asked.path.sense
    endless = doors.respond(beam, "twisting", mu=m, points=3, sense=sense, joint="hinge", ideal=asked.ideal)
    stop = float(endless["Phi_c"]) * d if math.isinf(to) else abs(to)
    alpha = math.copysign(beam.scale.alpha, to)
    ratios = beam.eta, beam.beta, beam.lam, math.sin(alpha), math.cos(alpha), beam.scale.theta0
    design = chain.Row(*ratios, m, n, asked.thickness)
    phi_e = float(endless["phi_e"])
    path = _path(design, endless, phi_e, stop, asked.points)
    along, each = _values(beam, design, path, phi_e, asked.points)
    same = doors.respond(beam, "twisting", mu=m, at=along["Phi"], sense=sense, joint="hinge", ideal=asked.ideal)
    along |= {"phi": along["Phi"] * d, "T_periodic": same["T"], "theta_periodic": same["theta"]}
    figures = {
        "phi_e": phi_e,
        "phi_end": math.inf if path.end is End.NONE else path.phi_end,
        "end": str(path.end),
        "scale_end": 0 if path.end in (End.RANGE, End.NONE) else path.scale + 1,
        "other_contact": path.other,
        "decay": _decay(design, phi_e),
    }
    single = {name: np.asarray(value) for name, value in figures.items()}
    return States({("point",): along, ("point", "scale"): each, (): single})


def _path(design: chain.Row, endless: Answer, phi_e: float, stop: float, points: int) -> chain_track.Track:
    """Follow the row from engagement to ``stop`` or to its end."""
    k = int(endless["neighbour"])
    if k == 0:
        touch = float(endless["phi_touch"])
        last = min(stop, touch if math.isfinite(touch) else SEARCH)
        other = str(endless["other_contact"].item()) if last < stop else ""
        return chain_track.Track([], End.OTHER if other else End.NONE, 0, other, last)
    if stop <= phi_e:
        return chain_track.Track([], End.RANGE, 0, "", stop)
    if k > 1:
        return chain_track.Track([], End.OTHER, 0, f"tip edge of scale 1 on side edge of scale {1 + k}", phi_e)
    n = max(2, points - before(points))
    fine = math.ceil(STEPS / (n - 1))
    found = chain_track.track(design, phi_e, np.linspace(phi_e, stop, fine * (n - 1) + 1)[1:])
    kept = found.states[::fine]
    if found.states and kept[-1] is not found.states[-1]:
        kept.append(found.states[-1])
    return found._replace(states=kept)


def _values(
    beam: Beam, design: chain.Row, path: chain_track.Track, phi_e: float, points: int
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return everything along the twist in SI units, of the row (points,) and of each scale (points, scales).

    The straight part comes first, then the states of the row.
    """
    d, K, n = beam.pitch, beam.joint_stiffness, design.scales
    first = before(points) if path.states else points
    straight = np.linspace(0.0, min(phi_e, path.phi_end), first, endpoint=not path.states)
    phi = np.concatenate([straight, [s.phi for s in path.states]])
    size, k = phi.size, straight.size
    theta, N, Q = np.full((size, n), design.theta0), np.zeros((size, n)), np.zeros((size, n))
    places = np.full((2, size, n), np.nan)
    torque, power = np.zeros(size), np.zeros(size)
    for i, s in enumerate(path.states, start=k):
        theta[i], N[i], Q[i] = s.theta, s.N, s.Q
        e = chain.terms(design, chain.frame(design, s.phi), s.theta[:-1], s.theta[1:], s.w[:-1], s.w[1:])
        torque[i] = (s.N[:-1] * e.torque).sum()
        power[i] = (s.N[:-1] * e.friction).sum()
        places[:, i, :-1] = np.where(s.closed[:-1], [e.c.p, e.c.s], np.nan)
    work = np.zeros(size)
    if len(path.states) > 2:
        work[k:] = cumulative_simpson(power[k:], x=phi[k:], initial=0.0)
    N[:, -1] = np.nan
    elastic = 0.5 * (
        beam.torsional_rigidity * (phi / d) ** 2 + K * ((theta - design.theta0) ** 2).sum(axis=1) / (n * d)
    )
    work *= K / (n * d)
    scales = K * torque / n
    total = elastic + work
    along = {
        "Phi": phi / d,
        "T": beam.torsional_rigidity * phi / d + scales,
        "T_scales": scales,
        "U_el": elastic,
        "W_fr": work,
        "RED": np.divide(work, total, out=np.zeros(size), where=total > 0),
    }
    each = {"theta": theta, "N": N * K / d, "f": design.mu * N * K / d, "p": places[0] * d, "s": places[1] * d}
    return along, {**each, "Q": Q * K}


def _decay(design: chain.Row, phi_e: float) -> float:
    """Return how much of an end's effect is left one scale further on: lever of the side contact over the tip's."""
    if not math.isfinite(phi_e):
        return math.nan
    c = chain.pair(design, chain.frame(design, phi_e), design.theta0, design.theta0)
    return float(-c.g_b / c.g_a)
