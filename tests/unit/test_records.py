"""Named tuples that compiled code is given by their address, and functions that are compiled for types alone."""

from __future__ import annotations

import gc
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from squama.batch.keeping import kept, making, part
from squama.batch.records import held
from squama.types import Array


class Inner(NamedTuple):
    a: Array
    k: int


class Outer(NamedTuple):
    inner: Inner
    b: Array
    c: Array
    yes: bool
    f: float


@part
def _scaled(v: Inner, by: int) -> float:
    out: float = by * v.k * v.a[1, -1]
    return out


@part
def _read(w: Outer) -> float:
    """Read fields before and behind a change of what they hold."""
    first = w.c[0]
    for i in range(len(w.c)):
        w.c[i] += w.b[i, 0, i] if w.yes else 0.0
    w.inner.a[1, 2] = w.f * first + w.c.sum()
    return _scaled(w.inner, 2) + _scaled(w.inner, w.inner.k) + w.b[:, 1].size


@part
def _given(w: Outer) -> float:
    return _read(held(w))


@making
def _made(n: int, b: Array, f: float) -> Outer:
    a = np.zeros((2, 3), b.dtype)
    return Outer(Inner(a, n), b, np.arange(n) + 0.0 * b[0, 0, 0], n > 1, f)


def _all(n: int, b: Array, f: float, out: Array) -> None:
    # many of them, so that what is freed would be written to again
    for i in range(len(out)):
        w = _made(n, b, f + i)
        out[i] = _given(w) + w.inner.a[1, 2] + w.c[1]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("kind", [float, complex])
def test_records_are_their_tuples(kind: type) -> None:
    b = np.random.default_rng(1).random((3, 2, 3)).astype(kind)
    b += 1j * b[::-1] if kind is complex else 0.0
    out, expected = np.zeros(500, kind), np.zeros(500, kind)
    kept(_all, [Path(__file__)])(3, b, 0.25, out)
    for i in range(500):
        c = np.arange(3) + b[range(3), 0, range(3)]
        last = (0.25 + i) * 0.0 + c.sum()
        expected[i] = (2 * 3 + 3 * 3) * last + b[:, 1].size + last + c[1]
    np.testing.assert_allclose(out, expected, rtol=1e-13)
    # with constants, and without: one version for the types of each kind of numbers
    assert len(_scaled.signatures) == len(_read.signatures) <= 2  # type: ignore[attr-defined]


def test_a_record_is_its_tuple_outside_of_compiled_code() -> None:
    w = Inner(np.zeros(1), 2)
    assert held(w) is w


@pytest.mark.parametrize("collects", [True, False])
def test_garbage_is_collected_again_behind_a_compilation(collects: bool) -> None:
    def f(x: float) -> float:
        return x + collects

    before = gc.isenabled()
    try:
        (gc.enable if collects else gc.disable)()
        assert kept(f, [Path(__file__)])(1.0) == 1.0 + collects
        assert gc.isenabled() == collects
    finally:
        (gc.enable if before else gc.disable)()
