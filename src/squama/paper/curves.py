"""Figs. 4 and 6: friction force and torque over twist rate, for both force laws."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from squama.beam.design import Beam
from squama.curves import doors
from squama.loads import LawName
from squama.model.outcome import End
from squama.paper.elements import FePoints
from squama.plot import style
from squama.plot.palette import GREY, INK
from squama.types import Array

POINTS = 300
NEAR = 1e-3
"""Margin before a lock at which curves end."""
ABOVE = 2.0
MARKERS = "osD^v<>p"
COMPLIANT: style.Dash = (0, (5, 1.5, 1, 1.5))
"""Line style of the compliant joint."""
BARE: style.Look = {"color": GREY, "linewidth": 1, "linestyle": (0, (1, 1.2))}
"""Style of the beam without contact."""


def both_laws(beam: Beam, mus: Sequence[float], laws: Sequence[LawName]) -> xr.Dataset:
    """Return the twisting of a beam for each friction and each force law (dimensions ``law``, ``mu``, ``point``)."""
    runs = [doors.twist(beam, mu=mus, law=law, margin=NEAR, points=POINTS, joint="hinge", ideal=True) for law in laws]
    data = xr.concat(runs, dim=xr.Variable("law", list(laws)), combine_attrs="drop_conflicts")
    return data.assign(
        ratio=data["phi"] / data["phi_e"],
        T_K=data["T_scales"] / beam.joint_stiffness,
        K_K=(data["K_t"] - beam.torsional_rigidity) / (beam.joint_stiffness * beam.pitch),
        T_GI=data["T"] / (beam.G_B * beam.I),
    )


def _lines(ax: Axes, data: xr.Dataset, x: str, y: str, *, asymptotes: bool = False) -> None:
    colours = style.shades(data.sizes["mu"])
    for law in data["law"].values:
        for i, colour in enumerate(colours):
            line = data.sel(law=law).isel(mu=i)
            # where the laws coincide the curve below is broad and pale, so that the dashes above it are visible
            values = data[y].isel(mu=i).values
            same = len(values) > 1 and bool(np.allclose(values[0], values[1], rtol=1e-9, equal_nan=True))
            below: style.Look = {"linewidth": 3.2, "alpha": 0.35} if same and law == "plate" else {}
            ax.plot(line[x].values, line[y].values, color=colour, linestyle=style.DASHES[str(law)], **below)
            if asymptotes and law == "plate" and line["end"] == "frictional lock":
                ax.axvline(float(line["phi_end"] / line["phi_e"]), color=colour, linewidth=0.8, linestyle=":", zorder=0)


def _keys(data: xr.Dataset) -> list[Line2D]:
    mus = [float(mu) for mu in data["mu"].values]
    handles = [style.key(rf"$\mu$ = {mu:g}", color=c) for mu, c in zip(mus, style.shades(len(mus)), strict=True)]
    return handles + style.law_keys([str(law) for law in data["law"].values])


@style.styled
def fig4(data: xr.Dataset) -> Figure:
    """Draw the friction force over the twist rate, relative to that at engagement."""
    figure = style.new_figure(1.45 * style.COLUMN, 3.1)
    ax = figure.subplots()
    _lines(ax, data, "ratio", "f0", asymptotes=True)
    ax.set(xlim=(1, 1.04 * float((data["phi_end"] / data["phi_e"]).max())), ylim=(0, 12))
    ax.set_xlabel(r"Twist rate over that at engagement $\Phi/\Phi_e$ (1)")
    ax.set_ylabel(r"Friction force $\bar{f}_0 = f\,l/K_\theta$ (1)")
    handles = [*_keys(data), style.key("lock, plate law", linestyle=":", linewidth=0.8)]
    figure.legend(handles=handles, loc="outside right center")
    return figure


@style.styled
def fig6a(data: xr.Dataset) -> Figure:
    """Draw the scales' part of the torque and of the stiffness, over K_theta."""
    figure = style.new_figure(style.PAGE, 3.0)
    axes = figure.subplots(1, 2)
    for ax, name, top in zip(axes, ("T_K", "K_K"), (30, 600), strict=True):
        _lines(ax, data.where(data["ratio"] >= 1), "ratio", name)
        ax.set(xlim=(1, 1.04 * float((data["phi_end"] / data["phi_e"]).max())), ylim=(0, top))
        ax.set_xlabel(r"Twist rate over that at engagement $\Phi/\Phi_e$ (1)")
    axes[0].set_ylabel(r"Torque of the scales $T_s/K_\theta$ (1)")
    axes[1].set_ylabel(r"Stiffness of the scales $\mathrm{d}T_s/\mathrm{d}\varphi\,/K_\theta$ (1)")
    style.letters(axes)
    figure.legend(handles=_keys(data), loc="outside lower center", ncols=8)
    return figure


@style.styled
def fig6b(parts: dict[float, xr.Dataset], points: FePoints, own: dict[float, xr.Dataset]) -> Figure:
    """Draw torque over G_B I against twist rate for each overlap ratio, with finite element points.

    ``own``: curves of the edge law with K_theta and C_f of the elements; drawn in a second row of panels, with the
    compliant joint if the points include it.
    """
    n, rows = len(parts), 2 if own else 1
    figure = style.new_figure(style.PAGE if n > 1 else 0.6 * style.PAGE, 3.4 if rows == 1 else 5.8)
    axes = figure.subplots(rows, n, sharey="row", sharex="col", squeeze=False)
    top = 0.0
    for column, (eta, data) in enumerate(parts.items()):
        drawn = [(data, ", scaling laws of the paper" if own else "")]
        drawn += [(own[eta], ", stiffness from the elements")] if own else []
        for row, (ax, (curves, words)) in enumerate(zip(axes[:, column], drawn, strict=True)):
            _lines(ax, curves, "Phi", "T_GI")
            for i, colour in enumerate(style.shades(curves.sizes["mu"])):
                last = curves.isel(law=-1, mu=i)
                if not End(last["end"].item()).locks:
                    ax.plot(float(last["Phi"][-1]), float(last["T_GI"][-1]), "x", color=colour)
            style.letter(ax, rf"({'abcd'[row * n + column]}) $\eta$ = {eta:g}{words}")
        # the axis ends at twice the torque of the curve with the least friction, or at the largest torque
        torque = data["T_GI"].values
        top = max(top, min(ABOVE * style.finite_max(torque[:, 0]), style.finite_max(torque)))
        top = max(top, _draw_points(axes[:, column], data, points, eta))
        for ax in axes[:, column]:
            rate = np.array([0.0, style.finite_max(data["Phi"].values)])
            bare = float(data["T_GI"].values.flat[1] / data["Phi"].values.flat[1])
            ax.plot(rate, bare * rate, **BARE)
            ax.set_xlim(0, None)
        axes[-1, column].set_xlabel(r"Twist rate $\Phi$ (rad/m)")
    axes[0, 0].set_ylim(0, 1.05 * top)
    if own:
        axes[1, 0].set_ylim(0, 1.4 * style.finite_max(points.load))
    for ax in axes[:, 0]:
        ax.set_ylabel(r"Torque $T/(G_B I)$, $I$ polar moment (rad/m)")
    handles = [
        *_keys(next(iter(parts.values()))),
        style.key("no contact", color=GREY, linewidth=1, linestyle=(0, (1, 1.2))),
    ]
    handles.append(style.key("off the tip edge (edge law)", linestyle="", marker="x"))
    mus = next(iter(parts.values()))["mu"].values
    for mu, colour, marker in zip(mus, style.shades(mus.size), MARKERS * mus.size, strict=False):
        look = {"linestyle": "", "marker": marker, "markerfacecolor": colour, "markersize": 3.5}
        handles.append(style.key(f"finite elements, $\\mu$ = {mu:g}", **look))
    if own and points.compliant is not None:
        handles.append(style.key("compliant joint", linewidth=0.9, linestyle=COMPLIANT))
    figure.legend(handles=handles, loc="outside lower center", ncols=4 if n > 1 else 3)
    return figure


def _draw_points(axes: Array, data: xr.Dataset, points: FePoints, eta: float) -> float:
    """Draw the points of one overlap ratio, and the compliant joint in the lower panel; return the largest load."""
    look: style.Look = {"linestyle": "", "markersize": 3.5, "markeredgecolor": INK, "markeredgewidth": 0.6, "zorder": 4}
    top = 0.0
    for i, (mu, colour) in enumerate(zip(data["mu"].values, style.shades(data.sizes["mu"]), strict=True)):
        mine = (points.eta == eta) & (points.mu == mu)
        for ax in axes:
            marker = MARKERS[i % len(MARKERS)]
            ax.plot(points.rate[mine], points.load[mine], marker=marker, markerfacecolor=colour, **look)
        if points.compliant is not None:
            for ax in axes[1:]:
                ax.plot(points.rate[mine], points.compliant[mine], color=colour, linewidth=0.9, linestyle=COMPLIANT)
        top = max(top, style.finite_max(points.load[mine], 0.0))
    return top
