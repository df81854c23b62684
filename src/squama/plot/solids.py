"""Solids for the printer: the assembled beam from above, from the side, cut along its middle, and its mould."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.errors import InputError
from squama.fabrication import shade
from squama.plot.style import PAGE, new_figure, styled

if TYPE_CHECKING:
    from squama.fabrication.facade import Export
    from squama.fabrication.mesh import Mesh

COLOURS = {
    "substrate": (0.75, 0.86, 0.93),
    "scale": (0.93, 0.72, 0.38),
    "tray": (0.78, 0.78, 0.8),
    "lid": (0.62, 0.75, 0.62),
    "blade": (0.85, 0.55, 0.5),
}
PIXELS = 1000
SHOWN = 6
"""Pitches of the views from close by."""


@styled
def solids_figure(made: Export) -> Figure:
    """Draw what an export has made: the beam from above and cut along its middle, and the mould taken apart.

    Parameters
    ----------
    made : Export
        With the assembly or the mould among its parts.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        Neither of them is there.
    """
    panels: list[tuple[str, list[Mesh], shade.View]] = []
    if "assembly" in made.solids:
        panels += _beam(made)
    if "mould" in made.solids:
        panels += _mould(made)
    if not panels:
        message = "picture: shows the assembly and the mould; write one of them among the parts"
        raise InputError(message)
    heights = [(v.top - v.bottom) / (v.right - v.left) for _, _, v in panels]
    figure = new_figure(PAGE, PAGE * sum(heights) + 0.55 * len(panels))
    axes = figure.subplots(len(panels), 1, height_ratios=[h * PAGE + 0.4 for h in heights], squeeze=False)[:, 0]
    for ax, (title, meshes, view) in zip(axes, panels, strict=True):
        _draw(ax, title, meshes, view)
    return figure


def _beam(made: Export) -> list[tuple[str, list[Mesh], shade.View]]:
    solids = made.solids["assembly"]
    plan = made.plan
    oblique = shade.fitted(solids, shade.look(-28, 30))
    side = shade.fitted(solids, shade.look(0, 0))
    near = side._replace(left=-3.0, right=min(side.right, plan.ends + SHOWN * plan.pitch + plan.length * 0.6))
    above = shade.fitted(solids, shade.look(0, 90))._replace(left=near.left, right=near.right)
    cut = [part for part in map(shade.halved, solids) if part is not None]
    return [
        ("the assembled beam", solids, oblique),
        ("from above (mm)", solids, above),
        ("cut along its middle, from the side (mm)", cut, near),
    ]


def _mould(made: Export) -> list[tuple[str, list[Mesh], shade.View]]:
    import numpy as np

    plan = made.plan
    solids = made.solids["mould"]
    up = {"tray": 0.0, "lid": plan.height + 10, "blade": plan.height + 10}
    # blades are drawn out along the scales
    out = np.array([plan.axes[0][2], plan.axes[0][0], plan.axes[0][1]]) * (plan.shank + plan.embedded + 10)
    apart = [
        m._replace(vertices=m.vertices + [0, 0, up[_kind(m)]] + (out if _kind(m) == "blade" else 0)) for m in solids
    ]
    cut = [part for part in map(shade.halved, solids) if part is not None]
    side = shade.fitted(solids, shade.look(0, 0))
    near = side._replace(right=min(side.right, plan.ends + SHOWN * plan.pitch))
    return [
        ("the mould taken apart", apart, shade.fitted(apart, shade.look(-28, 30))),
        ("the mould closed, cut along its middle (mm)", cut, near),
    ]


def _kind(mesh: Mesh) -> str:
    return mesh.name.replace("-", " ").split(" ", maxsplit=1)[0]


def _draw(ax: Axes, title: str, meshes: Sequence[Mesh], view: shade.View) -> None:
    image = shade.picture(meshes, [COLOURS[_kind(m)] for m in meshes], view, PIXELS)
    ax.imshow(image, extent=(view.left, view.right, view.bottom, view.top), interpolation="antialiased")
    ax.set_title(title)
    if "(mm)" not in title:
        ax.set_axis_off()
