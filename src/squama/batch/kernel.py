"""The package's own functions, compiled: nothing is written a second time but the loops over the places of a path.

Numba is told that ``twisting.root``, ``laws.edge``, ``Twist.solve`` and so on are implemented by themselves, so that
compiled code calls them by their names and methods and executes their very source. The steps from a design to its
answer (:mod:`squama.model.follow`, :mod:`squama.model.figures`) are copied with compiled functions in place of those
that they name.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from types import FunctionType
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.extending import overload, overload_attribute, overload_method

from squama.model import (
    bending,
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
from squama.model.evaluation import BENT, FIELDS, FOLDED, NAMES, SIZE, Design, Spot
from squama.model.paths import FoldedTwist, Ops, Twist

PLATE = NAMES.index("plate")


class _Part(JITCodeLibrary):
    """Code that only compiled code calls: optimised, and made machine code, in its outermost caller, not before."""

    def finalize(self) -> None:
        """Link what is called."""
        for called in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(called._get_module_for_linking(), preserve=True)
        self._finalized = True

    @property
    def codegen(self) -> Any:
        """What is told of the environment of the machine code, of which there is none."""
        return self

    def set_env(self, *_: Any) -> None:
        """Take note of nothing."""


class _Parts(Compiler):
    """Compiles such code."""

    place: Any = _Part

    def define_pipelines(self) -> Any:
        """Define the usual passes, in that place."""
        self.state.library = self.place(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        passes: Any = super()
        return passes.define_pipelines()


OPTIONS: dict[str, Any] = {
    "pipeline_class": _Parts,
    "error_model": "numpy",
    "_nrt": False,
    "no_rewrites": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
"""1/0 = inf, without a test; called by compiled code only. No rounding is left out, so nothing depends on company."""
_INLINED: dict[str, Any] = {"forceinline": True, **OPTIONS}
ROOM = np.dtype([(name, "f8", (SIZE,)) for name in FIELDS])
"""A :class:`squama.model.evaluation.Room` for compiled code: rows at constant distances, as vectors need."""


class _Single(NamedTuple):
    """Stands for NumPy where single numbers go through a formula for arrays."""

    all: Any


def _inlined(f: Callable[..., Any]) -> Any:
    return numba.njit(**_INLINED)(f)


def _teach(
    register: Any,
    what: tuple[Any, ...],
    like: Callable[..., Any],
    choose: Callable[..., Any],
    options: dict[str, Any] = _INLINED,
) -> None:
    """Register ``choose``, with the parameters of what it chooses (Numba compares the two)."""
    choose.__dict__["__signature__"] = inspect.signature(like)
    register(*what, jit_options=options)(choose)


def _compiled(f: Any) -> Any:
    """Have a function compiled where it is called, for types but not for the values of constants."""
    _teach(overload, (f,), f, lambda *_: f, OPTIONS)
    return f


def _itself(f: Callable[..., Any], **names: Any) -> FunctionType:
    """Return a copy of a function of the package that sees other globals under the given names."""
    assert isinstance(f, FunctionType)
    return FunctionType(f.__code__, {**f.__globals__, **names}, f.__name__, f.__defaults__, f.__closure__)


def _seen_from(row: Twist, k: float) -> Twist:
    return Twist(row.eta, row.beta, row.lam, row.sa, row.ca, row.theta0, k)


def _teach_rows(name: str, *rows: Any) -> None:
    """Teach a method or property of the rows."""
    own = {row: row.__dict__[name] for row in rows if name in row.__dict__}
    plain: dict[Any, Any] = {row: f.fget if isinstance(f, property) else f for row, f in own.items()}
    register = overload_attribute if isinstance(next(iter(own.values())), property) else overload_method
    like = next(iter(plain.values()))
    _teach(register, (types.BaseNamedTuple, name), like, lambda *args: plain.get(args[0].instance_class))


for _name in ("ratios", "open", "root", "solve_at", "solve_from", "half", "at_root", "places"):
    _teach_rows(_name, Twist, FoldedTwist)
_teach_rows("point", Bend)
_teach(overload_method, (types.BaseNamedTuple, "_replace"), _seen_from, lambda *_, **__: _seen_from)


def _same(x: Any) -> Any:
    return x


def _called(f: Callable[[float], float]) -> Any:
    def call(x: float) -> float:
        return f(x)

    return _inlined(call)


OPS = Ops(
    _called(math.sqrt),
    _called(math.sin),
    _called(math.cos),
    _called(math.tan),
    _called(math.atan),
    _inlined(lambda x: (math.sin(x), math.cos(x))),
    _inlined(lambda a, b: a if a > b else b),
    _inlined(lambda a, b: a if a < b else b),
)
_BARE = OPS._replace(atan=_inlined(_same))
"""Without the arc tangent, which would keep LLVM from taking several places in one instruction."""

for _f in (
    twisting.root, twisting.contact, laws.edge, laws.plate, mechanics.forces, energy.beyond,
    neighbours.gap, neighbours.reach, neighbours.reach_at, neighbours.engages, neighbours.on_edges,
):  # fmt: skip
    _teach(overload, (_f,), _f, lambda *_, f=_f: f)
_bend_at = _itself(bending.bend_at, np=_Single(_inlined(_same)))
_teach(overload, (bending.bend_at,), _bend_at, lambda *_: _bend_at)


@_inlined
def _open(d: Design) -> Twist:
    return Twist(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0, 1.0)


@_inlined
def _keep(room: Any, j: int, solved: Any) -> None:
    room.theta[j], r, room.q[j], room.per_x[j] = solved
    room.S[j], room.H[j], room.G[j], room.square[j] = r.S, r.H, r.G, r.q2
    room.sn[j], room.cs[j] = r.sn, r.cs


@_compiled
def roots(d: Design, room: Any, start: int, stop: int) -> None:
    """Terms of the contact condition, and its root, as :func:`squama.model.evaluation.roots`."""
    # sines first: their calls would keep LLVM from taking several places in one instruction
    if d.kind == FOLDED:
        row = FoldedTwist(d.eta, d.beta, d.lam, d.sa, d.ca, d.theta0, d.theta_f, 1.0)
        at_fold = _open(d).root(d.theta_f, OPS)
        for j in range(start, stop):
            room.sn[j], room.cs[j] = OPS.sincos(row.half(room.x[j]))
        for j in range(start, stop):
            _keep(room, j, row.solve_from(at_fold, room.x[j], room.sn[j], room.cs[j], OPS))
    else:
        for j in range(start, stop):
            room.sn[j], room.cs[j] = OPS.sincos(room.x[j])
        for j in range(start, stop):
            _keep(room, j, _open(d).solve_at(room.x[j], room.sn[j], room.cs[j], OPS))


@_inlined
def _see(room: Any, j: int, pt: Any, f: Any, tip: float, side: float) -> None:
    room.rate[j], room.drive[j], room.tip[j], room.side[j], room.turn[j] = pt.load_rate, f.D, tip, side, pt.turn
    low = f.D if pt.load_rate > f.D else pt.load_rate
    near = tip if tip < side else side
    low = near if near < low else low
    room.least[j] = pt.turn if pt.turn < low else low
    room.load[j], room.force[j], room.torque[j], room.power[j] = pt.load, f.f, f.torque, f.f * pt.slip_rate


def _by_number(law: int, c: Any, eta: float, sqrt: Any) -> Any:
    if law == PLATE:
        return laws.plate(c, eta, sqrt)
    return laws.edge(c, eta, sqrt)


_teach(overload, (laws.moments,), _by_number, lambda *_: _by_number)


@_compiled
def looks(d: Design, room: Any, start: int, stop: int) -> None:
    """Look at places of a path, as :func:`squama.model.evaluation.looks`; ``load`` is a tangent yet (see spot)."""
    if d.kind == BENT:
        row = Bend(d.eta, d.theta0)
        for j in range(start, stop):
            pt = row.point(room.x[j], "edge", OPS)
            _see(room, j, pt, mechanics.forces(pt, d.theta0, d.mu), 1.0, 1.0)
            room.theta[j], room.square[j] = room.x[j], 1.0
        return
    roots(d, room, start, stop)
    pair = _open(d)
    for j in range(start, stop):
        r = twisting.Root(room.sn[j], room.cs[j], room.S[j], room.H[j], room.G[j], room.square[j])
        pt = pair.at_root(room.theta[j], r, room.q[j], room.per_x[j], d.law, _BARE)
        tip, side = pair.places(pt)
        _see(room, j, pt, mechanics.forces(pt, d.theta0, d.mu), tip, side)


@_compiled
def spot(x: float, d: Design, room: Any) -> Spot:
    """Look at one place, as :func:`squama.model.evaluation.spot`."""
    room.x[0] = x
    looks(d, room, 0, 1)
    load = room.load[0] if d.kind == BENT else 2 * math.atan(room.load[0] / 2) / d.k
    return Spot(
        room.least[0], room.square[0], room.rate[0], room.drive[0], room.tip[0], room.side[0], room.turn[0],
        room.theta[0], load, room.force[0], room.torque[0], room.power[0],
    )  # fmt: skip


@_compiled
def meet(x: float, d: Design, room: Any) -> tuple[float, float]:
    """Inclination and twist at a place of a twisting path, as :func:`squama.model.evaluation.meet`."""
    room.x[0] = x
    roots(d, room, 0, 1)
    return room.theta[0], 2 * math.atan(room.S[0] / (room.H[0] + room.q[0])) / d.k


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
