"""Regime maps (paper Fig. 5), and the lock lines of twisting beside those of bending."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.loads import LOADS
from squama.plot.palette import ACCENT, GREY, INK
from squama.plot.style import DASHES, PAGE, Look, key, law_keys, letter, new_figure, shades, styled
from squama.symbols import SYMBOLS
from squama.types import Array

ROTATION = r"Rotation of the scales $(\theta-\theta_0)/\pi$ (1)"
SHOWN = ("frictional lock", "static lock")
STOPS: dict[str, tuple[Look, str]] = {
    "other": ({"marker": "o", "markersize": 3.2}, "beyond: ends without a lock"),
    "range": ({"marker": "o", "markersize": 3.6, "markerfacecolor": "white"}, "drawn so far: {}"),
}
"""Marks where an envelope stops, by why: another end takes over, or the range of the drawing; and their words."""


@styled
def regime_figure(dataset: xr.Dataset) -> Figure:
    """Draw the regimes of a beam in twisting (linear, sliding, locked), from :func:`squama.paper.maps.regimes`.

    Axes phi/pi and (theta - theta0)/pi; paths of the scales, the kinematic and the frictional envelopes, and where the
    contact leaves the tip edge or another pair of plates touches.
    """
    theta0, over = float(dataset.attrs["theta0"]), str(dataset.attrs["over"])
    figure = new_figure(PAGE, 4.3)
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
    colours = shades(len(mus))
    marked: set[str] = set()
    for law in laws:
        for mu, colour in zip(mus, colours, strict=True):
            line = dataset.sel(law=law, mu=mu)
            x, y = scaled(line["phi_end"], line["theta_end"])
            keep = np.isin(line["end"].values, SHOWN)
            # at a static lock the line runs on the axis: its first point there is enough
            still = line["end"].values == "static lock"
            keep &= ~(still & np.roll(still, 1) & np.roll(still, -1))
            ax.plot(np.where(keep, x, np.nan), np.where(keep, y, np.nan), color=colour, linestyle=DASHES[law])
            # off the axis it stops beside designs that end without a lock, and at the ends of the range
            locked, sliding = np.isin(line["end"].values, SHOWN), line["end"].values == "frictional lock"
            beside = np.r_[False, ~locked[:-1]] | np.r_[~locked[1:], False]
            outer = np.arange(locked.size) % (locked.size - 1) == 0
            for mark, at in (("other", sliding & beside), ("range", sliding & outer & ~beside)):
                marked |= {mark} if at.any() else set()
                ax.plot(x[at], y[at], linestyle="", color=colour, **STOPS[mark][0])
    ax.set_xlim(0, 1.03 * max(right, float(np.nanmax(dataset["phi_lock"].values)) / np.pi))
    ax.set(ylim=(0, 1.08 * float(np.nanmax(dataset["theta_lock"].values) - theta0) / np.pi), xlabel=over_pi("twisting"))
    ax.set_ylabel(ROTATION)
    handles = [key("kinematic lock", linewidth=2.2)]
    handles += [key(rf"frictional lock, $\mu$ = {mu:g}", color=c) for mu, c in zip(mus, colours, strict=True)]
    handles += law_keys(laws)
    handles.append(key(rf"path of the scales for one $\{over}$", color=GREY, linewidth=0.9))
    if np.isfinite(dataset["phi_off"].values).any():
        handles.append(key("contact leaves the tip edge", color=GREY, linestyle="-.", linewidth=1.6))
    if np.isfinite(dataset["phi_touch"].values).any():
        handles.append(key("other plates touch first", color=ACCENT, linestyle=":"))
    limits = dataset["scan"].values[[0, -1]] * (180 / np.pi if over == "alpha" else 1)
    unit = "°" if over == "alpha" else ""
    span = rf"$\{over}$ = {limits[0]:.3g}{unit} or {limits[1]:.3g}{unit}"
    handles += [key(words.format(span), linestyle="", **style) for m, (style, words) in STOPS.items() if m in marked]
    figure.legend(handles=handles, loc="outside right center")
    x, y = scaled(dataset["phi_lock"], dataset["theta_lock"])
    there, (wide, high) = np.isfinite(x), (ax.get_xlim()[1], ax.get_ylim()[1])
    # linear on the axis before engagement, nonlinear while sliding, locked beyond the envelope
    words: Look = {"style": "italic", "fontsize": 7.5, "color": INK}
    ax.text(float(np.median(x[there])), float(np.max(y[there])) + 0.012, "locked", ha="center", va="bottom", **words)
    ax.text(0.022 * wide, 0.62 * high, "sliding: nonlinear", rotation=90, ha="center", va="center", **words)
    ax.text(0.985 * wide, 0.02 * high, "on the axis: no contact, linear", ha="right", va="bottom", **words)
    return figure


def tag(ax: Axes, x: Array, y: Array, text: str, pad: float = 0.8) -> None:
    """Write beside the end of a path which one it is."""
    box = {"facecolor": "white", "edgecolor": "none", "pad": pad, "alpha": 0.85}
    i = int(np.argmin(abs(y - 0.62 * y.max())))
    ax.text(x[i], y[i], text, fontsize=6.5, color=INK, ha="center", va="center", bbox=box, zorder=6)


def over_pi(load: str) -> str:
    """Return the label of an axis of load angles over pi."""
    of = LOADS[load]
    return rf"{of.verb.capitalize()} per pitch ${SYMBOLS[of.angle].tex}/\pi$ (1)"


@styled
def lock_lines_figure(dataset: xr.Dataset) -> Figure:
    """Set the lock lines of twisting beside those of bending, from :func:`squama.paper.maps.lock_lines`.

    Above, the lock lines; below, their distance from the kinematic line. In bending it is arctan(mu) everywhere, so the
    line is a translate; in twisting it is not.
    """
    figure = new_figure(PAGE, 5.2)
    axes = figure.subplots(2, 2, sharex="col", sharey="row")
    mus = [float(mu) for mu in dataset["mu"].values]
    fixed = rf"$\eta$ varies along a line from {dataset.attrs['eta_low']:g} (right) to {dataset.attrs['eta_high']:g}"
    # the first is 0, the kinematic lock
    colours = dict(zip(mus[1:], shades(len(mus) - 1), strict=True))
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
        letter(top, f"({'ab'[column]}) {loading}: {fixed}")
        letter(low, f"({'cd'[column]}) {loading}: distance below the kinematic line")
    axes[0][0].set(ylabel=r"Inclination at the lock $\theta$ (deg)", ylim=(0, None))
    axes[1][0].set(ylabel="Drop of the inclination (deg)", ylim=(0, None))
    handles = [key(r"kinematic lock, $\mu$ = 0", linewidth=2.2)]
    handles += [key(rf"frictional lock, $\mu$ = {mu:g}", color=c) for mu, c in colours.items()]
    handles.append(key(r"a translate by arctan $\mu$", color=GREY, linestyle=":", linewidth=0.8))
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure
