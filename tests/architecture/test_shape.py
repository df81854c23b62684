"""The size of things, and names that do not stand in each other's way."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import squama

ROOT = Path(__file__).parents[2]
SRC = ROOT / "src" / "squama"
MODULES = sorted(SRC.rglob("*.py"))
MOST_CODE_LINES = 80
MOST_ROOT_MODULES = 13


def code_lines(function: ast.FunctionDef | ast.AsyncFunctionDef, lines: list[str]) -> int:
    """Lines of a function without its docstring, comments and blank lines."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    said = function.body[0] if len(body) < len(function.body) else None
    skipped = range(said.lineno, (said.end_lineno or 0) + 1) if said else range(0)
    own = (i for i in range(function.lineno, (function.end_lineno or 0) + 1) if i not in skipped)
    return sum(1 for i in own if lines[i - 1].strip() and not lines[i - 1].lstrip().startswith("#"))


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(SRC)))
def test_functions_can_be_seen_whole(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    found = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    assert {f.name: n for f in found if (n := code_lines(f, text.splitlines())) > MOST_CODE_LINES} == {}


def test_few_modules_stand_at_the_root() -> None:
    assert len(list(SRC.glob("*.py"))) <= MOST_ROOT_MODULES


def test_no_room_or_module_bears_a_public_name() -> None:
    here = {p.stem for p in SRC.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}
    assert not here & set(squama.__all__)


_TOUCH = """
import importlib, inspect, pkgutil, random, sys
import squama
r = random.Random(int(sys.argv[1]))
rooms = [m.name for m in pkgutil.walk_packages(squama.__path__, "squama.") if not m.name.endswith("__main__")]
todo = [*squama.__all__, *rooms]
r.shuffle(todo)
for name in todo:
    try:
        importlib.import_module(name) if "." in name else getattr(squama, name)
    except ImportError as error:
        # an extra that is not installed
        assert not str(error.name or "").startswith("squama"), error
for name in squama.__all__:
    value = getattr(squama, name)
    assert not inspect.ismodule(value), name
    if not inspect.isfunction(value):
        continue
    given = inspect.signature(value).parameters.values()
    needed = [p for p in given if p.default is p.empty and p.kind is not p.VAR_KEYWORD]
    try:
        value()
    except TypeError as error:
        assert needed and "missing" in str(error), (name, error)
    else:
        assert not needed, name
assert not set(dir(squama)) - set(squama.__all__)
print(len(todo))
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_names_work_in_whatever_order_they_are_touched(seed: int) -> None:
    done = subprocess.run([sys.executable, "-c", _TOUCH, str(seed)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > len(squama.__all__)
