"""Columns of a table of measured points: which column holds which quantity, and its factor to SI units."""

from __future__ import annotations

from typing import NamedTuple

from squama import units
from squama.errors import InputError, Problem, Problems, refuse
from squama.io import headers, numerals, tabular
from squama.io.numerals import DecimalName
from squama.loads import LOADS, Load
from squama.units import Dimension, shown


class Ordinate(NamedTuple):
    """The quantity measured over the twist: noun, names of its column, dimension, and an example of its header cell."""

    noun: str
    names: tuple[str, ...]
    dimension: Dimension
    cell: str


TIME = Ordinate("time", ("t", "time"), Dimension.TIME, "t (s)")


def torque(load: Load) -> Ordinate:
    """Return the ordinate of a test: torque or bending moment, of a part the force."""
    names = (load.torque, load.torque_words, *([] if load.pushed else [f"{load.name} {load.torque_words}"]))
    kind = Dimension.FORCE if load.pushed else Dimension.TORQUE
    return Ordinate(load.torque_words, names, kind, f"{load.torque} ({load.force})")


class Reading(NamedTuple):
    """Settings for reading columns: load, ordinate, pitch (m), number of scales, and the decimal sign or None."""

    load: Load
    ordinate: Ordinate
    pitch: float
    scales: int
    decimal: DecimalName | None

    @property
    def example(self) -> str:
        """An example of a header."""
        unit = "mm" if self.load.pushed else "rad/m" if self.load.sided else "1/m"
        return f"{self.load.rate} ({unit}), {self.ordinate.cell}"


def over(load: Load) -> dict[str, str]:
    """Return the names of an abscissa, each with the suffix of its unit: the length over which the angle is counted."""
    if load.pushed:
        return {load.angle: ""}
    found = {load.rate: "", load.rate_words: "", load.angle: "/pitch", load.angle_words: "/pitch"}
    return found | dict.fromkeys(("total", f"total {load.verb}"), " total")


def places(table: tabular.Table, how: Reading) -> tuple[list[int], str, list[str]]:
    """Return the columns of abscissa and ordinate, the length suffix of the abscissa, and the guesses in words."""
    load, ordinate, lengths = how.load, how.ordinate, over(how.load)
    names: dict[str, list[int]] = {}
    dimensions, called_as, bare = list[str](), list[str](), set[int]()
    for i, cell in enumerate(table.header.cells):
        name, unit = headers.split(cell)
        called_as.append(name)
        bare |= set() if unit else {i}
        # phi and Phi are different quantities, but words may begin with a capital
        names.setdefault(name if len(name) < 4 else name.casefold(), []).append(i)
        dimensions.append("" if unit.endswith(("/rad", "/deg")) else str(headers.dimension(unit) or ""))
    for name in (*lengths, *ordinate.names, "specimen"):
        if len(names.get(name, [])) > 1:
            twice = headers.split(table.header.cells[names[name][1]])[0]
            raise table.error(None, f"the column {shown(twice)} is given twice", "keep one")
    # columns named after another load are not guessed to belong to this one; any torque may be called a moment
    others = [name for other in LOADS.values() for part in (over(other), torque(other).names) for name in part]
    taken = {i for name in others if name not in ("M", "moment") for i in names.get(name, [])}
    found, length, guessed, problems, several = list[int](), "", list[str](), Problems(), False
    across = (Dimension.LENGTH,) if load.pushed else (Dimension.ANGLE, Dimension.TWIST_RATE)
    for noun, known, kinds in (
        (load.rate_words, tuple(lengths), across),
        (ordinate.noun, ordinate.names, (ordinate.dimension,)),
    ):
        there = [name for name in known if name in names]
        # T may be a temperature where another column is the torque
        right = (name for name in there if names[name][0] in bare or dimensions[names[name][0]] in kinds)
        own = next(right, next(iter(there), None))
        alike = [i for i, d in enumerate(dimensions) if d in kinds and i not in taken]
        called = [i for i, name in enumerate(called_as) if i not in taken and headers.means(name, kinds)]
        # of several columns with the unit take the one with the name; without any unit the error says so
        alike = [i for i in alike if i in called] if len(alike) > 1 and set(alike) & set(called) else alike
        if not alike and ordinate.dimension not in dimensions:
            alike = called
        if own is not None:
            found += names[own]
            length = lengths.get(own, length)
        elif len(alike) == 1:
            found += alike
            whole = dimensions[alike[0]] == "angle"
            length = " total" if whole else length
            what = f"the {load.verb} of the whole beam" if whole else f"the {noun}"
            guessed.append(f"{shown(table.header.cells[alike[0]])} as {what}")
        else:
            among = shown(", ".join(table.header.cells))
            several |= bool(alike)
            reason = "several columns may be" if alike else "no column of"
            reason += f" a {noun} ({', '.join(known)}) among {among}"
            remedy = f'write a header like: {how.example}; or say which it is with columns, e.g. "2={known[-1]}"'
            problems.add("", "", reason, remedy, table.line())
    if len(problems) == 2 and not several:
        raise no_header(table, how)
    problems.settle()
    return found, length, guessed


def no_header(table: tabular.Table, how: Reading) -> InputError:
    """Return the error for a table whose header names none of the needed columns."""
    text, ordinate = shown(table.delimiter.join(table.header.cells)), how.ordinate
    what = f"the header {text} has none of the columns that are needed"
    if any(map(numerals.is_number, table.header.cells)):
        what = f"{text} are numbers where the header must stand"
    columns = f'"1={"travel (mm)" if how.load.pushed else "total (deg)"}, 2={ordinate.cell}"'
    remedy = f"write above the rows a line like: {how.example}; or give columns, e.g. {columns}"
    kinds = [headers.dimension(headers.split(cell)[1]) for cell in table.header.cells]
    if Dimension.FORCE in kinds:
        remedy = 'for force over travel of a part give its load to a fit, e.g. "1 N up at tip"'
    return table.error(None, what, remedy)


def factor(cell: str, over: str | Dimension, how: Reading) -> float:
    """Return the factor from a column to SI units; ``over``: the ordinate's dimension, or an angle's length suffix."""
    name, unit = headers.split(cell)
    where, remedy = f"column {shown(cell)}", f"write a header like: {how.example}"
    if not unit:
        refuse(where, "", "has no unit", f'{remedy}; or give its unit with columns, e.g. "{name}=total (deg)"')
    try:
        if isinstance(over, Dimension):
            return units.quantity(f"1 {unit}", over)
        try:
            return how.load.read(f"1 {unit}", pitch=how.pitch, scales=how.scales)
        except units.QuantityError:
            if not over:
                raise
            return how.load.read(f"1 {unit}{over}", pitch=how.pitch, scales=how.scales)
    except units.NoLengthError:
        reason = f"{unit} does not say over which length"
        remedy = f'write "{name} ({unit}/mm)", "{name} ({unit}/pitch)" or "total ({unit})"'
    except units.QuantityError:
        kind = how.load.rate_words if how.load.pushed else "twist or curvature"
        reason = f"{unit} is no unit of a {over if isinstance(over, Dimension) else kind}"
    raise InputError(Problem(where, "", reason, remedy)) from None
