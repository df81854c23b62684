"""What squama cell prints and draws of a finite beam."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


def announce(text: str) -> None:
    """Say on standard error how large a run is."""
    print(text, file=sys.stderr, flush=True)


def write(data: xr.Dataset, plot: tuple[str, ...], csv: str | None, netcdf: str | None) -> list[Path]:
    """Write pictures and files; return their places."""
    from squama import store

    written: list[Path] = []
    if plot:
        from squama.plot import save_figure
        from squama.plot.finite import finite_figure

        figure = finite_figure(data)
        written += [save_figure(figure, path) for path in plot]
    if csv is not None:
        # a table has one shape: what belongs to a point stands in the line of each of its scales
        along = {name: v.broadcast_like(data["theta"]) for name, v in data.data_vars.items() if v.dims == ("point",)}
        written.append(store.save(data.assign(along), csv))
    if netcdf is not None:
        written.append(store.save(data, netcdf))
    return written


def show(file: str, data: xr.Dataset, written: list[Path]) -> None:
    """Print the summary of a finite beam: its torque, and the scales at the ends and in the middle."""
    from rich.console import Console

    from squama import files
    from squama.cli.summary import moment, number

    console = Console(highlight=False, markup=False, emoji=False)
    last, n = data.isel(point=-1), data.sizes["scale"]
    blocked = "roll and yaw blocked, " if "blocked" in data.attrs["joint"] else ""
    along = "free to move along the axis" if data.attrs["ends"] == "free" else "held along the axis"
    lines = [
        f"{data.attrs['sentence']}",
        f"phi = {number(float(last['phi']), 'rad/pitch')}, Phi = {number(float(last['Phi']), 'rad/m')}, means over "
        "the beam",
        f"torque T = {moment(float(last['T']))}; the turned end is {along}",
    ]
    for i in sorted({0, (n - 1) // 2, n - 1}):
        one = last.isel(scale=i)
        contact = ""
        if i < n - 1:
            contact = f", N = {number(float(one['N']), 'N')}, f = {number(float(one['f']), 'N')} on scale {i + 2}"
        lines.append(
            f"scale {i + 1}: theta = {number(math.degrees(float(one['theta'])), 'deg')}, twist of its pitch "
            f"{number(float(one['twist']), 'rad')}{contact}"
        )
    lines.append(f"energy balance: (W - U_el - W_fr)/W = {data.attrs['energy_error']:.2e}")
    lines += [f"warning: {line}" for line in data.attrs["warnings"].splitlines()]
    before = ""
    for phi, words in zip(data["phi"].values, data["contact"].values, strict=True):
        if words != before:
            lines.append(f"from phi = {phi:.4g}: {words or 'no contact'}")
            before = words
    lines += [f"wrote {files.label(place)}" for place in written]
    console.print(
        f"{file} by finite elements, {n} scales: mu = {float(data['mu']):g}, sense {data.attrs['sense']}, {blocked}"
        f"{data.attrs['mesh']}",
        style="bold",
        soft_wrap=True,
    )
    for line in lines:
        console.print(line, soft_wrap=True)
