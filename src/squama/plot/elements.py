"""Curves by finite elements: torque, inclination, contact forces and energies; and models beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from squama.fe.compare import FINITE
from squama.model.solve import Array
from squama.plot.style import (
    ACCENT,
    GREY,
    INK,
    PAGE,
    finite_max,
    key,
    label,
    letter,
    new_figure,
    prefixed,
    shades,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr

TWIST = r"Twist per pitch $\varphi$ (rad)"
BARE = {"color": GREY, "linestyle": (0, (4, 2)), "linewidth": 1}
LINES: tuple[Any, ...] = ((0, (4, 1.6)), "-", (0, (1, 1.1)), (0, (5, 1.5, 1, 1.5)), (0, (7, 2)))
"""Lines of the models, in their order."""
MARKS: tuple[Any, ...] = (":", (0, (5, 2)), (0, (4, 1.5, 1, 1.5)))
"""Vertical lines where the contact changes."""
FAR = 40.0
"""Differences of the torque are drawn up to this, percent."""


@styled
def elements_figure(data: xr.Dataset) -> Figure:
    """Draw a run of finite elements.

    Parameters
    ----------
    data : xarray.Dataset
        From :func:`squama.fe.facade.cell`.

    Returns
    -------
    matplotlib.figure.Figure
        Four panels over the twist rate: torque with the start's slope dashed; inclination; normal and friction
        force; energies per length. Ticks at the foot of the inclination: increments. Vertical lines: from there on
        another pair touches.
    """
    figure = new_figure(PAGE, 5.2)
    axes = figure.subplots(2, 2, sharex=True)
    load, inclination, forces, energies = axes.flat
    rate = np.asarray(data["Phi"].values, float)
    right = 1.04 * finite_max(rate) or 1.0
    factor, text = prefixed("T", finite_max(np.abs(data["T"].values)))
    slope = _slope(data)
    load.plot([0, right], [0, factor * slope * right], **BARE)
    load.plot(rate, factor * data["T"].values, color=INK)
    load.set_ylabel(text)
    inclination.plot(rate, np.degrees(data["theta"].values), color=INK)
    inclination.set_ylabel(label("theta", "deg"))
    colours = shades(3)
    factor, text = prefixed("N", max(finite_max(data["N"].values), finite_max(data["f"].values)))
    forces.plot(rate, factor * data["N"].values, color=INK)
    forces.plot(rate, factor * data["f"].values, color=ACCENT)
    forces.set_ylabel(text.replace("Normal force $N$", "Force of a contact"))
    forces.legend(handles=[key("normal $N$"), key("friction $f$", color=ACCENT)], loc="center left")
    factor, text = prefixed("W", finite_max(data["W"].values))
    names = {"W": "torque's work $W$", "U_el": r"elastic $U_\mathrm{el}$", "W_fr": r"frictional $W_\mathrm{fr}$"}
    for (name, words), colour in zip(names.items(), (colours[0], colours[1], ACCENT), strict=True):
        energies.plot(rate, factor * data[name].values, color=colour, label=words)
    energies.plot(rate, factor * (data["U_el"] + data["W_fr"]).values, color=INK, linestyle=(0, (1, 1.5)), label="sum")
    energies.set_ylabel(text.replace("Work of the torque per length $W$", "Energy per length"))
    energies.legend(loc="center left")
    inclination.plot(rate, np.zeros_like(rate), "|", color=GREY, markersize=4, transform=_foot(inclination))
    changes = [(at, words, mark) for (at, words), mark in zip(_changes(data), MARKS * 8, strict=False)]
    for ax, name in zip(axes.flat, "abcd", strict=True):
        letter(ax, f"({name})")
        ax.set_xlim(0, right)
        if ax is not inclination:
            ax.set_ylim(0, None)
        for at, _, mark in changes:
            ax.axvline(at, color=GREY, linewidth=0.8, linestyle=mark, zorder=0)
    for ax in axes[1]:
        ax.set_xlabel(label("Phi"))
    pitch = float(data["phi"][-1] / data["Phi"][-1]) if data["Phi"][-1] else 1.0
    for ax in axes[0]:
        top = ax.secondary_xaxis("top", functions=(lambda x: x * pitch, lambda x: x / pitch))
        top.set_xlabel(TWIST, fontsize=7)
        top.tick_params(labelsize=7)
        top.xaxis.set_major_locator(MaxNLocator(6))
    handles = [key("slope at the start", **BARE), key("increment", color=GREY, linestyle="", marker="|", markersize=4)]
    handles += [
        key(f"from {pitch * at:.4g} rad/pitch: {words or 'no contact'}", color=GREY, linestyle=mark, linewidth=0.8)
        for at, words, mark in changes
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2 if changes else 3)
    figure.suptitle(_title(data), fontsize=8, x=0.01, ha="left")
    return figure


def _foot(ax: Axes) -> Any:
    """Return a transformation in which y = 0 is the foot of a panel."""
    return ax.get_xaxis_transform()


def _slope(data: xr.Dataset) -> float:
    rate, T = (np.asarray(data[name].values, float) for name in ("Phi", "T"))
    there = np.flatnonzero(rate > 0)
    return float(T[there[0]] / rate[there[0]]) if there.size else 0.0


def _changes(data: xr.Dataset) -> list[tuple[float, str]]:
    """Return twist rates from which on something else touches, and what."""
    out, before = [], ""
    for rate, words in zip(data["Phi"].values, data["contact"].values, strict=True):
        if str(words) != before:
            before = str(words)
            out.append((float(rate), before))
    return out


def _title(data: xr.Dataset) -> str:
    blocked = ", roll and yaw blocked" if "blocked" in data.attrs["joint"] else ""
    stopped = "" if data.attrs["reached"] else f"\n{data.attrs['sentence']}"
    return (
        f"Periodic cell of finite elements{blocked}, sense {data.attrs['sense']}, $\\mu$ = {float(data['mu']):g}: "
        f"{data.attrs['mesh']}{stopped}"
    )


@styled
def compare_figure(table: xr.Dataset) -> Figure:
    """Draw models beside a curve by finite elements.

    Parameters
    ----------
    table : xarray.Dataset
        From :func:`squama.fe.compare.compare`.

    Returns
    -------
    matplotlib.figure.Figure
        Torque, its difference from the elements' with the band within which a model counts as holding, inclination
        and its difference, all over the twist per pitch. Finite beams have no differences.
    """
    figure = new_figure(PAGE, 5.4)
    axes = figure.subplots(2, 2, sharex=True)
    phi = np.asarray(table["phi"].values, float)
    factor, text = prefixed("T", finite_max(table["T_elements"].values))
    own: dict[str, Any] = {"color": INK, "marker": "o", "markersize": 2.6, "linewidth": 0.8}
    axes[0, 0].plot(phi, factor * table["T_elements"].values, **own)
    axes[1, 0].plot(phi, np.degrees(table["theta_elements"].values), **own)
    names = [str(name) for name in table["model"].values]
    looks = _looks(names)
    for name, style in looks.items():
        one = table.sel(model=name)
        axes[0, 0].plot(phi, factor * one["T"].values, **style)
        axes[1, 0].plot(phi, np.degrees(one["theta"].values), **style)
        if name not in FINITE:
            axes[0, 1].plot(phi, 100 * one["dT"].values, **style)
            axes[1, 1].plot(phi, np.degrees(one["dtheta"].values), **style)
    share = 100 * float(table.attrs["share"])
    axes[0, 1].axhspan(-share, share, color=GREY, alpha=0.18, linewidth=0)
    axes[1, 1].axhline(0, color=GREY, linewidth=0.7)
    _limits(axes[0, 0], factor * np.asarray(table["T_elements"].values, float))
    off = 100 * np.asarray(table["dT"].sel(model=[name for name in names if name not in FINITE]).values, float)
    top, low = (min(FAR, 1.1 * finite_max(np.maximum(s * off, 0), share)) for s in (1, -1))
    axes[0, 1].set_ylim(-max(low, 1.6 * share), max(top, 1.6 * share))
    axes[0, 0].set_ylabel(text)
    axes[0, 1].set_ylabel("Difference of the torque (%)")
    axes[1, 0].set_ylabel(label("theta", "deg"))
    axes[1, 1].set_ylabel(r"Difference of $\theta$ (deg)")
    for ax, name in zip(axes.flat, "abcd", strict=True):
        letter(ax, f"({name})")
        ax.set_xlim(0, 1.03 * finite_max(phi))
    for ax in axes[1]:
        ax.set_xlabel(TWIST)
    figure.legend(handles=_handles(table, looks, own), loc="outside lower center", ncols=2)
    figure.suptitle(str(table.attrs["title"]), fontsize=8, x=0.01, ha="left")
    return figure


def _looks(names: list[str]) -> dict[str, dict[str, Any]]:
    """Return how each model is drawn; finite beams are grey."""
    endless = [name for name in names if name not in FINITE]
    colours = [*shades(max(len(endless) - 1, 1)), ACCENT][-len(endless) :]
    looks = {
        name: {"color": colour, "linestyle": line}
        for name, colour, line in zip(endless, colours, LINES * len(names), strict=False)
    }
    return looks | {
        name: {"color": GREY, "linestyle": line}
        for name, line in zip(FINITE, ("-", (0, (3, 1.5))), strict=True)
        if name in names
    }


def _handles(table: xr.Dataset, looks: dict[str, dict[str, Any]], own: dict[str, Any]) -> list[Line2D]:
    handles = [key(f"finite elements: {table.attrs['elements']}", **own)]
    return handles + [key(str(table["words"].sel(model=name).item()), **style) for name, style in looks.items()]


def _limits(ax: Axes, reference: Array) -> None:
    """Show the whole of the reference; a model that runs away leaves the panel."""
    top = 1.6 * finite_max(reference)
    ax.set_ylim(0, min(top, ax.get_ylim()[1]))
