"""Parameters with their estimates and covariance: the base of the fits of a test and of a decay."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from squama._version import __version__
from squama.beam.design import Beam
from squama.identify.unknowns import Parameter, written
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr


Table = dict[str, tuple[str, object, str, str | None]]
"""Variables of a dataset by name: dimensions, values, words, and the unit (None for words and counts)."""


def of(given: object, *names: str) -> dict[str, object]:
    """Return attributes by name."""
    return {name: getattr(given, name) for name in names}


def variables(table: Table) -> dict[str, tuple[list[str], object, dict[str, str]]]:
    """Return the variables of a table with their attributes, for ``xarray.Dataset``."""
    return {
        name: (dims.split(), values, {"long_name": words} | ({} if unit is None else {"units": unit}))
        for name, (dims, values, words, unit) in table.items()
    }


class Estimated(ABC):
    """Parameters with their estimates and covariance."""

    beam: Beam
    estimates: Array
    covariance: Array
    notes: tuple[str, ...]

    @property
    @abstractmethod
    def rows(self) -> tuple[Parameter, ...]:
        """The parameters that were found."""

    @property
    def sizes(self) -> list[tuple[str, str]]:
        """Residuals and number of points as text, each with its name."""
        return []

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters that were found."""
        return tuple(row.name for row in self.rows)

    @property
    def values(self) -> dict[str, float]:
        """Estimates by name, SI units."""
        return self._by_name(self.estimates)

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors by name, SI units."""
        return self._by_name(self.deviations)

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the estimates."""
        return np.asarray(self.covariance / np.outer(self.deviations, self.deviations))

    @property
    def lines(self) -> list[str]:
        """Estimates with their errors: "mu = 0.251 +- 0.013"."""
        return written(self.rows, self.estimates, self.deviations)

    @property
    def deviations(self) -> Array:
        """Standard errors, in the order of the estimates."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def _by_name(self, values: Array) -> dict[str, float]:
        return dict(zip(self.parameters, values.tolist(), strict=True))

    def _parameters(self, **columns: Array) -> dict[str, dict[str, object]]:
        """Return estimates by name, with errors, units and further columns."""
        rows = zip(self.rows, self.estimates, self.deviations, *columns.values(), strict=True)
        return {
            row.name: {"estimate": float(value), "error": float(error), "unit": row.unit}
            | dict(zip(columns, (v.item() for v in more), strict=True))
            for row, value, error, *more in rows
        }

    def beam_file(self, sources: list[str]) -> str:
        """Return the text of the beam file with the estimates; comments name their source."""
        head = f"# Fitted by squama fit to {', '.join(sources)}: estimates and standard errors"
        return "\n".join([head, *(f"# {line}" for line in self.lines)]) + "\n\n" + self.beam.to_toml()

    def _labelled(self, title: str, table: Table, attrs: Mapping[str, object]) -> xr.Dataset:
        """Return the estimates and a table of variables as a dataset."""
        import xarray as xr

        names, units = list(self.parameters), np.array([row.unit for row in self.rows])
        own: Table = {
            "estimate": ("parameter", self.estimates, "estimate", None),
            "error": ("parameter", self.deviations, "standard error", None),
            "unit": ("parameter", units, "unit of the parameter", None),
            "correlation": ("parameter other", self.correlation, "correlation of the estimates", None),
        }
        found = {"beam": self.beam.to_toml(), "estimates": ", ".join(self.lines), "squama_version": __version__}
        attributes = {"title": f"parameters of a scale-covered beam from a {title}", **attrs, **found}
        return xr.Dataset(variables({**table, **own}), coords={"parameter": names, "other": names}, attrs=attributes)

    def summary(self) -> str:
        """Return estimates, errors, correlations and notes as text."""
        return "\n".join([*self.described(), *(f"{name} {text}" for name, text in self.sizes), *self.more])

    @property
    def more(self) -> list[str]:
        """Notes as lines."""
        return [f"note: {note}" for note in self.notes]

    def described(self) -> list[str]:
        """Return a line for each estimate, with its error and its correlations with the estimates above."""
        lines = []
        for i, row in enumerate(self.rows):
            other = [f"{self.correlation[i, j]:+.2f} with {self.parameters[j]}" for j in range(i)]
            also = f"; correlation {', '.join(other)}" if other else ""
            text = row.written(self.values[row.name], self.errors[row.name])
            lines.append(f"{row.name:11} {text:24} {row.words}{also}")
        return lines
