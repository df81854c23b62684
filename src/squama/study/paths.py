"""The paths of single beams of a sweep: inclination against load angle, without friction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from squama.design import Beam
from squama.errors import InputError
from squama.model import solution
from squama.model.paths import ARRAY
from squama.model.solve import Array
from squama.study.cells import cells
from squama.study.parameters import PARAMETERS, read_value
from squama.study.slices import Slice

POINTS = 200


def paths(part: Slice, texts: Sequence[str], *, bare: bool) -> dict[float, tuple[Array, Array]]:
    """Return load angle and inclination (rad) along the paths of beams, by their values of x.

    Friction and force law do not change a path, only where on it a lock comes: it is drawn up to its end at mu = 0.

    Parameters
    ----------
    part : Slice
        A slice with mu as y, so that all lines of it lie on the same paths.
    texts : sequence of str
        Values of x, within the range of the sweep or not.
    bare : bool
        Whether a number without a unit is SI.

    Raises
    ------
    InputError
        y is not mu, panels show other parameters, or a value is out of bounds.
    """
    if part.y != "mu" or part.panels not in (None, "law", "margin"):
        message = "paths: needs y = mu, and no panels but law and margin: else there is a path for each line"
        raise InputError(message)
    data = part.data
    load = data.attrs["load"]
    beam = Beam.from_toml_text(data.attrs["beam"])
    held = {str(n): float(data[n]) for n in data.coords if n in PARAMETERS and data[n].ndim == 0}
    at = np.array([read_value(part.x, text, bare=bare) for text in texts])
    c = cells(beam, load, held | {part.x: at})
    eta, beta, lam, alpha, theta0 = np.broadcast_arrays(c.eta, c.beta, c.lam, c.alpha, c.theta0, at)[:5]
    if load == "bending":
        found = solution.solve_bending(eta, theta0, np.zeros(at.size))
    else:
        sense = data.attrs["sense"]
        found = solution.solve_twisting(eta, beta, lam, alpha, theta0, np.zeros(at.size), law="edge", sense=sense)
    answer: dict[float, tuple[Array, Array]] = {}
    for index, track in found.tracks:
        x = track.x0 + (track.x_end - track.x0) * np.linspace(0, 1, POINTS)[:, None]
        with np.errstate(all="ignore"):
            pt = track.row.point(x, "edge", ARRAY)
        theta = np.broadcast_to(pt.theta, x.shape)
        for column, i in enumerate(index):
            answer[float(at[i])] = pt.load[:, column], theta[:, column]
    return answer
