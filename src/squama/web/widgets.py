"""Elements of the page: parameter fields, plots and the three-dimensional view.

ECharts and three.js are those of NiceGUI.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import nicegui
from nicegui import ui
from nicegui.events import GenericEventArguments

from squama import scene
from squama.people import per_pitch
from squama.plot.palette import SCENE
from squama.scene.standalone import LIBRARY
from squama.web.fields import FIELDS, Field

SCRIPTS = Path(scene.__file__).parent / "js"
THREE = Path(nicegui.__file__).parent / LIBRARY
ECHARTS = Path(nicegui.__file__).parent / "elements" / "echart" / "dist"


def received(args: object, **kinds: type) -> dict[str, Any]:
    """Return the data of an event of the page if they have these names and types, else an empty dict."""
    found = args if isinstance(args, dict) else {}
    return found if all(type(found.get(name)) is kind for name, kind in kinds.items()) else {}


class BeamView(ui.element, component="view.js", esm={"nicegui-scene": str(THREE), "squama-view": str(SCRIPTS)}):
    """The beam in three dimensions; the browser gets design and state, never vertices."""

    def __init__(
        self, shown: Mapping[str, object], on_dark: Callable[[bool], None], on_rest: Callable[[], None]
    ) -> None:
        super().__init__()
        self._props.update({"arrows": True, "palette": SCENE, **shown})
        self.on("dark", lambda event: on_dark(bool(event.args)))
        self.on("rest", on_rest)


class Chart(ui.element, component="chart.js", esm={"nicegui-echart": str(ECHARTS)}):
    """A plot with ECharts options, as "svg" or on a "canvas"; a click raises the event "picked"."""

    def __init__(self, options: Mapping[str, object], renderer: str) -> None:
        super().__init__()
        self._props.update({"options": options, "renderer": renderer})


def _parts(field: Field) -> dict[str, object]:
    """Return the properties of a field for the browser."""
    parts = ("label", "symbol", "unit", "allowed", "low", "high", "log", "whole", "optional")
    return {part: getattr(field, part) for part in parts}


class NumberField(ui.element, component="field.js"):
    """A parameter: slider, number, unit, range, and the message for an invalid entry."""

    def __init__(self, name: str, on_change: Callable[[str, str], None]) -> None:
        super().__init__()
        self.name = name
        self._props.update({**_parts(FIELDS[name]), "name": name, "error": "", "answered": 0})

        def changed(event: GenericEventArguments) -> None:
            if sent := received(event.args, number=int, text=str):
                self._props["answered"] = sent["number"]
                on_change(name, sent["text"][:200])
                self.update()

        self.on("change", changed)

    def show(self, value: float | None, f: Field, *, hint: float | None = None) -> None:
        """Show a value (SI) of a field; ``hint``: the value (SI) of an empty field."""
        new: dict[str, object] = {**_parts(f), "shown": f.shown(value), "error": ""}
        if f.unit == "deg" and f.turn and value is not None:
            new["allowed"] = f"{per_pitch(value)} ({f.slider})"
        if hint is not None:
            new["hint"] = f"{hint / f.factor:.4g} by its law"
        at = value if value is not None else hint
        shown = f.low if at is None else min(max(at / f.factor, f.low), f.high)
        low, place, top = (math.log(v) if f.log else v for v in (f.low, shown, f.high))
        put(self, **new, at=(place - low) / (top - low) if top > low else 0.0)

    def explain(self, message: str) -> None:
        """Show the message for an invalid entry."""
        self._props["error"] = message


class FileButton(ui.element, component="open.js"):
    """A button that opens a file of at most ``largest`` bytes; ``opened`` gets its name and its bytes."""

    def __init__(
        self, label: str, accept: str, largest: int, opened: Callable[[str, bytes], None], tell: Callable[[str], None]
    ) -> None:
        super().__init__()
        title = f"Open a file of at most {largest // 1024} KiB: {accept}"
        self._props.update({"label": label, "title": title, "accept": accept, "largest": largest})

        def read(event: GenericEventArguments) -> None:
            sent = received(event.args, name=str, data=str)
            try:
                content = base64.b64decode(sent["data"] if sent else "?", validate=True)
            except ValueError:
                tell("the file did not arrive whole: open it again")
            else:
                opened(sent["name"][:200], content)

        self.on("opened", read)
        self.on("refused", lambda _: tell(f"the file is larger than {largest // 1024} KiB: thin it out"))


class Choice(ui.element):
    """A native list of choices, usable with keyboards and screen readers."""

    def __init__(self, label: str, options: dict[str, str], value: str, on_change: Callable[[str], None]) -> None:
        super().__init__("label")
        self.classes("choice")
        with self:
            ui.element("span").props["textContent"] = label
            self.list = ui.element("select")
            self.list.props["aria-label"] = label
        self.list.on("change", lambda event: on_change(str(event.args)), js_handler="(e) => emit(e.target.value)")
        self.set(options, value)

    def set(self, options: dict[str, str], value: str) -> None:
        """Show these options, and select the value."""
        if not anew(self.list, (options, value)):
            return
        with self.list:
            for key, words in options.items():
                option = ui.element("option")
                option.props.update({"value": key, "textContent": words})
        self.list.props["value"] = value
        self.list.update()


class Entry(ui.element):
    """A native field for a line of text, which keeps the typed text while the page is redrawn around it."""

    def __init__(
        self, label: str, value: str, on_change: Callable[[str], None], *, most: int, mark: str, hint: str = "",
    ) -> None:  # fmt: skip
        super().__init__("label")
        self.classes("choice")

        def changed(event: GenericEventArguments) -> None:
            on_change(str(event.args)[:most])

        with self:
            text("span", label)
            self.field = ui.element("input").on("change", changed, js_handler="(e) => emit(e.target.value)")
        # an attribute, not a property, which would overwrite the typed text at each drawing
        self.field.props.update({"type": "text", "^value": value, "maxlength": most, "placeholder": hint})
        self.field.props["data-do"] = mark

    def empty(self) -> None:
        """Clear the field."""
        self.field.client.run_javascript(f"getHtmlElement({self.field.id}).value = ''")


def button(label: str, act: Callable[[], object], title: str = "", mark: str = "") -> ui.element:
    """Return a native button."""
    element = ui.element("button").on("click", act)
    element.props.update({"type": "button", "textContent": label, "title": title or label})
    if mark:
        element.props["data-do"] = mark
    return element


def text(tag: str, words: str = "", classes: str = "") -> ui.element:
    """Return an element with plain text."""
    element = ui.element(tag).classes(classes)
    write(element, words)
    return element


def write(element: ui.element, words: str) -> None:
    """Set the text of an element."""
    put(element, textContent=words)


def anew(place: ui.element, wanted: object) -> bool:
    """Empty an element whose contents differ from ``wanted``; return whether it must be filled."""
    if getattr(place, "wanted", None) == wanted:
        return False
    place.wanted = wanted  # type: ignore[attr-defined]
    place.clear()
    return True


def put(element: ui.element, **props: object) -> None:
    """Set properties of an element; unchanged ones are not sent to the browser again."""
    if any(element.props.get(key) != value for key, value in props.items()):
        element.props.update(props)
        element.update()
