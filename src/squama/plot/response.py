"""A response in four panels: load, friction force, inclination, dissipation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from squama.beam.design import Beam
from squama.io.measured import Measured
from squama.loads import HELD, LOADS, Load, model
from squama.model.outcome import End
from squama.plot.along import along
from squama.plot.palette import ACCENT, GREY, INK
from squama.plot.style import (
    PAGE,
    Colour,
    Look,
    axes_for,
    finite_max,
    headline,
    key,
    label,
    legend_below,
    legend_under,
    new_figure,
    prefixed,
    scaled_above,
    shades,
    styled,
)
from squama.symbols import SYMBOLS
from squama.types import Array

BEYOND = 1.3
"""Axes end this far beyond the measured points, over their own size."""
READABLE = 0.9
"""Near a lock the load grows without bound: axes end at this fraction of the way from engagement to the lock."""
BESIDE: Look = {"linewidth": 0.7, "zorder": 1.5}
SQUARE: Look = {"markerfacecolor": "white", "markersize": 3, "zorder": 4}
"""The hinge's curve beside another one, and where it engages."""
RISING = {"N", "f", "f0", "K_t", "K_b", "T_scales", "M_scales", "W_fr"}
"""Variables that grow without bound towards a lock."""


class _Curve(NamedTuple):
    """One curve, taken out of the dataset: ``data`` has the dimension ``point`` only."""

    data: xr.Dataset
    mu: float
    colour: Colour
    rate: Array
    rate_e: float
    rate_end: float
    end: str

    @property
    def engages(self) -> bool:
        """Whether part of it is in contact."""
        return bool(np.isfinite(self.rate_e) and self.rate_e <= self.rate_end)

    @property
    def locks(self) -> bool:
        """Whether it ends with a lock."""
        return End(self.end).locks

    @property
    def stops(self) -> bool:
        """Whether it ends without a lock; where nothing ever touches it has no end."""
        return not self.locks and (self.end != "no engagement" or bool(self.data["other_contact"].item()))


@styled
def response_figure(dataset: xr.Dataset, measured: Measured | None = None, hinge: xr.Dataset | None = None) -> Figure:
    """Draw what a beam does when it is twisted or bent: one curve, or a family over ``mu``, with ``measured`` points.

    ``hinge`` is the answer of hinges for the same beam and frictions, drawn thin beside it as far as the axes go, which
    are those of ``dataset``.

    With measured points the axes follow them: a curve that goes far beyond, or climbs to a lock, leaves the picture.
    Four panels: torque or moment with the beam without contact dashed, engagement and end marked; friction force;
    inclination; relative energy dissipation (the tangent stiffness if there is no friction). The load grows without
    bound towards a lock, so its axis ends before.

    >>> import squama
    >>> r = squama.twist(squama.Beam.from_ratios(), mu=[0.2, 0.5], points=50)
    >>> len(response_figure(r).axes)
    4
    """
    names = LOADS[dataset.attrs["load"]]
    curves = _curves(dataset, names)
    beam = Beam.from_toml_text(dataset.attrs["beam"])
    figure = new_figure(PAGE, 5.2)
    axes = figure.subplots(2, 2, sharex=True)
    load, friction, inclination, last = axes.flat
    right = _right(curves, measured)
    rubs = any(c.mu > 0 for c in curves)
    locks = [c.data["mu_lock"] for c in curves if "mu_lock" in c.data]
    touched = any((c.data["N"] > 0).any() for c in curves) or any(mu.notnull().any() for mu in locks)
    drawn = {load: names.torque, friction: "f0" if rubs else "N", inclination: "theta"}
    drawn[last] = "RED" if rubs and touched else names.tangent
    panels = []
    for ax, name in drawn.items():
        if ax is friction and not touched:
            _empty(ax, curves)
        else:
            panels.append((ax, name, _variable(ax, curves, name, right, measured)))
    for ax, text in zip(axes.flat, "abcd", strict=True):
        _room(ax, right)
        ax.text(0.03, 0.97, f"({text})", transform=ax.transAxes, fontweight="bold", va="top")
        _locks(ax, curves, right)
    others = _hinges(hinge, dataset, names)
    for panel in panels:
        _beside(*panel, others, right)
    for ax in axes[1]:
        ax.set_xlabel(label(names.rate))
    above = f"{names.verb.capitalize()} of the whole beam, {beam.scales} scales (deg)"
    scaled_above(load, beam.length * 180 / np.pi, above)
    legend_below(figure, _keys(curves, measured, others, right), 4 if others else 7)
    return headline(figure, _title(dataset, curves))


def curve(
    dataset: xr.Dataset,
    name: str,
    ax: Axes | None = None,
    *,
    measured: Measured | None = None,
    hinge: xr.Dataset | None = None,
) -> Axes:
    """Draw a variable of :func:`squama.twist` or ``bend`` over the rate, one curve or a family over ``mu``, with marks.

    Engagement, ends and locks are marked; where a variable grows without bound towards a lock the axis ends before.
    Beside torque and moment stands the beam without contact; ``measured`` points belong to them, and the axes follow
    them. ``hinge``, the answer of hinges for the same beam and frictions, is drawn thin as far as these axes go.

    Raises
    ------
    InputError
        There is no such number along the curve, or the dataset is no curve of one load.

    Examples
    --------
    >>> import squama
    >>> r = squama.twist(squama.Beam.from_ratios(), mu=[0.2, 0.5], joint="hinge", points=50)
    >>> curve(r, "T").get_ylabel()
    'Torque $T$ (kN m)'
    """
    load = dataset.attrs.get("load")
    ax = axes_for(ax, dataset, f"{LOADS[load].rate}_end" if load in LOADS else "", "squama.twist or bend")
    names = LOADS[dataset.attrs["load"]]
    along(dataset, name)
    curves = _curves(dataset, names)
    right = _right(curves, measured)
    factor = _variable(ax, curves, name, right, measured)
    _locks(ax, curves, right)
    others = _hinges(hinge, dataset, names)
    _beside(ax, name, factor, others, right)
    ax.set_xlabel(label(names.rate))
    handles = _keys(curves, measured, others, right, load=name == names.torque)
    if others:
        legend_under(ax, handles)
    elif handles:
        ax.legend(handles=handles)
    return ax


def _curves(dataset: xr.Dataset, names: Load) -> list[_Curve]:
    mus = np.atleast_1d(dataset["mu"].values)
    colours = shades(mus.size) if mus.size > 1 else [INK]
    out = []
    for i, (mu, colour) in enumerate(zip(mus, colours, strict=True)):
        data = dataset.isel(mu=i) if "mu" in dataset.dims else dataset
        rate = np.asarray(data[names.rate].values, float)
        order = np.argsort(rate, kind="stable")
        data = data.isel(point=order)
        e, last = float(data[f"{names.rate}_e"]), float(data[f"{names.rate}_end"])
        out.append(_Curve(data, float(mu), colour, rate[order], e, last, str(data["end"].values)))
    return out


def _right(curves: list[_Curve], measured: Measured | None) -> float:
    """Right end of the twist axis: past every end, or past the measured points and the first engagement."""
    if measured is not None:
        engaged = min((c.rate_e for c in curves if c.engages), default=0.0)
        return BEYOND * max(finite_max(np.asarray(measured.rate, float), 0.0), engaged) or 1.0
    ends = [c.rate_end if np.isfinite(c.rate_end) else finite_max(c.rate) for c in curves]
    shown = [min(end, 1.05 * finite_max(c.rate)) for c, end in zip(curves, ends, strict=True)]
    right = max(*shown, 0.0)
    return 1.08 * right if right > 0 else 1.0


def _limit(curves: list[_Curve], name: str, right: float) -> float:
    """Largest value to be seen: all of a curve that stays bounded; of those that lock, the typical readable part."""
    bounded, locking = [0.0], [0.0]
    for c in curves:
        v = np.asarray(c.data[name].values, float)
        v = np.where(c.rate <= right, v, np.nan)
        steep = c.end == "other contact" and len(curves) > 1
        if (c.locks or steep) and c.rate_end > c.rate_e:
            locking.append(finite_max(v[c.rate <= c.rate_e + READABLE * (c.rate_end - c.rate_e)], 0.0))
        else:
            bounded.append(finite_max(v, 0.0))
    seen = [v for v in locking if v > 0]
    return max(*bounded, float(np.median(seen)) if seen else 0.0)


def _variable(ax: Axes, curves: list[_Curve], name: str, right: float, measured: Measured | None) -> float:
    """Draw a variable within its axes; return the factor of its unit."""
    attrs = curves[0].data.attrs
    ax.set_xlim(0, right)
    if name == LOADS[attrs["load"]].torque:
        return _load(ax, curves, right, measured)
    factor, text = 1.0, label(name)
    if name == "theta":
        factor, text = 180 / np.pi, label(name, "deg")
    elif SYMBOLS[name].unit not in ("1", "rad", "N"):
        largest = _limit(curves, name, right) or max(finite_max(np.abs(c.data[name].values)) for c in curves)
        factor, text = prefixed(name, largest)
    _panel(ax, curves, name, factor, text)
    if name == "RED":
        ax.set_ylim(0, max(0.05, 1.05 * _span(ax)[1]))
    elif name == "theta":
        low, high = _span(ax)
        ax.set_ylim(max(0.0, low if high - low > 2 else low - 5), high if high - low > 2 else low + 5)
    elif name in RISING:
        ax.set_ylim(0, 1.08 * factor * _limit(curves, name, right) or 1.0)
    return factor


def _load(ax: Axes, curves: list[_Curve], right: float, measured: Measured | None) -> float:
    """Draw the load; return the factor of its unit."""
    names, beam = LOADS[curves[0].data.attrs["load"]], Beam.from_toml_text(curves[0].data.attrs["beam"])
    rigidity = float(curves[0].data.attrs.get("rigidity", names.rigidity(beam)))
    top = 1.08 * max(_limit(curves, names.torque, right), 1.25 * rigidity * right / 1.08)
    if measured is not None:
        most = finite_max(np.asarray(measured.load, float), 0.0)
        top = max(min(top, BEYOND * most), 1.08 * most, 1.08 * rigidity * right)
    factor, text = prefixed(names.torque, top)
    ax.plot([0, right], [0, factor * rigidity * right], color=GREY, linestyle=(0, (4, 2)), linewidth=1)
    _panel(ax, curves, names.torque, factor, text)
    for rate in [c.rate_e for c in curves if c.engages]:
        ax.plot(rate, factor * rigidity * rate, "o", color=INK, markerfacecolor="white", markersize=4, zorder=4)
    if measured is not None:
        ax.plot(measured.rate, factor * np.asarray(measured.load, float), ".", color=ACCENT, markersize=4, zorder=3)
    ax.set_ylim(0, factor * top)
    return factor


def _panel(ax: Axes, curves: list[_Curve], name: str, factor: float, text: str) -> None:
    """Draw one variable, with the ends of its curves."""
    for c in curves:
        v = factor * np.asarray(c.data[name].values, float)
        ax.plot(c.rate, v, color=c.colour)
        _end(ax, c, v)
    ax.set_ylabel(text)


def _locks(ax: Axes, curves: list[_Curve], right: float) -> None:
    """Draw a thin vertical line where a curve locks."""
    for c in curves:
        if c.locks and c.rate_end <= right:
            ax.axvline(c.rate_end, color=c.colour, linewidth=0.8, linestyle=":", zorder=0)


def _span(ax: Axes) -> tuple[float, float]:
    """Return the lowest and the highest value of the curves within the axes, with some room."""
    every = np.concatenate([np.asarray(line.get_xydata(), float) for line in ax.lines])
    seen = every[(every[:, 0] <= ax.get_xlim()[1]) & np.isfinite(every[:, 1]), 1]
    low, high = (float(seen.min()), float(seen.max())) if seen.size else (0.0, 0.0)
    room = 0.05 * (high - low)
    return low - room, high + room


def _hinges(hinge: xr.Dataset | None, dataset: xr.Dataset, names: Load) -> list[_Curve]:
    """Return the hinge's curves, their friction force over the stiffness of the other answer's joint."""
    if hinge is None:
        return []
    own = Beam.from_toml_text(dataset.attrs["beam"]).joint_stiffness
    return _curves(hinge.assign(f0=hinge["f0"] * (own / dataset.attrs.get("K_theta", own))), names)


def _beside(ax: Axes, name: str, factor: float, others: list[_Curve], right: float) -> None:
    """Draw the hinge's curves thin, within the axes as they are, and where they engage beside the load."""
    limits = ax.get_ylim()
    for c in others:
        v = factor * np.asarray(c.data[name].values, float)
        ax.plot(c.rate, v, color=c.colour, **BESIDE)
        names = LOADS[c.data.attrs["load"]]
        if name == names.torque and c.engages:
            bare = names.rigidity(Beam.from_toml_text(c.data.attrs["beam"])) * c.rate_e
            ax.plot(c.rate_e, factor * bare, "s", color=c.colour, **SQUARE)
    _locks(ax, others, right)
    ax.set_ylim(limits)


def _end(ax: Axes, c: _Curve, v: Array) -> None:
    """Mark the end of a curve that does not lock; on the axis the mark is not cut in half."""
    good = np.flatnonzero(np.isfinite(v))
    if good.size and c.stops and c.rate[good[-1]] <= ax.get_xlim()[1]:
        ax.plot(c.rate[good[-1]], v[good[-1]], "x", color=c.colour, zorder=4, clip_on=bool(v[good[-1]]))


def _room(ax: Axes, right: float) -> None:
    """Keep curves off the letter of the panel in its upper left corner."""
    low, high = ax.get_ylim()
    drawn = np.concatenate([np.asarray(line.get_xydata(), float) for line in ax.lines] or [np.empty((0, 2))])
    top = finite_max(drawn[drawn[:, 0] < 0.14 * right, 1], low)
    if top > low + 0.84 * (high - low):
        ax.set_ylim(low, low + (top - low) / 0.8)


def _empty(ax: Axes, curves: list[_Curve]) -> None:
    """Say why there is no friction force."""
    static = any(c.end == "static lock" for c in curves)
    words = "locked as soon as the scales touch:\nno sliding, no friction work" if static else "no sliding contact"
    ax.text(0.5, 0.5, words, transform=ax.transAxes, ha="center", va="center", color=GREY)
    ax.set(ylabel=label("f0"), yticks=[])


def _keys(
    curves: list[_Curve], measured: Measured | None, others: list[_Curve], right: float, *, load: bool = True
) -> list[Line2D]:
    """Return what a legend says, of marks that stand beside the ``load`` only if it is drawn."""
    handles: list[Line2D] = []
    if others:
        attrs = (c.data.attrs for c in (curves[0], others[0]))
        whose = [f"{about['scales']} on {HELD[about['joint']]}" for about in attrs]
        handles += [key(whose[0]), key(whose[1], **BESIDE)]
    if len(curves) > 1:
        handles += [key(rf"$\mu$ = {c.mu:g}", color=c.colour) for c in curves]
    if load:
        handles.append(key("no contact", color=GREY, linestyle=(0, (4, 2)), linewidth=1))
    if load and any(c.engages for c in curves):
        handles.append(key("engagement", linestyle="", marker="o", markerfacecolor="white", markersize=4))
    if load and any(c.engages for c in others):
        handles.append(key("engagement on hinges", linestyle="", marker="s", **SQUARE))
    if any(c.locks and c.rate_end <= right for c in (*curves, *others)):
        handles.append(key("lock on hinges" if others else "lock", linestyle=":", linewidth=0.8))
    if any(c.stops and min(c.rate_end, finite_max(c.rate)) <= right for c in curves):
        words = "end" if any(c.locks for c in curves) else "end, no lock"
        handles.append(key(words, linestyle="", marker="x"))
    if load and measured is not None:
        handles.append(key("measured", color=ACCENT, linestyle="", marker="."))
    return handles


def _title(dataset: xr.Dataset, curves: list[_Curve]) -> str:
    kind = f"{dataset.attrs['load'].capitalize()} of {model(dataset.attrs)}"
    sense = f", sense {dataset.attrs['sense']}" if "sense" in dataset.attrs else ""
    if len(curves) > 1:
        return f"{kind}{sense}"
    c = curves[0]
    text = f"{kind}{sense}, $\\mu$ = {c.mu:g}: {c.end}"
    at = f" at {c.rate_end:.4g} rad/m" if np.isfinite(c.rate_end) else ""
    other = str(c.data["other_contact"].values)
    if c.end == "no engagement":
        touch = f" at {float(c.data['phi_touch']):.4g} rad/pitch" if "phi_touch" in c.data else ""
        return f"{text}; {other} touches{touch}" if other else text
    return f"{text}{at}: {other}" if other else text + at
