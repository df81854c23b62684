"""Figures of results, ready to print, and their panels for axes of your own. Nothing is computed here.

Figures are made without pyplot, so they leave no state behind and need no display. matplotlib is loaded on first use of
a name.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from squama.plot.cycle import cycle_figure, energies, loops
    from squama.plot.elements import compare_figure, deformed_figure, elements_figure
    from squama.plot.finite import (
        finite_figure,
        inclinations,
        load_curve,
        part_animation,
        part_figure,
        row_figure,
        shape,
    )
    from squama.plot.fit import corner_figure, fit_figure, fitted, prediction_figure, residuals
    from squama.plot.inverse import front_figure, inverse_figure, tradeoff
    from squama.plot.maps import lock_lines_figure, red_figure, regime_figure
    from squama.plot.plan import expected_errors, plan_figure
    from squama.plot.plane import path_figure, path_loads, plane_contacts, plane_figure, plane_load, plane_path
    from squama.plot.projection import solids_figure
    from squama.plot.response import curve, line, response_figure
    from squama.plot.style import save_figure
    from squama.plot.sweep import map_figure, map_slice
    from squama.plot.uncertainty import cumulative, histogram, sobol, uncertainty_figure
    from squama.plot.vibration import damping, decay_figure, phase_plane, record, shaken_figure, vibration_figure

_NAMES = {
    "elements": "compare_figure deformed_figure elements_figure",
    "fit": "corner_figure fit_figure fitted prediction_figure residuals",
    "cycle": "cycle_figure energies loops",
    "finite": "finite_figure inclinations load_curve part_animation part_figure row_figure shape",
    "plan": "expected_errors plan_figure",
    "plane": "path_figure path_loads plane_contacts plane_figure plane_load plane_path",
    "inverse": "front_figure inverse_figure tradeoff",
    "sweep": "map_figure map_slice",
    "maps": "lock_lines_figure red_figure regime_figure",
    "response": "curve line response_figure",
    "style": "save_figure",
    "projection": "solids_figure",
    "uncertainty": "cumulative histogram sobol uncertainty_figure",
    "vibration": "damping decay_figure phase_plane record shaken_figure vibration_figure",
}
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        message = f"module 'squama.plot' has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(f"squama.plot.{_HOME[name]}"), name)
