"""The deformed pitch with its strain, drawn from behind forward (painter's algorithm)."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from squama.fe.deformed import IMAGES, Deformed
from squama.model.solve import Array
from squama.plot.style import GREY, INK, PAGE, new_figure, styled

AZIMUTH, ELEVATION = np.radians(-38.0), np.radians(32.0)
"""From where one looks, in rad: turned about y from the x axis towards z, and raised."""
SCALE = (0.62, 0.60, 0.56, 0.45)
MOST = 97.0
"""Colours end at this percentile of the strain over the surface: the scale's embedded edges are strained far more."""
_LIGHT = np.array([0.35, 0.85, 0.4])


@styled
def deformed_figure(state: Deformed) -> Figure:
    """Draw a deformed pitch with its images before and behind, and the scales on them.

    Parameters
    ----------
    state : Deformed
        From a run's ``last``, see :func:`squama.fe.facade.cell`.

    Returns
    -------
    matplotlib.figure.Figure
        Coloured by the largest principal stretch less 1, in percent, averaged at nodes.
    """
    figure = new_figure(0.78 * PAGE, 4.4)
    ax = figure.subplots()
    view = _view()
    strain = 100 * (state.at_nodes(state.stretch) - 1)[state.surface[:, :3]].mean(axis=1)
    outer = ~state.walls
    norm = Normalize(0.0, max(_percentile(strain[outer], state.moved[state.surface[outer, :3]]), 1e-6))
    colours = mpl.colormaps["viridis"](norm(strain))
    # the scale fills its slot
    colours[state.walls] = (*SCALE[:3], 1.0)
    polygons: list[Array] = []
    fills: list[Array] = []
    depths: list[Array] = []
    for k in IMAGES:
        corners = _image(state, k)[state.surface[:, :3]]
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
    # what stands out of the substrate is in front of it, seen from above
    plates = [plate @ view.T for plate in _exposed(state)]
    for plate in sorted(plates, key=lambda p: float(p[:, 2].mean())):
        x, y = plate[:, :2].T
        ax.fill(x, y, facecolor=SCALE, edgecolor=INK, linewidth=0.7)
        polygons.append(plate[:, :2])
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_axis_off()
    _bar(ax, state, polygons)
    shades = ScalarMappable(norm, mpl.colormaps["viridis"])
    figure.colorbar(shades, ax=ax, shrink=0.7, extend="max", label="Largest principal strain (%)")
    figure.suptitle(
        rf"Deformed at $\varphi$ = {abs(state.phi):.3g} rad per pitch; one pitch of elements, its images pale",
        fontsize=8,
        x=0.01,
        ha="left",
    )
    return figure


def _view() -> Array:
    """Return right, up and towards the eye as rows; y is up."""
    ca, sa, ce, se = np.cos(AZIMUTH), np.sin(AZIMUTH), np.cos(ELEVATION), np.sin(ELEVATION)
    eye = np.array([ce * ca, se, ce * sa])
    right = np.array([sa, 0.0, -ca])
    return np.array([right, np.cross(eye, right), eye])


def _percentile(values: Array, corners: Array) -> float:
    """Return the percentile of values on triangles (q, 3, 3) by their areas."""
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    order = np.argsort(values)
    share = np.cumsum(areas[order]) / areas.sum()
    return float(values[order][np.searchsorted(share, MOST / 100)])


def _turn(phi: float) -> Array:
    c, s = np.cos(phi), np.sin(phi)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _image(state: Deformed, k: int) -> Array:
    return np.asarray(state.moved @ _turn(k * state.phi).T + np.array([0.0, 0.0, k * state.pitch]))


def _exposed(state: Deformed) -> Array:
    """Return the corners (3, 4, 3) of what stands out of the substrate."""
    at_base = state.exposed / np.linalg.norm(state.scales[0, 1] - state.scales[0, 0])
    now = state.scales_moved.copy()
    for i, j in ((0, 1), (3, 2)):
        now[:, i] = now[:, j] + at_base * (now[:, i] - now[:, j])
    return now


def _lit(colours: Array, normal: Array, strength: float) -> Array:
    """Shade colours (n, 4) by the angle of their faces to the light; pale for a strength below 1."""
    unit = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    light = 0.72 + 0.28 * np.abs(unit @ (_LIGHT / np.linalg.norm(_LIGHT)))
    out = colours.copy()
    out[:, :3] = 1 - strength * (1 - out[:, :3] * light[:, None])
    return out


def _bar(ax: Any, state: Deformed, polygons: list[Array]) -> None:
    """Draw the length of one pitch below the picture."""
    points = np.concatenate(polygons)
    x, y = points[:, 0].min(), points[:, 1].min() - 0.12 * state.pitch
    ax.plot([x, x + state.pitch], [y, y], color=INK, linewidth=1.2)
    ax.text(x, y - 0.06 * state.pitch, f"one pitch, {1e3 * state.pitch:.4g} mm", va="top", fontsize=7, color=GREY)
