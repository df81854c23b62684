"""The plan of a sweep: what is computed, where it lies in the arrays, and how two plans differ."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from squama._version import __version__
from squama.beamfile import TABLES
from squama.errors import InputError
from squama.model.outcome import CODES
from squama.study.parameters import Axis
from squama.symbols import SYMBOLS
from squama.units import shown

FORMAT = 1
"""Version of the layout of a store."""
SMALLEST_TILE, LARGEST_TILE, PARTS = 1024, 65536, 16
"""Cells of a tile unless asked for: a sixteenth of the sweep within these bounds."""
MOST_TILES = 1_000_000
Tile = tuple[int, ...]
"""Number of a tile along each dimension."""


class Variable(NamedTuple):
    """A variable of the store: the field of :class:`squama.Solved` behind it, its type and its attributes."""

    field: str
    dtype: str
    attrs: dict[str, Any]


_END = {
    "long_name": "how the curve ends",
    "flag_values": [-1, *range(len(CODES))],
    "flag_meanings": " ".join(["not_computed", *(str(e).replace(" ", "_") for e in CODES)]),
}


def _variables(angle: str, torque: str) -> dict[str, Variable]:
    rows = (
        (f"{angle}_e", "load_e", f"{angle}_e"),
        ("theta_end", "theta_end", "theta_end"),
        (f"{angle}_end", "load_end", f"{angle}_end"),
        ("f0", "f0", "f0"),
        ("torque", "torque", torque),
        ("U_el", "U_el", "U_el_c"),
        ("W_fr", "W_fr", "W_fr_c"),
        ("RED", "RED", "RED_c"),
    )
    found = {name: Variable(field, "float64", SYMBOLS[symbol].attrs) for name, field, symbol in rows}
    found["f0"].attrs["long_name"] += " at the cut-off"
    found["end"] = Variable("code", "int8", _END)
    found["neighbour"] = Variable("neighbour", "int16", SYMBOLS["neighbour"].attrs)
    return found


VARIABLES = {"twisting": _variables("phi", "T_c"), "bending": _variables("psi", "M_c")}
"""Variables of a store by the load."""


class Plan(NamedTuple):
    """All that determines the numbers of a sweep, and nothing else."""

    beam_toml: str
    load: str
    laws: tuple[str, ...]
    sense: str
    margin: float | None
    engine: str
    axes: tuple[Axis, ...]
    tile: tuple[int, ...]
    versions: dict[str, str]

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions: ``law`` first if there are several."""
        return (*(("law",) if len(self.laws) > 1 else ()), *(axis.name for axis in self.axes))

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of cells along each dimension."""
        return (*((len(self.laws),) if len(self.laws) > 1 else ()), *(axis.values.size for axis in self.axes))

    @property
    def cells(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def grid(self) -> tuple[int, ...]:
        """Number of tiles along each dimension."""
        return tuple(-(-n // m) for n, m in zip(self.shape, self.tile, strict=True))

    def tiles(self, shard: tuple[int, int] = (1, 1)) -> Iterator[Tile]:
        """Tiles in their order; of shard i of n those whose number is i - 1 modulo n."""
        every = itertools.product(*(range(n) for n in self.grid))
        return itertools.islice(every, shard[0] - 1, None, shard[1])

    def place(self, tile: Tile) -> tuple[slice, ...]:
        """Where a tile lies in the arrays."""
        sides = zip(tile, self.tile, self.shape, strict=True)
        return tuple(slice(i * m, min((i + 1) * m, n)) for i, m, n in sides)

    def size(self, tile: Tile) -> int:
        """Cells of a tile."""
        return math.prod(s.stop - s.start for s in self.place(tile))

    @property
    def configuration(self) -> dict[str, Any]:
        """The plan as plain data."""
        return {
            "format": FORMAT,
            "load": self.load,
            "law": list(self.laws),
            "sense": self.sense,
            "margin": self.margin,
            "engine": self.engine,
            "over": [[axis.name, axis.record] for axis in self.axes],
            "tile": list(self.tile),
            "versions": self.versions,
            "beam": self.beam_toml,
        }

    @property
    def text(self) -> str:
        """The configuration as JSON, always in the same letters."""
        return json.dumps(self.configuration, sort_keys=True, separators=(",", ":"))

    @property
    def digest(self) -> str:
        """SHA-256 of the configuration."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @classmethod
    def from_text(cls, text: str) -> Plan:
        """Read back :attr:`text`."""
        c = json.loads(text)
        swept = tuple(Axis.from_record(name, v) for name, v in c["over"])
        return cls(
            c["beam"],
            c["load"],
            tuple(c["law"]),
            c["sense"],
            c["margin"],
            c["engine"],
            swept,
            tuple(c["tile"]),
            c["versions"],
        )


def tile_shape(shape: tuple[int, ...], dims: tuple[str, ...], most: int) -> tuple[int, ...]:
    """Return a tile of at most so many cells, as even as can be; one law and one margin to a tile."""
    parts = [n if dim in ("law", "margin") else 1 for n, dim in zip(shape, dims, strict=True)]
    while True:
        sides = [-(-n // k) for n, k in zip(shape, parts, strict=True)]
        if math.prod(sides) <= most:
            return tuple(sides)
        longest = max(range(len(sides)), key=sides.__getitem__)
        parts[longest] = min(max(parts[longest] + 1, int(1.01 * parts[longest])), shape[longest])


def check_tiles(grid: tuple[int, ...], asked: int) -> None:
    """Refuse a sweep of too many tiles."""
    if math.prod(grid) > MOST_TILES:
        message = f"tile = {asked}: makes {math.prod(grid):,} tiles, more than {MOST_TILES:,}; give larger tiles"
        raise InputError(message)


def default_tile(cells: int) -> int:
    """Return the number of cells of a tile when none is asked for."""
    return int(min(LARGEST_TILE, max(SMALLEST_TILE, cells // PARTS)))


def versions() -> dict[str, str]:
    """Versions of what the last digits depend on."""
    import scipy

    return {"numpy": np.__version__, "scipy": scipy.__version__, "squama": __version__}


def differences(stored: Plan, asked: Plan) -> list[str]:
    """Name every entry in which two plans differ, the stored value first."""
    old, new = stored.configuration, asked.configuration
    lines = []
    for key in old:
        if old[key] == new[key]:
            continue
        if key == "beam":
            lines += _beam_differences(old[key], new[key])
        elif key == "versions":
            lines += [
                f"{n} {old[key].get(n)} against {new[key][n]}" for n in new[key] if old[key].get(n) != new[key][n]
            ]
        elif key == "over":
            lines += _over_differences(dict(old[key]), dict(new[key]))
        else:
            lines.append(f"{key} {_brief(old[key])} against {_brief(new[key])}")
    return lines


def _beam_differences(old: str, new: str) -> list[str]:
    a, b = tomllib.loads(old), tomllib.loads(new)
    lines = []
    for table, keys in TABLES.items():
        for key in keys:
            was, is_ = a.get(table, {}).get(key), b.get(table, {}).get(key)
            if was != is_:
                lines.append(f"{table}.{key} {_brief(was)} against {_brief(is_)}")
    return lines


def _over_differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    if list(old) != list(new):
        return [f"over {', '.join(old)} against {', '.join(new)}"]
    return [f"over {_range(n, old[n])} against {_range(n, new[n])}" for n in old if old[n] != new[n]]


def _range(name: str, record: Any) -> str:
    axis = Axis.from_record(name, record)
    return f"{axis.span} ({axis.values.size} values)"


def _brief(value: Any) -> str:
    if value is None:
        return "not given"
    return ",".join(str(v) for v in value) if isinstance(value, list) else shown(value).strip('"')
