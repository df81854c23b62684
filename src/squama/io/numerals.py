"""Numbers as laboratories write them: decimal points or commas, marks between thousands, cells without a value."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Literal, NamedTuple

from squama.errors import InputError, Problem, refuse
from squama.io import tabular
from squama.units import shown

_WORDS = "nan na n/a n.a. null none - -- --- \N{EN DASH} \N{EM DASH} *"
_ERRORS = "#n/a #na #nv #value! #wert! #valeur! #div/0! #ref! #bezug! #num! #zahl! #nombre! #name? #null!"
GAPS = frozenset(f"{_WORDS} {_ERRORS}".split())
"""What stands, apart from nothing, in a cell that has no value; small letters."""
_ALIKE = str.maketrans(
    {"\N{MINUS SIGN}": "-", "\N{RIGHT SINGLE QUOTATION MARK}": "'"}
    | dict.fromkeys("\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}\N{THIN SPACE}", " ")
)
_PLAIN = re.compile(r"[+-]?(?:\d+(?:([.,])\d*)?|([.,])\d+)(?:[eE][+-]?\d+)?")
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}([ '.,])\d{3}(?:\1\d{3})*(?:(?!\1)([.,])\d*)?")
_WHOLE = re.compile(r"[+-]?[1-9]\d{2}")
_MARKS = {",": "commas", ".": "points", " ": "spaces", "'": "apostrophes"}


DecimalName = Literal[".", ","]


class Style(NamedTuple):
    """How numbers are written: the decimal sign, and what stands between thousands ("" if nothing does)."""

    decimal: str = "."
    group: str = ""

    def said(self, *, given: bool) -> list[str]:
        """Return what was guessed, in words; the decimal sign may be ``given``."""
        commas = ["with decimal commas"] * (self.decimal == "," and not given)
        return commas + ([f"with {_MARKS[self.group]} between thousands"] if self.group else [])


def is_gap(cell: str) -> bool:
    """Say whether a cell has no value.

    >>> [is_gap(cell) for cell in ("", " - ", "#N/A", "NaN", "0", "-1")]
    [True, True, True, True, False, False]
    """
    text = cell.strip()
    return not text or text.casefold() in GAPS


def is_number(cell: str) -> bool:
    """Say whether a cell is a number in some style.

    >>> [is_number(cell) for cell in ("1.5e3", "1.234,5", "1 234,5", "1'234.5", "1,23,4", "T")]
    [True, True, True, True, False, False]
    """
    text = _cleaned(cell)
    return bool(_PLAIN.fullmatch(text) or _GROUPED.fullmatch(text))


def style(columns: Sequence[Sequence[str]], given: DecimalName | None = None) -> Style:
    """Return how the numbers of columns are written; the decimal sign may be ``given``.

    One mark before three digits may be either: it separates thousands where a whole number of three digits stands in
    the same column, as in 900, 950, 1,000.

    >>> style([["0", "12,5"]]), style([["900", "1,000"]]), style([["1.234,5", "0,125"]])
    (Style(decimal=',', group=''), Style(decimal='.', group=','), Style(decimal=',', group='.'))
    """
    if given is not None and given not in (".", ","):
        refuse("decimal", shown(given), 'must be "." or ","')
    decimals, groups, either = set[str](), set[str](), set[str]()
    for column in columns:
        texts = [_cleaned(cell) for cell in column]
        hundreds = any(map(_WHOLE.fullmatch, texts))
        for text in texts:
            plain, grouped = _PLAIN.fullmatch(text), _GROUPED.fullmatch(text)
            if plain and not grouped:
                decimals |= {plain[1] or plain[2]} - {None}
            elif grouped and (not plain or hundreds):
                groups.add(grouped[1])
                decimals |= {grouped[2]} - {None}
            elif grouped:
                either.add(grouped[1])
    decimal = given or _decimal(decimals, groups, either)
    return Style(decimal, min((groups | either) - {decimal}, default=""))


def _decimal(decimals: set[str], groups: set[str], either: set[str]) -> str:
    """Return the decimal sign from signs that are decimal, that group thousands, and that may do either."""
    if decimals:
        return "," if decimals == {","} else "."
    if "." in groups or "," in groups:
        return "," if "." in groups else "."
    return "," if either == {","} else "."


def number(cell: str, written: Style, gap: str = "") -> float:
    """Read a number; ``gap`` as in :func:`tabular.number`.

    >>> number("1,25e3", Style(",")), number("-.5", Style()), number("1 234,5", Style(",", " "))
    (1250.0, -0.5, 1234.5)
    """
    text = _cleaned(cell)
    if (grouped := _GROUPED.fullmatch(text)) and grouped[1] == written.group and grouped[2] in (None, written.decimal):
        text = text.replace(written.group, "")
    if written.decimal == ",":
        if "." in text and is_number(text):
            reason = "has a point, but decimals are set off by commas here"
            raise InputError(Problem("", shown(cell.strip()), reason, f"write {text.replace('.', ',')}"))
        text = text.replace(",", ".")
    return tabular.number(text, gap=gap)


def _cleaned(cell: str) -> str:
    return cell.translate(_ALIKE).strip()
