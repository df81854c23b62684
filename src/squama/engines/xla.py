"""The JAX engine: open paths compiled by XLA for CPU or GPU, the rest by the NumPy engine.

The kernel is the one of :mod:`squama.model`, executed with ``jax.numpy``. Designs are padded to blocks of few sizes,
so that few programs are compiled. Paths that the coarse look does not settle (folds, dips, paths without an end),
whose root is slow to converge, or on which another neighbour's pair comes in, are handed in one batch to the NumPy
engine, and so is bending. Double precision is switched on for these calculations only.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextlib import AbstractContextManager
from importlib import import_module
from typing import Any

import numpy as np

from squama.checks import fail
from squama.engines import Problem, Solved
from squama.engines import numpy as reference
from squama.model import energy
from squama.model.neighbours import first_crossing
from squama.model.paths import Twist
from squama.model.solve import Array

SIZES = {"cpu": (1024, 16384), "gpu": (1024, 16384, 262144)}
"""Sizes of a block by the kind of device; one program is compiled for each that occurs."""


def run(p: Problem) -> Solved:
    """Answer every design of a problem."""
    try:
        import jax
    except ImportError:
        fail('engine = "jax": JAX is not installed; pip install squama[jax]')
    if p.load == "bending" or p.eta.size == 0:
        return reference.run(p)
    sa = np.sin(p.alpha) * (1 if p.sense == "+" else -1)
    columns = np.stack([p.eta, p.beta, p.lam, sa, np.cos(p.alpha), p.theta0, p.mu])
    with double(jax):
        out = in_blocks(compiled("block", law=p.law), columns, p.margin)
        refine(out, columns, p.law)
    settled = out["settled"] & ~out["rough"] & ~meets_another(out, columns)
    theta_c, load_c, work = out["theta_c"], out["load_c"], out["W_fr"]
    elastic = (p.ratio * load_c**2 + (theta_c - p.theta0) ** 2) / 2
    total = elastic + work
    answer = Solved(
        out["load_e"],
        out["theta_end"],
        out["load_end"],
        out["code"].astype(np.int8),
        out["neighbour"].astype(np.int64),
        theta_c,
        load_c,
        out["f0"],
        out["scales"] + p.ratio * load_c,
        elastic,
        work,
        np.divide(work, total, out=np.zeros(total.size), where=total > 0),
    )
    left = np.flatnonzero(~settled)
    if left.size:
        rest = reference.run(p._replace(**{name: getattr(p, name)[left] for name in Problem._fields[:7]}))
        for mine, theirs in zip(answer, rest, strict=True):
            mine[left] = theirs
    return answer


def refine(out: dict[str, Array], columns: Array, law: str) -> None:
    """Integrate the work of the designs that are flagged ``rough`` with more and more nodes."""
    nodes = 2 * energy.FEW_NODES
    out["rough"] &= out["settled"]
    while out["rough"].any() and nodes <= energy.MOST_NODES:
        lanes = np.flatnonzero(out["rough"])
        more = np.stack([out[name][lanes] for name in ("neighbour", "theta_c", "pole")])
        again = in_blocks(compiled("more_work", law=law, nodes=nodes), np.concatenate([columns[:, lanes], more]))
        out["W_fr"][lanes], out["rough"][lanes] = again["work"], again["rough"]
        nodes *= 2


def meets_another(out: dict[str, Array], columns: Array) -> Array:
    """Whether another neighbour's tip-side contact comes in, of the designs whose lines meet."""
    found = np.zeros(columns.shape[1], bool)
    lanes = np.flatnonzero(out["crossed"] & out["settled"])
    if lanes.size:
        row = Twist(*columns[:6, lanes])._replace(k=out["neighbour"][lanes])
        found[lanes] = first_crossing(row, row.theta0, out["theta_end"][lanes]).k > 0
    return found


def double(jax: Any) -> AbstractContextManager[Any]:
    """Double precision for a block of code; the user's setting is back behind it."""
    # older releases have it in jax.experimental
    home = jax if hasattr(jax, "enable_x64") else import_module("jax.experimental")
    switch: AbstractContextManager[Any] = home.enable_x64(True)
    return switch


def in_blocks(f: Callable[..., dict[str, Any]], columns: Array, *common: float) -> dict[str, Array]:
    """Answer the designs block by block, each padded to one of few sizes by repeating its last design."""
    import jax

    sizes = SIZES.get(jax.default_backend(), SIZES["gpu"])
    n, low, parts = columns.shape[1], 0, []
    while low < n:
        # the smallest block that takes what is left, or the largest
        size = next((s for s in sizes if s >= n - low), sizes[-1])
        part = columns[:, low : low + size]
        answer = f(np.pad(part, ((0, 0), (0, size - part.shape[1])), mode="edge"), *common)
        parts.append({name: np.asarray(v)[: part.shape[1]] for name, v in answer.items()})
        low += size
    return {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}


@functools.cache
def compiled(name: str, **settings: str | int) -> Callable[..., dict[str, Any]]:
    """Return a function of :mod:`squama.engines.xla_paths`, compiled for these settings when it first runs."""
    import jax

    from squama.engines import xla_paths

    found: Callable[..., dict[str, Any]] = jax.jit(functools.partial(getattr(xla_paths, name), **settings))
    return found
