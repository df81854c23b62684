"""A fit in two panels: measured points with the fitted curve, and residuals; a prediction; posterior samples."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from squama.loads import TESTS, Load, model
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK, UNLOADED
from squama.types import Array

_POINTS: dict[str, tuple[str, style.Look]] = {
    "straight": ("before engagement", {"color": GREY, "marker": "."}),
    "loading": ("loading", {"color": INK, "marker": "."}),
    "unloading": ("unloading", {"color": UNLOADED, "marker": "."}),
    "stick": ("at a reversal, not used", {"color": INK, "marker": "o", "markerfacecolor": "none", "markersize": 3.5}),
    "stray": ("stray, not used", {"color": ACCENT, "marker": "x", "markersize": 4}),
    "beyond": ("beyond the range, not used", {"color": GREY, "marker": "x", "markersize": 3}),
}
NAMES = {
    "mu": r"friction $\mu$",
    "K_theta": r"joint stiffness $K_\theta$",
    "C_f": "inclusion factor $C_f$",
    "E_B": "modulus of the bar $E_B$",
    "theta0": r"inclination at rest $\theta_0$",
    "torque_zero": "zero of the torque",
    "twist_zero": "zero of the twist",
    "backlash": "backlash",
    "drift": "drift",
    "damping": r"$\zeta$ of the material",
    "f_0": "$f_0$",
}
"""Words for parameters in figures."""
_NOISE, _ERROR = "#f6e3e6", "#e4aeb5"
"""Colours of the bands of a curve; they are opaque, because the bands of several loops overlap."""
NO_BREAK = "\u00a0"
"""Non-breaking space, between a value and its unit in titles."""


@style.styled
def fit_figure(dataset: xr.Dataset) -> Figure:
    """Draw measured points, the fitted curve and the residuals, from :meth:`squama.Fit.dataset`.

    Above: torque (moment) against twist (bend) per pitch, the curve with twice its standard error (dark) and twice the
    noise of a point (light). Below: measured less fitted, with twice the noise.
    """
    figure = style.new_figure(style.PAGE, 5.0)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.4, 1))
    fitted(dataset, upper)
    residuals(dataset, lower)
    upper.set_xlabel("")
    load = TESTS[dataset.attrs["load"]]
    of = "of force over travel" if load.pushed else f"in {load.name}"
    return style.headline(figure, f"Fit {of}, {model(dataset.attrs)}: {found(dataset)}", (upper, lower))


def fitted(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw measured points with the fitted curve, from :meth:`squama.Fit.dataset`; the upper panel of its figure.

    Around the curve: twice its standard error (dark) and twice the noise of a point (light).
    """
    ax, names = style.panel(ax, dataset, "residual", "Fit.dataset()")
    angle, torque = names.angle, names.torque
    factor, text = style.prefixed(torque, float(np.abs(dataset[torque].values).max()))
    values, noise = factor * dataset[torque].values, factor * float(dataset["noise"])
    ax.axhline(0, color=GREY, linewidth=0.5, zorder=2.2)
    for leg in np.unique(dataset["leg"].values):
        one = dataset.isel(curve=np.flatnonzero(dataset["leg"].values == leg))
        x, y = one[f"{angle}_curve"].values, factor * one[f"{torque}_curve"].values
        error = factor * one[f"{torque}_curve_error"].values
        ax.plot(x, y, color=ACCENT, zorder=3, linewidth=1.1)
        # no band along the drop at the start of a way
        for wide, colour, zorder in ((np.full_like(error, noise), _NOISE, 1), (error, _ERROR, 2)):
            look: style.Look = {"color": colour, "linewidth": 0, "zorder": zorder}
            ax.fill_between(x[1:], (y - 2 * wide)[1:], (y + 2 * wide)[1:], **look)
    _points(ax, dataset, angle, values)
    handles = [
        *ax.get_legend_handles_labels()[0],
        style.key("fitted", color=ACCENT),
        Patch(color=_ERROR, linewidth=0, label="twice its standard error"),
        Patch(color=_NOISE, linewidth=0, label="twice the noise of a point"),
    ]
    _across(ax, names)
    ax.set_ylabel(text)
    ax.legend(handles=handles, loc="upper left")
    used = dataset["used"].values
    if not used.all() and (dataset["branch"].values == "beyond").any():
        # the axes follow the used points; points beyond the range may lie far above
        for limits, v in ((ax.set_xlim, dataset[angle].values), (ax.set_ylim, values)):
            low, high = float(v[used].min()), float(v[used].max())
            space = 0.15 * (high - low)
            limits(max(low - space, float(v.min()) - space / 3), min(high + space, float(v.max()) + space / 3))
    return ax


@style.styled
def prediction_figure(dataset: xr.Dataset) -> Figure:
    """Draw the predicted curve of a fit with its band, from ``squama.Fit.predict``."""
    figure = style.new_figure(style.PAGE, 3.4)
    ax, names = style.panel(figure.subplots(), dataset, "leg", "Fit.predict()")
    T = names.torque
    factor, text = style.prefixed(T, float(np.nanmax(np.abs(dataset[T].values))))
    for leg in np.unique(dataset["leg"].values):
        one = dataset.isel(point=np.flatnonzero(dataset["leg"].values == leg))
        x, low, high = one[names.angle].values, *(factor * one[f"{T}_{end}"].values for end in ("low", "high"))
        ax.fill_between(x, low, high, color=ACCENT, alpha=0.3, linewidth=0)
        ax.plot(x, factor * one[T].values, color=ACCENT, linewidth=1.1)
    share = f"{100 * float(dataset.attrs['probability']):g} % of {dataset.attrs['draws']} draws of the fit"
    handles = [style.key("estimates", color=ACCENT), Patch(color=ACCENT, alpha=0.3, linewidth=0, label=share)]
    ax.legend(handles=handles, loc="upper left")
    _across(ax, names)
    ax.set_ylabel(text)
    return style.headline(figure, f"Prediction in {dataset.attrs['load']}: {found(dataset)}", ())


def residuals(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw measured less fitted torque (moment) and twice the noise of a point, from :meth:`squama.Fit.dataset`."""
    ax, names = style.panel(ax, dataset, "residual", "Fit.dataset()")
    noise = float(dataset["noise"])
    small, words = style.prefixed(names.torque, float(np.nanmax(np.abs(dataset["residual"].values), initial=2 * noise)))
    noise_band(ax, small * noise)
    used = dataset.isel(point=np.flatnonzero(dataset["used"].values))
    _points(ax, used, names.angle, small * used["residual"].values)
    _across(ax, names)
    ax.set_ylabel(f"Residual {style.unit_of(words)}")
    return ax


def _across(ax: Axes, load: Load) -> None:
    """Label the axis with the load angle per pitch, or with the travel in mm."""
    ax.set_xlabel(style.label("travel", "mm") if load.pushed else style.angle_label(load.name))
    if load.pushed:
        ax.xaxis.set_major_formatter(lambda x, _: f"{1e3 * x:g}")


def noise_band(ax: Axes, noise: float) -> None:
    """Draw the band of twice the noise of a point around zero residual."""
    ax.axhspan(-2 * noise, 2 * noise, color=ACCENT, alpha=0.12, linewidth=0)
    ax.axhline(0, color=ACCENT, linewidth=0.8)


def found(dataset: xr.Dataset, left_out: str = "") -> str:
    """Return the estimates of a fit as text for its title, without that of ``left_out``."""
    estimates = (line.split(" = ") for line in dataset.attrs["estimates"].replace("+-", "±").split(", "))
    return ", ".join(
        f"{NAMES[name]} = {value.replace(' ', NO_BREAK)}"
        for name, value in estimates
        if name in NAMES and name != left_out
    )


def _points(ax: Axes, dataset: xr.Dataset, angle: str, values: Array) -> None:
    for name, (words, own) in _POINTS.items():
        mask = dataset["branch"].values == name
        if mask.any():
            look: style.Look = {"markersize": 3.0, **own, "linestyle": "", "zorder": 2.5, "label": words}
            ax.plot(dataset[angle].values[mask], values[mask], **look)


@style.styled
def corner_figure(dataset: xr.Dataset) -> Figure:
    """Draw the posterior samples of a fit, each parameter against each other, from :meth:`squama.Fit.dataset`.

    Diagonal: histograms, with the normal distribution of estimate and standard error. Below: samples, with the 95 %
    ellipse of the normal distribution of estimates and covariance.
    """
    samples, names = dataset["sample_value"].values, [str(n) for n in dataset["parameter"].values]
    estimate, error = dataset["estimate"].values, dataset["error"].values
    n, labels = len(names), []
    for name, unit in zip(names, dataset["unit"].values, strict=True):
        labels.append(f"{NAMES[name][:1].upper()}{NAMES[name][1:]}{'' if unit == '1' else f' ({unit})'}")
    figure = style.new_figure(min(style.PAGE, 1.2 + 1.9 * n), 0.6 + 1.8 * n)
    axes = figure.subplots(n, n, sharex="col", squeeze=False)
    angle = np.linspace(0, 2 * np.pi, 121)
    circle = np.sqrt(-2 * np.log(0.05)) * np.stack([np.cos(angle), np.sin(angle)])
    z = np.linspace(-3.5, 3.5, 121)
    for (i, j), ax in np.ndenumerate(axes):
        if j > i:
            ax.set_visible(False)
            continue
        if i == j:
            ax.hist(samples[:, i], bins=40, density=True, color=GREY, alpha=0.5)
            ax.plot(estimate[i] + error[i] * z, np.exp(-0.5 * z**2) / (error[i] * np.sqrt(2 * np.pi)), color=ACCENT)
            ax.set_yticks([])
            ax.spines["left"].set_visible(False)
        else:
            ax.plot(samples[:, j], samples[:, i], ".", color=INK, markersize=1.2, alpha=0.25, rasterized=True)
            c = dataset["correlation"].values[i, j]
            both = np.linalg.cholesky(np.array([[1, c], [c, 1 + 1e-12]])) @ circle
            ax.plot(estimate[j] + error[j] * both[0], estimate[i] + error[i] * both[1], color=ACCENT)
            ax.tick_params(labelleft=j == 0)
        ax.locator_params(axis="x", nbins=3)
        if i == n - 1:
            ax.set_xlabel(labels[j])
        if i and not j:
            ax.set_ylabel(labels[i])
    figure.align_ylabels(axes[1:, 0])
    words = "estimates and their covariance: 95 %"
    handles = [style.key("samples", color=GREY, linestyle="", marker="."), style.key(words, color=ACCENT)]
    figure.legend(handles=handles, loc="upper right")
    return figure
