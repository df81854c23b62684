"""A finite row of scales in panels: the inclination of every scale at some twists, and the torque."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from squama.loads import model
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK
from squama.types import Array

PLACE, TWISTS = "Scale, counted from the first", r"twist per pitch $\varphi$ (rad)"


@style.styled
def row_figure(dataset: xr.Dataset) -> Figure:
    """Draw the inclinations along a finite row of :func:`squama.row` at some twists, and its torque.

    Left: inclination against the scale's number, a line per twist; ticks at the right: the endless beam. Right: torque
    of the row, of the endless beam dashed, and where the scales engage.
    """
    figure = style.new_figure(style.PAGE, 3.3)
    left, right = figure.subplots(1, 2)
    inclinations(dataset, left)
    phi, count = dataset["phi"].values, dataset.sizes["scale"]
    factor, text = style.prefixed("T", style.finite_max(dataset["T"].values))
    right.plot(phi, factor * dataset["T"].values, color=INK, label=f"row of {count} scales")
    right.plot(phi, factor * dataset["T_periodic"].values, color=GREY, linestyle="--", label="endless beam")
    right.set_ylim(0, 1.25 * factor * style.finite_max(dataset["T"].values))
    right.axvline(float(dataset["phi_e"]), color=ACCENT, linewidth=0.7, linestyle=":", label="engagement")
    right.set(xlabel=style.angle_label("twisting"), ylabel=text)
    style.legend_under(right, right.get_legend_handles_labels()[0])
    about = f"{model(dataset.attrs)}, sense {dataset.attrs['sense']}, $\\mu$ = {float(dataset['mu']):g}"
    return style.headline(figure, f"Twisting of a row of {count} scales: {about}", (left, right))


def inclinations(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the inclination of every scale of :func:`squama.row`, a line per twist, beside the endless beam's."""
    ax, _ = style.panel(ax, dataset, "theta_periodic", "squama.row")
    touching = np.flatnonzero(dataset["phi"].values >= float(dataset["phi_e"]))
    mark: style.Look = {"marker": "_", "markersize": 8}
    chosen, handles = _inclinations(ax, dataset, touching if touching.size else np.array([0]))
    for i, colour in chosen:
        endless = np.degrees(float(dataset["theta_periodic"][i]))
        ax.plot([dataset.sizes["scale"] + 0.5], [endless], color=colour, **mark)
    handles.append(style.key("endless beam", linestyle="", **mark))
    style.legend_under(ax, handles, TWISTS)
    return ax


@style.styled
def finite_figure(data: xr.Dataset) -> Figure:
    """Draw a finite beam of elements, from :func:`squama.fe.runs.cell`.

    Inclination and twist of every scale's pitch against the scale's number, a line per twist; torque over the mean
    twist, with the start's slope dashed.
    """
    figure = style.new_figure(style.PAGE, 3.0)
    left, middle, right = figure.subplots(1, 3)
    phi = data["phi"].values
    chosen, handles = _inclinations(left, data, np.arange(phi.size))
    for i, colour in chosen:
        middle.plot(data["scale"].values, data["twist"].values[i], color=colour, marker=".")
    middle.set(ylabel="Twist of a pitch (rad)", xlabel=PLACE)
    middle.xaxis.set_major_locator(MaxNLocator(integer=True))
    factor, text = style.prefixed("T", style.finite_max(np.abs(data["T"].values)))
    T = factor * data["T"].values
    if phi.size > 1:
        look: style.Look = {"color": GREY, "linestyle": "--"}
        right.plot([0, phi[-1]], [0, T[1] / phi[1] * phi[-1]], **look)
        handles.append(style.key("slope of the torque at the start", **look))
    right.plot(phi, T, color=INK)
    right.set(xlabel=style.angle_label("twisting"), ylabel=text)
    style.legend_below(figure, handles, 7)
    about = f"Twisting of a beam of {data.sizes['scale']} scales by finite elements; a line for each {TWISTS}"
    return style.headline(figure, f"{about}\nScales: {data.attrs['plates']}", (left, middle, right))


def _inclinations(ax: Axes, dataset: xr.Dataset, places: Array) -> tuple[list[tuple[int, style.Colour]], list[Artist]]:
    """Draw the inclination of every scale at some points, evenly chosen; return these with colours, and a legend."""
    some = np.unique(places[np.linspace(0, places.size - 1, 6).round().astype(int)]).tolist()
    chosen, handles = list(zip(some, style.shades(len(some)), strict=True)), list[Artist]()
    for i, colour in chosen:
        look: style.Look = {"color": colour, "marker": "."}
        ax.plot(dataset["scale"].values, np.degrees(dataset["theta"].values[i]), **look)
        handles.append(style.key(f"{dataset['phi'].values[i]:.3g}", **look))
    ax.set(xlabel=PLACE, ylabel=style.label("theta", "deg"))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    return chosen, handles
