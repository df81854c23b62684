"""Files that the page hands out: the beam, its curve, the stand-alone view."""

from __future__ import annotations

import tempfile
from pathlib import Path

from squama import checks, store
from squama.response import bent, twisted
from squama.view import standalone
from squama.web import live
from squama.web.state import State

KINDS = {"toml": "beam.toml", "csv": "curve.csv", "html": "beam.html"}
"""Names of the files by their kind."""


def make(state: State, kind: str) -> tuple[str, bytes]:
    """Return name and content of a file.

    Raises
    ------
    InputError
        No such kind.
    """
    checks.one_of("kind", kind, tuple(KINDS))
    return KINDS[kind], {"toml": _toml, "csv": _csv, "html": _html}[kind](state).encode()


def _toml(state: State) -> str:
    return state.beam.to_toml()


def _csv(state: State) -> str:
    """Return the curve as the commands write it."""
    if state.load == "twisting":
        answer = twisted(state.beam, mu=state.mu, law=state.law, margin=state.margin, sense=state.sense)
    else:
        answer = bent(state.beam, mu=state.mu, margin=state.margin)
    with tempfile.TemporaryDirectory() as folder:
        return store.save(answer.dataset(), Path(folder) / "curve.csv").read_text(encoding="utf-8")


def _html(state: State) -> str:
    return standalone.page(live.motion(state.setting), state.twist)
