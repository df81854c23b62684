"""Draw the dimensions of a beam with their symbols, docs/images/anatomy.png: python docs/images/anatomy.py."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon, Rectangle
from matplotlib.transforms import Affine2D

from squama.plot import style
from squama.plot.palette import GREY, INK

ETA, BETA, LAM, ZETA, T_S = 2.1, 0.6, 0.32, 0.42, 0.07
"""Exposed length, half width, half thickness of the bar, embedded length, thickness of a scale, in pitches."""
WIDTH, ALPHA, THETA0, TWIST = 1.5, np.radians(40), np.radians(24), np.radians(16)
BLUE, PALE, BAR = "#1f5fa8", "#9bb7d4", "#f1efe8"


def measure(
    ax: Axes, a: np.ndarray, b: np.ndarray, text: str, off: tuple[float, float], colour: str = INK, turn: int = 0
) -> None:
    """Draw a dimension from a to b, its text beside the middle and turned (deg)."""
    look = {"arrowstyle": "<|-|>,head_width=.12,head_length=.3", "color": colour, "lw": 0.7, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", b, a, arrowprops=look, zorder=6)
    ax.text(*((a + b) / 2 + off), text, ha="center", va="center", color=colour, rotation=turn, zorder=7)


def helper(ax: Axes, a: np.ndarray, b: np.ndarray) -> None:
    """Draw a thin line that leads to a dimension."""
    ax.plot(*zip(a, b, strict=True), color=GREY, lw=0.5)


def from_the_side(ax: Axes) -> None:
    """Draw bar and scales cut along the beam, edges across the beam."""
    ax.add_patch(Rectangle((-0.9, -2 * LAM), 5.0, 2 * LAM, fc=BAR, ec=GREY, lw=0.7))
    ax.plot([-1.0, 4.2], [-LAM, -LAM], color=GREY, lw=0.7, ls="-.")
    along = np.array([np.cos(THETA0), np.sin(THETA0)])
    across = np.array([-along[1], along[0]])
    for k in (0, 1, 2):
        base = np.array([k, 0.0])
        ends = (base - ZETA * along, base, base + ETA * along)
        for a, b, look in ((*ends[:2], {"alpha": 0.55}), (*ends[1:], {})):
            corners = [a - T_S / 2 * across, b - T_S / 2 * across, b + T_S / 2 * across, a + T_S / 2 * across]
            ax.add_patch(Polygon(corners, fc=BLUE if k == 0 else PALE, ec="none", **look))
        ax.plot(*base, "o", ms=2.5, color=INK, zorder=5)
    tip, root = ETA * along, -ZETA * along
    for at in (np.zeros(2), tip, root):
        helper(ax, at, at + 0.42 * across)
    measure(ax, 0.36 * across, tip + 0.36 * across, "$l$", tuple(0.13 * across), BLUE)
    measure(ax, root + 0.36 * across, 0.36 * across, "$L$", tuple(0.13 * across), BLUE)
    at = np.array([2.0, 0.0]) + (ETA - 0.25) * along
    arrow = {"arrowstyle": "-|>,head_width=.12,head_length=.3", "color": INK, "lw": 0.7, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", at + T_S / 2 * across, at + 0.26 * across, arrowprops=arrow)
    ax.annotate("", at - T_S / 2 * across, at - 0.26 * across, arrowprops=arrow)
    ax.text(*(at - 0.38 * across), "$t_s$", ha="center", va="center")
    for k in (1, 2):
        helper(ax, np.array([k, 0.0]), np.array([k, -2 * LAM - 0.25]))
    measure(ax, np.array([1, -2 * LAM - 0.2]), np.array([2, -2 * LAM - 0.2]), "$d$", (0, -0.13))
    measure(ax, np.array([3.6, -2 * LAM]), np.array([3.6, 0.0]), "$2t$", (0.2, -0.16))
    ax.plot([2, 3.0], [0, 0], color=INK, lw=0.6)
    ax.add_patch(Arc((2, 0), 1.5, 1.5, theta1=0, theta2=np.degrees(THETA0), lw=0.8))
    ax.text(2.95, 0.17, r"$\theta$", ha="center", va="center")
    ax.text(4.25, -LAM, "$z$", va="center", color=GREY)
    ax.set_xlim(-1.05, 4.45)
    ax.set_ylim(-1.5, 1.5)
    ax.set_title(r"(a)  from the side, drawn for $\alpha = 0$; $\theta = \theta_0$ at rest")


def from_above(ax: Axes) -> None:
    """Draw the scaled face."""
    ax.add_patch(Rectangle((-0.9, -WIDTH / 2), 5.0, WIDTH, fc=BAR, ec=GREY, lw=0.7))
    ax.plot([-1.0, 4.2], [0, 0], color=GREY, lw=0.7, ls="-.")
    width = np.array([np.sin(ALPHA), np.cos(ALPHA)])
    along = np.cos(THETA0) * np.array([np.cos(ALPHA), -np.sin(ALPHA)])
    for k in (0, 1, 2):
        base = np.array([k, 0.0])
        d, a = base - BETA * width, base + BETA * width
        colour = BLUE if k == 0 else PALE
        ax.add_patch(Polygon([d, a, a + ETA * along, d + ETA * along], fc=colour, ec=colour, lw=1.2, alpha=0.35))
        ax.plot(*zip(d, a, strict=True), color=colour, lw=2.0, solid_capstyle="butt")
        ax.plot(*base, "o", ms=2.5, color=INK, zorder=5)
    off = -0.16 * along
    measure(ax, -BETA * width + off, BETA * width + off, "$2b$", (-0.24, 0.08), BLUE)
    ax.plot([2, 2], [0, 0.95], color=INK, lw=0.6)
    ax.add_patch(Arc((2, 0), 1.5, 1.5, theta1=90 - np.degrees(ALPHA), theta2=90, lw=0.8))
    ax.plot([2, 2 + 0.95 * width[0]], [0, 0.95 * width[1]], color=INK, lw=0.6)
    ax.text(2.29, 0.84, r"$\alpha$", ha="center", va="center")
    measure(ax, np.array([3.7, -WIDTH / 2]), np.array([3.7, WIDTH / 2]), "width", (-0.14, 0.36), turn=90)
    ax.text(4.25, 0, "$z$", va="center", color=GREY)
    ax.set_xlim(-1.05, 4.45)
    ax.set_ylim(-1.8, 1.2)
    ax.set_title("(b)  from above")


def loads(left: Axes, right: Axes) -> None:
    """Draw two sections of the twisted bar, and a piece of the bent one."""
    box = {"ec": GREY, "lw": 0.9}
    for angle, look in ((0.0, {"fc": BAR, "ls": "-"}), (TWIST, {"fc": "none", "ls": (0, (4, 2))})):
        turn = Affine2D().rotate(angle) + left.transData
        left.add_patch(Rectangle((-WIDTH / 2, -LAM), WIDTH, 2 * LAM, transform=turn, **box, **look))
    for angle in (0.0, TWIST):
        left.plot([0, 1.05 * np.cos(angle)], [0, 1.05 * np.sin(angle)], color=INK, lw=0.6)
    left.add_patch(Arc((0, 0), 1.9, 1.9, theta1=0, theta2=np.degrees(TWIST), lw=0.8))
    left.text(1.12, 0.16, r"$\varphi = \Phi d$", va="center")
    left.plot(0, 0, "o", ms=2.5, color=INK)
    left.set_xlim(-1.1, 2.3)
    left.set_ylim(-0.95, 0.85)
    left.set_title(r"(c)  twist: two sections one pitch apart, seen along $z$")
    psi, radius = np.radians(38), 1 / np.radians(38)
    around = np.linspace(-psi / 2, psi / 2, 60)
    inner, outer = (
        np.column_stack([r * np.sin(around), radius - r * np.cos(around)]) for r in (radius - LAM, radius + LAM)
    )
    right.add_patch(Polygon(np.vstack([inner, outer[::-1]]), fc=BAR, ec=GREY, lw=0.9))
    for side in (-1, 1):
        right.plot(
            [0, side * (radius + LAM) * np.sin(psi / 2)],
            [radius, radius - (radius + LAM) * np.cos(psi / 2)],
            color=INK,
            lw=0.6,
        )
    middle = np.column_stack([radius * np.sin(around), radius - radius * np.cos(around)])
    right.plot(*middle.T, color=GREY, lw=0.7, ls="-.")
    right.add_patch(
        Arc((0, radius), 0.9, 0.9, theta1=270 - np.degrees(psi / 2), theta2=270 + np.degrees(psi / 2), lw=0.8)
    )
    right.text(0.3, radius - 0.42, r"$\psi = \kappa d$", va="center")
    right.text(0, 0.1, "$d$", ha="center", va="center")
    right.set_xlim(-1.5, 2.2)
    right.set_ylim(-0.4, 1.6)
    right.set_title("(d)  bend: one pitch, the scaled face above")


@style.styled
def picture() -> Figure:
    """Return the figure."""
    figure = style.new_figure(style.PAGE, 4.3)
    axes = figure.subplots(2, 2, height_ratios=(1.25, 1))
    from_the_side(axes[0, 0])
    from_above(axes[0, 1])
    loads(axes[1, 0], axes[1, 1])
    for ax in axes.flat:
        ax.set_aspect("equal")
        ax.set_anchor("NW")
        ax.axis("off")
    ratios = r"ratios:   $\eta = l/d$    $\beta = b/d$    $\lambda = t/d$    $\zeta = L/d$    slenderness $L/t_s$"
    figure.supxlabel(ratios, fontsize=8)
    return figure


if __name__ == "__main__":
    style.save_figure(picture(), Path(__file__).with_name("anatomy.png"))
