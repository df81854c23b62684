"""squama map: a slice of a sweep as a picture or as CSV."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

from squama.cli.options import PLOTS, Problems, flag
from squama.errors import InputError

MOST_ROWS = 5_000_000


def map(  # noqa: A001 - the command's name
    store: str,
    /,
    *,
    plot: Annotated[tuple[str, ...], flag("Picture to write: .png, .svg or .pdf; may be repeated.")] = (),
    csv: Annotated[str | None, flag("CSV file to write: a row per cell of the slice, units in the header.")] = None,
    variable: Annotated[
        str, flag("What is drawn: RED, torque, f0, U_el, W_fr, phi_e, phi_end, theta_end, end or lock (RED).")
    ] = "RED",
    x: Annotated[str | None, flag("Dimension of the horizontal axis.")] = None,
    y: Annotated[str | None, flag("Dimension of the vertical axis; with --variable lock that of the lines.")] = None,
    panels: Annotated[str | None, flag("Dimension with a panel for each value, e.g. margin.")] = None,
    at: Annotated[tuple[str, ...], flag("Value of another dimension, e.g. eta=3; may be repeated.")] = (),
    lines: Annotated[str | None, flag("With --variable lock: the lines to draw, e.g. 0.2,0.5,1.")] = None,
    paths: Annotated[
        str | None, flag("With --variable lock and y = mu: values of x whose paths are drawn too, e.g. 30deg,45deg.")
    ] = None,
) -> int:
    """Draw a slice of a sweep: contours, regimes, lock envelopes; or write it as CSV.

    Parameters
    ----------
    store
        Store of a sweep (.zarr), finished or not.
    """
    from squama import files
    from squama import store as writers
    from squama.study import slices, stored

    problems = Problems()
    held: dict[str, str] = {}
    with problems.caught():
        held = _held(at)
    if not plot and csv is None:
        problems.lines.append("there is nothing to write: give --plot map.png or --csv map.csv")
    seen: set[Path] = set()
    for path, allowed in (*((p, PLOTS) for p in plot), *(((csv, (".csv",)),) if csv is not None else ())):
        with problems.caught():
            writers.check_place(path, allowed)
            if Path(path).resolve() in seen:
                message = f"{files.label(path)}: is given twice; give the output another name"
                raise InputError(message)
            seen.add(Path(path).resolve())
    problems.settle()

    dataset = stored.open_sweep(store)
    shown = [str(name) for name in dataset.data_vars if name != "status"]
    if variable not in (*shown, "lock"):
        message = f"--variable = {files.label(variable)}: must be one of {', '.join((*shown, 'lock'))}"
        raise InputError(message)
    with _laid_to("--at"):
        part = slices.take(dataset, x=x, y=y, panels=panels, at=held, bare=False)
    chosen, drawn_paths = None, None
    if lines is not None or variable == "lock":
        with _laid_to("--lines"):
            chosen = _lines(part, lines, variable)
    if paths is not None:
        with _laid_to("--paths"):
            drawn_paths = _paths(part, paths, variable)
    if csv is not None and part.data["RED"].size > MOST_ROWS:
        message = f"--csv: the slice has {part.data['RED'].size:,} rows, {MOST_ROWS:,} at most; hold more with --at"
        raise InputError(message)
    name = files.label(store)
    try:
        missing = int((dataset["status"] == 0).sum())
        if missing:
            print(f"squama: warning: {name}: {missing} of {dataset['status'].size} tiles are not computed yet")
        if plot:
            from squama import plot as figures

            drawn = slices.thinned(part, 1200)
            figure = figures.map_figure(
                drawn.data, variable, x=part.x, y=part.y, panels=part.panels, lines=chosen, paths=drawn_paths
            )
            for path in plot:
                figures.save_figure(figure, path)
                print(f"wrote {files.label(path)}")
        if csv is not None:
            writers.save(slices.worded(part.data.load()), csv)
            print(f"wrote {files.label(csv)}")
    except InputError:
        raise
    except (ValueError, RuntimeError) as error:
        # chunks carry a checksum: zarr says so in a ValueError
        if "checksum" not in str(error) and "decompress" not in str(error).lower():
            raise
        message = f"{name}: is damaged (a chunk does not fit its checksum); remove it and run the sweep again"
        raise InputError(message) from None
    return 0


def _held(at: tuple[str, ...]) -> dict[str, str]:
    """Return the values of --at by name."""
    from squama.units import shown

    found: dict[str, str] = {}
    for item in at:
        name, equals, text = (part.strip() for part in item.partition("="))
        if not (name and equals and text):
            message = f"--at {shown(item)}: is not name=value; write e.g. eta=3"
            raise InputError(message)
        if name in found:
            message = f"--at {name}: is given twice; keep one of them"
            raise InputError(message)
        found[name] = text
    return found


def _lines(part: object, lines: str | None, variable: str) -> list[float]:
    """Return the values of y whose lock lines are drawn."""
    import numpy as np

    from squama.study import slices

    assert isinstance(part, slices.Slice)
    if variable != "lock":
        message = "lines: belongs to --variable lock; leave it out"
        raise InputError(message)
    if part.y is None:
        message = "variable = lock: needs two dimensions, one along the lines and one from line to line"
        raise InputError(message)
    if lines is not None:
        return slices.values_of(part, [text.strip() for text in lines.split(",")], bare=False)
    values = part.data[part.y].values
    return [float(values[i]) for i in dict.fromkeys(np.linspace(0, values.size - 1, 6).round().astype(int).tolist())]


def _paths(part: object, paths: str, variable: str) -> Any:
    """Return the paths of the beams at some values of x."""
    from squama.study import slices
    from squama.study.paths import paths as follow

    assert isinstance(part, slices.Slice)
    if variable != "lock":
        message = "paths: belongs to --variable lock; leave it out"
        raise InputError(message)
    return follow(part, [text.strip() for text in paths.split(",")], bare=False)


@contextmanager
def _laid_to(name: str) -> Iterator[None]:
    """Lay a mistake to the flag that it names, else a value to the flag that was read."""
    try:
        yield
    except InputError as error:
        lines = []
        for line in str(error).splitlines():
            first, _, rest = line.partition(" ")
            own = first.rstrip(":") in ("x", "y", "panels", "at", "lines", "paths", "variable")
            lines.append(f"--{line}" if own else f"{name} {line}" if rest.startswith("= ") else line)
        raise InputError("\n".join(lines)) from None
