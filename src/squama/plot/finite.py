"""Finite beams: a row, a beam of finite elements, a part under load; figures of each scale, and of the load."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image

from squama.beam.design import Beam
from squama.errors import refuse
from squama.io import files
from squama.loads import model
from squama.part.definition import Part
from squama.plot import style
from squama.plot.palette import ACCENT, GREY, INK
from squama.types import Array

PLACE = "Scale, counted from the first"


@style.styled
def row_figure(dataset: xr.Dataset) -> Figure:
    """Draw the inclinations along a finite row of :func:`squama.row` at some twists, and its torque.

    Left: inclination against the scale's number, a line per twist; ticks at the right: the endless beam. Right: torque
    of the row, of the endless beam (dashed), and engagement.
    """
    figure = style.new_figure(style.PAGE, 3.3)
    left, right = figure.subplots(1, 2)
    inclinations(dataset, left)
    count, (twist, words) = dataset.sizes["scale"], _twist(dataset)
    factor, text = style.prefixed("T", style.finite_max(dataset["T"].values))
    right.plot(twist, factor * dataset["T"].values, color=INK, label=f"row of {count} scales")
    right.set(xlabel=words, ylabel=text)
    engaged = float(dataset["phi_e"]) * np.degrees(count)
    _beside(right, twist, factor * dataset["T_periodic"].values, "endless beam", engaged, "engagement")
    right.set_ylim(0, 1.25 * factor * style.finite_max(dataset["T"].values))
    about = f"{model(dataset.attrs)}, sense {dataset.attrs['sense']}, $\\mu$ = {float(dataset['mu']):g}"
    return style.headline(figure, f"Twisting of a row of {count} scales: {about}", (left, right))


def inclinations(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the inclination of every scale of :func:`squama.row`, a line per twist, and that of the endless beam."""
    ax, _ = style.panel(ax, dataset, "theta_periodic", "squama.row")
    touching = np.flatnonzero(dataset["phi"].values >= float(dataset["phi_e"]))
    mark: style.Look = {"marker": "_", "markersize": 8}
    chosen, handles = _inclinations(ax, dataset, touching if touching.size else np.array([0]))
    for i, colour in chosen:
        endless = np.degrees(float(dataset["theta_periodic"][i]))
        ax.plot([dataset.sizes["scale"] + 0.5], [endless], color=colour, **mark)
    handles.append(style.key("endless beam", linestyle="", **mark))
    style.legend_under(ax, handles, _twist(dataset)[1])
    return ax


def _twist(dataset: xr.Dataset) -> tuple[Array, str]:
    """Return the twists (n,) of a finite beam in degrees over all its scales, and their label."""
    count = dataset.sizes["scale"]
    return np.degrees(count * dataset["phi"].values), f"Twist over {count} scales (deg)"


def _beside(ax: Axes, x: Array, y: Array, words: str, engaged: float, touch: str) -> None:
    """Draw a reference curve dashed, with labels ``words`` and ``touch`` of the engagement, and the legend."""
    ax.plot(x, y, color=GREY, linestyle="--", label=words)
    if np.isfinite(engaged):
        ax.axvline(engaged, color=ACCENT, linewidth=0.7, linestyle=":", label=touch)
    style.legend_under(ax, ax.get_legend_handles_labels()[0])


@style.styled
def finite_figure(data: xr.Dataset) -> Figure:
    """Draw a finite beam of elements, from ``squama.fe.runs.cell``.

    Inclination and twist of every scale's pitch against the scale's number, a line per twist; torque over the mean
    twist, with the start's slope dashed.
    """
    figure = style.new_figure(style.PAGE, 3.0)
    left, middle, right = figure.subplots(1, 3)
    phi, words = _twist(data)
    chosen, handles = _inclinations(left, data, np.arange(phi.size))
    for i, colour in chosen:
        middle.plot(data["scale"].values, np.degrees(data["twist"].values[i]), color=colour, marker=".")
    middle.set(ylabel="Twist of a pitch (deg)", xlabel=PLACE)
    middle.xaxis.set_major_locator(MaxNLocator(integer=True))
    factor, text = style.prefixed("T", style.finite_max(np.abs(data["T"].values)))
    T = factor * data["T"].values
    if phi.size > 1:
        look: style.Look = {"color": GREY, "linestyle": "--"}
        right.plot([0, phi[-1]], [0, T[1] / phi[1] * phi[-1]], **look)
        handles.append(style.key("slope of the torque at the start", **look))
    right.plot(phi, T, color=INK)
    right.set(xlabel=words, ylabel=text)
    style.legend_below(figure, handles, 7, title=words)
    about = f"Twisting of a beam of {data.sizes['scale']} scales by finite elements, $\\mu$ = {float(data['mu']):g}"
    return style.headline(figure, about, (left, middle, right))


def _inclinations(ax: Axes, dataset: xr.Dataset, places: Array) -> tuple[list[tuple[int, style.Colour]], list[Artist]]:
    """Draw the inclination of every scale at some points, evenly chosen; return points with colours, and a legend."""
    some = np.unique(places[np.linspace(0, places.size - 1, 6).round().astype(int)]).tolist()
    chosen, handles = list(zip(some, style.shades(len(some)), strict=True)), list[Artist]()
    twist, _ = _twist(dataset)
    for i, colour in chosen:
        look: style.Look = {"color": colour, "marker": "."}
        ax.plot(dataset["scale"].values, np.degrees(dataset["theta"].values[i]), **look)
        handles.append(style.key(f"{twist[i]:.3g}", **look))
    ax.set(xlabel=PLACE, ylabel=style.label("theta", "deg"))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    return chosen, handles


@style.styled
def part_figure(dataset: xr.Dataset) -> Figure:
    """Draw a part of :func:`squama.load`: left its shape at some points, right the load over the travel.

    The shape is seen from the side, or from above where it moves more sideways. Right: also the load without contact
    (dashed), and engagement.
    """
    figure = style.new_figure(style.PAGE, 3.4)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    shape(dataset, left)
    load_curve(dataset, right)
    n, mu = dataset.sizes["scale"], float(dataset["mu"])
    text = f"A part of {n} scales, {dataset.attrs['support']}: {dataset.attrs['loads']}, $\\mu$ = {mu:g}"
    return style.headline(figure, text, (left, right))


def shape(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the bar's axis and its scales at some points of :func:`squama.load`, in mm."""
    ax, _ = style.panel(ax, dataset, "x_axis", "squama.load")
    most = int(dataset["share"].values.argmax())
    chosen = np.unique(np.linspace(0, most, 4).round().astype(int))
    handles, above = [], False
    for i, colour in zip(chosen, style.shades(len(chosen)), strict=True):
        above = _stand(ax, dataset, int(i), colour)
        handles.append(style.key(f"{float(dataset['share'][i]):.2f}", color=colour))
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="Along the bar at rest (mm)", ylabel="Across (mm)" if above else "Up (mm)")
    style.legend_under(ax, handles, "share of the load")
    return ax


def _stand(ax: Axes, dataset: xr.Dataset, i: int, colour: style.Colour) -> bool:
    """Draw a part at a point, mm: the bar's axis, and unless seen from above (which is returned) bar and scales."""
    x, y, z = (1e3 * dataset[f"{name}_axis"].values for name in "xyz")
    above, y, z = bool(np.ptp(x) > np.ptp(y)), y[i], z[i]
    ax.plot(z, x[i] if above else y, color=colour, linewidth=1.4)
    if not above:
        beams = Part.from_toml_text(dataset.attrs["beam"]).graded(dataset.sizes["scale"])
        along_z, along_y = np.gradient(z), np.gradient(y)
        half = 1e3 * beams[0].substrate.thickness / 2 / np.hypot(along_z, along_y)
        low, high = (np.array([z, y]) + side * half * [along_y, -along_z] for side in (1, -1))
        ax.fill(*np.hstack([high, low[:, ::-1]]), color=colour, alpha=0.2, linewidth=0)
        for name, side in (("theta", 1), ("theta_other", -1)):
            if name in dataset:
                ax.plot(*_scales(beams, dataset[name].values[i], y, z, side), color=colour, linewidth=0.8)
    return above


def part_animation(dataset: xr.Dataset, path: str | os.PathLike[str], *, frames: int = 40) -> Path:
    """Write the deformation of a part of :func:`squama.load`, with its load over the travel, as a GIF.

    At most ``frames`` frames, evenly along its points, in the view of :func:`part_figure`. Returns the path as given.
    Raises InputError for another kind of dataset, another extension, or a file that cannot be written.
    """
    if Path(path).suffix.lower() != ".gif":
        refuse("", "", "is no name of an animation", "write a name that ends in .gif", files.label(path))
    steps = np.unique(np.linspace(0, dataset.sizes["point"] - 1, max(2, frames)).round().astype(int))
    figure = part_figure(dataset)
    left, right = figure.axes
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    figure.set_layout_engine("none")
    limits = left.get_xlim(), left.get_ylim()
    if (legend := left.get_legend()) is not None:
        legend.remove()
    travel = np.asarray(right.get_lines()[0].get_xydata())
    (mark,) = right.plot([], [], "o", color=ACCENT)
    pictures = []
    for i in steps:
        for artist in (*left.get_lines(), *left.patches):
            artist.remove()
        _stand(left, dataset, int(i), INK)
        left.set(xlim=limits[0], ylim=limits[1])
        mark.set_data(*travel[i : i + 1].T)
        canvas.draw()
        pictures.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    times = [60] * (len(pictures) - 1) + [800]
    film = partial(pictures[0].save, format="GIF", duration=times, save_all=True, append_images=pictures[1:], loop=0)
    return files.atomic_write(path, film)


def _scales(beams: Sequence[Beam], theta: Array, y: Array, z: Array, side: int) -> tuple[Array, Array]:
    """Return coordinates of all scales of a face as lines in side view, mm: along the bar, and across it.

    NaN between scales; ``side``: 1 for the scaled face, -1 for the other one.
    """
    along = np.gradient(z), np.gradient(y)
    size = np.hypot(*along)
    t_z, t_y = (np.interp(np.arange(theta.size) + 0.5, np.arange(z.size), v / size) for v in along)
    middle_z, middle_y = ((v[1:] + v[:-1]) / 2 for v in (z, y))
    half, length = side * 1e3 * beams[0].substrate.thickness / 2, 1e3 * np.array([beam.scale.length for beam in beams])
    alpha = np.array([beam.scale.alpha for beam in beams])
    base_z, base_y = middle_z - half * t_y, middle_y + half * t_z
    ahead, up = length * np.cos(alpha) * np.cos(theta), side * length * np.sin(theta)
    tip_z, tip_y = base_z + ahead * t_z - up * t_y, base_y + ahead * t_y + up * t_z
    gap = np.full(theta.size, np.nan)
    return np.column_stack([base_z, tip_z, gap]).ravel(), np.column_stack([base_y, tip_y, gap]).ravel()


def load_curve(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the load of :func:`squama.load` over its travel, and that without contact."""
    ax, _ = style.panel(ax, dataset, "x_axis", "squama.load")
    name, way, factor, unit = ("F", "travel", 1e3, "mm") if "F" in dataset else ("moment", "turn", 180 / np.pi, "deg")
    travel = factor * dataset[way].values
    scale, text = style.prefixed(name, style.finite_max(np.abs(dataset[name].values)))
    ax.plot(travel, scale * dataset[name].values, color=INK, label="with scales")
    ax.set(xlabel=f"{'Travel' if unit == 'mm' else 'Turn'} of the load ({unit})", ylabel=text)
    engaged, up = float(dataset["share_e"]), slice(0, int(dataset["share"].values.argmax()) + 1)
    at = float(np.interp(engaged, dataset["share"].values[up], travel[up])) if np.isfinite(engaged) else np.inf
    _beside(ax, travel[up], scale * dataset[f"{name}_bare"].values[up], "without contact", at, "scales touch")
    return ax
