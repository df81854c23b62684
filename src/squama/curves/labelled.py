"""Labelled results before they are an ``xarray.Dataset``: a command that prints a few figures need not load xarray."""

from __future__ import annotations

import functools
import math
from collections.abc import Hashable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama._version import __version__
from squama.beam.design import Beam
from squama.curves.chosen import MODELS, idealisation, thin
from squama.curves.way import Analysis, States
from squama.loads import LOADS, STRAIGHT, Load
from squama.symbols import SYMBOLS
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr


_BOTH = ("psi", "phi", "load", "kappa", "Phi", "rate")
"""Roles of load angles where bend and twist are both loads."""
_PART = ("share", "travel", "turn", "F", "moment", "F_bare", "moment_bare")
"""Roles of the load of a part."""
_FIRST = (*_BOTH, *_PART, "rate", "load", "torque", "scales", "tangent", "stiffness_ratio")
_SYMBOLS = {name: i for i, name in enumerate(SYMBOLS)}


MEAN = ("theta", "phi_cell", "psi_cell", "chi_cell", "stretch_cell")
"""Figures of N scales whose mean is told of a curve; of others the largest."""


class Labelled(NamedTuple):
    """Values with the names of their dimensions and their attributes."""

    dims: tuple[str, ...]
    values: Array
    attrs: dict[str, str]


class Answer:
    """Variables of a response by name, and attributes of the whole; ``answer["T"]`` are the values of one.

    ``mu`` is a coordinate: one number, or the dimension of a family of curves; ``along_load``: whether the load and
    the load angle are coordinates of the points, too.
    """

    def __init__(self, variables: dict[str, Labelled], attrs: dict[str, Any], *, along_load: bool = False) -> None:
        self.variables, self.attrs, self.along_load = variables, attrs, along_load

    def __getitem__(self, name: str) -> Array:
        """Return the values of a variable."""
        return self.variables[name].values

    @property
    def family(self) -> int | None:
        """Number of curves of a family over mu; None for a single curve."""
        return self["mu"].size if self["mu"].ndim else None

    @property
    def figures(self) -> dict[str, Array]:
        """Single figures of each curve, by name."""
        found = self.variables.items()
        return {name: v.values for name, v in found if "point" not in v.dims and name not in ("mu", "scale")}

    @property
    def curves(self) -> dict[str, Array]:
        """Variables along the curves, by name: of N scales the mean inclination, and the largest of other figures."""
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

    def pick(self, i: int) -> Answer:
        """Return one curve of a family."""
        one = {
            name: Labelled(v.dims[1:], np.asarray(v.values[i]), v.attrs) if v.dims[:1] == ("mu",) else v
            for name, v in self.variables.items()
        }
        return Answer(one, self.attrs, along_load=self.along_load)

    def dataset(self) -> xr.Dataset:
        """Return the same as an ``xarray.Dataset``."""
        import xarray as xr

        load = LOADS[self.attrs["load"]] if self.along_load else None
        names = [load.rate, load.angle, "mu"] if load else ["mu"]
        data = {name: v for name, v in self.variables.items() if name not in names}
        return xr.Dataset(data, coords={name: self.variables[name] for name in names}, attrs=self.attrs)


def _labelled(load: Load, states: States, mus: Array, page: str) -> dict[str, Labelled]:
    """Return the variables of states: names by the load's table, units and words by that of symbols.

    Equations are the paper's where that twists hinges, else those of a page of the theory. Along a curve the load comes
    first, then its torque or moment and stiffness, then the others in the order of the symbols.
    """
    by_dim = [*states.by_dim.items(), (("mu",) * mus.ndim, {"mu": mus})]
    found = {}
    for dims, values in by_dim:
        first = _FIRST if "kappa" in values else _FIRST[len(_BOTH) :]
        for role, name in sorted(load.variables(tuple(values)).items(), key=lambda one: _place(first, *one)):
            attrs = SYMBOLS[name].attrs
            if page and attrs.get("equation", "").startswith("paper"):
                attrs = attrs | {"equation": f"theory: {page}"}
            found[name] = Labelled(dims, np.asarray(values[role]), attrs)
    return found


def _place(first: tuple[str, ...], role: str, name: str) -> tuple[int, int]:
    """Return the place of a variable: first the load and what answers to it, by role, then by its symbol."""
    return first.index(role) if role in first else len(first), _SYMBOLS[name]


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
    """Return what a model's states say under their names, with what every answer says of the beam and of its loading.

    ``attrs``: more attributes, before those of the states; ``load``: by which names are given, that of the way if not
    given; ``sense``: in which a beam is loaded; ``page`` of the theory, for equations, that of the model if not given.
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
    if any("scale" in dims for dims in states.by_dim):
        words = {"long_name": "scale, counted along the beam"}
        found.variables["scale"] = Labelled(("scale",), np.arange(1, beam.pitches + 1), words)
    return found


@functools.lru_cache(maxsize=64)
def text(beam: Beam) -> str:
    """Return a beam as the text of its file."""
    return beam.to_toml()


def flat_cycle(dataset: xr.Dataset) -> xr.Dataset:
    """Return a cycle with the dimension ``point`` only, as a table of one shape; loops and senses as attributes."""

    def rows(dim: str, variables: Iterable[Hashable]) -> list[dict[str, object]]:
        columns = {str(name): dataset[name].values.tolist() for name in variables if dataset[name].dims == (dim,)}
        # JSON has no numbers for infinity and NaN
        plain = [[repr(v) if isinstance(v, float) and not math.isfinite(v) else v for v in c] for c in columns.values()]
        return [dict(zip(columns, row, strict=True)) for row in zip(*plain, strict=True)]

    others = [str(dim) for dim in dataset.dims if dim != "point"]
    told = {f"{dim}s": rows(dim, dataset.variables) for dim in others if dim != "scale"}
    return dataset.drop_dims(others).assign_attrs(told)
