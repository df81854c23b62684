"""Packages that only the solids need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from squama.errors import InputError

_EXTRAS = {"build123d": "step"}


def need(module: str) -> Any:
    """Import a module that comes with an extra of the package.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        package = module.split(".", maxsplit=1)[0]
        extra = _EXTRAS.get(package, "export")
        what = "STEP files need" if extra == "step" else "solids need"
        message = f"{what} {package}; install it with: pip install 'squama[{extra}]'"
        raise InputError(message) from None
