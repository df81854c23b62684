"""The list of planted errors fits the tree: nothing in it names a file, a test or a line that has gone."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
TESTS = ROOT / "tests"
PACKAGE = ROOT / "src" / "squama"


@pytest.fixture
def plant(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(TESTS / "mutants")
    import plant

    return plant


@pytest.fixture
def known(plant: ModuleType) -> ModuleType:
    import known

    return known


def test_the_tests_of_every_file_are_there(known: ModuleType) -> None:
    assert [file for file in known.TESTS if not (PACKAGE / file).is_file()] == []
    for test in dict.fromkeys(t for tests in known.TESTS.values() for t in tests):
        file, _, name = test.partition("::")
        text = (TESTS / file).read_text(encoding="utf-8")
        assert f"\ndef {name}(" in text if name else "\ndef test_" in text, test


def test_errors_by_hand_can_be_planted(plant: ModuleType, known: ModuleType) -> None:
    for file, old, new in known.BY_HAND:
        assert file in known.TESTS
        plant.by_hand(PACKAGE, file, old, new)


def test_what_is_no_error_can_be_planted(plant: ModuleType, known: ModuleType) -> None:
    from equivalent import EQUIVALENT

    found: dict[tuple[str, str], set[str]] = {}
    for m in (m for file in {file for file, _ in EQUIVALENT} for m in plant.mutants(PACKAGE, file)):
        found.setdefault((m.file, m.text), {"*"}).add(m.change)
    gone = {key: sorted(changes.keys() - found.get(key, set())) for key, changes in EQUIVALENT.items()}
    assert {key: changes for key, changes in gone.items() if changes} == {}
    assert {file for file, _ in EQUIVALENT} <= set(known.TESTS)
