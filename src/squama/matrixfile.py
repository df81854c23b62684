"""The stiffness of a scale's joint as a file: seven rows and columns with units, and the beam that it was made for.

A table of text (CSV) with a row for each force on the scale (F along n_X, n_Y, n_Z, moments M about them, and the
torque T) and a column for each motion (u_X .. w_Z, and phi, the twist per pitch); an entry is the force that the motion
takes while all others are held. Comments name what it was made for, as in a beam file:

    # scale.embedded = "4.5 mm"
"""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from squama import beamfile, files, tabular
from squama.errors import InputError
from squama.unit_table import Dimension, look_up
from squama.units import QuantityError, as_text, quantity, shown

if TYPE_CHECKING:
    from squama.model.solve import Array

MOTIONS = ("u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z", "phi")
"""Columns in their order; the first three are lengths, the others angles."""
FORCES = ("F_X", "F_Y", "F_Z", "M_X", "M_Y", "M_Z", "T")
"""Rows in their order; the first three are forces, the others moments."""
SHAPE = (
    "scale.embedded", "scale.width", "scale.thickness", "scale.alpha", "scale.theta0", "substrate.width",
    "substrate.thickness", "substrate.poisson_ratio",
)  # fmt: skip
"""Keys of the beam file that the matrix depends on, in units of the pitch and of the substrate's modulus."""
SCALING = ("beam.pitch", "substrate.youngs_modulus")
"""Keys by which it is scaled to a beam of the same shape."""
NEAR = 1e-6
"""Relative difference at which two values count as equal."""
_NEWTON = {"N": 1.0, "kN": 1e3, "mN": 1e-3}
_CELL = re.compile(r"\s*([A-Za-z]+(?:_[XYZ])?)\s*\(([^()]+)\)\s*")
_MADE = re.compile(r"#\s*([a-z]+\.[a-z0-9_]+)\s*=\s*(.+?)\s*")
_HEADER = "force," + ",".join(f"{name} ({'m' if i < 3 else 'rad'})" for i, name in enumerate(MOTIONS))
_ROWS = [f"{name} ({'N' if i < 3 else 'N m'})" for i, name in enumerate(FORCES)]


class Different(NamedTuple):
    """A value for which a matrix was made, and that of a beam, both SI."""

    key: str
    made: float
    here: float


class StoredMatrix:
    """A stiffness matrix as it stands in a file; frozen, equal where the numbers are.

    Parameters
    ----------
    rows : 7 sequences of 7 floats
        Stiffness over the six motions and the twist per pitch: N, m and rad.
    made : mapping
        What it was made for: SI values by "table.key"; ``beam.pitch`` and ``substrate.youngs_modulus`` at least.
    name : str
        The file, for messages.

    Raises
    ------
    InputError
        Not symmetric, or not positive definite.
    """

    __slots__ = ("__dict__", "made", "name", "rows")

    def __init__(self, rows: object, made: Mapping[str, float], name: str = "matrix") -> None:
        import numpy as np

        table = np.asarray(rows, float)
        self.rows = tuple(map(tuple, table.tolist()))
        self.made = {key: float(made[key]) for key in (*SCALING, *SHAPE) if key in made}
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
        """Return the rows in SI, as JSON takes them."""
        return [list(row) for row in self.rows]

    @functools.cached_property
    def K(self) -> Array:
        """The matrix (7, 7) in units of the pitch and of the substrate's modulus that it was made for."""
        import numpy as np

        d, E = (self.made[key] for key in SCALING)
        unit = np.array([d, d, d, 1.0, 1.0, 1.0, 1.0])
        K = np.array(self.rows) * np.outer(unit, unit) / (E * d**3)
        return np.asarray((K + K.T) / 2)

    @functools.cached_property
    def K_theta(self) -> float:
        """Moment about n_Y over the turn about n_Y with the other motions free, no twist; E d^3."""
        import numpy as np

        return float(1 / np.linalg.inv(self.K[:6, :6])[4, 4])

    @functools.cached_property
    def rigidity(self) -> float:
        """Torque over the twist per pitch with the scale free; E d^3."""
        import numpy as np

        K = self.K
        return float(K[6, 6] - K[6, :6] @ np.linalg.solve(K[:6, :6], K[:6, 6]))

    @property
    def text(self) -> str:
        """The file's text; :func:`parse` reads back the same numbers, to the last bit."""
        lines = ["# stiffness of a scale's joint: force of a row for the motion of a column, the others held; made for"]
        for name, value in self.made.items():
            table, _, key = name.partition(".")
            dimension = beamfile.TABLES[table][key].dimension
            assert dimension is not None
            written = as_text(value, dimension)
            lines.append(f"# {name} = " + (written if dimension is Dimension.RATIO else f'"{written}"'))
        lines.append(_HEADER)
        lines += [f"{name},{','.join(map(repr, row))}" for name, row in zip(_ROWS, self.rows, strict=True)]
        return "\n".join(lines) + "\n"

    def differences(self, values: Mapping[str, float]) -> list[Different]:
        """Return where the shape for which it was made differs from another, in units of the pitch.

        Parameters
        ----------
        values : mapping
            SI values by "table.key", those of :data:`SHAPE` and ``beam.pitch``.
        """
        found = []
        for key in SHAPE:
            if key not in self.made:
                continue
            table, _, name = key.partition(".")
            length = beamfile.TABLES[table][name].dimension is Dimension.LENGTH
            own, other = (v[key] / (v["beam.pitch"] if length else 1) for v in (self.made, values))
            if abs(own - other) > NEAR * max(abs(own), abs(other)):
                found.append(Different(key, self.made[key], values[key]))
        return found


def read(path: str | os.PathLike[str]) -> StoredMatrix:
    """Read a matrix from a file.

    Raises
    ------
    InputError
        The file cannot be read or is no such matrix: its shape, units or numbers, not symmetric, not positive definite.
    """
    return _parsed(tabular.read(path, missing="write it with: squama joint beam.toml --matrix joint.csv"))


def parse(text: str) -> StoredMatrix:
    """Read a matrix from the text of its file; errors as from :func:`read`."""
    return _parsed(tabular.parse(text, "matrix"))


def write(matrix: StoredMatrix, path: str | os.PathLike[str]) -> Path:
    """Write a matrix; the file is complete or not there at all."""
    return files.atomic_write(path, lambda place: place.write_text(matrix.text, encoding="utf-8"))


def _parsed(table: tabular.Table) -> StoredMatrix:
    """Return the matrix of a table.

    Raises
    ------
    InputError
        It is none.
    """
    head = table.header
    if len(head.cells) != 8 or len(table.rows) != 7:
        message = (
            f"{table.name}: has {len(table.rows)} rows and {max(len(head.cells) - 1, 0)} columns of numbers; a joint's "
            f"matrix has 7 and 7, over {', '.join(MOTIONS)}"
        )
        raise InputError(message)
    columns = [_unit(table, head.line, cell, MOTIONS[i], i < 3, moves=True) for i, cell in enumerate(head.cells[1:])]
    rows = []
    for i, row in enumerate(table.rows):
        if problem := tabular.ragged(row, 8):
            raise table.error(row.line, problem)
        force = _unit(table, row.line, row.cells[0], FORCES[i], i < 3, moves=False)
        values = []
        for cell, unit, motion in zip(row.cells[1:], columns, MOTIONS, strict=True):
            try:
                values.append(tabular.number(cell, "1234.5") * force / unit)
            except ValueError as error:
                raise table.error(row.line, f"{tabular.where(motion, cell)} {error}") from None
        rows.append(values)
    return StoredMatrix(rows, _made(table), table.name)


def _unit(table: tabular.Table, line: int, cell: str, name: str, first: bool, *, moves: bool) -> float:
    """Return the unit of a row or column in SI, or refuse its name or unit."""
    match = _CELL.fullmatch(cell)
    wanted = _HEADER.split(",")[1 + MOTIONS.index(name)] if moves else _ROWS[FORCES.index(name)]
    if match is None or match[1] != name:
        order = ", ".join(MOTIONS if moves else FORCES)
        raise table.error(
            line, f"{shown(cell.strip())}: must be {name} with its unit, as {wanted}; the order is {order}"
        )
    unit = match[2].strip()
    if not moves and first:
        factor = _NEWTON.get(unit)
    else:
        kind = {(True, True): Dimension.LENGTH, (True, False): Dimension.ANGLE}.get((moves, first), Dimension.TORQUE)
        found = look_up(unit)
        factor = found[1] / found[2] if found is not None and found[0] is kind else None
    if factor is None:
        raise table.error(line, f"{shown(cell.strip())}: has no unit that fits; write e.g. {wanted}")
    return factor


def _made(table: tabular.Table) -> dict[str, float]:
    """Return what the comments say that a matrix was made for."""
    made = {}
    for line in table.comments:
        match = _MADE.fullmatch(line)
        name, _, key = match[1].partition(".") if match else ("", "", "")
        if match is None or match[1] not in (*SCALING, *SHAPE):
            continue
        dimension = beamfile.TABLES[name][key].dimension
        assert dimension is not None
        try:
            made[match[1]] = quantity(match[2].strip('"'), dimension, bare=False)
        except QuantityError as error:
            message = f"{table.name}: # {match[1]} = {error}"
            raise InputError(message) from None
    if missing := [key for key in SCALING if not made.get(key, 0) > 0]:
        example = (
            f"# {missing[0]} = {beamfile.TABLES[missing[0].partition('.')[0]][missing[0].partition('.')[2]].example}"
        )
        message = f"{table.name}: does not say what it was made for; write a line above the header: {example}"
        raise InputError(message)
    return made


def _check(table: Array, name: str) -> None:
    """Refuse a matrix that no elastic body has."""
    import numpy as np

    if table.shape != (7, 7):
        message = f"{name}: has the shape {table.shape}; a joint's matrix has 7 rows and 7 columns"
        raise InputError(message)
    diagonal = np.diag(table)
    if not (diagonal > 0).all():
        i = int(np.flatnonzero(~(diagonal > 0))[0])
        message = f"{name}: is not positive definite: {FORCES[i]} by {MOTIONS[i]} is {diagonal[i]:.4g}, must be above 0"
        raise InputError(message)
    scaled = table / np.sqrt(np.outer(diagonal, diagonal))
    apart = np.abs(scaled - scaled.T)
    if apart.max() > NEAR:
        i, j = (int(k) for k in np.unravel_index(int(apart.argmax()), apart.shape))
        message = (
            f"{name}: is not symmetric: {FORCES[i]} by {MOTIONS[j]} is {table[i, j]:.6g}, {FORCES[j]} by {MOTIONS[i]} "
            f"is {table[j, i]:.6g}; both must be the same"
        )
        raise InputError(message)
    least = float(np.linalg.eigvalsh((scaled + scaled.T) / 2).min())
    if least <= 1e-9:
        message = (
            f"{name}: is not positive definite, so some motion would need no force or give energy away (least "
            f"eigenvalue {least:.2g} with the diagonal scaled to 1); check its entries"
        )
        raise InputError(message)
