"""A response in four panels (load, friction force, inclination, dissipation), and single variables of a result."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from squama import arguments
from squama.beam.design import Beam
from squama.curves.labelled import MEAN
from squama.errors import refuse
from squama.io.measured import Measured
from squama.loads import HELD, LOADS, Load, ending, model
from squama.model.outcome import End
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK, LOCKS, READABLE
from squama.symbols import SYMBOLS
from squama.types import Array
from squama.units import look_up, shown

BEYOND = 1.3
"""Length of the axes over the range of the measured points."""
BESIDE: style.Look = {"linewidth": 0.7, "zorder": 1.5}
SQUARE: style.Look = {"markerfacecolor": "white", "markersize": 3, "zorder": 4}
"""Styles of the curve on hinges, and of its engagement."""
EACH: style.Look = {"linewidth": 0.4, "alpha": 0.3, "zorder": 1.2}
"""Style of the curve of each of N scales."""
WITHOUT_ENDS: style.Look = {"linewidth": 0.9, "linestyle": ":"}
"""Style of the endless beam's curve."""
LOCK: style.Look = {"linewidth": 0.8, "linestyle": "-."}
"""Style of the line at a lock."""
RISING = {"N", "f", "f0", "K_t", "K_b", "T_scales", "M_scales", "W_fr"}
"""Variables that grow without bound towards a lock."""


class _Curve(NamedTuple):
    """One curve of the dataset: ``data`` with the dimension ``point`` only, ``each`` with those of N scales."""

    data: xr.Dataset
    each: xr.Dataset
    mu: float
    colour: style.Colour
    rate: Array
    rate_e: float
    rate_end: float
    end: str

    def values(self, name: str) -> Array:
        """Return a variable along the curve (n,)."""
        return np.asarray(self.data[name].values, float)

    @property
    def engages(self) -> bool:
        """Whether part of the curve is in contact."""
        return bool(np.isfinite(self.rate_e) and self.rate_e <= self.rate_end)

    @property
    def stops(self) -> bool:
        """Whether the curve ends without a lock; a curve without any contact has no end."""
        return self.end not in LOCKS and (self.end != "no engagement" or bool(self.data["other_contact"].item()))


class _Shown(NamedTuple):
    """Contents of a figure of a response; the axes end at the rate ``right``, ``others``: curves on hinges."""

    kind: Load
    beam: Beam
    rigidity: float
    curves: list[_Curve]
    others: list[_Curve]
    measured: Measured | None
    right: float


@style.styled
def response_figure(dataset: xr.Dataset, measured: Measured | None = None, hinge: xr.Dataset | None = None) -> Figure:
    """Draw the response of a beam to twist or bend: one curve, or a family over ``mu``, with ``measured`` points.

    ``hinge``: the response of the same beam on hinges, drawn thin within the axes of ``dataset``. With measured points
    the axes follow them, and curves may leave the picture. Four panels: torque or moment with the beam without contact
    (dashed), engagement and end marked; friction force; inclination; relative energy dissipation (tangent stiffness
    without friction). The load grows without bound towards a lock, so its axis ends before.

    >>> import squama
    >>> r = squama.twist(squama.Beam.from_ratios(), mu=[0.2, 0.5], points=50)
    >>> len(response_figure(r).axes)
    4
    """
    shown = _read(dataset, measured, hinge)
    figure, kind = style.new_figure(style.PAGE, 5.2), shown.kind
    axes = figure.subplots(2, 2, sharex=True)
    rubs = any(c.mu > 0 for c in shown.curves)
    locks = [c.data["mu_lock"] for c in shown.curves if "mu_lock" in c.data]
    touched = any((c.data["N"] > 0).any() for c in shown.curves) or any(mu.notnull().any() for mu in locks)
    force = ("f" if rubs else "N") if touched else ""
    names = [kind.torque, force, "theta", "RED" if rubs and touched else kind.tangent]
    for ax, name, text in zip(axes.flat, names, "abcd", strict=True):
        _draw(ax, shown, name, letter=f"({text})")
    for ax in axes[1]:
        ax.set_xlabel(style.label(kind.rate))
    for ax in axes[0]:
        style.degrees_above(ax, kind, shown.beam, shown.beam.pitch)
    style.legend_below(figure, _keys(shown, names), 4 if shown.others else 7)
    return style.headline(figure, _title(dataset, shown.beam, shown.curves))


def curve(
    dataset: xr.Dataset,
    name: str,
    ax: Axes | None = None,
    *,
    measured: Measured | None = None,
    hinge: xr.Dataset | None = None,
) -> Axes:
    """Draw a variable of :func:`squama.twist` or ``bend`` over the rate, one curve or a family over ``mu``.

    Engagement, ends and locks are marked; where a variable grows without bound towards a lock the axis ends before.
    Torque and moment have the beam without contact and ``measured`` points, which the axes follow. ``hinge``, the
    response on hinges of the same beam and frictions, is drawn thin within these axes.

    Raises
    ------
    InputError
        The variable is no number along the curve, or the dataset is no curve of one load.

    Examples
    --------
    >>> import squama
    >>> r = squama.twist(squama.Beam.from_ratios(), mu=[0.2, 0.5], joint="hinge", points=50)
    >>> curve(r, "T").get_ylabel()
    'Torque $T$ (N m)'
    """
    arguments.result(dataset)
    load = LOADS.get(dataset.attrs.get("load", ""))
    own = ax is None
    ax, _ = style.panel(ax, dataset, f"{load.rate}_end" if load else "", "squama.twist or bend")
    _along(dataset, name)
    shown = _read(dataset, measured, hinge)
    _draw(ax, shown, name)
    ax.set_xlabel(style.label(shown.kind.rate))
    handles = _keys(shown, [name])
    if shown.others or own:
        style.legend_under(ax, handles)
    elif handles:
        ax.legend(handles=handles)
    return ax


def line(
    dataset: xr.Dataset,
    name: str,
    ax: Axes | None = None,
    *,
    x: str | None = None,
    unit: str | None = None,
    x_unit: str | None = None,
    **look: Any,
) -> Axes:
    """Draw a variable of a curve, one line for each coefficient of friction or scale, and return the axes.

    Parameters
    ----------
    dataset
        Result of :func:`squama.twist`, ``bend``, ``bend_twist``, ``cycle``, ``row`` or ``vibrate``.
    name, x
        Variables along ``point`` for the vertical and horizontal axis (default: time, or the rate of the load).
    ax
        Axes to draw into; default: a new figure. Existing labels are kept.
    unit, x_unit
        Units other than SI, such as "N mm", "deg".
    look
        Keywords of ``Axes.plot``.

    Raises
    ------
    InputError
        The variable is not along ``point``, or the unit has another dimension.

    Examples
    --------
    >>> import squama
    >>> r = squama.twist(squama.Beam.from_ratios(), mu=[0.2, 0.5], joint="hinge", points=50)
    >>> ax = squama.plot.line(r, "T", unit="kN m")
    >>> ax.get_ylabel(), len(ax.lines)
    ('Torque $T$ (kN m)', 2)
    """
    there = _along(dataset, name)
    load = LOADS.get(dataset.attrs.get("load", ""))
    # default horizontal axis: the first of these variables that the result has
    first = ("t", load.rate) if load else ("t",)
    over = x or next((key for key in (*first, "Phi", "kappa", "phi", "psi") if key in there), "")
    _along(dataset, over, "x")
    ax, _ = style.panel(ax, dataset, name, "")
    factor, y_words = _unit(dataset, name, unit)
    x_factor, x_words = _unit(dataset, over, x_unit)
    drawn, across = (v.transpose(..., "point") for v in xr.broadcast(dataset[name], dataset[over]))
    for index in np.ndindex(drawn.shape[:-1]):
        one = dict(zip(drawn.dims[:-1], index, strict=True))
        words = ", ".join(f"{dim} = {dataset[dim].values[i]:g}" for dim, i in one.items())
        ax.plot(x_factor * across.isel(one), factor * drawn.isel(one), **{"label": words or None, **look})
    ax.set_ylabel(ax.get_ylabel() or y_words)
    ax.set_xlabel(ax.get_xlabel() or x_words)
    return ax


def _along(dataset: xr.Dataset, name: str, where: str = "name") -> list[str]:
    """Return the names of numbers along the points of a result; another name is refused."""
    arguments.result(dataset)
    there = [str(key) for key, v in {**dataset.coords, **dataset}.items() if "point" in v.dims and v.dtype.kind in "fi"]
    if name not in there:
        refuse(where, shown(name), "is no number along the points of this result", f"allowed: {', '.join(there)}")
    return there


def _unit(dataset: xr.Dataset, name: str, unit: str | None) -> tuple[float, str]:
    """Return the factor to a unit, and the axis label."""
    attrs, factor = dataset[name].attrs, 1.0
    own = attrs.get("units", "1")
    if unit is not None:
        there, wanted = look_up(own), look_up(unit)
        if there is None or wanted is None or there[0] is not wanted[0]:
            refuse("unit", shown(unit), f"is no unit of {name}, which is in {own}", "leave it out")
        factor = wanted[2] / wanted[1]
    if name in SYMBOLS:
        return factor, style.label(name, unit)
    words = str(attrs.get("long_name", name))
    return factor, f"{words[0].upper()}{words[1:]}" + ("" if own == "1" else f" ({unit or own})")


def _read(dataset: xr.Dataset, measured: Measured | None, hinge: xr.Dataset | None) -> _Shown:
    """Return the contents of the figure; the friction force on hinges is scaled by the response's joint stiffness."""
    kind, beam = LOADS[dataset.attrs["load"]], Beam.from_toml_text(dataset.attrs["beam"])
    curves, others = _curves(dataset, kind), []
    if hinge is not None:
        own = beam.joint_stiffness
        others = _curves(hinge.assign(f0=hinge["f0"] * (own / dataset.attrs.get("K_theta", own))), kind)
    if measured is not None:
        # the axis ends beyond the measured points and the first engagement
        engaged = min((c.rate_e for c in curves if c.engages), default=0.0)
        right = BEYOND * max(style.finite_max(np.asarray(measured.rate, float), 0.0), engaged) or 1.0
    else:
        # the axis ends beyond every end, as far as the curves go
        far = [style.finite_max(c.rate) for c in curves]
        ends = [min(c.rate_end, 1.05 * v) if np.isfinite(c.rate_end) else v for c, v in zip(curves, far, strict=True)]
        right = 1.08 * max(*ends, 0.0) or 1.0
    rigidity = float(dataset.attrs.get("rigidity", kind.rigidity(beam)))
    return _Shown(kind, beam, rigidity, curves, others, measured, right)


def _curves(dataset: xr.Dataset, names: Load) -> list[_Curve]:
    """Return the curves of a response, one for each coefficient of friction, with points sorted by the rate."""
    mus = np.atleast_1d(dataset["mu"].values)
    colours = style.shades(mus.size) if mus.size > 1 else [INK]
    out = []
    for i, (mu, colour) in enumerate(zip(mus, colours, strict=True)):
        data = (dataset.isel(mu=i) if "mu" in dataset.dims else dataset).sortby(names.rate)
        rate = np.asarray(data[names.rate].values, float)
        each = data[[str(v) for v in data.data_vars if "scale" in data[v].dims]]
        data = data.assign({v: (x.mean("scale") if v in MEAN else x.max("scale")) for v, x in each.items()})
        e, last = float(data[f"{names.rate}_e"]), float(data[f"{names.rate}_end"])
        out.append(_Curve(data, each, float(mu), colour, rate, e, last, str(data["end"].values)))
    return out


def _limit(curves: list[_Curve], name: str, right: float) -> float:
    """Return the largest value to be visible: of a bounded curve its largest, of curves that lock the readable part."""
    bounded, locking = [0.0], [0.0]
    for c in curves:
        v = np.where(c.rate <= right, c.values(name), np.nan)
        steep = c.end == "other contact" and len(curves) > 1
        if (c.end in LOCKS or steep) and c.rate_end > c.rate_e:
            locking.append(style.finite_max(v[c.rate <= c.rate_e + READABLE * (c.rate_end - c.rate_e)], 0.0))
        else:
            bounded.append(style.finite_max(v, 0.0))
    seen = [v for v in locking if v > 0]
    return max(*bounded, float(np.median(seen)) if seen else 0.0)


def _draw(ax: Axes, shown: _Shown, name: str, letter: str = "") -> None:
    """Draw a variable with its marks, then hinges within the same axes; without a name, why the panel is empty."""
    ax.set_xlim(0, shown.right)
    if name:
        factor = _variable(ax, shown, name)
    else:
        static = any(c.end == "static lock" for c in shown.curves)
        words = "locked as soon as the scales touch:\nno sliding, no friction work" if static else "no sliding contact"
        ax.text(0.5, 0.5, words, transform=ax.transAxes, ha="center", va="center", color=GREY)
        ax.set(ylabel=style.label("f"), yticks=[])
    if letter:
        # curves are kept off the letter
        low, high = ax.get_ylim()
        drawn = np.concatenate([np.asarray(line.get_xydata(), float) for line in ax.lines] or [np.empty((0, 2))])
        top = style.finite_max(drawn[drawn[:, 0] < 0.14 * shown.right, 1], low)
        if top > low + 0.84 * (high - low):
            ax.set_ylim(low, low + (top - low) / 0.8)
        ax.text(0.03, 0.97, letter, transform=ax.transAxes, fontweight="bold", va="top")
    others = shown.others if name else []
    with style.within(ax):
        for c in others:
            ax.plot(c.rate, factor * c.values(name), color=c.colour, **BESIDE)
            if name == shown.kind.torque and c.engages:
                bare = shown.kind.rigidity(shown.beam) * c.rate_e
                ax.plot(c.rate_e, factor * bare, "s", color=c.colour, **SQUARE)
    for c in (*shown.curves, *others):
        if c.end in LOCKS and c.rate_end <= shown.right:
            ax.axvline(c.rate_end, color=c.colour, zorder=0, **LOCK)


def _variable(ax: Axes, shown: _Shown, name: str) -> float:
    """Draw a variable and set the height of its axes; return the factor to its unit."""
    curves, right = shown.curves, shown.right
    factor, text, most = 1.0, style.label(name), _limit(curves, name, right)
    if name == shown.kind.torque:
        bare = shown.rigidity * right
        most = max(1.08 * most, 1.25 * bare)
        if shown.measured is not None:
            highest = style.finite_max(np.asarray(shown.measured.load, float), 0.0)
            most = max(min(most, BEYOND * highest), 1.08 * highest, 1.08 * bare)
        # the unit is that of the curves: the axis goes on beyond them
        factor, text = style.prefixed(name, min(most, max(style.finite_max(np.abs(c.values(name))) for c in curves)))
        ax.plot([0, right], [0, factor * bare], **style.BARE)
    elif name == "theta":
        factor, text = 180 / np.pi, style.label(name, "deg")
    elif SYMBOLS[name].unit not in ("1", "rad"):
        factor, text = style.prefixed(name, most or max(style.finite_max(np.abs(c.values(name))) for c in curves))
    for c in curves:
        v = factor * c.values(name)
        if name in c.each:
            ax.plot(c.rate, factor * c.each[name].values, color=c.colour, **EACH)
        ax.plot(c.rate, v, color=c.colour)
        if f"{name}_periodic" in c.data:
            ax.plot(c.rate, factor * c.values(f"{name}_periodic"), color=c.colour, **WITHOUT_ENDS)
        good = np.flatnonzero(np.isfinite(v))
        if good.size and c.stops and c.rate[good[-1]] <= right:
            # a mark on the axis is not clipped
            ax.plot(c.rate[good[-1]], v[good[-1]], "x", color=c.colour, zorder=4, clip_on=bool(v[good[-1]]))
    ax.set_ylabel(text)
    if name == shown.kind.torque:
        for rate in [c.rate_e for c in curves if c.engages]:
            ax.plot(rate, factor * shown.rigidity * rate, color=INK, zorder=4, **style.ENGAGED)
        if (points := shown.measured) is not None:
            ax.plot(points.rate, factor * np.asarray(points.load, float), ".", color=ACCENT, markersize=4, zorder=3)
        ax.set_ylim(0, factor * most)
    elif name == "RED":
        ax.set_ylim(0, max(0.05, 1.05 * _span(ax)[1]))
    elif name == "theta":
        low, high = _span(ax)
        low, high = (low, high) if high - low > 2 else (low - 5, low + 5)
        ax.set_ylim(max(0.0, low), high)
    elif name in RISING:
        ax.set_ylim(0, 1.08 * factor * most or 1.0)
    return factor


def _span(ax: Axes) -> tuple[float, float]:
    """Return the lowest and the highest value of the curves within the axes, with a margin."""
    every = np.concatenate([np.asarray(line.get_xydata(), float) for line in ax.lines])
    seen = every[(every[:, 0] <= ax.get_xlim()[1]) & np.isfinite(every[:, 1]), 1]
    low, high = (float(seen.min()), float(seen.max())) if seen.size else (0.0, 0.0)
    room = 0.05 * (high - low)
    return low - room, high + room


def _keys(shown: _Shown, names: list[str]) -> list[Line2D]:
    """Return the legend's handles of variables ``names``; torque and moment have marks of their own."""
    curves, others, handles = shown.curves, shown.others, []
    load = shown.kind.torque in names
    if others:
        attrs = (c.data.attrs for c in (curves[0], others[0]))
        whose = [f"{about['scales']} on {HELD[about['joint']]}" for about in attrs]
        handles += [style.key(whose[0]), style.key(whose[1], **BESIDE)]
    if len(curves) > 1:
        handles += [style.key(rf"$\mu$ = {c.mu:g}", color=c.colour) for c in curves]
    if any(name in curves[0].each for name in names):
        handles.append(style.key("each scale", color=INK, **EACH))
    if any(f"{name}_periodic" in curves[0].data for name in names):
        handles.append(style.key("endless beam", **WITHOUT_ENDS))
    if load:
        handles.append(style.key("no contact", **style.BARE))
    if load and any(c.engages for c in curves):
        handles.append(style.key("engagement", **style.ENGAGED))
    if load and any(c.engages for c in others):
        handles.append(style.key("engagement on hinges", linestyle="", marker="s", **SQUARE))
    if any(c.end in LOCKS and c.rate_end <= shown.right for c in (*curves, *others)):
        handles.append(style.key("lock on hinges" if others else "lock", **LOCK))
    if any(c.stops and min(c.rate_end, style.finite_max(c.rate)) <= shown.right for c in curves):
        words = "end" if any(End(c.end).locks for c in curves) else "end, no lock"
        handles.append(style.key(words, linestyle="", marker="x"))
    if load and shown.measured is not None:
        handles.append(style.key("measured", color=ACCENT, linestyle="", marker="."))
    return handles


def _title(dataset: xr.Dataset, beam: Beam, curves: list[_Curve]) -> str:
    what = f"{dataset.sizes['scale']} scales {ending(dataset.attrs['ends'])}: " if "ends" in dataset.attrs else ""
    kind = f"{dataset.attrs['load'].capitalize()} of {what}{model(dataset.attrs)}"
    sense = ", sense -" if dataset.attrs.get("sense") == "-" else ""
    if len(curves) > 1:
        return f"{kind}{sense}"
    c = curves[0]
    text = f"{kind}{sense}, $\\mu$ = {c.mu:g}"
    if c.end == End.RANGE:
        return text
    if c.end == End.NONE and (touching := str(c.data["other_contact"].values)):
        where = f" at {np.degrees(float(c.data['phi_touch'])) * beam.pitches:.3g} deg" if "phi_touch" in c.data else ""
        return f"{text}: {c.end}; {touching} touches{where}"
    at = f" at {np.degrees(c.rate_end * beam.length):.3g} deg" if np.isfinite(c.rate_end) else ""
    # on hinges the other contact ends the curve
    other = str(c.data["other_contact"].values) if dataset.attrs["joint"] == "hinge" else ""
    return f"{text}: {c.end}{at}{f' ({other})' if other else ''}"
