"""The plan of a test: expected standard error of each parameter over the top of the loop."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from squama.errors import refuse
from squama.loads import LOADS, model
from squama.plot.fit import NAMES
from squama.plot.palette import ACCENT, GREY, INK
from squama.plot.style import PAGE, Look, headline, key, legend_below, new_figure, panel, styled

_LOOKS: dict[str, Look] = {
    "loading": {"color": GREY, "marker": "x", "linestyle": ":"},
    "loop": {"color": INK, "marker": "o", "linestyle": "-"},
    "both senses": {"color": ACCENT, "marker": "^", "linestyle": "-."},
}
_WANTED: Look = {"color": GREY, "linewidth": 0.7, "linestyle": (0, (5, 3))}


@styled
def plan_figure(dataset: xr.Dataset) -> Figure:
    """Draw the expected errors of the loops of a test, a panel for each parameter, from :meth:`squama.Plan.dataset`."""
    names = [str(name) for name in dataset["parameter"].values]
    wide = min(len(names), 3)
    high = -(-len(names) // wide)
    figure = new_figure(PAGE, 0.9 + 2.3 * high)
    axes = figure.subplots(high, wide, squeeze=False).ravel()
    for ax in axes[len(names) :]:
        ax.set_visible(False)
    for name, ax in zip(names, axes, strict=False):
        expected_errors(dataset, name, ax)
    handles = [*axes[0].get_legend_handles_labels()[0], key("accuracy that is wanted", **_WANTED)]
    legend_below(figure, handles, len(handles))
    title = f"Expected errors of one loop in {LOADS[dataset.attrs['load']].name}: {model(dataset.attrs)}"
    return headline(figure, title, axes[: len(names)])


def expected_errors(dataset: xr.Dataset, name: str, ax: Axes | None = None) -> Axes:
    """Draw the standard error of one parameter over the top of the loops, from :meth:`squama.Plan.dataset`.

    Errors of ratios are absolute, others in per cent; the dashed line is the required accuracy.
    """
    ax, load = panel(ax, dataset, "loops", "Plan.dataset()")
    names = [str(each) for each in dataset["parameter"].values]
    if name not in names:
        refuse("name", f'"{name}"', "is not the name of a parameter of the plan", f"known are {', '.join(names)}")
    values = np.asarray(dataset.attrs["values"])
    value, plain = abs(float(values[names.index(name)])), dataset[f"error_{name}"].attrs["units"] == "1"
    factor = 1.0 if plain else 100 / value
    degrees = np.degrees(dataset["total"].values)
    for shape in dict.fromkeys(dataset["loop"].values.tolist()):
        own = dataset["loop"].values == shape
        ax.plot(degrees[own], factor * dataset[f"error_{name}"].values[own], label=shape, markersize=4, **_LOOKS[shape])
    ax.axhline(factor * value * dataset.attrs["accuracy"], **_WANTED)
    ax.set(yscale="log", xlabel=f"Largest {load.verb} of the beam (deg)")
    ax.set_ylabel(f"Error of {NAMES[name]}{'' if plain else ' (%)'}")
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_formatter(Plain(minor_thresholds=(1.5, 0.5)))
    return ax


class Plain(LogFormatter):
    """Ticks of a logarithmic axis without exponents: 0.6 in place of 6e-01."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a tick, or "" where there is none."""
        return f"{x:g}" if super().__call__(x, pos) else ""
