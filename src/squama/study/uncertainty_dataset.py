"""The result of :func:`squama.uncertainty` as a labelled dataset."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from squama._version import __version__
from squama.model.outcome import End
from squama.study.parameters import PARAMETERS, canonical
from squama.study.uncertainty_samples import REPLICATES

if TYPE_CHECKING:
    import xarray as xr

    from squama.study.uncertainty import Uncertain

_OF_FIGURES = {
    "mean": "mean",
    "mean_se": "standard error of the mean",
    "sd": "standard deviation",
    "sd_se": "standard error of the standard deviation",
    "low": "smallest value",
    "high": "largest value",
    "share": "share of the samples in which the figure exists",
}
_INDICES = {
    "S1": "first-order Sobol index",
    "S1_conf": "half width of its 95 % interval",
    "ST": "total Sobol index",
    "ST_conf": "half width of its 95 % interval",
}


def dataset(u: Uncertain) -> xr.Dataset:
    """Return statistics, probabilities, histogram, indices and samples with their names and units."""
    import xarray as xr

    from squama.study.uncertainty import figures_of

    about = {f.name: f for f in figures_of(u.case.load)}
    names = list(u.summaries)
    each = list(u.summaries.values())
    mixed = "as units(figure)"
    data: dict[str, Any] = {}
    for key, words in _OF_FIGURES.items():
        values = np.array([getattr(s, key) for s in each], float)
        data[key] = ("figure", values, {"long_name": words, "units": "1" if key == "share" else mixed})
    for key, words in (("quantile", "quantile"), ("quantile_se", "standard error of the quantile")):
        values = np.array([getattr(s, key.replace("quantile", "quantiles")) for s in each], float)
        data[key] = (("figure", "level"), values.reshape(len(names), -1), {"long_name": words, "units": mixed})
    nominal = np.array([u.nominal[name] for name in names], float)
    data["nominal"] = ("figure", nominal, {"long_name": "value of the nominal beam", "units": mixed})
    data["units"] = ("figure", np.array([about[n].unit for n in names], "U8"), {"long_name": "unit of the figure"})
    data["meaning"] = ("figure", np.array([about[n].meaning for n in names], "U64"), {"long_name": "what it is"})
    data |= _probabilities(u)
    data["distribution"] = (
        "parameter",
        np.array([t.text for t in u.case.tolerances]),
        {"long_name": "distribution of the parameter"},
    )
    load_end = next(f for f in about.values() if f.role == "load_end")
    attrs = {"units": load_end.unit, "long_name": load_end.meaning}
    data["bin_low"], data["bin_high"] = ("bin", u.edges[:-1], attrs), ("bin", u.edges[1:], attrs)
    coords: dict[str, Any] = {
        "figure": names,
        "level": list(u.levels),
        "end": list(u.ends),
        "parameter": [t.name for t in u.case.tolerances],
    }
    counts = np.zeros((len(u.ends), max(u.edges.size - 1, 0)), np.int64)
    engaged = [i for i, e in enumerate(u.ends) if e != End.NONE]
    counts[engaged] = u.counts
    data["count"] = (("end", "bin"), counts, {"long_name": "samples by end and end twist", "units": "1"})
    if u.indices is not None:
        coords["indexed"] = list(u.indices.figures)
        for key, words in _INDICES.items():
            data[key] = (("indexed", "parameter"), getattr(u.indices, key), {"long_name": words, "units": "1"})
    for name, values in u.kept.items():
        if name in about:
            attrs = {"units": about[name].unit, "long_name": about[name].meaning}
        elif name == "end":
            # the coordinate of the probabilities has that name
            attrs = {"long_name": "how the curve of the sample ends"}
        else:
            attrs = {"units": PARAMETERS[canonical(name)].symbol.unit, "long_name": name}
        data["sample_end" if name == "end" else name] = ("sample", values, attrs)
    return xr.Dataset(data, coords=coords, attrs=_attrs(u))


def _probabilities(u: Uncertain) -> dict[str, Any]:
    found: dict[str, Any] = {
        "probability": ("end", np.array([p.value for p in u.ends.values()]), _words("share of the samples")),
        "probability_se": ("end", np.array([p.se for p in u.ends.values()]), _words("its standard error")),
    }
    single = {"P_engaged": (u.engaged, "scales engage"), "P_locked": (u.locked, "the beam locks")}
    if u.before is not None:
        single["P_locked_before"] = (u.before.locks, f"the beam locks before {u.before.text}")
        single["P_ended_before"] = (u.before.ends, f"the curve ends before {u.before.text} without a lock")
    for name, (p, words) in single.items():
        found[name] = ((), p.value, _words(f"probability that {words}"))
        found[f"{name}_se"] = ((), p.se, _words("its standard error"))
    return found


def _words(text: str) -> dict[str, str]:
    return {"long_name": text, "units": "1"}


def _attrs(u: Uncertain) -> dict[str, Any]:
    return {
        "title": f"uncertainty of a scale-covered beam in {u.case.load}",
        "load": u.case.load,
        "law": u.case.law,
        "sense": u.case.sense,
        "margin": u.case.margin,
        "samples": u.samples,
        "sets": REPLICATES,
        "sampler": u.sampler,
        "seed": u.seed,
        "nominal_end": u.nominal_end,
        "tolerances": json.dumps({t.name: [t.kind, *t.numbers] for t in u.case.tolerances}),
        "without_indices": json.dumps(u.indices.left_out if u.indices else {}),
        "before": u.before.text if u.before else "",
        "beam": u.case.beam.to_toml(),
        "squama_version": __version__,
        "notes": "\n".join(u.notes),
        "warnings": "\n".join(u.case.beam.warnings(u.case.load)),
    }
