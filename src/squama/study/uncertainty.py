"""What tolerances do: Monte Carlo over the dimensions of a beam and its friction, through the batch engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from squama import api, checks, engines, units
from squama.design import Beam
from squama.model.outcome import CODES, End
from squama.model.solve import Array
from squama.study import uncertainty_indices, uncertainty_samples
from squama.study.uncertainty_indices import Indices
from squama.study.uncertainty_samples import LOCKS, MOST, NONE, REPLICATES, SAMPLERS, Case
from squama.study.uncertainty_statistics import Probability, Summary, probability, summary
from squama.study.uncertainty_tolerances import Tolerance, nominal, tolerances

if TYPE_CHECKING:
    import xarray as xr

LEVELS = (0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
SAMPLES, FEWEST = 2**17, 3200
BINS = 120
ENGAGED, LOCKED, BEFORE = "engaged", "locked", "locked before"
"""Properties of a sample, beside its figures, that have probabilities and Sobol indices."""
_TABLE = (
    ("load_e", "phi_e", "psi_e", "rad", "{} per pitch at engagement"),
    ("rate_e", "Phi_e", "kappa_e", "rad/m", "{} rate at engagement"),
    ("load_end", "phi_end", "psi_end", "rad", "{} per pitch at the end"),
    ("rate_end", "Phi_end", "kappa_end", "rad/m", "{} rate at the end"),
    ("torque", "T_c", "M_c", "N m", "load at the cut-off"),
    ("RED", "RED_c", "RED_c", "1", "relative energy dissipation at the cut-off"),
    ("U_el", "U_el_c", "U_el_c", "J/m", "elastic energy per length at the cut-off"),
    ("W_fr", "W_fr_c", "W_fr_c", "J/m", "frictional work per length at the cut-off"),
    ("stiffness", "K_0", "K_0", "N m2", "stiffness before contact"),
    ("stiffness_e", "K_e", "K_e", "N m2", "tangent stiffness right after engagement"),
)


class Figure(NamedTuple):
    """A figure of a sample: its role in the calculation, name, unit and meaning."""

    role: str
    name: str
    unit: str
    meaning: str


def figures_of(load: str) -> tuple[Figure, ...]:
    """Return the figures of a kind of loading."""
    bending = load == "bending"
    word = "bend" if bending else "twist"
    return tuple(Figure(r, b if bending else t, unit, text.format(word)) for r, t, b, unit, text in _TABLE)


class Before(NamedTuple):
    """Whether a beam locks before a twist: as given, its value and the figure it is compared with."""

    text: str
    value: float
    role: str
    locks: Probability
    ends: Probability


class Uncertain(NamedTuple):
    """What :func:`uncertainty` returns, before it is a dataset."""

    case: Case
    sampler: str
    seed: int
    samples: int
    levels: tuple[float, ...]
    summaries: dict[str, Summary]
    nominal: dict[str, float]
    nominal_end: str
    ends: dict[str, Probability]
    engaged: Probability
    locked: Probability
    before: Before | None
    edges: Array
    counts: Array
    indices: Indices | None
    kept: dict[str, Array]
    notes: tuple[str, ...]

    def dataset(self) -> xr.Dataset:
        """Return the same as an ``xarray.Dataset``."""
        from squama.study.uncertainty_dataset import dataset

        return dataset(self)


def uncertainty(
    beam: Beam,
    vary: Mapping[str, Any],
    *,
    before: float | str | None = None,
    mu: float | None = None,
    load: str = "twisting",
    law: str = "edge",
    sense: str = "+",
    margin: float = 0.01,
    samples: int = SAMPLES,
    sampler: str = "sobol",
    seed: int = 0,
    levels: Sequence[float] = LEVELS,
    indices: int = 0,
    keep: bool = False,
) -> xr.Dataset:
    """Say what the tolerances of a beam do to its engagement, end, torque and dissipation.

    Parameters
    ----------
    beam
        The nominal beam.
    vary
        Distributions by the names of the beam file, independent of each other: "60 deg +- 1 deg" (limits, every value
        between them equally likely), "+- 1 deg" (about the beam's own), "60 deg +- 1 deg triangular",
        "60 deg +- 2 deg 2 sd" (normal), "normal(0.25, 0.03)", "uniform(..)", "triangular(low, most likely, high)", or
        ``("normal", 0.25, 0.03)``; a spread may be in %. Limits must be possible for the parameter; a normal
        distribution is truncated to what is possible, and a note says how much that leaves out.
    before
        Twist (curvature in bending) for the probability of locking before it: a rate in rad/m or text such as
        "120 deg total", "0.2 rad/pitch". An angle per pitch or in total does not change with the pitch of a sample.
    mu
        Coefficient of friction in place of the beam's own.
    load, law, sense, margin
        As in :func:`squama.solve`.
    samples
        How many at least; Sobol points come as 32 sets of a power of two each, others as 32 equal sets.
    sampler
        "sobol" (scrambled Sobol points) or "random" (PCG64).
    seed
        The same seed gives the same samples, whatever the number of threads.
    levels
        Probabilities of the quantiles.
    indices
        Base number N of Sobol indices, a power of two such as 4096, or 0 for none: N (D + 2) more beams are solved for
        D tolerances. Needs the extra ``fit``.
    keep
        Whether the samples are part of the dataset.

    Returns
    -------
    xarray.Dataset
        Dimension ``figure``: ``mean``, ``sd``, ``quantile`` (by ``level``), each with its standard error ``*_se``,
        ``low``, ``high``, ``nominal``, ``units``, and ``share`` of the samples in which the figure exists, over which
        the statistics are. Dimension ``end``: ``probability``. Single figures: ``P_engaged``, ``P_locked``,
        ``P_locked_before``, ``P_ended_before``. Dimension ``bin``: ``count`` of the end twist, by ``end``. Dimension
        ``indexed``: ``S1``, ``ST`` by ``parameter``. Dimension ``sample``: dimensions and figures of each beam.

    Raises
    ------
    InputError
        A distribution or an argument cannot be used, or a sample is no beam: a line each.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(mu=0.3)
    >>> u = squama.uncertainty(beam, {"alpha": "+- 1 deg", "mu": "normal(0.3, 0.03)"}, samples=4096)
    >>> print(f"{float(u['mean'].sel(figure='phi_end')):.3f} +- {float(u['sd'].sel(figure='phi_end')):.3f} rad/pitch")
    0.283 +- 0.006 rad/pitch
    """
    return uncertain(
        beam, vary, before=before, mu=mu, load=load, law=law, sense=sense, margin=margin, samples=samples,
        sampler=sampler, seed=seed, levels=levels, indices=indices, keep=keep,
    ).dataset()  # fmt: skip


def uncertain(
    beam: Beam,
    vary: Mapping[str, Any],
    *,
    before: float | str | None = None,
    mu: float | None = None,
    load: str = "twisting",
    law: str = "edge",
    sense: str = "+",
    margin: float = 0.01,
    samples: int = SAMPLES,
    sampler: str = "sobol",
    seed: int = 0,
    levels: Sequence[float] = LEVELS,
    indices: int = 0,
    keep: bool = False,
    bare: bool = True,
) -> Uncertain:
    """Return what :func:`uncertainty` returns, before it is a dataset."""
    checks.one_of("load", load, ("twisting", "bending"))
    checks.law(law)
    checks.sense(sense)
    checks.one_of("sampler", sampler, SAMPLERS)
    margin = checks.scalar("margin", margin, 1e-12, 1.0, "at least 1e-12 and below 1")
    each = uncertainty_samples.size(checks.whole("samples", samples, FEWEST, MOST), sampler)
    seed = checks.whole("seed", seed, 0, 2**31)
    quantiles = _levels(levels, each)
    base = checks.whole("indices", indices, 0, 2**20)
    if base:
        if base < 64 or base & (base - 1):
            checks.fail(f"indices = {base}: must be 0 or a power of two from 64 to 1048576; write e.g. 4096")
        uncertainty_indices.needed()
    if mu is not None:
        beam = beam.replace(friction={"mu": mu})
    known = tuple(tolerances(vary, beam, bare=bare))
    if beam.friction.mu is None and "friction.mu" not in [t.name for t in known]:
        checks.fail("mu is not given: write mu = 0.25 under [friction] in the beam's file, or give mu or its tolerance")
    # one engine for all samples, however they are parted
    engine = engines.fastest(each * REPLICATES, load)
    case = Case(beam, known, load, law if load == "twisting" else "edge", sense, margin, engine)
    limit = None if before is None else _limit(before, case)

    found = _run(case, each, sampler, seed, keep)
    kept = {name: found.pop(name) for name in [n for n in found if "." in n]}
    code = found.pop("code")
    named = {f.role: f.name for f in figures_of(load)}
    summaries = {named[role]: s for role in named if (s := summary(found[role], quantiles, REPLICATES)) is not None}
    at = uncertainty_samples.figures(case, {t.name: np.array([nominal(t, beam)]) for t in known})
    ends = {str(e): probability(code == i, REPLICATES) for i, e in enumerate(CODES) if np.any(code == i)}
    edges, counts = _histogram(found["load_end"], code, ends)
    locks = np.isin(code, LOCKS)
    return Uncertain(
        case=case,
        sampler=sampler,
        seed=seed,
        samples=code.size,
        levels=quantiles,
        summaries=summaries,
        nominal={named[role]: float(at[role][0]) for role in named},
        nominal_end=str(CODES[int(at["code"][0])]),
        ends=ends,
        engaged=probability(code != NONE, REPLICATES),
        locked=probability(locks, REPLICATES),
        before=None if limit is None else _before(limit, found, code),
        edges=edges,
        counts=counts,
        indices=_indices(case, base, seed, limit) if base else None,
        kept={**kept, **{named[r]: found[r] for r in named}, "end": _words(code)} if keep else {},
        notes=tuple(_notes(case, named, summaries)),
    )


def _levels(levels: Sequence[float], each: int) -> tuple[float, ...]:
    given = np.atleast_1d(checks.numbers("levels", levels))
    if given.ndim != 1 or not given.size or np.any((given <= 0) | (given >= 1)) or np.any(np.diff(given) <= 0):
        checks.fail("levels: must be probabilities above 0 and below 1 that grow; write e.g. (0.05, 0.5, 0.95)")
    rare = float(min(given.min(), 1 - given.max()))
    if rare * each < 1:
        need = int(np.ceil(1 / rare)) * REPLICATES
        checks.fail(f"levels: a quantile of {rare:g} needs {need} samples or more, for its standard error")
    return tuple(float(v) for v in given)


def _limit(given: float | str, case: Case) -> tuple[str, float, str]:
    """Return the text, the value and the role of what a lock is compared with."""
    read = units.twist if case.load == "twisting" else units.curvature
    scales = case.beam.scales
    try:
        rate, other = (read(given, pitch=d, scales=scales) for d in (1.0, 2.0))
    except units.QuantityError as error:
        checks.fail(f"before = {error.shown}: {error.reason}")
    if rate <= 0:
        checks.fail(f'before = {units.shown(given)}: must be more than 0; write e.g. "0.2 rad/pitch"')
    text = given if isinstance(given, str) else f"{given:g} rad/m"
    # what depends on the pitch is an angle over it, or over all of them
    return text, rate, "rate_end" if rate == other else "load_end"


def _run(case: Case, each: int, sampler: str, seed: int, keep: bool) -> dict[str, Array]:
    """Return every figure of every sample by role, set after set; with ``keep`` the dimensions by name too."""
    found: dict[str, Array] = {}
    for place, points in uncertainty_samples.unit_points(len(case.tolerances), each, sampler, seed):
        dimensions = uncertainty_samples.values(case, points)
        part = uncertainty_samples.figures(case, dimensions)
        for name, v in {**part, **(dimensions if keep else {})}.items():
            if name not in found:
                found[name] = np.empty(each * REPLICATES, np.int8 if name == "code" else float)
            found[name][place] = v
    return found


def _before(limit: tuple[str, float, str], found: dict[str, Array], code: Array) -> Before:
    text, value, role = limit
    early = found[role] < value
    locks = np.isin(code, LOCKS)
    return Before(text, value, role, probability(early & locks, REPLICATES), probability(early & ~locks, REPLICATES))


def _histogram(load_end: Array, code: Array, ends: Mapping[str, Probability]) -> tuple[Array, Array]:
    """Return bins of the end twist, and the number of samples in each by end."""
    there = np.isfinite(load_end)
    shown = [CODES.index(End(e)) for e in ends if e != End.NONE]
    if not there.any():
        return np.zeros(0), np.zeros((0, 0), np.int64)
    low, high = float(load_end[there].min()), float(load_end[there].max())
    edges = np.linspace(low, high if high > low else low * (1 + 1e-9) + 1e-12, BINS + 1)
    return edges, np.array([np.histogram(load_end[code == i], edges)[0] for i in shown])


def _words(code: Array) -> Array:
    return np.array([str(e) for e in CODES])[code]


def _indices(case: Case, base: int, seed: int, limit: tuple[str, float, str] | None) -> Indices:
    figures = figures_of(case.load)

    def evaluate(points: Array) -> dict[str, Array]:
        parts = [
            uncertainty_samples.figures(
                case, uncertainty_samples.values(case, points[i : i + uncertainty_samples.CHUNK])
            )
            for i in range(0, len(points), uncertainty_samples.CHUNK)
        ]
        found = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        locks = np.isin(found["code"], LOCKS)
        named = {f.name: found[f.role] for f in figures}
        named |= {ENGAGED: (found["code"] != NONE).astype(float), LOCKED: locks.astype(float)}
        if limit is not None:
            named[BEFORE] = (locks & (found[limit[2]] < limit[1])).astype(float)
        return named

    return uncertainty_indices.indices(tuple(t.name for t in case.tolerances), base, seed, evaluate)


def _notes(case: Case, named: Mapping[str, str], summaries: Mapping[str, Summary]) -> list[str]:
    notes = [line for t in case.tolerances for line in t.notes]
    rare = [name for name in named.values() if name not in summaries]
    if rare:
        notes.append(f"no statistics of {', '.join(rare)}: too few samples have {'it' if len(rare) == 1 else 'them'}")
    if case.load == "twisting":
        mu = next((nominal(t, case.beam) for t in case.tolerances if t.name == "friction.mu"), case.beam.friction.mu)
        assert mu is not None
        e = api.ends(**case.beam.ratios, mu=mu, law=case.law, sense=case.sense, contacts="all")
        if e.other.item():
            notes.append(
                f"in the nominal beam another contact comes in at {float(e.phi_touch):.4g} rad/pitch "
                f"({e.other.item()}); samples follow the tip-side contact alone"
            )
    return notes


__all__ = ["Tolerance", "Uncertain", "uncertain", "uncertainty"]
