"""The one look of all figures, and how they are saved."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from squama import files
from squama.errors import InputError
from squama.model.solve import Array
from squama.symbols import SYMBOLS

P = ParamSpec("P")

FORMATS = (".png", ".svg", ".pdf")
"""Endings of the files that can be written."""
DPI = 200
"""Resolution of a PNG, dots per inch."""
COLUMN, PAGE = 3.5, 7.2
"""Widths of a figure in one and in two columns, inches."""
INK, GREY, ACCENT = "#1a1a1a", "#7a7a7a", "#b2182b"
"""Lines and text; what stands behind; what is marked."""

STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "mathtext.fontset": "dejavusans",
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "axes.titlelocation": "left",
    "axes.linewidth": 0.7,
    "axes.edgecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 1.9,
    "legend.labelspacing": 0.35,
    "legend.title_fontsize": 7,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.5,
    "lines.solid_capstyle": "round",
    "hatch.linewidth": 0.9,
    "hatch.color": GREY,
    "figure.facecolor": "white",
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "svg.fonttype": "none",
    "svg.hashsalt": "squama",
    "pdf.fonttype": 42,
}

_SETTINGS: Any = STYLE

AXIS = {
    "f0": r"Friction force $\bar{f}_0 = f\,l/K_\theta$",
    "N": "Normal force $N$ (N)",
    "alpha": r"Angle of the scale width $\alpha$ (rad)",
    "theta": r"Inclination $\theta$ (rad)",
    "K_t": r"Tangent stiffness $\mathrm{d}T/\mathrm{d}\Phi$ (N m$^2$)",
    "K_b": r"Tangent stiffness $\mathrm{d}M/\mathrm{d}\kappa$ (N m$^2$)",
}
"""Labels where that of the table of symbols is too long for an axis or has its formula in words."""

DASHES: dict[str, Any] = {"plate": "-", "edge": (0, (4, 1.6))}
"""Line of each force law."""


def styled(make: Callable[P, Figure]) -> Callable[P, Figure]:
    """Run a function that makes a figure under the common style, whatever the user's own settings are."""

    @functools.wraps(make)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with mpl.rc_context():
            mpl.rcdefaults()
            mpl.rcParams.update(_SETTINGS)
            return make(*args, **kwargs)

    return wrapped


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure (inches) that can be drawn without a display."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure; the ending of the path names the format.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    path : path
        Where to write, ending in .png, .svg or .pdf. The same figure gives the same bytes.

    Returns
    -------
    Path
        The file's path, as given.

    Raises
    ------
    InputError
        Another ending, or the file cannot be written; a file that was there is then as it was.
    """
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        what = f'the ending "{ending}" is not known' if ending else "has no ending"
        message = f"{files.label(path)}: {what}; write a name that ends in .png, .svg or .pdf"
        raise InputError(message)
    undated: dict[str, dict[str, Any]] = {
        ".png": {"Software": None},
        ".svg": {"Date": None},
        ".pdf": {"CreationDate": None},
    }

    def write(place: Path) -> None:
        with mpl.rc_context():
            mpl.rcParams.update(_SETTINGS)
            figure.savefig(place, format=ending[1:], metadata=undated[ending])

    return files.atomic_write(path, write)


def shades(n: int) -> list[tuple[float, float, float]]:
    """Return n colours from dark to light, in equal steps of grey, that colour-blind readers tell apart too."""
    table = np.asarray(mpl.colormaps["viridis"](np.linspace(0.0, 0.82, 256)))[:, :3]
    grey = table @ (0.299, 0.587, 0.114)
    steps = np.linspace(grey[0], grey[-1], max(n, 2))[:n]
    return [(float(r), float(g), float(b)) for r, g, b in table[np.searchsorted(grey, steps)]]


def prefixed(name: str, largest: float) -> tuple[float, str]:
    """Return the factor and the axis label that bring a quantity to a readable size (N m to mN m, kN m ...)."""
    steps = ((1e6, 1e-6, "M"), (1e3, 1e-3, "k"), (1.0, 1.0, ""), (1e-3, 1e3, "m"), (0.0, 1e6, "\N{MICRO SIGN}"))
    factor, prefix = next((f, p) for low, f, p in steps if abs(largest) >= low)
    if not largest:
        factor, prefix = 1.0, ""
    return factor, label(name, prefix + SYMBOLS[name].unit)


def label(name: str, unit: str | None = None) -> str:
    """Return the label of an axis, with another unit than the SI one if it is given."""
    symbol = SYMBOLS[name]
    text = AXIS.get(name, symbol.axis).replace("N m2", "N m$^2$")
    if unit is None:
        return text
    return text.replace(f"({symbol.unit.replace('N m2', 'N m$^2$')})", f"({unit.replace('N m2', 'N m$^2$')})")


def key(text: str, **line: Any) -> Line2D:
    """Return a handle for a legend."""
    return Line2D([], [], label=text, **{"color": INK, **line})


def law_keys(laws: Sequence[str]) -> list[Line2D]:
    """Return handles that tell the force laws apart."""
    words = {"plate": "plate law (the paper's)", "edge": "edge law"}
    return [key(words[law], linestyle=DASHES[law]) for law in laws]


def letter(ax: Axes, text: str) -> None:
    """Write the letter or the title of a panel above its left corner."""
    ax.set_title(text, loc="left", fontweight="bold" if len(text) <= 3 else "normal")


def finite_max(values: Array, default: float = 1.0) -> float:
    """Return the largest finite value."""
    good = values[np.isfinite(values)]
    return float(good.max()) if good.size else default
