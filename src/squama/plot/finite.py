"""A finite beam of elements in three panels: inclination and local twist of every scale, and the torque."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from squama.plot.style import GREY, INK, PAGE, finite_max, label, letter, new_figure, prefixed, shades, styled

if TYPE_CHECKING:
    import xarray as xr

LINES = 6
"""Twists at which values along the beam are drawn."""


@styled
def finite_figure(data: xr.Dataset) -> Figure:
    """Draw a run of a finite beam.

    Parameters
    ----------
    data : xarray.Dataset
        From :func:`squama.fe.facade_beam.beam`.

    Returns
    -------
    matplotlib.figure.Figure
        Inclination and twist of every scale's pitch against the scale's number, a line per twist; torque over the mean
        twist, with the start's slope dashed.
    """
    figure = new_figure(PAGE, 2.8)
    left, middle, right = figure.subplots(1, 3)
    phi, number = data["phi"].values, data["scale"].values
    chosen = np.unique(np.linspace(0, phi.size - 1, LINES).round().astype(int))
    for i, colour in zip(chosen, shades(len(chosen)), strict=True):
        at = data.isel(point=int(i))
        left.plot(number, np.degrees(at["theta"].values), color=colour, marker=".", label=f"{phi[i]:.3g}")
        middle.plot(number, at["twist"].values, color=colour, marker=".")
    left.set_ylabel(label("theta", "deg"))
    left.legend(title=r"$\varphi$ (rad/pitch)")
    middle.set_ylabel("Twist of a pitch (rad)")
    for ax in (left, middle):
        ax.set_xlabel("scale")
    factor, text = prefixed("T", finite_max(np.abs(data["T"].values)))
    T = factor * data["T"].values
    if phi.size > 1:
        right.plot([0, phi[-1]], [0, T[1] / phi[1] * phi[-1]], color=GREY, linestyle="--")
    right.plot(phi, T, color=INK)
    right.set_xlabel(r"Twist per pitch $\varphi$ (rad)")
    right.set_ylabel(text)
    for ax, name in ((left, "(a)"), (middle, "(b)"), (right, "(c)")):
        letter(ax, name)
    return figure
