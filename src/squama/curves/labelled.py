"""Labelled results before they are an ``xarray.Dataset``, so that commands that print a few numbers need no xarray."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama._version import __version__
from squama.beam.design import Beam
from squama.curves.chosen import MODELS, idealisation, thin
from squama.curves.way import Analysis, States
from squama.loads import STRAIGHT, Load
from squama.symbols import SYMBOLS
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr


_BOTH = ("psi", "phi", "load", "kappa", "Phi", "rate", "M", "M_scales")
"""Roles of load angles and moments where bend and twist are both loads."""
_PART = ("share", "travel", "turn", "F", "moment", "F_bare", "moment_bare", "F_periodic", "moment_periodic")
"""Roles of the load of a part."""
_FIRST = (*_BOTH, *_PART, "rate", "load", "torque", "scales", "tangent", "stiffness_ratio")
_SYMBOLS = {name: i for i, name in enumerate(SYMBOLS)}


MEAN = ("theta", "phi_cell", "psi_cell", "chi_cell", "stretch_cell")
"""Variables of N scales shown by their mean along a curve; others are shown by the largest value."""


class Labelled(NamedTuple):
    """Values with the names of their dimensions, and their attributes."""

    dims: tuple[str, ...]
    values: Array
    attrs: dict[str, str]


class Answer:
    """Variables of a response by name, and attributes of the whole; ``answer["T"]`` are the values of T.

    ``mu`` is a coordinate: one number, or the dimension of a family of curves; ``over``: coordinates of the points.
    """

    def __init__(self, variables: dict[str, Labelled], attrs: dict[str, Any], over: tuple[str, ...] = ()) -> None:
        self.variables, self.attrs, self.over = variables, attrs, over

    def __getitem__(self, name: str) -> Array:
        """Return the values of a variable."""
        return self.variables[name].values

    @property
    def family(self) -> int | None:
        """Number of curves of a family over mu; None for a single curve."""
        return self["mu"].size if self["mu"].ndim else None

    @property
    def figures(self) -> dict[str, Array]:
        """Single values of each curve, by name."""
        found = self.variables.items()
        return {name: v.values for name, v in found if "point" not in v.dims and name not in ("mu", "scale")}

    @property
    def curves(self) -> dict[str, Array]:
        """Variables along the curves, by name; for N scales the mean inclination, the largest of other variables."""
        return {name: self.along(name) for name, v in self.variables.items() if "point" in v.dims}

    @property
    def each(self) -> dict[str, Array]:
        """Variables of each of N scales along the curves, by name."""
        return {name: v.values for name, v in self.variables.items() if {"point", "scale"} <= {*v.dims}}

    def along(self, name: str) -> Array:
        """Return a variable along the curves, see :attr:`curves`."""
        v = self.variables[name]
        if "scale" not in v.dims:
            return v.values
        return np.asarray(v.values.mean(axis=-1) if name in MEAN else np.fmax.reduce(v.values, axis=-1))

    def at(self, i: int) -> dict[str, Array]:
        """Return the values of all variables along a single curve at its point ``i``, by name."""
        return {name: v.values[i] for name, v in self.variables.items() if v.dims[:1] == ("point",)}

    def pick(self, i: int) -> Answer:
        """Return one curve of a family."""
        one = {
            name: Labelled(v.dims[1:], np.asarray(v.values[i]), v.attrs) if v.dims[:1] == ("mu",) else v
            for name, v in self.variables.items()
        }
        return Answer(one, self.attrs, self.over)

    def dataset(self) -> xr.Dataset:
        """Return the response as an ``xarray.Dataset``."""
        import xarray as xr

        names = [*self.over, "mu"]
        data = {name: v for name, v in self.variables.items() if name not in names}
        return xr.Dataset(data, coords={name: self.variables[name] for name in names}, attrs=self.attrs)


def _labelled(load: Load, states: States, mus: Array, page: str) -> dict[str, Labelled]:
    """Return the variables of states with names from the load's table, units and words from that of symbols.

    Equations are the paper's for twisting on hinges, else those of a ``page`` of the theory. Along a curve the load
    comes first, then its torque or moment and stiffness, then the others in the order of the symbols, those of single
    scales among them.
    """
    by_dim = [*states.by_dim.items(), (("mu",) * mus.ndim, {"mu": mus})]
    first = _FIRST if any("kappa" in values for _, values in by_dim) else _FIRST[len(_BOTH) :]
    named = [(dims, values, load.variables(tuple(values)).items()) for dims, values in by_dim]
    every = [(dims, name, role, values[role]) for dims, values, names in named for role, name in names]
    groups = list(dict.fromkeys(_group(dims) for dims, *_ in every))

    def place(role: str) -> int:
        return first.index(role) if role in first else len(first)

    every.sort(key=lambda one: (groups.index(_group(one[0])), place(one[2]), _SYMBOLS[one[1]]))
    found = {}
    for dims, name, _, value in every:
        attrs = SYMBOLS[name].attrs
        if page and attrs.get("equation", "").startswith("paper"):
            attrs = attrs | {"equation": f"theory: {page}"}
        found[name] = Labelled(dims, np.asarray(value), attrs)
    return found


def _group(dims: tuple[str, ...]) -> tuple[str, ...]:
    """Return the dimensions without that of single scales, whose variables stand among those of the points."""
    return tuple(dim for dim in dims if dim != "scale" or "point" not in dims)


def answer(
    analysis: Analysis,
    states: States,
    title: str,
    attrs: Mapping[str, object] = {},
    *,
    load: Load | None = None,
    sense: str = "+",
    page: str | None = None,
) -> Answer:
    """Return a model's states as labelled variables, with the attributes common to all results.

    ``attrs``: further attributes, before those of the states; ``load``: the load whose names are used, by default that
    of the way; ``sense`` of the load; ``page`` of the theory for equations, by default the model's.
    """
    load, joint, beam = load or analysis.way.load, analysis.joint, analysis.beam
    model = MODELS[joint]
    about = {
        "title": title,
        "load": load.name,
        "law": load.law(analysis.law),
        "joint": joint,
        "scales": idealisation(beam, joint, ideal=thin(load, analysis.law, joint, ideal=analysis.ideal)),
        "beam": text(beam),
        **({"faces": beam.faces} if beam.other else {}),
        **({"hold": STRAIGHT} if model.straight else {}),
        "squama_version": __version__,
        **({} if load.sided else {"neutral": beam.neutral}),
        "warnings": "\n".join([*filter(None, [analysis.note]), *states.notes, *beam.warnings(load.name, sense, joint)]),
    }
    page = model.pages[load.name] if page is None else page
    found = Answer(_labelled(load, states, analysis.mus, page), {**about, **attrs, **states.attrs})
    own = load.model(about["law"], joint, about["scales"])
    for name, v in found.variables.items():
        if name.endswith("_periodic"):
            found.variables[name] = v._replace(attrs={**v.attrs, "long_name": f"{v.attrs['long_name']} ({own})"})
    if any("scale" in dims for dims in states.by_dim):
        words = {"long_name": "scale, counted along the beam"}
        found.variables["scale"] = Labelled(("scale",), np.arange(1, beam.pitches + 1), words)
    return found


@functools.lru_cache(maxsize=64)
def text(beam: Beam) -> str:
    """Return a beam as the text of its file."""
    return beam.to_toml()
