"""Monte Carlo over the tolerances of a beam's dimensions, joint and friction.

Samples come in :data:`REPLICATES` independent sets; the scatter between the sets gives the standard error of every
statistic, for scrambled Sobol points and for random points. A sample depends on the seed and its number only, not on
chunks or threads.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from squama import arguments
from squama.arrays import edge_contacts
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.curves import doors
from squama.errors import InputError, refuse
from squama.joints.choice import shape
from squama.joints.law import errors, region
from squama.loads import ENDLESS, LOADS, JointName, LawName, LoadName, SenseName
from squama.model import mechanics
from squama.model.bending import Bend
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY
from squama.model.paths import Twist as Tip
from squama.people import per_pitch
from squama.progress import work
from squama.study import columns
from squama.study.models import Model, Twist, note, shares
from squama.study.parameters import FACTOR
from squama.study.tolerances import statistics
from squama.study.tolerances.distributions import Tolerance, nominal, tolerances
from squama.study.tolerances.statistics import KNOWN, REPLICATES, Case, Indices, Limit, dataset
from squama.types import Array
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

LEVELS = (0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
SAMPLES = {"hinge": 2**17, "compliant": 2**15}
"""Default number of samples, by the joint."""
FEWEST = 3200
CHUNK = 65_536
"""Samples that are computed at a time; each figure of a sample then takes 8 bytes."""
MOST = 2**24
SamplerName = Literal["sobol", "random"]
SAMPLERS: tuple[str, ...] = get_args(SamplerName)
_BITS = 30


def uncertainty(
    beam: Beam,
    vary: Mapping[str, object],
    *,
    joint: JointName | None = None,
    ideal: bool | None = None,
    at: float | str | None = None,
    before: float | str | None = None,
    mu: float | None = None,
    load: LoadName = "twisting",
    law: LawName = "edge",
    sense: SenseName = "+",
    margin: float = 0.01,
    samples: int | None = None,
    sampler: SamplerName = "sobol",
    seed: int = 0,
    levels: Sequence[float] = LEVELS,
    indices: int = 0,
    keep: bool = False,
    bare: bool = True,
) -> xr.Dataset:
    """Compute how the tolerances of a beam scatter its engagement, end, torque, stiffness and dissipation.

    Samples are endless beams; for a beam with a number of scales the nominal figures are also computed with all of
    them.

    Parameters
    ----------
    vary
        Distributions by the names of the beam file, independent of each other: "60 deg +- 1 deg" (limits, every value
        between them equally likely), "+- 1 deg" (about the beam's own), "60 deg +- 1 deg triangular",
        "60 deg +- 2 deg 2 sd" (normal), "normal(0.25, 0.03)", "uniform(..)", "triangular(low, most likely, high)", or
        ``("normal", 0.25, 0.03)``; a spread may be in %. Limits must be possible for the parameter; a normal
        distribution is truncated to what is possible, and a note says how much that leaves out. ``joint.factor``
        multiplies K_theta of a compliant joint; where that is by the law it scatters as far as the law was off.
    joint, ideal, at
        As in :func:`squama.sweep`: how scales are held and taken, and the twist at which figures are taken.
    before
        Twist (curvature in bending) for the probability that hinges lock before it: a rate in rad/m or text such as
        "120 deg total", "0.2 rad/pitch". An angle per pitch or in total does not change with the pitch of a sample.
    mu, load, law, sense, margin
        As in :func:`squama.solve`; the beam's own friction if not given.
    samples
        How many at least (32768; 131072 on hinges); Sobol points come as 32 sets of a power of two each, others as 32
        equal sets.
    sampler, seed
        "sobol" (scrambled Sobol points) or "random" (PCG64); the same seed gives the same samples on any threads.
    levels
        Probabilities of the quantiles.
    indices
        Base number N of Sobol indices, a power of two such as 4096, or 0 for none: N (D + 2) more beams are solved for
        D tolerances. Needs the extra ``fit``.
    keep, bare
        Whether the samples are part of the dataset; whether a number without a unit is SI.

    Returns
    -------
    xarray.Dataset
        Dimension ``figure``: ``mean``, ``sd``, ``quantile`` (by ``level``), each with its standard error ``*_se``,
        ``low``, ``high``, ``nominal``, ``units``, and ``share`` of the samples in which the figure exists, over which
        the statistics are; figures of compliant joints have the names of :func:`squama.sweep`. Of a beam with a number
        of scales ``own`` is the nominal beam with all of them: statistics times own over nominal are about theirs.
        Dimension ``end``: ``probability``. Single figures, of the samples whose joint is known: ``P_engaged``,
        ``P_strength``; on hinges ``P_locked``, ``P_locked_before``, ``P_ended_before``. Dimension ``bin``: ``count`` of
        the stiffness ratio (on hinges the end twist), by ``end``. Dimension ``indexed``: ``S1``, ``ST`` by
        ``parameter``. Dimension ``sample``: dimensions and figures of each beam.

    Raises
    ------
    InputError
        A distribution or an argument cannot be used, or a sample is no beam: a line each. More than a fifth of the
        samples lie outside the range of the law of the joint.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(mu=0.3)
    >>> vary = {"alpha": "+- 1 deg", "mu": "normal(0.3, 0.03)"}
    >>> u = squama.uncertainty(beam, vary, joint="hinge", samples=4096)
    >>> print(f"{float(u['mean'].sel(figure='phi_end')):.3f} +- {float(u['sd'].sel(figure='phi_end')):.3f} rad/pitch")
    0.283 +- 0.006 rad/pitch
    """
    arguments.beam(beam)
    arguments.load(load)
    arguments.law(law)
    arguments.sense(sense)
    arguments.one_of("sampler", sampler, SAMPLERS)
    margin = arguments.margin(margin)
    model = Model.chosen(beam, load, (law,), sense, joint, ideal, at)
    if not model.compliant:
        only_one(beam.faces, "tolerances on hinges")
    each = size(arguments.whole("samples", SAMPLES[model.joint] if samples is None else samples, FEWEST, MOST), sampler)
    seed = arguments.whole("seed", seed, 0, 2**31)
    quantiles = _levels(levels, each)
    base = arguments.whole("indices", indices, 0, 2**20)
    if base:
        if base < 64 or base & (base - 1):
            refuse("indices", str(base), "must be 0 or a power of two from 64 to 1048576", "write e.g. 4096")
        statistics.needed()
    if mu is not None:
        beam = beam.replace(friction={"mu": mu})
    known = tuple(tolerances(vary, beam, bare=bare, joint=model.joint, ideal=model.ideal))
    own = _of_law(beam, known, model)
    known += own
    if "friction.mu" not in [t.name for t in known]:
        arguments.friction(beam.friction.mu, None, "pass mu=0.3 or its tolerance")
    limit = None if before is None else _limit(before, load, beam, model)
    case = Case(beam, known, load, LOADS[load].law(law), sense, margin, quantiles, limit, sampler, seed, model)
    own_figures = solved(case, {t.name: np.array([nominal(t, beam)]) for t in known})
    samples_of = _run(case, _points(len(known), each, sampler, seed), REPLICATES * each, "samples", keep=keep)
    lost = float((samples_of["code"] == case.unknown).mean())
    if lost > 1 - KNOWN:
        reason = f"{100 * lost:.3g} % of the samples lie outside the range of the law of the joint"
        remedy = "make the tolerances narrower, move the beam away from the ends of that range, or give joint.matrix"
        refuse("tolerances", "", f"{reason}, at most {100 * (1 - KNOWN):.0f} % may", remedy)
    own_indices = _indices(case, base) if base else None
    found = dataset(case, samples_of, own_figures, own_indices, keep)
    ends, with_ends = _with_ends(case, found.figure.values.tolist())
    if ends:
        about = {"long_name": "value of the nominal beam with its own number of scales", "units": statistics.MIXED}
        found["own"] = ("figure", with_ends, about)
        found.attrs |= {"ends": ends, "own_scales": beam.pitches}
    notes = [*filter(None, [note(beam, load, (law,), joint)])]
    notes += [f"{t.name} = {t.text}: how far the law of the joint was off, added to what is given" for t in own]
    notes += _notes(case, found.figure.values.tolist(), samples_of["code"])
    if own_indices is not None and own_indices.figures and own_indices.known < own_indices.groups:
        counted = f"Sobol indices are of {own_indices.known} of {own_indices.groups} groups of samples"
        notes.append(f"{counted}; the other groups have beams that the law of the joint does not cover")
    found.attrs["notes"] = "\n".join(notes)
    return found


def _of_law(beam: Beam, known: Sequence[Tolerance], model: Model) -> tuple[Tolerance, ...]:
    """Return the scatter of K_theta from the joint's law; empty where K_theta is stated, measured or varied."""
    better = beam.joint.matrix is not None or beam.joint.stiffness is not None
    if not model.compliant or better or {t.name for t in known} & {FACTOR, "joint.stiffness"}:
        return ()
    rms = errors(region(shape(beam))).K_theta.rms
    return tuple(tolerances({FACTOR: ("normal", 1.0, rms)}, beam, joint=model.joint))


def _levels(levels: Sequence[float], each: int) -> tuple[float, ...]:
    given = np.atleast_1d(arguments.numbers("levels", levels))
    if given.ndim != 1 or not given.size or np.any((given <= 0) | (given >= 1)) or np.any(np.diff(given) <= 0):
        refuse("levels", "", "must be probabilities above 0 and below 1 that grow", "write e.g. (0.05, 0.5, 0.95)")
    rare = float(min(given.min(), 1 - given.max()))
    if rare * each < 1:
        need = int(np.ceil(1 / rare)) * REPLICATES
        refuse("levels", "", f"a quantile of {rare:g} needs {need} samples or more, for its standard error")
    return tuple(float(v) for v in given)


def _limit(given: float | str, load: str, beam: Beam, model: Model) -> Limit:
    if model.compliant:
        refuse("before", shown(given), "asks for a lock, and compliant joints have none", "give at, or take hinges")
    twist = Twist.read("before", given, load, beam)
    text = given if isinstance(given, str) else twist.words(beam.pitches)
    return Limit(text, twist.value, "rate_end" if twist.unit == "rad/m" else "load_end")


def _run(case: Case, chunks: Iterable[Array], total: int, what: str, *, keep: bool = False) -> dict[str, Array]:
    """Solve samples at points (n, parameters) of the unit cube, chunk by chunk; ``total``: their number, for progress.

    Returns figures (n,) by field, with ``keep`` also the dimensions by name.
    """
    parts, done = [], 0
    with work(what, total) as tell:
        for points in chunks:
            dimensions = {t.name: t.at(points[:, i]) for i, t in enumerate(case.tolerances)}
            parts.append(solved(case, dimensions) | (dimensions if keep else {}))
            tell(done := done + len(points))
    # figures leave the parts one by one, so that memory does not hold all of them twice
    return {name: np.concatenate([part.pop(name) for part in parts]) for name in list(parts[0])}


def _indices(case: Case, base: int) -> Indices:
    def evaluate(points: Array) -> tuple[dict[str, Array], Array]:
        parts = (points[i : i + CHUNK] for i in range(0, len(points), CHUNK))
        found = _run(case, parts, len(points), "samples of the indices")
        named = {f.name: found[f.role] for f in case.figures}
        properties = {name.replace("_", " "): has for name, (has, _) in case.properties(found).items()}
        # a beam that the joint's law does not cover has no figures
        return named | properties, found["code"] != case.unknown

    return statistics.indices(tuple(t.name for t in case.tolerances), base, case.seed, evaluate)


def _with_ends(case: Case, names: Sequence[str]) -> tuple[str, list[float]]:
    """Return the ends of the nominal beam in words, and its figures with all of its scales; NaN where unknown.

    Returns ("", []) for an endless beam, on hinges, and where not all scales are computed
    (:func:`squama.curves.doors.ends_of`).
    """
    beam, model = case.beam, case.model
    if model.at is None or beam.scales is None:
        return "", []
    load, at = LOADS[case.load], float(model.at.per_pitch(beam.pitch))
    try:
        values = {t.name: nominal(t, beam) for t in case.tolerances if t.name != FACTOR}
        one = columns.beam_at(beam, "twisting", values)
        at = float(model.at.per_pitch(one.pitch))
        how = doors.How(joint=model.joint, ideal=model.ideal)
        found = doors.respond(one, case.load, to=at / one.pitch, sense=case.sense, **how)
    except InputError:
        return "", []
    ends = str(found.attrs.get("ends", ENDLESS))
    if ends == ENDLESS:
        return "", []

    there = math.isclose(float(found[load.angle][-1]), at, rel_tol=1e-6)

    def figure(name: str) -> float:
        if name == "finite_ratio":
            return figure("torque") / float(found.along(f"{load.torque}_periodic")[-1]) if there else math.nan
        own = name.removeprefix("finite_")
        named = {"torque": load.torque, "tangent": load.tangent}.get(own, own)
        v = found.variables.get(named)
        if v is None:
            return float(found.attrs.get(name, math.nan))
        if "point" not in v.dims:
            return float(v.values)
        # a curve that ends before the twist has no figures there
        return float(found.along(named)[-1]) if there else math.nan

    return ends, [figure(name) for name in names]


def _notes(case: Case, summarised: Sequence[str], code: Array) -> list[str]:
    notes = [line for t in case.tolerances for line in t.notes]
    rare = [f.name for f in case.figures if f.name not in summarised]
    if rare:
        notes.append(f"no statistics of {', '.join(rare)}: too few samples have {'it' if len(rare) == 1 else 'them'}")
    limits = {t.name: tuple(t.at(np.array([2**-_BITS, 1 - 2**-_BITS])).tolist()) for t in case.tolerances}
    notes += columns.matrix_warnings(case.beam, "twisting" if case.model.compliant else case.load, limits)
    if case.model.compliant:
        notes += shares(np.bincount(code, minlength=len(case.ends)))
    elif LOADS[case.load].sided:
        mu = next((nominal(t, case.beam) for t in case.tolerances if t.name == "friction.mu"), case.beam.friction.mu)
        assert mu is not None
        e = edge_contacts.ends(**case.beam.ratios, mu=mu, law=case.law, sense=case.sense, contacts="all")
        if e.other.item():
            notes.append(
                f"in the nominal beam another contact comes in at {per_pitch(float(e.phi_touch))} "
                f"({e.other.item()}); samples follow the tip-side contact alone"
            )
    return notes


def size(wanted: int, sampler: str) -> int:
    """Return the samples per set for at least ``wanted`` in all: a power of two for Sobol points."""
    each = -(-wanted // REPLICATES)
    return 1 << (each - 1).bit_length() if sampler == "sobol" else each


def _points(dimensions: int, each: int, sampler: str, seed: int) -> Iterator[Array]:
    """Yield points strictly inside the unit cube, arrays (n, ``dimensions``), about a chunk at a time."""
    from scipy.stats.qmc import Sobol

    edge, together = 2.0 ** -(_BITS + 1), max(1, CHUNK // each)
    for first in range(0, REPLICATES, together):
        sets = []
        for r in range(first, min(first + together, REPLICATES)):
            rng = np.random.default_rng([seed, r])
            sobol = Sobol(dimensions, scramble=True, bits=_BITS, rng=rng) if sampler == "sobol" else None
            sets.append(rng.random((each, dimensions)) if sobol is None else sobol.random(each))
        points = np.clip(np.concatenate(sets), edge, 1 - edge)
        yield from (points[start : start + CHUNK] for start in range(0, len(points), CHUNK))


def solved(case: Case, dimensions: dict[str, Array]) -> dict[str, Array]:
    """Return figures of samples (n,) by field, from dimensions (n,) in SI units; refuse samples that are no beam."""
    c = case.model.cells(case.beam, case.load, dimensions)
    n = next(iter(dimensions.values())).size
    good = np.broadcast_to(columns.valid(c), n)
    if not good.all():
        here = {name: float(v[np.argmin(good)]) for name, v in dimensions.items()}
        try:
            columns.beam_at(case.beam, case.load, here)
            why = "its joint has no stiffness that is a number"
        except InputError as error:
            why = "; ".join(map(str, error.problems))
        reason = f"some samples are no valid beam; at {columns.at(here)}: {why}"
        refuse("tolerances", "", reason, "make the tolerances narrower")
    found = case.model.solved(
        case.beam, c, (n,), load=case.load, law=case.law, sense=case.sense, margin=case.margin, few=0
    )
    found["code"] = found["code"].astype(np.int8)
    if case.model.at is None:
        return _hinged(case, c, found)
    # figures are only taken up to the twist: an engagement beyond it, and an end there, are none
    to = case.model.at.per_pitch(c.d)
    found["load_e"] = np.where(found["load_e"] <= to, found["load_e"], np.nan)
    found["load_end"] = np.where(found["load_end"] < to, found["load_end"], np.nan)
    return found


def _hinged(case: Case, c: columns.Cells, si: dict[str, Array]) -> dict[str, Array]:
    """Return the figures of samples on hinges, from the solution ``si`` of :mod:`squama.study.hinge_columns`.

    ``stiffness`` (N m^2) is that without contact, ``stiffness_e`` that right after engagement (inf for a lock there),
    ``code`` that of the end. Other figures are NaN where scales do not engage.
    """
    found = {name: si[name] for name in ("load_e", "load_end", "torque", "RED", "U_el", "W_fr")}
    found |= {"rate_e": si["load_e"] / c.d, "rate_end": si["load_end"] / c.d}
    found["stiffness_e"] = c.rigidity + c.K * c.d * _engaged_slope(case, c, si["neighbour"])
    found = {name: np.where(si["code"] != CODES.index(End.NONE), v, np.nan) for name, v in found.items()}
    return {**found, "stiffness": np.broadcast_to(c.rigidity, si["code"].shape), "code": si["code"]}


def _engaged_slope(case: Case, c: columns.Cells, neighbour: Array) -> Array:
    """Return dT/dphi of the scales over K_theta right after engagement; inf where friction locks them there.

    At engagement the lift is zero, so the derivative of the torque has no other term.
    """
    row: Bend | Tip = Bend(c.eta, c.beta, c.lam, np.sin(c.alpha), np.cos(c.alpha), c.theta0)
    if LOADS[case.load].sided:
        sa = np.sin(c.alpha) * (-1 if case.sense == "-" else 1)
        thickness = 0.0 if case.model.ideal else c.sizes["scale"]["thickness"] / c.d
        row = Tip(c.eta, c.beta, c.lam, sa, np.cos(c.alpha), c.theta0, np.maximum(neighbour, 1), thickness)
    with np.errstate(all="ignore"):
        pt = row.point(c.theta0, case.law, ARRAY)
        D = mechanics.forces(pt, c.theta0, c.mu).D
        slope = (pt.theta_rate + c.mu * pt.slip_rate / D) * pt.theta_rate / pt.load_rate**2
    return np.asarray(np.where(D > 0, slope, np.inf))
