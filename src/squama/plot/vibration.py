"""Vibrations: record with envelope, damping against amplitude, phase plane; steady states under shaking."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.beam.faces import sense
from squama.loads import LOADS, Load, model
from squama.plot.fit import found, noise_band
from squama.plot.palette import ACCENT, GREY, INK, UNLOADED
from squama.plot.style import BARE, PAGE, Look, about, angle_label, headline, label, new_figure, panel, styled, within


@styled
def vibration_figure(dataset: xr.Dataset) -> Figure:
    """Draw a free vibration from :func:`squama.vibrate`.

    Above: the record with the envelope of its peaks. Below: the damping of every cycle against its amplitude, and the
    phase plane. Grey: the load angle at engagement.
    """
    figure = new_figure(PAGE, 4.6)
    axes = figure.subplot_mosaic([["record", "record"], ["damping", "plane"]])
    record(dataset, axes["record"])
    damping(dataset, axes["damping"])
    phase_plane(dataset, axes["plane"])
    attrs = dataset.attrs
    material = f", $\\zeta$ of the material {attrs['damping']:g}" if attrs["damping"] else ""
    title = f"Free vibration in {attrs['load']} ({attrs['mode']}): {about(dataset)}{material}"
    return headline(figure, title, axes.values())


def record(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the load angle of a free vibration of :func:`squama.vibrate` over time, with the envelope of its peaks."""
    ax, names = panel(ax, dataset, "t_turn", "squama.vibrate")
    angle = names.angle
    t, y = dataset["t_turn"].values, dataset[f"{angle}_turn"].values
    ax.plot(dataset["t"], dataset[angle], color=INK, linewidth=0.9)
    for sign in (1, -1):
        side = y * sign > 0
        ax.plot(t[side], y[side], color=ACCENT, linestyle=(0, (3, 2)), label="envelope" if sign > 0 else None)
    _engaged(dataset, names, ax.axhline)
    ax.set(xlabel=label("t"), ylabel=angle_label(names.name), xlim=(0, max(float(dataset["t"][-1]), 1e-12)))
    ax.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
    return ax


def _engaged(dataset: xr.Dataset, names: Load, line: Callable[..., object], ways: Sequence[int] = (1, -1)) -> None:
    engaged = float(dataset[f"{names.angle}_e"])
    both = sense(dataset.attrs.get("faces", "one"), names.axis, math.inf) < 0
    for sign in ways if both else (1,):
        if np.isfinite(engaged):
            words = "engagement" if sign > 0 else None
            line(sign * engaged, color=GREY, linewidth=0.7, label=words, zorder=0)


def damping(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the damping ratio of every cycle of :func:`squama.vibrate` against its first peak."""
    ax, names = panel(ax, dataset, "t_turn", "squama.vibrate")
    turns = dataset[f"{names.angle}_turn"].values
    zeta = dataset["zeta_cycle"].values
    ax.plot(np.abs(turns[0 : 2 * zeta.size : 2]), zeta, color=ACCENT, linestyle="", marker="o", markersize=3)
    ax.set(xlabel="Peak at which a cycle begins (rad per pitch)", ylabel="Damping ratio of the cycle $\\zeta_n$")
    # a damping below this is invisible
    ax.set_ylim(0, max(1e-6, 1.15 * float(np.nanmax(zeta, initial=0.0))))
    _engaged(dataset, names, ax.axvline, (1,))
    if np.isfinite(float(dataset[f"{names.angle}_e"])):
        # behind the points, which rise with the peak
        ax.legend(loc="lower right")
    return ax


def phase_plane(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the speed of a free vibration of :func:`squama.vibrate` over its load angle."""
    ax, names = panel(ax, dataset, "t_turn", "squama.vibrate")
    ax.plot(dataset[names.angle], dataset[f"{names.angle}_speed"], color=INK, linewidth=0.4)
    ax.axhline(0, color=GREY, linewidth=0.5, zorder=0)
    _engaged(dataset, names, ax.axvline)
    ax.set(xlabel=angle_label(names.name), ylabel=label(f"{names.angle}_speed"))
    return ax


@styled
def decay_figure(dataset: xr.Dataset) -> Figure:
    """Draw the record of a decay with the fitted motion and the residuals, from :meth:`squama.DecayFit.dataset`.

    Below: measured less fitted, with twice the noise of a point.
    """
    names, attrs = LOADS[dataset.attrs["load"]], dataset.attrs
    t, y, fitted = (dataset[name].values for name in ("t", names.angle, f"{names.angle}_fit"))
    figure = new_figure(PAGE, 4.4)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.4, 1))
    point: Look = {"color": INK, "linestyle": "", "marker": ".", "markersize": 2.5}
    upper.plot(t, y, label="measured", **point)
    upper.plot(t, fitted, color=ACCENT, linewidth=0.9, label="fitted")
    upper.set(ylabel=angle_label(names.name), xlim=(t[0], t[-1]))
    upper.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
    noise_band(lower, float(dataset["noise"]))
    lower.plot(t, y - fitted, **point)
    lower.set(xlabel=label("t"), ylabel="Residual (rad per pitch)")
    title = f"Decay in {names.name} ({attrs['mode']}), {model(attrs)}: {found(dataset, 'twist_zero')}"
    return headline(figure, title, (upper, lower))


@styled
def shaken_figure(dataset: xr.Dataset) -> Figure:
    """Draw steady states from :func:`squama.shake`.

    Left: largest and smallest load angle over the frequency, with rising and falling frequency, and those of the bare
    bar. Right: share of the torque's work that friction dissipates. States that did not settle are hollow on the left,
    and omitted on the right.
    """
    names = LOADS[dataset.attrs["load"]]
    figure = new_figure(PAGE, 3.1)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    f = dataset["frequency"].values
    zeta, static = dataset.attrs["damping"], float(dataset[f"{names.angle}_static"])
    looks = {"up": (ACCENT, "o", "frequency growing"), "down": (UNLOADED, "v", "frequency falling")}
    for way, (colour, marker, words) in looks.items():
        one, loose = dataset.sel(way=way), ~dataset["settled"].sel(way=way).values.astype(bool)
        share = (one["W_rubbed"] / one["W_fed"]).where(one["settled"]).values
        high, low = (one[f"{names.angle}_{bound}"].values for bound in ("high", "low"))
        for ax, y, text in ((left, high, words), (left, low, None), (right, share, words)):
            look: Look = {"color": colour, "marker": marker, "markersize": 3}
            ax.plot(f, y, linewidth=0.7, label=text, **look)
            ax.plot(f[loose], y[loose], linestyle="", markerfacecolor="white", **look)
    fine = np.linspace(f[0], f[-1], 400)
    ratio = fine / float(dataset["f_0"])
    with np.errstate(divide="ignore"):
        linear = static / np.hypot(1 - ratio**2, 2 * zeta * ratio)
    low, high = left.get_ylim()
    left.set_ylim(low, high + 0.3 * (high - low))
    with within(left):
        for sign in (1, -1):
            grey = BARE | {"linewidth": 0.8, "zorder": 0}
            left.plot(fine, sign * linear, label="no contact" if sign > 0 else None, **grey)
    left.set(xlabel=label("frequency"), ylabel=f"Largest, smallest {angle_label(names.name).lower()}")
    right.set(xlabel=label("frequency"), ylabel="Work of friction over that of the torque")
    right.set_ylim(0, max(0.01, 1.15 * right.get_ylim()[1]))
    left.legend(loc="upper right", fontsize=7)
    title = f"Steady states in {names.name} ({dataset.attrs['mode']}): {about(dataset)}, $\\zeta$ = {zeta:g}"
    return headline(figure, title, (left, right))
