"""Draw the geometry of the contact, docs/images/geometry.svg: python docs/images/sketch.py."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Arc, Polygon
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import squama

ETA, BETA, LAM, ALPHA, THETA = 2.2, 0.75, 0.45, np.radians(40), np.radians(38)
BLUE, RED, GREY, BAR = "#1f5fa8", "#c0392b", "#666666", "#f1efe8"


def scale(k: int, phi: float, theta: float) -> dict[str, np.ndarray]:
    """Corners and axes of scale 1 + k in units of the pitch; scale 1 stands still."""
    sa, ca, st, ct = np.sin(ALPHA), np.cos(ALPHA), np.sin(theta), np.cos(theta)
    n_x, n_y = np.array([-sa * ct, st, ca * ct]), np.array([ca, 0, sa])
    c, s = np.cos(k * phi), np.sin(k * phi)
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    base = np.array([0, LAM, 0])
    corners = {"D": base - BETA * n_y, "A": base + BETA * n_y}
    corners |= {"C": corners["D"] + ETA * n_x, "B": corners["A"] + ETA * n_x, "O": base, "M": base + ETA * n_x}
    out = {name: turn @ at + [0, 0, k] for name, at in corners.items()}
    return out | {"n_X": turn @ n_x, "n_Y": turn @ n_y}


def place(at: np.ndarray) -> tuple[float, float, float]:
    """Axes of the drawing: z to the right, x to the front, y up."""
    return at[2], at[0], at[1]


def top_view(ax: plt.Axes) -> None:
    """Three scales from above, untwisted."""
    ax.add_patch(Polygon([(-2.0, -0.95), (3.6, -0.95), (3.6, 0.95), (-2.0, 0.95)], fc=BAR, ec=GREY, lw=0.8))
    ax.plot([-2.2, 3.8], [0, 0], color=GREY, lw=0.7, ls="-.")
    ax.text(3.85, 0, "z", va="center", color=GREY)
    for k in (-1, 0, 1):
        c = scale(k, 0.0, np.radians(20))
        flat = [(c[n][2], c[n][0]) for n in "DABC"]
        colour = BLUE if k == 0 else "#9bb7d4"
        ax.add_patch(Polygon(flat, fc=colour, ec=colour, alpha=0.25, lw=0))
        ax.add_patch(Polygon(flat, fill=False, ec=colour, lw=1.3))
        o = (c["O"][2], c["O"][0])
        ax.plot(*o, "o", ms=2.5, color="k")
    c = scale(0, 0.0, np.radians(20))
    for name, dx, dy in (("D", -0.05, -0.2), ("A", 0.0, 0.1), ("C", 0.03, -0.2), ("B", 0.15, 0.05)):
        ax.text(c[name][2] + dx, c[name][0] + dy, f"${name}_1$", ha="center", color=BLUE)
    ax.annotate("", (1, 1.08), (0, 1.08), arrowprops={"arrowstyle": "<->", "lw": 0.8})
    for x in (0, 1):
        ax.plot([x, x], [0, 1.12], color="k", lw=0.5, ls=":")
    ax.text(0.5, 1.22, "$d$", ha="center", va="center")
    # alpha between the cross-section (vertical here) and the scale's width
    ax.plot([0, 0], [0, -0.75], color="k", lw=0.6)
    ax.add_patch(Arc((0, 0), 0.8, 0.8, theta1=270 - np.degrees(ALPHA), theta2=270, lw=0.8))
    ax.text(-0.17, -0.52, r"$\alpha$", ha="center", va="center")
    ax.text(0.14, 0.3, "$2b$", ha="center", va="center", color=BLUE)
    ax.set_title("from above, $\\varphi = 0$", fontsize=9, y=0.98)
    ax.set_aspect("equal")
    ax.set_xlim(-2.3, 4.1)
    ax.set_ylim(-2.0, 1.4)
    ax.axis("off")


def contact_view(ax: plt.Axes) -> None:
    """Scales 1 and 2 in contact."""
    ax.computed_zorder = False
    found = squama.contact(THETA, eta=ETA, beta=BETA, lam=LAM, alpha=ALPHA)
    phi, p, s = float(found.phi), float(found.p), float(found.s)
    one, two = scale(0, phi, THETA), scale(1, phi, THETA)
    for c, colour in ((two, "#9bb7d4"), (one, BLUE)):
        face = [place(c[n]) for n in "DABC"]
        ax.add_collection3d(Poly3DCollection([face], fc=colour, ec=colour, alpha=0.22, lw=1.2))
    for c, a, b in ((one, "C", "B"), (two, "D", "C")):
        ax.plot(*zip(place(c[a]), place(c[b]), strict=True), color=RED, lw=2.2, zorder=10)
    at = one["M"] + p * one["n_Y"]
    if not np.allclose(at, two["D"] + s * two["n_X"]):
        message = "the two edges do not meet"
        raise AssertionError(message)
    ax.plot(*([v] for v in place(at)), "o", color="k", ms=4, zorder=11)
    ax.text(*place(at + np.array([0.16, 0.1, -0.06])), "$P_{12}$", ha="center", va="center")
    for c, k, name, d in (
        (one, 1, "C", (0.0, -0.1, -0.12)),
        (one, 1, "B", (0.02, 0.14, 0.02)),
        (one, 1, "D", (-0.1, 0.0, -0.12)),
        (one, 1, "A", (0.02, 0.14, -0.02)),
        (two, 2, "C", (0.0, -0.02, 0.16)),
        (two, 2, "B", (0.0, 0.1, 0.14)),
        (two, 2, "D", (-0.12, -0.08, -0.04)),
    ):
        ax.text(*place(c[name] + np.array(d)), f"${name}_{k}$", ha="center", va="center", color=BLUE)
    o = one["O"]
    for vector, name in (
        (one["n_X"], "n_{X1}"),
        (one["n_Y"], "n_{Y1}"),
        (np.cross(one["n_X"], one["n_Y"]), "n_{Z1}"),
    ):
        ax.quiver(*place(o), *place(0.6 * vector), color="k", lw=1, arrow_length_ratio=0.18)
        aside = np.array([0, 0.03, 0.2]) if name == "n_{Y1}" else 0.12 * vector
        ax.text(*place(o + 0.6 * vector + aside), f"${name}$", fontsize=8, ha="center")
    ax.plot(*zip(place(np.array([0, 0, -0.6])), place(np.array([0, 0, 2.3])), strict=True), color=GREY, lw=0.8, ls="-.")
    ax.text(*place(np.array([0, -0.02, 2.4])), "z", color=GREY)
    ax.set_title(
        f"in contact: the tip edge $C_1B_1$ on the side edge $D_2C_2$,\n"
        rf"$\varphi$ = {phi:.2f}, $\theta$ = {np.degrees(THETA):.0f}°",
        fontsize=9,
        y=1.03,
    )
    ax.set_box_aspect((3.0, 2.3, 2.0), zoom=1.08)
    ax.set_xlim(-0.5, 2.5)
    ax.set_ylim(-1.5, 0.8)
    ax.set_zlim(-0.1, 1.9)
    ax.view_init(elev=52, azim=-128)
    ax.axis("off")


def main() -> None:
    """Write the picture beside this file."""
    mpl.rcParams |= {"font.size": 9, "svg.hashsalt": "squama", "mathtext.fontset": "dejavusans"}
    figure = plt.figure(figsize=(9.4, 4.0))
    top_view(figure.add_axes((0.0, 0.02, 0.45, 0.88)))
    contact_view(figure.add_axes((0.44, -0.07, 0.54, 0.9), projection="3d"))
    figure.savefig(Path(__file__).with_name("geometry.svg"), metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    main()
