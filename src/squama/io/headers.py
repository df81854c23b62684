"""Headers of tables: names of quantities in English, German and French, and units with or without brackets."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache

from squama.io import numerals
from squama.units import Dimension, look_up

NAMES = {
    Dimension.ANGLE: "angle, twist, twist angle, angle of twist, torsion angle, rotation, rotation angle, bend angle,"
    "winkel, drehwinkel, verdrehwinkel, torsionswinkel, biegewinkel, verdrehung, rotation, position,"
    "angle de torsion, angle de rotation, angle de flexion",
    Dimension.TORQUE: "torque, moment, torsional moment, bending moment, Mt, Md, Mz, Mb, drehmoment, torsionsmoment,"
    "biegemoment, couple, moment de torsion, moment de flexion, M, T",
    Dimension.TWIST_RATE: "twist rate, curvature, drillung, kr\u00fcmmung, kruemmung, courbure",
    Dimension.LENGTH: "travel, displacement, deflection, extension, stroke, crosshead, position, weg, verschiebung,"
    "durchbiegung, traversenweg, standardweg, d\u00e9placement, fl\u00e8che",
    Dimension.FORCE: "force, load, F, kraft, standardkraft, charge",
    Dimension.TIME: "time, elapsed time, t, zeit, laufzeit, temps",
}
"""Names of columns in laboratories, by dimension."""
MEASURED = tuple(NAMES)
_WORDS: dict[Dimension, frozenset[str]] = {
    kind: frozenset(word.strip() for word in words.split(",")) for kind, words in NAMES.items()
}
_LONGEST = 200
"""Largest number of characters of a cell with a unit."""
_BRACKETS = re.compile(r"[(\[{<](.*)[)\]}>]")
_CELL = re.compile(r"(.*?)\s*(?:\((.*)\)|\[(.*)\]|\{(.*)\}|<(.*)>)")
_BEFORE_UNIT = re.compile(r"\s+in\s+|\s*[/,:_]\s*|\s+|(?=\u00b0)")
_TIMES = ("s", "ms", "us", "\u00b5s", "min", "h")
"""Units of time; others, such as a and d, are more likely letters."""
_SYMBOLS = {"U": "rev", "Umdr": "rev", "Umdr.": "rev", "tr": "rev", "Grad": "deg", "grad": "deg", "degr\u00e9s": "deg"}
_SYMBOLS |= {"Sekunden": "s", "Sek.": "s", "sec": "s"}
"""Other spellings of units that as symbols would have another meaning or none."""


def split(cell: str) -> tuple[str, str]:
    """Return name and unit of a header's cell; the unit is empty if missing.

    >>> split("Phi (deg/mm)"), split("Winkel in Grad"), split("Drehmoment_Nm"), split("T")
    (('Phi', 'deg/mm'), ('Winkel', 'deg'), ('Drehmoment', 'Nm'), ('T', ''))
    """
    text = " ".join(cell.split())
    if len(text) > _LONGEST:
        return text, ""
    if match := _CELL.fullmatch(text):
        return match[1], symbol(next(filter(None, match.groups()[1:]), ""))
    for between in _BEFORE_UNIT.finditer(text):
        name, unit = text[: between.start()], symbol(text[between.end() :])
        if name and dimension(unit):
            return name, unit
    return text, ""


def symbol(text: str) -> str:
    """Return the symbol of a unit, without brackets."""
    text = text.strip()
    match = _BRACKETS.fullmatch(text) if len(text) <= _LONGEST else None
    text = (match[1] if match else text).strip()
    return _SYMBOLS.get(text, text)


@lru_cache(1000)
def dimension(unit: str) -> Dimension | None:
    """Return the dimension of a unit, one of :data:`MEASURED`; None for any other."""
    found = look_up(unit) if unit else None
    if not found or found[0] not in MEASURED or (found[0] is Dimension.TIME and unit not in _TIMES):
        return None
    return found[0]


def means(name: str, kinds: Sequence[Dimension]) -> bool:
    """Return whether a name belongs to one of the quantities, in a known language."""
    # T and t, M and m are different quantities
    return any((name if len(name) < 3 else name.casefold()) in _WORDS[kind] for kind in kinds)


def is_time(name: str, unit: str) -> bool:
    """Return whether a column of this name and unit holds times."""
    return dimension(unit) is Dimension.TIME or (not unit and means(name, [Dimension.TIME]))


def named(cell: str) -> bool:
    """Return whether a header's cell names a quantity, or has the unit of one."""
    name, unit = split(cell)
    return bool(name and dimension(unit)) or means(name, MEASURED)


def units(cells: Sequence[str]) -> bool:
    """Return whether a row holds units and no numbers."""
    return not any(map(numerals.is_number, cells)) and any(dimension(symbol(cell)) for cell in cells)
