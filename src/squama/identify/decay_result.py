"""The result of the fit of a decay: a value with what follows from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from squama._version import __version__
from squama.beam.design import Beam
from squama.curves.chosen import idealisation
from squama.dynamics.systems import Model
from squama.identify.unknowns import Estimated, Parameter
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False, eq=False)
class DecayFit(Estimated):
    """Parameters of a beam found from the record of a decay.

    ``beam`` has the estimates put in, with the rotor (in a mode the density) of the frequency that was found. Names of
    what was found are ``parameters``: what was asked for, then ``f_0`` (Hz), ``release`` (first turning point, rad per
    pitch), ``start`` (its time, s) and ``twist_zero`` (reading at rest, rad over the whole beam). In this order
    ``estimates``, ``covariance`` and ``correlation``, by name ``values`` and standard ``errors``, SI units.

    Arrays of one length, the points: ``t`` (s), ``angle`` measured, ``fitted`` (rad per pitch). ``noise`` of a point
    from its neighbours, ``rms`` of the residuals (rad per pitch); ``at_bound`` by parameter; ``notes`` what is to be
    known.
    """

    beam: Beam
    initial: Beam
    model: Model
    mode: str
    found: tuple[Parameter, ...]
    estimates: Array
    covariance: Array
    t: Array
    angle: Array
    fitted: Array
    noise: float
    at_bound: NDArray[np.bool_]
    notes: tuple[str, ...]

    @property
    def rows(self) -> tuple[Parameter, ...]:
        """What was found."""
        return self.found

    @property
    def rms(self) -> float:
        """Root mean square of the residuals, rad per pitch."""
        return math.sqrt(float(np.mean((self.angle - self.fitted) ** 2)))

    @property
    def attrs(self) -> dict[str, str]:
        """What the fit is made with, in words."""
        model = self.model
        return {
            "load": model.load.name,
            "law": model.law,
            "joint": model.joint,
            "scales": idealisation(self.beam, model.joint, ideal=model.ideal),
            "mode": self.mode,
            **({"faces": self.beam.faces} if self.beam.other else {}),
        }

    def report(self) -> dict[str, Any]:
        """Return the whole result as plain data, for JSON."""
        return {
            **self.attrs,
            "parameters": self._parameters(at_bound=self.at_bound),
            **{name: getattr(self, name) for name in ("correlation", "noise", "rms")},
            "points": {"t": self.t, "load": self.angle, "fitted": self.fitted},
            "notes": list(self.notes),
            "beam": self.beam.model_dump(),
            "squama_version": __version__,
        }

    def __repr__(self) -> str:
        return f"DecayFit({', '.join(self.lines)}; {self.t.size} points, rms {self.rms:.3g} rad/pitch)"

    def summary(self) -> str:
        """Return estimates, errors, correlations and what is to be known about them, as text."""
        sizes = f"residual rms {self.rms:.3g} rad/pitch, noise of a point {self.noise:.3g} rad/pitch"
        return "\n".join([*self._described(), f"{sizes}; {self.t.size} points", *(f"note: {n}" for n in self.notes)])

    def dataset(self) -> xr.Dataset:
        """Return everything as an ``xarray.Dataset``: dimensions ``point`` and ``parameter``."""
        load = self.model.load
        return self._labelled(
            f"decay in {load.name}",
            {
                "t": ("point", self.t, "time", "s"),
                load.angle: ("point", self.angle, load.angle_words, "rad"),
                f"{load.angle}_fit": ("point", self.fitted, f"fitted {load.angle}", "rad"),
                "noise": ("", self.noise, "noise of a point", "rad"),
            },
            {**self.attrs, "notes": "\n".join(self.notes)},
        )

    def plot(self) -> Figure:
        """Draw the record, the fitted motion and the residuals, see :func:`squama.plot.decay_figure`."""
        from squama.plot import decay_figure

        drawn: Figure = decay_figure(self.dataset())
        return drawn
