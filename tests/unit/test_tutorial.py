"""The chapters of the tutorial run from beginning to end and print the text of the docs."""

import copy
import re
import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PICTURES = {"tutorial": 1, "tutorial_limb": 1, "tutorial_made": 0}
"""Chapters, and the pictures in each."""
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def printed(notebook) -> list[str]:
    """What each code cell has printed."""
    cells = [c for c in notebook.cells if c.cell_type == "code"]
    return ["".join(o.text for o in c.outputs if o.output_type == "stream" and o.name == "stdout") for c in cells]


def notebook(chapter: str) -> Path:
    return ROOT / "docs" / f"{chapter}.ipynb"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run a notebook beside copies of the examples."""
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    for module in ("SALib", "ipykernel"):
        pytest.importorskip(module)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    (tmp_path / "docs").mkdir()
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    monkeypatch.setenv("PYTHONWARNINGS", "default")

    def do(notebook):
        done = copy.deepcopy(notebook)
        client = nbclient.NotebookClient(done, timeout=300, resources={"metadata": {"path": str(tmp_path / "docs")}})
        client.execute()
        return done

    return lambda chapter: nbformat.read(notebook(chapter), as_version=4), do


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("chapter", PICTURES)
def test_a_chapter_runs_and_prints_what_it_shows(run, chapter):
    read, do = run
    stored = read(chapter)
    done = do(stored)
    shown, now = printed(stored), printed(done)
    # a length is written in mm where that keeps its last digit, else in m
    wordings = [[NUMBER.sub("#", text).replace('"# mm"', '"# m"') for text in texts] for texts in (now, shown)]
    assert wordings[0] == wordings[1]
    designed = next((i for i, text in enumerate(shown) if text.startswith("engagement: asked")), len(shown))
    # where the search ends among designs of equal merit may depend on the machine, all before it does not
    for before, after in zip(shown[:designed], now[:designed], strict=True):
        for a, b in zip(NUMBER.findall(after), NUMBER.findall(before), strict=True):
            last = 10.0 ** -len(b.partition(".")[2])
            assert float(a) == pytest.approx(float(b), abs=1.01 * last)
    asked = re.findall(r"asked (>=|<=) ([\d.]+).*reached (\S+)", "".join(now[designed:]))
    assert len(asked) == (4 if chapter == "tutorial_limb" else 0)
    for sense, least, reached in asked:
        assert float(reached) >= float(least) if sense == ">=" else float(reached) <= float(least)
    pictures = [c for c in done.cells if any("image/png" in o.get("data", {}) for o in c.get("outputs", []))]
    assert len(pictures) == PICTURES[chapter]


def test_the_tutorial_tells_no_place_of_this_machine():
    text = "".join(notebook(chapter).read_text() for chapter in PICTURES)
    for place in (ROOT, Path.home(), Path(sys.prefix)):
        assert len(place.parts) == 1 or str(place) not in text
    assert '"output_type": "error"' not in text
    assert '"name": "stderr"' not in text
