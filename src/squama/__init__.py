"""Mechanics of biomimetic scale-covered beams: twisting and bending with Coulomb friction.

The public names, in the order in which data flows; each is imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from squama._version import __version__
from squama.errors import InputError, SquamaError, ValidityWarning

if TYPE_CHECKING:
    from squama.api import Contact, Ends, Forces, contact, ends, forces
    from squama.cycles import cycle
    from squama.derivatives import Gradient, gradient
    from squama.design import Beam, Friction, Joint, Scale, Substrate
    from squama.engines import Solved, solve
    from squama.fabrication.facade import Export, export
    from squama.identify.facade import fit
    from squama.identify.result import Fit
    from squama.inverse.designs import inverse_design
    from squama.inverse.front import pareto
    from squama.model.outcome import End
    from squama.response import bend, twist
    from squama.rows import row
    from squama.store import read, save
    from squama.study.stored import open_sweep
    from squama.study.sweep import sweep
    from squama.study.uncertainty import uncertainty
    from squama.symbols import SYMBOLS

_HOME = {
    "Scale": "design",
    "Substrate": "design",
    "Joint": "design",
    "Friction": "design",
    "Beam": "design",
    "contact": "api",
    "Contact": "api",
    "forces": "api",
    "Forces": "api",
    "ends": "api",
    "Ends": "api",
    "solve": "engines",
    "Solved": "engines",
    "gradient": "derivatives",
    "Gradient": "derivatives",
    "End": "model.outcome",
    "twist": "response",
    "bend": "response",
    "row": "rows",
    "cycle": "cycles",
    "inverse_design": "inverse.designs",
    "pareto": "inverse.front",
    "fit": "identify.facade",
    "Fit": "identify.result",
    "sweep": "study.sweep",
    "open_sweep": "study.stored",
    "export": "fabrication.facade",
    "Export": "fabrication.facade",
    "uncertainty": "study.uncertainty",
    "save": "store",
    "read": "store",
    "SYMBOLS": "symbols",
}

__all__ = [
    "SYMBOLS",
    "Beam",
    "Contact",
    "End",
    "Ends",
    "Export",
    "Fit",
    "Forces",
    "Friction",
    "Gradient",
    "InputError",
    "Joint",
    "Scale",
    "Solved",
    "SquamaError",
    "Substrate",
    "ValidityWarning",
    "__version__",
    "bend",
    "contact",
    "cycle",
    "ends",
    "export",
    "fit",
    "forces",
    "gradient",
    "inverse_design",
    "open_sweep",
    "pareto",
    "read",
    "row",
    "save",
    "solve",
    "sweep",
    "twist",
    "uncertainty",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        message = f"module 'squama' has no attribute {name!r}"
        raise AttributeError(message)
    value = getattr(import_module(f"squama.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
