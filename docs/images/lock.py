"""Draw why a beam on hinges locks, docs/images/lock.png: python docs/images/lock.py."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Wedge
from scipy.optimize import brentq

import squama
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK

ETA, MU, THETA0, EARLY = 1.9, 0.45, np.radians(15), np.radians(26)
BLUE, BAR, CONE = "#1f5fa8", "#f1efe8", "#e9d8a6"
THICK, FORCE = 0.42, 0.62
"""Thickness of the drawn bar and length of the drawn normal force, in pitches."""


def bend(theta: float) -> float:
    """Return the bend per pitch at which scales of an inclination touch, edges across the beam, about the face."""
    return float(brentq(lambda psi: ETA * psi * np.cos(psi / 2) - np.sin(theta + psi / 2), 1e-6, 1.5))


def locked() -> float:
    """Return the inclination at the lock of squama.bend; the drawn condition must hold there."""
    beam = squama.Beam.from_ratios(eta=ETA, alpha=0, theta0=THETA0)
    r = squama.bend(beam, mu=MU, neutral="face", joint="hinge")
    theta, psi = float(r.theta_end), float(r.psi_end)
    if abs(np.tan(theta + psi / 2) - 1 / MU) > 1e-6 or abs(bend(theta) - psi) > 1e-9:
        message = "the drawn condition is not the lock of squama.bend"
        raise AssertionError(message)
    return theta


def turned(angle: float) -> np.ndarray:
    """Return the unit vector at an angle to the line from base to base."""
    return np.array([np.cos(angle), np.sin(angle)])


def arrow(ax: Axes, start: np.ndarray, along: np.ndarray, colour: str, width: float = 1.6) -> None:
    """Draw a vector."""
    look = {"arrowstyle": "-|>,head_width=.22,head_length=.5", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", start + along, start, arrowprops=look, zorder=6)


def scales(ax: Axes, theta: float) -> None:
    """Draw the bent bar, three scales, and the force at the tip of one of them."""
    psi = bend(theta)
    a, radius = theta + psi / 2, 1 / psi
    half = radius * np.sin(psi / 2)
    centre = np.array([half, radius * np.cos(psi / 2)])
    around = np.linspace(-1.9, 1.2, 200) * psi
    face = centre + radius * np.column_stack([np.sin(around), -np.cos(around)])
    back = centre + (radius + THICK) * np.column_stack([np.sin(around), -np.cos(around)])
    ax.add_patch(Polygon(np.vstack([face, back[::-1]]), fc=BAR, ec=GREY, lw=0.7))
    for k in (-1, 0, 1):
        at = (k - 0.5) * psi
        base = centre + radius * np.array([np.sin(at), -np.cos(at)])
        tip = base + ETA * turned(theta + at)
        colour = BLUE if k in (0, 1) else "#9bb7d4"
        ax.plot(*zip(base, tip, strict=True), color=colour, lw=2.2 if k in (0, 1) else 1.5, solid_capstyle="butt")
        ax.plot(*base, "o", ms=3, color=INK, zorder=5)
    touch = ETA * turned(theta - psi / 2)
    normal, friction = turned(a + np.pi / 2), -MU * turned(a)
    lean = np.degrees(np.arctan(MU))
    middle = np.degrees(a) + 90
    ax.add_patch(Wedge(touch, 1.25, middle - lean, middle + lean, fc=CONE, ec="none", alpha=0.75, zorder=3))
    ax.plot([touch[0] - 1.45, touch[0] + 0.5], [touch[1]] * 2, color=INK, lw=0.8, ls=(0, (4, 2)), zorder=4)
    ax.plot([0, 2 * half], [0, 0], color=INK, lw=0.8, ls=(0, (4, 2)), zorder=4)
    arrow(ax, touch, FORCE * 1.4 * normal, INK, 1.2)
    arrow(ax, touch, FORCE * 1.4 * (normal + friction), ACCENT)
    ax.text(*(touch + FORCE * 1.4 * normal + (0.02, 0.09)), "$N$", ha="center")
    tip = touch + FORCE * 1.4 * (normal + friction)
    above = 0.1 if tip[1] > touch[1] + 0.1 else -0.15
    ax.text(tip[0] - 0.1, tip[1] + above, "$R$", ha="center", va="center", color=ACCENT)
    ax.text(half, -0.13, "$c$", ha="center", va="center")
    ax.text(*(0.55 * touch + (0.06, -0.02)), "1", color=BLUE, ha="left", va="top")
    second = np.array([2 * half, 0]) + 0.3 * ETA * turned(a)
    ax.text(second[0] + 0.1, second[1] - 0.06, "2", color=BLUE)
    ax.set_aspect("equal")
    ax.axis("off")


def triangle(ax: Axes, theta: float) -> None:
    """Draw normal, friction, resultant, and its part across the line from base to base."""
    a = theta + bend(theta) / 2
    normal, friction = turned(a + np.pi / 2), -MU * turned(a)
    total = normal + friction
    origin = np.zeros(2)
    ax.plot([-1.5, 0.35], [0, 0], color=INK, lw=0.8, ls=(0, (4, 2)))
    arrow(ax, origin, normal, INK, 1.2)
    arrow(ax, normal, friction, BLUE, 1.4)
    arrow(ax, origin, total, ACCENT)
    side = np.array([-normal[1], normal[0]])
    ax.text(*(0.55 * normal - 0.1 * side), "$N$", ha="left", va="bottom")
    ax.text(*(normal + 0.5 * friction + 0.11 * normal), r"$\mu N$", ha="center", va="center", color=BLUE)
    ax.text(*(0.62 * total + (0.02, -0.12)), "$R$", ha="center", va="center", color=ACCENT)
    if total[1] > 1e-6:
        arrow(ax, np.array([total[0], 0.0]), np.array([0.0, total[1]]), ACCENT, 1.0)
        ax.text(total[0] - 0.06, total[1] / 2, r"$R_\perp$", ha="right", va="center", color=ACCENT)
    else:
        ax.text(total[0] - 0.1, -0.07, r"$R_\perp = 0$", ha="right", va="top", color=ACCENT)
    ax.text(0.37, 0.0, "line from\nbase to base", va="center", fontsize=7)
    ax.set_aspect("equal")
    ax.set_xlim(-1.85, 1.05)
    ax.set_ylim(-0.28, 1.08)
    ax.axis("off")


@style.styled
def picture() -> Figure:
    """Return the figure."""
    figure = style.new_figure(style.PAGE, 3.9)
    axes = figure.subplots(2, 2, height_ratios=(1.8, 1))
    states = ((EARLY, "before the lock: $R$ lifts the scales"), (locked(), "at the lock: $R$ points along the line"))
    for column, (theta, words) in enumerate(states):
        scales(axes[0, column], theta)
        triangle(axes[1, column], theta)
        axes[0, column].set_title(f"({'ab'[column]})  {words}")
        axes[0, column].set_xlim(-1.7, 2.6)
        axes[0, column].set_ylim(-0.55, 2.2)
    figure.legend(
        handles=[
            style.key("normal force $N$", lw=1.2),
            style.key(r"friction $\mu N$", color=BLUE),
            style.key("resultant $R$", color=ACCENT),
            Polygon([(0, 0)], fc=CONE, label=r"friction cone, half angle $\arctan\mu$"),
            style.key("line from base to base", lw=0.8, ls=(0, (4, 2))),
        ],
        loc="outside lower center",
        ncols=5,
    )
    return figure


if __name__ == "__main__":
    style.save_figure(picture(), Path(__file__).with_name("lock.png"))
