"""The page: its parts, and what happens when something in them is changed."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from importlib.resources import files
from typing import Any

from nicegui import app, run, ui

from squama.errors import InputError
from squama.web import charts, download, link, live, map, panels  # noqa: A004 - the module is named after what it draws
from squama.web.elements import BeamView, button, text, write
from squama.web.state import State

WAIT = 0.3
"""Seconds without a change after which the map is computed anew."""
MOMENT = 0.04
"""Seconds by which the plots follow the view."""


class Explorer:
    """One open page: its state, and the elements that show it."""

    def __init__(self, state: State, notice: str = "") -> None:
        self.state, self.dark = state, False
        self.map_axes = ("mu", "alpha")
        self.later: asyncio.TimerHandle | None = None
        self.pending: asyncio.Task[None] | None = None
        self.map_key: map.Key | None = None
        # kept here: what is clicked may be gone before all is drawn
        self.client = ui.context.client
        ui.add_css(files("squama.web").joinpath("page.css").read_text(encoding="utf-8"))
        self.mode = ui.dark_mode(None)
        with ui.element("header"):
            text("h1", "squama explorer")
            self.presets = panels.presets(self)
            panels.tools(self)
        with ui.element("div").classes("explorer"):
            with ui.element("section").classes("stage").props('aria-label="Beam"'):
                self.view = BeamView(live.scene(state), self.darken)
                with ui.element("div").classes("over"):
                    button("Reset view", lambda: self.view.run_method("reset"), "Show the whole beam", "reset")
                    self.arrows = button("Hide forces", self.toggle_arrows, "Show or hide the arrows", "arrows")
                panels.legend()
            self.notice = text("p", "", "notice").props('role="alert"')
            self.outcome = panels.Outcome()
            self.controls = panels.Controls(self)
            with ui.element("section").classes("plots").props('aria-label="Plots"'):
                self.plots = {plot: self._chart(charts.line_options(state, plot, dark=False)) for plot in charts.PLOTS}
                with ui.element("div").classes("plot"):
                    self.map_choices = panels.map_choices(self)
                    self.map_ends = ui.element("ul").classes("legend ends")
                    with ui.element("div").classes("cells"):
                        self.map = ui.echart({"series": []})
                        self.marks = panels.marks(map.ROOM)
                    self.map.props["aria-label"] = "Regime map; a click takes the design under the pointer"
                    self.map.on("componentClick", self.clicked, ["value", "seriesId"])
            self.compared = panels.Compared(self)
        self.say(notice)
        self.draw()

    def _chart(self, options: dict[str, Any]) -> tuple[ui.echart, ui.element]:
        with ui.element("div").classes("plot"), ui.element("div").classes("cells"):
            chart = ui.echart(options, renderer="svg")
            chart.props["role"] = "img"
            return chart, panels.marks(charts.ROOM)

    # ---- what people do ------------------------------------------------------------------------------------

    def enter(self, name: str, words: str) -> None:
        """Take what was entered in a field; what cannot be used is explained there and changes nothing."""
        try:
            state = self.state.change(name, words)
            live.motion(state.setting)
        except InputError as error:
            self.controls.fields[name].explain(str(error))
            return
        self.set(state)

    def attempt(self, make: Callable[[], State]) -> None:
        """Go to a state, or say why that cannot be."""
        try:
            state = make()
            live.motion(state.setting)
        except InputError as error:
            self.say(str(error))
            return
        self.say("")
        self.set(state)

    def set(self, state: State) -> None:
        """Show a state."""
        self.state = state
        self.draw()

    def clicked(self, event: Any) -> None:
        """Take the design of a cell of the map."""
        value = event.args.get("value")
        if event.args.get("seriesId") == "cells" and isinstance(value, list):
            self.attempt(lambda: map.take(self.state, *self.map_axes, (int(value[0]), int(value[1]))))

    def choose_axes(self, x: str, y: str) -> None:
        """Draw the map over other parameters."""
        try:
            map.check_axes(self.state.load, x, y)
        except InputError as error:
            self.say(str(error))
            return
        self.map_axes = (x, y)
        self.draw_map()

    def toggle_arrows(self) -> None:
        """Show or hide the arrows of the forces."""
        on = not self.view.props["arrows"]
        self.view.arrows(on=on)
        self.arrows.props["textContent"] = "Hide forces" if on else "Show forces"
        self.arrows.update()

    def darken(self, dark: bool) -> None:
        """Draw the plots for a dark or a light page."""
        if dark != self.dark:
            self.dark = dark
            self.map_key = None
            self.draw_plots()

    def say(self, words: str) -> None:
        """Show a line above the figures, or take it away."""
        write(self.notice, words)
        self.notice.classes(remove="shown" if not words else "", add="shown" if words else "")

    def save(self, kind: str) -> None:
        """Hand a file to the browser."""
        if kind == "png":
            self.view.run_method("save", "beam.png")
            return
        try:
            name, content = download.make(self.state, kind)
        except InputError as error:
            self.say(str(error))
            return
        self.client.download(content, name)

    # ---- what is drawn -------------------------------------------------------------------------------------

    def draw(self) -> None:
        """Draw everything that the state changes; the map follows when nothing more comes in."""
        self.view.show(live.scene(self.state))
        self.controls.show(self.state)
        self.outcome.show(self.state)
        self.compared.show(self.state)
        # the view comes first: plots follow in a moment, once for all changes until then
        if self.later is None and app.is_started:
            self.later = asyncio.get_running_loop().call_later(MOMENT, self.draw_plots)
        self.client.run_javascript(f"history.replaceState(null, '', '?{link.query(self.state)}')")

    def draw_plots(self) -> None:
        """Draw the three curves; one whose point alone has moved is not drawn again."""
        self.later = None
        colour = charts.theme(dark=self.dark).mark
        for plot, (chart, place) in self.plots.items():
            options = charts.line_options(self.state, plot, dark=self.dark)
            if options != chart.options:
                chart._props["options"] = options
                chart.update()
            panels.show_marks(place, [map.Mark("", colour, *charts.point(self.state, plot))])
        self.draw_map()

    def draw_map(self) -> None:
        """Move the mark of the design; compute the map anew where it depends on what has changed."""
        if not set(self.map_axes) <= set(map.axes(self.state.load)):
            self.map_axes = ("mu", "eta")
        self.map_choices(self.state.load, self.map_axes)
        wanted = map.key(self.state, *self.map_axes)
        panels.show_marks(self.marks, map.marks(self.state, wanted))
        if wanted == self.map_key:
            return
        if self.pending is not None:
            self.pending.cancel()
        if app.is_started:
            self.pending = asyncio.get_running_loop().create_task(self._map(wanted))

    async def _map(self, wanted: map.Key) -> None:
        await asyncio.sleep(WAIT)
        found = await run.io_bound(map.grid, wanted)
        if found is None or self.map.is_deleted:
            return
        self.map_key = wanted
        panels.list_ends(self.map_ends, map.ends(found), wanted.load)
        self.map._props["options"] = map.options(wanted, found, dark=self.dark)
        self.map.update()
