"""A path in the plane of bend and twist, and what the beam opposes to it along the way."""

from __future__ import annotations

import itertools

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.beam.design import Beam
from squama.loads import HELD
from squama.plot.palette import ACCENT, GREY, INK, KEPT, UNLOADED
from squama.plot.style import PAGE, TICKS, Look, angle_label, headline, letters, new_figure, prefixed, styled
from squama.types import Array

CONTACTS = {"": GREY, "TS": KEPT[0], "CF": KEPT[0], "BF": KEPT[1], "TA": KEPT[2]}
"""Colours of contacts; base contacts have the last one."""


@styled
def path_figure(dataset: xr.Dataset) -> Figure:
    """Draw a path from :func:`squama.bend_twist`: in the plane of bend and twist, and moment and torque along it.

    Left: the path in the colours of its contacts, the line on which a scale's tip edge lies flush in the next face
    dashed, events marked. Right: moment and torque over the way gone, with their jumps, and the inclination.

    >>> import squama
    >>> r = squama.bend_twist(squama.Beam.from_ratios(), "bend 0.1 rad/pitch; twist 0.15 rad/pitch", mu=0.2)
    >>> len(path_figure(r).axes)
    3
    """
    figure = new_figure(PAGE, 3.2)
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.15), height_ratios=(1.5, 1))
    plane, loads = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
    theta = figure.add_subplot(grid[1, 1], sharex=loads)
    steps = np.hypot(np.diff(dataset["psi"].values), np.diff(dataset["phi"].values))
    way = np.concatenate([[0.0], np.cumsum(steps)])
    _plane(plane, dataset)
    _loads(loads, dataset, way)
    theta.plot(way, np.degrees(dataset["theta"].values), color=INK)
    theta.set(xlabel="Way gone (rad per pitch)", ylabel=r"$\theta$ (deg)", xlim=(0, way[-1]))
    loads.tick_params(labelbottom=False)
    held = f"{dataset.attrs['scales']} on {HELD[dataset.attrs['joint']]}"
    headline(figure, f"Bent and twisted: {held}, $\\mu$ = {float(dataset['mu']):g}")
    letters((plane, loads, theta))
    return figure


def _plane(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the path in its plane."""
    psi, phi, contact = (dataset[name].values for name in ("psi", "phi", "contact"))
    seen = set()
    for start, stop in runs(contact):
        name = str(contact[start])
        text = (name or "no contact") if name not in seen else None
        seen.add(name)
        ax.plot(psi[start:stop], phi[start:stop], color=CONTACTS.get(name, UNLOADED), linewidth=1.6, label=text)
    low, high = ax.get_xlim()
    bottom, top = ax.get_ylim()
    slope = np.tan(Beam.from_toml_text(dataset.attrs["beam"]).scale.alpha)
    line: Look = {"color": GREY, "linestyle": (0, (4, 2)), "linewidth": 0.8, "zorder": 1}
    ax.axline((0, 0), slope=slope, label=r"$\varphi = \psi\,\tan\alpha$", **line)
    point: Look = {"linestyle": "", "markersize": 3.5, "zorder": 4, "color": INK}
    ax.plot(dataset["psi_event"], dataset["phi_event"], marker="o", markerfacecolor="white", **point)
    if dataset["end"].item() != "range end":
        end = str(dataset["end"].item())
        ax.plot(dataset["psi_end"], dataset["phi_end"], **(point | {"marker": "X", "color": ACCENT}), label=end)
    room = 0.06 * max(high - low, top - bottom)
    ax.set(xlim=(low - room, high + room), ylim=(bottom - room, top + room))
    ax.set(xlabel=angle_label("bending"), ylabel=angle_label("twisting"))
    ax.locator_params(nbins=TICKS)
    ax.legend(loc="best")


def _loads(ax: Axes, dataset: xr.Dataset, way: Array) -> None:
    """Draw moment and torque along the way."""
    both = {name: dataset[name].values for name in ("M", "T")}
    factor, text = prefixed("M", max(float(np.abs(v).max()) for v in both.values()))
    for (name, values), colour in zip(both.items(), (UNLOADED, INK), strict=True):
        ax.plot(way, factor * values, color=colour, label=f"${name}$")
    ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)
    ax.set(ylabel=f"$M$, $T$ {text[text.rindex('(') :]}")
    ax.legend(loc="upper left")


def runs(words: Array) -> list[tuple[int, int]]:
    """Return where runs of equal words start and stop."""
    cuts = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist(), len(words)]
    return list(itertools.pairwise(cuts))
