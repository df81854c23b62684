"""The view as one HTML file that opens without a server: three.js and the scripts of the view are inside."""

from __future__ import annotations

import base64
import json
from html import escape
from importlib.resources import files
from typing import Any

from squama.view import three
from squama.view.motion import Motion, shape

SAMPLES = 240
"""States inside the file; between them the slider has nothing to show."""


def page(motion: Motion, load: float) -> str:
    """Return the text of the file.

    Parameters
    ----------
    motion : Motion
        The beam's motion; its states are sampled from no load to the last.
    load : float
        Load angle per pitch (rad) that is shown first.

    Returns
    -------
    str
        HTML. The content of the imports is inside as data, so nothing is fetched.

    Raises
    ------
    InputError
        three.js is not installed.
    """
    library = three.find().read_bytes()
    scripts = {name: files("squama.view").joinpath("js", f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS}
    # inside a data address a module has no folder: its neighbours are named in the import map
    for name, text in scripts.items():
        scripts[name] = text.replace('from "./', 'from "squama/')
    imports = {"nicegui-scene": _data(library)}
    imports |= {f"squama/{name}.js": _data(text.encode()) for name, text in scripts.items()}
    setting = motion.setting
    states = [{**s._asdict(), "mu": setting.mu} for s in motion.samples(SAMPLES)]
    for one in states:
        one["slip"] = list(one["slip"])
    data: dict[str, Any] = {
        "design": shape(setting, motion.path.neighbour),
        "states": states,
        "first": min(range(len(states)), key=lambda i: abs(states[i]["load"] - load)),
        "end": str(motion.end),
        "sentence": motion.sentence,
        "angle": "twist" if motion.twisting else "bend",
    }
    # "<" inside a script would end it early
    return PAGE.format(
        imports=json.dumps({"imports": imports}),
        data=json.dumps(data).replace("<", "\\u003c"),
        title=escape(f"{setting.beam.scales} scales, mu = {setting.mu:g}: {motion.end}"),
    )


SCRIPTS = ("geometry", "scene", "standalone")


def _data(content: bytes) -> str:
    return f"data:text/javascript;base64,{base64.b64encode(content).decode()}"


PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
:root {{ color-scheme: light dark; --ink: #1d2125; --page: #f7f7f5; --soft: #59636e; }}
@media (prefers-color-scheme: dark) {{ :root {{ --ink: #e8eaed; --page: #16191d; --soft: #a9b3bd; }} }}
body {{ margin: 0; height: 100vh; display: flex; flex-direction: column; background: var(--page); color: var(--ink);
  font: 15px/1.4 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }}
#stage {{ flex: 1; min-height: 0; }}
canvas {{ display: block; width: 100%; height: 100%; }}
form {{ display: flex; flex-wrap: wrap; gap: 6px 14px; align-items: center; padding: 8px 14px; }}
input {{ flex: 1 1 240px; }}
p {{ margin: 0; padding: 0 14px 10px; color: var(--soft); }}
</style>
<script type="importmap">{imports}</script>
</head>
<body>
<div id="stage"><canvas tabindex="0" role="img"
  aria-label="{title}. Arrow keys turn, plus and minus zoom, Home resets."></canvas></div>
<form onsubmit="return false"><button type="button" id="play">Play</button><label for="load" id="name"></label>
<input type="range" id="load" min="0" step="1"><output id="now"></output>
<button type="button" id="reset">Reset view</button></form>
<p id="end"></p>
<script type="application/json" id="data">{data}</script>
<script type="module">import "squama/standalone.js";</script>
</body>
</html>
"""
