"""Draw a twisted beam and its torque, docs/images/first.png: python docs/images/first.py."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

import squama
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK

ROOT = Path(__file__).parents[2]
BEAM = squama.Beam.from_toml(str(ROOT / "examples" / "stiff_skin.toml"))
DRAWN = 13
"""Number of drawn scales."""
BAR, SCALE, EDGE = "#d9d5c8", "#5b8fc4", "#27496d"
LIGHT = np.array([0.25, 0.9, 0.35])
VIEWER = np.array([0.62, 0.75, -0.16])
"""Where the drawing is seen from, in the axes of the beam: x across, y out of the scaled face, z along it.

A twist turns the scaled face towards x, so the bar never hides a scale.
"""


def axes_of_the_page() -> np.ndarray:
    """Return what points right, up and to the viewer (3, 3)."""
    toward = VIEWER / np.linalg.norm(VIEWER)
    right = np.cross([0.0, 1.0, 0.0], toward)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(toward, right), toward])


def turned(points: np.ndarray, angle: float, along: float) -> np.ndarray:
    """Return points (n, 3) turned about the axis and moved along it, in pitches."""
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) + [0, 0, along]


def faces(phi: float) -> list[tuple[np.ndarray, str]]:
    """Return the faces (4, 3) of bar and scales at a twist per pitch, with their colours."""
    half = np.array([BEAM.substrate.width, BEAM.substrate.thickness]) / (2 * BEAM.pitch)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    found = []
    stations = np.linspace(-0.6, DRAWN - 0.4, 6 * DRAWN)
    rings = [turned(np.column_stack([corners, np.zeros(4)]), phi * z, z) for z in stations]
    for a, b in itertools.pairwise(rings):
        found += [(np.array([a[i], a[i - 1], b[i - 1], b[i]]), BAR) for i in range(4)]
    found += [(rings[0], BAR), (rings[-1], BAR)]
    sa, ca = np.sin(BEAM.scale.alpha), np.cos(BEAM.scale.alpha)
    st, ct = np.sin(BEAM.scale.theta0), np.cos(BEAM.scale.theta0)
    x, y = np.array([-sa * ct, st, ca * ct]), np.array([ca, 0.0, sa])
    base = np.array([0.0, BEAM.lam, 0.0])
    plate = np.array([base - BEAM.beta * y, base + BEAM.beta * y])
    plate = np.vstack([plate, plate[::-1] + BEAM.eta * x])
    found += [(turned(plate, phi * k, float(k)), SCALE) for k in range(DRAWN)]
    return found


def shade(face: np.ndarray, colour: str) -> tuple[float, ...]:
    """Return the colour of a face by its attitude to the light."""
    normal = np.cross(face[1] - face[0], face[2] - face[1])
    bright = 0.72 + 0.28 * abs(normal @ LIGHT) / (np.linalg.norm(normal) * np.linalg.norm(LIGHT))
    rgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return tuple(rgb * bright)


def beam(ax: Axes, phi: float) -> None:
    """Draw the beam, bar before scales and far faces first."""
    page = axes_of_the_page()
    ordered = sorted(faces(phi), key=lambda each: (each[1] == SCALE, float((each[0] @ page[2]).mean())))
    outlines = [face @ page[:2].T for face, _ in ordered]
    look = {
        "facecolors": [shade(*each) for each in ordered],
        "edgecolors": [EDGE if colour == SCALE else shade(face, colour) for face, colour in ordered],
        "linewidths": [0.6 if colour == SCALE else 0.3 for _, colour in ordered],
    }
    ax.add_collection(PolyCollection(outlines, **look))


def torque(ax: Axes) -> None:
    """Draw torque over the twist of the whole beam, and that of its bar."""
    r = squama.twist(BEAM, to="0.11 rad/pitch")
    degrees = np.degrees(BEAM.length)
    turn, mN = degrees * r.Phi.values, 1e3 * r["T"].values
    touch = degrees * float(r.Phi_e)
    ax.plot(turn, mN, color=EDGE, lw=1.8)
    ax.plot(turn, 1e3 * (r["T"] - r.T_scales).values, **style.BARE)
    at = float(np.interp(touch, turn, mN))
    ax.plot(touch, at, color=INK, **style.ENGAGED)
    leader = {"arrowstyle": "-", "lw": 0.6, "shrinkB": 3}
    ax.annotate(f"scales touch\nat {touch:.0f} deg", (touch, at), (touch - 62, at + 4.5), arrowprops=leader)
    i = int(np.argmin(abs(turn - 2 * touch)))
    ax.plot(turn[i], mN[i], "o", ms=4, color=ACCENT)
    ratio = float(r.stiffness_ratio[i])
    ax.text(turn[i] + 6, mN[i] - 1.2, f"{ratio:.1f} times as\nstiff as the bar", va="center", color=ACCENT)
    ax.text(turn[-1] + 6, 1e3 * float(r["T"][-1] - r.T_scales[-1]) - 0.7, "bar alone", va="center", color=GREY)
    ax.set_xlim(0, 1.33 * turn[-1])
    ax.set_ylim(0, None)
    ax.set_xlabel("Twist of the whole beam (deg)")
    ax.set_ylabel("Torque (N mm)")


@style.styled
def picture() -> Figure:
    """Return the figure."""
    figure = style.new_figure(style.PAGE, 1.6)
    rest, twisted, right = figure.subplots(1, 3, width_ratios=(1, 1, 1.5))
    for ax, phi in ((rest, 0.0), (twisted, 0.11)):
        beam(ax, phi)
        ax.set_aspect("equal", adjustable="datalim")
        ax.autoscale_view()
        ax.axis("off")
    torque(right)
    rest.set_title(f"(a)  at rest ({DRAWN} of {BEAM.scales} scales)")
    twisted.set_title("(b)  twisted")
    right.set_title(f"(c)  torque of all {BEAM.scales} scales")
    return figure


if __name__ == "__main__":
    style.save_figure(picture(), Path(__file__).with_name("first.png"))
