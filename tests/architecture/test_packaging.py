"""What would be published: sdist and wheel build and are sound, and everything tells the same version and needs."""

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml

import squama

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE = yaml.safe_load((ROOT / "packaging" / "recipe.yaml").read_text(encoding="utf-8"))
CONDA_NAMES = {"matplotlib": "matplotlib-base"}


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Path:
    """Build the sdist, and the wheel from it."""
    place = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(place), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return place


def test_both_are_sound(built: Path) -> None:
    names = {f"squama-{squama.__version__}.tar.gz", f"squama-{squama.__version__}-py3-none-any.whl"}
    assert {path.name for path in built.iterdir()} == names
    command = [sys.executable, "-m", "twine", "check", "--strict", *map(str, built.iterdir())]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert done.stdout.count("PASSED") == 2


def test_they_hold_what_belongs_to_them_and_no_more(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    inside = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in inside} == {"squama", f"squama-{squama.__version__}.dist-info"}
    tracked = subprocess.run(["git", "ls-files", "src/squama"], cwd=ROOT, capture_output=True, text=True, check=False)
    ours = {name.removeprefix("src/") for name in tracked.stdout.split()}
    if ours:
        assert {name for name in inside if name.startswith("squama/")} == ours
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        tops = {name.split("/")[1] for name in archive.getnames() if "/" in name}
    assert {"src", "tests", "docs", "examples", "constraints.txt", "Makefile", "LICENSE", "README.md"} <= tops
    assert not {".venv", "out", "dist"} & tops


def test_the_wheel_works_away_from_the_sources(built: Path, tmp_path: Path) -> None:
    (wheel,) = built.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(tmp_path / "installed")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "installed")}

    def run(*words: str) -> str:
        command = [sys.executable, "-m", "squama", *words]
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment)
        assert done.returncode == 0, done.stderr
        return done.stdout

    where = subprocess.run([sys.executable, "-c", "import squama; print(squama.__file__)"], cwd=tmp_path,
                           env=environment, capture_output=True, text=True, check=True)  # fmt: skip
    assert str(tmp_path) in where.stdout
    assert run("--version").strip() == squama.__version__
    run("new", "beam.toml")
    assert "free until" in run("twist", "beam.toml", "--joint", "hinge", "--ideal")


def test_the_recipe_needs_what_the_package_needs() -> None:
    assert RECIPE["context"]["version"] == squama.__version__
    run = dict(line.partition(" ")[::2] for line in RECIPE["requirements"]["run"])
    assert run.pop("python") == PROJECT["requires-python"]
    needed = [re.fullmatch(r"([\w-]+)(\S*)", line).groups() for line in PROJECT["dependencies"]]
    assert run == {CONDA_NAMES.get(name, name): bounds for name, bounds in needed}
    assert RECIPE["build"]["python"]["entry_points"] == [f"squama = {PROJECT['scripts']['squama']}"]
    assert RECIPE["about"]["summary"].replace(" - ", ": ") == PROJECT["description"]
    # it builds from the sdist, which lies where `python -m build` puts it
    source = RECIPE["source"]["path"].replace("${{ version }}", squama.__version__)
    assert (ROOT / "packaging" / source).resolve() == ROOT / "dist" / f"squama-{squama.__version__}.tar.gz"


def test_the_citation_has_what_archives_ask_for() -> None:
    """Zenodo takes its metadata from CITATION.cff where nothing else is given."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == squama.__version__
    assert cited["license"] == PROJECT["license"]
    assert cited["type"] == "software"
    assert [a["name"] for a in cited["authors"]] == [a["name"] for a in PROJECT["authors"]]
    assert set(cited["keywords"]) <= set(PROJECT["keywords"])
    assert cited["abstract"].strip()
    assert cited["title"].startswith("squama: ")


def test_the_forge_runs_the_two_commands_and_nothing_else() -> None:
    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8"))["jobs"]
    steps = [step["run"] for job in jobs.values() for step in job["steps"] if "run" in step]
    assert steps == ["make demo", "make test"]
