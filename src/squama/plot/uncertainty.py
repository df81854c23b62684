"""Effect of tolerances, in panels: histogram of the end twist by end, cumulative probability, Sobol indices."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.beam.design import Beam
from squama.loads import ENDLESS, Load, model
from squama.model.outcome import End
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK
from squama.study.models import Twist
from squama.symbols import SYMBOLS

SHOWN = ("load_e", "load_end", "torque_c", "RED_c", "W_fr_c", "K_e")
"""Figures of hinges whose indices are drawn, by field."""
SHOWN_COMPLIANT = ("phi_e", "torque", "stiffness_ratio", "stress", "RED")
"""Figures of compliant joints whose indices are drawn."""
_WORDS = {"K_e": "$K_e$", "RED_c": "RED", "engaged": "engages", "locked": "locks", "locked before": "locks\nbefore"}
_ROOM = 1.06
"""Height of an axis over that of its contents."""
_MARK: style.Look = {"color": ACCENT, "linewidth": 0.9, "linestyle": (0, (3, 2))}


@style.styled
def uncertainty_figure(dataset: xr.Dataset) -> Figure:
    """Draw the scatter of a beam within its tolerances, and the influence of each, from :func:`squama.uncertainty`.

    On hinges, left: histogram of the end twist, by named end; right: probability that the beam has locked (solid), or
    that its curve has ended in any way (dashed), before a twist. On compliant joints: histogram of the stiffness ratio
    at the twist, and the probability that the ratio is at least this large. With Sobol indices: the total index of each
    tolerance with its 95 % interval, and the first-order index inside it.
    """
    indexed = "S1" in dataset and dataset.sizes["indexed"]
    figure = style.new_figure(style.PAGE, 6.2 if indexed else 3.3)
    panels = figure.subplot_mosaic("ab;cc" if indexed else "ab")
    histogram(dataset, panels["a"])
    cumulative(dataset, panels["b"])
    if indexed:
        sobol(dataset, panels["c"])
    title = f"{dataset.attrs['samples']} {ENDLESS} beams within their tolerances in {dataset.attrs['load']}: "
    return style.headline(figure, title + model(dataset.attrs), panels.values())


def _ends(dataset: xr.Dataset) -> list[str]:
    """Return the ends with an end twist, the most frequent first."""
    ends = [e for e in dataset["end"].values if e != End.NONE]
    return sorted(ends, key=lambda e: -float(dataset["probability"].sel(end=e)))


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if share < 0.995 or share == 1 else f"{100 * share:.5g} %"


def _across(dataset: xr.Dataset, kind: Load) -> tuple[float, str]:
    """Return the factor and the label of the axis of the bins: degrees of the whole beam, or stiffness ratios."""
    if "at" in dataset.attrs:
        return 1.0, SYMBOLS["stiffness_ratio"].axis
    beam = Beam.from_toml_text(dataset.attrs["beam"])
    return style.over_beam(kind, beam)


def histogram(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the histogram of :func:`squama.uncertainty`: end twists by named end, or stiffness ratios at the twist."""
    ax, kind = style.panel(ax, dataset, "bin", "squama.uncertainty")
    # as many bars as the samples fill evenly
    wide = max(1, round(dataset.sizes["bin"] / (2 * dataset.attrs["samples"] ** (1 / 3))))
    factor, across = _across(dataset, kind)
    tops = factor * dataset["bin_high"].values
    low, high = factor * dataset["bin_low"].values[::wide], tops[wide - 1 :: wide]
    high = np.append(high, tops[-1:])[: low.size]
    ends = _ends(dataset)
    colours = style.shades(max(len(ends), 2))
    under = np.zeros(low.size)
    handles, thick = [], "at" in dataset.attrs
    for end, colour in zip(ends, colours, strict=False):
        counts = np.add.reduceat(dataset["count"].sel(end=end).values, np.arange(low.size) * wide)
        density = counts / dataset.attrs["samples"] / np.maximum(high - low, 1e-300)
        ax.stairs(under + density, np.append(low, high[-1:]), baseline=under, fill=True, color=colour, linewidth=0)
        under = under + density
        share = float(dataset["probability"].sel(end=end))
        if not thick or len(ends) > 1:
            handles.append(style.key(f"{end}, {_percent(share)}", color=colour, linewidth=5))
    if End.NONE in dataset["end"].values:
        share = float(dataset["probability"].sel(end=str(End.NONE)))
        handles.append(style.key(f"no engagement, {_percent(share)}", color="none", linewidth=0))
    figure = "stiffness_ratio" if thick else kind.variable("load_end")
    if figure in dataset["figure"].values and np.isfinite(nominal := float(dataset["nominal"].sel(figure=figure))):
        ax.axvline(factor * nominal, 0, 1 / _ROOM, **_MARK)
        handles.append(style.key("nominal beam", **_MARK))
    ax.set(xlabel=across, ylabel=f"Probability density{'' if thick else ' (1/deg)'}")
    ax.set_ylim(0, _ROOM * float(under.max()) if under.size else 1)
    ax.locator_params(axis="x", nbins=style.TICKS)
    style.legend_under(ax, handles)
    return ax


def cumulative(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the probability of :func:`squama.uncertainty` that a beam has locked, or ended, before a twist.

    On compliant joints: the probability that the stiffness ratio is at least this large.
    """
    ax, kind = style.panel(ax, dataset, "bin", "squama.uncertainty")
    factor, across = _across(dataset, kind)
    edges = factor * np.append(dataset["bin_low"].values, dataset["bin_high"].values[-1:])
    n = dataset.attrs["known_samples"]
    every = dataset["count"].sum("end").values / n
    if "at" in dataset.attrs:
        ax.plot(edges, np.append(np.cumsum(every[::-1])[::-1], 0), color=INK, label="beams at least as stiff")
    else:
        locks = [e for e in _ends(dataset) if End(e).locks]
        locked = dataset["count"].sel(end=locks).sum("end").values / n
        ax.plot(edges, np.append(0, np.cumsum(locked)), color=INK, label="beams that have locked")
        if len(locks) < len(_ends(dataset)):
            ended = np.append(0, np.cumsum(every))
            ax.plot(edges, ended, color=GREY, linestyle=style.DASHED, label="beams whose curve has ended")
    beam, before = Beam.from_toml_text(dataset.attrs["beam"]), dataset.attrs["before"]
    twist = Twist.read("before", before, dataset.attrs["load"], beam) if before else None
    # a rate has no single twist per pitch where the pitch varies
    if twist and not (twist.unit == "rad/m" and "beam.pitch" in dataset["parameter"].values):
        p, place = float(dataset["P_locked_before"]), factor * float(twist.per_pitch(beam.pitch))
        ax.axvline(place, 0, 1 / _ROOM, label=f"{before}: {100 * p:.3g} % locked", **_MARK)
        if edges.size and edges[0] <= place <= edges[-1]:
            ax.plot([place], [p], marker="o", color=ACCENT, markersize=4, linestyle="")
    ax.set(ylim=(0, _ROOM), yticks=[0, 0.25, 0.5, 0.75, 1], xlabel=across, ylabel="Probability")
    ax.locator_params(axis="x", nbins=style.TICKS)
    style.legend_under(ax, ax.get_legend_handles_labels()[0])
    return ax


def sobol(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the Sobol indices of :func:`squama.uncertainty`: total with its 95 % interval, first-order inside it."""
    ax, kind = style.panel(ax, dataset, "S1", "squama.uncertainty with Sobol indices")
    name = kind.variable
    wanted = SHOWN_COMPLIANT if "at" in dataset.attrs else map(name, SHOWN)
    figures = [f for f in (*wanted, "engaged", "locked", "locked before") if f in dataset["indexed"].values]
    total, first = (dataset[name].sel(indexed=figures).values for name in ("ST", "S1"))
    error = dataset["ST_conf"].sel(indexed=figures).values
    names = list(dataset["parameter"].values)
    order = [i for i in np.argsort(-total.max(axis=0)) if total[:, i].max() > 0.01]
    width = 0.84 / max(len(order), 1)
    colours = style.shades(max(len(order), 2))
    x = np.arange(len(figures))
    for j, i in enumerate(order):
        at = x + (j - (len(order) - 1) / 2) * width
        for index, alpha in ((total, 0.45), (first, None)):
            ax.bar(at, np.maximum(index[:, i], 0), 0.9 * width, color=colours[j], alpha=alpha, linewidth=0)
        ax.errorbar(at, total[:, i], error[:, i], color=INK, linestyle="", linewidth=0.7, capsize=1.5)
    handles = [style.key(names[i], color=colours[j], linewidth=5) for j, i in enumerate(order)]
    handles.append(style.key("pale: total index, 95 %", color=GREY, alpha=0.45, linewidth=5))
    ax.set_xticks(x, [_WORDS.get(f) or f"${SYMBOLS[name(f)].tex}$" for f in figures])
    ax.tick_params(axis="x", length=0)
    ax.set(ylim=(0, _ROOM * min(max(float((total + error).max()), 1e-3), 1.2)), ylabel="Sobol index")
    style.legend_under(ax, handles)
    return ax
