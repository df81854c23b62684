"""The common style of all figures, and their saving."""

from __future__ import annotations

import functools
import io
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axes._secondary_axes import SecondaryAxis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from squama import arguments
from squama.beam.design import Beam
from squama.errors import refuse
from squama.io import files
from squama.loads import LOADS, TESTS, Load, model
from squama.people import readable
from squama.plot.palette import GREY, INK
from squama.symbols import SYMBOLS
from squama.types import Array

P = ParamSpec("P")

FORMATS = (".png", ".svg", ".pdf")
"""File extensions of figures."""
DPI = 200
"""Resolution of a PNG, dots per inch."""
COLUMN, PAGE = 3.5, 7.2
"""Widths of a figure in one and in two columns, inches."""

LABELS = 1.2
"""Approximate width of a panel with its labels over that of its axes."""
TICKS = 6
"""Largest number of steps along an axis of half a page: longer series of many digits would overlap."""

Look = dict[str, Any]
"""Keyword arguments of matplotlib's artists."""
Colour = str | tuple[float, float, float]
Dash = str | tuple[float, tuple[float, ...]]
"""Dashes of a line in matplotlib's form."""

_SETTINGS = mpl.rc_params_from_file(Path(__file__).with_name("figure.mplstyle"), use_default_template=False)
_SETTINGS.update({"axes.edgecolor": INK, "hatch.color": GREY, "figure.dpi": DPI, "savefig.dpi": DPI})

AXIS = {
    "f0": r"Friction force $\bar{f}_0 = f\,l/K_\theta$",
    "N": "Normal force $N$ (N)",
    "f": "Friction force $f$ (N)",
    "alpha": r"Angle of the scale width $\alpha$ (rad)",
    "theta": r"Inclination $\theta$ (rad)",
    "K_t": r"Tangent stiffness $\mathrm{d}T/\mathrm{d}\Phi$ (N m^2)",
    "K_b": r"Tangent stiffness $\mathrm{d}M/\mathrm{d}\kappa$ (N m^2)",
}
"""Axis labels, where that of the table of symbols is too long or has its formula in words."""

DASHED: Dash = (0, (4, 2))
BARE: Look = {"color": GREY, "linestyle": DASHED, "linewidth": 1}
"""Style of the beam without contact."""
ENGAGED: Look = {"linestyle": "", "marker": "o", "markerfacecolor": "white", "markersize": 4}
"""Style of the mark of engagement."""
DASHES: dict[str, Dash] = {"plate": "-", "edge": (0, (4, 1.6))}
LAWS = {"plate": "plate law (the paper's)", "edge": "edge law"}
"""Line style and name of each force law."""


def styled(make: Callable[P, Figure]) -> Callable[P, Figure]:
    """Run a function that makes a figure with the common style, whatever the user's settings."""

    @functools.wraps(make)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> Figure:
        for given in args[:1]:
            arguments.result(given)
        with mpl.rc_context():
            mpl.rcdefaults()
            mpl.rcParams.update(_SETTINGS)
            return make(*args, **kwargs)

    return wrapped


class _Shown(Figure):
    """A figure that displays itself at the end of a notebook's cell, though it is made without pyplot."""

    def _repr_png_(self) -> bytes:
        return written(self, "png")


def written(figure: Figure, kind: str) -> bytes:
    """Return a figure as the bytes of a file ("png", "svg", "pdf"); equal figures give equal bytes."""
    made, undated = io.BytesIO(), {"png": "Software", "svg": "Date", "pdf": "CreationDate"}[kind]
    with mpl.rc_context():
        mpl.rcParams.update(_SETTINGS)
        figure.savefig(made, format=kind, metadata={undated: None})
    return made.getvalue()


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure (inches) that needs no display."""
    figure = _Shown(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def panel(ax: Axes | None, dataset: xr.Dataset, mark: str, made_by: str) -> tuple[Axes, Load]:
    """Return the axes for a result, by default those of a new figure, and the kind of its load.

    Raises InputError where the dataset lacks the name ``mark``, so it is of another kind.
    """
    arguments.result(dataset)
    if mark not in {*map(str, dataset.variables), *map(str, dataset.dims)}:
        refuse("", "", f"this dataset is no result of {made_by}", "its .squama.plot() draws what it is")
    kind = TESTS.get(dataset.attrs.get("load", ""), LOADS["twisting"])
    return new_figure(COLUMN, 0.75 * COLUMN).subplots() if ax is None else ax, kind


@contextmanager
def within(ax: Axes) -> Iterator[None]:
    """Draw into axes without changing their height."""
    limits = ax.get_ylim()
    yield
    ax.set_ylim(limits)


def about(dataset: xr.Dataset) -> str:
    """Return model and friction of a result as text for its title."""
    return f"{model(dataset.attrs)}, $\\mu$ = {float(dataset['mu']):g}"


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure (.png, .svg, .pdf); return the path as given. Equal figures give equal bytes.

    Raises InputError for another extension, or a file that cannot be written; an old file then stays unchanged.
    """
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        what = f'the ending "{ending}" is not known' if ending else "has no ending"
        refuse("", "", what, "write a name that ends in .png, .svg or .pdf", files.label(path))
    # written as a whole, because matplotlib reports a full disk by errors of its own kinds
    made = written(figure, ending[1:])
    return files.atomic_write(path, lambda place: place.write_bytes(made))


def shades(n: int) -> list[Colour]:
    """Return n colours from dark to light, in equal steps of grey, distinguishable for colour-blind readers too."""
    table = np.asarray(mpl.colormaps["viridis"](np.linspace(0.0, 0.82, 256)))[:, :3]
    grey = table @ (0.299, 0.587, 0.114)
    steps = np.linspace(grey[0], grey[-1], max(n, 2))[:n]
    return [(float(r), float(g), float(b)) for r, g, b in table[np.searchsorted(grey, steps)]]


def prefixed(name: str, largest: float) -> tuple[float, str]:
    """Return the factor and the axis label of a quantity in a readable unit (N mm, N m, mJ/m ...)."""
    factor, unit = readable(SYMBOLS[name].unit, largest)
    return factor, label(name, unit)


def unit_of(text: str) -> str:
    """Return the unit at the end of an axis label, with its brackets."""
    return text[text.rindex("(") :]


def label(name: str, unit: str | None = None) -> str:
    """Return the axis label of a quantity, in SI or another unit."""
    symbol = SYMBOLS[name]
    text = AXIS.get(name, symbol.axis)
    return re.sub(r"(N m+)\^?2", r"\1$^2$", text.replace(f"({symbol.unit})", f"({unit or symbol.unit})"))


def key(text: str, **line: Any) -> Line2D:
    """Return a handle for a legend."""
    return Line2D([], [], label=text, **{"color": INK, **line})


def legend_below(figure: Figure, handles: Sequence[Artist], most: int, **look: object) -> None:
    """Add a legend below all panels, in as many columns (at most ``most``) as fit the figure."""
    legend_within(figure, most, handles, loc="outside lower center", **look)


def legend_under(ax: Axes, handles: Sequence[Artist], title: str = "") -> None:
    """Add a legend below a panel and the label of its axis, which must be set."""
    lines = 3.2 + 1.2 * ax.get_xlabel().count("\n")
    under = ScaledTranslation(0, -lines * mpl.rcParams["font.size"] / 72, ax.figure.dpi_scale_trans)
    look: Look = {"columnspacing": 1.2, "title": title, "alignment": "left", "bbox_to_anchor": (0.5, 0)}
    legend_within(ax, 4, handles, loc="upper center", bbox_transform=ax.transAxes + under, **look)


def legend_within(place: Figure | Axes, most: int, handles: Sequence[Artist], **look: Any) -> None:
    """Add a legend in as many columns (at most ``most``) as fit a figure, or axes with labels."""
    room = place.bbox.width * (1.0 if isinstance(place, Figure) else LABELS)
    for columns in range(min(most, len(handles)), 0, -1):
        legend = place.legend(handles=handles, ncols=columns, **look)
        if columns == 1 or legend.get_window_extent().width <= room:
            return
        legend.remove()


def law_keys(laws: Sequence[str]) -> list[Line2D]:
    """Return legend handles of the force laws."""
    return [key(LAWS[law], linestyle=DASHES[law]) for law in laws]


def letter(ax: Axes, text: str) -> None:
    """Write the letter or the title of a panel above its left corner."""
    ax.set_title(text, loc="left", fontweight="bold" if len(text) <= 3 else "normal")


def letters(axes: Iterable[Axes]) -> None:
    """Write (a), (b) ... above panels."""
    for i, ax in enumerate(axes):
        letter(ax, f"({chr(97 + i)})")


def headline(figure: Figure, text: str, panels: Iterable[Axes] = ()) -> Figure:
    """Write the title of a figure, wrapped to its width, and letters above panels; return the figure."""
    letters(panels)
    title = figure.suptitle("", fontsize=8, x=0.01, ha="left")
    lines = []
    for part in text.splitlines():
        line = ""
        # units are not broken
        for word in re.sub(r"(?<=N) (?=m)| (?=[=\u00b1] *[-\d])|(?<=[=\u00b1]) (?=[-\d])", "\u00a0", part).split(" "):
            title.set_text(f"{line} {word}".strip())
            if line and title.get_window_extent().width > 0.98 * figure.bbox.width:
                lines.append(line)
                line = word
            else:
                line = title.get_text()
        lines.append(line)
    title.set_text("\n".join(lines))
    return figure


def scaled_above(ax: Axes, factor: float, text: str) -> SecondaryAxis:
    """Draw an axis above a panel with ``factor`` times the values of the axis below."""
    top = ax.secondary_xaxis("top", functions=(lambda v: np.multiply(v, factor), lambda v: np.divide(v, factor)))
    top.set_xlabel(text)
    top.tick_params(labelsize=7)
    return top


def scaled_right(ax: Axes, factor: float, text: str) -> SecondaryAxis:
    """Draw an axis on the right of a panel with ``factor`` times the values of the axis on its left."""
    right = ax.secondary_yaxis("right", functions=(lambda v: np.multiply(v, factor), lambda v: np.divide(v, factor)))
    right.set_ylabel(text)
    right.tick_params(labelsize=7)
    return right


def degrees_above(ax: Axes, kind: Load, beam: Beam, pitch: float = 1.0) -> SecondaryAxis:
    """Draw an axis above a panel with the degrees of the whole beam.

    The axis below is in rad per pitch, or in rad/m with the ``pitch`` in m.
    """
    factor, text = over_beam(kind, beam)
    return scaled_above(ax, pitch * factor, text)


def over_beam(kind: Load, beam: Beam) -> tuple[float, str]:
    """Return the factor from rad per pitch to degrees of the whole beam, and the label of an axis in these."""
    return float(np.degrees(beam.pitches)), f"{kind.verb.capitalize()} over {beam.extent} (deg)"


def angle_label(load: str) -> str:
    """Return the axis label of the load angle."""
    return label(TESTS[load].angle)


def finite_max(values: Array, default: float = 1.0) -> float:
    """Return the largest finite value, or the default."""
    good = values[np.isfinite(values)]
    return float(good.max()) if good.size else default
