"""Packages that only the finite elements need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from squama.errors import InputError

_PACKAGES = {"netgen": "netgen-mesher"}


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
        package = _PACKAGES.get(module.split(".", maxsplit=1)[0], module)
        message = f"finite elements need {package}; install them with: pip install 'squama[fe]'"
        raise InputError(message) from None
