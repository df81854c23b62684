"""The documentation holds: every block of it is executed, every name in it exists.

In a page, in the order in which they stand and in one temporary folder and one namespace: ``python`` blocks and cells
are executed, and a ``text`` block right behind one must be what it printed; a block behind ``<!-- file: name -->`` is
written to that file; every ``$ squama ...`` line of a ``console`` block is run, with exit status 0 or that of
``<!-- exit n -->``. A block behind ``<!-- needs name -->`` is left out where that package is not installed.
``<!-- long -->`` before a console block leaves it to ``make verify``, as do pages of :data:`LONG` all of theirs. Cells
of :data:`LONG_CELLS` are executed by ``make docs`` alone.
"""

from __future__ import annotations

import contextlib
import doctest
import importlib
import importlib.util
import io
import pkgutil
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import squama
from squama.beam.beamfile import TABLES
from squama.model.outcome import SENTENCES

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(p for p in DOCS.rglob("*.md") if "_build" not in p.parts)]
LONG = {"command_examples", "decide", "fit", "graded", "specimen", "machine", "uncertainty", "vibration"}
LONG |= {"combined", "commands", "cycles", "design", "explore", "flags", "indices", "load", "maps", "row", "tables"}
LONG |= {"decay", "trust", "view"}
"""Pages that take more than 4 s."""
LONG_CELLS = {"elements", "fit", "front", "graded", "how_many", "limb", "regimes", "tolerances"}
"""Pages of the gallery that take more than 4 s."""
MODULES = sorted(
    m.name for m in pkgutil.walk_packages(squama.__path__, "squama.") if m.name.rsplit(".", 1)[-1] != "__main__"
)
_FENCE = re.compile(
    r"^(?:<!-- (?P<mark>[^>]*?) -->\n)?(?P<fence>```+)(?P<lang>[^\n]*)\n(?P<body>.*?)^(?P=fence)$", re.M | re.S
)


class Block(NamedTuple):
    """A fenced block: its language, text, mark, line, and whether it stands right behind the block before it."""

    lang: str
    body: str
    mark: str
    line: int
    follows: bool


def blocks(page: Path) -> Iterator[Block]:
    text = page.read_text(encoding="utf-8")
    end = 0
    for m in _FENCE.finditer(text):
        follows = not text[end : m.start()].strip() and end > 0
        line = text.count("\n", 0, m.start("body")) + 1
        yield Block(m["lang"].strip(), m["body"], m["mark"] or "", line, follows)
        end = m.end()


def commands(body: str) -> list[list[str]]:
    """Arguments of every ``$ squama`` line; a backslash goes on to the next line."""
    lines = body.replace("\\\n", " ").splitlines()
    return [shlex.split(line[2:], comments=True)[1:] for line in lines if line.startswith("$ squama")]


def run_command(arguments: list[str]) -> int:
    from squama.cli import main

    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            return int(main(arguments) or 0)
    except SystemExit as stop:
        return int(stop.code or 0)


def run_page(page: Path, folder: Path, *, long: bool) -> None:
    namespace: dict[str, Any] = {"__name__": page.stem}
    printed = ""
    for block in blocks(page):
        where = f"{page.relative_to(ROOT)}:{block.line}"
        if block.mark.startswith("file: "):
            (folder / block.mark[6:]).write_text(block.body, encoding="utf-8")
        if block.mark.startswith("needs ") and importlib.util.find_spec(block.mark[6:]) is None:
            continue
        if block.lang == "text" and block.follows and printed:
            assert printed.split() == block.body.split(), f"{where}: printed\n{printed}"
        printed = ""
        if block.lang in {"python", "{code-cell} python"}:
            out = io.StringIO()
            source = re.sub(r"^:.*$", "", block.body, count=1, flags=re.M) if block.lang[0] == "{" else block.body
            code = compile("\n" * (block.line - 1) + source, str(page), "exec")
            with contextlib.redirect_stdout(out):
                exec(code, namespace)
            printed = out.getvalue()
        elif block.lang == "console":
            if block.mark == "long" and not long:
                continue
            status = int(block.mark[5:]) if block.mark.startswith("exit ") else 0
            for arguments in commands(block.body):
                assert run_command(arguments) == status, f"{where}: squama {shlex.join(arguments)}"


def long(page: Path) -> bool:
    """Say whether a page of the docs is left to ``make verify``."""
    return page.stem in (LONG_CELLS if page.parent.name == "gallery" else LONG)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Enter a folder for a page's files; the examples are in it as in the repository."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    # as deep in it as pages of the gallery
    (place := tmp_path / "docs" / "gallery").mkdir(parents=True)
    (place / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(place)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    return place


@pytest.mark.parametrize("page", [p for p in PAGES if not long(p)], ids=lambda p: p.relative_to(ROOT).as_posix())
def test_blocks_of_a_page_run(page: Path, folder: Path) -> None:
    run_page(page, folder, long=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [p for p in PAGES if (long(p) or "<!-- long -->" in p.read_text(encoding="utf-8")) and p.parent.name != "gallery"],
    ids=lambda p: p.name,
)
def test_long_blocks_of_a_page_run(page: Path, folder: Path) -> None:
    run_page(page, folder, long=True)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_marks_and_languages_of_blocks_are_known(page: Path) -> None:
    for block in blocks(page):
        assert re.fullmatch(r"(file: [\w.]+|exit \d|needs \w+|long)?", block.mark)
        assert block.lang in {"python", "console", "text", "toml"} or block.lang.startswith("{")


@pytest.mark.parametrize("module", MODULES)
def test_examples_in_docstrings(module: str, folder: Path) -> None:
    failed, _ = doctest.testmod(importlib.import_module(module))
    assert failed == 0


def ledger() -> list[str]:
    text = "".join((DOCS / f"{page}.md").read_text(encoding="utf-8") for page in ("ledger", "ledger_more"))
    return [line for line in text.splitlines() if line.startswith("| ") and "`" in line]


def resolve(name: str) -> Any:
    """Import a dotted name: the longest module, then attributes."""
    parts = name.split(".")
    for n in range(len(parts), 0, -1):
        try:
            found: Any = importlib.import_module(".".join(parts[:n]))
        except ModuleNotFoundError:
            continue
        for part in parts[n:]:
            found = getattr(found, part)
        return found
    raise LookupError(name)


def test_ledger_has_every_equation_with_a_function_and_a_test() -> None:
    seen = set()
    for line in ledger():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if cells[0].isdecimal():
            seen.add(int(cells[0]))
        assert re.search(r"`squama\.[\w.]+`.*: `tests/", cells[-1]), line
        assert re.search(r"`tests/[\w./]+`", cells[-1]), line
    assert seen == set(range(1, 17))


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_names_and_files_that_pages_mention_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for name in re.findall(r"[`<]~?(squama(?:\.\w+)+)", text):
        resolve(name)
    for path in re.findall(r"`((?:tests|src|docs(?!/_build)|examples|benchmarks)/[\w./]*)`", text):
        assert (ROOT / path).exists(), path
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):
        assert (page.parent / target).exists(), target


def test_every_end_stands_in_the_docs_with_its_sentence() -> None:
    text = (DOCS / "howto" / "ends.md").read_text(encoding="utf-8")
    for end, sentence in SENTENCES.items():
        assert f"| `{end}` | {sentence} |" in text


def test_every_key_of_a_beam_file_is_explained() -> None:
    text = (DOCS / "howto" / "keys.md").read_text(encoding="utf-8")
    assert "```{squama-table} keys\n" in text  # all keys, with the limits of numbers
    for table, content in TABLES.items():
        for key, row in content.items():
            assert row.bounds or f"`{key}`" in text, f"{table}.{key}"


def test_docs_are_public() -> None:
    hosts = {"arxiv.org", "doi.org", "keepachangelog.com", "semver.org"}
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        assert "shared/" not in text
        assert set(re.findall(r"https?://([^/\s)>]+)", text)) <= hosts
        assert not re.search(r"(?<![\w.])/(?:home|work|root|tmp|Users)/", text)


def test_every_public_name_stands_in_the_pages_of_the_interface() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "interface").glob("*.md"))
    names = [f"squama.{name}" for name in squama.__all__ if name not in ("SYMBOLS", "__version__")]
    names += [f"squama.plot.{name}" for name in squama.plot.__all__]
    assert [name for name in names if f":: {name}\n" not in text] == []
