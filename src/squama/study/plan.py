"""The plan of a sweep: beam, model and axes, the layout of its arrays, and the differences between two plans."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import tomllib
from collections.abc import Iterator, Mapping
from importlib import metadata
from typing import Any, NamedTuple

import numpy as np

from squama._version import __version__
from squama.beam.design import Beam
from squama.loads import LOADS
from squama.model.outcome import CODES
from squama.study.compliant_columns import ENDS, Figures
from squama.study.hinge_columns import AT_CUT
from squama.study.models import Model
from squama.study.parameters import PARAMETERS, Axis
from squama.symbols import SYMBOLS
from squama.types import Array
from squama.units import shown

FORMAT = 2
"""Version of the layout of a store."""
Tile = tuple[int, ...]
"""Number of a tile along each dimension."""


class Variable(NamedTuple):
    """A variable of the store: the field of the figures that it holds, its data type and its attributes."""

    field: str
    dtype: str
    attrs: dict[str, Any]


def _variables(joint: str, load: str) -> dict[str, Variable]:
    """Return the variables of one joint under a load: numbers, how the curve ends, the neighbour on hinges."""
    of, hinged, found = LOADS[load], joint == "hinge", dict[str, Variable]()
    for field in ("load_e", "theta_end", "load_end", "f0", *AT_CUT) if hinged else Figures._fields:
        symbol = of.variable(f"{field}_c" if hinged and field in AT_CUT else field)
        if field != "code":
            name = of.variable(field) if field.startswith("load_") else field
            found[name] = Variable(field, "float64", SYMBOLS[symbol].attrs)
    ends = CODES if hinged else ENDS
    about = {
        "long_name": "how the curve ends",
        "flag_values": [-1, *range(len(ends))],
        "flag_meanings": " ".join(["not_computed", *(end.replace(" ", "_") for end in ends)]),
    }
    found["end"] = Variable("code", "int8", about)
    if hinged:
        found["f0"].attrs["long_name"] += " at the cut-off"
        found["neighbour"] = Variable("neighbour", "int16", SYMBOLS["neighbour"].attrs)
    return found


VARIABLES = {(joint, load): _variables(joint, load) for joint in ("hinge", "compliant") for load in LOADS}
"""Variables of a store by joint and load."""
OWN = ("finite_torque", "finite_stiffness_ratio", "finite_ratio")
"""Fields for beams with a number of scales only."""
MARK = "squama_sweep"
"""Attribute of the group that marks a store; its value is the version of the layout."""
STATUS = "status"
CHECKSUMS = "checksums"
"""Array of the checksums of the chunks of each tile, in the order of the variables."""
_STATUS_ATTRS = {"long_name": "state of each tile", "flag_values": [0, 1], "flag_meanings": "not_computed done"}


def variables(model: Model, load: str) -> dict[str, Variable]:
    """Return the variables of a model's figures under a load, by name."""
    return {name: v for name, v in VARIABLES[model.joint, load].items() if model.own or v.field not in OWN}


class Plan(NamedTuple):
    """All settings that determine the numbers in a store, and no others: equal plans give equal bytes."""

    beam_toml: str
    load: str
    laws: tuple[str, ...]
    sense: str
    margin: float | None
    axes: tuple[Axis, ...]
    tile: tuple[int, ...]
    versions: dict[str, str]
    model: Model = Model()

    @property
    def variables(self) -> dict[str, Variable]:
        """Variables of the store by name."""
        return variables(self.model, self.load)

    @property
    def sizes(self) -> dict[str, int]:
        """Number of cells along each dimension, by name: ``law`` first if there are several."""
        laws = {"law": len(self.laws)} if len(self.laws) > 1 else {}
        return laws | {axis.name: axis.values.size for axis in self.axes}

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(self.sizes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of cells along each dimension."""
        return tuple(self.sizes.values())

    @property
    def cells(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def grid(self) -> tuple[int, ...]:
        """Number of tiles along each dimension."""
        return tuple(-(-n // m) for n, m in zip(self.shape, self.tile, strict=True))

    def tiles(self, shard: tuple[int, int] = (1, 1)) -> Iterator[Tile]:
        """Return the tiles in order; shard (i, n) takes every n-th tile from the i-th on."""
        every = itertools.product(*(range(n) for n in self.grid))
        return itertools.islice(every, shard[0] - 1, None, shard[1])

    def place(self, tile: Tile) -> tuple[slice, ...]:
        """Return the slices that a tile takes in the arrays."""
        sides = zip(tile, self.tile, self.shape, strict=True)
        return tuple(slice(i * m, min((i + 1) * m, n)) for i, m, n in sides)

    def size(self, tile: Tile) -> int:
        """Return the number of cells of a tile."""
        return math.prod(s.stop - s.start for s in self.place(tile))

    @property
    def configuration(self) -> dict[str, object]:
        """The plan as plain data."""
        return {
            "format": FORMAT,
            "load": self.load,
            "law": list(self.laws),
            "sense": self.sense,
            "margin": self.margin,
            "over": [[axis.name, axis.record] for axis in self.axes],
            "tile": list(self.tile),
            "versions": self.versions,
            "beam": self.beam_toml,
            **self.model.record,
        }

    @property
    def text(self) -> str:
        """The configuration as JSON; equal plans give equal text."""
        return json.dumps(self.configuration, sort_keys=True, separators=(",", ":"))

    @property
    def digest(self) -> str:
        """SHA-256 of the configuration."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @classmethod
    def from_text(cls, text: str) -> Plan:
        """Read a plan from its :attr:`text`."""
        c = json.loads(text)
        swept = tuple(Axis.from_record(name, v) for name, v in c["over"])
        alike = {key: c[key] for key in ("load", "sense", "margin", "versions")}
        return cls(
            c["beam"], laws=tuple(c["law"]), axes=swept, tile=tuple(c["tile"]), model=Model.from_record(c), **alike
        )


def arrays(plan: Plan) -> dict[str, dict[str, object]]:
    """Return the keyword arguments that create every array of the store, without its codecs."""
    keys = ("shape", "chunks", "dtype", "dimension_names", "attributes", "fill_value")
    found: dict[str, tuple[object, ...]] = {}
    for name, (_, dtype, attrs) in plan.variables.items():
        found[name] = plan.shape, plan.tile, dtype, plan.dims, attrs, np.nan if dtype == "float64" else -1
    tiles, ones, names = tuple(f"tile_{dim}" for dim in plan.dims), (1,) * len(plan.grid), list(plan.variables)
    found[STATUS] = plan.grid, ones, "int8", tiles, _STATUS_ATTRS, 0
    about = {"long_name": "CRC-32C of the chunks of each tile", "variables": " ".join(names)}
    found[CHECKSUMS] = (*plan.grid, len(names)), (*ones, len(names)), "uint32", (*tiles, "variable"), about, 0
    for name, (values, own) in coordinates(plan).items():
        found[name] = values.shape, values.shape, str(values.dtype), (name,), own, 0
    return {name: dict(zip(keys, about, strict=True)) for name, about in found.items()}


def coordinates(plan: Plan) -> dict[str, tuple[Array, Mapping[str, object]]]:
    """Return values and attributes of the coordinates by name."""
    found: dict[str, tuple[Array, Mapping[str, object]]] = {}
    if len(plan.laws) > 1:
        codes = np.arange(len(plan.laws), dtype="int8")
        flags = {"long_name": "force law", "flag_values": codes.tolist(), "flag_meanings": " ".join(plan.laws)}
        found["law"] = codes, flags
    for axis in plan.axes:
        found[axis.name] = axis.values, PARAMETERS[axis.name].symbol.attrs
    return found


def attributes(plan: Plan) -> dict[str, object]:
    """Return the attributes of the group."""
    about = {
        "title": f"sweep of a scale-covered beam in {plan.load}",
        "Conventions": "CF-1.11",
        "load": plan.load,
        "law": " ".join(plan.laws),
        "sense": plan.sense,
        "margin": plan.margin,
        "beam": plan.beam_toml,
        "squama_version": plan.versions["squama"],
        "versions": plan.versions,
        "configuration": plan.text,
        "configuration_sha256": plan.digest,
        MARK: FORMAT,
        **({} if plan.model == Model() else plan.model.attrs(Beam.from_toml_text(plan.beam_toml))),
    }
    return {key: value for key, value in about.items() if value is not None}


def tile_shape(shape: tuple[int, ...], dims: tuple[str, ...], most: int) -> tuple[int, ...]:
    """Return the shape of tiles of at most ``most`` cells, as even as possible, with one law and one margin each."""
    parts = [n if dim in ("law", "margin") else 1 for n, dim in zip(shape, dims, strict=True)]
    while True:
        sides = [-(-n // k) for n, k in zip(shape, parts, strict=True)]
        if math.prod(sides) <= most:
            return tuple(sides)
        longest = max(range(len(sides)), key=sides.__getitem__)
        parts[longest] = min(max(parts[longest] + 1, int(1.01 * parts[longest])), shape[longest])


def versions() -> dict[str, str]:
    """Return the versions of the packages on which the last digits depend."""
    return {**{name: metadata.version(name) for name in ("numba", "numpy", "scipy")}, "squama": __version__}


def differences(stored: Plan, asked: Plan) -> list[str]:
    """Return a line for every entry in which two plans differ, the stored value first."""
    old, new = _entries(stored), _entries(asked)
    lines = []
    for key in {**old, **new}:
        (was, before), (wanted, now) = (entries.get(key, (None, "not given")) for entries in (old, new))
        # where the parameters differ, their names suffice
        if was != wanted and (key[0] != "over" or (key in old and key in new)):
            lines.append(f"{key[0]} {before} against {now}")
    return lines


def _entries(plan: Plan) -> dict[tuple[str, str], tuple[object, str]]:
    """Return the entries of a configuration by name (and parameter), each with its value and its text."""
    found: dict[tuple[str, str], tuple[object, str]] = {}
    for key, value in {**plan.model._asdict(), **plan.configuration}.items():
        if key == "over":
            names = [axis.name for axis in plan.axes]
            found["over", ""] = names, ", ".join(names)
            found |= {("over", a.name): (a.record, f"{a.span} ({a.values.size} values)") for a in plan.axes}
            continue
        tables = tomllib.loads(value) if key == "beam" else {"": value if key == "versions" else {key: value}}
        for table, keys in tables.items():
            found |= {(f"{table}.{name}".lstrip("."), ""): (v, _brief(v)) for name, v in keys.items()}
    return found


def _brief(value: object) -> str:
    if value is None:
        return "not given"
    return ",".join(str(v) for v in value) if isinstance(value, list) else shown(value).strip('"')
