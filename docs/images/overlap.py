"""Draw the overlap of two plates with its vertices, docs/images/overlap.png: python docs/images/overlap.py."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import squama
from squama.contacts import path
from squama.curves import compliant
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK

ROOT = Path(__file__).parents[2]
BEAM, MU = ROOT / "examples" / "pla_on_vps.toml", 0.25
TWISTS = (0.18, 0.21, 0.24)
BLUE, RED, FILL = "#1f5fa8", ACCENT, "#e9d8a6"
MARKS = {
    "EE": ("o", "an edge crosses an edge"),
    "VF": ("^", "a corner of scale 1 over scale 2"),
    "FV": ("s", "a corner of scale 2 under scale 1"),
    "FE": ("D", "a bent edge of scale 2 along scale 1"),
}
SHARES = np.linspace(0.0, 1.0, 401)


class Pair(NamedTuple):
    """Two neighbours in a state: the shape of both, their deflection (6, 4), and scale 1 as scale 2 sees it."""

    scale: path.Scale
    bent: np.ndarray
    turn: np.ndarray
    shift: np.ndarray

    @classmethod
    def of(cls, scale: path.Scale, row: np.ndarray) -> Pair:
        """Return the scales of a state, a row of the path."""
        v = path.named(row)
        sa, ca, st, ct = np.sin(scale.alpha), np.cos(scale.alpha), np.sin(scale.theta0), np.cos(scale.theta0)
        x, y = np.array([-sa * ct, st, ca * ct]), np.array([ca, 0.0, sa])
        axes, base = np.array([x, y, np.cross(x, y)]), np.array([0.0, scale.lam, 0.0])
        a, b, c = -float(v["psi"]), -float(v["aside"]), -float(v["twist"])
        screw = expm(np.array([[0, -c, b, 0], [c, 0, -a, 0], [-b, a, 0, 1 + float(v["stretch"])], [0, 0, 0, 0]]))
        u = np.array([float(v[name]) for name in ("u_X", "u_Y", "u_Z")])
        own = Rotation.from_rotvec([float(v[name]) for name in ("w_X", "w_Y", "w_Z")]).as_matrix()
        place = base + axes.T @ u
        # scale 2 is scale 1 moved by the screw
        one, two = axes.T @ own, screw[:3, :3] @ axes.T @ own
        return cls(scale, path.deflections(row).reshape(6, 4), two.T @ one,
                   two.T @ (place - screw[:3, :3] @ place - screw[:3, 3]))  # fmt: skip

    def lifted(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the deflection of either scale."""
        X, Y = np.asarray(x / self.scale.eta), np.asarray(y / self.scale.beta)
        return sum(self.bent[m, n] * X ** (m + 2) * Y**n for m in range(6) for n in range(4))

    def over(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return places (n, 3) of the lower sheet of scale 1 in the axes of scale 2."""
        return np.column_stack([x, y, self.lifted(x, y) - self.scale.h / 2]) @ self.turn.T + self.shift

    def under(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return places (n, 3) of the upper sheet of scale 2 in the axes of scale 1."""
        return (np.column_stack([x, y, self.lifted(x, y) + self.scale.h / 2]) - self.shift) @ self.turn

    def gap_below(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the gaps (n,) between places of the upper sheet of scale 2 and the lower sheet of scale 1."""
        p = self.under(x, y)
        return self.lifted(p[:, 0], p[:, 1]) - self.scale.h / 2 - p[:, 2]

    def edges(self) -> list[np.ndarray]:
        """Return the edges (n, 2) of the lower sheet of scale 1 in the axes of scale 2: tip, side, side, base."""
        return [self.over(*edge)[:, :2] for edge in sides(self.scale)]


def sides(scale: path.Scale) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the edges of a plate: tip, side D, side A, base."""
    along, across, one = scale.eta * SHARES, scale.beta * (2 * SHARES - 1), np.ones_like(SHARES)
    return [(scale.eta * one, across), (along, -scale.beta * one), (along, scale.beta * one), (0 * one, across)]


def outline(edges: list[np.ndarray]) -> np.ndarray:
    """Return the corners and edges of a plate as one closed line (n, 2)."""
    tip, side_d, side_a, base = edges
    return np.vstack([side_d, tip, side_a[::-1], base[::-1]])


def vertices(pair: Pair) -> list[tuple[str, np.ndarray]]:
    """Return the vertices of the overlap in the axes of scale 2, and of which kind they are."""
    s = pair.scale
    found: list[tuple[str, np.ndarray]] = []
    corners = np.array(list(itertools.product((0.0, s.eta), (-s.beta, s.beta))))
    over, under = pair.over(*corners.T)[:, :2], pair.under(*corners.T)
    found += [("VF", p) for p in over if 0 <= p[0] <= s.eta and abs(p[1]) <= s.beta]
    found += [("FV", c) for c, p in zip(corners, under, strict=True) if 0 <= p[0] <= s.eta and abs(p[1]) <= s.beta]
    for edge in pair.edges():
        for axis, goal in ((1, -s.beta), (1, s.beta), (0, 0.0), (0, s.eta)):
            beyond = edge[:, axis] - goal
            for i in np.flatnonzero(np.diff(np.sign(beyond)) != 0):
                p = edge[i] + (edge[i + 1] - edge[i]) * beyond[i] / (beyond[i] - beyond[i + 1])
                if -1e-9 <= p[0] <= s.eta + 1e-9 and abs(p[1]) <= s.beta + 1e-9:
                    found.append(("EE", p))
    return found


def seen(ax: Axes, pair: Pair) -> tuple[float, float]:
    """Draw both plates along the normal of scale 2; return where on its side edge the overlap begins and ends."""
    s = pair.scale
    two, one = np.array([[0, -s.beta], [s.eta, -s.beta], [s.eta, s.beta], [0, s.beta]]), outline(pair.edges())
    found = vertices(pair)
    at = np.array([p for _, p in found])
    middle = at.mean(axis=0)
    order = np.argsort(np.arctan2(*(at - middle).T))
    ax.add_patch(Polygon(at[order], fc=FILL, ec="none"))
    ax.add_patch(Polygon(two, fill=False, ec=GREY, lw=1.3))
    ax.add_patch(Polygon(one, fill=False, ec=BLUE, lw=1.3))
    on_side = np.sort(at[np.abs(at[:, 1] + s.beta) < 1e-9, 0])
    for kind, p in found:
        x = np.array([p[0]])
        closed = float(pair.gap_below(x, np.array([p[1]]))[0]) < 1e-6
        ax.plot(*p, MARKS[kind][0], ms=6, mfc=RED if closed else "white", mec=RED if closed else INK, mew=1.0, zorder=5)
    bend = touched(pair, on_side)
    ax.plot(bend, -s.beta, MARKS["FE"][0], ms=6, mfc=RED, mec=RED, zorder=5)
    ax.text(0.05, s.beta - 0.06, "scale 2", color=GREY, va="top")
    ax.text(*(one[one[:, 0].argmin()] + (0.15, 0.2)), "scale 1", color=BLUE)
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_xlabel("$x/d$ along scale 2, from its base")
    ax.set_ylabel("$y/d$")
    style.letter(ax, rf"(a)  seen along the normal, $\varphi$ = {TWISTS[-1]}")
    return float(on_side[0]), float(on_side[-1])


def touched(pair: Pair, span: np.ndarray) -> float:
    """Return where the side edge of scale 2 is tangent to the face of scale 1: a root of the gap's slope."""
    y, small = np.array([-pair.scale.beta]), 1e-4

    def slope(x: float) -> float:
        return float(np.diff([pair.gap_below(np.array([x + e]), y)[0] for e in (-small, small)])[0])

    return float(brentq(slope, span[0] + 0.05, 0.7 * span[-1]))


def along(ax: Axes, scale: path.Scale, rows: np.ndarray, span: tuple[float, float]) -> None:
    """Draw the gap along the side edge of scale 2."""
    for twist, row, look in zip(TWISTS, rows, (":", "--", "-"), strict=True):
        pair = Pair.of(scale, row)
        at = [p[0] for _, p in vertices(pair) if abs(p[1] + scale.beta) < 1e-9]
        x = np.linspace(min(at), max(at), 400)
        gap = pair.gap_below(x, np.full_like(x, -scale.beta))
        ax.plot(x, 1e3 * gap, look, color=BLUE, label=rf"$\varphi$ = {twist}")
        ends = [x[0], x[-1], touched(pair, x)]
        for place, mark in zip(ends, ("s", "o", "D"), strict=True):
            closed = float(pair.gap_below(np.array([place]), np.array([-scale.beta]))[0]) < 1e-6
            height = 1e3 * float(np.interp(place, x, gap))
            colour = {"mfc": RED, "mec": RED} if closed else {"mfc": "white", "mec": INK}
            ax.plot(place, height, mark, ms=5, zorder=5, clip_on=False, **colour)
    ax.set_xlim(0, span[1] * 1.05)
    ax.set_ylim(0, None)
    ax.set_xlabel("$x/d$ along the side edge of scale 2")
    ax.set_ylabel(r"gap, $10^{-3}\,d$")
    ax.legend()
    style.letter(ax, "(b)  gap along that edge")


@style.styled
def picture() -> Figure:
    """Return the figure."""
    beam = squama.Beam.from_toml(str(BEAM))
    scale, held = compliant.scale(beam, ideal=False), compliant.Held.of(beam.replace(hold="bend, lateral bend"))
    rows, _ = path.Path.of(scale, held.K, MU, **held.bar).states(np.array(TWISTS))
    figure = style.new_figure(style.PAGE, 2.6)
    left, right = figure.subplots(1, 2, width_ratios=(1.55, 1))
    span = seen(left, Pair.of(scale, rows[-1]))
    along(right, scale, rows, span)
    handles = [style.key(f"{k}: {words}", marker=m, ls="", mfc="white") for k, (m, words) in MARKS.items()]
    handles.append(style.key("touches", marker="o", ls="", mfc=RED, mec=RED))
    style.legend_below(figure, handles, 3)
    return figure


if __name__ == "__main__":
    style.save_figure(picture(), Path(__file__).with_name("overlap.png"))
