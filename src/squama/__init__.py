"""Mechanics of biomimetic scale-covered beams: twisting and bending with Coulomb friction.

The public names, in the order in which data flows; each is imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from inspect import isfunction
from typing import TYPE_CHECKING

from squama.errors import telling

if TYPE_CHECKING:
    from squama import plot as plot
    from squama._version import __version__ as __version__
    from squama.arrays.combined_states import Combined as Combined
    from squama.arrays.combined_states import Held as Held
    from squama.arrays.combined_states import combined as combined
    from squama.arrays.combined_states import held as held
    from squama.arrays.compliant_beams import Response as Response
    from squama.arrays.compliant_beams import response as response
    from squama.arrays.derivatives import Gradient as Gradient
    from squama.arrays.derivatives import gradient as gradient
    from squama.arrays.edge_contacts import Contact as Contact
    from squama.arrays.edge_contacts import Ends as Ends
    from squama.arrays.edge_contacts import Forces as Forces
    from squama.arrays.edge_contacts import contact as contact
    from squama.arrays.edge_contacts import ends as ends
    from squama.arrays.edge_contacts import forces as forces
    from squama.batch import Solved as Solved
    from squama.batch import solve as solve
    from squama.beam.design import Beam as Beam
    from squama.beam.design import Friction as Friction
    from squama.beam.design import Joint as Joint
    from squama.beam.design import Scale as Scale
    from squama.beam.design import Substrate as Substrate
    from squama.curves.doors import bend as bend
    from squama.curves.doors import twist as twist
    from squama.curves.finite_rows import row as row
    from squama.curves.histories import cycle as cycle
    from squama.curves.polygons import bend_twist as bend_twist
    from squama.curves.polygons import bend_twist_map as bend_twist_map
    from squama.dynamics.doors import shake as shake
    from squama.dynamics.doors import vibrate as vibrate
    from squama.dynamics.ratios import FreeVibration as FreeVibration
    from squama.dynamics.ratios import free_vibration as free_vibration
    from squama.errors import InputError as InputError
    from squama.errors import ResultWarning as ResultWarning
    from squama.errors import SquamaError as SquamaError
    from squama.errors import SquamaWarning as SquamaWarning
    from squama.errors import TableWarning as TableWarning
    from squama.errors import ValidityWarning as ValidityWarning
    from squama.fabrication.exporting import Export as Export
    from squama.fabrication.exporting import export as export
    from squama.fe.runs import cell as cell
    from squama.fe.stiffness import joint as joint
    from squama.identify.decay_fit import DecayFit as DecayFit
    from squama.identify.decay_fit import fit_decay as fit_decay
    from squama.identify.expected import Plan as Plan
    from squama.identify.fitting import fit as fit
    from squama.identify.planning import plan as plan
    from squama.identify.result import Fit as Fit
    from squama.inverse.designing import design as design
    from squama.inverse.designing import inverse_design as inverse_design
    from squama.inverse.front import pareto as pareto
    from squama.io.datasets import read as read
    from squama.io.datasets import save as save
    from squama.io.measured import read_measured as read_measured
    from squama.model.outcome import End as End
    from squama.part.definition import Part as Part
    from squama.part.door import load as load
    from squama.scene.part_motion import view_part as view_part
    from squama.scene.picture import view as view
    from squama.sections.table import LawTable as LawTable
    from squama.sections.table import law_table as law_table
    from squama.sections.trial import Law as Law
    from squama.sections.trial import law as law
    from squama.study.store import open_sweep as open_sweep
    from squama.study.sweeping import sweep as sweep
    from squama.study.tolerances.monte_carlo import uncertainty as uncertainty
    from squama.study.verification import verify as verify
    from squama.symbols import SYMBOLS as SYMBOLS

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
    "_version": "__version__",
    "errors": "InputError ResultWarning SquamaError SquamaWarning TableWarning ValidityWarning",
}
_DATASETS = {"curves", "dynamics", "fe", "identify", "inverse", "io", "part", "study"}
"""Rooms whose functions return datasets with the accessor ``.squama``."""
_TELLING = (_DATASETS - {"io"}) | {"sections"}
"""Rooms whose functions warn of each line of their result's ``warnings``. ``io`` is left out: a file that is read was
warned of when it was computed.
"""
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = list(_HOME)


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
