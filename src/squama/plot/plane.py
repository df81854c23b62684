"""The plane of bend and twist: regimes, moment and torque over it, paths in it, and the loads along a path."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from squama.beam.design import Beam
from squama.errors import refuse
from squama.loads import HELD, LOADS, covering, ending
from squama.model.outcome import End
from squama.model.screw import WORDS
from squama.plot import style
from squama.plot.palette import ACCENT, ENDS, GREY, INK, KEPT, READABLE, UNLOADED
from squama.plot.response import BESIDE, EACH, WITHOUT_ENDS
from squama.types import Array
from squama.units import shown

CONTACTS = {"": GREY, "TS": KEPT[0], "CF": KEPT[0], "BF": KEPT[1], "TA": KEPT[2], "TF": INK}
"""Colours of contacts; contacts at the base have another."""
PAIRS = {
    frozenset({"BF", "TF"}): "#7f5fa8",
    frozenset({"BF", "TS"}): "#2f8f5b",
    frozenset({"TF", "TS"}): "#8c2d4f",
}
"""Colours of pairs of simultaneous contacts."""
BOX: style.Look = {"loc": "best", "frameon": True, "framealpha": 0.85, "edgecolor": "none"}
"""Settings of a legend that lies over lines."""
FLUSH = r"$\varphi = \psi\,\tan\alpha$"
"""Name of the line on which a scale's tip edge lies flush in the next face."""
_FRAMED: style.Look = {"color": INK, "linewidth": 0.7, "linestyle": style.DASHED}
WAY = "Length of the path (rad per pitch)"


def said(name: str) -> str:
    """Return a contact, or simultaneous contacts, in words with their letters."""
    return " and ".join(f"{WORDS[one]} ({one})" if one in WORDS else one for one in sorted(name.split("+")))


def coloured(name: str) -> str:
    """Return the colour of a contact, or of two simultaneous contacts."""
    return CONTACTS.get(name) or PAIRS.get(frozenset(name.split("+")), UNLOADED)


@style.styled
def plane_figure(dataset: xr.Dataset, paths: Sequence[xr.Dataset] = ()) -> Figure:
    """Draw a map from :func:`squama.bend_twist_map`: (a) contacts, locks, inclination; (b) moment; (c) torque.

    Axes in rad/m below and left, in deg per pitch above and right. Dashed: the line on which a scale's tip edge lies
    flush in the next face. ``paths`` of :func:`squama.bend_twist` are added, with marks at their events.

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
    drawn = (child for child in axes[0].get_children() if isinstance(child, QuadContourSet))
    inclined = any(np.size(path.vertices) for contours in drawn for path in contours.get_paths())
    first = "(a) contacts, locks" + ", lines of $\\theta$" * inclined
    for ax, words in zip(axes, (first, "(b) moment", "(c) torque"), strict=True):
        style.letter(ax, words)
        style.scaled_above(ax, degrees, "deg per pitch").xaxis.label.set_fontsize(7)
    style.scaled_right(axes[0], degrees, "deg per pitch").yaxis.label.set_fontsize(7)
    style.legend_below(figure, handles, 5)
    held = f"{dataset.attrs['scales']} on {HELD[dataset.attrs['joint']]}, $\\mu$ = {float(dataset['mu']):g}"
    return style.headline(figure, f"Bent and twisted: {held}; every state straight from rest")


def plane_contacts(dataset: xr.Dataset, ax: Axes | None = None, *, paths: Sequence[xr.Dataset] = ()) -> Axes:
    """Draw contacts, locks and inclinations of :func:`squama.bend_twist_map`, and paths of ``bend_twist``."""
    ax, _ = style.panel(ax, dataset, "state", "squama.bend_twist_map")
    style.legend_under(ax, _contacts(ax, dataset, paths))
    return ax


def plane_load(dataset: xr.Dataset, name: str, ax: Axes | None = None, *, paths: Sequence[xr.Dataset] = ()) -> Axes:
    """Draw moment ``"M"`` or torque ``"T"`` of :func:`squama.bend_twist_map` as contours with a colour bar.

    ``paths`` of :func:`squama.bend_twist` are added.
    """
    ax, _ = style.panel(ax, dataset, "state", "squama.bend_twist_map")
    if name not in ("M", "T"):
        refuse("name", shown(name), "is no load of this plane", "allowed: M, T")
    values = dataset[name].values.T
    ax.set_facecolor(to_rgba(GREY, 0.35))
    if np.isfinite(values).any():
        # near a lock a load grows without bound: contours go up to this percentile
        low, high = float(np.nanmin(values)), float(np.nanpercentile(values, 95.0))
        factor, text = style.prefixed(name, max(abs(low), abs(high)))
        levels = MaxNLocator(10).tick_values(factor * low, factor * high)
        look: style.Look = {"levels": levels, "cmap": "viridis", "extend": "both"}
        drawn = ax.contourf(dataset["kappa"], dataset["Phi"], factor * values, **look)
        bar = ax.figure.colorbar(drawn, ax=ax, format="%.3g", pad=0.03)
        bar.set_label(text)
        bar.ax.tick_params(labelsize=7)
    _frame(ax, dataset, paths)
    return ax


def _contacts(ax: Axes, dataset: xr.Dataset, paths: Sequence[xr.Dataset]) -> list[Artist]:
    """Draw contacts over the rates of bend and twist, and paths; return the handles of the legend."""
    handles = _regimes(ax, dataset, (dataset["kappa"].values, dataset["Phi"].values))
    _frame(ax, dataset, paths)
    path = style.key("path with its events", color=ACCENT, marker="o", markersize=3, markerfacecolor="white")
    return [*handles, style.key(FLUSH, **_FRAMED), *([path] if paths else [])]


def _flush(ax: Axes, dataset: xr.Dataset, look: style.Look) -> None:
    """Draw the line on which a scale's tip edge lies flush in the next face."""
    slope = np.tan(Beam.from_toml_text(dataset.attrs["beam"]).scale.alpha)
    ax.axline((0, 0), slope=slope, **look)


def _frame(ax: Axes, dataset: xr.Dataset, paths: Sequence[xr.Dataset]) -> None:
    """Draw the flush line, paths with their events (an early end crossed), and the axes."""
    _flush(ax, dataset, _FRAMED)
    for path in paths:
        line: style.Look = {"color": ACCENT, "zorder": 4}
        ax.plot(path["kappa"], path["Phi"], linewidth=1.4, **line)
        ax.plot(path["kappa_event"], path["Phi_event"], "o", markersize=3, markerfacecolor="white", **line)
        if path["end"].item() != End.RANGE:
            ax.plot(path["kappa_end"], path["Phi_end"], "X", markersize=4.5, **line)
    (left, right), (low, high) = (dataset[name].values[[0, -1]] for name in ("kappa", "Phi"))
    ax.set(xlim=(left, right), ylim=(low, high), xlabel=style.label("kappa"), ylabel=style.label("Phi"))
    ax.locator_params(nbins=style.TICKS)


def _regimes(ax: Axes, plane: xr.Dataset, where: tuple[Array, Array]) -> list[Patch]:
    """Draw contacts, ends before a state, and inclinations, at coordinates ``where``; return the legend's handles."""
    state, contact = plane["state"].values.T, plane["contact"].values.T
    ended = ~np.isin(state, ("open", "sliding"))
    word = np.where(ended, state, np.where(state == "open", "no contact", contact))
    colours = {"no contact": to_rgba("white")}
    for name in np.unique(word[~ended]).tolist():
        # faint, as a background of paths
        colours.setdefault(name, to_rgba(coloured(name), 0.18))
    colours |= {name: to_rgba(ENDS.get(name, GREY), 0.55) for name in np.unique(word[ended]).tolist()}
    ground = np.array([[colours[name] for name in row] for row in word.tolist()])
    box = (where[0][0], where[0][-1], where[1][0], where[1][-1])
    ax.imshow(ground, extent=box, origin="lower", aspect="auto", interpolation="nearest", zorder=0)
    theta = np.degrees(np.where(state == "sliding", plane["theta"].values.T, np.nan))
    if np.isfinite(theta).any():
        # at theta0 a line would follow the engagement
        rest = np.degrees(Beam.from_toml_text(plane.attrs["beam"]).scale.theta0)
        levels = [level for level in range(20, 90, 10) if abs(level - rest) > 1]
        lines = ax.contour(*where, theta, levels=levels, colors=GREY, linewidths=0.5, zorder=1)
        ax.clabel(lines, fmt="%g°", fontsize=6)
    present = dict.fromkeys(["no contact", *np.unique(word).tolist()])
    named = {said(name): colours[name] for name in present}
    return [Patch(facecolor=colour, label=text, edgecolor=GREY, linewidth=0.4) for text, colour in named.items()]


@style.styled
def path_figure(dataset: xr.Dataset, plane: xr.Dataset | None = None, hinge: xr.Dataset | None = None) -> Figure:
    """Draw a path from :func:`squama.bend_twist`: in the plane of bend and twist, and moment and torque along it.

    Left: the path in the colours of its contacts (those of the scaled face), dashed the line on which a scale's tip
    edge lies flush in the next face, events marked; with ``plane`` (:func:`squama.bend_twist_map`) also the contacts
    over the plane, lines of equal inclination, and states that straight paths from rest do not reach. Right: moment and
    torque along the path, with their jumps (the axis ends before a lock), and the inclination: for N scales each scale
    thin, their mean, and the endless beam dotted. ``hinge``, the response on hinges to the same path, is drawn thin
    within the axes of the dataset alone.

    >>> import squama
    >>> r = squama.bend_twist(squama.Beam.from_ratios(), "bend 0.1 rad/pitch; twist 0.15 rad/pitch", mu=0.2)
    >>> len(path_figure(r).axes)
    3
    """
    figure = style.new_figure(style.PAGE, 3.5)
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.15), height_ratios=(1.5, 1))
    left, loads = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
    theta = figure.add_subplot(grid[1, 1], sharex=loads)
    if legend := plane_path(dataset, left, plane=plane).get_legend():
        # below the panels, where it lies over nothing
        legend.remove()
        each = [style.key("each scale, in (c)", color=INK, **EACH)] if "scale" in dataset["theta"].dims else []
        style.legend_below(figure, [*left.get_legend_handles_labels()[0], *each], 4)
    beam = Beam.from_toml_text(dataset.attrs["beam"])
    style.degrees_above(left, LOADS["bending"], beam)
    style.scaled_right(left, *style.over_beam(LOADS["twisting"], beam))
    path_loads(dataset, loads, hinge=hinge)
    loads.set_xlabel("")
    way, inclined = _path_length(dataset), np.degrees(dataset["theta"].values)
    if "scale" in dataset["theta"].dims:
        theta.plot(way, inclined, color=INK, **EACH)
        theta.plot(way, np.degrees(dataset["theta_periodic"].values), color=INK, **WITHOUT_ENDS)
        inclined = inclined.mean(axis=1)
    theta.plot(way, inclined, color=INK, label="scaled face")
    if "theta_other" in dataset:
        inclined = np.degrees(dataset["theta_other"].values).reshape(way.size, -1).mean(axis=1)
        theta.plot(way, inclined, color=ACCENT, label="other face")
        theta.legend(loc="best")
    if hinge is not None:
        with style.within(theta):
            theta.plot(_path_length(hinge), np.degrees(hinge["theta"].values), color=INK, **BESIDE)
    theta.set(xlabel=WAY, ylabel=r"$\theta$ (deg)")
    loads.tick_params(labelbottom=False)
    held = f"{dataset.attrs['scales']} on {HELD[dataset.attrs['joint']]}{covering(dataset.attrs)}"
    if "ends" in dataset.attrs:
        held = f"{dataset.sizes['scale']} scales {ending(dataset.attrs['ends'])}: {held}"
    return style.headline(figure, f"Bent and twisted: {held}, $\\mu$ = {float(dataset['mu']):g}", (left, loads, theta))


def _path_length(dataset: xr.Dataset) -> Array:
    """Return the length (n,) of the path in its prescribed strains, rad per pitch."""
    strains = np.column_stack([dataset["psi"].values, dataset["phi"].values])
    steps = np.diff(strains, axis=0, prepend=0.0) * np.any(np.reshape(dataset.attrs["path"], (-1, 2)), axis=0)
    return np.cumsum(np.hypot(*steps.T))


def plane_path(dataset: xr.Dataset, ax: Axes | None = None, *, plane: xr.Dataset | None = None) -> Axes:
    """Draw a path of :func:`squama.bend_twist` in the plane of bend and twist per pitch, coloured by contact.

    With ``plane`` (:func:`squama.bend_twist_map`) also the regimes of the plane; the left panel of :func:`path_figure`.
    """
    ax, _ = style.panel(ax, dataset, "event", "squama.bend_twist")
    if plane is not None:
        _regimes(ax, plane, (plane["psi"].values, plane["phi"].values))
    psi, phi, contact = (dataset[name].values for name in ("psi", "phi", "contact"))
    cuts, seen = [0, *(np.flatnonzero(contact[1:] != contact[:-1]) + 1), len(contact)], set[str]()
    for start, stop in itertools.pairwise(cuts):
        name = str(contact[start])
        text = said(name or "no contact") if name not in seen else None
        seen.add(name)
        whole = slice(max(0, start - 1), stop)
        ax.plot(psi[whole], phi[whole], color=coloured(name), linewidth=1.6, label=text)
    _flush(ax, dataset, _FRAMED | {"label": FLUSH, "color": GREY, "linewidth": 0.8, "zorder": 1})
    point: style.Look = {"linestyle": "", "markersize": 3.5, "zorder": 4}
    event: style.Look = {"color": INK, "marker": "o", "markerfacecolor": "white", "label": "event on the path"}
    ax.plot(dataset["psi_event"], dataset["phi_event"], **event, **point)
    if (end := str(dataset["end"].item())) != End.RANGE:
        ax.plot(dataset["psi_end"], dataset["phi_end"], color=ACCENT, marker="X", label=end, **point)
    room = 0.1 * max(np.ptp(psi), np.ptp(phi))
    ax.set(xlim=(psi.min() - room, psi.max() + room), ylim=(phi.min() - room, phi.max() + room))
    ax.set(xlabel=style.angle_label("bending"), ylabel=style.angle_label("twisting"))
    ax.locator_params(nbins=style.TICKS)
    ax.legend(**BOX)
    return ax


def path_loads(dataset: xr.Dataset, ax: Axes | None = None, *, hinge: xr.Dataset | None = None) -> Axes:
    """Draw moment and torque of :func:`squama.bend_twist` along the path; the axis ends before a lock.

    ``hinge``, the response on hinges to the same path, is drawn thin within these axes.
    """
    ax, _ = style.panel(ax, dataset, "event", "squama.bend_twist")
    way, colours = _path_length(dataset), {"M": UNLOADED, "T": INK}
    factor, text = style.prefixed("M", max(float(np.abs(dataset[name].values).max()) for name in colours))
    both = {name: factor * dataset[name].values for name in colours}
    for name, colour in colours.items():
        ax.plot(way, both[name], color=colour, label=f"${name}$")
        if f"{name}_periodic" in dataset:
            beside = factor * dataset[f"{name}_periodic"].values
            ax.plot(way, beside, color=colour, label=f"${name}$, endless", **WITHOUT_ENDS)
    ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)
    ax.set(xlabel=WAY, xlim=(0, way[-1]), ylabel=f"$M$, $T$ {style.unit_of(text)}")
    if End(dataset["end"].item()).locks:
        seen = np.array([*both.values()])[:, way <= READABLE * way[-1]]
        ax.set_ylim(1.1 * min(0.0, seen.min()), 1.3 * max(seen.max(), 0.0))
    if hinge is not None:
        with style.within(ax):
            for name, colour in colours.items():
                words = f"${name}$ on hinges"
                ax.plot(_path_length(hinge), factor * hinge[name].values, color=colour, label=words, **BESIDE)
    # above the lines of hinges, which leave the axes early
    ax.legend(**BOX | ({"loc": "upper left"} if hinge is None else {}))
    return ax
