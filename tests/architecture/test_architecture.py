"""The shape of the package: imports point one way, files are small, the facade is light."""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import squama

ROOT = Path(__file__).parents[2]
SRC = ROOT / "src" / "squama"
LAYERS = (
    ("errors", "types", "_version", "symbols", "interrupt", "needs", "progress"),
    ("units",),
    ("model",),
    ("arguments", "batch", "loads", "people"),
    ("io",),
    ("beam",),
    ("fe",),
    ("joints", "contacts"),
    ("curves", "arrays"),
    ("fabrication", "dynamics", "part", "sections"),
    ("plot", "study", "identify", "inverse"),
    ("paper", "scene"),
    ("web",),
    ("cli",),
    ("__main__",),
)
"""Every room of the package, lowest first; a room may import from its own layer and from those before it."""
HEAVY = {
    "numpy",
    "scipy",
    "pint",
    "matplotlib",
    "xarray",
    "numba",
    "pydantic",
    "rich",
    "cyclopts",
    "h5py",
    "h5netcdf",
}
MOST_LINES = 450
MODULES = {
    ".".join(p.relative_to(SRC).with_suffix("").parts).removesuffix(".__init__"): p
    for p in sorted(SRC.rglob("*.py"))
    if p != SRC / "__init__.py"
}


def room(module: str) -> str:
    return module.split(".", maxsplit=1)[0]


def layer(module: str) -> int:
    return next(i for i, rooms in enumerate(LAYERS) if room(module) in rooms)


def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path: Path) -> Iterator[tuple[str, bool, bool]]:
    """Module of the package that is imported, whether only when called, whether only for type checking."""

    def visit(node: ast.AST, lazy: bool, typing: bool) -> Iterator[tuple[str, bool, bool]]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.expr):
                continue
            if isinstance(child, ast.Import):
                yield from ((a.name, lazy, typing) for a in child.names)
            elif isinstance(child, ast.ImportFrom):
                assert child.level == 0, f"{path}: relative import"
                yield from ((f"{child.module}.{a.name}", lazy, typing) for a in child.names)
            inner = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
            yield from visit(child, lazy or isinstance(child, ast.FunctionDef), typing or inner)

    for name, lazy, typing in visit(tree(path), False, False):
        if name.split(".")[0] != "squama":
            yield name, lazy, typing
            continue
        short = name.removeprefix("squama").removeprefix(".")
        # the name may be a module or something in one
        yield next((m for m in (short, short.rpartition(".")[0]) if m in MODULES), "squama"), lazy, typing


@functools.cache
def graph() -> dict[str, list[tuple[str, bool, bool]]]:
    """What every module imports; only the processes that ask for it read all sources."""
    return {module: list(imports(path)) for module, path in MODULES.items()}


def test_every_room_has_its_layer() -> None:
    rooms = [r for rooms in LAYERS for r in rooms]
    assert len(rooms) == len(set(rooms))
    assert {room(m) for m in MODULES} == set(rooms)


@pytest.mark.parametrize("module", list(MODULES))
def test_imports_point_one_way(module: str) -> None:
    wrong = [m for m, _, typing in graph()[module] if m in MODULES and not typing and layer(m) > layer(module)]
    assert not wrong
    # nothing inside goes through the facade, which would import everything's names
    assert "squama" not in [m for m, _, _ in graph()[module]]


def test_there_are_no_cycles() -> None:
    # lazy imports and those for types count, too
    edges = {m: {n for n, _, _ in found if n in MODULES} for m, found in graph().items()}
    order = list(TopologicalSorter(edges).static_order())
    assert set(order) == set(MODULES)


def test_the_model_is_pure() -> None:
    """It knows nothing of beams, files, plots or the command line, and says nothing."""
    for module in (m for m in MODULES if room(m) == "model"):
        inside = {m for m, _, _ in graph()[module] if m in MODULES}
        assert {room(m) for m in inside} <= {"model", "errors", "types"}, module
        outside = {m.split(".")[0] for m, _, _ in graph()[module] if m not in MODULES}
        standard = {"__future__", "collections", "functools", "math", "typing", "warnings", "enum", "threading"}
        assert outside <= standard | {"numpy", "scipy"}, module
        calls = [
            n.func.id
            for n in ast.walk(tree(MODULES[module]))
            if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)
        ]
        assert not {"print", "open", "input", "eval", "exec"} & set(calls), module


def test_one_place_decides_where_compiled_code_is_kept() -> None:
    """Numba stops an import where no folder for its cache can be written; :mod:`squama.batch.keeping` does not."""
    keeps = {m for m, path in MODULES.items() if re.search("cache=True|enable_caching|FunctionCache", path.read_text())}
    assert keeps == {"batch.keeping"}


def test_the_geometry_imports_nothing_at_all() -> None:
    for module in ("model.twisting", "model.laws"):
        names = {m.rpartition(".")[0] or m for m, _, _ in graph()[module]}
        assert names <= {"__future__", "collections.abc", "typing", "model"}


def files(*folders: str) -> list[Path]:
    return [p for f in folders for p in sorted((ROOT / f).rglob("*.py"))]


@pytest.mark.parametrize("path", files("src", "tests"), ids=lambda p: str(p.relative_to(ROOT)))
def test_files_are_small_and_plain(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= MOST_LINES
    # no invisible characters, no look-alikes of letters: what is not ASCII is a sign of a unit or a typographic mark
    if text.isascii():
        return
    strange = {c for c in text if ord(c) > 127} - set("°µμ·⋅²³é–−×→±≤≥θφηβλαψκζ…“”‘’")
    assert not strange or path.parent.name == "unit"
    code = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Name | ast.arg | ast.FunctionDef | ast.ClassDef)]
    names = {getattr(n, "id", None) or getattr(n, "arg", None) or n.name for n in code}
    assert all(name.isascii() for name in names)


def test_every_file_of_the_package_says_what_it_is() -> None:
    for path in MODULES.values():
        assert ast.get_docstring(tree(path)), path


def fresh(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT / "src")
    return done.stdout


def test_importing_squama_is_light() -> None:
    loaded = fresh("import squama, sys; print(*{m.split('.')[0] for m in sys.modules})").split()
    assert not HEAVY & set(loaded)
    ours = fresh("import squama, sys; print(*[m for m in sys.modules if m.startswith('squama')])").split()
    assert set(ours) == {"squama", "squama.errors"}


def test_a_calculation_needs_no_plots_and_no_pint() -> None:
    loaded = fresh(
        "import squama, sys; squama.ends(eta=3, beta=1.25, lam=.45, alpha=.8, theta0=.17, mu=.2);"
        "squama.twist(squama.Beam.from_ratios(), mu=.2, joint='hinge'); print(*{m.split('.')[0] for m in sys.modules})"
    ).split()
    assert not {"pint", "matplotlib", "numba", "rich", "cyclopts", "sympy"} & set(loaded)


def test_a_compliant_beam_needs_no_elements_and_no_plots() -> None:
    loaded = fresh("import squama, sys; squama.twist(squama.Beam.from_ratios(), mu=.2); print(*sys.modules)").split()
    assert not {"pint", "matplotlib", "rich", "cyclopts", "sympy", "ipctk", "netgen"} & {
        m.split(".")[0] for m in loaded
    }
    assert not [m for m in loaded if m.startswith("squama.fe.solver")]


def test_versions_agree() -> None:
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert cited is not None
    assert cited[1] == squama.__version__
