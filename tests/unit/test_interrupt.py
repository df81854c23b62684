"""Ctrl-C while a package is imported: compiled packages hide it behind errors of their own; it counts nevertheless."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from squama import needs
from squama.cli import main
from squama.errors import InputError
from squama.interrupt import until_interrupted

HIDES = """
import signal
for _ in range({times}):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise {error}("initialization failed")
"""


@pytest.fixture(autouse=True)
def heeded() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt, also where the tests were started in the background, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A place for a package that is interrupted as it is imported."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "interrupted", raising=False)
    return tmp_path / "interrupted.py"


@pytest.mark.parametrize("times", [1, 2])
@pytest.mark.parametrize("error", ["ImportError", "UnboundLocalError"])
def test_ctrl_c_during_an_import_is_no_missing_package(package: Path, times: int, error: str) -> None:
    package.write_text(HIDES.format(times=times, error=error), encoding="utf-8")
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        needs.need("interrupted")
    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_during_an_import_is_a_wish_to_work_that_ends_at_a_safe_place(package: Path) -> None:
    package.write_text(HIDES.format(times=1, error="ImportError"), encoding="utf-8")
    with until_interrupted() as stopped:
        assert needs.need("interrupted").__name__ == "interrupted"
        assert stopped()


def test_a_package_that_is_missing_is_asked_for(package: Path) -> None:
    with pytest.raises(InputError, match="need interrupted; install"):
        needs.need("interrupted")


def test_a_command_that_is_interrupted_as_it_imports_ends_with_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def hides(_: str) -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError from None

    monkeypatch.setattr(needs, "import_module", hides)
    example = Path(__file__).parents[2] / "examples" / "stiff_skin.toml"
    assert main(["joint", str(example), "--levels", "1", "--fresh"]) == 130
    assert "install" not in capsys.readouterr().err
