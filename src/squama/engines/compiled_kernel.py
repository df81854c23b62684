"""The package's own kernel, laws and rows, compiled: nothing is written a second time.

Numba is told that ``twisting.root``, ``laws.edge``, ``Twist.solve`` and so on are implemented by themselves, so that
compiled code calls them by their names and methods and executes their very source. The elementary functions are
passed in, as everywhere; those of this module are straight-line arithmetic, so that LLVM computes many designs in one
instruction.
"""

from __future__ import annotations

import inspect
import math
import operator
from collections.abc import Callable
from types import FunctionType
from typing import Any, NamedTuple, TypeVar

import numba
import numpy as np
from numba import types
from numba.extending import overload, overload_attribute, overload_method

from squama.model import energy, laws, mechanics, neighbours, twisting
from squama.model.paths import FoldedTwist, Ops, Twist

F = TypeVar("F", bound=Callable[..., Any])
OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "arcp", "nsz"}}
"""1/0 = inf, without a test; multiply and add in one rounding, divide several numbers by one, no sign of zero."""
_INLINED: dict[str, Any] = {"forceinline": True, **OPTIONS}


def inlined(f: F) -> F:
    """Compile a function into whatever calls it."""
    out: Any = numba.njit(**_INLINED)(f)
    return out  # type: ignore[no-any-return]


def compiled(f: F) -> F:
    """Compile a function that stands for itself."""
    out: Any = numba.njit(**OPTIONS)(f)
    return out  # type: ignore[no-any-return]


@compiled
def lines(n: int) -> Any:
    """Zeros that start where a line of the cache does: lanes that lie across two lines take twice as long."""
    room = np.zeros(n + 8)
    start = (64 - room.ctypes.data % 64) % 64 // 8
    return room[start : start + n]


class _Laws(NamedTuple):
    """Stands for ``laws.LAWS`` in compiled code, where a law goes by its function and not by its name."""

    none: int = 0


def _teach(register: Any, what: tuple[Any, ...], like: Callable[..., Any], choose: Callable[..., Any]) -> None:
    """Register ``choose``, with the parameters of what it chooses (Numba compares the two)."""
    choose.__signature__ = inspect.signature(like)  # type: ignore[attr-defined]
    register(*what, jit_options=_INLINED)(choose)


def _same(table: Any, law: Any) -> Any:  # noqa: ARG001
    return law


def _itself(f: Callable[..., Any], **names: Any) -> FunctionType:
    """Return a copy of a function of the package that sees other globals under the given names."""
    assert isinstance(f, FunctionType)
    return FunctionType(f.__code__, {**f.__globals__, **names}, f.__name__, f.__defaults__, f.__closure__)


def _teach_rows(name: str) -> None:
    """Teach a method or property of the rows."""
    own = {row: row.__dict__[name] for row in (Twist, FoldedTwist) if name in row.__dict__}
    plain: dict[Any, Any] = {row: f.fget if isinstance(f, property) else f for row, f in own.items()}
    bodies = {row: _itself(f, LAWS=_Laws()) for row, f in plain.items()}
    register = overload_attribute if isinstance(next(iter(own.values())), property) else overload_method
    like = next(iter(bodies.values()))
    _teach(register, (types.BaseNamedTuple, name), like, lambda *args: bodies.get(args[0].instance_class))


def _seen_from(row: Twist, k: float) -> Twist:
    return Twist(row.eta, row.beta, row.lam, row.sa, row.ca, row.theta0, k)


for _name in ("ratios", "open", "root", "solve", "solve_from", "at_root", "places"):
    _teach_rows(_name)
_teach(overload_method, (types.BaseNamedTuple, "_replace"), _seen_from, lambda *_, **__: _seen_from)
_teach(
    overload,
    (operator.getitem,),
    _same,
    lambda *args: _same if getattr(args[0], "instance_class", None) is _Laws else None,
)

edge = inlined(laws.edge)
plate = inlined(laws.plate)

_ROUND = 6755399441055744.0  # adding and subtracting it rounds to the nearest integer
_PIO2 = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
_P1, _P2, _P3 = _PIO2


@inlined
def _turned(x: float) -> tuple[float, float, float]:
    """Quadrant (-2..2) of an angle of a few turns, sine and cosine of what is left of it (fdlibm's polynomials)."""
    n = (x * 0.6366197723675814 + _ROUND) - _ROUND
    r = ((x - n * _P1) - n * _P2) - n * _P3
    z = r * r
    s = 2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
    s = -1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * s))
    c = -2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    c = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * c))
    m = n - 4 * ((n * 0.25 + _ROUND) - _ROUND)
    return m, r + r * z * s, 1 - (z / 2 - z * z * c)


@inlined
def sin(x: float) -> float:
    """Sine."""
    m, s, c = _turned(x)
    value = c if m * m == 1 else s
    return value if m * (m - 1) == 0 else -value


@inlined
def cos(x: float) -> float:
    """Cosine."""
    m, s, c = _turned(x)
    value = s if m * m == 1 else c
    return value if m * (m + 1) == 0 else -value


@inlined
def sincos(x: float) -> tuple[float, float]:
    """Sine and cosine of at most half a turn: polynomials at half the angle, doubled; no division."""
    y = x / 2
    z = y * y
    zz = z * z
    # the even and the odd terms beside each other, for a chain of half the length
    s = -0.16666666666666666 + zz * (
        -0.00019841269841254795 + zz * (-2.505210761086116e-08 + zz * -7.643957622560617e-13)
    )
    t = 0.008333333333333316 + zz * (
        2.7557319219115013e-06 + zz * (1.6058976915095007e-10 + zz * 2.7312868913092307e-15)
    )
    c = 0.04166666666666666 + zz * (2.4801587298886815e-05 + zz * (2.0876681108263528e-09 + zz * 4.646173408703228e-14))
    d = -0.0013888888888884717 + zz * (-2.755731856817136e-07 + zz * -1.1466234424282487e-11)
    sn = y + y * (z * (s + z * t))
    cs = 1 - (0.5 * z - zz * (c + z * d))
    return 2 * sn * cs, (cs - sn) * (cs + sn)


@inlined
def tan(x: float) -> float:
    """Tangent of any angle of a few turns."""
    return sin(x) / cos(x)


@inlined
def atan(x: float) -> float:
    """Arc tangent (Cephes' rational function)."""
    a = abs(x)
    far, near = a > 2.414213562373095, a > 0.66
    top = -1.0 if far else (a - 1 if near else a)
    low = a if far else (a + 1 if near else 1.0)
    y = top / low
    z = y * y
    p = -7.500855792314704667340e1 + z * (-1.615753718733365076637e1 + z * -8.750608600031904122785e-1)
    p = -6.485021904942025371773e1 + z * (-1.228866684490136173410e2 + z * p)
    q = 4.328810604912902668951e2 + z * (1.650270098316988542046e2 + z * (2.485846490142306297962e1 + z))
    q = 1.945506571482613964425e2 + z * (4.853903996359136964868e2 + z * q)
    rest = (6.123233995736766e-17 if far else (3.061616997868383e-17 if near else 0.0)) + y * (z * p / q)
    value = (1.5707963267948966 if far else (0.7853981633974483 if near else 0.0)) + (rest + y)
    return -value if x < 0 else value


@inlined
def decay(y: float) -> tuple[float, float]:
    """exp(-y) and 1 - exp(-y) for 0 <= y < 30, both to some 1e-14 of themselves."""
    z = y * -0.015625
    a = 1.984126984126984e-4 + z * (2.48015873015873e-5 + z * (2.7557319223985893e-6 + z * 2.755731922398589e-7))
    a = 0.16666666666666666 + z * (
        0.041666666666666664 + z * (0.008333333333333333 + z * (0.001388888888888889 + z * a))
    )
    a = z * (1 + z * (0.5 + z * a))
    p = 1 + a
    for _ in range(6):
        p = p * p
        a = a * (2 + a)
    return p, -a


@inlined
def sqrt(x: float) -> float:
    """Square root."""
    return math.sqrt(x)


@inlined
def larger(a: float, b: float) -> float:
    """Return the larger of two; the second where the first is no number."""
    return a if a > b else b


OPS = Ops(sqrt, sin, cos, tan, atan, sincos, larger)

for _f in (
    twisting.root, twisting.contact, mechanics.forces, mechanics.pressed, energy.beyond,
    neighbours.gap, neighbours.reach, neighbours.reach_at, neighbours.meeting, neighbours.within,
):  # fmt: skip
    _teach(overload, (_f,), _f, lambda *_, f=_f: f)
_on_edges = _itself(neighbours.on_edges, ARRAY=OPS, np=OPS)
_teach(overload, (neighbours.on_edges,), _on_edges, lambda *_: _on_edges)
