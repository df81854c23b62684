"""Maps of the paper: relative energy dissipation (Fig. 7), regimes (Fig. 5), lock lines of twisting and bending."""

from __future__ import annotations

from collections.abc import Iterable

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from squama.loads import LOADS
from squama.model.outcome import End
from squama.plot import style
from squama.plot.palette import ACCENT, ENDS, GREY, INK, LOCKS
from squama.symbols import SYMBOLS
from squama.types import Array

LEVELS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
COLOURS = mpl.colormaps["cividis"].resampled(len(LEVELS) - 1)
NORM = BoundaryNorm(LEVELS, len(LEVELS) - 1)
HATCHES = {
    "static lock": ("////", "static lock: no sliding"),
    "off tip edge": ("....", "contact leaves the tip edge"),
    "off side edge": ("ooo", "contact leaves the side edge"),
    "released": ("xxx", "scales come back to rest"),
    "other contact": ("\\\\\\\\", "tip-side contact of another neighbour first"),
    "no engagement": ("++", "no engagement"),
    "joint unknown": ("xx", "joint unknown"),
}
"""Hatching and name of regions that end without a lock, or at once."""
TOUCH: style.Look = {"color": ENDS[End.OTHER], "linewidth": 1.3}
"""Line below which other plates touch first; drawn on a white line, to be visible on every colour."""
HALO: list[patheffects.AbstractPathEffect] = [patheffects.withStroke(linewidth=1.5, foreground="white")]
"""White outline of the numbers of lines, for dark colours."""
CASING = [patheffects.Stroke(linewidth=2.6, foreground="white"), patheffects.Normal()]
BLANK = ("static lock", "no engagement")
"""Regions without a value, on white."""
SWATCH: style.Look = {"handlelength": 2.4, "handleheight": 1.3}
"""Size of legend handles that makes a hatching visible."""
ROTATION = r"Rotation of the scales $(\theta-\theta_0)/\pi$ (1)"
SHOWN = ("frictional lock", "static lock")
STOPS: dict[str, tuple[style.Look, str]] = {
    "other": ({"marker": "o", "markersize": 3.2}, "beyond: ends without a lock"),
    "range": ({"marker": "o", "markersize": 3.6, "markerfacecolor": "white"}, "ends of a line: {}"),
}
"""Marks at the end of an envelope, by cause (another end, or the end of the drawn range), and their words."""

THIN = 40
"""Number of cells along the shorter side of a map above which slivers of regions get no outline."""


@style.styled
def red_figure(dataset: xr.Dataset) -> Figure:
    """Draw the relative energy dissipation to the end of each curve, from ``squama.paper.maps.red_map``.

    A panel for each force law with contours of RED. The region of static lock is blank, hatched and named; regions that
    end without a lock are hatched and named; a line marks where other pairs of plates touch before the end.
    """
    laws = [str(law) for law in dataset["law"].values]
    over = str(dataset.attrs["over"])
    figure = style.new_figure(style.PAGE if len(laws) > 1 else 0.55 * style.PAGE, 3.5)
    axes = np.atleast_1d(np.asarray(figure.subplots(1, len(laws), sharey=True)))
    factor = 180 / np.pi if over == "alpha" else 1.0
    x, y = dataset["value"].values * factor, dataset["mu"].values
    seen: list[str] = []
    for ax, law, name in zip(axes, laws, "abcdef", strict=False):
        part = dataset.sel(law=law)
        seen += [e for e in _panel(ax, x, y, part) if e not in seen]
        style.letter(ax, f"({name}) {style.LAWS[law]}")
        ax.set_xlabel(style.label("alpha", "deg") if over == "alpha" else style.label("eta"))
    axes[0].set_ylabel(style.label("mu"))
    bar = figure.colorbar(ScalarMappable(NORM, COLOURS), ax=list(axes), ticks=LEVELS, aspect=28)
    bar.set_label(f"{style.label('RED')}, margin {dataset.attrs['margin']:g}")
    bar.outline.set_linewidth(0.7)
    handles: list[Artist] = [hatched(e) for e in HATCHES if e in seen]
    if set(seen) - {"static lock"}:
        handles.append(style.key("another end, or past a fold: values may jump", color=ACCENT, linewidth=0.9))
    if bool((dataset["phi_end"] > dataset["phi_touch"]).any()):
        handles.append(style.key("below it other plates touch first", **TOUCH))
    style.legend_below(figure, handles, 3, **SWATCH)
    return figure


def hatched(end: str, *, blank: bool | None = None, words: str = "") -> Patch:
    """Return a legend handle for a hatched region on the colour of its map; ``words`` replace its name."""
    hatch, own = HATCHES[end]
    # dissipation is small where a curve ends without a lock
    ground, line = ("white", GREY) if (end in BLANK if blank is None else blank) else (COLOURS(1), "white")
    with mpl.rc_context({"hatch.color": line}):
        return Patch(facecolor=ground, edgecolor=line, hatch=hatch, label=words or own)


def hatch_region(ax: Axes, x: Array, y: Array, inside: Array, end: str, *, blank: bool | None = None) -> None:
    """Hatch a region (mask ``inside``, rows along y) that ends without a lock, or at once, with an outline."""
    blank = end in BLANK if blank is None else blank
    ground, line = ("white", GREY) if blank else ("none", "white")
    look: style.Look = {"levels": [0.5, 1.5], "colors": ground, "hatches": [HATCHES[end][0]]}
    with mpl.rc_context({"hatch.color": line}):
        ax.contourf(x, y, inside.astype(float), zorder=3.7 if blank else 3, **look)
    _outline(ax, x, y, inside)


def _outline(ax: Axes, x: Array, y: Array, inside: Array) -> None:
    """Draw a line around a region, but not around pieces that are a few cells wide everywhere."""
    from scipy.ndimage import binary_dilation, binary_opening, label

    if not inside.any() or inside.all():
        return
    seen = np.ones_like(inside)
    if min(inside.shape) > THIN:
        # a piece is outlined as a whole, where it tapers too
        pieces, _ = label(inside, np.ones((3, 3)))
        wide = np.unique(pieces[binary_opening(inside, np.ones((4, 4), bool))])
        seen = binary_dilation(np.isin(pieces, wide[wide > 0]), np.ones((3, 3), bool))
    if (inside & seen).any():
        shown = np.ma.masked_where(~seen, inside.astype(float))
        ax.contour(x, y, shown, levels=[0.5], colors=ACCENT, linewidths=0.9, zorder=4)


def hatch_ground(ax: Axes, x: Array, y: Array, inside: Array, end: str) -> None:
    """Hatch the ground of a region of unknown cells, below the adjacent cells."""
    look: style.Look = {"levels": [1e-6, 1.5], "colors": "white", "hatches": [HATCHES[end][0]]}
    with mpl.rc_context({"hatch.color": GREY}):
        ax.contourf(x, y, inside.astype(float), zorder=0.5, **look)


def contours(
    ax: Axes,
    grid: tuple[Array, Array, Array],
    groups: Iterable[Array],
    look: style.Look,
    avoid: Array | None = None,
    unknown: Array | None = None,
) -> None:
    """Fill contours of a ``grid`` (x, y, values by y and x) in each group of cells separately, with lines and numbers.

    Values jump between groups: each group is extended beyond its border by its nearest values and clipped there, so
    that nothing is interpolated across the border; next to ``unknown`` cells it ends with its own cells. ``look`` has
    ``levels``, ``norm`` and ``cmap``; numbers keep off the points ``avoid`` (n, 2). The limits of ``ax`` must be set.
    """
    from scipy.ndimage import binary_dilation, binary_opening, distance_transform_edt

    x, y, values = grid
    levels, kept_free = np.asarray(look["levels"], float), np.empty((0, 2)) if avoid is None else avoid
    for group in groups:
        own = group & np.isfinite(values)
        if not own.any():
            continue
        border, near = None, kept_free
        if not own.all():
            # the border lies halfway to other cells, and at its own cells next to unknown ones; single cells and lines
            # of cells between unknown ones would have no area, so they reach halfway too
            known = np.ones_like(own) if unknown is None else ~unknown
            single = known & ~binary_opening(known, np.ones((2, 2), bool))
            near_single = binary_dilation(single, np.ones((3, 3), bool))
            inside = np.where(own, 1.0, np.where(known | near_single, 0.0, -1e6))
            mask = ax.contourf(x, y, inside, levels=[0.5, 1.5], colors="none")
            border = mask.get_paths()[0]
            mask.remove()
            near = np.concatenate([kept_free, np.asarray(border.vertices)])
        nearest = distance_transform_edt(~own, return_distances=False, return_indices=True)
        whole = np.clip(values[tuple(nearest)], levels[0], levels[-1])
        drawn = [ax.contourf(x, y, whole, **look)]
        inner = levels[(levels > whole.min()) & (levels < whole.max())]
        if inner.size:
            drawn.append(ax.contour(x, y, whole, levels=inner, colors=INK, linewidths=0.5, zorder=3.5))
            _number(ax, x, y, drawn[-1], own, near)
        for part in drawn if border is not None else ():
            part.set_clip_path(border, ax.transData)


def _number(ax: Axes, x: Array, y: Array, lines: QuadContourSet, own: Array, border: Array) -> None:
    """Write each line's number where it is farthest from other lines, from the border and from other numbers.

    A number needs 0.03 of the panel's size around it, and 0.1 to other numbers.
    """
    from scipy.spatial import cKDTree

    low, size = np.array([x[0], y[0]]), np.array([x[-1] - x[0], y[-1] - y[0]])
    none = np.empty((0, 2))
    points = [(np.concatenate([none, *pieces]) - low) / size for pieces in lines.allsegs]
    ways = [np.concatenate([none, *(np.gradient(s / size, axis=0) for s in pieces)]) for pieces in lines.allsegs]
    placed: list[Array] = []
    for i, (level, line, way) in enumerate(zip(lines.levels, points, ways, strict=True)):
        if not len(line):
            continue
        room = np.minimum(line, 1 - line).min(axis=1)
        others = np.concatenate([*points[:i], *points[i + 1 :], (border - low) / size])
        if len(others):
            room = np.minimum(room, cKDTree(others).query(line)[0])
        if placed:
            room[cKDTree(np.array(placed)).query(line)[0] < 0.1] = 0
        place = line * size + low
        column, row = (abs(place[:, j, None] - grid).argmin(axis=1) for j, grid in enumerate((x, y)))
        room[~own[row, column]] = 0
        # prefer places where the line is level, and the number upright
        best = int((room * (0.3 + abs(way[:, 0]) / np.maximum(np.hypot(*way.T), 1e-300))).argmax())
        if room[best] > 0.03:
            placed.append(line[best])
            at = [(float(place[best, 0]), float(place[best, 1]))]
            ax.clabel(lines, levels=[level], fmt="%.4g", fontsize=6, inline_spacing=3, manual=at)
            lines.labelTexts[-1].set_path_effects(HALO)


def _panel(ax: Axes, x: Array, y: Array, part: xr.Dataset) -> list[str]:
    red, end = part["RED"].values.T, part["end"].values.T
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    ax.spines[["top", "right"]].set_visible(True)
    touch = part["phi_touch"].values[:, None]
    ahead = np.where(np.isfinite(touch), part["phi_end"].values - touch, -1.0).T
    avoid = None
    if (ahead > 0).any() and not (ahead > 0).all():
        first = ax.contour(x, y, ahead, levels=[0.0], colors=TOUCH["color"], linewidths=TOUCH["linewidth"], zorder=4.5)
        first.set(path_effects=CASING)
        avoid = np.asarray(first.get_paths()[0].vertices)
    # RED goes to 0 at the static lock: contours run on beyond the line, and the region is covered afterwards
    ends = [e for e in np.unique(end) if e not in LOCKS and e != "no engagement"]
    look: style.Look = {"levels": LEVELS, "norm": NORM, "cmap": COLOURS}
    locks, folded = np.isin(end, LOCKS), part["folded"].values.T
    contours(ax, (x, y, red), [locks & ~folded, locks & folded, *(end == e for e in ends)], look, avoid)
    _outline(ax, x, y, locks & folded)
    found = [name for name in HATCHES if (end == name).any()]
    for name in found:
        if name != End.STATIC:
            hatch_region(ax, x, y, end == name, name)
            continue
        # the region above its line, with its name where there is most room
        line, top = part["mu_static"].values, float(y[-1])
        own: style.Look = {"facecolor": "white", "edgecolor": GREY, "hatch": HATCHES[name][0], "linewidth": 0}
        ax.fill_between(x, line, top, zorder=5, **own)
        ax.plot(x, line, color=INK, linewidth=1.0, zorder=6)
        room = np.where((x > x[0] + 0.18 * np.ptp(x)) & (x < x[0] + 0.82 * np.ptp(x)), top - line, 0.0)
        if room[col := int(room.argmax())] > 0.06 * top:
            box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
            ax.text(x[col], (line[col] + top) / 2, "static lock", ha="center", va="center", bbox=box, zorder=7)
    return found


@style.styled
def regime_figure(dataset: xr.Dataset) -> Figure:
    """Draw the regimes of a beam in twisting (linear, sliding, locked), from ``squama.paper.maps.regimes``.

    Axes phi/pi and (theta - theta0)/pi; paths of the scales, the kinematic and the frictional envelopes, and where the
    contact leaves the tip edge or another pair of plates touches.
    """
    theta0, over = float(dataset.attrs["theta0"]), str(dataset.attrs["over"])
    figure = style.new_figure(style.PAGE, 4.3)
    ax = figure.subplots()

    def scaled(phi: xr.DataArray, theta: xr.DataArray) -> tuple[Array, Array]:
        return np.asarray(phi, float) / np.pi, (np.asarray(theta, float) - theta0) / np.pi

    right = 0.0
    for i in range(dataset.sizes["value"]):
        x, y = scaled(dataset["phi"][i], dataset["theta"][i])
        good = np.isfinite(x)
        ax.plot(np.r_[0, x[good]], np.r_[0, y[good]], color=GREY, linewidth=0.9, zorder=1)
        right = max(right, float(x[good].max()))
        value = float(dataset["value"][i])
        text = rf"$\eta$ = {value:g}" if over == "eta" else rf"$\alpha$ = {np.degrees(value):.3g}°"
        tag(ax, x[good], y[good], text)
    ax.plot(*scaled(dataset["phi_off"], dataset["theta_off"]), color=GREY, linestyle="-.", linewidth=1.6, zorder=3)
    ax.plot(*scaled(dataset["phi_touch"], dataset["theta_touch"]), color=ACCENT, linestyle=":", linewidth=1.3, zorder=3)
    ax.plot(*scaled(dataset["phi_lock"], dataset["theta_lock"]), color=INK, linewidth=2.2, zorder=4)
    laws = [str(law) for law in dataset["law"].values]
    mus = [float(mu) for mu in dataset["mu"].values]
    colours = style.shades(len(mus))
    marked: set[str] = set()
    for law in laws:
        for mu, colour in zip(mus, colours, strict=True):
            line = dataset.sel(law=law, mu=mu)
            x, y = scaled(line["phi_end"], line["theta_end"])
            keep = np.isin(line["end"].values, SHOWN)
            # at a static lock the line runs along the axis: only its first point is drawn
            still = line["end"].values == "static lock"
            keep &= ~(still & np.roll(still, 1) & np.roll(still, -1))
            ax.plot(np.where(keep, x, np.nan), np.where(keep, y, np.nan), color=colour, linestyle=style.DASHES[law])
            # off the axis an envelope stops next to designs that end without a lock, and at the ends of the range
            locked, sliding = np.isin(line["end"].values, SHOWN), line["end"].values == "frictional lock"
            beside = np.r_[False, ~locked[:-1]] | np.r_[~locked[1:], False]
            outer = np.arange(locked.size) % (locked.size - 1) == 0
            for mark, at in (("other", sliding & beside), ("range", sliding & outer & ~beside)):
                marked |= {mark} if at.any() else set()
                ax.plot(x[at], y[at], linestyle="", color=colour, **STOPS[mark][0])
    ax.set_xlim(0, 1.03 * max(right, float(np.nanmax(dataset["phi_lock"].values)) / np.pi))
    ax.set(ylim=(0, 1.08 * float(np.nanmax(dataset["theta_lock"].values) - theta0) / np.pi), xlabel=over_pi("twisting"))
    ax.set_ylabel(ROTATION)
    handles = [style.key("kinematic lock", linewidth=2.2)]
    handles += [style.key(rf"frictional lock, $\mu$ = {mu:g}", color=c) for mu, c in zip(mus, colours, strict=True)]
    handles += style.law_keys(laws)
    handles.append(style.key(rf"path of the scales for one $\{over}$", color=GREY, linewidth=0.9))
    if np.isfinite(dataset["phi_off"].values).any():
        handles.append(style.key("contact leaves the tip edge", color=GREY, linestyle="-.", linewidth=1.6))
    if np.isfinite(dataset["phi_touch"].values).any():
        handles.append(style.key("other plates touch first", color=ACCENT, linestyle=":"))
    limits = dataset["scan"].values[[0, -1]] * (180 / np.pi if over == "alpha" else 1)
    unit = "°" if over == "alpha" else ""
    span = rf"$\{over}$ = {limits[0]:.3g}{unit} or {limits[1]:.3g}{unit}"
    handles += [
        style.key(words.format(span), linestyle="", **dots) for m, (dots, words) in STOPS.items() if m in marked
    ]
    figure.legend(handles=handles, loc="outside right center")
    x, y = scaled(dataset["phi_lock"], dataset["theta_lock"])
    there, (wide, high) = np.isfinite(x), (ax.get_xlim()[1], ax.get_ylim()[1])
    # linear on the axis before engagement, nonlinear while sliding, locked beyond the envelope
    words: style.Look = {"style": "italic", "fontsize": 7.5, "color": INK}
    ax.text(float(np.median(x[there])), float(np.max(y[there])) + 0.012, "locked", ha="center", va="bottom", **words)
    corner: style.Look = {"ha": "right", "va": "bottom", **words}
    ax.text(0.985 * wide, 0.075 * high, "above the axis: sliding, nonlinear", **corner)
    ax.text(0.985 * wide, 0.02 * high, "on the axis: no contact, linear", **corner)
    return figure


def tag(ax: Axes, x: Array, y: Array, text: str, pad: float = 0.8) -> None:
    """Write a label near the end of a path."""
    box = {"facecolor": "white", "edgecolor": "none", "pad": pad, "alpha": 0.85}
    i = int(np.argmin(abs(y - 0.62 * y.max())))
    ax.text(x[i], y[i], text, fontsize=6.5, color=INK, ha="center", va="center", bbox=box, zorder=6)


def over_pi(load: str) -> str:
    """Return the axis label of a load angle over pi."""
    of = LOADS[load]
    return rf"{of.verb.capitalize()} per pitch ${SYMBOLS[of.angle].tex}/\pi$ (1)"


@style.styled
def lock_lines_figure(dataset: xr.Dataset) -> Figure:
    """Draw the lock lines of twisting and of bending side by side, from ``squama.paper.maps.lock_lines``.

    Above: the lock lines; below: their distance from the kinematic line. In bending the distance is arctan(mu)
    everywhere, so the lines are translates; in twisting they are not.
    """
    figure = style.new_figure(style.PAGE, 5.2)
    axes = figure.subplots(2, 2, sharex="col", sharey="row")
    mus = [float(mu) for mu in dataset["mu"].values]
    fixed = rf"$\eta$ varies along a line from {dataset.attrs['eta_low']:g} (right) to {dataset.attrs['eta_high']:g}"
    # the first friction is 0, the kinematic lock
    colours = dict(zip(mus[1:], style.shades(len(mus) - 1), strict=True))
    for column, loading in enumerate(("bending", "twisting")):
        part = dataset.sel(loading=loading)
        top, low = axes[0][column], axes[1][column]
        for mu in mus:
            line = part.sel(mu=mu)
            x, y = line["load"].values / np.pi, np.degrees(line["theta"].values)
            top.plot(x, y, color=colours.get(mu, INK), linewidth=1.3 if mu else 2.2)
            if mu:
                low.plot(x, np.degrees(line["drop"].values), color=colours[mu])
                low.axhline(np.degrees(np.arctan(mu)), color=GREY, linewidth=0.8, linestyle=":", zorder=0)
        low.set_xlabel(over_pi(loading))
        top.set_xlim(0, None)
        style.letter(top, f"({'ab'[column]}) {loading}: {fixed}")
        style.letter(low, f"({'cd'[column]}) {loading}: distance below the kinematic line")
    axes[0][0].set(ylabel=r"Inclination at the lock $\theta$ (deg)", ylim=(0, None))
    axes[1][0].set(ylabel="Drop of the inclination (deg)", ylim=(0, None))
    handles = [style.key(r"kinematic lock, $\mu$ = 0", linewidth=2.2)]
    handles += [style.key(rf"frictional lock, $\mu$ = {mu:g}", color=c) for mu, c in colours.items()]
    handles.append(style.key(r"a translate by arctan $\mu$", color=GREY, linestyle=":", linewidth=0.8))
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure
