"""The view as one HTML file that opens without a server, with the scripts and NiceGUI's three.js inside."""

from __future__ import annotations

import base64
import json
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from squama.errors import refuse
from squama.model.outcome import SENTENCES
from squama.plot.palette import SCENE, variables
from squama.scene.motion import Motion, State, shapes

LIBRARY = Path("elements", "scene", "dist")
"""Folder of the three.js module inside NiceGUI."""
SAMPLES, OF_EACH = 240, 80
"""Number of states in the file, and that where each scale has its own."""


def find() -> Path:
    """Return the path of three.js as a module.

    Raises InputError where NiceGUI is not installed or lacks the file.
    """
    spec = find_spec("nicegui")
    places = spec.submodule_search_locations if spec is not None else None
    path = Path(next(iter(places))) / LIBRARY / "index.js" if places else None
    if path is None or not path.is_file():
        reason = "the view in a browser needs NiceGUI 3.16 or newer"
        refuse("", "", reason, "install it with: pip install 'squama[web]'")
    return path


def page(motion: Motion, load: float, name: str = "") -> str:
    """Return the HTML of a motion, which first shows a load angle per pitch (rad) and loads nothing from elsewhere.

    ``name`` of the beam.

    Raises InputError where three.js is not installed.
    """
    # a module in a data address has no folder, so its imports are named in the import map
    imports = {"nicegui-scene": _data(find().read_bytes())}
    for script in ("geometry.js", "scene.js", "standalone.js"):
        imports[f"squama/{script}"] = _data(_own(script).replace('from "./', 'from "squama/').encode())
    setting = motion.setting
    states = [
        {**_told(s, setting.mu), "words": motion.words(s)} for s in motion.samples(OF_EACH if motion.each else SAMPLES)
    ]
    data = {
        "design": _design(motion),
        "states": states,
        "first": min(range(len(states)), key=lambda i: abs(states[i]["load"] - load)),
        "end": str(motion.end),
        "sentence": SENTENCES[motion.end],
        "palette": SCENE,
        "model": motion.title(name),
        "angle": motion.verb,
    }
    # "<" inside a script would end it early
    return _own("standalone.html").format(
        imports=json.dumps({"imports": imports}),
        data=json.dumps(data).replace("<", "\\u003c"),
        light=variables("light"),
        dark=variables("dark"),
        title=escape(f"{name or setting.beam.extent}, mu = {setting.mu:g}, {motion.model}"),
    )


def drawn(motion: Motion, state: State) -> dict[str, dict[str, object]]:
    """Return what the script draws: the design and a state of a motion, with the other face's scales."""
    return {"design": _design(motion), "state": _told(state, motion.setting.mu)}


def _design(motion: Motion) -> dict[str, object]:
    """Return the design of the scaled face, and within it that of the other one."""
    design, *others = (design for design, _ in shapes(motion))
    return {**design, "other": next(iter(others), None)}


def _told(state: State, mu: float) -> dict[str, Any]:
    """Return a state, and within it those of the other face's scales and of single scales, for the page."""
    other, each = _told(state.other, mu) if state.other else None, [_told(one, mu) for one in state.each or []]
    if each:
        each = json.loads(json.dumps(each), parse_float=lambda text: float(f"{float(text):.5g}"))
    return {**state._asdict(), "mu": mu, "other": other, "each": each or None}


def _own(name: str) -> str:
    return files("squama.scene").joinpath("js", name).read_text(encoding="utf-8")


def _data(content: bytes) -> str:
    return f"data:text/javascript;base64,{base64.b64encode(content).decode()}"
