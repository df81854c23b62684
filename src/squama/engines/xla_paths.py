"""What the JAX engine compiles: a block of designs from ratios to figures at the cut-off.

The same steps as :mod:`squama.model.solution`, :mod:`squama.model.ends` and :mod:`squama.model.energy` take, without
branches: what they would look at again is flagged instead. JAX is imported where it is used.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np

from squama.model import energy, mechanics, neighbours
from squama.model.ends import COINCIDE, half_turn
from squama.model.neighbours import SAMPLES
from squama.model.outcome import CODES, End
from squama.model.paths import TWIST_ENDS, Ops, Twist
from squama.model.scan import COARSE, SAFETY, STEPS, hides
from squama.model.solve import place

PATIENCE = 24
"""Steps of the root solver after which the designs that have not converged are handed over."""
_KINEMATIC, _FRICTIONAL = CODES.index(End.KINEMATIC), CODES.index(End.FRICTIONAL)


class Ended(NamedTuple):
    """Ends of the paths of a block, and whether they can be relied on."""

    x: Any
    code: Any
    settled: Any


def operations() -> Ops:
    """Elementary functions of JAX."""
    from jax import numpy as jnp

    def sincos(x: Any) -> tuple[Any, Any]:
        return jnp.sin(x), jnp.cos(x)

    return Ops(jnp.sqrt, jnp.sin, jnp.cos, jnp.tan, jnp.arctan, sincos, jnp.maximum)


def block(columns: Any, margin: Any, *, law: str) -> dict[str, Any]:
    """Solve a block of designs: rows eta, beta, lam, sin and cos of alpha, theta0, mu.

    Beside the figures there are flags: ``settled`` (the end is right unless ``crossed``), ``crossed`` (another pair
    may come in before it) and ``rough`` (the work wants more nodes, with the pole at ``pole``).
    """
    from jax import numpy as jnp

    ops = operations()
    theta0, mu = columns[5], columns[6]
    row = Twist(*columns[:6])._replace(k=jnp.ones_like(mu))
    far = jnp.maximum(1.0, jnp.floor(neighbours.reach(row, ops)))
    k, load_e = engagement(row, far)
    engaged = k > 0
    row = row._replace(k=jnp.maximum(k, 1.0))
    end = first_end(row, mu, law)
    # a path that ends where it begins bears no load yet
    at_start = end.x <= theta0
    locks = (end.code == _KINEMATIC) | (end.code == _FRICTIONAL)
    x_c = jnp.where(locks, theta0 + (1 - margin) * (end.x - theta0), end.x)
    moved = engaged & (x_c > theta0)
    pt = row.point(x_c, law, ops)
    f = mechanics.forces(pt, theta0, mu)
    x_pole = pole(row, end.x, mu, law)
    work, rough = works(row, mu, x_c, x_pole, law, energy.FEW_NODES)
    load_end = jnp.where(at_start, load_e, row.point(end.x, law, ops).load)
    idle = jnp.where(engaged, load_e, 0.0)
    return {
        "load_e": load_e,
        "theta_end": jnp.where(engaged, end.x, theta0),
        "load_end": jnp.where(engaged, load_end, jnp.inf),
        "code": jnp.where(engaged, end.code, CODES.index(End.NONE)),
        "neighbour": k,
        "theta_c": jnp.where(moved, x_c, theta0),
        "load_c": jnp.where(moved, pt.load, idle),
        "f0": jnp.where(moved, f.f * row.eta, 0.0),
        "scales": jnp.where(moved, f.torque, 0.0),
        "W_fr": jnp.where(moved & (mu > 0), work, 0.0),
        "pole": x_pole,
        "settled": end.settled | ~engaged,
        "crossed": crossed(row, end.x, far) & engaged,
        "rough": rough & moved & (mu > 0),
    }


def engagement(row: Twist, far: Any) -> tuple[Any, Any]:
    """Return the neighbour that is met first and its engagement twist; 0 and inf where there is none."""
    from jax import lax
    from jax import numpy as jnp

    ops = operations()

    def look(j: Any, found: tuple[Any, Any]) -> tuple[Any, Any]:
        k, best = found
        on, twist = neighbours.engages(row._replace(k=1.0 * j), ops)
        phi = jnp.where(on & (j <= far), twist, jnp.inf)
        return jnp.where(phi < best, 1.0 * j, k), jnp.minimum(phi, best)

    start = jnp.zeros_like(row.eta), jnp.full_like(row.eta, jnp.inf)
    found: tuple[Any, Any] = lax.fori_loop(1, far.max().astype(int) + 1, look, start)
    return found


def first_end(row: Twist, mu: Any, law: str) -> Ended:
    """Solve the first end of open paths; settled where a coarse look suffices."""
    from jax import numpy as jnp

    ops = operations()
    x0, steps = row.theta0, STEPS[::COARSE]
    span = float(half_turn(1)[0]) - x0
    pt = row.point(x0 + span * steps[:, None], law, ops)
    each = mechanics.named_margins(row, pt, mu)
    ended = ~(functools.reduce(jnp.minimum, each) > 0)
    met, first = ended.any(axis=0), ended.argmax(axis=0)
    settled = met & calm(each, first) & smooth(pt.q * pt.q, first)
    grid = jnp.asarray(steps)
    a, b = x0 + span * grid[jnp.maximum(first - 1, 0)], x0 + span * grid[first]
    x, converged = first_zero(lambda x: smallest(row, row.point(x, law, ops), mu), a, b, settled)
    values = jnp.stack(jnp.broadcast_arrays(*mechanics.named_margins(row, row.point(x, law, ops), mu)))
    zero = ~(values > COINCIDE)
    which = jnp.where(zero.any(axis=0), zero.argmax(axis=0), jnp.nan_to_num(values, nan=-1.0).argmin(axis=0))
    code = jnp.asarray(np.array([CODES.index(e) for e in TWIST_ENDS]))[which]
    code = jnp.where((first == 0) & (code == _FRICTIONAL), CODES.index(End.STATIC), code)
    return Ended(x, code, settled & converged)


def smallest(row: Twist, pt: Any, mu: Any) -> Any:
    """Return the smallest margin."""
    from jax import numpy as jnp

    return functools.reduce(jnp.minimum, mechanics.named_margins(row, pt, mu))


def calm(margins: Any, first: Any) -> Any:
    """Whether no margin can vanish between the samples up to ``first``; as :mod:`squama.model.scan` has it."""
    from jax import numpy as jnp

    s = jnp.arange(2, margins[0].shape[0])[:, None]
    hidden = [hides(v[:-2], v[1:-1], v[2:], first == s, jnp.minimum) for v in margins]
    return ~(functools.reduce(jnp.logical_or, hidden) & (first >= s)).any(axis=0)


def smooth(values: Any, stop: Any) -> Any:
    """Whether nothing can hide between the samples up to ``stop``; as :mod:`squama.model.scan` has it."""
    from jax import numpy as jnp

    bend = abs(values[2:] - 2 * values[1:-1] + values[:-2])
    bend = jnp.concatenate([bend[:1], jnp.maximum(bend[1:], bend[:-1]), bend[-1:]])
    safe = jnp.minimum(values[1:], values[:-1]) > bend * SAFETY
    return (safe | (jnp.arange(safe.shape[0])[:, None] >= stop)).all(axis=0)


def first_zero(f: Any, a: Any, b: Any, wanted: Any) -> tuple[Any, Any]:
    """Solve f(x) = 0 between a and b in lock-step (Chandrupatla); return roots, and whether each has converged."""
    from jax import lax
    from jax import numpy as jnp

    def step(state: tuple[Any, ...]) -> tuple[Any, ...]:
        n, done, t, x1, f1, x2, f2 = state
        x = x1 + t * (x2 - x1)
        y = f(x)
        same = (y > 0) == (f1 > 0)
        x3, f3 = jnp.where(same, x1, x2), jnp.where(same, f1, f2)
        x2, f2 = jnp.where(same, x2, x1), jnp.where(same, f2, f1)
        best = jnp.where(abs(y) < abs(f2), x, x2)
        least = 4e-16 * abs(best) / abs(x2 - x)
        t, safe = place(x, y, x2, f2, x3, f3)
        t = jnp.clip(jnp.where(safe, t, 0.5), least, 1 - least)
        now = (least > 0.5) | (y == 0)
        # what has converged stays
        new = (jnp.where(now, best, x), y, x2, f2)
        x1, f1, x2, f2 = (jnp.where(done, old, v) for old, v in zip(state[3:], new, strict=True))
        return n + 1, done | now, t, x1, f1, x2, f2

    def go_on(state: tuple[Any, ...]) -> Any:
        return (state[0] < PATIENCE) & ~(state[1] | ~wanted).all()

    at_start = b <= a
    state = (0, at_start, jnp.full_like(a, 0.5), a, f(a), b, f(b))
    state = lax.while_loop(go_on, step, state)
    return state[3], state[1]


def crossed(row: Twist, x_end: Any, far: Any) -> Any:
    """Whether the lines of another neighbour's tip-side pair come to meet at a sample of the path."""
    from jax import lax
    from jax import numpy as jnp

    ops = operations()
    theta = row.theta0 + (x_end - row.theta0) * np.linspace(0.0, 1.0, SAMPLES)[:, None]
    theta, r, q, _ = row.solve(theta, ops)
    phi = 2 * ops.atan(r.S / (r.H + q)) / row.k

    def look(j: Any, found: Any) -> Any:
        met = neighbours.gap(row, 1.0 * j, theta, phi, ops) >= 0
        rising = (met[1:] > met[:-1]).any(axis=0)
        return found | (rising & (row.k != j) & (j <= far))

    return lax.fori_loop(1, far.max().astype(int) + 1, look, jnp.zeros_like(x_end, bool))


def pole(row: Twist, x_end: Any, mu: Any, law: str) -> Any:
    """Where the friction force has its pole; as :func:`squama.model.energy.pole`."""
    ops, h = operations(), 1e-4 * (x_end - row.theta0)
    D1 = mechanics.forces(row.point(x_end, law, ops), row.theta0, mu).D
    D0 = mechanics.forces(row.point(x_end - h, law, ops), row.theta0, mu).D
    return x_end + energy.beyond(D1, D0, h, ops)


def more_work(columns: Any, *, law: str, nodes: int) -> dict[str, Any]:
    """Frictional work of paths that want more nodes: rows of :func:`block`, then k, cut-off and pole."""
    work, rough = works(Twist(*columns[:6])._replace(k=columns[7]), columns[6], columns[8], columns[9], law, nodes)
    return {"work": work, "rough": rough}


def works(row: Twist, mu: Any, x_stop: Any, x_pole: Any, law: str, nodes: int) -> tuple[Any, Any]:
    """Frictional work by one rule of :mod:`squama.model.energy`, and whether that has too few nodes."""
    from jax import numpy as jnp

    unit, integral = energy._rule(nodes)
    reach = x_pole - row.theta0
    y_end = -jnp.log1p(-(x_stop - row.theta0) / reach)
    short = -jnp.expm1(-y_end * unit[:, None])
    pt = row.point(row.theta0 + reach * short, law, operations())
    density = mechanics.forces(pt, row.theta0, mu).f * pt.slip_rate * (reach * (1 - short))
    c = jnp.asarray(np.vstack([integral.sum(axis=0), integral[-4:]])) @ density
    return y_end * c[0], ~(abs(c[1:]).max(axis=0) <= energy.TOLERANCE * abs(c[0]))
