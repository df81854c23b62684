"""Parts of the page: presets and tools, parameters, outcome, comparison, measured table, part under load."""

from __future__ import annotations

import base64
import itertools
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from nicegui import ui

from squama.loads import FREE, LOADS
from squama.plot.palette import KEPT, STATES, WORDS
from squama.web import bench, fields, live, map, state, tables  # noqa: A004 - the module is named after what it draws
from squama.web.charts import Line
from squama.web.fields import CHOICES, FIELDS, MATERIALS, OTHER, material
from squama.web.state import PRESETS, State
from squama.web.tables import Table
from squama.web.widgets import Choice, Entry, NumberField, anew, button, text, write

Attempt = Callable[[Callable[[State], State]], None]
"""Function that shows the state returned by its argument, or the reason why it is impossible."""


def presets(attempt: Attempt) -> None:
    """Make the list of initial beams."""

    def go(name: str) -> None:
        if name:
            attempt(lambda now: state.preset(name, now.kept))

    Choice("Preset", {"": "Start from ..."} | {name: words for name, (words, *_) in PRESETS.items()}, "", go)


FILES = {
    "toml": "beam file (TOML)",
    "csv": "curve as a table (CSV)",
    "plots-svg": "plots for print (SVG)",
    "plots-png": "plots for print (PNG)",
    "png": "view as a picture (PNG)",
    "html": "view as a page of its own (HTML)",
}
"""Files for download."""


def tools(save: Callable[[str], None], brightness: Callable[[], object]) -> None:
    """Make the menu of downloads and the buttons for undo, link and brightness."""
    with ui.element("nav").props('aria-label="Files and page"'):
        with ui.element("details").classes("menu"):
            text("summary", "Save", "button")
            with ui.element("div") as every:
                for kind, what in FILES.items():
                    button(what[0].upper() + what[1:], partial(save, kind), f"Download the {what}", kind)
            every.on("click", js_handler="(e) => e.currentTarget.parentElement.removeAttribute('open')")
        undo = button("Undo", lambda: None, "Go back to the state before the last change (Ctrl+Z)", "undo")
        undo.on("click", js_handler="() => { if (history.state?.step > 0) history.back(); }")
        copy = button("Copy link", lambda: None, "Copy the address of this state", "link")
        copy.on(
            "click",
            js_handler="(e) => { navigator.clipboard.writeText(location.href); const b = e.target; "
            "b.textContent = 'Copied'; setTimeout(() => { b.textContent = 'Copy link'; }, 1500); }",
        )
        button("Light/dark", brightness, "Change between light and dark", "dark")


def legend() -> None:
    """Make the legend of the view's colours."""
    with ui.element("ul").classes("legend"):
        for name, words in (WORDS | {"normal": "normal force on the tip", "friction": "friction on the tip"}).items():
            _key(words, STATES.get(name, ""), name)


def _key(words: str, colour: str, name: str = "") -> None:
    """Add an entry to a legend; without a colour ``name`` is a class of the style sheet."""
    with ui.element("li"):
        ui.element("b").classes(f"key {name}").style(f"background: {colour}" if colour else "")
        text("span", words)


class Controls:
    """All parameters in collapsible groups."""

    def __init__(self, attempt: Attempt, enter: Callable[[str, str], None]) -> None:
        self.fields: dict[str, NumberField] = {}
        self.choices: dict[str, Choice] = {}

        def choose(name: str, value: str) -> None:
            attempt(lambda now: now.change(name, value))

        with ui.element("section").classes("controls").props('aria-label="Parameters"'):
            for group in dict.fromkeys(field.group for field in FIELDS.values()):
                with ui.element("details") as folded:
                    folded.props["open"] = group != "Material and joint"
                    text("summary", group)
                    if group == "Loading":
                        for name, (label, options) in CHOICES.items():
                            self.choices[name] = Choice(label, options, "", partial(choose, name))
                        self.material = Choice("Material", {}, "", partial(choose, "material"))
                    for name, field in FIELDS.items():
                        if field.group == group:
                            self.fields[name] = NumberField(name, enter)

    def show(self, now: State) -> None:
        """Show a state in all fields."""
        for name, choice in self.choices.items():
            choice.set(CHOICES[name][1], getattr(now, name))
        found = material(now.beam.scale)
        words = {name: words for name, (words, _) in MATERIALS.items()}
        self.material.set(words | (OTHER if found in OTHER else {}), found)
        names, m = LOADS[now.load], live.motion(now.setting)
        laws = live.own_joint(now)
        for name, field in self.fields.items():
            look = fields.of(name, now.beam, load=now.load)
            if name == "twist":
                look = look._replace(high=float(f"{look.turn * m.most:.3g}"))
            field.show(now.value(name), look, hint=laws.get(name))
        for name in ("law", "sense", "joint", "ideal"):
            self.choices[name].set_visibility(names.sided)
        self.fields["bend"].set_visibility(names.sided)


class Outcome:
    """The verdict, the figures of the current point, the end of the curve, the warnings."""

    def __init__(self) -> None:
        with ui.element("section").classes("outcome").props('aria-label="Outcome"'):
            with ui.element("div").classes("end"):
                self.verdict, self.own, self.model = text("strong"), text("span", "", "own"), text("span")
            self.readings = ui.element("dl")
            self.sentence = text("p", "", "sentence").props('aria-live="polite"')
            # focusable, because a long list scrolls
            self.list = ui.element("ul").classes("warnings").props('aria-label="Warnings" tabindex="0"')
            self.list.set_visibility(False)
        self.shown: list[ui.element] = []

    def show(self, now: State) -> None:
        """Show a state."""
        end, where, sentence = live.outcome(now)
        write(self.verdict, live.verdict(now))
        write(self.own, live.own_scales(now))
        write(self.model, live.motion(now.setting).model)
        write(self.sentence, f"{' '.join(filter(None, ('The curve ends', f'({end})' * bool(end), where)))}. {sentence}")
        rows = live.readings(now)
        if anew(self.readings, [label for label, _ in rows]):
            self.shown.clear()
            for label, _ in rows:
                with self.readings, ui.element("div"):
                    text("dt", label)
                    self.shown.append(text("dd"))
        for place, (_, value) in zip(self.shown, rows, strict=True):
            write(place, value)
        lines = live.warnings(now)
        if anew(self.list, lines):
            self.list.set_visibility(bool(lines))
            with self.list:
                for line in lines:
                    text("li", line)


HEADS = {
    "name": "",
    "what": "design",
    "model": "model",
    "end": "end",
    "engagement": "engages ({})",
    "at": "ends ({})",
    "torque": "load there",
    "RED": "RED",
}
"""Columns of the table of kept designs, by the keys of a row, with a place for the unit of angles."""


class Compared:
    """The table of the kept designs and the displayed one."""

    def __init__(self, attempt: Attempt) -> None:
        self.attempt = attempt
        with ui.element("section").classes("compared").props('aria-label="Comparison"'):
            with ui.element("p"):
                text("strong", "Compare")
                button("Keep this design", partial(attempt, State.keep), "Keep it to compare, up to three", "keep")
            # focusable, because a wide table scrolls
            with ui.element("div").classes("rows").props('tabindex="0" aria-label="Kept designs"') as self.place:
                self.table = ui.element("table")
            self.place.set_visibility(False)

    def show(self, now: State) -> None:
        """Show a state; without kept designs there is no table."""
        rows = live.compared(now) if now.kept else []
        if not anew(self.table, (rows, live.angles(now))):
            return
        # a model common to all designs is shown with the outcome
        columns = [name for name in HEADS if name != "model" or len({row["model"] for row in rows}) > 1]
        self.place.set_visibility(bool(rows))
        with self.table:
            if not rows:
                return
            with ui.element("thead"), ui.element("tr"):
                for head in (*(HEADS[name].format(live.angles(now)[1]) for name in columns), ""):
                    text("th", head)
            with ui.element("tbody"):
                for i, row in enumerate(rows):
                    with ui.element("tr"):
                        name, *_ = [text("td", row[column]) for column in columns]
                        with ui.element("td"):
                            if i == len(now.kept):
                                continue
                            for word, act in (("Show", State.show), ("Remove", State.drop)):
                                go = partial(self.attempt, partial(act, i=i))
                                button(word, go, f"{word} design {row['name']}")
                        # letters stay in the text colour, legible on every background
                        name.style(f"box-shadow: inset 0 -3px {KEPT[i]}; font-weight: bold")


DECIMALS = {"": "as guessed", ".": "point", ",": "comma"}
"""Decimal signs of a table."""
ENDLESS_ENDS, ENDS = {"": "endless"}, {"free": "free", "couple": "under a couple", "gripped": "gripped"}
"""Ends of a specimen, without and with a number of scales."""


class Measured:
    """The opened measured table: settings of its reading, residual, fit."""

    def __init__(
        self, attempt: Attempt, read: Callable[[tables.How], object], fit: Callable[[], object],
        remove: Callable[[], object],
    ) -> None:  # fmt: skip
        self.how = tables.GUESSED

        def choose(name: str, value: str) -> None:
            self.how = self.how._replace(**{name: value})
            read(self.how)

        def hold(ends: str) -> None:
            attempt(lambda now: now._replace(beam=now.beam.replace(ends=ends or None)))

        with ui.element("section").classes("measured").props('aria-label="Measured table"') as self.place:
            with ui.element("p"):
                self.name, self.residual = text("strong"), text("span")
            with ui.element("p"):
                hint = "as guessed; e.g. 1=total (deg), 2=T (N mm)"
                take = partial(choose, "columns")
                self.columns = Entry("Columns", "", take, most=200, mark="columns", hint=hint)
                self.decimal = Choice("Decimals", DECIMALS, "", partial(choose, "decimal"))
                self.ends = Choice("Ends", ENDLESS_ENDS, "", hold)
                button("Fit μ and K_θ", fit, "Find friction and joint stiffness by the model that is shown", "fit")
                button("Remove", remove, "Take the measured points away", "unmeasured")
            self.found = ui.element("div").classes("found")
        self.place.set_visibility(False)

    def forget(self) -> None:
        """Reset the reading of the next table to guesses."""
        self.how = tables.GUESSED
        self.columns.empty()
        self.decimal.set(DECIMALS, "")

    def show(self, name: str, table: Table | None, now: State, found: tables.Fitted | None) -> None:
        """Show a table (or only the name of an unreadable one), its residual for a state, and the result of a fit."""
        self.place.set_visibility(bool(name))
        write(self.name, name)
        self.ends.set(*(ENDS, now.beam.ends or FREE) if now.beam.scales else (ENDLESS_ENDS, ""))
        words = "not read: choose columns and decimals"
        if table is not None:
            left = tables.residual(table, now, found)
            words = left.words if left else f"measured in {table.load}"
            words = "; ".join(filter(None, (words, table.said)))
        write(self.residual, words)
        shown = found if found and found.beam == now.beam else None
        if not anew(self.found, shown and (shown.values, shown.doubts, shown.lines)) or shown is None:
            return
        with self.found:
            for doubt in shown.doubts:
                text("p", f"Check: {doubt}", "doubt")
            with ui.element("dl"):
                for symbol, what, value in shown.values:
                    with ui.element("div"):
                        text("dt", f"{symbol}, {what}")
                        text("dd", value)
            text("p", f"Fitted as {shown.specimen}, {shown.model}")
            with ui.element("details"):
                text("summary", "Summary of the fit")
                text("pre", "\n".join(shown.lines))


class PartUnderLoad:
    """The beam as a part, a cantilever or a three-point bend: shape, force, contact force of each scale."""

    def __init__(self, bear: Callable[..., object]) -> None:
        self.state: State | None = None
        self.given = {"case": "cantilever", "way": "up", "force": "0.2 N"}

        def put_in(name: str) -> Callable[[str], None]:
            return lambda value: self.given.update({name: str(value)[:50]})

        with ui.element("section").classes("part").props('aria-label="Part under load"'), ui.element("details"):
            text("summary", "Part under load")
            with ui.element("p"):
                Choice("Case", {name: one[0] for name, one in bench.CASES.items()}, "cantilever", put_in("case"))
                Choice("Direction", bench.WAYS, "up", put_in("way"))
                Entry("Force", self.given["force"], put_in("force"), most=50, mark="force")
                button("Load it", lambda: bear(**self.given), "Load the part, by squama.load", "bear")
            with ui.element("div") as self.result:
                self.words, what = ui.element("ul"), "Shape of the part, force over travel, and force on each scale"
                self.picture = ui.element("img").props(f'alt="{what}"')
            self.picture.set_visibility(False)

    def show(self, found: bench.Loaded, state: State) -> None:
        """Show the result of a part under load."""
        self.state = state
        self.words.clear()
        with self.words:
            for line in found.words:
                text("li", line)
        self.picture.set_visibility(True)
        content = base64.b64encode(found.picture.encode()).decode()
        self.picture.props["src"] = f"data:image/svg+xml;base64,{content}"
        self.result.classes(remove="old")

    def fade(self, now: State) -> None:
        """Grey out a result for another beam or model."""
        if self.state is not None and bench.follows(now) != bench.follows(self.state):
            self.state = None
            self.result.classes(add="old")


def show_lines(place: ui.element, wanted: Sequence[Line]) -> None:
    """Make the legend of the plots' lines, the displayed design first."""
    last, *others = {line.name: line for line in reversed(wanted)}.values()
    looks = [(line.name, _sample(line)) for line in (last, *reversed(others))]
    if not anew(place, looks):
        return
    with place:
        for name, look in looks:
            with ui.element("li"):
                ui.element("b").classes("key line").style(look)
                text("span", name)


def _sample(line: Line) -> str:
    """Return the CSS style of a sample of a line."""
    if line.points:
        return f"height: 6px; width: 6px; border-radius: 50%; background: {line.colour}"
    ends = itertools.pairwise(itertools.accumulate(line.dashes, initial=0))
    stops = [f"{'transparent' if i % 2 else line.colour} {a}px {b}px" for i, (a, b) in enumerate(ends)]
    ground = f"repeating-linear-gradient(90deg, {', '.join(stops)})" if stops else line.colour
    return f"height: {max(2, round(line.width))}px; background: {ground}"


def map_choices(choose: Callable[[int, str], None]) -> Callable[[tuple[str, str], str], None]:
    """Make the title of the map and the lists of its two axes; return a function that updates them."""
    options = {name: f"{FIELDS[name].symbol} {word}" for name, word in map.AXES.items()}
    with ui.element("p").classes("axes"):
        title = text("strong")
        lists = [Choice(label, {}, "", partial(choose, i)) for i, label in enumerate(("Across", "Up"))]

    def show(axes: tuple[str, str], words: str) -> None:
        write(title, words)
        for one, axis in zip(lists, axes, strict=True):
            one.set(options, axis)

    return show


def list_classes(place: ui.element, classes: Mapping[str, str], wanted: map.Key) -> None:
    """Make the legend of the map's colours."""
    place.clear()
    with place:
        for words, colour in classes.items():
            _key(words, colour)
        if wanted.at is None and LOADS[wanted.load].sided:
            text("li", f"(of the tip-side contact alone, {wanted.scales})")


def marks(room: Mapping[str, int]) -> ui.element:
    """Make the container of the marks over a plot with these margins."""
    inset = " ".join(f"{room[side]}px" for side in ("top", "right", "bottom", "left"))
    return ui.element("div").classes("marks").style(f"inset: {inset}").props('aria-hidden="true"')


RIM = 8
"""Radius of a mark, pixels."""


def show_marks(place: ui.element, wanted: Sequence[map.Mark]) -> None:
    """Show marks at their positions."""
    old = list(place.default_slot.children)
    if len(old) != len(wanted):
        place.clear()
        with place:
            old = [text("b") for _ in wanted]
    for element, mark in zip(old, wanted, strict=True):
        write(element, mark.letter)
        element.classes(add="aside" if mark.shift else "", remove="" if mark.shift else "aside")
        style = f"left: {100 * mark.left:.2f}%; top: {100 * mark.top:.2f}%; margin-left: {mark.shift}px"
        style += f"; border-color: {mark.colour}"
        if mark.shift:
            # a leader line from the rim of the mark to its place
            start = -mark.shift if mark.shift > 0 else RIM
            style += f"; --start: {start}px; --lead: {abs(mark.shift) - RIM}px; --place: {-mark.shift}px"
        if element.props.get("data-style") != style:
            element.props["data-style"] = style
            element.style(replace=style)
