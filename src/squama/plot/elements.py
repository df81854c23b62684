"""Finite elements: curves, comparison with the models, and the deformed pitch with its strain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from squama.fe.agreement import FINITE
from squama.fe.deformed import IMAGES, Deformed
from squama.fe.plate import Turn
from squama.people import per_pitch
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

LINES: tuple[style.Dash, ...] = ((0, (4, 1.6)), "-", (0, (1, 1.1)), (0, (5, 1.5, 1, 1.5)), (0, (7, 2)))
"""Line styles of the models, in their order."""
VARIANTS = ("plate", "own")
"""Variants of the hinge that differ from its edge law by less than a line's width."""
_FINITE: tuple[tuple[str, str, style.Dash], ...] = (("beam", GREY, "-"), ("row", GREY, (0, (3, 1.5))))
"""Names, colours and line styles of finite beams."""
MARKS: tuple[style.Dash, ...] = (":", (0, (5, 2)), (0, (4, 1.5, 1, 1.5)))
"""Styles of the vertical lines at changes of the contact."""
TWIST = "Twist (deg per pitch)"
SCALE = (0.62, 0.60, 0.56, 0.45)


@style.styled
def elements_figure(data: xr.Dataset) -> Figure:
    """Draw a run of finite elements of one pitch, from ``squama.fe.runs.cell``.

    Four panels over the twist rate: torque with the start's slope dashed; inclination; normal and friction force;
    energies per length. Ticks on the axis of the inclination: increments. Vertical lines: changes of the pair in
    contact.
    """
    figure = style.new_figure(style.PAGE, 5.2)
    axes = figure.subplots(2, 2, sharex=True)
    load, inclination, forces, energies = axes.flat
    rate = np.asarray(data["Phi"].values, float)
    right = 1.04 * style.finite_max(rate) or 1.0
    T, N, f, W, U_el, W_fr = (np.asarray(data[name].values, float) for name in ("T", "N", "f", "W", "U_el", "W_fr"))
    first, second, _ = style.shades(3)
    factor, text = style.prefixed("T", style.finite_max(np.abs(T)))
    for i in np.flatnonzero(rate > 0)[:1]:
        load.plot([0, right], [0, factor * T[i] / rate[i] * right], **style.BARE)
    load.plot(rate, factor * T, color=INK)
    load.set_ylabel(text)
    inclination.plot(rate, np.degrees(data["theta"].values), color=INK)
    inclination.set_ylabel(style.label("theta", "deg"))
    ticks: style.Look = {"color": GREY, "linestyle": "", "marker": "|", "markersize": 4}
    inclination.plot(rate, np.zeros_like(rate), transform=inclination.get_xaxis_transform(), **ticks)
    factor, text = style.prefixed("N", max(style.finite_max(N), style.finite_max(f)))
    for v, ink, words in ((N, INK, "normal $N$"), (f, ACCENT, "friction $f$")):
        forces.plot(rate, factor * v, color=ink, label=words)
    forces.set_ylabel(text.replace("Normal force $N$", "Force of a contact"))
    factor, text = style.prefixed("W", style.finite_max(W))
    works = (W, first, "torque's work $W$"), (U_el, second, r"elastic $U_\mathrm{el}$")
    for v, colour, words in (*works, (W_fr, ACCENT, r"frictional $W_\mathrm{fr}$")):
        energies.plot(rate, factor * v, color=colour, label=words)
    energies.plot(rate, factor * (U_el + W_fr), color=INK, linestyle=(0, (1, 1.5)), label="sum")
    energies.set_ylabel(text.replace("Work of the torque per length $W$", "Energy per length"))
    for ax in (forces, energies):
        ax.legend(loc="center left")
    contact = data["contact"].values
    starts = np.flatnonzero(contact != np.append("", contact[:-1]))
    changes = [(rate[i], contact[i], mark) for i, mark in zip(starts, MARKS * 8, strict=False)]
    for ax in axes.flat:
        ax.set_xlim(0, right)
        if ax is not inclination:
            ax.set_ylim(0, None)
        for at, _, mark in changes:
            ax.axvline(at, color=GREY, linewidth=0.8, linestyle=mark, zorder=0)
    pitch = float(data["phi"][-1] / data["Phi"][-1]) if data["Phi"][-1] else 1.0
    for ax, below in zip(axes[0], axes[1], strict=True):
        below.set_xlabel(style.label("Phi"))
        top = style.scaled_above(ax, np.degrees(pitch), TWIST)
        top.xaxis.label.set_fontsize(7)
        top.xaxis.set_major_locator(MaxNLocator(6))
    handles = [style.key("slope at the start", **style.BARE), style.key("increment", **ticks)]
    for at, words, mark in changes:
        text = f"from {per_pitch(pitch * at)}: {words or 'no contact'}"
        handles.append(style.key(text, color=GREY, linestyle=mark, linewidth=0.8))
    figure.legend(handles=handles, loc="outside lower center", ncols=2 if changes else 3)
    attrs = data.attrs
    blocked = ", roll and yaw blocked" if "blocked" in attrs["joint"] else ""
    stopped = "" if attrs["reached"] else f"\n{attrs['sentence']}"
    # the mesh stands in the summary
    about = f"One pitch by finite elements; scales {attrs['plates'].partition(':')[0]}{blocked}"
    title = f"{about}, sense {attrs['sense']}, $\\mu$ = {float(data['mu']):g}{stopped}"
    return style.headline(figure, title, axes.flat)


@style.styled
def compare_figure(table: xr.Dataset) -> Figure:
    """Draw models and finite elements together, from ``squama.fe.agreement.compare``.

    Torque, its difference from the elements with the band of agreement, inclination and its difference, all over the
    twist in degrees per pitch. Finite beams have no differences; ``VARIANTS`` of the hinge are in the table only.
    """
    figure = style.new_figure(style.PAGE, 5.4)
    axes = figure.subplots(2, 2, sharex=True)
    (torque, off), (theta, apart) = axes
    phi = np.degrees(np.asarray(table["phi"].values, float))
    highest = style.finite_max(table["T_elements"].values)
    factor, text = style.prefixed("T", highest)
    own: style.Look = {"color": INK, "marker": "o", "markersize": 2.6, "linewidth": 0.8}
    torque.plot(phi, factor * table["T_elements"].values, **own)
    theta.plot(phi, np.degrees(table["theta_elements"].values), **own)
    handles = [style.key(f"finite elements: {table.attrs['elements']}", **own)]
    names = [str(name) for name in table["model"].values if name not in VARIANTS]
    endless = [name for name in names if name not in FINITE]
    colours = [*style.shades(max(len(endless) - 1, 1)), ACCENT][-len(endless) :]
    looks = [*zip(endless, colours, LINES * len(names), strict=False), *_FINITE]
    for name, colour, dashes in (look for look in looks if look[0] in names):
        one, look = table.sel(model=name), {"color": colour, "linestyle": dashes}
        torque.plot(phi, factor * one["T"].values, **look)
        theta.plot(phi, np.degrees(one["theta"].values), **look)
        if name not in FINITE:
            off.plot(phi, 100 * one["dT"].values, **look)
            apart.plot(phi, np.degrees(one["dtheta"].values), **look)
        handles.append(style.key(str(one["words"].item()), **look))
    share = 100 * float(table.attrs["share"])
    handles.append(off.axhspan(-share, share, color=GREY, alpha=0.18, linewidth=0, label=f"within {share:g} %"))
    apart.axhline(0, color=GREY, linewidth=0.7)
    # the whole curve of the elements is shown; a model that diverges leaves the panel
    torque.set_ylim(0, min(1.6 * factor * highest, torque.get_ylim()[1]))
    percent = 100 * np.asarray(table["dT"].sel(model=endless).values, float)
    top, low = (min(40.0, 1.1 * style.finite_max(np.maximum(s * percent, 0), share)) for s in (1, -1))
    off.set_ylim(-max(low, 1.6 * share), max(top, 1.6 * share))
    torque.set_ylabel(text)
    off.set_ylabel("Difference of the torque (%)")
    theta.set(ylabel=style.label("theta", "deg"), xlabel=TWIST)
    apart.set(ylabel=r"Difference of $\theta$ (deg)", xlabel=TWIST)
    torque.set_xlim(0, 1.03 * style.finite_max(phi))
    for ax in (theta, apart):
        ax.ticklabel_format(useOffset=False, style="plain")
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return style.headline(figure, str(table.attrs["title"]).replace("mu =", r"$\mu$ ="), axes.flat)


@style.styled
def deformed_figure(state: Deformed) -> Figure:
    """Draw a deformed pitch (``last`` of a run) with its periodic images on both sides, and the scales.

    Colours: largest principal stretch less 1, in per cent, averaged at nodes.
    """
    figure = style.new_figure(0.78 * style.PAGE, 4.4)
    ax = figure.subplots()
    # rows: right, up, towards the eye; y is up, the eye 38 deg beside the x axis and 32 deg above the plane
    (ca, ce), (sa, se) = (f(np.radians([-38.0, 32.0])) for f in (np.cos, np.sin))
    eye, right = np.array([ce * ca, se, ce * sa]), np.array([sa, 0.0, -ca])
    view = np.array([right, np.cross(eye, right), eye])
    strain = 100 * (state.at_nodes(state.stretch) - 1)[state.surface[:, :3]].mean(axis=1)
    outer = ~state.walls
    a, b, c = (state.moved[state.surface[outer, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    # the strain at the scale's embedded edges is far above that of the rest of the surface
    norm = Normalize(0.0, max(float(np.percentile(strain[outer], 97.0, method="inverted_cdf", weights=areas)), 1e-6))
    colours = mpl.colormaps["viridis"](norm(strain))
    # the scale fills its slot
    colours[state.walls] = (*SCALE[:3], 1.0)
    polygons: list[Array] = []
    fills: list[Array] = []
    depths: list[Array] = []
    for k in IMAGES:
        moved = state.moved @ Turn.at(k * state.phi).Q.T + [0.0, 0.0, k * state.pitch]
        corners = moved[state.surface[:, :3]]
        seen = corners @ view.T
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        towards = normal @ view[2] > 0
        polygons += list(seen[towards, :, :2])
        depths.append(seen[towards, :, 2].mean(axis=1))
        fills.append(_lit(colours[towards], normal[towards], 1.0 if k == 0 else 0.45))
    order = np.argsort(np.concatenate(depths), kind="stable")
    faces = np.concatenate(fills)[order]
    behind = [polygons[i] for i in order]
    ax.add_collection(PolyCollection(behind, facecolors=faces, edgecolors=faces, linewidths=0.15))
    # seen from above, the exposed scales lie in front of the substrate
    plates, share = state.scales_moved.copy(), state.exposed / np.linalg.norm(state.scales[0, 1] - state.scales[0, 0])
    for i, j in ((0, 1), (3, 2)):
        plates[:, i] = plates[:, j] + share * (plates[:, i] - plates[:, j])
    for plate in sorted(plates @ view.T, key=lambda p: float(p[:, 2].mean())):
        x, y = plate[:, :2].T
        ax.fill(x, y, facecolor=SCALE, edgecolor=INK, linewidth=0.7)
        polygons.append(plate[:, :2])
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_axis_off()
    # the length of one pitch below the picture
    x, y = np.concatenate(polygons).min(axis=0) - [0, 0.12 * state.pitch]
    ax.plot([x, x + state.pitch], [y, y], color=INK, linewidth=1.2)
    ax.text(x, y - 0.06 * state.pitch, f"one pitch, {1e3 * state.pitch:.4g} mm", va="top", fontsize=7, color=GREY)
    bar = ScalarMappable(norm, mpl.colormaps["viridis"])
    figure.colorbar(bar, ax=ax, shrink=0.7, extend="max", label="Largest principal strain (%)")
    title = f"Deformed at {per_pitch(abs(state.phi))}: one pitch of elements, its neighbours pale"
    return style.headline(figure, title)


def _lit(colours: Array, normal: Array, strength: float) -> Array:
    """Shade colours (n, 4) by the angle of their faces (normals (n, 3)) to the light; pale for a strength below 1."""
    unit, light = normal / np.linalg.norm(normal, axis=1, keepdims=True), np.array([0.35, 0.85, 0.4])
    bright = 0.72 + 0.28 * np.abs(unit @ (light / np.linalg.norm(light)))
    out = colours.copy()
    out[:, :3] = 1 - strength * (1 - out[:, :3] * bright[:, None])
    return out
