"""Plant many errors at once, each behind a switch: one compilation serves all of them, where each would need its own.

Every error that stands in the body of a function becomes ``wrong if planted(k) else right``. The package is imported,
compiled and tested once with all switches off; a process forked from there has one of them on.
"""

from __future__ import annotations

import ast
import ctypes
import functools
import os
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plant import Mutant

ON = "SQUAMA_PLANTED"
"""Variable of the environment that says to scripts which error is on."""
SWITCH = ctypes.c_int64(int(os.environ.get(ON, "0")))
"""Number of the error that is on; 0 for none. Compiled code reads it at its address, the same in forked processes."""
Steps = tuple[tuple[str, int], ...]
"""The way to a node from the root of a syntax tree: fields, and places in those that are lists (-1 in others)."""


def planted(number: int) -> bool:
    """Whether an error is on."""
    return SWITCH.value == number


def compiles() -> None:
    """Let compiled code call :func:`planted`, and keep none of it on the disk: other processes have another address."""
    from llvmlite import ir
    from numba import extending, types

    from squama.batch import keeping

    def lower(_: Any, builder: Any, __: Any, args: Any) -> Any:
        number = ir.IntType(64)
        place = builder.inttoptr(ir.Constant(number, ctypes.addressof(SWITCH)), number.as_pointer())
        return builder.icmp_signed("==", builder.load(place), args[0])

    def nowhere(_: Any) -> None:
        raise RuntimeError

    extending.type_callable(planted)(lambda _: lambda __: types.boolean)
    extending.lower_builtin(planted, types.Integer)(lower)
    keeping._Copy = nowhere  # type: ignore[assignment,misc]


def children(node: ast.AST) -> Iterator[tuple[tuple[str, int], Any]]:
    """Yield what a node consists of."""
    for field, value in ast.iter_fields(node):
        if isinstance(value, list):
            yield from (((field, i), v) for i, v in enumerate(value))
        else:
            yield (field, -1), value


def difference(a: ast.AST, b: ast.AST) -> Steps:
    """Return the way to the smallest expression or statement that holds all differences of two trees."""
    one, other = dict(children(a)), dict(children(b))
    unlike = [step for step in one if step not in other or _text(one[step]) != _text(other[step])]
    if len(one) != len(other) or len(unlike) != 1 or type(a) is not type(b):
        return ()
    (step,) = unlike
    inner, outer = one[step], other[step]
    if not isinstance(inner, ast.AST) or type(inner) is not type(outer):
        return (step,) if isinstance(inner, ast.expr | ast.stmt) else ()
    deeper = difference(inner, outer)
    return (step, *deeper) if deeper or isinstance(inner, ast.expr | ast.stmt) else ()


def _text(node: Any) -> str:
    return ast.dump(node) if isinstance(node, ast.AST) else repr(node)


def found(node: Any, steps: Steps) -> Any:
    """Return the node at the end of a way."""
    for field, i in steps:
        node = getattr(node, field) if i < 0 else getattr(node, field)[i]
    return node


def executed(tree: ast.AST, steps: Steps) -> bool:
    """Whether the node at the end of a way is a value, or a statement, in the body of a function."""
    node: Any = tree
    inside = False
    for field, i in steps:
        inside = inside or (isinstance(node, ast.FunctionDef) and field == "body")
        if isinstance(node, ast.AnnAssign | ast.arg | ast.FunctionDef) and field in ("annotation", "returns", "args"):
            return False
        node = getattr(node, field) if i < 0 else getattr(node, field)[i]
    return inside and isinstance(getattr(node, "ctx", ast.Load()), ast.Load)


def whole(tree: ast.AST, steps: Steps, wrong: Any) -> bool:
    """Whether an error makes a fraction of a whole number, or stands for the place in a tuple: both change a type."""
    counted = {n.target.id for n in ast.walk(tree) if isinstance(n, ast.For) and isinstance(n.target, ast.Name)}
    if isinstance(wrong, ast.BinOp) and isinstance(wrong.op, ast.Div):
        parts = (wrong.left, wrong.right)
        return all(getattr(p, "id", None) in counted or isinstance(getattr(p, "value", None), int) for p in parts)
    owner = found(tree, steps[:-1])
    return isinstance(owner, ast.Subscript) and isinstance(owner.value, ast.Call) and steps[-1][0] == "slice"


def with_switches(source: str, errors: list[tuple[int, Mutant]]) -> tuple[str, list[int]]:
    """Return a file with errors behind switches, and the numbers of those that could be put in."""
    tree = ast.parse(source)
    places: dict[Steps, list[tuple[int, Any]]] = {}
    for number, m in errors:
        other = ast.parse(m.apply(source))
        steps = difference(tree, other)
        while steps and steps[-1][0] == "func":  # compiled code has no functions as values
            steps = steps[:-1]
        if steps and executed(tree, steps) and not whole(tree, steps, found(other, steps)):
            places.setdefault(steps, []).append((number, found(other, steps)))
    # the deepest ones first: those above keep them in their right branch
    for steps in sorted(places, key=len, reverse=True):
        right = found(tree, steps)
        for number, wrong in places[steps]:
            test = ast.parse(f"planted({number})", mode="eval").body
            statement = isinstance(right, ast.stmt)
            right = ast.If(test, [wrong], [right]) if statement else ast.IfExp(test, wrong, right)
        owner, (field, i) = found(tree, steps[:-1]), steps[-1]
        if i < 0:
            setattr(owner, field, right)
        else:
            getattr(owner, field)[i] = right
    last = max(i for i, n in enumerate(tree.body) if isinstance(n, ast.ImportFrom) and n.module == "__future__")
    tree.body[last + 1 : last + 1] = ast.parse("from switched import planted").body
    text = ast.unparse(ast.fix_missing_locations(tree))
    return text, sorted(number for several in places.values() for number, _ in several)


def put_in(source: Path, todo: list[Mutant]) -> dict[int, Mutant]:
    """Put errors behind switches into a copy of the package's folder; return those that could be, by number."""
    by_number = dict(enumerate(todo, 1))
    put: dict[int, Mutant] = {}
    for file in dict.fromkeys(m.file for m in todo):
        path = source / "squama" / file
        own = [(number, m) for number, m in by_number.items() if m.file == file]
        text, numbers = with_switches(path.read_text(encoding="utf-8"), own)
        path.write_text(text, encoding="utf-8")
        put |= {number: by_number[number] for number in numbers}
    shutil.copy2(__file__, source)
    return put


def of_another_type(told: str) -> set[int]:
    """Return the errors in the line that could not be compiled, by what the compiler says: they give another type."""
    lines = [line for line in told.splitlines() if line.startswith("E ") and "planted(" in line]
    return {int(number) for number in re.findall(r"planted\((\d+)\)", "".join(lines[:1]))}


def turn_on(number: int, tests: Path) -> None:
    """Turn an error on, and forget what was found without it."""
    SWITCH.value, os.environ[ON] = number, str(number)
    for name, module in list(sys.modules.items()):
        if str(tests) in str(getattr(module, "__file__", "")):
            del sys.modules[name]
        elif name.partition(".")[0] == "squama":
            for kept in vars(module).values():
                if isinstance(kept, functools._lru_cache_wrapper):
                    kept.cache_clear()
