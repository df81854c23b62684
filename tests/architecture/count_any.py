"""Counts ``Any`` in the annotations of the package, by room: ``python tests/architecture/count_any.py [folder]``."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

SRC = Path(__file__).parents[2] / "src" / "squama"


def annotations(tree: ast.AST) -> Iterator[ast.expr]:
    """Yield every annotation, and the values that stand for one (``Array = NDArray[Any]``, ``cast``'s types)."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.returns:
            yield node.returns
        elif isinstance(node, ast.arg | ast.AnnAssign) and node.annotation:
            yield node.annotation
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Subscript):
            yield node.value
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "cast":
            yield node.args[0]


def count(text: str) -> int:
    """Return how often the annotations of a module name ``Any``."""
    found = {
        (n.lineno, n.col_offset)
        for one in annotations(ast.parse(text))
        for n in ast.walk(one)
        if isinstance(n, ast.Name) and n.id == "Any"
    }
    return len(found)


def rooms(source: Path) -> Counter[str]:
    """Return the counts by room; the modules at the root are one each."""
    counts: Counter[str] = Counter()
    for path in sorted(source.rglob("*.py")):
        counts[path.relative_to(source).parts[0].removesuffix(".py")] += count(path.read_text(encoding="utf-8"))
    return counts


if __name__ == "__main__":
    found = rooms(Path(sys.argv[1]) if len(sys.argv) > 1 else SRC)
    for name, number in found.most_common():
        if number:
            print(f"{number:5} {name}")
    print(f"{found.total():5} in all")
