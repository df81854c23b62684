"""The plane of bend and twist: regimes, moment and torque over it, with paths drawn in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from squama.beam.design import Beam
from squama.errors import refuse
from squama.loads import HELD
from squama.model.outcome import End
from squama.plot import style
from squama.plot.palette import ACCENT, ENDS, GREY, INK, KEPT, UNLOADED
from squama.types import Array
from squama.units import shown

CONTACTS = {"": GREY, "TS": KEPT[0], "CF": KEPT[0], "BF": KEPT[1], "TA": KEPT[2], "TF": INK}
"""Colours of contacts; those at the base have another."""
FAINT, LEVELS = 0.18, (20, 30, 40, 50, 60, 70, 80)
"""How strong they are behind a path, and inclinations with a line, degrees."""
READABLE = 95.0
"""Contours of a load go up to this percentile of it: near a lock it grows without bound."""
LINES = 11
"""Contours of a load, about."""


@style.styled
def plane_figure(dataset: xr.Dataset, paths: Sequence[xr.Dataset] = ()) -> Figure:
    """Draw a map from :func:`squama.bend_twist_map`: (a) contacts, locks, inclination; (b) moment; (c) torque.

    Axes in rad/m below and left, in deg per pitch above and right; the line on which a scale's tip edge lies flush in
    the next face dashed; ``paths`` of :func:`squama.bend_twist` are drawn in, their events marked.

    >>> import squama
    >>> beam = squama.Beam.from_ratios(mu=0.2)
    >>> way = "bend 0.1 rad/pitch; twist 0.15 rad/pitch"
    >>> m = squama.bend_twist_map(beam, way, joint="hinge", points=21)
    >>> len(plane_figure(m, [squama.bend_twist(beam, way, joint="hinge")]).axes)
    5
    """
    figure = style.new_figure(style.PAGE, 3.3)
    axes = figure.subplots(1, 3, sharex=True, sharey=True)
    degrees = np.degrees(Beam.from_toml_text(dataset.attrs["beam"]).pitch)
    handles = _contacts(axes[0], dataset, paths)
    for ax, name in zip(axes[1:], ("M", "T"), strict=True):
        plane_load(dataset, name, ax, paths=paths)
        ax.set_ylabel("")
    for ax, words in zip(axes, ("(a) contacts, locks, $\\theta$", "(b) moment", "(c) torque"), strict=True):
        style.letter(ax, words)
        style.scaled_above(ax, degrees, "deg per pitch").xaxis.label.set_fontsize(7)
    beside = axes[0].secondary_yaxis("right", functions=(lambda v: v * degrees, lambda v: v / degrees))
    beside.set_ylabel("deg per pitch", fontsize=7)
    beside.tick_params(labelsize=7)
    style.legend_below(figure, handles, 5)
    held = f"{dataset.attrs['scales']} on {HELD[dataset.attrs['joint']]}"
    return style.headline(figure, f"{held}, $\\mu$ = {float(dataset['mu']):g}; every state straight from rest")


def plane_contacts(dataset: xr.Dataset, ax: Axes | None = None, *, paths: Sequence[xr.Dataset] = ()) -> Axes:
    """Draw contacts, locks and inclinations of :func:`squama.bend_twist_map`, with paths of ``bend_twist`` in them."""
    ax, _ = style.panel(ax, dataset, "state", "squama.bend_twist_map")
    style.legend_under(ax, _contacts(ax, dataset, paths))
    return ax


def plane_load(dataset: xr.Dataset, name: str, ax: Axes | None = None, *, paths: Sequence[xr.Dataset] = ()) -> Axes:
    """Draw moment ``"M"`` or torque ``"T"`` of :func:`squama.bend_twist_map` as contours with a bar of colours.

    ``paths`` of :func:`squama.bend_twist` are drawn in.
    """
    ax, _ = style.panel(ax, dataset, "state", "squama.bend_twist_map")
    if name not in ("M", "T"):
        refuse("name", shown(name), "is no load of this plane", "allowed: M, T")
    _load(ax, dataset, name)
    _frame(ax, dataset, paths)
    return ax


def _contacts(ax: Axes, dataset: xr.Dataset, paths: Sequence[xr.Dataset]) -> list[Patch]:
    """Draw contacts over the rates of bend and twist; return what a legend says of them."""
    handles = regimes(ax, dataset, (dataset["kappa"].values, dataset["Phi"].values))
    _frame(ax, dataset, paths)
    return handles


def flush(ax: Axes, dataset: xr.Dataset, look: style.Look) -> None:
    """Draw the line on which a scale's tip edge lies flush in the next face."""
    slope = np.tan(Beam.from_toml_text(dataset.attrs["beam"]).scale.alpha)
    ax.axline((0, 0), slope=slope, linestyle=style.DASHED, **look)


def _frame(ax: Axes, dataset: xr.Dataset, paths: Sequence[xr.Dataset]) -> None:
    """Draw where a scale's tip edge lies flush in the next face, paths, and the axes."""
    flush(ax, dataset, {"color": INK, "linewidth": 0.7})
    for path in paths:
        _path(ax, path)
    (left, right), (low, high) = (dataset[name].values[[0, -1]] for name in ("kappa", "Phi"))
    ax.set(xlim=(left, right), ylim=(low, high), xlabel=style.label("kappa"), ylabel=style.label("Phi"))
    ax.locator_params(nbins=style.TICKS)


def regimes(ax: Axes, plane: xr.Dataset, where: tuple[Array, Array]) -> list[Patch]:
    """Draw contacts, what ends the way to a state, and inclinations, at places along both axes; return the legend."""
    state, contact = plane["state"].values.T, plane["contact"].values.T
    ended = ~np.isin(state, ("open", "sliding"))
    word = np.where(ended, state, np.where(state == "open", "no contact", contact))
    colours = {"no contact": to_rgba("white")}
    for name in np.unique(word[~ended]).tolist():
        colours.setdefault(name, to_rgba(CONTACTS.get(name, UNLOADED), FAINT))
    colours |= {name: to_rgba(ENDS.get(name, GREY), 0.55) for name in np.unique(word[ended]).tolist()}
    ground = np.array([[colours[name] for name in row] for row in word.tolist()])
    box = (where[0][0], where[0][-1], where[1][0], where[1][-1])
    ax.imshow(ground, extent=box, origin="lower", aspect="auto", interpolation="nearest", zorder=0)
    theta = np.degrees(np.where(state == "sliding", plane["theta"].values.T, np.nan))
    if np.isfinite(theta).any():
        lines = ax.contour(*where, theta, levels=LEVELS, colors=GREY, linewidths=0.5, zorder=1)
        ax.clabel(lines, fmt="%g°", fontsize=6)
    present = dict.fromkeys(["no contact", *np.unique(word).tolist()])
    return [Patch(facecolor=colours[name], edgecolor=GREY, linewidth=0.4, label=name) for name in present]


def _load(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw a moment or torque as filled contours with a bar of its own."""
    values = dataset[name].values.T
    ax.set_facecolor(to_rgba(GREY, 0.35))
    if not np.isfinite(values).any():
        return
    low, high = float(np.nanmin(values)), float(np.nanpercentile(values, READABLE))
    factor, text = style.prefixed(name, max(abs(low), abs(high)))
    # closer together where little has happened yet
    levels = low + (high - low) * np.linspace(0, 1, LINES) ** 2
    # in numbers that can be read, none of them -0
    digits = 1 - int(np.floor(np.log10(max(factor * (high - low), 1e-300))))
    levels = np.unique(np.round(factor * levels, digits) + 0.0)
    drawn = ax.contourf(dataset["kappa"], dataset["Phi"], factor * values, levels=levels, cmap="viridis", extend="both")
    bar = ax.figure.colorbar(drawn, ax=ax, format="%.3g", pad=0.03)
    bar.set_label(text)
    bar.ax.tick_params(labelsize=7)


def _path(ax: Axes, path: xr.Dataset) -> None:
    """Draw a path and its events, the end crossed where it is not that of the path."""
    line: style.Look = {"color": ACCENT, "zorder": 4}
    ax.plot(path["kappa"], path["Phi"], linewidth=1.4, **line)
    ax.plot(path["kappa_event"], path["Phi_event"], "o", markersize=3, markerfacecolor="white", **line)
    if path["end"].item() != End.RANGE:
        ax.plot(path["kappa_end"], path["Phi_end"], "X", markersize=4.5, **line)
