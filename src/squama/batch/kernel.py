"""The package's own functions, compiled by Numba from their only source; only the loops over places are written here.

Numba is told that ``twisting.root``, ``laws.edge``, ``Twist.solve`` and so on are implemented by themselves, so that
compiled code calls them by name and executes the same source. The functions from a design to its solution
(:mod:`squama.model.follow`, :mod:`squama.model.figures`) are copied with compiled functions in place of the names they
use.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from types import FunctionType
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np
from numba import types
from numba.extending import overload, overload_attribute, overload_method

from squama.batch.keeping import INNER
from squama.model import (
    bracket,
    crossings,
    energy,
    evaluation,
    figures,
    follow,
    laws,
    mechanics,
    neighbours,
    twisting,
)
from squama.model.bending import Bend
from squama.model.evaluation import BENT, FIELDS, FOLDED, NAMES, SIZE, Design, Room, Spot
from squama.model.paths import FoldedTwist, Ops, Point, Twist

_T = TypeVar("_T")
_F = TypeVar("_F", bound=Callable[..., object])
_Solved = tuple[float, twisting.Root, float, float]
"""What :meth:`squama.model.paths.Twist.solve` returns."""

EDGE, PLATE = (NAMES.index(law) for law in ("edge", "plate"))


_SINE, _VERSINE = (tuple((-1) ** n / math.factorial(2 * n + m) for n in range(8)) for m in (1, 2))
"""Coefficients of sin(z)/z and (1 - cos z)/z^2 as series in z^2."""
WIDTH = 8
"""Number of places evaluated together."""
SPARE = SIZE
"""Index in the room at which single places are evaluated."""
OPTIONS: dict[str, object] = {
    **INNER,
    "_nrt": False,
}
"""Numba options: 1/0 = inf, without a test. Every rounding is kept, so a result does not depend on other designs."""
_INLINED: dict[str, Any] = {"forceinline": True, **OPTIONS}
ROOM = np.dtype([(name, "f8", (SIZE + 2 * WIDTH,)) for name in FIELDS])
"""A :class:`squama.model.evaluation.Room` for compiled code: rows at constant distances, as vector instructions need.
"""


class _Single(NamedTuple):
    """Stands for NumPy where a formula for arrays is evaluated with single numbers."""

    all: Callable[[bool], bool]


def _same(x: _T) -> _T:
    return x


def _inlined(f: _F) -> _F:
    return cast("_F", numba.njit(**_INLINED)(f))


def _teach(
    register: Callable[..., Callable[[_F], _F]],
    what: tuple[object, ...],
    like: Callable[..., object],
    choose: _F,
    options: Mapping[str, object] = _INLINED,
) -> None:
    """Register ``choose`` with Numba, with the signature of the functions it returns (Numba compares the two)."""
    choose.__dict__["__signature__"] = inspect.signature(like)
    register(*what, jit_options=options)(choose)


def _compiled(f: _F) -> _F:
    """Register a function to be compiled at its calls, by argument types, not for values of constants."""
    _teach(overload, (f,), f, lambda *_: f, OPTIONS)
    return f


def _itself(f: object, **names: object) -> FunctionType:
    """Return a copy of a function of the package with other globals under the given names."""
    assert isinstance(f, FunctionType)
    return FunctionType(f.__code__, {**f.__globals__, **names}, f.__name__, f.__defaults__, f.__closure__)


def _seen_from(row: Twist, k: float) -> Twist:
    return Twist(row.eta, row.beta, row.lam, row.sa, row.ca, row.theta0, k, row.thickness)


def _teach_rows(name: str, *rows: type) -> None:
    """Register a method or property of the rows with Numba."""
    own = {row: row.__dict__[name] for row in rows if name in row.__dict__}
    plain: dict[type, object] = {row: f.fget if isinstance(f, property) else f for row, f in own.items()}
    copies = {row: _itself(f, np=_Single(_inlined(_same))) for row, f in plain.items()}
    register = overload_attribute if isinstance(next(iter(own.values())), property) else overload_method
    like = next(iter(copies.values()))
    _teach(register, (types.BaseNamedTuple, name), like, lambda *args: copies.get(args[0].instance_class))


for _name in ("ratios", "open", "root", "solve_at", "solve_from", "half", "at_root", "places"):
    _teach_rows(_name, Twist, FoldedTwist, Bend)
for _name in ("levers", "meeting", "bend", "point"):
    _teach_rows(_name, Bend)
_teach(overload_method, (types.BaseNamedTuple, "_replace"), _seen_from, lambda *_, **__: _seen_from)


@_inlined
def _series(c: tuple[float, ...], w: float) -> float:
    # in pairs, which do not wait for each other
    w2 = w * w
    low, high = c[0] + c[1] * w + w2 * (c[2] + c[3] * w), c[4] + c[5] * w + w2 * (c[6] + c[7] * w)
    return low + (w2 * w2) * high


def _sincos(x: float) -> tuple[float, float]:
    """Return sine and cosine up to half a turn, by series at a quarter of it; the C library's cannot be vectorised."""
    z = x / 4
    w = z * z
    s, v = z * _series(_SINE, w), w * _series(_VERSINE, w)
    s, v = 2 * s * (1 - v), 2 * s * s
    return 2 * s * (1 - v), 1 - 2 * s * s


def _called(f: Callable[[float], float]) -> Callable[[float], float]:
    def call(x: float) -> float:
        return f(x)

    return _inlined(call)


OPS = Ops(
    _called(math.sqrt),
    _called(math.sin),
    _called(math.cos),
    _called(math.tan),
    _called(math.atan),
    _inlined(_sincos),
    _inlined(lambda a, b: a if a > b else b),
    _inlined(lambda a, b: a if a < b else b),
)
_BARE = OPS._replace(atan=_inlined(_same))
"""Operations without the arc tangent, which would keep LLVM from vectorising over places."""

for _f in (
    twisting.root, twisting.contact, laws.edge, laws.plate, mechanics.forces, energy.beyond,
    neighbours.gap, neighbours.reach, neighbours.reach_at, neighbours.meets, neighbours.engages, neighbours.on_edges,
    neighbours.touches_at_rest,
):  # fmt: skip
    _teach(overload, (_f,), _f, lambda *_, f=_f: f)


@_inlined
def _open(d: Design) -> Twist:
    return Twist(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0, 1.0, d.thickness)


@_inlined
def _keep(d: Design, room: Room, j: int, solved: _Solved, law: int) -> None:  # noqa: ARG001
    room.theta[j], r, room.q[j], _ = solved
    room.S[j], room.H[j], room.G[j], room.cs[j] = r.S, r.H, r.G, r.cs


@_inlined
def _plain(d: Design, x: float, _: twisting.Root) -> _Solved:
    sn, cs = OPS.sincos(x)
    return _open(d).solve_at(x, sn, cs, OPS)


@_inlined
def _folded(d: Design, x: float, fold: twisting.Root) -> _Solved:
    row = FoldedTwist(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0, d.theta_f, 1.0, d.thickness)
    up, over = OPS.sincos(row.half(x))
    return row.solve_from(fold, x, up, over, OPS)


@_inlined
def _all(
    f: Callable[[Design, Room, int, _Solved, int], None],
    solve: Callable[[Design, float, twisting.Root], _Solved],
    d: Design, room: Room, start: int, stop: int, law: int,
) -> None:  # fmt: skip
    # blocks of one instruction's size, so that no place is left over; numbers that Python does not count from the end
    fold = _open(d).root(d.theta_f, OPS)
    for i in range(np.uint64(start), np.uint64(stop), np.uint64(WIDTH)):
        for j in range(np.uint64(WIDTH)):
            f(d, room, i + j, solve(d, room.x[i + j], fold), law)


@_compiled
def roots(d: Design, room: Room, start: int, stop: int) -> None:
    """Evaluate the contact condition and its root at places of a path, as :func:`squama.model.evaluation.roots`."""
    if d.kind == FOLDED:
        _all(_keep, _folded, d, room, start, stop, EDGE)
    else:
        _all(_keep, _plain, d, room, start, stop, EDGE)


@_inlined
def _see(room: Room, j: int, pt: Point, f: mechanics.Forces, tip: float, side: float) -> None:
    room.rate[j], room.drive[j], room.tip[j], room.side[j], room.turn[j] = pt.load_rate, f.D, tip, side, pt.turn
    low = f.D if pt.load_rate > f.D else pt.load_rate
    near = tip if tip < side else side
    low = near if near < low else low
    room.least[j] = pt.turn if pt.turn < low else low
    room.load[j], room.force[j], room.torque[j], room.power[j] = pt.load, f.f, f.torque, f.f * pt.slip_rate


def _by_number(law: int, c: twisting.Contact, eta: float, sqrt: twisting.Sqrt) -> laws.Moments:
    if law == PLATE:
        return laws.plate(c, eta, sqrt)
    return laws.edge(c, eta, sqrt)


_teach(overload, (laws.moments,), _by_number, lambda *_: _by_number)


@_inlined
def _look(d: Design, room: Room, j: int, solved: _Solved, law: Any) -> None:
    pair = _open(d)
    theta, r, q, per_x = solved
    pt = pair.at_root(theta, r, q, per_x, law, _BARE)
    tip, side = pair.places(pt)
    room.theta[j], room.square[j] = theta, r.q2
    _see(room, j, pt, mechanics.forces(pt, d.theta0, d.mu), tip, side)


@_compiled
def looks(d: Design, room: Room, start: int, stop: int) -> None:
    """Evaluate the places start..stop of a path, as :func:`squama.model.evaluation.looks`.

    ``room.load`` is still a tangent then, except in bending (see :func:`spot`).
    """
    # a loop for each case: branches inside would keep LLVM from vectorising over places
    if d.kind == BENT:
        row = Bend(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0)
        for j in range(start, stop):
            pt = row.point(room.x[j], "edge", OPS)
            tip, side = row.places(pt)
            _see(room, j, pt, mechanics.forces(pt, d.theta0, d.mu), tip, side)
            room.theta[j], room.square[j] = room.x[j], 1.0
    elif d.kind == FOLDED and d.law == PLATE:
        _all(_look, _folded, d, room, start, stop, PLATE)
    elif d.kind == FOLDED:
        _all(_look, _folded, d, room, start, stop, EDGE)
    elif d.law == PLATE:
        _all(_look, _plain, d, room, start, stop, PLATE)
    else:
        _all(_look, _plain, d, room, start, stop, EDGE)


@_compiled
def spot(x: float, d: Design, room: Room) -> Spot:
    """Evaluate one place, as :func:`squama.model.evaluation.spot`."""
    room.x[SPARE] = x
    looks(d, room, SPARE, SPARE + 1)
    load = room.load[SPARE] if d.kind == BENT else 2 * math.atan(room.load[SPARE] / 2) / d.k
    return Spot(
        room.least[SPARE], room.square[SPARE], room.rate[SPARE], room.drive[SPARE], room.tip[SPARE], room.side[SPARE],
        room.turn[SPARE], room.theta[SPARE], load, room.force[SPARE], room.torque[SPARE], room.power[SPARE],
    )  # fmt: skip


@_compiled
def meet(x: float, d: Design, room: Room) -> tuple[float, float]:
    """Return inclination and twist at a place of a twisting path, as :func:`squama.model.evaluation.meet`."""
    room.x[SPARE] = x
    roots(d, room, SPARE, SPARE + 1)
    return room.theta[SPARE], 2 * math.atan(room.S[SPARE] / (room.H[SPARE] + room.q[SPARE])) / d.k


_names: dict[str, Any] = {"FLOAT": OPS, "spot": spot, "looks": looks, "roots": roots, "meet": meet}
for _step in (
    bracket.place, bracket.reached, bracket.zero, evaluation.samples, evaluation.sample, evaluation.onward,
    evaluation.apart, evaluation.joined,
    crossings.condition, crossings.lines, crossings.clear, crossings.rises, crossings.first_crossing,
    follow.design, follow.value, follow.first_engagement, follow.first_not_positive, follow.around, follow.calm,
    follow.steady, follow.bend_at, follow.smooth, follow.falls, follow.judged, follow.closely, follow.bracket,
    follow.named, follow.end, follow.follow,
    figures.cutoff, figures.by_rule, figures.in_parts, figures.worked, figures.figures, figures.fill,
):  # fmt: skip
    _names[_step.__name__] = _compiled(_itself(_step, **_names))
fill = _names["fill"]
