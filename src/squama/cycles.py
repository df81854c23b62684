"""Loading, unloading and reversal: from a beam and a history of twists to its loops."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import checks, histories
from squama._version import __version__
from squama.answer import Answer, Labelled
from squama.design import Beam
from squama.histories import Senses
from squama.model import history
from squama.model.outcome import End
from squama.model.paths import ARRAY, FLOAT
from squama.model.solve import Array
from squama.symbols import SYMBOLS

if TYPE_CHECKING:
    import xarray as xr

STRAIGHT, MOST = 4, 1_000_000
"""A straight part has this many times fewer points than a part in contact; most points of a history."""
BRANCHES = ("straight", "loading", "unloading", "stick")
_ALONG = ("branch", "leg", "theta", "N", "f", "p", "U_el", "W_fr")
_KEPT = (*_ALONG, "end", "other_contact", "neighbour", "sense", "W_d", "U_max", "zeta_eq", "K_sec")
_TWISTING = {name: name for name in (*_KEPT, "s")} | {
    "rate": "Phi",
    "load": "phi",
    "torque": "T",
    "scales": "T_scales",
    "tangent": "K_t",
    **{name: f"phi_{name}" for name in ("base", "top", "residual", "jam", "most")},
    "drop": "T_drop",
    "load_e": "phi_e",
    "load_end": "phi_end",
}
_BENDING = {name: name for name in _KEPT if name != "p"} | {
    "rate": "kappa",
    "load": "psi",
    "torque": "M",
    "scales": "M_scales",
    "tangent": "K_b",
    "s": "r",
    **{name: f"psi_{name}" for name in ("base", "top", "residual", "jam", "most")},
    "drop": "M_drop",
    "load_e": "psi_e",
    "load_end": "psi_end",
}
NAMES = {"twisting": _TWISTING, "bending": _BENDING}
"""Names of the variables of each kind of loading by their roles."""


def cycle(
    beam: Beam,
    twist: float | str | Sequence[float | str],
    *,
    mu: float | None = None,
    law: str = "edge",
    load: str = "twisting",
    margin: float = 0.01,
    points: int = 60,
    loops: int = 1,
    joint: str = "hinge",
) -> xr.Dataset:
    """Load and unload a beam through any history of twists: loops, stick intervals, dissipation, jamming.

    Parameters
    ----------
    beam
        The beam.
    twist
        Twists one after the other, from rest at 0: rates in rad/m or texts such as "0.2 rad/pitch", or one text as
        "0, 0.15, 0.05, 0.2, 0 rad/pitch". A single twist is gone to and back. Negative: the other sense. In bending
        curvatures, positive towards the scales.
    mu
        Coefficient of friction; the beam's own if not given.
    law
        "edge" (satisfies virtual work) or "plate" (the paper's); in bending they coincide.
    load
        "twisting" or "bending".
    margin
        How near to a lock a history may go: fraction of the path left.
    points
        Number of points in contact of each way between two twists; a straight part has a quarter of it.
    loops
        How many times the history is gone through.
    joint
        "hinge" (closed form) or "compliant" (as in :func:`squama.twist`; twisting, edge law, no margin).

    Returns
    -------
    xarray.Dataset
        Dimension ``point``: ``branch`` (how the point was reached: "straight", "loading", "unloading", "stick"),
        ``leg``, ``phi``, ``Phi``, ``T``, ``T_scales``, ``K_t``, ``theta``, ``N``, ``f`` (negative while the twist
        falls), ``p``, ``s``, ``U_el``, ``W_fr`` (from the start on); every turning point twice, before and after the
        drop of torque. Dimension ``loop``, closed loops in the order in which they close: ``phi_base``, ``phi_top``,
        ``W_d``, ``U_max``, ``zeta_eq``, ``K_sec``, ``T_drop``, ``phi_residual``. Dimension ``sense``: ``phi_e``,
        ``phi_most``, ``phi_jam``, ``phi_end``, ``end``, ``other_contact``, ``neighbour``. In bending ``psi``,
        ``kappa``, ``M``, ``K_b``, ``r``. With the compliant joint every turning point stands once, "stick" are the
        points until the contact slides back, ``phi_most`` and ``phi_jam`` are not there; ``energy_error``: work that is
        neither stored nor rubbed away, relative to W_fr. See docs, theory: cycles.

    Raises
    ------
    InputError
        An argument is out of range; the history goes beyond a lock or to a contact that is not followed, or the scales
        do not slide back on it.

    Examples
    --------
    >>> import squama
    >>> c = squama.cycle(squama.Beam.from_ratios(youngs_modulus="2 MPa"), "0, 0.2, 0 rad/pitch", mu=0.3)
    >>> print(f"{float(c.W_d[0]):.3g} J/m a loop, damping ratio {float(c.zeta_eq[0]):.3f}")
    9.32 J/m a loop, damping ratio 0.043
    """
    return cycled(
        beam, twist, mu=mu, law=law, load=load, margin=margin, points=points, loops=loops, joint=joint
    ).dataset()


def cycled(
    beam: Beam,
    twist: float | str | Sequence[float | str],
    *,
    mu: float | None = None,
    law: str = "edge",
    load: str = "twisting",
    margin: float = 0.01,
    points: int = 60,
    loops: int = 1,
    joint: str = "hinge",
) -> Answer:
    """Return what :func:`cycle` returns, before it is a dataset."""
    checks.law(law)
    checks.one_of("load", load, tuple(NAMES))
    value = beam.friction.mu if mu is None else mu
    if value is None:
        checks.fail("mu is not given: pass mu=0.3, or write mu under [friction] in the beam's file")
    m = checks.scalar("mu", value, -1e-300, math.inf, "0 or more")
    margin = checks.scalar("margin", margin, 1e-12, 1.0, "at least 1e-12 and below 1")
    points = checks.whole("points", points, 3, 1e5)
    checks.joint(joint)
    values = histories.read(twist, beam, load)
    values = histories.repeated(values, checks.whole("loops", loops, 1, 1e4))
    if len(values) * points > MOST:
        checks.fail(f"twist: {len(values)} twists of {points} points are too many; ask for fewer points or loops")
    if joint == "compliant":
        for name, given, only in (("law", law, "edge"), ("load", load, "twisting")):
            if given != only:
                checks.fail(f'{name} = "{given}": is not covered by joint="compliant"; write {name}="{only}"')
        from squama import cycles_compliant

        return cycles_compliant.cycled(beam, values, mu=m, points=points)
    senses = histories.senses(beam, load, m, law, margin)
    histories.check(values, senses)
    along, figures = _along(senses, values, points), _loops(senses, values)
    names = NAMES[load]
    used = [s for s in ("+", "-") if s == "+" or min(values) < 0]
    by_sense = {role: [_SENSE[role](senses, sign) for sign in used] for role in _SENSE}
    dims = {**dict.fromkeys(along, "point"), **dict.fromkeys(figures, "loop"), **dict.fromkeys(by_sense, "sense")}
    every = {**along, **figures, **by_sense, "sense": used}
    variables = {
        names[role]: Labelled((dims.get(role, "sense"),), np.asarray(every[role]), SYMBOLS[names[role]].attrs)
        for role in every
        if role in names
    }
    variables["mu"] = Labelled((), np.asarray(m), SYMBOLS["mu"].attrs)
    attrs = {
        "title": f"cycles of a scale-covered beam in {load}",
        "load": load,
        "law": law if load == "twisting" else "edge",
        "margin": margin,
        "joint": "hinge",
        "history": [v / beam.pitch for v in values],
        "beam": beam.to_toml(),
        "squama_version": __version__,
        "warnings": "\n".join(beam.warnings(load)),
    }
    return Answer(variables, attrs)


def _jam(senses: Senses, sign: str) -> float:
    """Smallest load angle from which a beam that is let go does not come back; inf for none."""
    side = senses.sides.get(sign)
    x = history.jam(side, senses.bar) if side is not None else None
    return math.inf if side is None or x is None else float(side.row.point(x, side.law, FLOAT).load)


_SENSE: dict[str, Any] = {
    "load_e": lambda s, sign: s.paths[sign].load_e,
    "most": lambda s, sign: s.most[sign],
    "jam": _jam,
    "load_end": lambda s, sign: math.inf if s.paths[sign].row is None else s.paths[sign].load_end,
    "end": lambda s, sign: str(s.paths[sign].end),
    "other_contact": lambda s, sign: s.paths[sign].other,
    "neighbour": lambda s, sign: s.paths[sign].neighbour,
}


class _Piece(NamedTuple):
    """Part of a way in one state: signed load angles of its ends; ``sign`` of the contact, "" where there is none."""

    start: float
    stop: float
    sign: str


def _pieces(senses: Senses, start: float, stop: float) -> list[_Piece]:
    """Split the way from one load angle to another where contacts engage or open."""
    cuts = [s * p.load_e for s, p in ((1, senses.paths["+"]), (-1, senses.paths["-"]))]
    inside = sorted((c for c in cuts if min(start, stop) < c < max(start, stop)), reverse=stop < start)
    ends = [start, *inside, stop]
    found = []
    for a, b in itertools.pairwise(ends):
        middle = (a + b) / 2
        sign = "+" if middle > 0 else "-"
        found.append(_Piece(a, b, sign if abs(middle) > senses.paths[sign].load_e else ""))
    return found


def _along(senses: Senses, values: list[float], points: int) -> dict[str, Any]:
    """Return every variable along the history, by role."""
    turns, parts = set(history.reversals(values)), []
    done = 0.0
    known: dict[_Piece, dict[str, Any]] = {}
    for i, (start, stop) in enumerate(itertools.pairwise(values)):
        fresh = i == 0 or i in turns
        for piece in _pieces(senses, start, stop):
            if piece not in known:
                known[piece] = _evaluate(senses, piece, points)
            part = {**known[piece], "branch": known[piece]["branch"].copy(), "W_fr": known[piece]["W_fr"] + done}
            done = float(part["W_fr"][-1])
            part["leg"] = np.full(part["load"].size, i + 1)
            if fresh and i and piece.sign and senses.mu:
                part["branch"][0] = "stick"
            parts.append(part if fresh else {name: v[1:] for name, v in part.items()})
            fresh = False
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _evaluate(senses: Senses, piece: _Piece, points: int) -> dict[str, Any]:
    """Every variable on a part of the way, ends included."""
    case = senses.case
    d, K, way = case.pitch, case.stiffness, 1 if abs(piece.stop) > abs(piece.start) else -1
    n = points if piece.sign else max(2, points // STRAIGHT)
    sign = -1 if piece.sign == "-" else 1
    w = np.linspace(0.0, 1.0, n + 1)
    zero = np.zeros(n + 1)
    out: dict[str, Any] = {"theta": np.full(n + 1, case.theta0)}
    out |= {"N": zero, "f": zero, "work": zero, "scales": zero, "tangent": zero, "p": zero * np.nan, "s": zero * np.nan}
    load = piece.start + (piece.stop - piece.start) * w
    if piece.sign:
        side = senses.sides[piece.sign]
        a, b = (senses.place(piece.sign, abs(v)) for v in (piece.start, piece.stop))
        if senses.paths[piece.sign].end in (End.FRICTIONAL, End.KINEMATIC):
            # closer together where the curve steepens
            w = 1 - (1 - w) ** 2 if way > 0 else w**2
        x = a + (b - a) * w
        x[-1] = b
        with np.errstate(all="ignore"):
            # a complex step gives the tangent without cancellation
            pt = side.row.point(x + 1e-30j, side.law, ARRAY)
            forces = side.forces(pt, way)
        load = sign * pt.load.real
        load[0], load[-1] = piece.start, piece.stop
        # where the contact opens the lift is zero but for rounding
        out["theta"], out["N"] = pt.theta.real, np.maximum(forces.N.real, 0) * K / d
        out["f"] = side.friction(way) * out["N"]
        out["scales"], out["tangent"] = forces.torque.real, forces.torque.imag / pt.load.imag
        out["p"], out["s"] = (np.broadcast_to(np.real(v), x.shape) * d for v in (pt.p, pt.s))
        out["work"] = history.work(side, a, b)(x)
    rate = load / d
    return {
        "branch": np.full(n + 1, {0: "straight", 1: "loading", -1: "unloading"}[way if piece.sign else 0], "U9"),
        "load": load,
        "rate": rate,
        "theta": out["theta"],
        "torque": case.rigidity * rate + sign * K * out["scales"],
        "scales": sign * K * out["scales"],
        "tangent": case.rigidity + K * d * out["tangent"],
        "N": out["N"],
        "f": out["f"],
        "p": out["p"],
        "s": out["s"],
        "U_el": (case.rigidity * rate**2 + K / d * (out["theta"] - case.theta0) ** 2) / 2,
        "W_fr": out["work"] * K / d,
    }


class _State(NamedTuple):
    """Torques on both branches and elastic energy at a load angle (signed), and where in contact; None if straight."""

    up: float
    down: float
    elastic: float
    x: float | None


def _state(senses: Senses, load: float) -> _State:
    case, sign = senses.case, "+" if load > 0 else "-"
    straight = case.rigidity * load / case.pitch
    energy = straight * load / case.pitch / 2
    if abs(load) <= senses.paths[sign].load_e:
        return _State(straight, straight, energy, None)
    side, x = senses.sides[sign], senses.place(sign, abs(load))
    pt = side.row.point(x, side.law, FLOAT)
    up, down = (straight + math.copysign(case.stiffness, load) * side.forces(pt, way).torque for way in (1, -1))
    return _State(up, down, energy + case.stiffness / case.pitch * (pt.theta - case.theta0) ** 2 / 2, x)


def _loops(senses: Senses, values: list[float]) -> dict[str, Array]:
    """Return the figures of every closed loop, by role."""
    known: dict[tuple[float, float], list[float]] = {}
    rows = []
    for loop in history.loops(values):
        key = loop.base, loop.top
        if key not in known:
            known[key] = _figures(senses, loop)
        rows.append([*key, *known[key]])
    names = ("base", "top", "W_d", "U_max", "zeta_eq", "K_sec", "drop", "residual")
    return dict(zip(names, np.array(rows, float).reshape(-1, len(names)).T, strict=True))


def _figures(senses: Senses, loop: history.Loop) -> list[float]:
    case = senses.case
    base, top = _state(senses, loop.base), _state(senses, loop.top)
    dissipated = rest = 0.0
    if top.x is not None:
        sign = "+" if loop.top > 0 else "-"
        side = senses.sides[sign]
        low = side.x0 if base.x is None else base.x
        both = history.work(side, low, top.x)(np.array(top.x)), history.work(side, top.x, low)(np.array(low))
        dissipated = float(sum(both)) * case.stiffness / case.pitch
        x = history.residual(side, senses.bar, top.x)
        rest = 0.0 if x is None else math.copysign(float(side.row.point(x, side.law, FLOAT).load), loop.top)
    secant = (top.up - base.down) / ((loop.top - loop.base) / case.pitch)
    return [
        dissipated,
        top.elastic,
        dissipated / (4 * math.pi * top.elastic),
        secant,
        abs(top.up - top.down),
        rest,
    ]
