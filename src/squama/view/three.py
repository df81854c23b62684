"""Where three.js is: the copy that NiceGUI brings (extra ``web``), so that nothing is fetched from elsewhere."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from squama.errors import InputError

LIBRARY = Path("elements", "scene", "dist")
"""Folder of the module inside NiceGUI."""


def find() -> Path:
    """Return the file with three.js as a module.

    Raises
    ------
    InputError
        NiceGUI is not installed, or it has no such file.
    """
    spec = find_spec("nicegui")
    places = spec.submodule_search_locations if spec is not None else None
    path = Path(next(iter(places))) / LIBRARY / "index.js" if places else None
    if path is None or not path.is_file():
        message = "the view in a browser needs NiceGUI 3.16 or newer; install it with: pip install 'squama[web]'"
        raise InputError(message)
    return path
