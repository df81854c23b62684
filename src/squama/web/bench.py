"""The beam that is shown as a part under load: a cantilever or a three-point bend, by :func:`squama.load`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama import arguments
from squama.errors import naming, refuse
from squama.units import Dimension, number, quantity, shown
from squama.web.state import State

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

CASES = {
    "cantilever": ("Cantilever, force at the tip", "clamped", "tip"),
    "three-point": ("Three-point bend, force in the middle", "simple", "middle"),
}
"""How a part is held and loaded: words, support, place of the force."""
WAYS = {"up": "up, towards the scales", "down": "down", "right": "to the side"}
"""Directions of the force."""
MOST = 60
"""Scales of a part that is loaded on the page."""
POINTS = 30


class Loaded(NamedTuple):
    """What a part does: sentences, and a picture (SVG) of its shape, its force over the travel and its scales."""

    words: tuple[str, ...]
    picture: str


def loaded(state: State, case: str, force: str, way: str) -> Loaded:
    """Load the beam of a state, with its friction and number of scales (25 pitches of an endless one).

    ``force`` has a unit, "0.2 N". Raises InputError: it cannot be so, or the part has more than 60 scales.
    """
    from squama.part.door import load
    from squama.plot.style import styled, written

    arguments.one_of("case", case, tuple(CASES))
    arguments.one_of("direction", way, tuple(WAYS))
    with naming("force"):
        newtons = quantity(force[:50], Dimension.FORCE, bare=False)
    if not 0 < newtons < math.inf:
        refuse("force", shown(force[:50]), "must be more than 0", 'write e.g. "0.2 N"')
    if state.beam.pitches > MOST:
        refuse("", "", f"the page loads at most {MOST} scales", "use squama load")
    _, support, place = CASES[case]
    data = load(
        state.beam, f"{newtons!r} N {way} at {place}", support=support, scales=state.beam.pitches, mu=state.mu,
        points=POINTS,
    )  # fmt: skip
    return Loaded(tuple(_words(data)), written(styled(_figure)(data), "svg").decode())


def _words(data: xr.Dataset) -> list[str]:
    """Say how far the part goes, what it bears, and where that is doubtful."""
    top = data.isel(point=int(data["share"].values.argmax()))
    newtons, travel, bare = (float(top[name]) for name in ("F", "travel", "F_bare"))
    ratio = newtons / bare if bare else math.nan
    stiffer = f", {ratio:.3g} times the force without contact" if math.isfinite(ratio) else ""
    if abs(ratio - 1) < 5e-3:
        stiffer = ", as without contact"
    engaged = float(data["share_e"])
    touch = f"the scales touch from {number(engaged * newtons / float(top['share']), 'N')} on"
    loads = top["N"].values
    most = f"scale {int(loads.argmax()) + 1} of {loads.size} bears most, {number(float(loads.max()), 'N')}"
    found = [f"{number(newtons, 'N')} at {number(1e3 * travel, 'mm')}{stiffer}"]
    found.append(f"{touch}; {most}" if math.isfinite(engaged) else "the scales do not touch")
    if float(top["share"]) < 1 - 1e-9:
        found.append(f"the part ends before all of the force: {data['end'].item()}")
    return found + [f"Warning: {line}" for line in str(data.attrs["warnings"]).splitlines() if line]


def _figure(data: xr.Dataset) -> Figure:
    """Draw the shape at some points, the force over the travel, and what each scale bears under all of the force."""
    from squama.plot import finite, style
    from squama.plot.palette import UNLOADED

    figure = style.new_figure(style.PAGE, 3.2)
    shape, curve, scales = figure.subplots(1, 3, width_ratios=(1.4, 1, 1))
    finite.shape(data, shape)
    finite.load_curve(data, curve)
    loads = data["N"].values[int(data["share"].values.argmax())]
    scales.bar(1 + np.arange(loads.size), loads, color=UNLOADED)
    scales.set(xlabel="Scale, from the root", ylabel="Contact force on a scale (N)", ylim=(0, None))
    return style.headline(figure, "", (shape, curve, scales))
