"""Output of a command: files, pictures, and the result: a summary for people, or JSON.

JSON is strictly valid: NaN is null, and infinity is the text "inf".
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from squama.errors import printable, refuse
from squama.io import files
from squama.io.files import label
from squama.loads import ENDLESS, NOTHING, ending, fixed, model
from squama.people import figure, rigidity_unit, turned
from squama.units import number, torque_unit

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.cli.flags import Common
    from squama.curves.labelled import Answer, Labelled
    from squama.types import Array


Shown: TypeAlias = "Iterable[str | Table]"
"""Lines and tables of a summary."""
SCHEMA = 3
"""Version of the JSON keys; it increases when a key is removed or changes its meaning or unit."""

# ---- files ------------------------------------------------------------------------------------------------


def write(
    flags: Common,
    data: Callable[[], xr.Dataset],
    figure: str,
    table: Callable[[xr.Dataset], xr.Dataset] | None = None,
    **also: object,
) -> list[Path]:
    """Write the requested pictures, CSV (of ``table(data)``) and netCDF; ``data`` is called only if there are any."""
    if not (flags.plot or flags.csv or flags.netcdf):
        return []
    from squama.io import datasets

    dataset = data()
    written = draw(flags.plot, figure, dataset, **also)
    if flags.csv is not None:
        written.append(write_csv(flags.csv, table(dataset) if table else dataset))
    if flags.netcdf is not None:
        written.append(datasets.save(dataset, flags.netcdf))
    return written


def draw(paths: Sequence[str], figure: str, /, *given: object, **also: object) -> list[Path]:
    """Draw a figure with a function of :mod:`squama.plot`, and write it to every path."""
    if not paths:
        return []
    from squama import plot

    drawn = getattr(plot, figure)(*given, **also)
    return [plot.save_figure(drawn, path) for path in paths]


def write_text(path: str | Path, text: str) -> Path:
    """Write a text file atomically; "-" is standard output."""
    if path == files.STANDARD:
        sys.stdout.write(text)
        return Path(files.STANDARD)
    return files.atomic_write(path, lambda place: place.write_text(text, encoding="utf-8"))


def check_folder(folder: str, *, force: bool) -> None:
    """Refuse a folder that cannot be made, or that holds files ``design_*.toml`` already."""
    place, where = Path(folder), f"-o {label(folder)}"
    if folder == files.STANDARD:
        refuse(where, "", "is standard output, which holds no folder", "give the name of a folder")
    if files.exists(place) and not place.is_dir():
        refuse(where, "", "is a file", "give the name of a folder")
    if not place.exists() and not Path(os.path.realpath(place)).parent.is_dir():
        refuse(where, "", "its folder does not exist", "make it first or give another path")
    there = sorted(p.name for p in place.glob("design_*.toml")) if place.is_dir() else []
    if there and not force:
        more = f" and {len(there) - 1} more" if len(there) > 1 else ""
        refuse(where, "", f"holds {there[0]}{more} already", "give another folder, or replace them with --force")


def write_csv(path: str, dataset: xr.Dataset) -> Path:
    """Write a dataset as CSV; "-" is standard output."""
    from squama.io import datasets

    return write_text(path, datasets.csv_text(dataset)) if path == files.STANDARD else datasets.save(dataset, path)


def write_beams(folder: str, texts: Mapping[int, str]) -> list[Path]:
    """Write ``design_1.toml`` ... into a folder; files ``design_*.toml`` of an earlier run are removed."""
    place = files.make_folder(folder)
    written = [write_text(place / f"design_{number}.toml", text) for number, text in texts.items()]
    for old in place.glob("design_*.toml"):
        if old not in written:
            old.unlink()
    return written


# ---- the result -------------------------------------------------------------------------------------------


def report(
    as_json: bool,
    file: str,
    written: Iterable[Path | str],
    record: Mapping[str, object],
    shown: Shown,
    wrote: Iterable[str] | None = None,
) -> int:
    """Print a result and the written files; return the exit status.

    As JSON the entries are ``file`` (the input), those of ``record``, and ``written``. For people the title is the file
    and the first of ``shown``; the other lines and tables follow, and a line for each written file, or the lines
    ``wrote`` instead. After a table on standard output only warnings are printed.
    """
    paths = list(written)
    if Path(files.STANDARD) in paths:
        for line in shown:
            if isinstance(line, str) and line.startswith("warning: "):
                print(_clean(line), file=sys.stderr)
        return 0
    if as_json:
        return say(True, {"file": label(file), **record, "written": [str(path) for path in paths]}, ())
    from rich.console import Console

    console = Console(highlight=False, markup=False, emoji=False)
    title, *parts = shown
    # no digit is cut off: a window narrower than a table wraps its lines
    wide, tables = console.options.update(width=1000), [part for part in parts if not isinstance(part, str)]
    console.width = max(console.width, 100, *(console.measure(table, options=wide).maximum for table in tables))
    console.print(f"{label(file)}{_clean(str(title))}", style="bold", soft_wrap=True)
    for part in (*parts, *(wrote or (f"wrote {label(path)}" for path in paths))):
        if isinstance(part, str):
            console.print(_clean(part), style="yellow" if part.startswith("warning: ") else None, soft_wrap=True)
        else:
            console.print(part)
    return 0


def of(given: object, names: str) -> dict[str, object]:
    """Return attributes by name; ``names`` are words of a text."""
    return {name: getattr(given, name) for name in names.split()}


def part(data: xr.Dataset | Answer, *dims: str) -> dict[str, object]:
    """Return the values of the variables along exactly these dimensions, by name."""
    return {str(name): v.values for name, v in data.variables.items() if v.dims == dims}


def figures(data: xr.Dataset | Answer) -> dict[str, object]:
    """Return the single figures of a result, by name, without friction."""
    return {name: value for name, value in part(data).items() if name != "mu"}


def record(beam: Beam, data: xr.Dataset | Answer, attrs: str, **parts: object) -> dict[str, object]:
    """Return a result for JSON; a part that is text is replaced by the variables along the dimensions that it names."""
    return {
        **{key: data.attrs[key] for key in attrs.split() if key in data.attrs},
        "mu": data.variables["mu"].values,
        "warnings": data.attrs["warnings"].splitlines(),
        "beam": beam.model_dump(),
        **{name: part(data, *one.split()) if isinstance(one, str) else one for name, one in parts.items()},
        "units": units(data.variables.items()),
    }


def units(variables: Iterable[tuple[Hashable, xr.Variable | xr.DataArray | Labelled]]) -> dict[str, str]:
    """Return the units of variables by name."""
    return {str(name): v.attrs.get("units", "") for name, v in variables}


def show_json(record: Mapping[str, object]) -> None:
    """Print a record as JSON on standard output; its last entry ``schema`` is the version of the keys."""
    sys.stdout.write(json.dumps(_plain({**record, "schema": SCHEMA}), allow_nan=False, indent=1) + "\n")


def _plain(value: object) -> object:
    """Return nested values as types of JSON."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "inf" if value > 0 else "-inf"
    return value


def say(as_json: bool, record: Mapping[str, object], lines: Iterable[str]) -> int:
    """Print a record as JSON, or lines; return the exit status."""
    if as_json:
        show_json(record)
    else:
        print(*map(_clean, lines), sep="\n")
    return 0


def _clean(text: str) -> str:
    """Return lines with control characters escaped, so that a file's text cannot control the terminal."""
    return "\n".join(map(printable, text.split("\n")))


def table(head: Sequence[str], rows: Iterable[Sequence[str]], *, left: int | None = None, gap: int = 2) -> Table:
    """Return a table: the first ``left`` columns (default: all) aligned left, the others right."""
    from rich.table import Table

    made = Table(box=None, pad_edge=False, padding=(0, gap, 0, 0), show_header=any(head))
    for i, name in enumerate(head):
        first = left is None or i < left
        made.add_column(name, header_style="bold", justify="left" if first else "right", no_wrap=first)
    for row in rows:
        made.add_row(*map(_clean, row))
    return made


def warnings(text: str | Iterable[str]) -> list[str]:
    """Return warnings as printed lines."""
    lines = text.splitlines() if isinstance(text, str) else text
    return [f"warning: {line}" for line in lines if line]


# ---- the summary -------------------------------------------------------------------------------------------


class Summary(NamedTuple):
    """The printed result of a command: figures by name (without empty ones), a table, and more with --full."""

    verdict: str
    figures: Iterable[tuple[str, str]] = ()
    table: Shown = ()
    warnings: str | Iterable[str] = ()
    full: Shown = ()

    def shown(self, *, full: bool = False) -> Iterator[str | Table]:
        """Yield the lines and tables in order."""
        yield f": {self.verdict}"
        rows = [(name, value) for name, value in self.figures if value]
        wide = max((len(name) for name, _ in rows), default=0)
        yield from (f"  {name:{wide}}  {value}" for name, value in rows)
        yield from self.table
        yield from warnings(self.warnings)
        if full:
            yield ""
            yield from self.full


def touching(engaged: float, beam: Beam) -> str:
    """Return the load angle (rad per pitch) at which scales touch as text; "never" for inf."""
    return f"at {turned(engaged, beam)}" if math.isfinite(engaged) else "never"


def largest_stress(stress: Array, beam: Beam) -> str:
    """Return the largest of the stresses (Pa) of all scales as text, with its share of the strength; "" without any."""
    most = float(stress.max())
    if not (math.isfinite(most) and most > 0):
        return ""
    share = f"; {percent(most / beam.scale.strength)} of its strength" if beam.scale.strength else ""
    return f"{figure(1e-6 * most, 'MPa')}, in scale {stress.argmax() + 1}{share}"


def percent(share: float) -> str:
    """Return a share in per cent, with three digits; "below 0.01 %" for less."""
    return "below 0.01 %" if 0 < share < 1e-4 else number(100 * share, "%")


def energy(per_length: float, beam: Beam) -> str:
    """Return an energy per length (J/m) as the text of the energy of the whole beam, or of a pitch."""
    factor, unit = energy_unit(per_length, beam)
    return figure(factor * per_length, unit)


def energy_unit(largest: float, beam: Beam) -> tuple[float, str]:
    """Return factor and unit for an energy per length (J/m): of the whole beam, or per pitch."""
    length, of = (beam.length, "") if beam.scales else (beam.pitch, " per pitch")
    factor, unit = joules(largest * length)
    return factor * length, f"{unit}{of}"


def joules(largest: float) -> tuple[float, str]:
    """Return factor and unit for an energy (J) that match those of a torque: mJ with N mm, J with N m."""
    factor, unit = torque_unit(largest)
    return factor, "mJ" if unit == "N mm" else "J"


def rigidity(value: float) -> str:
    """Return a rigidity or tangent stiffness (N m^2) as text."""
    factor, unit = rigidity_unit(value)
    return figure(factor * value, unit)


def modelled(beam: Beam, attrs: Mapping[str, Any], many: str = "") -> str:
    """Return the model of a result, its scales and the band of its torque as text; ``many``: words for the scales."""
    ends = attrs.get("ends", ENDLESS)
    many = many or ("endless beam" if ends == ENDLESS else f"{beam.extent} {ending(ends)}")
    held = "" if attrs.get("hold", NOTHING) == NOTHING else f"; {fixed(attrs)}"
    band = float(attrs.get("band", math.nan))
    # the accuracy of the joint's law is known in twisting only
    known = "error of the moment not known" if attrs["load"] == "bending" else f"torque to about {100 * band:.2g} %"
    return f"{model(attrs)}; {many}{held}{f'; {known}' if math.isfinite(band) else ''}"
