"""Slices of sweeps: contours of numbers, ends as named colours, lock envelopes, lines."""

from __future__ import annotations

import re
from collections.abc import Mapping
from textwrap import wrap

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from squama.beam.design import Beam
from squama.errors import refuse
from squama.loads import LOADS, model
from squama.model.outcome import End
from squama.plot import maps, style
from squama.plot.palette import ACCENT, ENDS, GREY, INK, LOCKS
from squama.study.models import Twist
from squama.study.slices import ends
from squama.symbols import SYMBOLS
from squama.types import Array
from squama.units import for_people, shown

_UNDONE = "not computed"
_UNKNOWN = ("joint unknown", _UNDONE)
"""Ends of cells without figures."""
_NAMES = re.compile(r"\b(?:nu|[A-Z]|t)_\w+")
"""Symbols in the descriptions of the beam file's keys, such as t_s."""
_ENVELOPES: dict[str, tuple[tuple[End, ...], style.Look]] = {
    "kinematic lock": ((End.KINEMATIC,), {"linewidth": 2.4}),
    "frictional lock; on the axis static": ((End.FRICTIONAL, End.STATIC), {"linewidth": 1.3}),
    "contact leaves its edge": ((End.OFF_TIP, End.OFF_SIDE), {"color": GREY, "linewidth": 1.2, "linestyle": "-."}),
}
"""Ends whose envelopes are drawn, and their line styles."""
Paths = Mapping[float, tuple[Array, Array]]
"""Load angle and inclination along the paths of some beams, by their value of x."""


@style.styled
def map_figure(
    dataset: xr.Dataset,
    variable: str = "RED",
    *,
    x: str,
    y: str | None = None,
    panels: str | None = None,
    lines: list[float] | None = None,
    paths: Paths | None = None,
) -> Figure:
    """Draw a slice of a sweep: a dataset with the dimensions ``x``, ``y`` and ``panels`` and no other.

    The dimensions may be in any order. ``variable``: ``end`` gives a regime map; ``lock`` gives the locks of the beams
    along x as a line for each of the values ``lines`` of y, with the ``paths`` of single beams. Without y a line is
    drawn; with panels a panel for each value of that dimension.
    """
    dataset = _ordered(dataset, variable, (panels, y, x))
    parts = [dataset] if panels is None else [dataset.isel({panels: i}) for i in range(dataset.sizes[panels])]
    count, columns = len(parts), min(len(parts), 3)
    rows = -(-count // columns)
    width = style.PAGE if count > 1 or variable in ("end", "lock") else 0.68 * style.PAGE
    figure = style.new_figure(width, 0.7 + rows * (3.0 if columns < 3 else 2.5))
    axes = np.atleast_1d(np.asarray(figure.subplots(rows, columns, sharex=True, sharey=True))).ravel()
    for ax in axes[count:]:
        ax.set_visible(False)
    for ax, part, name in zip(axes, parts, "abcdef", strict=False):
        style.letter(ax, f"({name}) {_word(panels, part)}" if panels else "")
    drawn = list(axes[:count])
    handles = _drawn(drawn, parts, variable, x, y, lines or [], paths or {})
    if handles and variable in ("end", "lock") and y is not None:
        figure.legend(handles=handles, loc="outside right center")
    elif handles:
        style.legend_below(figure, handles, 3 if y else 4, **(maps.SWATCH if y else {}))
    across = drawn[-1].get_xlabel()
    for i, ax in enumerate(drawn):
        ax.label_outer(remove_inner_ticks=False)
        if i + columns >= count:
            ax.xaxis.set_tick_params(labelbottom=True)
            # long labels of adjacent panels would overlap
            ax.set_xlabel("\n".join(wrap(across, 200 if columns < 2 else 96 // columns)))
    return style.headline(figure, _title(dataset, variable, (x, y, panels)))


def map_slice(
    dataset: xr.Dataset,
    variable: str = "RED",
    ax: Axes | None = None,
    *,
    x: str,
    y: str | None = None,
    lines: list[float] | None = None,
    paths: Paths | None = None,
) -> Axes:
    """Draw a slice of a sweep with the dimensions ``x`` and ``y`` and no other, as :func:`map_figure` draws a panel.

    Contours with a colour bar, ``end`` as named colours, ``lock`` as envelopes; a line without ``y``. The legend is
    below the panel.
    """
    ax, _ = style.panel(ax, dataset, "status", "squama.sweep")
    dataset = _ordered(dataset, variable, (y, x))
    handles = _drawn([ax], [dataset], variable, x, y, lines or [], paths or {})
    ax.set_xlabel(_wrapped(ax.get_xlabel(), ax, style.LABELS * ax.bbox.width))
    if handles:
        style.legend_under(ax, handles)
    return ax


def _ordered(dataset: xr.Dataset, variable: str, names: tuple[str | None, ...]) -> xr.Dataset:
    """Return a slice with its dimensions in this order; refuse other dimensions, and an unknown variable."""
    order = [name for name in names if name]
    if variable not in (known := ["lock", *map(str, dataset.data_vars)]):
        refuse("variable", shown(variable), "is not in this sweep", f"allowed: {', '.join(known)}")
    if (found := {*map(str, dataset["end"].dims)}) != {*order}:
        words = f"this slice has the dimensions {', '.join(sorted(found))}, to be drawn over {', '.join(sorted(order))}"
        refuse("", "", words, "choose one value of every other with .sel(), or name it")
    return dataset.transpose(..., *order)


def _drawn(
    axes: list[Axes], parts: list[xr.Dataset], variable: str, x: str, y: str | None, lines: list[float], paths: Paths
) -> list[Artist]:
    """Draw a slice into each of the axes; return the legend's handles."""
    if variable == "lock":
        assert y is not None
        return _envelopes(axes, parts, x, y, lines, paths)
    if y is None:
        return _lines(axes, parts, variable, x)
    return _regimes(axes, parts, x, y) if variable == "end" else _contours(axes, parts, variable, x, y)


def axis_values(part: xr.Dataset, name: str) -> tuple[Array, str]:
    """Return the values of a dimension in the unit of texts, and the axis label."""
    factor, text = for_people(part[name].attrs.get("units", "1"))
    words = _NAMES.sub(r"$\g<0>$", part[name].attrs.get("long_name", name))
    # Greek letters of symbols
    words = re.sub(r"\$[^$]*\$", lambda one: re.sub("nu|theta", r"\\\g<0>", one[0]), words)
    tex = SYMBOLS[name].tex if name in SYMBOLS else ""
    label = f"{words[0].upper()}{words[1:]}" + (f" ${tex}$" if tex else "") + (f" ({text})" if text else "")
    return part[name].values * factor, label


def _label(dataset: xr.Dataset, variable: str) -> str:
    role = "torque_c" if variable == "torque" and "at" not in dataset.attrs else variable
    label = SYMBOLS[LOADS[dataset.attrs["load"]].variable(role)].axis
    return label.replace("(Pa)", "(MPa)")


def _values(part: xr.Dataset, variable: str) -> Array:
    """Return the values of a variable in the unit of its label."""
    factor = 1e-6 if part[variable].attrs.get("units") == "Pa" else 1.0
    return factor * np.asarray(part[variable].values, float)


def _word(name: str | None, part: xr.Dataset) -> str:
    assert name is not None
    if name == "law":
        return f"{part['law'].item()} law"
    return f"{_tex(name)} = {_value(part, name, float(part[name]))}"


def _wrapped(text: str, ax: Axes, room: float) -> str:
    """Break a label into lines that fit a length (pixels) along the axes."""
    letter = 0.5 * mpl.rcParams["font.size"] * ax.figure.dpi / 72
    return "\n".join(wrap(text, min(48, max(1, int(room / letter)))))


def _tex(name: str) -> str:
    return f"${SYMBOLS[name].tex}$" if name in SYMBOLS and name != "margin" else name


def _value(part: xr.Dataset, name: str, value: float) -> str:
    factor, text = for_people(part[name].attrs.get("units", "1"))
    return f"{value * factor:.5g} {text}".strip()


def _title(dataset: xr.Dataset, variable: str, over: tuple[str | None, ...]) -> str:
    one = {"law": dataset["law"].item()} if "law" in dataset.coords and "law" not in dataset.dims else {}
    words = [str(dataset.attrs["load"]).capitalize(), model({**dataset.attrs, **one})]
    if dataset.attrs["sense"] != "+":
        words.append(f"sense {dataset.attrs['sense']}")
    if "at" in dataset.attrs:
        scales = Beam.from_toml_text(dataset.attrs["beam"]).pitches
        words.append(f"at {Twist.from_text(dataset.attrs['at']).words(scales)}")
    if "margin" in dataset.attrs and variable in ("f0", "torque", "U_el", "W_fr", "RED"):
        words.append(f"margin {dataset.attrs['margin']:g}")
    words += [_word(str(n), dataset) for n in dataset.coords if n not in (*over, "law") and dataset[n].ndim == 0]
    return ", ".join(word for word in words if word)


def _frame(ax: Axes, part: xr.Dataset, x: str, y: str) -> tuple[Array, Array]:
    """Draw the frame of a map; return the values along its axes."""
    (xs, across), (ys, up) = axis_values(part, x), axis_values(part, y)
    ax.set(xlim=(xs[0], xs[-1]), ylim=(ys[0], ys[-1]), xlabel=across, ylabel=up)
    ax.spines[["top", "right"]].set_visible(True)
    return xs, ys


def levels_of(values: Array, variable: str) -> Array:
    """Return contour levels: the fixed ones of RED, else round numbers without the rare extremes."""
    if variable == "RED":
        return np.array(maps.LEVELS)
    good = values[np.isfinite(values)]
    low, high = np.quantile(good, [0.01, 0.99]) if good.size else (0.0, 1.0)
    if low > 0 and high / low > 50:
        ten = 10 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
        for parts in ((1, 2, 5), (1, 3), (1,)):
            steps = np.sort(np.concatenate([m * ten for m in parts]))
            first, last = steps.searchsorted([low, high], side="right")
            inside = steps[max(first - 1, 0) : last + 1]
            if inside.size <= 14 or parts == (1,):
                return np.asarray(inside)
    if low == high:
        low, high = low - 0.5, high + 0.5
    return np.asarray(MaxNLocator(9).tick_values(low, high))


def _contours(axes: list[Axes], parts: list[xr.Dataset], variable: str, x: str, y: str) -> list[Artist]:
    grids = [_values(part, variable) for part in parts]
    codes = [ends(part) for part in parts]
    # on hinges figures without contact are those of the bar
    blank = [_UNDONE] if "at" in parts[0].attrs else [_UNDONE, End.NONE]
    for grid, code in zip(grids, codes, strict=True):
        grid[np.isin(code, blank)] = np.nan
    every, code = np.ravel(grids), np.ravel(codes)
    seen = {*np.unique(code).tolist()}
    levels = levels_of(every if variable == "phi_e" else every[code != End.STATIC], variable)
    norm = BoundaryNorm(levels, len(levels) - 1 if variable == "RED" else 256)
    colours = maps.COLOURS if variable == "RED" else maps.COLOURS.resampled(256)
    # regions without a value are white
    empty = {end for end in maps.HATCHES if end == End.STATIC or not np.isfinite(every[code == end]).any()}
    jumps = False
    for ax, part, grid, code in zip(axes, parts, grids, codes, strict=True):
        xs, ys = _frame(ax, part, x, y)
        look: style.Look = {"levels": levels, "norm": norm, "cmap": colours}
        unknown, touching = np.isin(code, _UNKNOWN), np.ones(code.shape, bool)
        if variable in ("tangent", "stiffness_ratio") and "N" in part:
            touching = np.asarray(part["N"].values > 0)
        # values are continuous between kinds of locks, and jump at other ends and where scales begin to touch
        locks = np.isin(code, LOCKS)
        groups = [locks, *(code == c for c in np.unique(code[~locks]))]
        groups = [group & side for group in groups for side in (touching, ~touching)]
        maps.contours(ax, (xs, ys, grid), groups, look, unknown=unknown)
        if len(np.unique(touching[~unknown])) > 1:
            jumps = True
            side = np.where(unknown, np.nan, touching)
            ax.contour(xs, ys, side, levels=[0.5], zorder=4, colors=ACCENT, linewidths=0.9)
        for name in maps.HATCHES:
            if (inside := code == name).any() and name in _UNKNOWN:
                maps.hatch_ground(ax, xs, ys, inside, name)
            elif inside.any():
                maps.hatch_region(ax, xs, ys, inside, name, blank=name in empty)
    bar = axes[0].figure.colorbar(ScalarMappable(norm, colours), ax=axes, aspect=28)
    ticks = levels if len(levels) <= 14 else levels[::2]
    bar.set_ticks(list(ticks), labels=[f"{tick:.4g}" for tick in ticks])
    bar.minorticks_off()
    bar.set_label(_wrapped(_label(parts[0], variable), axes[0], axes[0].bbox.height))
    bar.outline.set_linewidth(0.7)
    worded = "at" in parts[0].attrs
    handles: list[Artist] = [
        maps.hatched(name, blank=name in empty, words=name if worded else "") for name in maps.HATCHES if name in seen
    ]
    if _UNDONE in seen:
        handles.append(Patch(facecolor="white", edgecolor=INK, label="not computed yet"))
    words = ["here the end changes: values may jump"] if len(seen - {*_UNKNOWN}) > 1 else []
    words += ["here scales begin to touch: stiffness jumps"] if jumps else []
    if words:
        handles.append(style.key("; ".join(words), color=ACCENT, linewidth=0.9))
    return handles


def _regimes(axes: list[Axes], parts: list[xr.Dataset], x: str, y: str) -> list[Artist]:
    names, colours = list(ENDS), ListedColormap(list(ENDS.values()))
    norm = BoundaryNorm(np.arange(-0.5, len(names)), len(names))
    codes = [np.vectorize(names.index, otypes=[int])(ends(part)) for part in parts]
    for ax, part, code in zip(axes, parts, codes, strict=True):
        xs, ys = _frame(ax, part, x, y)
        # below regions with slanted borders, so that no gap is left where three of them meet
        ax.pcolormesh(xs, ys, code, shading="nearest", cmap=colours, norm=norm, rasterized=True)
        for c in np.unique(code):
            if not (own := code == c).all():
                ax.contourf(xs, ys, own.astype(float), levels=[0.5, 1.5], colors=[colours(int(c))])
                ax.contour(xs, ys, own.astype(float), levels=[0.5], colors=INK, linewidths=0.6)
    seen = [names[c] for c in np.unique(codes)]
    return [Patch(facecolor=ENDS[name], edgecolor=INK, linewidth=0.5, label=name) for name in seen]


def _envelopes(
    axes: list[Axes], parts: list[xr.Dataset], x: str, y: str, lines: list[float], paths: Paths
) -> list[Artist]:
    load_end = LOADS[parts[0].attrs["load"]].variable("load_end")
    theta0 = Beam.from_toml_text(parts[0].attrs["beam"]).scale.theta0
    coloured = list(zip(lines, style.shades(len(lines)), strict=True))

    def start_of(part: xr.Dataset) -> Array:
        # inclination at rest, of the cells or of the beam
        return np.asarray(part["theta0"].values if "theta0" in part.coords else theta0)

    there: set[str] = set()
    top = right = 0.0
    for ax, part in zip(axes, parts, strict=True):
        for value, (load, theta) in paths.items():
            start = value if x == "theta0" else start_of(part)
            across, up = load / np.pi, (theta - start) / np.pi
            ax.plot(np.r_[across[:1], across], np.r_[0, up], color=GREY, linewidth=0.8, zorder=1)
            maps.tag(ax, across, up, _value(part, x, value).replace(" deg", "°"), 0.6)
        for value, colour in coloured:
            line = part.sel({y: value})
            across = np.asarray(line[load_end].values, float) / np.pi
            up = (np.asarray(line["theta_end"].values, float) - start_of(line)) / np.pi
            code = ends(line)
            for words, (codes, look) in _ENVELOPES.items():
                keep = np.isin(code, codes)
                if keep.any():
                    there.add(words)
                    ax.plot(np.where(keep, across, np.nan), np.where(keep, up, np.nan), **{"color": colour, **look})
                    top, right = max(top, float(up[keep].max())), max(right, float(across[keep].max()))
        ax.set(xlabel=maps.over_pi(part.attrs["load"]), ylabel=maps.ROTATION)
    for ax in axes:
        ax.set(xlim=(0, 1.03 * right or 1), ylim=(-0.01 * top, 1.05 * top or 1))
    handles: list[Artist] = [style.key(_word(y, parts[0].sel({y: value})), color=colour) for value, colour in coloured]
    handles += [style.key(words, **_ENVELOPES[words][1]) for words in _ENVELOPES if words in there]
    low, high = (_value(parts[0], x, float(parts[0][x][i])) for i in (0, -1))
    handles.append(style.key(f"along a line {_tex(x)} = {low} to {high}", linestyle=""))
    if paths:
        handles.append(style.key(f"path of the scales for one {_tex(x)}", color=GREY, linewidth=0.8))
    return handles


def _lines(axes: list[Axes], parts: list[xr.Dataset], variable: str, x: str) -> list[Artist]:
    colours = {**ENDS, End.STATIC: GREY, End.NONE: GREY}
    for ax, part in zip(axes, parts, strict=True):
        xs, across = axis_values(part, x)
        code = ends(part)
        v = _values(part, variable)
        for c in np.unique(code[code != _UNDONE]):
            where = code == c
            # one more cell joins the pieces
            joined = where | np.r_[False, where[:-1]]
            ax.plot(xs, np.where(joined & np.isfinite(v), v, np.nan), color=colours[c])
        ax.set(xlabel=across, ylabel="Code of the end" if variable == "end" else _label(part, variable))
    seen = {*np.ravel([ends(part) for part in parts]).tolist()} - {_UNDONE}
    if seen == {End.RANGE}:
        return []  # all curves reach the twist of the figures
    return [style.key(end, color=colour) for end, colour in colours.items() if end in seen]
