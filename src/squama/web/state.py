"""What the page shows: a beam, how it is loaded, and the designs that were kept to compare; checked at the door."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from typing import Any, NamedTuple

from squama import checks, units
from squama.design import Beam
from squama.errors import InputError
from squama.paper import parameters
from squama.units import QuantityError
from squama.view.motion import Motion, Setting
from squama.web.fields import CHOICES, FIELDS, changed, plain, value

MOST_KEPT = 3
"""Designs that can be compared."""
FRICTION = 0.25
"""Coefficient of friction of a beam that has none."""
FIRST = 0.7
"""A beam is first shown at this fraction of the way to its end."""


class State(NamedTuple):
    """A beam and its loading; ``twist`` is the twist or bend per pitch that is asked for, rad."""

    beam: Beam
    twist: float
    load: str = "twisting"
    law: str = "edge"
    sense: str = "+"
    margin: float = 0.01
    kept: tuple[State, ...] = ()

    @property
    def mu(self) -> float:
        """Coefficient of friction; that of the beam, or a usual one if it has none."""
        return FRICTION if self.beam.friction.mu is None else self.beam.friction.mu

    @property
    def setting(self) -> Setting:
        """What the curve depends on."""
        return Setting(self.beam, self.mu, self.load, self.law, self.margin, self.sense)

    def value(self, name: str) -> float | int | None:
        """Return what a field holds, in SI units."""
        if name in ("twist", "margin"):
            return float(getattr(self, name))
        return value(self.beam, name)

    def change(self, name: str, text: str) -> State:
        """Return the state with what was entered in a field.

        Parameters
        ----------
        name : str
            Name of a field or of a choice.
        text : str
            What was entered: a number in the field's unit or with a unit of its own; a word of a choice.

        Returns
        -------
        State

        Raises
        ------
        InputError
            It cannot be used: one line with what is allowed. The state is as it was.
        """
        if name in CHOICES:
            new = self._with(name, checks.one_of(name, text, tuple(CHOICES[name][1])))
            return new.started() if name == "load" else new
        field = FIELDS[name]
        try:
            number = self._load(text) if name == "twist" else field.read(text)
        except QuantityError as error:
            message = f"{field.label}: {error.shown}: {error.reason}"
            raise InputError(message) from None
        if name in ("twist", "margin"):
            return self._with(name, number)
        return self._replace(beam=changed(self.beam, name, number))

    def _with(self, name: str, value: Any) -> State:
        return self._replace(**{name: value})

    def _load(self, text: str) -> float:
        """Read a load: a plain number in rad per pitch, or "5 rad/m", "20 deg/pitch", "90 deg total"."""
        if not plain(text):
            read = units.twist if self.load == "twisting" else units.curvature
            rate = read(text, pitch=self.beam.pitch, scales=self.beam.scales, bare=False)
            text = repr(rate * self.beam.pitch)
        return units.bounded(text, units.Dimension.RATIO, FIELDS["twist"].bounds)

    def started(self) -> State:
        """Return the state part of the way to its end."""
        return self._replace(twist=round(FIRST * Motion(self.setting).last, 4))

    def keep(self) -> State:
        """Return the state with the design kept to compare.

        Raises
        ------
        InputError
            Three are kept already, or this one is.
        """
        alone = self._replace(kept=())
        if alone in self.kept:
            message = "this design is kept already; change something first"
            raise InputError(message)
        if len(self.kept) >= MOST_KEPT:
            message = f"{MOST_KEPT} designs are kept; remove one first"
            raise InputError(message)
        return self._replace(kept=(*self.kept, alone))

    def drop(self, i: int) -> State:
        """Return the state without a kept design."""
        return self._replace(kept=self.kept[:i] + self.kept[i + 1 :])

    def show(self, i: int) -> State:
        """Return the state that shows a kept design."""
        return self.kept[i]._replace(kept=self.kept)


def of(beam: Beam) -> State:
    """Return the first state of a beam."""
    mu = State(beam, 0.0).mu
    return State(beam.replace(friction={"mu": mu}), 0.0).started()


def example() -> Beam:
    """Return the beam of the commented example: PLA scales on a silicone bar."""
    text = files("squama").joinpath("cli", "example.toml").read_text(encoding="utf-8")
    return Beam.from_toml_text(text, source="example")


PRESETS: dict[str, tuple[str, float | None]] = {
    "pla": ("PLA scales on silicone (example)", None),
    "main": ("Paper, Figs. 4, 5, 6a, 7 (η = 3)", 0.5),
    "fig6b3": ("Paper, Fig. 6b (η = 3)", 0.2),
    "fig6b2": ("Paper, Fig. 6b (η = 2)", 0.2),
}
"""Beams to start from: words, and the friction that is shown first (the beam's own if None)."""


def preset(name: str, kept: tuple[State, ...] = ()) -> State:
    """Return a state to start from.

    Raises
    ------
    InputError
        No such preset.
    """
    checks.one_of("preset", name, tuple(PRESETS))
    makers: dict[str, Callable[[], Beam]] = {"pla": example, "main": parameters.main}
    beam = makers[name]() if name in makers else parameters.fig6b(float(name.removeprefix("fig6b")))
    mu = PRESETS[name][1]
    start = of(beam) if mu is None else of(beam.replace(friction={"mu": mu}))
    return start._replace(kept=kept)
