"""Maps of the relative energy dissipation over friction and one property of the design (paper Fig. 7)."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from squama.plot.palette import ACCENT, GREY, INK
from squama.plot.style import LAWS, PAGE, key, label, letter, new_figure, styled
from squama.types import Array

LEVELS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
LABELLED = (0.7, 0.8, 0.9, 0.95)
COLOURS = mpl.colormaps["cividis"].resampled(len(LEVELS) - 1)
NORM = BoundaryNorm(LEVELS, len(LEVELS) - 1)
HATCHES = {
    "static lock": ("////", "static lock: no sliding"),
    "off tip edge": ("....", "contact leaves the tip edge"),
    "off side edge": ("ooo", "contact leaves the side edge"),
    "released": ("xxx", "scales come back to rest"),
    "other contact": ("\\\\\\\\", "tip-side contact of another neighbour first"),
    "no engagement": ("++", "no engagement"),
}
"""Regions that end without a lock, or at once: hatching and name."""
OUTLINE = [patheffects.Stroke(linewidth=2.6, foreground=INK), patheffects.Normal()]
DARK = COLOURS(1)
"""Ground of a hatching in the legend: dissipation is small where a curve ends without a lock."""
BOUNDARY = "here the end changes: values may jump"


@styled
def red_figure(dataset: xr.Dataset) -> Figure:
    """Draw the relative energy dissipation to the end of each curve, from :func:`squama.paper.maps.red_map`.

    A panel for each force law, contours of RED; the region of static lock blank, hatched and named, regions that end
    without a lock hatched and named; a line where other pairs of plates touch before the end.
    """
    laws = [str(law) for law in dataset["law"].values]
    over = str(dataset.attrs["over"])
    figure = new_figure(PAGE if len(laws) > 1 else 0.55 * PAGE, 3.5)
    axes = np.atleast_1d(np.asarray(figure.subplots(1, len(laws), sharey=True)))
    factor = 180 / np.pi if over == "alpha" else 1.0
    x, y = dataset["value"].values * factor, dataset["mu"].values
    seen: list[str] = []
    for ax, law, name in zip(axes, laws, "abcdef", strict=False):
        part = dataset.sel(law=law)
        seen += [e for e in _panel(ax, x, y, part) if e not in seen]
        letter(ax, f"({name}) {LAWS[law]}")
        ax.set_xlabel(label("alpha", "deg") if over == "alpha" else label("eta"))
    axes[0].set_ylabel(label("mu"))
    bar = figure.colorbar(ScalarMappable(NORM, COLOURS), ax=list(axes), ticks=LEVELS, aspect=28)
    bar.set_label(f"{label('RED')}, margin {dataset.attrs['margin']:g}")
    bar.outline.set_linewidth(0.7)
    handles: list[Any] = [hatched(e, dark=e != "static lock") for e in HATCHES if e in seen]
    if set(seen) - {"static lock"}:
        handles.append(key(BOUNDARY, color=ACCENT, linewidth=0.9))
    if bool((dataset["phi_end"] > dataset["phi_touch"]).any()):
        handles.append(key("below it other plates touch first", color="white", linestyle="--", linewidth=1.4))
        handles[-1].set_path_effects(OUTLINE)
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def hatched(end: str, *, dark: bool = False) -> Patch:
    """Return a handle for a region that is hatched, on the ground of its map."""
    hatch, words = HATCHES[end]
    return Patch(facecolor=DARK if dark else "white", edgecolor="white" if dark else GREY, hatch=hatch, label=words)


def _panel(ax: Axes, x: Array, y: Array, part: xr.Dataset) -> list[str]:
    red, end = part["RED"].values.T, part["end"].values.T
    # RED goes to 0 at the static lock: contours run on to the line, and the region is covered after
    shown = np.ma.masked_invalid(np.where(end == "no engagement", np.nan, red))
    ax.contourf(x, y, shown, levels=LEVELS, norm=NORM, cmap=COLOURS)
    # RED jumps where the end changes from a lock to none: lines on either side of it
    locks = np.isin(end, ("frictional lock", "kinematic lock", "static lock"))
    lines = ax.contour(x, y, np.ma.masked_where(~locks, shown), levels=LEVELS[1:-1], colors=INK, linewidths=0.5)
    if (~locks).any():
        ax.contour(x, y, np.ma.masked_where(locks, shown), levels=LEVELS[1:-1], colors=INK, linewidths=0.5)
    where = _label_places(x, y, np.where(locks, red, 0.0))
    if where:
        ax.clabel(lines, levels=LABELLED, fmt="%.2g", fontsize=6, inline_spacing=3, manual=where)
    found = []
    for name, (hatch, _) in HATCHES.items():
        inside = end == name
        if not inside.any():
            continue
        found.append(name)
        if name == "static lock":
            line = part["mu_static"].values
            ax.fill_between(x, line, y[-1], facecolor="white", edgecolor=GREY, hatch=hatch, linewidth=0, zorder=3)
            ax.plot(x, line, color=INK, linewidth=1.0, zorder=4)
            _name_region(ax, x, line, float(y[-1]))
            continue
        with mpl.rc_context({"hatch.color": "white"}):
            ax.contourf(x, y, inside.astype(float), levels=[0.5, 1.5], colors="none", hatches=[hatch])
        ax.contour(x, y, inside.astype(float), levels=[0.5], colors=ACCENT, linewidths=0.9)
    touch = part["phi_touch"].values[:, None]
    ahead = np.where(np.isfinite(touch), part["phi_end"].values - touch, -1.0).T
    if (ahead > 0).any() and not (ahead > 0).all():
        ax.contour(x, y, ahead, levels=[0.0], colors="white", linestyles="--", linewidths=1.4).set(path_effects=OUTLINE)
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    ax.spines[["top", "right"]].set_visible(True)
    return found


def _label_places(x: Array, y: Array, red: Array) -> list[tuple[float, float]]:
    """Places for the numbers on the contours: where RED first reaches each level, at columns apart from each other."""
    places = []
    for level, share in zip(LABELLED, np.linspace(0.92, 0.5, len(LABELLED)), strict=True):
        col = int(share * (x.size - 1))
        above = red[:, col] >= level
        if above.any() and not above[0]:
            places.append((float(x[col]), float(y[above.argmax()])))
    return places


def _name_region(ax: Axes, x: Array, line: Array, top: float) -> None:
    """Write the name of the region above a line where it is highest, away from the sides, if there is room."""
    room = np.where((x > x[0] + 0.18 * np.ptp(x)) & (x < x[0] + 0.82 * np.ptp(x)), top - line, 0.0)
    col = int(room.argmax())
    if room[col] > 0.06 * top:
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
        ax.text(x[col], (line[col] + top) / 2, "static lock", ha="center", va="center", bbox=box, zorder=5)
