"""Figures of results, ready to print: labelled data in, a matplotlib figure out. Nothing is computed here.

Figures are made without pyplot, so they leave no state behind and need no display. matplotlib is loaded when one
of the names is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from squama.plot.cycle import cycle_figure
    from squama.plot.deformed import deformed_figure
    from squama.plot.elements import compare_figure, elements_figure
    from squama.plot.fit import corner_figure, fit_figure
    from squama.plot.front import front_figure
    from squama.plot.inverse import inverse_figure
    from squama.plot.maps import red_figure
    from squama.plot.regimes import lock_lines_figure, regime_figure
    from squama.plot.response import response_figure
    from squama.plot.row import row_figure
    from squama.plot.solids import solids_figure
    from squama.plot.style import save_figure
    from squama.plot.sweep import map_figure
    from squama.plot.uncertainty import uncertainty_figure

_HOME = {
    "response_figure": "response",
    "row_figure": "row",
    "cycle_figure": "cycle",
    "fit_figure": "fit",
    "corner_figure": "fit",
    "front_figure": "front",
    "inverse_figure": "inverse",
    "regime_figure": "regimes",
    "lock_lines_figure": "regimes",
    "red_figure": "maps",
    "map_figure": "sweep",
    "elements_figure": "elements",
    "compare_figure": "elements",
    "deformed_figure": "deformed",
    "solids_figure": "solids",
    "uncertainty_figure": "uncertainty",
    "save_figure": "style",
}

__all__ = [
    "compare_figure",
    "corner_figure",
    "cycle_figure",
    "deformed_figure",
    "elements_figure",
    "fit_figure",
    "front_figure",
    "inverse_figure",
    "lock_lines_figure",
    "map_figure",
    "red_figure",
    "regime_figure",
    "response_figure",
    "row_figure",
    "save_figure",
    "solids_figure",
    "uncertainty_figure",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        message = f"module 'squama.plot' has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(f"squama.plot.{_HOME[name]}"), name)
