"""State of the page: a beam, its load, and the kept designs, validated.

A state can be written as the query of a link and read back, exact to the last bit and validated like a beam file.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any, NamedTuple
from urllib.parse import parse_qsl, urlencode

from squama import arguments
from squama.beam import beamfile
from squama.beam.beamfile import TABLES
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.errors import InputError, Problems, naming, refuse
from squama.joints import choice
from squama.loads import LOADS
from squama.paper import parameters
from squama.people import degrees
from squama.scene.motion import Motion, Setting
from squama.scene.picture import FIRST
from squama.units import as_text, is_number, shown
from squama.web.fields import CHOICES, FIELDS, LABELS, MATERIALS, PLAIN, TURNS, made_of, placed, turn, within
from squama.web.fields import of as of_field

MOST_KEPT = 3
"""Largest number of kept designs."""
LONGEST, MOST_VALUES = 20_000, 64
"""Largest number of characters, and of values, of a query; a link has some thirty values."""


class State(NamedTuple):
    """A beam and its load; ``twist``: the wanted twist or bend, rad per pitch.

    ``bend``: bend held while the beam is twisted, rad per pitch, signed. ``ideal``, "yes" or "no": thin, rigid scales;
    ``path``: "loading", "cycle" (loading and unloading) or "decay" (release from the load).
    """

    beam: Beam
    twist: float
    load: str = "twisting"
    law: str = "edge"
    sense: str = "+"
    margin: float = 0.01
    joint: str = "compliant"
    ideal: str = "no"
    path: str = "loading"
    bend: float = 0.0
    kept: tuple[State, ...] = ()

    @property
    def mu(self) -> float:
        """Coefficient of friction of the beam, or 0.25 if it has none."""
        return 0.25 if self.beam.friction.mu is None else self.beam.friction.mu

    @property
    def bent(self) -> bool:
        """Whether a bend is held."""
        return bool(self.bend) and LOADS[self.load].sided

    @property
    def setting(self) -> Setting:
        """Setting of the curve."""
        ideal, law, bend = self.ideal == "yes", "edge" if self.bent else self.law, self.bend if self.bent else 0.0
        sided = LOADS[self.load].sided
        how = self.beam, self.mu, self.load, law, self.margin, self.sense
        if self.joint == "compliant" and (sided or self.path != "decay"):
            # a joint outside the law is replaced by hinges, and the page says so; in bending a decay takes hinges
            return Setting(*how, None, ideal or None, bend)
        # held bent, and in bending, hinges have thin scales only
        return Setting(*how, "hinge", ideal or self.bent or not sided, bend)

    @property
    def quick(self) -> bool:
        """Whether the curve is available at once, without finite elements for the joint."""
        return self.joint == "hinge" or LOADS[self.load].law(self.law) == "plate" or choice.known(self.beam)

    @property
    def hinged(self) -> State:
        """The same state with the paper's model: thin scales on hinges."""
        return self._replace(joint="hinge", ideal="yes")

    @property
    def beside(self) -> State | None:
        """The same state with the other model (hinges or thick scales), None where that needs finite elements."""
        if self.beam.other:
            return None
        other = self.hinged if self.joint == "compliant" else self._replace(joint="compliant", ideal="no", law="edge")
        return other if other.quick else None

    def covered(self) -> State:
        """Return this state; refuse scales on both faces by hinges, or by a joint that is not available at once."""
        if self.joint == "hinge" or not self.quick:
            only_one(self.beam.faces, "the explorer on hinges")
        return self

    def value(self, name: str) -> float | int | None:
        """Return the value of a field, SI."""
        if name in PLAIN:
            return float(getattr(self, name))
        if name == "scales":
            return self.beam.pitches
        table, _, key = FIELDS[name].place.rpartition(".")
        return getattr(getattr(self.beam, table, self.beam), key)  # type: ignore[no-any-return]

    def change(self, name: str, text: str) -> State:
        """Return the state with an entry of a field or a choice: a number in the field's unit or with its own.

        Raises InputError for an invalid entry, in one line with the allowed values.
        """
        return self._changed(name, text).covered()

    def _changed(self, name: str, text: str) -> State:
        """Return the state with an entry as :meth:`change`, whatever the model covers."""
        if name in CHOICES:
            new = self._with(name, arguments.one_of(name, text, tuple(CHOICES[name][1])))
            if name == "joint":
                # hinges have ideal scales by default, and only they have the plate law
                return new.hinged if text == "hinge" else new._replace(ideal="no", law="edge")
            if text == "plate":
                return new.hinged
            return new.started() if name == "load" else new
        if name == "material":
            return self._replace(beam=self.beam.replace(scale=made_of(arguments.one_of(name, text, tuple(MATERIALS)))))
        field = of_field(name, self.beam, load=self.load)
        with naming(field.label):
            number = turn(name, text, self.beam, self.load) if name in TURNS else field.read(text)
        if name in PLAIN:
            return self._with(name, number)
        try:
            return self._replace(beam=self.beam._with(dict([placed(self.beam, name, number)])))
        except InputError as error:
            raise error.renamed(LABELS) from None

    def _with(self, name: str, value: Any) -> State:
        return self._replace(**{name: value})

    def started(self) -> State:
        """Return the state at a share of the way to its end (on hinges, where its own end is not available at once)."""
        one = self if self.quick else self.hinged
        # a round number in the displayed unit
        factor, _ = degrees(self.beam)
        return self._replace(twist=float(f"{factor * FIRST * Motion(one.setting).last:.3g}") / factor)

    def keep(self) -> State:
        """Return the state with the displayed design kept for comparison.

        Raises InputError where three are kept already, or this one is.
        """
        alone = self._replace(kept=())
        if alone in self.kept:
            refuse("", "", "this design is kept already", "change something first")
        if len(self.kept) >= MOST_KEPT:
            refuse("", "", f"{MOST_KEPT} designs are kept", "remove one first")
        return self._replace(kept=(*self.kept, alone))

    def drop(self, i: int) -> State:
        """Return the state without a kept design."""
        return self._replace(kept=self.kept[:i] + self.kept[i + 1 :])

    def show(self, i: int) -> State:
        """Return the state that shows a kept design."""
        return self.kept[i]._replace(kept=self.kept)


def of(beam: Beam) -> State:
    """Return the first state of a beam."""
    mu = State(beam, 0.0).covered().mu
    return State(beam.replace(friction={"mu": mu}), 0.0).started()


def example() -> Beam:
    """Return the beam of the commented example: PLA scales on a silicone bar."""
    text = files("squama").joinpath("cli", "example.toml").read_text(encoding="utf-8")
    return Beam.from_toml_text(text, source="example")


PRESETS: dict[str, tuple[str, Callable[[], Beam], dict[str, float]]] = {
    "pla": ("PLA scales on silicone (example)", example, {}),
    "main": ("Paper, Figs. 4, 5, 6a, 7 (η = 3)", parameters.main, {"mu": 0.5}),
    "fig6b3": ("Paper, Fig. 6b (η = 3)", partial(parameters.fig6b, 3.0), {"mu": 0.2}),
    "fig6b2": ("Paper, Fig. 6b (η = 2)", partial(parameters.fig6b, 2.0), {"mu": 0.2}),
}
"""Initial beams: words, function that makes the beam, and a friction in place of the beam's own. Beams of the paper
have one and are shown with the paper's model.
"""


def preset(name: str, kept: tuple[State, ...] = ()) -> State:
    """Return an initial state. Raises InputError for an unknown preset."""
    _, make, friction = PRESETS[arguments.one_of("preset", name, tuple(PRESETS))]
    beam = make().replace(friction=friction)
    return (State(beam, 0.0).hinged.started() if friction else of(beam))._replace(kept=kept)


def query(state: State) -> str:
    """Return the query of a state's link.

    >>> link = query(preset("main"))
    >>> link[:56], read(link) == preset("main")
    ('load=twisting&path=loading&law=edge&sense=%2B&joint=hing', True)
    """
    pairs = {name: getattr(state, name) for name in CHOICES}
    pairs |= {name: repr(float(getattr(state, name))) for name in PLAIN if name != "bend" or state.bend}
    data = state.beam.model_dump()
    for table, keys in TABLES.items():
        part = data if table == "beam" else data[table]
        for key, (dimension, *_) in keys.items():
            if (value := part[key]) is not None:
                pairs[f"{table}.{key}"] = str(value) if dimension is None else as_text(value, dimension)
    return urlencode([*pairs.items(), *(("keep", query(one)) for one in state.kept)])


def read(text: str, *, kept: bool = True) -> State:
    """Return the state of a query; ``kept``: whether it may hold kept designs.

    Raises InputError with one line per mistake.
    """
    if len(text) > LONGEST:
        refuse("", "", f"the link is longer than {LONGEST} characters", "copy it anew")
    text = text.removeprefix("?")
    if text.count("&") >= MOST_VALUES:
        refuse("", "", f"the link has more than {MOST_VALUES} values", "copy it anew")
    pairs = parse_qsl(text, keep_blank_values=True)
    tables: dict[str, dict[str, object]] = {}
    plain: dict[str, str] = {}
    keeps: list[str] = []
    problems = Problems()
    for name, given in pairs:
        table, dot, key = name.partition(".")
        if dot and table in TABLES and key in TABLES[table]:
            whole = TABLES[table][key].dimension is None and given.isdecimal() and len(given) < 9
            tables.setdefault(table, {})[key] = int(given) if whole else given
        elif name in CHOICES or name in PLAIN:
            plain[name] = given
        elif name == "keep" and kept:
            keeps.append(given)
        else:
            problems.add(shown(name), reason="is not known in a link")
    if len(keeps) > MOST_KEPT:
        problems.add("keep", reason=f"{len(keeps)} designs", remedy=f"at most {MOST_KEPT}")
    problems.settle()
    beam = Beam._build(beamfile.merge({}, tables), source="link", bare=False)
    state = State(beam, 0.0)
    state = state._replace(beam=beam.replace(friction={"mu": state.mu}))
    # the idealisation comes after the joint, which sets its own
    for name in sorted(plain, key=[*CHOICES, *PLAIN].index):
        # links are in rad per pitch, whatever unit the page shows
        if name in TURNS and is_number(given := plain[name]):
            with naming(name):
                state = state._with(name, within(name, float(given), given, beam, state.load))
            continue
        other = state._changed(name, plain[name])
        # a load in a link does not reset the twist, unlike a change on the page
        state = state._replace(load=plain[name]) if name == "load" else other
    return state.covered()._replace(kept=tuple(read(one, kept=False) for one in keeps))
