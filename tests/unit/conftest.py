"""What several files of tests share."""

import pytest


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fits without the one by the other model, which takes several times as long as the one that is looked at."""
    monkeypatch.setattr("squama.identify.fitting._rival", lambda *_: None)


@pytest.fixture
def unasked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Designs as the search finds them, of which no other model is asked: a row, or elements, take longer."""
    monkeypatch.setattr("squama.inverse.beside.beside", lambda *_, **__: ())
