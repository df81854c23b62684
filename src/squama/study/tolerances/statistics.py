"""Statistics of samples in independent sets, with standard errors; Sobol indices; the dataset that holds them.

A statistic is taken over all samples together, and over each of the R sets. The sets are independent and alike, so the
standard deviation of their statistics over the root of R is the standard error, for scrambled Sobol points and for
random points. For R = 32 this error is itself known to some 13 %; for Sobol points, with rare outliers, to a factor of
two.

Sobol indices give the share of a figure's variance due to each tolerance, alone (S1) and with all others (ST): by
Saltelli's scheme (Saltelli et al., Comput. Phys. Commun. 181 (2010) 259) as SALib draws and evaluates it, (D + 2) N
samples for D tolerances, with bootstrap confidence intervals. The samples come in N groups of D + 2, the members of
which differ in one tolerance each. Where some samples have no figures, only complete groups count. The remaining groups
are no longer drawn independently; this moved indices of test functions by up to 0.04 with a fifth of the groups missing
(0.02 with a tenth), so there are no indices where more are missing.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Hashable, Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama._version import __version__
from squama.beam.design import Beam
from squama.errors import refuse
from squama.loads import LOADS, LawName, SenseName
from squama.model.outcome import CODES, LOCKS
from squama.study.compliant_columns import ENDS, UNKNOWN
from squama.study.models import Model
from squama.study.parameters import PARAMETERS, canonical
from squama.study.plan import variables
from squama.study.tolerances.distributions import Tolerance
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

REPLICATES = 32
"""Number of independent sets of samples."""
LEAST = 20
"""Least number of samples with a figure in every set, for statistics of the figure."""
KNOWN = 0.8
"""Least share of samples whose joint is known for statistics, and of complete groups of samples for Sobol indices."""
RESAMPLES = 200
CONFIDENCE = 0.95


class Summary(NamedTuple):
    """Statistics of one figure over the samples in which it exists; ``*_se`` are standard errors.

    ``share`` of the samples in which it exists; ``quantile`` and ``quantile_se`` (levels,); ``low``, ``high`` smallest
    and largest value.
    """

    share: float
    mean: float
    mean_se: float
    sd: float
    sd_se: float
    quantile: Array
    quantile_se: Array
    low: float
    high: float


class Probability(NamedTuple):
    """Share of the samples with a property, its standard error, and the number of such samples."""

    value: float
    se: float
    number: int


def summary(x: Array, levels: Sequence[float], replicates: int) -> Summary | None:
    """Summarise a figure; None if some set has fewer than :data:`LEAST` values.

    Values x (n,) come set after set, not finite where the figure does not exist; ``levels``: probabilities of the
    quantiles.
    """
    sets = x.reshape(replicates, -1)
    there = np.isfinite(sets)
    counts = there.sum(axis=1)
    if counts.min() < LEAST:
        return None
    # missing values go to the end of their set
    ordered = np.sort(np.where(there, sets, np.inf), axis=1)
    parts = [row[:count] for row, count in zip(ordered, counts, strict=True)]
    whole = np.sort(ordered, axis=None)[: counts.sum()]
    of_sets = np.array([[p.mean(), p.std(ddof=1)] for p in parts])
    se = of_sets.std(axis=0, ddof=1) / np.sqrt(replicates)
    quantiles = np.quantile(whole, levels)
    quantiles_se = _quantile_errors(whole, parts, levels, quantiles)
    # a figure that is the same in all samples has no scatter, not that of rounding
    same = whole[0] == whole[-1]
    mean, sd = (float(whole[0]), 0.0) if same else (float(whole.mean()), float(whole.std(ddof=1)))
    se, quantiles_se = se * (not same), quantiles_se * (not same)
    share, (mean_se, sd_se) = float(counts.sum() / x.size), se.tolist()
    low, high = float(whole[0]), float(whole[-1])
    return Summary(share, mean, mean_se, sd, sd_se, quantiles, quantiles_se, low, high)


def _quantile_errors(whole: Array, parts: list[Array], levels: Sequence[float], quantiles: Array) -> Array:
    """Return standard errors of quantiles: the error of the share of samples below each, over the density there.

    (The quantiles of a small set of Sobol points scatter less than their share in the whole does.)
    """
    shares = np.array([np.searchsorted(p, quantiles) / p.size for p in parts])
    # a quantile is known only to lie between two samples
    of_share = np.maximum(shares.std(axis=0, ddof=1) / np.sqrt(len(parts)), 0.5 / whole.size)
    p = np.asarray(levels, float)
    above, below = (np.quantile(whole, np.clip(p + side * of_share, 0, 1)) for side in (1, -1))
    return np.asarray(above - below) / 2


def probability(has: Array, replicates: int, among: Array | None = None) -> Probability:
    """Return the share of samples ``has`` (n,), set after set, that have a property.

    ``among`` (n,): which samples count, some in every set; all if None. Where none or all of them have it the sets do
    not differ; the standard error is then that of one sample more or less, about 1/n.
    """
    counted = np.ones(has.shape, bool) if among is None else among
    has = has & counted
    n, count = int(np.count_nonzero(counted)), int(np.count_nonzero(has))
    if count in (0, n):
        p = (count + 1) / (n + 2)
        return Probability(count / n, float(np.sqrt(p * (1 - p) / n)), count)
    sizes = counted.reshape(replicates, -1).sum(axis=1)
    shares = has.reshape(replicates, -1).sum(axis=1) / sizes
    # a few samples spread over the sets scatter like any counts
    least = 0.0 if count * (n - count) / n > replicates else np.sqrt(count * (n - count) / n**3)
    return Probability(count / n, float(max(shares.std(ddof=1) / np.sqrt(replicates), least)), count)


class Indices(NamedTuple):
    """Sobol indices (figures, parameters) of the figures that have them; ``*_conf``: half widths of 95 % intervals.

    ``known`` of ``groups`` groups of samples are complete; ``left_out``: reason by figure without indices.
    """

    figures: tuple[str, ...]
    S1: Array
    S1_conf: Array
    ST: Array
    ST_conf: Array
    left_out: dict[str, str]
    known: int
    groups: int


def needed() -> None:
    """Refuse Sobol indices where SALib is not installed."""
    if find_spec("SALib") is None:
        refuse("Sobol indices", "", "SALib is not installed", "pip install squama[fit]")


def indices(
    names: tuple[str, ...], base: int, seed: int, evaluate: Callable[[Array], tuple[dict[str, Array], Array]]
) -> Indices:
    """Draw Saltelli's samples, evaluate them and return the indices.

    ``base`` is N, a power of two; ``evaluate`` takes points (n, parameters) of the unit cube and returns figures (n,)
    by name, not finite where one does not exist, and which samples (n,) the model covers. A figure that is missing in
    some covered samples, or does not vary, gets no indices; no figure does where too few groups are complete.
    ``left_out`` gives the reason.
    """
    from SALib.analyze import sobol as analyze
    from SALib.sample import sobol as sample

    problem: dict[str, object] = {"num_vars": len(names), "names": list(names), "bounds": [[0.0, 1.0]] * len(names)}
    with warnings.catch_warnings():
        # SALib passes arguments that SciPy and pandas warn of
        warnings.simplefilter("ignore")
        points = sample.sample(problem, base, calc_second_order=False, seed=np.random.default_rng([seed, base]))
        found, known = evaluate(points)
        whole = known.reshape(base, -1).all(axis=1)
        rows: dict[str, Mapping[str, Array]] = {}
        left_out: dict[str, str] = {}
        for name, every in found.items():
            values = every.reshape(base, -1)[whole].ravel().astype(float)
            if whole.mean() < KNOWN:
                left_out[name] = f"is known in {whole.mean():.2g} of the groups of samples only, {KNOWN:g} are needed"
                continue
            there = np.isfinite(values).mean()
            if there < 1:
                left_out[name] = f"exists in {there:.4g} of the samples only"
            elif np.ptp(values) <= 1e-12 * np.abs(values).max():
                left_out[name] = "does not vary"
            else:
                # a seed of 0 means none to SALib
                how = {"num_resamples": RESAMPLES, "conf_level": CONFIDENCE, "seed": seed + 1}
                rows[name] = analyze.analyze(problem, values, calc_second_order=False, **how)

    def table(key: str) -> Array:
        return np.array([rows[name][key] for name in rows], float).reshape(len(rows), len(names))

    counts = int(whole.sum()), base
    return Indices(tuple(rows), table("S1"), table("S1_conf"), table("ST"), table("ST_conf"), left_out, *counts)


# ---- the dataset -------------------------------------------------------------------------------------------

_FIGURES = (
    ("load_e", "load_e", "rad", "{} per pitch at engagement"),
    ("rate_e", "rate_e", "rad/m", "{} rate at engagement"),
    ("load_end", "load_end", "rad", "{} per pitch at the end"),
    ("rate_end", "rate_end", "rad/m", "{} rate at the end"),
    ("torque", "torque_c", "N m", "load at the cut-off"),
    ("RED", "RED_c", "1", "relative energy dissipation at the cut-off"),
    ("U_el", "U_el_c", "J/m", "elastic energy per length at the cut-off"),
    ("W_fr", "W_fr_c", "J/m", "frictional work per length at the cut-off"),
    ("stiffness", "K_0", "N m^2", "stiffness before contact"),
    ("stiffness_e", "K_e", "N m^2", "tangent stiffness right after engagement"),
)
BINS = 120
BINNED = {"hinge": "load_end", "compliant": "stiffness_ratio"}
"""Figure of the stored histogram, by the joint."""


class Limit(NamedTuple):
    """The twist before which locks are counted: text, value, and the field of the end twist in the same unit."""

    text: str
    value: float
    role: str


class Case(NamedTuple):
    """A tolerance study: the beam, its tolerances, load, model and statistics."""

    beam: Beam
    tolerances: tuple[Tolerance, ...]
    load: str
    law: LawName
    sense: SenseName
    margin: float
    levels: tuple[float, ...]
    limit: Limit | None
    sampler: str
    seed: int
    model: Model

    @property
    def ends(self) -> tuple[str, ...]:
        """Ends in words; the index is the code."""
        return ENDS if self.model.compliant else CODES

    @property
    def unknown(self) -> int:
        """Code of a sample whose joint the law does not cover; -1 on hinges."""
        return ENDS.index(UNKNOWN) if self.model.compliant else -1

    @property
    def figures(self) -> tuple[Figure, ...]:
        """Figures of a sample."""
        if self.model.compliant:
            stored = variables(self.model, self.load).items()
            known = [(v.field, name, v.attrs["units"], v.attrs["long_name"]) for name, v in stored if name != "end"]
            return tuple(Figure(*row) for row in known)
        of = LOADS[self.load]
        return tuple(Figure(role, of.variable(name), unit, text.format(of.verb)) for role, name, unit, text in _FIGURES)

    def properties(self, found: Mapping[str, Array]) -> dict[str, tuple[Array, str]]:
        """Return properties of samples by name: truth values (n,) and their description."""
        engaged = np.isfinite(found["load_e"])
        if self.model.compliant:
            has = {"engaged": (engaged, "scales engage before the twist")}
            if self.beam.scale.strength is not None or "scale.strength" in [t.name for t in self.tolerances]:
                has["strength"] = np.isfinite(found["load_strength"]), "a scale comes to its strength"
            return has
        locks = np.isin(found["code"], LOCKS)
        has = {"engaged": (engaged, "scales engage"), "locked": (locks, "the beam locks")}
        if self.limit is not None:
            early, text = found[self.limit.role] < self.limit.value, self.limit.text
            has["locked_before"] = early & locks, f"the beam locks before {text}"
            has["ended_before"] = early & ~locks, f"the curve ends before {text} without a lock"
        return has


class Figure(NamedTuple):
    """A figure of a sample: its field in the solution, name, unit and meaning."""

    role: str
    name: str
    unit: str
    meaning: str


MIXED = "as units(figure)"
_OF_FIGURES = {
    "mean": ("mean", MIXED),
    "mean_se": ("standard error of the mean", MIXED),
    "sd": ("standard deviation", MIXED),
    "sd_se": ("standard error of the standard deviation", MIXED),
    "low": ("smallest value", MIXED),
    "high": ("largest value", MIXED),
    "share": ("share of the samples in which the figure exists", "1"),
    "quantile": ("quantile", MIXED),
    "quantile_se": ("standard error of the quantile", MIXED),
}
_INDICES = {
    "S1": "first-order Sobol index",
    "S1_conf": "half width of its 95 % interval",
    "ST": "total Sobol index",
    "ST_conf": "half width of its 95 % interval",
}


def dataset(
    case: Case, found: Mapping[str, Array], nominal: Mapping[str, Array], found_indices: Indices | None, keep: bool
) -> xr.Dataset:
    """Return the dataset of statistics, probabilities, histogram, indices and samples, with names and units.

    ``found`` holds the figures of the samples by field, with ``keep`` also their dimensions by name; ``nominal`` the
    figures of the beam without tolerances.
    """
    import xarray as xr

    figures = case.figures
    summaries = {f: s for f in figures if (s := summary(found[f.role], case.levels, REPLICATES)) is not None}
    code, binned = found["code"], found[BINNED[case.model.joint]]
    known = code != case.unknown
    there = {str(e): code == i for i, e in enumerate(case.ends) if np.any(code == i)}
    coords: dict[Hashable, Any] = {
        "figure": [f.name for f in summaries],
        "level": list(case.levels),
        "end": list(there),
        "parameter": [t.name for t in case.tolerances],
    }
    data: dict[Hashable, object] = {}

    def put(name: str, dims: Sequence[str], values: object, words: str, unit: str | None = None) -> None:
        data[name] = (dims, np.asarray(values), {"long_name": words} | ({} if unit is None else {"units": unit}))

    for key, (words, unit) in _OF_FIGURES.items():
        dims = ["figure", "level"] if key.startswith("quantile") else ["figure"]
        values = np.array([getattr(s, key) for s in summaries.values()], float)
        put(key, dims, values.reshape([len(coords[dim]) for dim in dims]), words, unit)
    put("nominal", ["figure"], [float(nominal[f.role][0]) for f in summaries], "value of the nominal beam", MIXED)
    put("units", ["figure"], np.array([f.unit for f in summaries], "U8"), "unit of the figure")
    put("meaning", ["figure"], np.array([f.meaning for f in summaries], "U64"), "what it is")
    shares = [probability(has, REPLICATES) for has in there.values()]
    put("probability", ["end"], [p.value for p in shares], "share of the samples", "1")
    put("probability_se", ["end"], [p.se for p in shares], "its standard error", "1")
    for name, (has, words) in case.properties(found).items():
        p = probability(has, REPLICATES, known)
        put(f"P_{name}", [], p.value, f"probability that {words}", "1")
        put(f"P_{name}_se", [], p.se, "its standard error", "1")
    put("distribution", ["parameter"], [t.text for t in case.tolerances], "distribution of the parameter")
    about = {f.role: f for f in figures}
    finite = binned[np.isfinite(binned)]
    edges = np.zeros(1)
    if finite.size:
        low, high = float(finite.min()), float(finite.max())
        edges = np.linspace(low, high if high > low else low * (1 + 1e-9) + 1e-12, BINS + 1)
    of = about[BINNED[case.model.joint]]
    put("bin_low", ["bin"], edges[:-1], of.meaning, of.unit)
    put("bin_high", ["bin"], edges[1:], of.meaning, of.unit)
    # a sample without the figure is not counted
    counts = [np.histogram(binned[has & np.isfinite(binned)], edges)[0] for has in there.values()]
    put("count", ["end", "bin"], counts, f"samples by end and {of.meaning}", "1")
    if found_indices is not None:
        coords["indexed"] = list(found_indices.figures)
        for key, words in _INDICES.items():
            put(key, ["indexed", "parameter"], getattr(found_indices, key), words, "1")
    if keep:
        for name in coords["parameter"]:
            put(name, ["sample"], found[name], name, PARAMETERS[canonical(name)].symbol.unit)
        for f in figures:
            put(f.name, ["sample"], found[f.role], f.meaning, f.unit)
        # "end" is taken: the coordinate of the probabilities
        put("sample_end", ["sample"], np.array(case.ends, str)[code], "how the curve of the sample ends")
    attrs = {
        "title": f"uncertainty of a scale-covered beam in {case.load}",
        **{key: getattr(case, key) for key in ("load", "law", "sense")},
        **({} if case.model.compliant else {"margin": case.margin}),
        **case.model.attrs(case.beam),
        "samples": code.size,
        "known_samples": int(known.sum()),
        "sets": REPLICATES,
        **{key: getattr(case, key) for key in ("sampler", "seed")},
        "nominal_end": str(case.ends[int(nominal["code"][0])]),
        "tolerances": json.dumps({t.name: [t.kind, *t.numbers] for t in case.tolerances}),
        "without_indices": json.dumps(found_indices.left_out if found_indices else {}),
        "before": case.limit.text if case.limit else "",
        "before_figure": about[case.limit.role].name if case.limit else "",
        "beam": case.beam.to_toml(),
        "squama_version": __version__,
        "notes": "",
        "warnings": "\n".join(case.model.warnings(case.beam, case.load, case.sense)),
    }
    return xr.Dataset(data, coords, attrs)
