"""A path in the plane of bend and twist, and what the beam opposes to it along the way."""

from __future__ import annotations

import itertools

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.loads import HELD, covering
from squama.model.outcome import End
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK, UNLOADED
from squama.plot.plane import CONTACTS, flush, regimes
from squama.plot.response import BESIDE, EACH, READABLE, WITHOUT_ENDS
from squama.types import Array

WAY = "Way gone (rad per pitch)"


@style.styled
def path_figure(dataset: xr.Dataset, plane: xr.Dataset | None = None, hinge: xr.Dataset | None = None) -> Figure:
    """Draw a path from :func:`squama.bend_twist`: in the plane of bend and twist, and moment and torque along it.

    Left: the path in the colours of its contacts (those of the scaled face), the line on which a scale's tip edge lies
    flush in the next face dashed, events marked; behind it, where ``plane`` is given (:func:`squama.bend_twist_map`),
    the contacts all over the plane, lines of equal inclination, and where straight ways from rest end before. Right:
    moment and torque over the way gone, with their jumps (the axis ends before a lock), and the inclination, of N
    scales each thin, with their mean, and dotted those of the endless beam; ``hinge``,
    the answer of hinges for the same path, is drawn thin beside them, as far as the axes of the dataset alone go.

    >>> import squama
    >>> r = squama.bend_twist(squama.Beam.from_ratios(), "bend 0.1 rad/pitch; twist 0.15 rad/pitch", mu=0.2)
    >>> len(path_figure(r).axes)
    3
    """
    figure = style.new_figure(style.PAGE, 3.2)
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.15), height_ratios=(1.5, 1))
    left, loads = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
    theta = figure.add_subplot(grid[1, 1], sharex=loads)
    way = _gone(dataset)
    plane_path(dataset, left, plane=plane)
    path_loads(dataset, loads, hinge=hinge)
    loads.set_xlabel("")
    inclined = np.degrees(dataset["theta"].values)
    if "scale" in dataset["theta"].dims:
        theta.plot(way, inclined, color=INK, **EACH)
        theta.plot(way, np.degrees(dataset["theta_periodic"].values), color=INK, **WITHOUT_ENDS)
        inclined = inclined.mean(axis=1)
    theta.plot(way, inclined, color=INK, label="scaled face")
    if "theta_other" in dataset:
        theta.plot(way, np.degrees(dataset["theta_other"].values), color=ACCENT, label="other face")
        theta.legend(loc="best")
    if hinge is not None:
        with style.within(theta):
            theta.plot(_gone(hinge), np.degrees(hinge["theta"].values), color=INK, **BESIDE)
    theta.set(xlabel=WAY, ylabel=r"$\theta$ (deg)")
    loads.tick_params(labelbottom=False)
    held = f"{dataset.attrs['scales']} on {HELD[dataset.attrs['joint']]}{covering(dataset.attrs)}"
    if "ends" in dataset.attrs:
        held = f"{dataset.sizes['scale']} scales, {dataset.attrs['ends']} ends: {held}"
    return style.headline(figure, f"Bent and twisted: {held}, $\\mu$ = {float(dataset['mu']):g}", (left, loads, theta))


def _gone(dataset: xr.Dataset) -> Array:
    """Return the way gone (n,) in the strains that the path names, rad per pitch."""
    strains = np.column_stack([dataset["psi"].values, dataset["phi"].values])
    steps = np.diff(strains, axis=0, prepend=0.0) * np.any(np.reshape(dataset.attrs["path"], (-1, 2)), axis=0)
    return np.cumsum(np.hypot(*steps.T))


def plane_path(dataset: xr.Dataset, ax: Axes | None = None, *, plane: xr.Dataset | None = None) -> Axes:
    """Draw a path of :func:`squama.bend_twist` in the plane of bend and twist per pitch, in colours of its contacts.

    Behind it, if ``plane`` is given, what :func:`squama.bend_twist_map` found; the left of its figure.
    """
    ax, _ = style.panel(ax, dataset, "event", "squama.bend_twist")
    if plane is not None:
        regimes(ax, plane, (plane["psi"].values, plane["phi"].values))
    psi, phi, contact = (dataset[name].values for name in ("psi", "phi", "contact"))
    seen = set()
    for start, stop in runs(contact):
        name = str(contact[start])
        text = (name or "no contact") if name not in seen else None
        seen.add(name)
        whole = slice(max(0, start - 1), stop)
        ax.plot(psi[whole], phi[whole], color=CONTACTS.get(name, UNLOADED), linewidth=1.6, label=text)
    low, high, bottom, top = psi.min(), psi.max(), phi.min(), phi.max()
    line: style.Look = {"label": r"$\varphi = \psi\,\tan\alpha$", "color": GREY, "linewidth": 0.8, "zorder": 1}
    flush(ax, dataset, line)
    point: style.Look = {"linestyle": "", "markersize": 3.5, "zorder": 4}
    ax.plot(dataset["psi_event"], dataset["phi_event"], color=INK, marker="o", markerfacecolor="white", **point)
    if (end := str(dataset["end"].item())) != End.RANGE:
        ax.plot(dataset["psi_end"], dataset["phi_end"], color=ACCENT, marker="X", label=end, **point)
    room = 0.1 * max(high - low, top - bottom)
    ax.set(xlim=(low - room, high + room), ylim=(bottom - room, top + room))
    ax.set(xlabel=style.angle_label("bending"), ylabel=style.angle_label("twisting"))
    ax.locator_params(nbins=style.TICKS)
    ax.legend(loc="best", frameon=True, framealpha=0.85, edgecolor="none")
    return ax


def path_loads(dataset: xr.Dataset, ax: Axes | None = None, *, hinge: xr.Dataset | None = None) -> Axes:
    """Draw moment and torque of :func:`squama.bend_twist` along the way; the axis ends before a lock.

    ``hinge``, the answer of hinges for the same path, is drawn thin as far as these axes go.
    """
    ax, _ = style.panel(ax, dataset, "event", "squama.bend_twist")
    way = _gone(dataset)
    both = {name: dataset[name].values for name in ("M", "T")}
    factor, text = style.prefixed("M", max(float(np.abs(v).max()) for v in both.values()))
    for (name, values), colour in zip(both.items(), (UNLOADED, INK), strict=True):
        ax.plot(way, factor * values, color=colour, label=f"${name}$")
        if f"{name}_periodic" in dataset:
            beside = factor * dataset[f"{name}_periodic"].values
            ax.plot(way, beside, color=colour, label=f"${name}$, endless", **WITHOUT_ENDS)
    ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)
    ax.set(xlabel=WAY, xlim=(0, way[-1]), ylabel=f"$M$, $T$ {style.unit_of(text)}")
    if End(dataset["end"].item()).locks:
        before = way <= READABLE * way[-1]
        shown = np.array([values[before] for values in both.values()]) * factor
        ax.set_ylim(1.1 * min(0.0, shown.min()), 1.3 * max(shown.max(), 0.0))
    if hinge is not None:
        with style.within(ax):
            for name, colour in zip(both, (UNLOADED, INK), strict=True):
                text = f"${name}$ on hinges"
                ax.plot(_gone(hinge), factor * hinge[name].values, color=colour, label=text, **BESIDE)
    # over the hinge's lines, which leave the axes early
    ax.legend(loc="upper left" if hinge is None else "best", frameon=True, framealpha=0.85, edgecolor="none")
    return ax


def runs(words: Array) -> list[tuple[int, int]]:
    """Return where runs of equal words start and stop."""
    cuts = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist(), len(words)]
    return list(itertools.pairwise(cuts))
