"""The plots of the page as one figure for print, with a legend of lines and models."""

from __future__ import annotations

from textwrap import wrap

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from squama.plot.palette import THEMES
from squama.plot.style import PAGE, Look, headline, key, new_figure, styled, written
from squama.web import charts, live
from squama.web.charts import Line
from squama.web.state import State
from squama.web.tables import Fitted, Table

NOW = {"color": THEMES["light"]["mark"], "markersize": 4}
"""Style of the current point."""
MARKS = {"": "o", charts.UP: "^", charts.RIGHT: ">"}
"""Marker of the current point, by the arrow to it where it lies beyond an axis."""


def made(state: State, table: Table | None, kind: str, fit: Fitted | None = None) -> tuple[str, bytes]:
    """Return name and content of a picture of the plots, "svg" or "png"."""
    return f"plots.{kind}", written(figure(state, table, fit), kind)


@styled
def figure(state: State, table: Table | None = None, fit: Fitted | None = None) -> Figure:
    """Draw the plots of a state in the width of a page, with the axes of the screen and one legend.

    The current point is marked; the legend has the values of kept designs and of the displayed one.
    """
    plots = (*charts.PLOTS, *[charts.RESIDUAL] * bool(table))
    drawn = new_figure(PAGE, 4.6 if table else 2.9)
    axes = drawn.subplots(*((2, 2) if table else (1, 3))).flat
    rows = live.compared(state)
    words = {row["name"]: f"{row['what']}; {row['model']}" for row in rows}
    words = {charts.OWN: words.pop("now")} | {name: f"{name}: {text}" for name, text in words.items()}
    words = {name: "\n".join(wrap(text, 105)) for name, text in words.items()}
    handles: dict[str, Line2D] = {}
    for ax, plot in zip(axes, plots, strict=True):
        ends = charts.frame(state, plot, table, fit)
        across, up = charts.axes(state, plot, ends)
        for line in charts.lines(state, plot, dark=False, table=table, fit=fit):
            look = _look(line)
            ax.plot(across.factor * line.x, up.factor * line.y, **look)
            handles.setdefault(line.name, key(words.get(line.name, line.name), **look))
        if plot != charts.RESIDUAL:
            at = charts.point(state, plot, table)
            ax.plot(at.left, 1 - at.top, MARKS[at.arrow], transform=ax.transAxes, clip_on=False, **NOW)
        ax.set(xlim=(0, across.factor * ends.right), ylim=(up.factor * ends.low, up.factor * ends.top))
        ax.set(xlabel=across.label, ylabel=up.label)
    last = handles.pop(charts.OWN)
    ordered = [last, *handles.values(), key("the state that is shown", linestyle="", marker="o", **NOW)]
    drawn.legend(handles=ordered, loc="outside lower left", ncols=1 if state.kept else 2)
    return headline(drawn, f"{state.load.capitalize()}, endless beam: {live.motion(state.setting).model}", drawn.axes)


def _look(line: Line) -> Look:
    if line.points:
        return {"color": line.colour, "linestyle": "", "marker": ".", "markersize": 3}
    # 0.75 pt in print for a pixel of the page
    width, *dashes = (0.75 * n for n in (line.width, *line.dashes))
    return {"color": line.colour, "linewidth": width, "linestyle": (0, dashes) if dashes else "-"}
