"""A finite row in two panels: the inclination of every scale, and the torque beside the endless beam's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from squama.plot.style import (
    ACCENT,
    GREY,
    INK,
    PAGE,
    finite_max,
    key,
    label,
    letter,
    new_figure,
    prefixed,
    shades,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr

LINES = 6
"""Twists at which the inclinations along the row are drawn."""


@styled
def row_figure(dataset: xr.Dataset) -> Figure:
    """Draw the inclinations along a finite row at some twists, and its torque.

    Parameters
    ----------
    dataset : xarray.Dataset
        From :func:`squama.row`.

    Returns
    -------
    matplotlib.figure.Figure
        Left: inclination against the scale's number, a line per twist; grey ticks at the right: the endless beam.
        Right: torque of the row, and of the endless beam dashed.
    """
    figure = new_figure(PAGE, 2.8)
    left, right = figure.subplots(1, 2)
    phi = dataset["phi"].values
    touching = np.flatnonzero(phi >= float(dataset["phi_e"]))
    chosen = np.unique(touching[np.linspace(0, touching.size - 1, LINES).round().astype(int)]) if touching.size else [0]
    number = dataset["scale"].values
    for i, colour in zip(chosen, shades(len(chosen)), strict=True):
        at = dataset.isel(point=int(i))
        left.plot(number, np.degrees(at["theta"].values), color=colour, marker=".", label=f"{phi[i]:.3g}")
        left.plot([number[-1] + 0.5], [np.degrees(float(at["theta_periodic"]))], color=colour, marker="_", markersize=8)
    left.set_xlabel("scale")
    left.set_ylabel(label("theta", "deg"))
    left.legend(title=r"$\varphi$ (rad/pitch)")
    factor, text = prefixed("T", finite_max(dataset["T"].values))
    right.plot(phi, factor * dataset["T"].values, color=INK)
    right.plot(phi, factor * dataset["T_periodic"].values, color=GREY, linestyle="--")
    right.set_ylim(0, 1.25 * factor * finite_max(dataset["T"].values))
    right.axvline(float(dataset["phi_e"]), color=ACCENT, linewidth=0.7, linestyle=":")
    right.set_xlabel(r"Twist per pitch $\varphi$ (rad)")
    right.set_ylabel(text)
    right.legend(handles=[key(f"row of {number.size}"), key("endless beam", color=GREY, linestyle="--")])
    for ax, name in ((left, "(a)"), (right, "(b)")):
        letter(ax, name)
    return figure
