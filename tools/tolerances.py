"""The tests' tolerances beside the deviations they meet: ``python tools/tolerances.py [arguments of pytest]``.

Runs the tests in this process and lists each comparison whose tolerance is below 30 times the largest deviation
measured, unless its reason stands there: a comment that begins with ``# tolerance:`` in the same function, or with
``# tolerances:`` at the left margin for the whole file. Read are ``pytest.approx``, ``assert_allclose``, ``allclose``
and ``isclose`` of NumPy, and asserts that something is smaller than a number up to 0.01 or a multiple of one.
"""

from __future__ import annotations

import ast
import builtins
import sys
import tempfile
from collections.abc import Callable
from copy import deepcopy
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
TESTS = str(ROOT / "tests")
FACTOR, SMALL = 30.0, 0.01


class Met(NamedTuple):
    """The largest deviation of a comparison as a part of its tolerance, and both as they are."""

    part: float
    deviation: float
    tolerance: float


met: dict[tuple[str, int], Met] = {}


def note(deviation: object, tolerance: object) -> None:
    """Keep the worst of some deviations under the line of the tests that asks; failed ones are the tests' matter."""
    frame = sys._getframe(1)
    while not frame.f_code.co_filename.startswith(TESTS):
        if frame.f_back is None:
            return
        frame = frame.f_back
    away, allowed = np.broadcast_arrays(np.abs(np.asarray(deviation, float)), np.asarray(tolerance, float))
    known = (away > 0) & (away <= allowed)
    if known.any():
        part = np.where(known, away, 0) / np.where(known, allowed, 1)
        i = np.unravel_index(part.argmax(), part.shape)
        key = frame.f_code.co_filename, frame.f_lineno
        met[key] = max(met.get(key, Met(0, 0, 0)), Met(float(part[i]), float(away[i]), float(allowed[i])))


def note_approx() -> None:
    """Have ``pytest.approx`` note each pair of numbers."""
    scalar = type(pytest.approx(1.0))
    equal = scalar.__eq__

    def noted(self: Any, actual: object) -> bool:
        numbers = all(isinstance(x, int | float | np.number) for x in (actual, self.expected))
        if numbers and np.isfinite(self.expected):
            note(actual - self.expected, self.tolerance)
        return bool(equal(self, actual))

    scalar.__eq__ = noted  # type: ignore[method-assign]


def note_numpy(module: object, name: str, rtol: float, atol: float) -> None:
    """Have a comparison of NumPy note its arrays; two defaults of its tolerances."""
    plain: Callable[..., object] = getattr(module, name)

    def noted(a: object, b: object, rtol: float = rtol, atol: float = atol, **options: bool) -> object:
        left, right = np.asarray(a), np.asarray(b)
        if left.dtype.kind in "fiu" and right.dtype.kind in "fiu":
            with np.errstate(invalid="ignore"):
                note(left - right, atol + rtol * np.abs(right))
        return plain(a, b, rtol=rtol, atol=atol, **options)

    setattr(module, name, noted)


class Bounds(ast.NodeTransformer):
    """Has asserts of ``... < 1e-6`` and ``... <= 1e-6 * size`` note both sides."""

    def visit_Assert(self, node: ast.Assert) -> ast.Assert:
        """Look at the comparisons of an assert only."""
        for compare in (n for n in ast.walk(node.test) if isinstance(n, ast.Compare)):
            sides = [compare.left, *compare.comparators]
            for i, op in enumerate(compare.ops):
                if isinstance(op, ast.Lt | ast.LtE) and self.small(sides[i + 1]):
                    noted = ast.Call(ast.Name("__below__", ast.Load()), [sides[i], deepcopy(sides[i + 1])], [])
                    sides[i] = ast.copy_location(noted, sides[i])
            compare.left, compare.comparators = sides[0], sides[1:]
        return ast.fix_missing_locations(node)

    def small(self, bound: ast.expr) -> bool:
        """Tell whether a bound is a small number or a multiple of one."""
        if isinstance(bound, ast.BinOp):
            both = all if isinstance(bound.op, ast.Add | ast.Sub) else any
            return both(self.small(side) for side in (bound.left, bound.right))
        return isinstance(bound, ast.Constant) and isinstance(bound.value, float) and 0 < bound.value <= SMALL


def below(value: object, bound: object) -> object:
    """Note and return what an assert wants below a bound."""
    if isinstance(value, int | float | np.generic | np.ndarray) or hasattr(value, "to_numpy"):
        note(value, bound)
    return value


def read_asserts() -> None:
    """Compile the modules of the tests with ``Bounds``, past the cache of compiled files."""
    plain = SourceFileLoader.source_to_code

    def compiled(self: SourceFileLoader, data: bytes, path: str, **options: int) -> object:
        tree = Bounds().visit(ast.parse(data)) if str(path).startswith(TESTS) else data
        return plain(self, tree, path, **options)

    SourceFileLoader.source_to_code = compiled  # type: ignore[method-assign, assignment]
    builtins.__below__ = below  # type: ignore[attr-defined]


def reasoned(file: str, line: int) -> bool:
    """Tell whether the reason for a tolerance stands in its function, or in its file for all."""
    text = Path(file).read_text(encoding="utf-8")
    lines = text.splitlines()
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            first = min([node.lineno, *(d.lineno for d in node.decorator_list)])
            if first <= line <= (node.end_lineno or first):
                mine = lines[first - 1 : node.end_lineno]
                return any("# tolerance:" in x for x in mine) or any(x.startswith("# tolerances:") for x in lines)
    return any(x.startswith("# tolerances:") for x in lines)


def main() -> int:
    """Run the tests, print the narrow tolerances without a reason, return 1 where there are some."""
    note_approx()
    note_numpy(np.testing, "assert_allclose", 1e-7, 0.0)
    note_numpy(np, "allclose", 1e-5, 1e-8)
    note_numpy(np, "isclose", 1e-5, 1e-8)
    read_asserts()
    with tempfile.TemporaryDirectory() as empty:
        sys.pycache_prefix = empty
        status = pytest.main(["--assert=plain", "-q", *sys.argv[1:]])
    narrow = sorted(key for key, one in met.items() if one.part * FACTOR > 1 and not reasoned(*key))
    for file, line in narrow:
        one, source = met[file, line], Path(file).read_text(encoding="utf-8").splitlines()[line - 1].strip()
        print(f"{Path(file).relative_to(ROOT)}:{line}: {one.deviation:.1e} of {one.tolerance:.1e}  {source}")
    print(f"{len(narrow)} of {len(met)} tolerances with a deviation are below {FACTOR:g} times it, without a reason")
    return int(status) or int(bool(narrow))


if __name__ == "__main__":
    sys.exit(main())
