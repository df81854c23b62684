"""Solids of an export: the assembled beam in views from above, from the side and cut, and its mould.

Parallel projection with flat shading; edges are drawn where the depth or the face changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from squama.errors import refuse
from squama.fabrication.bodies import BENCH
from squama.fabrication.mesh import Mesh, from_manifold, manifold
from squama.plot import raster
from squama.plot.style import COLUMN, PAGE, Look, headline, legend_below, new_figure, styled
from squama.types import Array

if TYPE_CHECKING:
    from squama.fabrication.exporting import Export

COLOURS = {
    "substrate": (0.75, 0.86, 0.93),
    "scale": (0.93, 0.72, 0.38),
    "tray": (0.78, 0.78, 0.8),
    "lid": (0.62, 0.75, 0.62),
    "blade": (0.85, 0.55, 0.5),
}
NAMES = {
    "substrate": "substrate",
    "scale": "scale",
    "tray": "mould: tray",
    "lid": "mould: lid",
    "blade": "mould: blade, which leaves the slot of a scale",
}
"""Words for the colours."""
SHOWN = 6
"""Number of pitches in close views."""
LIGHT = np.array([-0.35, -0.5, 0.8])
EDGE = (0.1, 0.1, 0.1)


@styled
def solids_figure(made: Export) -> Figure:
    """Draw the solids of an export: the beam from above and cut along its middle, and the mould taken apart.

    Raises InputError if the export has neither the assembly nor the mould.
    """
    columns = [drawn(made) for part, drawn in (("assembly", _beam), ("mould", _mould)) if part in made.solids]
    if not columns:
        refuse("picture", "", "shows the assembly and the mould", "write one of them among the parts")
    figure = new_figure(PAGE if len(columns) > 1 else 1.4 * COLUMN, 0)
    width = figure.get_figwidth() / len(columns)
    heights = [[(v.top - v.bottom) / (v.right - v.left) * width + 0.5 for _, _, v in panels] for panels in columns]
    figure.set_figheight(max(map(sum, heights)) + 0.5)
    grid = figure.add_gridspec(1, len(columns))
    for i, (panels, high) in enumerate(zip(columns, heights, strict=True)):
        # the shorter column is filled up from below
        own = [*high, max(map(sum, heights)) - sum(high) + 1e-6]
        rows = grid[i].subgridspec(len(own), 1, height_ratios=own)
        for row, (title, meshes, view) in enumerate(panels):
            ax = figure.add_subplot(rows[row])
            image = picture(meshes, [COLOURS[_kind(m)] for m in meshes], view, 1000)
            ax.imshow(image, extent=(view.left, view.right, view.bottom, view.top), interpolation="antialiased")
            ax.set_title(title)
            if "(mm)" not in title:
                ax.set_axis_off()
    shown = {_kind(m) for panels in columns for _, meshes, _ in panels for m in meshes}
    look: Look = {"edgecolor": EDGE, "linewidth": 0.5}
    legend_below(figure, [Patch(facecolor=COLOURS[k], label=NAMES[k], **look) for k in COLOURS if k in shown], 5)
    return headline(figure, f"Solids of a beam of {made.plan.scales} scales")


def _beam(made: Export) -> list[Panel]:
    solids, plan = made.solids["assembly"], made.plan
    side = fitted(solids, look(0, 0))
    near = side._replace(left=-3.0, right=min(side.right, plan.ends + SHOWN * plan.pitch + plan.length * 0.6))
    above = fitted(solids, look(0, 90))._replace(left=near.left, right=near.right)
    return [
        ("the assembled beam", solids, fitted(solids, look(-28, 30))),
        ("from above (mm)", solids, above),
        ("cut along its middle, from the side (mm)", halved(solids), near),
    ]


def _mould(made: Export) -> list[Panel]:
    solids, plan = made.solids["mould"], made.plan
    up = {"tray": 0.0, "lid": plan.height + 10, "blade": plan.height + 10}
    # blades are drawn out along the scales
    out = {"blade": BENCH @ plan.axes[0] * (plan.shank + plan.embedded + 10)}
    apart = [m.moved(np.eye(3), out.get(_kind(m), 0) + np.array([0, 0, up[_kind(m)]])) for m in solids]
    side = fitted(solids, look(0, 0))
    near = side._replace(right=min(side.right, plan.ends + SHOWN * plan.pitch))
    return [
        ("the mould taken apart", apart, fitted(apart, look(-28, 30))),
        ("the mould closed, cut along its middle (mm)", halved(solids), near),
    ]


def _kind(mesh: Mesh) -> str:
    return mesh.name.replace("-", " ").split(" ", maxsplit=1)[0]


class View(NamedTuple):
    """Directions to the right, up and to the eye, as rows of ``axes`` (3, 3), and the extent of the picture, mm."""

    axes: Array
    left: float
    right: float
    bottom: float
    top: float


Panel = tuple[str, list[Mesh], View]


def look(azimuth: float, elevation: float) -> Array:
    """Return the directions to the right, up and to the eye, rows (3, 3); angles in degrees, 0, 0 is the side view."""
    a, e = np.radians([azimuth, elevation])
    eye = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
    right = np.array([np.cos(a), np.sin(a), 0.0])
    return np.array([right, np.cross(eye, right), eye])


def fitted(meshes: Sequence[Mesh], axes: Array) -> View:
    """Return the view of all solids, with a margin."""
    seen = np.concatenate([m.vertices for m in meshes]) @ axes[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = 0.03 * float((high - low).max())
    return View(axes, low[0] - room, high[0] + room, low[1] - room, high[1] + room)


def halved(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Return the parts of solids beyond the middle plane along the bar."""
    parts = [(m.name, manifold(m).trim_by_plane((0.0, 1.0, 0.0), 0.0)) for m in meshes]
    return [from_manifold(name, part) for name, part in parts if not part.is_empty()]


def picture(meshes: Sequence[Mesh], colours: Sequence[Sequence[float]], view: View, pixels: int) -> Array:
    """Return an image (rows, ``pixels``, 4) of the solids, the first row at the top; empty pixels are transparent.

    ``colours``: red, green, blue of each solid, 0 to 1.
    """
    # every pixel is drawn as 2 x 2, which smooths edges
    fine = 2
    size = (view.right - view.left) / (pixels * fine)
    shape = fine * max(1, round((view.top - view.bottom) / size / fine)), pixels * fine
    depth, face = np.full(shape, -np.inf), np.full(shape, -1)
    shades, seen = list[Array](), list[Array]()
    for number, (mesh, colour) in enumerate(zip(meshes, colours, strict=True)):
        corners = (mesh.vertices @ view.axes.T - [view.left, view.bottom, 0]) / [size, size, 1]
        normals = mesh.normals / np.maximum(np.linalg.norm(mesh.normals, axis=1), 1e-300)[:, None]
        bright = 0.7 + 0.3 * (normals @ (LIGHT / np.linalg.norm(LIGHT)))
        slope = normals @ view.axes[2]
        towards = slope > 1e-9
        seen.append(corners[mesh.triangles[towards]])
        own = np.c_[np.outer(bright, colour), np.full(len(bright), number), normals, slope]
        shades.append(own[towards])
    for number, window, front, _ in raster.fill(depth, np.concatenate(seen)):
        face[window][front] = number
    shade = np.concatenate(shades)
    # one more row for empty pixels (face -1)
    colour = np.append(np.c_[shade[:, :3], np.ones(len(shade))], [[1.0, 1, 1, 0]], axis=0).astype(np.float32)
    _, kind = np.unique(np.round(shade[:, 3:7], 3), axis=0, return_inverse=True)
    kind = np.append(kind.ravel(), -1)[face]
    slope = np.append(1 / np.maximum(shade[:, 7], 0.02), 1.0).astype(np.float32)[face]
    flat = np.where(face >= 0, depth, -1e9)
    # edges: changes of solid, direction of the face or depth
    line = np.zeros(face.shape, bool)
    for p, q in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        jump = np.abs(flat[p] - flat[q]) > size * (1.5 * np.maximum(slope[p], slope[q]) + 1)
        line[p] |= (kind[p] != kind[q]) | jump
    fine_image = colour[face]
    fine_image[line] = [*EDGE, 1.0]
    rows, columns = (n // fine for n in face.shape)
    small = fine_image.reshape(rows, fine, columns, fine, 4)
    weight = small[..., 3:]
    mixed = (small[..., :3] * weight).sum((1, 3)) / np.maximum(weight.sum((1, 3)), 1e-9)
    whole = np.concatenate([mixed, weight.mean((1, 3))], axis=-1)
    return np.asarray(np.round(whole[::-1] * 255), np.uint8)
