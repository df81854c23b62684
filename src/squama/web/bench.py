"""The displayed beam as a part under load, a cantilever or a three-point bend, by :func:`squama.load`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama import arguments
from squama.curves.chosen import idealisation
from squama.errors import naming, refuse
from squama.loads import HELD
from squama.model.outcome import SENTENCES, End
from squama.units import Dimension, number, quantity, shown
from squama.web.state import State

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

CASES = {
    "cantilever": ("Cantilever, force at the tip", "clamped", "tip"),
    "three-point": ("Three-point bend, force in the middle", "simple", "middle"),
}
"""Cases of a part: words, support, place of the force."""
WAYS = {"up": "up, towards the scales", "down": "down", "right": "to the side"}
"""Directions of the force."""
MOST = 25
"""Largest number of scales of a part on the page."""
POINTS = 16
"""Points of the curve."""
WHOLE = 0.999
"""Share of the force that counts as all of it."""


class Loaded(NamedTuple):
    """Result of a part under load: sentences, and a picture (SVG) of its shape, force over travel, and scales."""

    words: tuple[str, ...]
    picture: str


def followed(state: State, case: str, force: str, way: str) -> xr.Dataset:
    """Load the beam of a state, with its friction and number of scales (25 if endless), as :func:`squama.load`.

    ``force`` is a text with unit, "0.2 N". Raises InputError for an invalid argument, a beam on hinges, or more than 25
    scales.
    """
    from squama.part.door import load

    arguments.one_of("case", case, tuple(CASES))
    arguments.one_of("direction", way, tuple(WAYS))
    with naming("force"):
        newtons = quantity(force[:50], Dimension.FORCE, bare=False)
    if not 0 < newtons < math.inf:
        refuse("force", shown(force[:50]), "must be more than 0", 'write e.g. "0.2 N"')
    if state.beam.pitches > MOST:
        refuse("", "", f"the page loads at most {MOST} scales", "use squama load")
    if state.joint == "hinge":
        refuse("joint", shown(state.joint), "is not known of a part", "choose compliant")
    _, support, place = CASES[case]
    return load(
        state.beam, f"{newtons!r} N {way} at {place}", support=support, scales=state.beam.pitches, mu=state.mu,
        points=POINTS, ideal=state.ideal == "yes" or None,
    )  # fmt: skip


def told(data: xr.Dataset, state: State) -> Loaded:
    """Return sentences and picture for the beam of a state under load."""
    from squama.plot.style import styled, written

    return Loaded((_model(state), *_words(data)), written(styled(_figure)(data), "svg").decode())


def follows(state: State) -> tuple[object, ...]:
    """Return the values of a state on which a part under load depends."""
    return state.beam, state.mu, state.joint, state.ideal, state.bent


def _model(state: State) -> str:
    """Return a sentence on the part's model, and its differences from the displayed beam."""
    beam = state.beam
    scales = idealisation(beam, "compliant", ideal=state.ideal == "yes")
    more = [f"{scales} on {HELD['compliant']}"]
    more += ["cut from the endless beam that is shown"] * (beam.scales is None)
    more += ["without the held bend"] * state.bent
    return f"Part of {beam.pitches} scales: {'; '.join(more)}"


def _words(data: xr.Dataset) -> list[str]:
    """Return sentences on the travel, the largest contact force, and the warnings."""
    top = data.isel(point=int(data["share"].values.argmax()))
    newtons, travel, bare = (float(top[name]) for name in ("F", "travel", "F_bare"))
    ratio = newtons / bare if bare else math.nan
    stiffer = f", {number(ratio)} times the force without contact" if math.isfinite(ratio) else ""
    if abs(ratio - 1) < 5e-3:
        stiffer = ", as without contact"
    engaged = float(data["share_e"])
    touch = f"The scales touch from {number(engaged * newtons / float(top['share']), 'N')} on"
    loads = top["N"].values
    # the last scale has no neighbour
    borne = np.nan_to_num(loads)
    most = f"scale {int(borne.argmax()) + 1} of {loads.size} bears most, {number(float(borne.max()), 'N')}"
    found = [f"{number(newtons, 'N')} at {number(1e3 * travel, 'mm')}{stiffer}"]
    found.append(f"{touch}; {most}" if math.isfinite(engaged) else "The scales do not touch")
    if float(top["share"]) < WHOLE:
        asked = number(newtons / float(top["share"]), "N")
        found.append(f"The curve stops at {number(newtons, 'N')} of {asked}: {SENTENCES[End(data['end'].item())]}")
    return found + [f"Warning: {line}" for line in str(data.attrs["warnings"]).splitlines() if line]


def _figure(data: xr.Dataset) -> Figure:
    """Draw the shape at some points, the force over the travel, and the contact force on each scale under full load."""
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
