"""``result.squama``: summary and figure of a squama dataset, in notebooks and scripts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from squama import plot
from squama.beam.card import card, side
from squama.beam.design import Beam
from squama.errors import refuse
from squama.loads import model
from squama.symbols import SYMBOLS
from squama.units import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURES = {
    "way": "shaken_figure",
    "t_turn": "vibration_figure",
    "bin": "uncertainty_figure",
    "design": "front_figure",
    "t": "decay_figure",
    "loops": "plan_figure",
    "parameter": "fit_figure",
    "work_low": "prediction_figure",
    "branch": "cycle_figure",
    "event": "path_figure",
    "x_axis": "part_figure",
    "state": "plane_figure",
    "T_elements": "compare_figure",
    "status": "map_figure",
    "u_end": "finite_figure",
    "gap": "elements_figure",
    "phi_end": "response_figure",
    "psi_end": "response_figure",
}
"""Figure functions by a name that only one kind of result has; for several the first counts."""


@xr.register_dataset_accessor("squama")  # type: ignore[no-untyped-call]
class Result:
    r"""Summary, beam and figures of a dataset made by squama.

    Examples
    --------
    >>> import squama
    >>> r = squama.twist(squama.Beam.from_ratios(mu=0.5), joint="hinge", points=50)
    >>> print(r.squama.summary().splitlines()[0])
    twisting of a scale-covered beam: thin, rigid scales on hinges, edge law
    >>> len(r.squama.plot().axes), r.squama.line("theta").get_ylabel()
    (4, 'Inclination $\\theta$ (rad)')
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset

    @property
    def beam(self) -> Beam | None:
        """The beam of the result; None if the dataset has none."""
        text = self._dataset.attrs.get("beam")
        return None if text is None else Beam.from_toml_text(text)

    def plot(self, *given: object, **options: object) -> Figure:
        """Return the figure for this kind of result, with the arguments of its function in ``squama.plot``.

        Raises InputError for a dataset without a figure.
        """
        there = {*map(str, self._dataset.variables), *map(str, self._dataset.dims)}
        name = next((figure for mark, figure in FIGURES.items() if mark in there), None)
        if name is None:
            refuse("", "", "squama has no figure of this dataset", "draw a variable with .squama.line(name)")
        figure: Figure = getattr(plot, name)(self._dataset, *given, **options)
        return figure

    def line(self, name: str, ax: Axes | None = None, **options: Any) -> Axes:
        """Draw one variable into axes, as :func:`squama.plot.line` does."""
        return plot.line(self._dataset, name, ax, **options)

    def summary(self) -> str:
        """Return title, single figures with units, and warnings, as text."""
        rows, notes = self._rows(), self._notes()
        wide = max((len(words) for words, _ in rows), default=0)
        return "\n".join([self._title(), *(f"  {words:{wide}}  {value}" for words, value in rows), *notes])

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return card(self._title(), self._rows(), self._notes(), "" if self.beam is None else side(self.beam))

    def _title(self) -> str:
        attrs = self._dataset.attrs
        about = f": {model(attrs)}" if {"load", "law", "joint"} <= set(attrs) else ""
        return f"{attrs.get('title', 'dataset')}{about}"

    def _rows(self) -> list[tuple[str, str]]:
        """Return words and values of variables with one or a few values (at most 8), without empty ones."""
        rows = []
        for name, v in self._dataset.variables.items():
            if "point" in v.dims or v.size > 8:
                continue
            unit = v.attrs.get("units", "")
            values = [x if isinstance(x, str) else number(x, "" if unit == "1" else unit) for x in np.ravel(v).tolist()]
            if any(value not in ("", "-") for value in values):
                words = v.attrs.get("long_name", SYMBOLS[str(name)].long_name if name in SYMBOLS else "")
                rows.append((f"{words} {name}".strip(), ", ".join(values)))
        return rows

    def _notes(self) -> list[str]:
        return [f"warning: {text}" for text in self._dataset.attrs.get("warnings", "").splitlines()]
