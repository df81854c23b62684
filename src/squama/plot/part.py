"""A part under load in panels: its shape at some points, and the load over its travel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squama.beam.design import Beam
from squama.part.definition import Part
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK
from squama.types import Array


@style.styled
def part_figure(dataset: xr.Dataset) -> Figure:
    """Draw a part of :func:`squama.load`: left its shape at some points, right the load over the travel.

    The shape is seen from the side, or from above where it moves more sideways. Right: the same without contact
    dashed, and where scales first touch.
    """
    figure = style.new_figure(style.PAGE, 3.4)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    shape(dataset, left)
    load_curve(dataset, right)
    n, mu = dataset.sizes["scale"], float(dataset["mu"])
    text = f"A part of {n} scales, {dataset.attrs['support']}: {dataset.attrs['loads']}, $\\mu$ = {mu:g}"
    return style.headline(figure, text, (left, right))


def shape(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the bar's axis and its scales at some points of :func:`squama.load`, mm."""
    ax, _ = style.panel(ax, dataset, "x_axis", "squama.load")
    part = Part.from_toml_text(dataset.attrs["beam"])
    beams = part.graded(dataset.sizes["scale"])
    x, y, z = (1e3 * dataset[f"{name}_axis"].values for name in "xyz")
    above = np.ptp(x) > np.ptp(y)
    across = x if above else y
    most = int(dataset["share"].values.argmax())
    chosen = np.unique(np.linspace(0, most, 4).round().astype(int))
    handles = []
    for i, colour in zip(chosen, style.shades(len(chosen)), strict=True):
        ax.plot(z[i], across[i], color=colour, linewidth=1.4)
        if not above:
            # the outline of the bar as seen from the side
            along_z, along_y = np.gradient(z[i]), np.gradient(y[i])
            half = 1e3 * part.beam.substrate.thickness / 2 / np.hypot(along_z, along_y)
            low, high = (np.array([z[i], y[i]]) + side * half * [along_y, -along_z] for side in (1, -1))
            ax.fill(*np.hstack([high, low[:, ::-1]]), color=colour, alpha=0.2, linewidth=0)
            ax.plot(*_scales(beams, dataset["theta"].values[i], y[i], z[i]), color=colour, linewidth=0.8)
        handles.append(style.key(f"{float(dataset['share'][i]):.2f}", color=colour))
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="Along the bar at rest (mm)", ylabel="Across (mm)" if above else "Up (mm)")
    style.legend_under(ax, handles, "part of the load")
    return ax


def _scales(beams: Sequence[Beam], theta: Array, y: Array, z: Array) -> tuple[Array, Array]:
    """Return lines of all scales as seen from the side: from the bar's face along the bar, and away from it."""
    along = np.gradient(z), np.gradient(y)
    size = np.hypot(*along)
    t_z, t_y = (np.interp(np.arange(theta.size) + 0.5, np.arange(z.size), v / size) for v in along)
    middle_z, middle_y = ((v[1:] + v[:-1]) / 2 for v in (z, y))
    half, length = 1e3 * beams[0].substrate.thickness / 2, 1e3 * np.array([beam.scale.length for beam in beams])
    alpha = np.array([beam.scale.alpha for beam in beams])
    base_z, base_y = middle_z - half * t_y, middle_y + half * t_z
    ahead, up = length * np.cos(alpha) * np.cos(theta), length * np.sin(theta)
    tip_z, tip_y = base_z + ahead * t_z - up * t_y, base_y + ahead * t_y + up * t_z
    gap = np.full(theta.size, np.nan)
    return np.column_stack([base_z, tip_z, gap]).ravel(), np.column_stack([base_y, tip_y, gap]).ravel()


def load_curve(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the load of :func:`squama.load` over its travel, beside that without contact."""
    ax, _ = style.panel(ax, dataset, "x_axis", "squama.load")
    name, way, factor, unit = ("F", "travel", 1e3, "mm") if "F" in dataset else ("moment", "turn", 180 / np.pi, "deg")
    travel = factor * dataset[way].values
    scale, text = style.prefixed(name, style.finite_max(np.abs(dataset[name].values)))
    ax.plot(travel, scale * dataset[name].values, color=INK, label="with scales")
    engaged, up = float(dataset["share_e"]), slice(0, int(dataset["share"].values.argmax()) + 1)
    bare = scale * dataset[f"{name}_bare"].values[up]
    ax.plot(travel[up], bare, color=GREY, linestyle="--", label="without contact")
    if np.isfinite(engaged):
        at = float(np.interp(engaged, dataset["share"].values[up], travel[up]))
        ax.axvline(at, color=ACCENT, linewidth=0.7, linestyle=":", label="scales touch")
    ax.set(xlabel=f"{'Travel' if unit == 'mm' else 'Turn'} of the load ({unit})", ylabel=text)
    style.legend_under(ax, ax.get_legend_handles_labels()[0])
    return ax
