"""Imports of optional packages, with a message that names the extra to install."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from squama.errors import InputError, Problem
from squama.interrupt import undivided

_PACKAGES = {"netgen": "netgen-mesher"}
_EXTRAS = {"build123d": "step", **dict.fromkeys(("lxml", "manifold3d", "networkx", "trimesh"), "export")}
_EXTRAS |= {"zarr": "sweep", "portalocker": "sweep", "distributed": "sweep", "emcee": "fit"}
_EXTRAS |= {"openpyxl": "xlsx"}
_WORDS = {
    "fe": "finite elements need {}; install them with",
    "export": "solids need {}; install it with",
    "step": "STEP files need {}; install it with",
    "sweep": "a sweep needs {}; install it with",
    "fit": "posterior samples need {}, which is not installed; install it with",
    "xlsx": "workbooks need {}; install it with",
    "distributed": "dask needs dask.{}; install it with",
}


def need(module: str) -> ModuleType:
    """Import and return a module of an optional extra; raise an InputError with the pip command if it is missing."""
    try:
        with undivided():
            return import_module(module)
    except ImportError:
        top = module.split(".", maxsplit=1)[0]
        extra = _EXTRAS.get(top, "fe")
        words = _WORDS[top if top in _WORDS else extra].format(_PACKAGES.get(top, top))
        raise InputError(Problem(reason=f"{words}: pip install 'squama[{extra}]'")) from None
