"""Loads and supports in words and units: "0.2 N up at tip", "10 mm down at middle", "30 N mm twist", "simple"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from squama.beam import mass
from squama.beam.design import Beam
from squama.contacts.system import PHI, PSI
from squama.contacts.ties import TURNS, Tie, X, Y, Z
from squama.errors import naming, refuse
from squama.types import Array
from squama.units import Dimension, QuantityError, quantity, shown

DIRECTIONS = {"up": Y, "down": -Y, "left": -X, "right": X, "out": Z, "in": -Z}
"""Directions of forces: up is from the bar's middle to the scaled face, out is along the bar, from root to tip."""
ANGLES = {"twist": PHI, "bend": PSI}
"""Words for a torque or moment at the ends, and for an angle between them."""
PULLS = {"tendon": -1.0, "thrust": 1.0, "pressure": 1.0}
"""Words for a tension, a thrust, or a pressure in a chamber, along a line at a height over the bar's middle; signs of
the axial force.
"""
SUPPORTS = ("clamped", "gripped", "simple")
"""Supports: the root clamped; both ends coaxial; on two rollers."""
GRAVITY = 9.81
EXAMPLES = '"0.2 N up at tip", "5 mm down at middle", "0.5 N down over all", "30 N mm twist", "3 N tendon at 4 mm"'
MANY = 12
"""Loads at most."""
LEAST, LARGEST = 1e-9, 1e6
"""Sizes of loads, SI."""
_WORDS = "|".join((*DIRECTIONS, *ANGLES, *PULLS))
_FORM = re.compile(rf"\s*(.*?)\s*\b({_WORDS})\b\s*(?:on\s+(.+?)\s*)?(?:at\s+(.+?)|(over\s+all))?\s*", re.DOTALL)
_SIMPLE = re.compile(r"\s*simple(?:\s*,?\s*span\s+(.+?))?\s*", re.DOTALL)


class Load(NamedTuple):
    """One load: its size (SI), what that measures, what is loaded, as a tie whose unit load is of size 1.

    ``given``: the deformation is imposed, not the load; ``turns``: strain by which a couple at the tip, or the angle
    of its turn, strains each cell: PHI or PSI, -1 of other loads.
    """

    words: str
    size: float
    measures: Dimension
    tie: Tie
    given: bool = False
    turns: int = -1

    @property
    def where(self) -> str:
        """The load without its size: "up at tip"."""
        return re.sub(rf".*?\b(?=({_WORDS})\b)", "", self.words, count=1).strip()


class Support(NamedTuple):
    """How a part is supported, one of :data:`SUPPORTS`; ``ends``: where rollers are, from the root in pitches."""

    word: str
    ends: tuple[float, float] = (0.0, 0.0)


def texts(given: str | Sequence[str]) -> list[str]:
    """Return the text of each load; none of what is neither a text nor a list."""
    if isinstance(given, str):
        return given.split(";")
    return list(given) if isinstance(given, list | tuple) else []


def loads(given: str | Sequence[str], beam: Beam, n: int) -> list[Load]:
    """Read the loads of a beam of n scales; refuse what is none, and those that do not go together."""
    whole = texts(given)
    if not whole or len(whole) > MANY or not all(isinstance(text, str) for text in whole):
        refuse("load", "", f"must be 1 to {MANY} texts", f"write e.g. {EXAMPLES}")
    with naming("load"):
        found = [_load(text, beam, n) for text in whole]
    imposed = [load for load in found if load.given]
    if imposed and len(found) > 1:
        why = "imposes a deformation, which stands alone"
        refuse("load", shown(imposed[0].words), why, "give forces and moments in place of it, or leave the others out")
    return found


def together(given: str | Sequence[str], on: str | None, beam: Beam, n: int) -> tuple[list[Load], Support]:
    """Read the loads and the support of a beam of n scales; refuse loads that the support does not bear."""
    held, found = support(on or SUPPORTS[0], beam, n), loads(given, beam, n)
    for load in found:
        bends, twists = load.turns == PSI, load.turns == PHI
        across = [force for _, force in load.tie.forces]
        for wrong, why, remedy in (
            (
                held.word == "gripped" and twists and len(found) > 1,
                "turns a grip, and stands alone",
                "leave others out",
            ),
            (held.word == "gripped" and bends, "bends against the grips", 'write support="clamped"'),
            (held.word == "simple" and twists, "twists a part that lies on rollers", 'write support="clamped"'),
            (held.word == "simple" and across and not across[0][1], "pushes along the rollers", 'write "up" or "down"'),
        ):
            if wrong:
                refuse("load", shown(load.words), why, remedy)
    return found, held


def _load(text: str, beam: Beam, n: int) -> Load:
    """Read one load."""
    form = _FORM.fullmatch(text) if len(text) <= 100 else None
    if form is None:
        refuse("", shown(text), "is no load", f"write e.g. {EXAMPLES}")
    number, word, chamber, place, over = form.groups()
    if chamber is not None and word != "pressure":
        refuse("", shown(text), 'has a section ("on ..."), as only a pressure has', f"write e.g. {EXAMPLES}")
    if word in ANGLES:
        return _turn(text, number, word, place or over)
    if word in PULLS:
        size = _of_chamber(text, number, chamber, beam) if word == "pressure" else _size(number, Dimension.FORCE)
        return _pull(text, size, word, place, beam)
    where = Y * 0 + DIRECTIONS[word]
    if number.strip() == "weight" or number.endswith(" weight"):
        return _weight(text, number, where, beam, n, place)
    if over:
        return Load(text, _size(number, Dimension.FORCE), Dimension.FORCE, _over_all(where, n))
    at, given = _place(place or "tip", beam, n), _is_length(number)
    kind = Dimension.LENGTH if given else Dimension.FORCE
    return Load(text, _size(number, kind), kind, Tie([(at, where)]), given)


def _over_all(where: Array, n: int) -> Tie:
    """Return a force that all cells share."""
    return Tie([(i + 0.5, where / n) for i in range(n)])


def _size(number: str, kind: Dimension) -> float:
    """Read the size of a load, which is above 0."""
    size = quantity(number, kind, bare=False)
    if not size > 0:
        refuse("", shown(number), "must be above 0", "write another direction for the other way")
    return _in_range(number, size)


def _in_range(number: str, size: float) -> float:
    """Return the size of a load; refuse one that no part bears."""
    if not LEAST <= size <= LARGEST:
        refuse("", shown(number), "is out of range (1e-9 to 1e6 in m, N or N m)", "give a smaller one")
    return size


def _is_length(number: str) -> bool:
    """Say whether a text is a length."""
    try:
        quantity(number, Dimension.LENGTH, bare=False)
    except QuantityError:
        return False
    return True


def _turn(text: str, number: str, word: str, place: str | None) -> Load:
    """Read a torque or moment at the ends, or the angle between them."""
    if place not in (None, "tip"):
        refuse("", shown(text), f"a {word} is at the tip", f'write "{number} {word}"')
    strain = ANGLES[word]
    tie = Tie(couple=TURNS[strain])
    try:
        angle = quantity(number.removesuffix("total").strip(), Dimension.ANGLE, bare=False)
    except QuantityError:
        return Load(text, _size(number, Dimension.TORQUE), Dimension.TORQUE, tie, turns=strain)
    if not 0 < angle < 100:
        refuse("", shown(text), "must be above 0 and below 100 rad", f'write e.g. "90 deg {word}"')
    return Load(text, angle, Dimension.ANGLE, tie, given=True, turns=strain)


def _of_chamber(text: str, number: str, chamber: str | None, beam: Beam) -> float:
    """Read a pressure and the sides of its chamber's section; return the thrust on the section."""
    sides = [] if chamber is None else re.split(r"\s+x\s+", chamber)
    if len(sides) != 2:
        refuse("", shown(text), "has no section of a chamber", 'write e.g. "20 kPa pressure on 10 mm x 4 mm"')
    width, height = (_size(side, Dimension.LENGTH) for side in sides)
    bar = beam.substrate
    if not (width < bar.width and height < bar.thickness):
        across = f"{1e3 * bar.width:g} mm x {1e3 * bar.thickness:g} mm"
        refuse("", shown(text), f"has a chamber that is not inside the bar of {across}", "give a smaller section")
    pressure = quantity(number, Dimension.PRESSURE, bare=False)
    if not pressure > 0:
        refuse("", shown(number), "must be above 0", 'write e.g. "20 kPa pressure on 10 mm x 4 mm"')
    return _in_range(number, pressure * width * height)


def _pull(text: str, size: float, word: str, place: str | None, beam: Beam) -> Load:
    """Read the place of a tension or thrust along a line over the bar's middle."""
    height = quantity(place or "0 mm", Dimension.LENGTH, bare=False) / beam.pitch
    half = beam.substrate.thickness / beam.pitch / 2
    if abs(height) > 2 * half:
        refuse("", shown(text), "lies farther from the bar's middle than its thickness", 'write e.g. "at 4 mm"')
    sign = PULLS[word]
    tie = Tie(carried=(-sign * height, 0.0, 0.0, sign))
    return Load(text, size, Dimension.FORCE, tie)


def _weight(text: str, number: str, where: Array, beam: Beam, n: int, place: str | None) -> Load:
    """Read the beam's own weight, or a multiple of it."""
    bar, scale = beam.density, beam.scale.density
    if place is not None:
        refuse("", shown(text), "the weight is along all of the beam", 'write e.g. "weight down"')
    if bar is None or scale is None:
        missing = "beam.density" if bar is None else "scale.density"
        refuse(
            "", shown(text), f"{missing} is not known", f'write it into the beam file, e.g. {missing} = "1150 kg/m3"'
        )
    times = quantity(number.removesuffix("weight").strip() or "1", Dimension.RATIO)
    if not times > 0:
        refuse("", shown(text), "must be above 0", 'write e.g. "weight down"')
    force = times * GRAVITY * mass.of(beam, bar, scale).mass * n * beam.pitch
    return Load(text, force, Dimension.FORCE, _over_all(where, n))


def _place(text: str, beam: Beam, n: int) -> float:
    """Read a place along the beam: from its root, in pitches."""
    words = {"tip": float(n), "middle": n / 2, "root": 0.0}
    if text.strip() in words:
        return words[text.strip()]
    if not _is_length(text):
        refuse("", shown(text), "is no place on the beam", 'write "tip", "middle", "root", or a length such as "12 mm"')
    at = quantity(text, Dimension.LENGTH, bare=False) / beam.pitch
    if not 0 <= at <= n * (1 + 1e-9):
        long = f"{1e3 * n * beam.pitch:g} mm"
        refuse(
            "", shown(text), f"is not on the beam, which is {long} long", f'write "tip", "middle", or up to "{long}"'
        )
    return min(at, float(n))


def support(text: str, beam: Beam, n: int) -> Support:
    """Read how a beam of n scales is supported."""
    if text in SUPPORTS[:2]:
        return Support(text)
    form = _SIMPLE.fullmatch(text) if isinstance(text, str) and len(text) <= 100 else None
    if form is None:
        words = f"must be one of {', '.join(map(shown, SUPPORTS))}"
        refuse("support", shown(text), words, 'write e.g. "clamped", or "simple, span 180 mm"')
    if form[1] is None:
        return Support("simple", (0.0, float(n)))
    with naming("support"):
        span = quantity(form[1], Dimension.LENGTH, bare=False) / beam.pitch
    if not 1 <= span <= n * (1 + 1e-9):
        long = f"{1e3 * n * beam.pitch:g} mm"
        refuse("support", shown(text), f"must be one pitch to {long} long", f'write e.g. "simple, span {long}"')
    return Support("simple", ((n - min(span, n)) / 2, (n + min(span, n)) / 2))


def supporting(held: Support, n: int) -> list[Tie]:
    """Return the ties of a support."""
    if held.word == "clamped":
        return []
    if held.word == "gripped":
        return [Tie(turn=(n, axis, 0 * Z)) for axis in (X, Y, Z)] + [Tie([(n, axis)]) for axis in (X, Y)]
    first, last = held.ends
    rollers = [*(Tie([(first, axis)]) for axis in (X, Y, Z)), *(Tie([(last, axis)]) for axis in (X, Y))]
    return [*rollers, Tie(turn=(round(first), Z, 0 * Z))]
