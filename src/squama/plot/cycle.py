"""A history of loading in two panels: loops of the torque, and energies."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.beam.design import Beam
from squama.loads import LOADS, ending
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK, UNLOADED


@style.styled
def cycle_figure(dataset: xr.Dataset) -> Figure:
    """Draw the loops of a history of loading and unloading from :func:`squama.cycle`, and its energies.

    Left: torque (moment) against twist (bend) per pitch, loading dark, unloading blue, drops at a reversal dashed, the
    beam without contact grey; engagement and residual twist after release marked. Right: elastic energy and frictional
    work along the path.
    """
    figure = style.new_figure(style.PAGE, 3.1)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    loops(dataset, left)
    energies(dataset, right)
    for ax in (left, right):
        style.degrees_above(ax, LOADS[dataset.attrs["load"]], Beam.from_toml_text(dataset.attrs["beam"]))
    extent = ending(dataset.attrs["ends"]) if "ends" in dataset.attrs else "as an endless beam"
    title = f"Cycles of {dataset.attrs['load']} {extent}: {style.about(dataset)}"
    return style.headline(figure, title, (left, right))


def loops(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the loops of :func:`squama.cycle`, torque (moment) against twist (bend) per pitch; the left of its figure.

    Loading and unloading have their own colours; engagement and residual twist after release are marked.
    """
    ax, names = style.panel(ax, dataset, "loop", "squama.cycle")
    angle = names.angle
    load, branch = dataset[angle].values, dataset["branch"].values
    factor, text = style.prefixed(names.torque, float(np.abs(dataset[names.torque].values).max()))
    values = factor * dataset[names.torque].values
    beam = Beam.from_toml_text(dataset.attrs["beam"])
    # torque per twist without contact
    slope = factor * dataset.attrs.get("rigidity", names.rigidity(beam)) / beam.pitch
    for name, words, look in (
        ("straight", "scales apart", {"color": GREY}),
        ("loading", "loading", {"color": INK}),
        ("unloading", "unloading", {"color": UNLOADED}),
        ("stick", "reversal: the scales stick", {"color": ACCENT, "linestyle": (0, (2, 1))}),
    ):
        mask = branch[1:] == name
        if mask.any():
            # segments with gaps between them
            x, y = (
                np.stack([v[:-1], v[1:], np.full(mask.size, np.nan)], axis=-1)[mask].ravel() for v in (load, values)
            )
            ax.plot(x, y, zorder=2, label=words, **look)
        places = np.flatnonzero(branch == name)
        if name in ("loading", "unloading") and places.size:
            # the direction of the longest way of either kind
            run = max(np.split(places, np.flatnonzero(np.diff(places) > 1) + 1), key=len)
            i = int(run[np.argmin(np.abs(load[run] - 0.5 * (load[run[0]] + load[run[-1]])))])
            if i > (j := max(i - 4, int(run[0]))):
                arrow = {"arrowstyle": "-|>", "color": look["color"], "linewidth": 0, "mutation_scale": 13}
                arrow |= {"shrinkA": 0, "shrinkB": 0}
                ax.annotate("", (load[i], values[i]), (load[j], values[j]), arrowprops=arrow)
    engaged = np.sort(dataset[f"{angle}_e"].values * np.where(dataset["sense"].values == "-", -1, 1))
    engaged = engaged[(engaged >= load.min()) & (engaged <= load.max())]
    if engaged.size:
        ax.plot(engaged, slope * engaged, color=INK, label="engagement", zorder=4, **style.ENGAGED)
    rest = np.unique(dataset[f"{angle}_residual"].values)
    rest = rest[rest != 0]
    if rest.size:
        ax.plot(rest, 0 * rest, "s", color=ACCENT, markersize=4, zorder=4, label="left when let go")
    ends = np.array([load.min(), load.max()])
    ax.plot(ends, slope * ends, zorder=1, label="no contact", **style.BARE | {"linewidth": 0.8})
    ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)
    ax.set(xlabel=style.angle_label(names.name), ylabel=text)
    ax.legend(loc="upper left")
    return ax


def energies(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw elastic energy and frictional work along the path of a history of :func:`squama.cycle`."""
    ax, names = style.panel(ax, dataset, "loop", "squama.cycle")
    load = dataset[names.angle].values
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(load)))])
    elastic, work = dataset["U_el"].values, dataset["W_fr"].values
    largest = float(max(elastic.max(), work.max()))
    factor, text = style.prefixed("U_el", largest)
    for name, values, colour in (("U_el", elastic, GREY), ("W_fr", work, ACCENT)):
        ax.plot(way, factor * values, color=colour, label=style.label(name).rpartition(" (")[0])
    ax.locator_params(axis="x", nbins=style.TICKS)
    ax.set(xlim=(0, way[-1]), ylim=(0, 1.3 * factor * largest))
    covered = f"{names.verb.capitalize()} covered so far (rad per pitch)"
    ax.set(xlabel=covered, ylabel=f"Energy per length {style.unit_of(text)}")
    ax.legend(loc="upper left")
    return ax
