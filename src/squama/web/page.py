"""The page: its parts, and the actions on changes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from importlib.resources import files
from operator import call
from typing import Any, TypeVar, cast

from nicegui import ui
from nicegui.events import GenericEventArguments

from squama.beam.beamfile import beside_the_beam
from squama.errors import InputError
from squama.plot.palette import THEMES, variables
from squama.scene.picture import SIZE
from squama.web import bench, charts, live, map, panels, tables  # noqa: A004 - the module is named after what it draws
from squama.web.aside import Aside
from squama.web.state import State, query
from squama.web.tables import GUESSED, Fitted, How, Table
from squama.web.widgets import BeamView, Chart, FileButton, button, put, received, text, write

WAIT = 0.3
"""Seconds without a change after which the link is written and the map computed."""
T = TypeVar("T")
SOLVING = Aside(live.prepare, most=2)
LOADING = Aside(bench.followed, most=1, limit=300)
READING = Aside(tables.opened, most=1, limit=20)
FITTING = Aside(tables.fitted, most=1, limit=tables.SECONDS + 5)
PRINTING: Aside[[Callable[[], Any]], Any] = Aside(call, most=1, limit=60)
"""Calls what draws with matplotlib, whose settings are global to the process: one call at a time."""
MAPPING = Aside(map.grid, most=1)
SWINGING = Aside(live.swing, most=1, limit=30)
LINKING = Aside(live.linked, most=2, limit=5)
"""Reads links, within a time limit in seconds."""
SCRIPT = """
for (const name of ["keydown", "pointerdown"])
  addEventListener(name, ({ key, target }) => {
    for (const menu of document.querySelectorAll(".menu[open]")) {
      if (key ? key !== "Escape" : menu.contains(target)) continue;
      menu.open = false;
      if (key) menu.firstElementChild.focus();
    }
  });
addEventListener("popstate", ({ state }) => emitEvent("went", { link: location.search, step: state?.step ?? 0 }));
addEventListener("keydown", (event) => {
  const undo = (event.ctrlKey || event.metaKey) && !event.shiftKey && event.key === "z";
  if (!undo || event.target.matches("input[type=text]") || !(history.state?.step > 0)) return;
  event.preventDefault();
  history.back();
});
"""
"""Closes open menus on Escape and on a click elsewhere; Back of the browser, and Ctrl+Z, undo."""
LET_GO, STOP = "Let go", "Stop"
"""Labels of the button that plays a decay, before and while it plays."""


@contextmanager
def telling(tell: Callable[[str], None]) -> Iterator[None]:
    """Pass the message of an InputError raised inside to ``tell``."""
    try:
        yield
    except InputError as error:
        tell(str(error))


class Explorer:
    """One open page: its state, and the elements that display it."""

    def __init__(self, state: State, notice: str = "") -> None:
        # the wanted state and the displayed one differ for seconds where a joint needs finite elements
        self.wanted = state
        if not all(one.quick for one in (state, *state.kept)):
            state = state.hinged._replace(kept=())
        self.state = self.drawn = state
        self.solving = self.working = self.pending = cast("asyncio.Task[None] | None", None)
        self.table: Table | None = None
        self.found: Fitted | None = None
        # the file of a table, which may be read again
        self.file = "", b""
        self.dark, self.map_axes = False, ("mu", "alpha")
        self.map_key: map.Key | None = None
        # the browser's address, and its number in the history
        self.link, self.step = "", 0
        # kept, because a clicked element may be gone before everything is drawn
        self.client = ui.context.client
        ui.add_css(files("squama.web").joinpath("page.css").read_text(encoding="utf-8"))
        ui.add_css(f":root {{ {variables('light')} }} body.body--dark {{ {variables('dark')} }}")
        self.mode = ui.dark_mode(None)
        with ui.element("header"):
            text("h1", "squama explorer")
            FileButton("Open", ".toml,.csv,.tsv,.txt", tables.LARGEST["table"], self.open, self.say)
            panels.presets(self.attempt)
            panels.tools(self.save, lambda: self.mode.set_value(not self.dark))
        with ui.element("div").classes("explorer"):
            with ui.element("div").classes("work"):
                with ui.element("section").classes("stage").props('aria-label="Beam"'):
                    self.view = BeamView(live.scene(self.drawn), self.darken, self.rest)
                    with ui.element("div").classes("over"):
                        words = "Play the vibration from the twist that is shown"
                        self.release = button(LET_GO, self.let_go, words, "release")
                        button("Reset view", lambda: self.view.run_method("reset"), "Show the whole beam", "reset")
                        self.arrows = button("Hide forces", self.toggle_arrows, "Show or hide the arrows", "arrows")
                    panels.legend()
                self.notice = text("p", "", "notice").props('role="alert"')
                self.outcome = panels.Outcome()
                self.measured = panels.Measured(self.attempt, self.read, self.fit, self.remove)
                with ui.element("section").classes("plots").props('aria-label="Plots"'):
                    self.lines = ui.element("ul").classes("legend lines")
                    with ui.element("div").classes("strip"):
                        self.plots = {plot: self._chart(plot) for plot in (*charts.PLOTS, charts.RESIDUAL)}
                        self._map_chart()
                self.part = panels.PartUnderLoad(self.bear)
                self.compared = panels.Compared(self.attempt)
            self.controls = panels.Controls(self.attempt, self.enter)
        ui.add_head_html(f"<script>{SCRIPT}</script>")
        ui.on("went", self.go_back)
        self.say(notice)
        self.draw()
        # a page without a browser computes nothing
        self.client.on_connect(self.begin)
        self.client.on_delete(self.end)

    def _chart(self, plot: str) -> tuple[Chart, ui.element]:
        with ui.element("div").classes("plot") as place, ui.element("div").classes("cells"):
            chart = Chart(charts.line_options(self.drawn, plot, dark=False), "svg")
            if plot == charts.RESIDUAL:
                self.residual_plot = place
            return chart, panels.marks(charts.ROOM)

    def _map_chart(self) -> None:
        with ui.element("div").classes("plot"):
            self.map_choices = panels.map_choices(self.choose_axis)
            self.map_ends = ui.element("ul").classes("legend ends")
            with ui.element("div").classes("cells"):
                self.map = Chart({"series": []}, "canvas")
                self.marks = panels.marks(map.ROOM)
            self.map.props["aria-label"] = "Map over two parameters; a click takes the design under the pointer"
            self.map.on("picked", self.clicked)

    def begin(self) -> None:
        """Compute and draw the slow parts, once a browser is connected."""
        self.draw_plots()
        wanted, self.wanted = self.wanted, self.drawn
        if wanted != self.drawn:
            self.change_to(wanted, self.say)

    def end(self) -> None:
        """Cancel running work of a closed page."""
        for one in (self.pending, self.solving, self.working):
            if one is not None:
                one.cancel()

    # ---- actions of the user ------------------------------------------------------------------------------------

    def enter(self, name: str, words: str) -> None:
        """Apply an entry of a field; an invalid entry is explained at the field and changes nothing."""
        explain = self.controls.fields[name].explain
        with telling(explain):
            self.change_to(self.state.change(name, words), explain)

    def attempt(self, make: Callable[[State], State]) -> None:
        """Show the state that ``make`` returns for the present one, or the reason why it is impossible."""
        with telling(self.say):
            self.say("")
            self.change_to(make(self.state), self.say)

    def change_to(self, state: State, refuse: Callable[[str], None]) -> None:
        """Show a state, at once unless its joint needs finite elements; ``refuse`` gets the message of a failure.

        Raises InputError for a failure that is found at once.
        """
        solved = {one.setting for one in (self.drawn, *self.drawn.kept)}
        if all(one.quick or one.setting in solved for one in (state, *state.kept)):
            live.motion(state.setting)
            self.state = self.drawn = state
            self.draw()
            return
        self.state = state
        if self.solving is None or self.solving.done():
            self.solving = asyncio.get_running_loop().create_task(self._solve(refuse))

    async def _solve(self, refuse: Callable[[str], None]) -> None:
        """Compute the wanted state off the event loop; of several changes the last counts."""
        while (aim := self.state) != self.drawn:
            self.say("Elements are being solved for the joint ...")
            try:
                await SOLVING(aim)
            except InputError as error:
                self.state = self.drawn
                self.say("")
                refuse(str(error))
                self.draw()
                return
            if self.view.is_deleted:
                return
            if aim == self.state:
                self.say("")
                self.drawn = aim
                self.draw()

    def clicked(self, event: GenericEventArguments) -> None:
        """Show the design of a clicked cell of the map."""
        sent = received(event.args, value=list, seriesId=str)
        cell = sent["value"][:2] if sent else []
        if all(type(i) is int and 0 <= i < n for i, n in zip(cell, map.SIZE, strict=False)) and len(cell) == 2:
            self.attempt(lambda now: map.take(now, *self.map_axes, (cell[0], cell[1])))

    def choose_axis(self, i: int, name: str) -> None:
        """Draw the map over another parameter; choosing the other axis's parameter swaps the axes."""
        axes = {i: name, 1 - i: self.map_axes[i if self.map_axes[1 - i] == name else 1 - i]}
        with telling(self.say):
            map.check_axes(axes[0], axes[1])
            self.map_axes = (axes[0], axes[1])
            self.draw_map()

    def toggle_arrows(self) -> None:
        """Show or hide the arrows of the forces."""
        put(self.view, arrows=not self.view.props["arrows"])
        write(self.arrows, "Hide forces" if self.view.props["arrows"] else "Show forces")

    def let_go(self) -> None:
        """Play the decay from the displayed load, or stop it."""
        if self.release.props["textContent"] == STOP:
            self.view.run_method("rest")
            return
        shown = self.drawn

        def play(found: live.Swing) -> None:
            if shown == self.drawn:
                write(self.release, STOP)
                self.say(found.words)
                self.view.run_method("play", found.frames, found.step)

        self.beside("The vibration is being computed ...", SWINGING(shown), play)

    def rest(self) -> None:
        """Reset the button after a decay, when the view shows the state again."""
        write(self.release, LET_GO)

    def go_back(self, event: GenericEventArguments) -> None:
        """Show the state of an address of the browser's history."""
        if sent := received(event.args, link=str, step=int):
            # the browser has changed the address already; if the state cannot be shown, the address is corrected
            self.link, self.step = sent["link"].removeprefix("?"), sent["step"]
            if self.pending is not None:
                self.pending.cancel()

            def show(found: State) -> None:
                self.attempt(lambda _: found)
                if self.state != found:
                    self.draw()

            self.beside("", LINKING(sent["link"]), show, self.draw)

    def darken(self, dark: bool) -> None:
        """Redraw the plots for a dark or a light page."""
        if dark != self.dark:
            self.dark = dark
            self.map_key = None
            self.draw_plots()

    def say(self, words: str) -> None:
        """Show a notice above the figures, or hide it."""
        write(self.notice, words)
        self.notice.classes(remove="shown" if not words else "", add="shown" if words else "")

    def save(self, kind: str) -> None:
        """Send a file to the browser."""
        if kind == "png":
            self.view.run_method("save", "beam.png", *SIZE)
            return
        if kind.startswith("plots-"):
            wanted = self.drawn, self.table, kind.removeprefix("plots-"), self.found

            def printed() -> tuple[str, bytes]:
                # it imports matplotlib
                from squama.web import prints

                return prints.made(*wanted)

            self.beside(
                "The plots are being drawn ...", PRINTING(printed), lambda made: self.client.download(*made[::-1])
            )
            return
        with telling(self.say):
            name, content = live.make_file(self.state, kind)
            self.client.download(content, name)

    @property
    def busy(self) -> bool:
        """Whether a computation is running; if so, show a notice."""
        if self.working is None or self.working.done():
            return False
        self.say("something else is being computed still: wait a moment")
        return True

    def beside(
        self, words: str, work: Coroutine[object, object, T], then: Callable[[T], object],
        failed: Callable[[], object] = lambda: None,
    ) -> None:  # fmt: skip
        """Run ``work`` off the event loop, one at a time, and pass its result to ``then``.

        ``failed`` is called where ``work`` fails or cannot start.
        """
        if self.busy:
            work.close()
            failed()
            return

        async def do() -> None:
            self.say(words)
            try:
                found = await work
            except (InputError, TimeoutError) as error:
                self.say(str(error) or "this takes too long, and was given up")
                failed()
            else:
                if not self.view.is_deleted:
                    self.say("")
                    then(found)

        self.working = asyncio.get_running_loop().create_task(do())

    def open(self, name: str, content: bytes) -> None:
        """Show the beam or the measured table of a file."""

        def show(found: State | Table) -> None:
            if isinstance(found, Table):
                self.measure(found)
                return
            self.attempt(lambda now: found._replace(kept=now.kept))
            part = beside_the_beam(content.decode(errors="replace"))
            if part and self.state.beam == found.beam:
                self.say(f"the beam alone is shown, without {part}; for these: squama load")

        if self.busy:
            return
        if not name.lower().endswith(".toml") and len(content) <= tables.LARGEST["table"]:
            self.file = name, content
            self.measured.forget()
            self.measure(None)
        self.beside("The file is being read ...", READING(name, content, self.state, GUESSED), show)

    def read(self, how: How) -> None:
        """Read the opened table again with chosen columns and decimal sign."""

        def show(found: State | Table) -> None:
            if isinstance(found, Table):
                self.measure(found)

        if self.file[0] and not self.busy:
            # the old points do not belong to the new choices
            self.measure(None)
            self.beside("The table is being read ...", READING(*self.file, self.state, how), show)

    def measure(self, table: Table | None) -> None:
        """Show a measured table with the curves, or none."""
        self.table, self.found = table, None
        self.draw()

    def remove(self) -> None:
        """Remove the measured table."""
        self.file = "", b""
        self.measure(None)

    def fit(self) -> None:
        """Fit the displayed model to the measured table, and show the fitted beam."""
        if (table := self.table) is None:
            return

        def show(found: Fitted) -> None:
            self.found = found
            self.attempt(lambda now: now._replace(beam=found.beam))

        self.beside("A fit is being computed ...", FITTING(table, self.drawn), show)

    def bear(self, case: str, force: str, way: str) -> None:
        """Load the displayed beam as a part."""
        shown = self.drawn

        async def made() -> bench.Loaded:
            data = await LOADING(shown, case, force, way)
            return cast("bench.Loaded", await PRINTING(lambda: bench.told(data, shown)))

        def show(found: bench.Loaded) -> None:
            self.part.show(found, shown)
            self.part.fade(self.drawn)

        self.beside("The part is being loaded ...", made(), show)

    # ---- drawing -------------------------------------------------------------------------------------

    def draw(self) -> None:
        """Draw everything that depends on the state; map and link follow after a pause."""
        if self.release.props["textContent"] == STOP:
            self.view.run_method("rest")
        self.release.set_visibility(self.drawn.path == "decay")
        put(self.view, **live.scene(self.drawn))
        self.controls.show(self.drawn)
        self.outcome.show(self.drawn)
        self.compared.show(self.drawn)
        self.part.fade(self.drawn)
        # in the same message as the view, so that the page is painted once
        if self.client.has_socket_connection:
            self.draw_plots()

    def draw_plots(self) -> None:
        """Draw the curves; a curve of which only the point has moved is not sent again."""
        colour = THEMES["dark" if self.dark else "light"]["mark"]
        for plot, (chart, place) in self.plots.items():
            put(chart, options=charts.line_options(self.drawn, plot, dark=self.dark, table=self.table, fit=self.found))
            if plot != charts.RESIDUAL:
                at = charts.point(self.drawn, plot, self.table)
                panels.show_marks(place, [map.Mark(at.arrow, colour, at.left, at.top)])
        self.residual_plot.set_visibility(self.table is not None)
        shown = charts.lines(self.drawn, "torque", dark=self.dark, table=self.table, fit=self.found)
        panels.show_lines(self.lines, shown)
        self.measured.show(self.file[0], self.table, self.drawn, self.found)
        self.draw_map()

    def draw_map(self) -> None:
        """Move the mark of the design; compute the map again where its key has changed."""
        wanted = map.key(self.drawn, *self.map_axes)
        self.map_choices(self.map_axes, wanted.title)
        panels.show_marks(self.marks, map.marks(self.drawn, wanted))
        if self.pending is not None:
            self.pending.cancel()
        if self.client.has_socket_connection:
            self.pending = asyncio.get_running_loop().create_task(self._settle(wanted))

    async def _settle(self, wanted: map.Key) -> None:
        await asyncio.sleep(WAIT)
        # changing the address makes the browser redraw its window
        if (link := query(self.drawn)) != self.link:
            self.step, how = (self.step + 1, "push") if self.link else (self.step, "replace")
            self.link = link
            self.client.run_javascript(f"history.{how}State({{ step: {self.step} }}, '', '?{link}')")
        if wanted == self.map_key:
            return
        found = await MAPPING(wanted)
        if self.map.is_deleted:
            return
        self.map_key = wanted
        panels.list_classes(self.map_ends, map.classes(wanted, found, dark=self.dark), wanted)
        put(self.map, options=map.options(wanted, found, dark=self.dark))
