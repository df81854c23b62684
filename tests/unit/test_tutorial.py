"""The tutorial runs from beginning to end and says what it says in the docs."""

import copy
import re
import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOK = ROOT / "docs" / "tutorial.ipynb"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def printed(notebook) -> list[str]:
    """What each code cell has printed."""
    cells = [c for c in notebook.cells if c.cell_type == "code"]
    return ["".join(o.text for o in c.outputs if o.output_type == "stream" and o.name == "stdout") for c in cells]


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

    return nbformat.read(NOTEBOOK, as_version=4), do


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_the_tutorial_runs_and_prints_what_it_shows(run):
    notebook, do = run
    done = do(notebook)
    shown, now = printed(notebook), printed(done)
    # a length is written in mm where that keeps its last digit, else in m
    wordings = [[NUMBER.sub("#", text).replace('"# mm"', '"# m"') for text in texts] for texts in (now, shown)]
    assert wordings[0] == wordings[1]
    designed = next(i for i, text in enumerate(shown) if text.startswith("engagement: asked"))
    # where the search ends among designs of equal merit may depend on the machine, all before it does not
    for before, after in zip(shown[:designed], now[:designed], strict=True):
        for a, b in zip(NUMBER.findall(after), NUMBER.findall(before), strict=True):
            last = 10.0 ** -len(b.partition(".")[2])
            assert float(a) == pytest.approx(float(b), abs=1.01 * last)
    asked = re.findall(r"asked (>=|<=) (\S+) .*reached (\S+)", now[designed])
    assert len(asked) == 4
    for sense, least, reached in asked:
        assert float(reached) >= float(least) if sense == ">=" else float(reached) <= float(least)
    pictures = [c for c in done.cells if any("image/png" in o.get("data", {}) for o in c.get("outputs", []))]
    assert len(pictures) == 2


def test_the_tutorial_tells_no_place_of_this_machine():
    text = NOTEBOOK.read_text()
    for place in (ROOT, Path.home(), Path(sys.prefix)):
        assert len(place.parts) == 1 or str(place) not in text
    assert '"output_type": "error"' not in text
    assert '"name": "stderr"' not in text
