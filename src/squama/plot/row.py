"""A finite row of scales in panels: the inclination of every scale at some twists, and the torque."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.plot.palette import ACCENT, GREY, INK
from squama.plot.style import PAGE, angle_label, finite_max, label, letters, new_figure, prefixed, shades, styled
from squama.types import Array

LINES = 6
"""Twists at which values along the row are drawn."""


@styled
def row_figure(dataset: xr.Dataset) -> Figure:
    """Draw the inclinations along a finite row of :func:`squama.row` at some twists, and its torque.

    Left: inclination against the scale's number, a line per twist; grey ticks at the right: the endless beam. Right:
    torque of the row, and of the endless beam dashed.
    """
    figure = new_figure(PAGE, 2.8)
    left, right = figure.subplots(1, 2)
    phi, end = dataset["phi"].values, dataset.sizes["scale"] + 0.5
    touching = np.flatnonzero(phi >= float(dataset["phi_e"]))
    chosen = _some(touching) if touching.size else np.array([0])
    _inclinations(left, dataset, chosen)
    for i, colour in zip(chosen, shades(len(chosen)), strict=True):
        endless = np.degrees(float(dataset["theta_periodic"][i]))
        left.plot([end], [endless], color=colour, marker="_", markersize=8)
    factor, text = prefixed("T", finite_max(dataset["T"].values))
    right.plot(phi, factor * dataset["T"].values, color=INK, label=f"row of {dataset.sizes['scale']}")
    right.plot(phi, factor * dataset["T_periodic"].values, color=GREY, linestyle="--", label="endless beam")
    right.set_ylim(0, 1.25 * factor * finite_max(dataset["T"].values))
    right.axvline(float(dataset["phi_e"]), color=ACCENT, linewidth=0.7, linestyle=":")
    right.set(xlabel=angle_label("twisting"), ylabel=text)
    held = " on hinges" if dataset.attrs.get("joint") == "hinge" else ""
    right.legend(title=dataset.attrs.get("scales", "") + held)
    letters((left, right))
    return figure


@styled
def finite_figure(data: xr.Dataset) -> Figure:
    """Draw a finite beam of elements, from :func:`squama.fe.runs.cell`.

    Inclination and twist of every scale's pitch against the scale's number, a line per twist; torque over the mean
    twist, with the start's slope dashed.
    """
    figure = new_figure(PAGE, 2.8)
    left, middle, right = figure.subplots(1, 3)
    phi = data["phi"].values
    chosen = _some(np.arange(phi.size))
    _inclinations(left, data, chosen)
    for i, colour in zip(chosen, shades(len(chosen)), strict=True):
        middle.plot(data["scale"].values, data["twist"].values[i], color=colour, marker=".")
    middle.set(ylabel="Twist of a pitch (rad)", xlabel="scale")
    factor, text = prefixed("T", finite_max(np.abs(data["T"].values)))
    T = factor * data["T"].values
    if phi.size > 1:
        right.plot([0, phi[-1]], [0, T[1] / phi[1] * phi[-1]], color=GREY, linestyle="--")
    right.plot(phi, T, color=INK)
    right.set(xlabel=angle_label("twisting"), ylabel=text)
    letters((left, middle, right))
    return figure


def _some(places: Array) -> Array:
    """Return some of the places, evenly."""
    return np.unique(places[np.linspace(0, places.size - 1, LINES).round().astype(int)])


def _inclinations(ax: Axes, dataset: xr.Dataset, chosen: Array) -> None:
    """Draw the inclination of every scale, a line per twist."""
    for i, colour in zip(chosen, shades(len(chosen)), strict=True):
        theta, words = np.degrees(dataset["theta"].values[i]), f"{dataset['phi'].values[i]:.3g}"
        ax.plot(dataset["scale"].values, theta, color=colour, marker=".", label=words)
    ax.set(xlabel="scale", ylabel=label("theta", "deg"))
    low, high = ax.get_ylim()
    # room for the legend
    ax.set_ylim(low - 0.35 * (high - low), high)
    ax.legend(title=r"$\varphi$ (rad/pitch)", loc="lower left", ncols=3)
