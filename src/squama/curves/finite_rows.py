"""A row of N scales without periodicity: from a beam to the inclination of every scale, along the twist."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_simpson

from squama import arguments
from squama.arrays.solution import SEARCH
from squama.beam.design import Beam
from squama.curves import doors
from squama.curves.hinge import LINEAR
from squama.curves.labelled import Answer, Labelled, attributes, labelled
from squama.curves.path import Asked, LoadPath, States
from squama.loads import LOADS
from squama.model import chain, chain_track
from squama.model.outcome import End
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

MOST = 2000
"""Largest number of scales of a row."""
STEPS = 40
"""Steps that a row takes at least, however few points are asked for."""


def row(
    beam: Beam,
    *,
    scales: int | None = None,
    mu: float | None = None,
    to: float | str | None = None,
    points: int = 100,
    sense: str = "+",
) -> xr.Dataset:
    """Twist a row of N hinged scales that does not repeat: its end scales lack one neighbour.

    The twist per pitch is the same all along the row; the force law is "edge" (docs, theory: a finite row).

    Parameters
    ----------
    beam
        The beam.
    scales
        Number of scales, 2 to 2000; the beam's own if not given.
    mu
        Coefficient of friction; the beam's own if not given.
    to
        Twist at which to stop: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total" (over
        ``scales`` pitches). If not given, the cut-off of the endless beam's curve (margin 0.01).
    points
        Number of points along the twist.
    sense
        "+" or "-": which way the beam is twisted. Twists are magnitudes.

    Returns
    -------
    xarray.Dataset
        Dimensions ``point`` and ``scale`` (1 to N); ``theta``, ``N``, ``f``, ``p``, ``s`` of every scale's contact with
        the next (NaN where there is none) and ``Q``; ``T``, ``T_scales``, ``U_el``, ``W_fr``, ``RED`` of the row;
        ``T_periodic`` and ``theta_periodic`` of the endless beam, NaN beyond its end; ``phi_e``, ``phi_end``, ``end``,
        ``scale_end``, ``other_contact``, ``decay``. SI units and radians.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45)
    >>> r = squama.row(beam, scales=25, mu=0.2, to="0.1 rad/pitch")
    >>> ends = r.theta.isel(point=-1, scale=[0, 12, 24]).values
    >>> print([f"{t:.3f}" for t in ends], f"{float(r.decay):.2f} per scale")
    ['0.301', '0.290', '0.070'] 0.77 per scale
    """
    return follow(beam, scales, mu, to, points, sense)


def follow(
    beam: Beam, scales: int | None, mu: float | None, to: float | str | None, points: int, sense: str,
    ideal: bool = True,
) -> xr.Dataset:  # fmt: skip
    """Follow a row, of thin scales or, where they are not ``ideal``, as thick as the beam's."""
    n = arguments.whole("scales", beam.scales if scales is None else scales, 2, MOST)
    points = arguments.whole("points", points, 3, 1e5)
    sign = arguments.sense(sense)
    m = arguments.friction(beam.friction.mu, mu)
    d = beam.pitch
    stop = None if to is None else doors.far(to, LOADS["twisting"], d, n)
    endless = doors.respond(beam, "twisting", mu=m, points=3, sense=sense, joint="hinge", ideal=ideal)
    stop = float(endless["Phi_c"]) * d if stop is None else stop
    alpha = sign * beam.scale.alpha
    ratios = beam.eta, beam.beta, beam.lam, math.sin(alpha), math.cos(alpha), beam.scale.theta0
    asked = Asked(beam.replace(scales=n), LoadPath.of("twisting", [0.0]), np.asarray(m), "edge", 0.0, points)
    asked = asked._replace(ideal=ideal)
    design = chain.Row(*ratios, m, n, asked.thickness)
    phi_e = float(endless["phi_e"])
    path = _path(design, endless, phi_e, stop, points)
    along, each = _values(beam, design, path, phi_e, points)
    same = doors.respond(beam, "twisting", mu=m, at=along["Phi"], sense=sense, joint="hinge", ideal=ideal)
    along |= {"T_periodic": same["T"], "theta_periodic": same["theta"]}
    phi_end = math.inf if path.end is End.NONE else path.phi_end
    figures: dict[str, float | int | str] = {
        "phi_e": phi_e,
        "Phi_e": phi_e / d,
        "phi_end": phi_end,
        "Phi_end": phi_end / d,
        "end": str(path.end),
        "scale_end": 0 if path.end in (End.RANGE, End.NONE) else path.scale + 1,
        "other_contact": path.other,
        "decay": _decay(design, phi_e),
    }
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("point",): {"phi": along["Phi"] * d, **along},
        ("point", "scale"): each,
        (): {name: np.asarray(value) for name, value in figures.items()},
    }
    attrs = attributes(asked, "twisting of a row of scales", sense)
    variables = labelled(asked.path.load, States(by_dim), asked.mus)
    counted = {"long_name": "scale, counted along the beam"}
    variables["scale"] = Labelled(("scale",), np.arange(1, n + 1), counted)
    return Answer(variables, {**attrs, "load": "row", "mu": m, "sense": sense}).dataset().set_coords("phi")


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
    n = max(2, points - _straight(points))
    fine = math.ceil(STEPS / (n - 1))
    found = chain_track.track(design, phi_e, np.linspace(phi_e, stop, fine * (n - 1) + 1)[1:])
    kept = found.states[::fine]
    if found.states and kept[-1] is not found.states[-1]:
        kept.append(found.states[-1])
    return found._replace(states=kept)


def _straight(points: int) -> int:
    """Return the number of points before engagement."""
    return max(1, points // LINEAR)


def _values(
    beam: Beam, design: chain.Row, path: chain_track.Track, phi_e: float, points: int
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return everything along the twist in SI units, of the row (points,) and of each scale (points, scales).

    The straight part comes first, then the states of the row.
    """
    d, K, n = beam.pitch, beam.joint_stiffness, design.scales
    before = _straight(points) if path.states else points
    straight = np.linspace(0.0, min(phi_e, path.phi_end), before, endpoint=not path.states)
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
