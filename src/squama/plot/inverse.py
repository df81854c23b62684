"""What was asked and the curves of the designs; what the tolerances of the best one do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama import response
from squama.plot.style import ACCENT, GREY, INK, PAGE, key, letter, new_figure, shades, styled

if TYPE_CHECKING:
    from squama.inverse.results import InverseDesign
    from squama.inverse.target import Target

BARS = 8
"""Dimensions whose tolerances are drawn."""
CURVES = 8


@styled
def inverse_figure(found: InverseDesign, target: Target) -> Figure:
    """Draw an inverse design.

    Parameters
    ----------
    found : InverseDesign
        From :func:`squama.inverse_design`.
    target : Target
        What was asked, from :func:`squama.inverse.target.read_target`.

    Returns
    -------
    matplotlib.figure.Figure
        Left: torque (moment) against the twist over the whole beam, a curve for each design, with what was asked.
        Right: by how much the tolerance of each dimension changes what the first design reaches.
    """
    figure = new_figure(PAGE, 3.2)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    _curves(left, found, target)
    _bars(right, found)
    for ax, name in ((left, "(a)"), (right, "(b)")):
        letter(ax, name)
    return figure


def _curves(ax: Axes, found: InverseDesign, target: Target) -> None:
    twisting = target.space.load == "twisting"
    options, scales = target.options, target.space.beam.scales
    degrees = 180 / np.pi * scales
    lines, handles = [], []
    for i, (d, colour) in enumerate(zip(found.designs[:CURVES], shades(min(len(found), CURVES)), strict=False)):
        if twisting:
            curve = response.twisted(d.beam, law=options.law, sense=options.sense, margin=options.margin)
        else:
            curve = response.bent(d.beam, margin=options.margin)
        x, y = curve["phi" if twisting else "psi"] * degrees, curve["T" if twisting else "M"]
        lines.append((x, y, d, colour))
        handles.append(key(f"design {i + 1}: {d.end}", color=colour))
    asked = [goal for goal in target.goals if goal.want.figure == "torque"]
    pitch = found[0].beam.pitch
    points = np.array([[g.want.at.per_pitch(pitch) * degrees, g.asked] for g in asked if g.want.at]).reshape(-1, 2)
    # curves climb without bound towards a lock: show the part in which the target lies
    least = max((float(np.interp(0.9 * x[-1], x, y)) for x, y, _, _ in lines), default=1.0)
    top = 1.6 * float(points[:, 1].max()) if points.size else least
    factor, unit = (1e3, "N mm") if top < 1 else (1.0, "N m")
    for x, y, d, colour in lines:
        ax.plot(x, factor * y, color=colour)
        if d.end.endswith("lock"):
            ax.axvline(d.rate_end * d.beam.pitch * degrees, color=colour, linewidth=0.7, linestyle=(0, (1, 1.5)))
    if points.size:
        ax.plot(points[:, 0], factor * points[:, 1], linestyle="", marker="o", color=ACCENT, markersize=4, zorder=5)
        handles.append(key("asked", linestyle="", marker="o", color=ACCENT, markersize=4))
    for goal in target.goals:
        if goal.twist is not None:
            at = float(goal.twist.per_pitch(pitch)) * degrees
            ax.axvline(at, color=ACCENT, linewidth=1.0, linestyle=(0, (4, 2)), zorder=0)
            sense = {"=": "", ">=": " at least", "<=": " at most"}[goal.sense]
            handles.append(key(f"asked: {goal.name}{sense}", color=ACCENT, linewidth=1.0, linestyle=(0, (4, 2))))
    ax.set_ylim(0, factor * top)
    ax.set_xlim(0, None)
    ax.set_xlabel(f"{'Twist' if twisting else 'Bend'} of {scales} scales (deg)")
    ax.set_ylabel(f"{'Torque' if twisting else 'Moment'} ({unit})")
    ax.legend(handles=handles, loc="upper left", fontsize=6)


def _bars(ax: Axes, found: InverseDesign) -> None:
    goal = found[0].goals[0]
    rows = sorted(goal.effects.items(), key=lambda item: -abs(item[1]))[:BARS]
    rows = [row for row in rows if row[1]][::-1]
    colours = [GREY if value < 0 else INK for _, value in rows]
    ax.barh(range(len(rows)), [abs(value) for _, value in rows], color=colours, height=0.6)
    ax.set_yticks(range(len(rows)), [f"{name}\n{_size(found, name)}" for name, _ in rows], fontsize=6)
    unit = f" ({goal.unit})" if goal.unit else ""
    ax.set_xlabel(f"Change of {goal.name}{unit}, design 1")
    words: list[Any] = [key("grows with it", color=INK, linewidth=4), key("falls with it", color=GREY, linewidth=4)]
    ax.legend(handles=words, loc="lower right")


def _size(found: InverseDesign, name: str) -> str:
    value = found.tolerance[name]
    from squama.inverse.space import Variable
    from squama.study.parameters import PARAMETERS

    kind = str(PARAMETERS[Variable(name, 0, 1).key].dimension)
    factor, unit = {"length": (1e3, " mm"), "angle": (180 / np.pi, " deg"), "pressure": (1e-6, " MPa")}.get(
        kind, (1, "")
    )
    return f"\N{PLUS-MINUS SIGN}{factor * value:.3g}{unit}"
