"""All that depends on how a beam is loaded, in one table: twisting and bending."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from operator import attrgetter
from typing import Any, Literal, NamedTuple, cast, get_args

from squama import units
from squama.errors import refuse
from squama.people import per_pitch
from squama.symbols import OTHER

THIN = "thin, rigid scales"
"""How the paper takes scales."""
LawName = Literal["edge", "plate"]
SenseName = Literal["+", "-"]
JointName = Literal["compliant", "hinge"]
HELD = {"hinge": "hinges", "compliant": "compliant joints"}
"""What scales are on, by the kind of joint."""
PAPER = {"joint": "hinge", "scales": THIN}
"""Attributes of what is answered by the paper's model alone."""


class Load(NamedTuple):
    """A kind of loading; everything that asks which one it is asks this table.

    Parameters
    ----------
    name : str
        "twisting" or "bending".
    verb, done : str
        "twist", "twisted".
    angle, rate, torque, tangent, place : str
        Names of variables: load angle per pitch, the same per length, torque or moment, tangent stiffness, place of
        the contact along the other scale.
    angle_words, rate_words, torque_words : str
        What those measure, for labels and sentences.
    letter : str
        The load angle as plain text.
    read : callable
        Reads a rate with its unit, rad/m (:mod:`squama.units`).
    sided : bool
        Whether there are two senses and two force laws.
    axis : int
        Its place in the points of a load path, (psi, phi).
    matrix : bool
        Whether the inclusion factor comes from the joint's matrix, where the beam has one.
    missing : tuple of str
        Roles that have no variable.
    rigidity, inclusion : callable
        Of a beam: rigidity without contact (N m^2), inclusion factor.
    unit, force : str
        SI units of the load angle and of the torque; of a part that is pushed its travel, m, and its force, N.
    """

    name: str
    verb: str
    done: str
    angle: str
    rate: str
    torque: str
    tangent: str
    place: str
    angle_words: str
    rate_words: str
    torque_words: str
    letter: str
    read: Callable[..., float]
    sided: bool
    axis: int
    matrix: bool
    missing: tuple[str, ...]
    rigidity: Callable[[Any], float]
    inclusion: Callable[[Any], float]
    unit: str = "rad"
    force: str = "N m"

    @property
    def pushed(self) -> bool:
        """Whether it is of a part that is pushed: the travel is of the whole part."""
        return self.force == "N"

    @property
    def noun(self) -> str:
        """A force, or a torque, as which moments count too."""
        return self.torque_words if self.pushed else "torque"

    @property
    def way(self) -> str:
        """A travel, or a twist, as which bends count too."""
        return self.verb if self.pushed else "twist"

    def counted(self, scales: int) -> int:
        """Return over how many pitches a load angle is counted: one for the travel of a whole part."""
        return 1 if self.pushed else scales

    def shown(self, x: float) -> str:
        """Return a load angle per pitch, or a travel, in words."""
        return units.number(1e3 * x, "mm") if self.pushed else per_pitch(x, 4)

    def size(self, value: float) -> str:
        """Return a torque or force in words."""
        factor, sign = units.prefix(value)
        return units.number(factor * value, f"{sign}N") if self.pushed else units.moment(value)

    def variable(self, role: str) -> str:
        """Return the variable of a dataset that a role becomes: "torque_c" is T_c or M_c, "theta" is theta."""
        if role.endswith(OTHER):
            return self.variable(role.removesuffix(OTHER)) + OTHER
        whole = {"s": self.place, "drop": f"{self.torque}_drop", "scales": f"{self.torque}_scales"}
        whole |= {end: f"{self.angle}_{end}" for end in ("base", "top", "residual", "jam", "most")}
        stems = {"load": self.angle, "rate": self.rate, "torque": self.torque, "tangent": self.tangent}
        head, line, tail = role.partition("_")
        return whole.get(role) or stems.get(head, head) + line + tail

    def variables(self, roles: tuple[str, ...]) -> dict[str, str]:
        """Return the variables of roles, by role, without those that this loading has not."""
        return {role: self.variable(role) for role in roles if role.removesuffix(OTHER) not in self.missing}

    def law(self, name: str) -> LawName:
        """Return the force law that is followed where ``name`` is asked: in the plane the two coincide."""
        return cast("LawName", name) if self.sided else "edge"

    def model(self, law: str = "edge", joint: str = "hinge", scales: str = THIN) -> str:
        """Say by which model a beam is answered: "thin, rigid scales on hinges, edge law"."""
        words = f"{scales} on {HELD[joint]}"
        return f"{words}, {' and '.join(law.split())} law" if self.sided and joint == "hinge" else words

    def height(self, lam: Any, neutral: str) -> Any:
        """Return the height of the scales' face over the line that a load leaves where it is, in pitches.

        That is the bar's middle in twisting, and in bending the line that keeps its length.
        """
        return lam if self.sided else lam - neutral_height(neutral, lam)

    def other_way(self, remedy: str) -> str:
        """Return advice for a negative load; none where there is no other way."""
        return f"; for the other way round write {remedy}" if self.sided else ""


_TWISTING = Load(
    *("twisting", "twist", "twisted", "phi", "Phi", "T", "K_t", "s", "twist per pitch", "twist rate", "torque", "φ"),
    read=units.twist,
    sided=True,
    axis=1,
    matrix=True,
    missing=(),
    rigidity=attrgetter("torsional_rigidity"),
    inclusion=attrgetter("C_f"),
)
_BENDING = Load(
    *("bending", "bend", "bent", "psi", "kappa", "M", "K_b", "r", "bend per pitch", "curvature", "moment", "ψ"),
    read=units.curvature,
    sided=False,
    axis=0,
    matrix=False,
    missing=("p",),
    rigidity=attrgetter("bending_rigidity"),
    inclusion=attrgetter("bending_C_f"),
)
LoadName = Literal["twisting", "bending"]
LOADS = {load.name: load for load in (_TWISTING, _BENDING)}
"""Kinds of loading by name."""


def _travel(value: object, *, pitch: float, bare: bool = True, **_: int) -> float:
    """Read a travel, over the pitch; the number of scales does not matter."""
    return units.quantity(value, units.Dimension.LENGTH, bare=bare) / pitch


_PUSHED = Load(
    *("force and travel", "travel", "pushed", "travel", "travel", "F", "stiffness", "s", "travel", "travel", "force"),
    letter="u",
    read=_travel,
    sided=False,
    axis=0,
    matrix=False,
    missing=(),
    rigidity=attrgetter("bending_rigidity"),
    inclusion=attrgetter("bending_C_f"),
    unit="m",
    force="N",
)
TESTS = LOADS | {_PUSHED.name: _PUSHED}
"""Kinds of loading of a test, by name: also that of a part, whose force is measured over the travel of its place."""
PUSHED = _PUSHED.name


def model(attrs: Mapping[str, Any]) -> str:
    """Say by which model a result was found, by its attributes; where they tell no joint it is the paper's hinge."""
    about = {**PAPER, **attrs}
    # of rows, and of both loads together, as of twisting
    said = LOADS.get(about["load"], _TWISTING).model(about["law"], about["joint"], about["scales"])
    return said + covering(attrs)


def covering(attrs: Mapping[str, Any]) -> str:
    """Say how scales lie on both faces, by a result's attributes, to be put behind other words; else nothing."""
    return f", on both faces ({attrs['faces']})" if "faces" in attrs else ""


UNIFORM = "uniform"
ModeName = Literal["uniform", "simply supported", "cantilever"]
MODES: tuple[str, ...] = get_args(ModeName)
"""How a beam swings: all pitches alike, or in the first bending mode of a bar so supported."""
FREE, COUPLE, GRIPPED, ENDLESS = "free", "couple", "gripped", "endless"
"""Words of ends: one torque or moment in all pitches, a couple at both ends, coaxial grips, none: pitches are alike."""
EndsName = Literal["free", "couple", "gripped", "equal", "endless"]
ENDS: tuple[EndsName, ...] = get_args(EndsName)
"""How the ends of a beam may be: :func:`squama.twist`."""
MANY_SCALES = 200
"""Largest number of scales of a beam whose ends are followed unasked."""
STRAINS = ("bend", "twist", "lateral bend", "stretch")
"""What a pitch of the bar does, per pitch: psi, phi, chi, epsilon."""
STRAIGHT, NOTHING = "straight", "nothing"
"""Words for what is held: all strains that are not loaded, and none, which is so where a beam says nothing."""


def hold(text: str) -> tuple[str, ...]:
    """Return which strains are held, of a text such as "bend, stretch", "straight" or "nothing".

    Raises
    ------
    InputError
        A word is not known.
    """
    words = [" ".join(part.split()) for part in text.split(",")]
    if words == [STRAIGHT]:
        return STRAINS
    if words == [NOTHING]:
        return ()
    if any(word not in STRAINS for word in words):
        names = ", ".join(map(units.shown, (*STRAINS, STRAIGHT, NOTHING)))
        refuse("", units.shown(text), f"must be some of {names}", 'write e.g. "bend, stretch"')
    return tuple(name for name in STRAINS if name in words)


def holds(text: str, load: Load) -> bool:
    """Whether what is held includes the bend of a beam that is twisted, or the twist of one that is bent."""
    return any(other.verb in hold(text) for other in LOADS.values() if other is not load)


def fixed(attrs: Mapping[str, Any]) -> str:
    """Say what is held, by a result's attributes, and which line of a hinge's bar keeps its length."""
    whole = "held straight" if attrs["load"] == "twisting" else "all else held"
    words = whole if attrs["hold"] == STRAIGHT else f"{attrs['hold']} held"
    bent = attrs["joint"] == "hinge" and "neutral" in attrs
    return f"{words}; {LINES[attrs['neutral']]}" if bent else words


def ending(ends: str) -> str:
    """Return the ends of a beam with a number of scales in words: "with free ends"."""
    words = {COUPLE: "under a couple at the ends", "equal": "with equal cells"}
    return words.get(ends, f"with {ends} ends")


def ended(attrs: Mapping[str, Any]) -> str:
    """Say of which beam a result is, by its attributes: "as an endless beam", "with free ends"."""
    return ending(attrs["ends"]) if "ends" in attrs else "as an endless beam"


def holding(held: Iterable[str]) -> str:
    """Return what is held in words: the text of :func:`hold`."""
    names = tuple(held)
    return STRAIGHT if names == STRAINS else ", ".join(names) or NOTHING


NEUTRAL = {"middle": 0.0, "face": 1.0}
"""Lines of the bar that keep their length in bending: their height over its middle, in half thicknesses.

The first is that of a homogeneous bar without axial force, which is taken where none is given.
"""
LineName = Literal["free", "middle", "face"]
LINES = {"free": "no axial force"} | {name: f"the line in the {name} of the bar keeps its length" for name in NEUTRAL}
"""How a result is headed by its line; "free": of a bar that stretches as it likes."""


def neutral_height(neutral: str, lam: Any) -> Any:
    """Return the height over the bar's middle, in pitches, of the line that keeps its length."""
    return NEUTRAL[neutral] * lam
