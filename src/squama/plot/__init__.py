"""Figures of results, ready to print, and their panels for axes of your own. Nothing is computed here.

Figures are made without pyplot, so they leave no state behind and need no display. matplotlib is loaded on first use of
a name.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from squama.plot.cycle import cycle_figure as cycle_figure
    from squama.plot.cycle import energies as energies
    from squama.plot.cycle import loops as loops
    from squama.plot.elements import compare_figure as compare_figure
    from squama.plot.elements import deformed_figure as deformed_figure
    from squama.plot.elements import elements_figure as elements_figure
    from squama.plot.finite import finite_figure as finite_figure
    from squama.plot.finite import inclinations as inclinations
    from squama.plot.finite import load_curve as load_curve
    from squama.plot.finite import part_animation as part_animation
    from squama.plot.finite import part_figure as part_figure
    from squama.plot.finite import row_figure as row_figure
    from squama.plot.finite import shape as shape
    from squama.plot.fit import corner_figure as corner_figure
    from squama.plot.fit import fit_figure as fit_figure
    from squama.plot.fit import fitted as fitted
    from squama.plot.fit import prediction_figure as prediction_figure
    from squama.plot.fit import residuals as residuals
    from squama.plot.inverse import front_figure as front_figure
    from squama.plot.inverse import inverse_figure as inverse_figure
    from squama.plot.inverse import tradeoff as tradeoff
    from squama.plot.maps import lock_lines_figure as lock_lines_figure
    from squama.plot.maps import red_figure as red_figure
    from squama.plot.maps import regime_figure as regime_figure
    from squama.plot.plan import expected_errors as expected_errors
    from squama.plot.plan import plan_figure as plan_figure
    from squama.plot.plane import path_figure as path_figure
    from squama.plot.plane import path_loads as path_loads
    from squama.plot.plane import plane_contacts as plane_contacts
    from squama.plot.plane import plane_figure as plane_figure
    from squama.plot.plane import plane_load as plane_load
    from squama.plot.plane import plane_path as plane_path
    from squama.plot.projection import solids_figure as solids_figure
    from squama.plot.response import curve as curve
    from squama.plot.response import line as line
    from squama.plot.response import response_figure as response_figure
    from squama.plot.style import save_figure as save_figure
    from squama.plot.sweep import map_figure as map_figure
    from squama.plot.sweep import map_slice as map_slice
    from squama.plot.uncertainty import cumulative as cumulative
    from squama.plot.uncertainty import histogram as histogram
    from squama.plot.uncertainty import sobol as sobol
    from squama.plot.uncertainty import uncertainty_figure as uncertainty_figure
    from squama.plot.vibration import damping as damping
    from squama.plot.vibration import decay_figure as decay_figure
    from squama.plot.vibration import phase_plane as phase_plane
    from squama.plot.vibration import record as record
    from squama.plot.vibration import shaken_figure as shaken_figure
    from squama.plot.vibration import vibration_figure as vibration_figure

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


def __getattr__(name: str) -> object:
    if name not in _HOME:
        message = f"module 'squama.plot' has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(f"squama.plot.{_HOME[name]}"), name)
