"""Labelled results before they are an ``xarray.Dataset``: a command that prints a few figures need not load xarray."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr


class Labelled(NamedTuple):
    """Values with the names of their dimensions and their attributes."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: dict[str, str]


class Answer:
    """Variables of a response, and what holds for all of them; ``answer["T"]`` are the values of one.

    Parameters
    ----------
    variables : dict of Labelled
        By name. ``mu`` is a coordinate: one number, or the dimension of a family of curves.
    attrs : dict
        Attributes of the whole.
    """

    def __init__(self, variables: dict[str, Labelled], attrs: dict[str, Any]) -> None:
        self.variables, self.attrs = variables, attrs

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return the values of a variable."""
        return self.variables[name].values

    @property
    def family(self) -> int | None:
        """Number of curves of a family over mu; None for a single curve."""
        return self["mu"].size if self["mu"].ndim else None

    @property
    def figures(self) -> dict[str, NDArray[Any]]:
        """Single figures of each curve, by name."""
        return {name: v.values for name, v in self.variables.items() if "point" not in v.dims and name != "mu"}

    @property
    def curves(self) -> dict[str, NDArray[Any]]:
        """Variables along the curves, by name."""
        return {name: v.values for name, v in self.variables.items() if "point" in v.dims}

    def pick(self, i: int) -> Answer:
        """Return one curve of a family."""
        one = {
            name: Labelled(v.dims[1:], np.asarray(v.values[i]), v.attrs) if v.dims[:1] == ("mu",) else v
            for name, v in self.variables.items()
        }
        return Answer(one, self.attrs)

    def dataset(self) -> xr.Dataset:
        """Return the same as an ``xarray.Dataset``."""
        import xarray as xr

        data = dict(self.variables)
        return xr.Dataset(data, coords={"mu": data.pop("mu")}, attrs=self.attrs)
