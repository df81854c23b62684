"""The pinned packages can be installed with the oldest Python that the package allows."""

import re
from importlib import metadata
from pathlib import Path

import pytest
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).parents[2]
OLDEST = "3.11.0"
PINS = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text().split())


def _installed(name: str) -> metadata.Distribution | None:
    try:
        return metadata.distribution(name)
    except metadata.PackageNotFoundError:
        return None


def test_the_oldest_python_is_the_one_that_is_promised() -> None:
    promised = re.search(r'^requires-python = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert promised is not None
    assert OLDEST in SpecifierSet(promised[1])
    assert "3.10.99" not in SpecifierSet(promised[1])


@pytest.mark.parametrize("name", PINS)
def test_a_pin_admits_the_oldest_python(name: str) -> None:
    package = _installed(name)
    if package is None or package.version != PINS[name]:
        pytest.skip("not installed here")
    assert OLDEST in SpecifierSet(package.metadata.get("Requires-Python") or ""), package.version


def test_nearly_all_pins_are_looked_at() -> None:
    found = {name for name in PINS if (package := _installed(name)) and package.version == PINS[name]}
    assert len(found) > 0.8 * len(PINS), sorted(set(PINS) - found)
