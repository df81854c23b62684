"""All differences between twisting and bending in one table; words for models, joints, ends and held strains."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from operator import attrgetter
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeVar, cast, get_args

from squama import units
from squama.errors import refuse
from squama.people import per_pitch, readable
from squama.symbols import OTHER

if TYPE_CHECKING:
    from squama.types import Array

_N = TypeVar("_N", float, "Array")

THIN = "thin, rigid scales"
"""The paper's model of the scales, in words."""
LawName = Literal["edge", "plate"]
SenseName = Literal["+", "-"]
JointName = Literal["compliant", "hinge"]
HELD = {"hinge": "hinges", "compliant": "compliant joints"}
"""Joints of the scales in words, by the kind of joint."""
PAPER = {"joint": "hinge", "scales": THIN}
"""Attributes of results of the paper's model alone."""


class Load(NamedTuple):
    """A kind of loading with its symbols, words and units; code that differs between loads reads this table.

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
        Names of those quantities in labels and sentences.
    letter : str
        Symbol of the load angle as plain text.
    read : callable
        Function that reads a load angle per length (rad/m) from text with a unit (:mod:`squama.units`).
    sided : bool
        Whether the load has two senses and two force laws.
    axis : int
        Index of the load angle in the points (psi, phi) of a load path.
    matrix : bool
        Whether the inclusion factor is taken from the joint's stiffness matrix, where the beam has one.
    missing : tuple of str
        Roles without a variable in datasets of this load.
    rigidity, inclusion : callable
        Functions of a beam: rigidity without contact (N m^2), inclusion factor.
    unit, force : str
        SI units of the load angle and of the torque; for a pushed part of its travel (m) and its force (N).
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
    rigidity: attrgetter[float]
    inclusion: attrgetter[float]
    unit: str = "rad"
    force: str = "N m"

    @property
    def pushed(self) -> bool:
        """Whether the load is a force on a part; its travel is then that of the whole part, not of a pitch."""
        return self.force == "N"

    @property
    def noun(self) -> str:
        """General word for the load: "force", or "torque", which includes moments."""
        return self.torque_words if self.pushed else "torque"

    @property
    def way(self) -> str:
        """General word for the load angle: "travel", or "twist", which includes bends."""
        return self.verb if self.pushed else "twist"

    def counted(self, scales: int) -> int:
        """Return the number of pitches over which the load angle is counted; 1 for the travel of a whole part."""
        return 1 if self.pushed else scales

    def shown(self, x: float) -> str:
        """Return a load angle (rad per pitch) in degrees per pitch, or a travel (m) in mm, as text."""
        return units.number(1e3 * x, "mm") if self.pushed else per_pitch(x, 4)

    def size(self, value: float) -> str:
        """Return a torque (N m) or a force (N) as text for people."""
        factor, unit = readable(self.force, value)
        return units.number(factor * value, unit)

    def variable(self, role: str) -> str:
        """Return the dataset variable of a role: "torque_c" gives T_c or M_c, "theta" gives theta."""
        if role.endswith(OTHER):
            return self.variable(role.removesuffix(OTHER)) + OTHER
        whole = {"s": self.place, "drop": f"{self.torque}_drop", "scales": f"{self.torque}_scales"}
        whole |= {end: f"{self.angle}_{end}" for end in ("base", "top", "residual", "jam", "most")}
        stems = {"load": self.angle, "rate": self.rate, "torque": self.torque, "tangent": self.tangent}
        head, line, tail = role.partition("_")
        return whole.get(role) or stems.get(head, head) + line + tail

    def variables(self, roles: tuple[str, ...]) -> dict[str, str]:
        """Return the dataset variables by role, without roles that this load does not have."""
        return {role: self.variable(role) for role in roles if role.removesuffix(OTHER) not in self.missing}

    def law(self, name: str) -> LawName:
        """Return the force law used for the requested one: bending has only "edge", because both laws agree there."""
        return cast("LawName", name) if self.sided else "edge"

    def model(self, law: str = "edge", joint: str = "hinge", scales: str = THIN) -> str:
        """Return the model in words, such as "thin, rigid scales on hinges, edge law"."""
        words = f"{scales} on {HELD[joint]}"
        return f"{words}, {' and '.join(law.split())} law" if self.sided and joint == "hinge" else words

    def height(self, lam: _N, neutral: str) -> _N:
        """Return the height (pitches) of the scaled face over the axis of the load.

        The axis is the bar's middle in twisting, and in bending the line that keeps its length.
        """
        return lam if self.sided else lam - neutral_height(neutral, lam)

    def other_way(self, remedy: str) -> str:
        """Return the advice for a negative load, to be appended to a message; "" in bending, which has one sense."""
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
"""Kinds of loading of a beam, by name."""


def _travel(value: object, *, pitch: float, bare: bool = True, **_: int) -> float:
    """Return a travel (text or m) over the pitch; the number of scales does not matter."""
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
"""Kinds of loading of a test, by name: those of a beam, and a force on a part, measured over its travel."""
PUSHED = _PUSHED.name


def model(attrs: Mapping[str, object]) -> str:
    """Return the model of a result in words, from its attributes; without a joint among them, the paper's hinges."""
    about = {**PAPER, **attrs}
    load, law, joint, scales = (str(about[name]) for name in ("load", "law", "joint", "scales"))
    # rows, and bending with twisting, are described as twisting
    said = LOADS.get(load, _TWISTING).model(law, joint, scales)
    return said + covering(attrs)


def covering(attrs: Mapping[str, object]) -> str:
    """Return the words for scales on both faces, from a result's attributes, to be appended; "" for one face."""
    return f", on both faces ({attrs['faces']})" if "faces" in attrs else ""


UNIFORM = "uniform"
ModeName = Literal["uniform", "simply supported", "cantilever"]
MODES: tuple[str, ...] = get_args(ModeName)
"""Shapes of vibration: all pitches alike, or the first bending mode of a simply supported bar or a cantilever."""
FREE, COUPLE, GRIPPED, ENDLESS = "free", "couple", "gripped", "endless"
"""Words for the ends of a beam: one torque or moment in all pitches, a couple at both ends, coaxial grips, no ends."""
EndsName = Literal["free", "couple", "gripped", "equal", "endless"]
ENDS: tuple[EndsName, ...] = get_args(EndsName)
"""Allowed ends of a beam, see :func:`squama.twist`."""
MANY_SCALES = 200
"""Largest number of scales for which the finite row is computed without being requested."""
STRAINS = ("bend", "twist", "lateral bend", "stretch")
"""Strains of the bar per pitch: psi, phi, chi, epsilon."""
STRAIGHT, NOTHING = "straight", "nothing"
"""Words for held strains: all strains that are not loaded; none, the default of a beam."""


def hold(text: str) -> tuple[str, ...]:
    """Return the names of the held strains in a text such as "bend, stretch", "straight" or "nothing".

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
    """Return whether a text of held strains includes the bend of a twisted beam, or the twist of a bent one."""
    return any(other.verb in hold(text) for other in LOADS.values() if other is not load)


def fixed(attrs: Mapping[str, object]) -> str:
    """Return a result's held strains in words, from its attributes, and the line of a hinged bar that keeps length."""
    whole = "held straight" if attrs["load"] == "twisting" else "all else held"
    words = whole if attrs["hold"] == STRAIGHT else f"{attrs['hold']} held"
    bent = attrs["joint"] == "hinge" and "neutral" in attrs
    return f"{words}; {LINES[str(attrs['neutral'])]}" if bent else words


def ending(ends: str) -> str:
    """Return the ends of a finite beam in words, such as "with free ends"."""
    words = {COUPLE: "under a couple at the ends", "equal": "with equal cells"}
    words |= {mode: f"of a {mode} bar" for mode in MODES[1:]}
    return words.get(ends, f"with {ends} ends")


def holding(held: Iterable[str]) -> str:
    """Return the text of held strains, which :func:`hold` reads back."""
    names = tuple(held)
    return STRAIGHT if names == STRAINS else ", ".join(names) or NOTHING


NEUTRAL = {"middle": 0.0, "face": 1.0}
"""Height of the line that keeps its length in bending over the bar's middle, in half thicknesses, by its name.

The first is that of a homogeneous bar without axial force, and the default.
"""
LineName = Literal["free", "middle", "face"]
LINES = {"free": "no axial force"} | {name: f"the line in the {name} of the bar keeps its length" for name in NEUTRAL}
"""Words for the line that keeps its length in the head of a result; "free" is a bar without axial force."""


def neutral_height(neutral: str, lam: _N) -> _N:
    """Return the height of the line that keeps its length over the bar's middle, in pitches; ``lam`` is t/d."""
    return NEUTRAL[neutral] * lam
