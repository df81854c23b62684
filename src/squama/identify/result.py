"""The result of a fit: a value with everything that follows from it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from squama._version import __version__
from squama.design import Beam
from squama.identify import separable, wording
from squama.identify.curve import curve
from squama.identify.data import Record
from squama.identify.forward import Forward
from squama.identify.parameters import Asked
from squama.identify.separable import Remedy
from squama.model.solve import Array

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, repr=False, eq=False)
class Fit:
    """Parameters of a beam found from a test.

    Attributes
    ----------
    beam : Beam
        The beam with the estimates put in.
    parameters : tuple of str
        Names of what was found; arrays over parameters are in this order.
    values, errors : dict of float
        Estimates and their standard errors, SI units.
    covariance, correlation : ndarray, shape (parameters, parameters)
        Of the estimates.
    noise : float
        Standard deviation of a torque, N m: from the residuals, or as given.
    rms : float
        Root mean square of the residuals of the points that were used, N m.
    residuals : ndarray, shape (points,)
        Measured less fitted torque, N m, of every point that the model covers; NaN elsewhere.
    fitted, band : ndarray, shape (points,)
        Fitted torque and its standard error, N m.
    branch : ndarray of str, shape (points,)
        "straight" (before engagement), "loading", "unloading" or "stick" (at a reversal).
    used : ndarray of bool, shape (points,)
        Which points the fit is made from; those of a reversal are not.
    condition : float
        Condition number of the derivatives to the parameters, columns scaled to one length.
    specimens : tuple of SpecimenFit
        Estimates from each specimen alone; empty for a single one.
    remedies : tuple of Remedy
        Further measurements, with the standard errors they would bring.
    notes : tuple of str
        What is to be known: parameters that are not separable, bounds that are reached, residuals that are not noise.
    posterior : Posterior or None
        Samples, if asked for.
    """

    beam: Beam
    initial: Beam
    load: str
    law: str
    asked: Asked
    record: Record
    forward: Forward
    estimates: Array
    covariance: Array
    noise: float
    given_noise: bool
    rms: float
    residuals: Array
    fitted: Array
    band: Array
    branch: NDArray[np.str_]
    used: NDArray[np.bool_]
    jacobian: Array
    starts: tuple[int, int]
    at_bound: NDArray[np.bool_]
    specimens: tuple[Any, ...]
    remedies: tuple[Remedy, ...]
    notes: tuple[str, ...]
    posterior: Any = None

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of what was found."""
        return self.asked.names

    @property
    def values(self) -> dict[str, float]:
        """Estimates by name, SI units."""
        return dict(zip(self.parameters, self.estimates.tolist(), strict=True))

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors by name, SI units."""
        return dict(zip(self.parameters, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the estimates."""
        return separable.correlations(self.covariance)

    @property
    def condition(self) -> float:
        """Condition number of the scaled derivatives."""
        return separable.condition(self.jacobian)

    def __repr__(self) -> str:
        shown = ", ".join(wording.estimate(self, name) for name in self.parameters)
        return f"Fit({shown}; {np.count_nonzero(self.used)} of {self.used.size} points, rms {self.rms:.3g} N m)"

    def summary(self) -> str:
        """Return estimates, errors, correlations and what is to be known about them, as text."""
        return wording.summary(self)

    def dataset(self) -> xr.Dataset:
        """Return everything as an ``xarray.Dataset``: dimensions ``point``, ``parameter``, ``curve``, ``sample``."""
        import xarray as xr

        twisting = self.load == "twisting"
        angle, rate, torque = ("phi", "Phi", "T") if twisting else ("psi", "kappa", "M")
        rec = self.record
        labels = np.array([s.label for s in rec.specimens])
        points = {
            "specimen": (labels[rec.specimen], "specimen", ""),
            "branch": (self.branch, "state in which the point was reached", ""),
            "used": (self.used, "whether the fit is made from the point", ""),
            angle: (rec.load, f"{wording.WORDS[self.load][0]} per pitch", "rad"),
            rate: (rec.load / self.beam.pitch, wording.WORDS[self.load][1], "rad/m"),
            torque: (rec.torque, f"measured {wording.WORDS[self.load][2]}", "N m"),
            f"{torque}_fit": (self.fitted, f"fitted {wording.WORDS[self.load][2]}", "N m"),
            f"{torque}_error": (self.band, f"standard error of the fitted {wording.WORDS[self.load][2]}", "N m"),
            "residual": (self.residuals, "measured less fitted", "N m"),
        }
        units = np.array([row.unit for row in self.asked.rows])
        every = {
            "estimate": (self.estimates, "estimate"),
            "error": (np.sqrt(np.diag(self.covariance)), "standard error"),
            "low": (self.asked.low, "lower bound"),
            "high": (self.asked.high, "upper bound"),
            "initial": (self.asked.start, "value in the beam as given"),
            "unit": (units, "unit of estimate, error and bounds"),
        }
        data: dict[str, Any] = {
            name: ("point", values, {"long_name": words, "units": unit})
            for name, (values, words, unit) in points.items()
        }
        data |= {name: ("parameter", values, {"long_name": words}) for name, (values, words) in every.items()}
        data["correlation"] = (("parameter", "other"), self.correlation, {"long_name": "correlation of the estimates"})
        data["rms"] = ((), self.rms, {"long_name": "root mean square of the residuals", "units": "N m"})
        data["noise"] = ((), self.noise, {"long_name": "standard deviation of a point", "units": "N m"})
        drawn = curve(self)
        data[f"{angle}_curve"] = ("curve", drawn.load, {"long_name": f"{angle} of the fitted curve", "units": "rad"})
        data[f"{torque}_curve"] = ("curve", drawn.torque, {"long_name": "fitted curve", "units": "N m"})
        words = {"long_name": "standard error of the fitted curve", "units": "N m"}
        data[f"{torque}_curve_error"] = ("curve", drawn.error, words)
        data["leg"] = ("curve", drawn.leg, {"long_name": "way between two reversals, counted from 1"})
        names = list(self.parameters)
        if self.posterior is not None:
            data["sample_value"] = (("sample", "parameter"), self.posterior.samples, {"long_name": "posterior sample"})
        attrs = {
            "title": f"parameters of a scale-covered beam from a test in {self.load}",
            "load": self.load,
            "law": self.law,
            "beam": self.beam.to_toml(),
            "initial_beam": self.initial.to_toml(),
            "estimates": ", ".join(wording.estimate(self, name) for name in names),
            "notes": "\n".join(self.notes),
            "remedies": json.dumps([{"what": r.what, "errors": r.errors.tolist()} for r in self.remedies]),
            "squama_version": __version__,
        }
        return xr.Dataset(data, coords={"parameter": names, "other": names}, attrs=attrs)
