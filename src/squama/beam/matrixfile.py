"""The stiffness matrix of a scale's joint as a file: nine rows and columns with units, and the beam it was made for.

The file is CSV, with a row for each force on the scale (F along n_X, n_Y, n_Z, moments M about them), the torque T, the
moment M and the tension, and a column for each motion (u_X .. w_Z), the twist phi, the bend psi and the elongation of a
pitch. An entry is the force of its row for the motion of its column while all other motions are held. Files with seven
rows lack bend and elongation and are for bars that are neither bent nor stretched. Comments name the beam for which the
matrix was made, with the keys of the beam file:

    # scale.embedded = "4.5 mm"
"""

from __future__ import annotations

import functools
import math
import os
import re
from collections.abc import Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING

from squama.beam.beamfile import NUMBERS
from squama.errors import naming, refuse
from squama.io import files, tabular
from squama.units import UNITS, Dimension, as_text, look_up, quantity, shown

if TYPE_CHECKING:
    from squama.types import Array

MOTIONS = ("u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z")
"""Motions of a scale in the order of the rows: displacements along its axes, rotations about them."""
VARIABLES = (*MOTIONS, "phi", "psi", "elongation")
"""Columns in their order; matrices of seven columns lack the last two."""
FORCES = ("F_X", "F_Y", "F_Z", "M_X", "M_Y", "M_Z", "T", "M", "tension")
"""Rows in their order: the forces and moments that belong to the :data:`VARIABLES`."""
SIZES = (7, 9)
"""Allowed numbers of rows: without bend and elongation, and with them."""
_LENGTHS = (0, 1, 2, 8)
"""Indices of the variables that are lengths."""
SHAPE = (
    "scale.embedded",
    "scale.width",
    "scale.thickness",
    "scale.alpha",
    "scale.theta0",
    "substrate.width",
    "substrate.thickness",
    "substrate.poisson_ratio",
)
"""Keys of the beam file on which the matrix depends, in units of the pitch and of the substrate's modulus."""
TAB = ("scale.youngs_modulus", "scale.poisson_ratio")
"""Further keys on which it depends if the embedded part bends; the modulus in units of the substrate's."""
SCALING = ("beam.pitch", "substrate.youngs_modulus")
"""Keys by which the matrix is scaled to another beam of the same shape."""
NEAR = 1e-6
"""Largest relative difference of two values that count as equal."""
_NEWTON = {"N": 1.0, "kN": 1e3, "mN": 1e-3}
_CELL = re.compile(r"\s*([A-Za-z]+(?:_[XYZ])?)\s*\(([^()]+)\)\s*")
_MADE = re.compile(r"#\s*([a-z]+\.[a-z0-9_]+)\s*=\s*(.+)")
_COLUMNS = [f"{name} ({'m' if i in _LENGTHS else 'rad'})" for i, name in enumerate(VARIABLES)]
_ROWS = [f"{name} ({'N' if i in _LENGTHS else 'N m'})" for i, name in enumerate(FORCES)]


class StoredMatrix:
    """Stiffness matrix of a joint as stored in a file; frozen, and equal to another one with the same numbers.

    ``rows`` (7, 7) or (9, 9) are over :data:`VARIABLES`, in N, m and rad. ``made`` describes the beam it was made for,
    SI values by "table.key", at least those of :data:`SCALING`; ``name`` is the file's name in messages. A matrix that
    is not symmetric or not positive definite is refused.
    """

    __slots__ = ("__dict__", "made", "name", "rows")

    def __init__(self, rows: object, made: Mapping[str, float], name: str = "matrix") -> None:
        import numpy as np

        table = np.asarray(rows, float)
        self.rows = tuple(map(tuple, table.tolist()))
        self.made = {key: float(made[key]) for key in (*SCALING, *SHAPE, *TAB) if key in made}
        self.name = name
        _check(table, name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, StoredMatrix) and (self.rows, self.made) == (other.rows, other.made)

    def __hash__(self) -> int:
        return hash(self.rows)

    def __repr__(self) -> str:
        return f"<stiffness of a joint from {self.name}>"

    def __str__(self) -> str:
        return self.text

    def __deepcopy__(self, memo: object) -> StoredMatrix:
        return self

    def tolist(self) -> list[list[float]]:
        """Return the rows in SI units as lists, for JSON."""
        return [list(row) for row in self.rows]

    @functools.cached_property
    def K(self) -> Array:
        """Matrix (7, 7) or (9, 9) in units of pitch and substrate modulus of the beam it was made for."""
        import numpy as np

        lengths, unit = _scales(self.made, len(self.rows))
        K = np.array(self.rows) * lengths / unit
        return np.asarray((K + K.T) / 2)

    @functools.cached_property
    def K_theta(self) -> float:
        """Stiffness against inclination, over E d^3."""
        return inclination_stiffness(self.K[:7, :7])

    def rigidity(self, free: Sequence[int], seen: Sequence[int] = (), own: Sequence[float] = ()) -> float:
        """Return the torque over the twist per pitch without contact, over E d^3; see :func:`twisting_stiffness`."""
        return twisting_stiffness(self.K, free, seen, own)

    @property
    def text(self) -> str:
        """Text of the file; :func:`parse` reads back the same numbers, to the last bit."""
        lines = ["# stiffness of a scale's joint: force of a row for the motion of a column, the others held; made for"]
        for name, value in self.made.items():
            written = as_text(value, NUMBERS[name][0])
            lines.append(f"# {name} = " + (written if NUMBERS[name][0] is Dimension.RATIO else f'"{written}"'))
        n = len(self.rows)
        lines.append(",".join(("force", *_COLUMNS[:n])))
        lines += [f"{name},{','.join(map(repr, row))}" for name, row in zip(_ROWS[:n], self.rows, strict=True)]
        return "\n".join(lines) + "\n"

    def differences(self, values: Mapping[str, float]) -> list[tuple[str, float, float]]:
        """Return the shape parameters that differ from those the matrix was made for: key, value made for, value given.

        Lengths are compared in units of the pitch, moduli in the substrate's; ``values`` and the result are SI, by
        "table.key".
        """
        found, units = [], dict(zip((Dimension.LENGTH, Dimension.PRESSURE), SCALING, strict=True))
        for key in (*SHAPE, *TAB):
            if key in self.made:
                unit = units.get(NUMBERS[key][0])
                own, other = (v[key] / (v[unit] if unit else 1) for v in (self.made, values))
                if not math.isclose(own, other, rel_tol=NEAR):
                    found.append((key, self.made[key], values[key]))
        return found


def made_for(beam: object, *, tab: bool = True) -> dict[str, float]:
    """Return the values (SI, by "table.key") on which a beam's matrix depends; with ``tab`` also the scale's moduli.

    A scale without a modulus is rigid: its modulus is infinite.
    """
    keys = (*SCALING, *SHAPE, *TAB * tab)
    values = {name: attrgetter(name.removeprefix("beam."))(beam) for name in keys}
    values["scale.poisson_ratio"] = attrgetter("scale.nu")(beam)
    return {name: math.inf if values[name] is None else float(values[name]) for name in keys}


def stored(beam: object, K: Array, name: str = "matrix", *, tab: bool = False) -> StoredMatrix:
    """Return a matrix (7, 7) or (9, 9), in units of pitch and substrate modulus, as :class:`StoredMatrix` in SI units.

    ``tab``: the embedded part bends, with the modulus of the beam's scales.
    """
    made = made_for(beam, tab=tab)
    lengths, unit = _scales(made, len(K))
    return StoredMatrix(K * unit / lengths, made, name)


def _scales(made: Mapping[str, float], n: int) -> tuple[Array, float]:
    """Return the products of lengths (n, n) that scale the entries, and E d^3."""
    import numpy as np

    d, E = (made[key] for key in SCALING)
    lengths = np.array([d if i in _LENGTHS else 1.0 for i in range(n)])
    return np.outer(lengths, lengths), E * d**3


def freed(K: Array) -> Array:
    """Return the stiffness (n,) against each variable of a matrix (n, n) with all other variables free."""
    import numpy as np

    return np.asarray(1 / np.diag(np.linalg.inv(K)))


def inclination_stiffness(K: Array, motion: int = 4) -> float:
    """Return the stiffness against a turn about n_Y at fixed twist, the scale's other motions free.

    ``motion`` is the row of that turn; the last row of K is the twist.
    """
    return float(freed(K[:-1, :-1])[motion])


def twisting_stiffness(
    K: Array, free: Sequence[int] = (), seen: Sequence[int] = (), own: Sequence[float] = ()
) -> float:
    """Return the torque over the twist per pitch, with the scale's motions free.

    The twist is the last row of K, or the seventh of nine. ``free``: flags of the free strains bend, twist, lateral
    bend and stretch, for K (9, 9); none by default. For scales on both faces ``seen`` and ``own`` are those of
    :func:`of_strains`.
    """
    import numpy as np

    twist = 6 if len(K) == 9 else len(K) - 1
    if len(seen):
        K, twist, free = of_strains(K, seen, own), 0, free if len(K) == 9 else ()
        loose = [row - 6 for row in loose_rows(free)]
    else:
        loose = [*range(twist), *loose_rows(free)]
    across = K[loose, twist]
    return float(K[twist, twist] - across @ np.linalg.solve(K[np.ix_(loose, loose)], across))


def of_strains(K: Array, seen: Array | Sequence[int], own: Array | Sequence[float]) -> Array:
    """Return the stiffness (..., s, s) against twist, bend and stretch with scales on both faces, free to move.

    ``K`` (..., 6 + s, 6 + s) is that of one face. ``seen`` (..., 3) are the signs of bend, twist and lateral bend on
    the other face; ``own`` (..., 4) is the bar's own stiffness against bend, twist, lateral bend and stretch, which
    each K includes once.
    """
    import numpy as np

    s = K.shape[-1] - 6
    across, signs, bar = K[..., :6, 6:], np.ones((*K.shape[:-2], s)), np.zeros((*K.shape[:-2], s), K.dtype)
    alone = K[..., 6:, 6:] - np.swapaxes(across, -1, -2) @ np.linalg.solve(K[..., :6, :6], across)
    for row, (sees, strain) in enumerate(((1, 1), (0, 0), (None, 3))[:s]):
        bar[..., row] = np.asarray(own)[..., strain]
        if sees is not None:
            signs[..., row] = np.asarray(seen)[..., sees]
    return np.asarray(alone * (1 + signs[..., None] * signs[..., None, :]) - bar[..., None] * np.eye(s))


def loose_rows(free: Sequence[int]) -> list[int]:
    """Return the rows in K (9, 9) of the free strains bend and stretch; the lateral bend, being the bar's, has none."""
    return [row for row, loose in zip((7, None, None, 8), free, strict=False) if loose and row]


def read(path: str | os.PathLike[str]) -> StoredMatrix:
    """Read a matrix from its CSV file; refuse a file that cannot be read or is not such a matrix."""
    return _parsed(tabular.read(path, missing="write it with: squama joint beam.toml --matrix joint.csv"))


def parse(text: str) -> StoredMatrix:
    """Read a matrix from the text of its file; errors as from :func:`read`."""
    return _parsed(tabular.parse(text, "matrix"))


def write(matrix: StoredMatrix, path: str | os.PathLike[str]) -> Path:
    """Write a matrix to a file, which is complete or not there at all."""
    return files.atomic_write(path, lambda place: place.write_text(matrix.text, encoding="utf-8"))


def _parsed(table: tabular.Table) -> StoredMatrix:
    import numpy as np

    head = table.header
    if (n := len(head.cells) - 1) not in SIZES or len(table.rows) != n:
        have = f"has {len(table.rows)} rows and {max(len(head.cells) - 1, 0)} columns of numbers"
        refuse("", "", have, f"a joint's matrix has 9 and 9 (or the first 7), over {', '.join(VARIABLES)}", table.name)
    motions = [_unit(table, head.line, cell, i, _COLUMNS) for i, cell in enumerate(head.cells[1:])]
    read_cell = functools.partial(tabular.number, example="1234.5")
    columns = {motion: (i, read_cell) for i, motion in enumerate(VARIABLES[:n], start=1)}
    rows, values, problems = tabular.numbers(table, columns, "force")
    problems.settle()
    forces = [[_unit(table, row.line, row.cells[0], i, _ROWS)] for i, row in enumerate(rows)]
    return StoredMatrix(np.array(values) * forces / motions, _made(table), table.name)


def _unit(table: tabular.Table, line: int, cell: str, i: int, names: list[str]) -> float:
    """Return the SI factor of the unit of row or column i; refuse a wrong one. ``names``: all, with SI units."""
    match = _CELL.fullmatch(cell)
    name, si = names[i].rstrip(")").split(" (")
    if match is None or match[1] != name:
        reason, order = f"must be {name} with its unit, as {names[i]}", ", ".join(n.partition(" ")[0] for n in names)
        raise table.error(line, reason, f"the order is {order}", shown(cell.strip()))
    unit = match[2].strip()
    factor = _NEWTON.get(unit) if si == "N" else None
    if si != "N" and (found := look_up(unit)) is not None and found[0] is UNITS[si][0]:
        factor = found[1] / found[2]
    if factor is None:
        raise table.error(line, "has no unit that fits", f"write e.g. {names[i]}", shown(cell.strip()))
    return factor


def _made(table: tabular.Table) -> dict[str, float]:
    """Return the values (SI, by "table.key") in a file's comments for which the matrix was made."""
    made = {}
    for line in table.comments:
        match = _MADE.fullmatch(line)
        if match is not None and match[1] in (*SCALING, *SHAPE, *TAB):
            with naming(f"# {match[1]}", table.name):
                made[match[1]] = quantity(match[2].strip().strip('"'), NUMBERS[match[1]][0], bare=False)
    if missing := [key for key in SCALING if not made.get(key, 0) > 0]:
        example = f"# {missing[0]} = {NUMBERS[missing[0]][1].example}"
        remedy = f"write a line above the header: {example}"
        refuse("", "", "does not say what it was made for", remedy, table.name)
    return made


def _check(table: Array, name: str) -> None:
    """Refuse a matrix that is not symmetric or not positive definite."""
    import numpy as np

    diagonal = np.diag(table)
    if not (diagonal > 0).all():
        i = int(np.flatnonzero(~(diagonal > 0))[0])
        entry = f"{FORCES[i]} by {VARIABLES[i]} is {diagonal[i]:.4g}, must be above 0"
        refuse("", "", f"is not positive definite: {entry}", source=name)
    scaled = table / np.sqrt(np.outer(diagonal, diagonal))
    apart = np.abs(scaled - scaled.T)
    if apart.max() > NEAR:
        i, j = (int(k) for k in np.unravel_index(int(apart.argmax()), apart.shape))
        both = ", ".join(f"{FORCES[a]} by {VARIABLES[b]} is {table[a, b]:.6g}" for a, b in ((i, j), (j, i)))
        refuse("", "", f"is not symmetric: {both}", "both must be the same", name)
    least = float(np.linalg.eigvalsh((scaled + scaled.T) / 2).min())
    if least <= 1e-9:
        reason = "is not positive definite, so some motion would need no force or give energy away"
        about = f"least eigenvalue {least:.2g} with the diagonal scaled to 1"
        refuse("", "", f"{reason} ({about})", "check its entries", name)
