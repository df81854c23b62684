"""Mechanics of biomimetic scale-covered beams: twisting and bending with Coulomb friction.

The public names, in the order in which data flows; each is imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from inspect import isfunction
from typing import TYPE_CHECKING

from squama._version import __version__
from squama.errors import (
    InputError,
    ResultWarning,
    SquamaError,
    SquamaWarning,
    TableWarning,
    ValidityWarning,
    telling,
)

if TYPE_CHECKING:
    from squama import plot as plot
    from squama.arrays.combined_states import Combined, Held, combined, held
    from squama.arrays.compliant_beams import Response, response
    from squama.arrays.derivatives import Gradient, gradient
    from squama.arrays.edge_contacts import Contact, Ends, Forces, contact, ends, forces
    from squama.batch import Solved, solve
    from squama.beam.design import Beam, Friction, Joint, Scale, Substrate
    from squama.curves.doors import bend, twist
    from squama.curves.finite_rows import row
    from squama.curves.histories import cycle
    from squama.curves.polygons import bend_twist, bend_twist_map
    from squama.dynamics.doors import shake, vibrate
    from squama.dynamics.ratios import FreeVibration, free_vibration
    from squama.fabrication.exporting import Export, export
    from squama.fe.runs import cell
    from squama.fe.stiffness import joint
    from squama.identify.decay_fit import DecayFit, fit_decay
    from squama.identify.expected import Plan
    from squama.identify.fitting import fit
    from squama.identify.planning import plan
    from squama.identify.result import Fit
    from squama.inverse.designing import design, inverse_design
    from squama.inverse.front import pareto
    from squama.io.datasets import read, save
    from squama.io.measured import read_measured
    from squama.model.outcome import End
    from squama.part.definition import Part
    from squama.part.door import load
    from squama.scene.part_motion import view_part
    from squama.scene.picture import view
    from squama.sections.table import LawTable, law_table
    from squama.sections.trial import Law, law
    from squama.study.store import open_sweep
    from squama.study.sweeping import sweep
    from squama.study.tolerances.monte_carlo import uncertainty
    from squama.study.verification import verify
    from squama.symbols import SYMBOLS

_NAMES = {
    "beam.design": "Scale Substrate Joint Friction Beam",
    "arrays.edge_contacts": "contact Contact forces Forces ends Ends",
    "arrays.compliant_beams": "response Response",
    "arrays.combined_states": "combined Combined held Held",
    "batch": "solve Solved",
    "arrays.derivatives": "gradient Gradient",
    "model.outcome": "End",
    "curves.doors": "twist bend",
    "curves.finite_rows": "row",
    "curves.histories": "cycle",
    "curves.polygons": "bend_twist bend_twist_map",
    "dynamics.doors": "vibrate shake",
    "dynamics.ratios": "free_vibration FreeVibration",
    "part.definition": "Part",
    "part.door": "load",
    "sections.trial": "law Law",
    "sections.table": "law_table LawTable",
    "fe.runs": "cell",
    "fe.stiffness": "joint",
    "study.verification": "verify",
    "inverse.designing": "inverse_design design",
    "inverse.front": "pareto",
    "identify.decay_fit": "fit_decay DecayFit",
    "identify.expected": "Plan",
    "identify.fitting": "fit",
    "identify.planning": "plan",
    "identify.result": "Fit",
    "study.sweeping": "sweep",
    "study.store": "open_sweep",
    "study.tolerances.monte_carlo": "uncertainty",
    "scene.part_motion": "view_part",
    "scene.picture": "view",
    "fabrication.exporting": "export Export",
    "io.datasets": "save read",
    "io.measured": "read_measured",
    "symbols": "SYMBOLS",
}
_DATASETS = {"curves", "dynamics", "fe", "identify", "inverse", "io", "part", "study"}
"""Rooms whose functions return datasets with the accessor ``.squama``."""
_TELLING = (_DATASETS - {"io"}) | {"sections"}
"""Rooms whose functions warn of each line of their result's ``warnings``. ``io`` is left out: a file that is read was
warned of when it was computed.
"""
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}

__all__ = [
    "SYMBOLS",
    "Beam",
    "Combined",
    "Contact",
    "DecayFit",
    "End",
    "Ends",
    "Export",
    "Fit",
    "Forces",
    "FreeVibration",
    "Friction",
    "Gradient",
    "Held",
    "InputError",
    "Joint",
    "Law",
    "LawTable",
    "Part",
    "Plan",
    "Response",
    "ResultWarning",
    "Scale",
    "Solved",
    "SquamaError",
    "SquamaWarning",
    "Substrate",
    "TableWarning",
    "ValidityWarning",
    "__version__",
    "bend",
    "bend_twist",
    "bend_twist_map",
    "cell",
    "combined",
    "contact",
    "cycle",
    "design",
    "ends",
    "export",
    "fit",
    "fit_decay",
    "forces",
    "free_vibration",
    "gradient",
    "held",
    "inverse_design",
    "joint",
    "law",
    "law_table",
    "load",
    "open_sweep",
    "pareto",
    "plan",
    "read",
    "read_measured",
    "response",
    "row",
    "save",
    "shake",
    "solve",
    "sweep",
    "twist",
    "uncertainty",
    "verify",
    "vibrate",
    "view",
    "view_part",
]


def __getattr__(name: str) -> object:
    if name == "plot":
        return import_module("squama.plot")
    if name not in _HOME:
        message = f"module 'squama' has no attribute {name!r}"
        raise AttributeError(message)
    value = getattr(import_module(f"squama.{_HOME[name]}"), name)
    room = _HOME[name].partition(".")[0]
    if room in _TELLING and isfunction(value) and name != "open_sweep":
        value = telling(value)
    globals()[name] = value
    if room in _DATASETS:
        import_module("squama.plot.accessor")
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
