"""squama uncertainty: effect of tolerances on a beam, by Monte Carlo."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated

from squama.beam import beamfile
from squama.cli import flags, output
from squama.cli.flags import flag, one_of, pair, settled, whole
from squama.cli.output import Summary, energy_unit, modelled
from squama.errors import naming, refuse
from squama.io.files import label, read_text
from squama.loads import LOADS, THIN, ending
from squama.people import degrees, figure, readable, turned
from squama.units import for_people, number, torque_unit

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from squama.beam.design import Beam
    from squama.curves.bench import Bench
    from squama.study.tolerances.distributions import Tolerance
    from squama.study.tolerances.statistics import Probability

INFLUENCES = 4
"""Largest number of tolerances listed for a figure."""
_VARY = pair("name=tolerance", '--vary scale.alpha="60 deg +- 1 deg"')
_SHARES = {"engaged": "engagement", "locked": "locked", "strength": "strength reached"}
"""Single probabilities, and their words."""
_DRAWN = {"sobol": "scrambled Sobol points", "random": "random points (PCG64)"}
_FIGURE = ("meaning", "nominal", "share", "mean", "mean_se", "sd", "sd_se", "low", "high")
_TOLERANCE = 'Tolerance: scale.alpha="60 deg +- 1 deg" (limits), mu="normal(0.25, 0.03)"; may be repeated.'
_FILE = "TOML file with tolerances under [tolerance]; --vary takes precedence."
_BEFORE = 'Twist for which the probability of an earlier lock is computed (hinges), e.g. "120 deg total".'
_SAMPLER = "Samples: sobol (scrambled Sobol points) or random (PCG64). Default: sobol."
_SAMPLES = "Least number of beams. Default: 32768; on hinges 131072."
_INDICES = "Samples for Sobol indices, a power of two such as 4096; 0 for none (extra fit). Default: 0."


@flags.group
class Study(flags.How):
    """Settings of samples and model: arguments of :func:`squama.uncertainty`."""

    at: Annotated[str | None, flag(flags.AT)] = None
    before: Annotated[str | None, flag(_BEFORE)] = None
    samples: Annotated[int | None, flag(_SAMPLES, read=whole(3200, 1 << 24, "131072"))] = None
    sampler: Annotated[str, flag(_SAMPLER, read=one_of("sobol", "random"))] = "sobol"
    seed: Annotated[int, flag("Seed of the samples. Default: 0.", read=whole(0, 2**31, "7"))] = 0
    indices: Annotated[int, flag(_INDICES, read=whole(0, 2**20, "4096"))] = 0
    sense: flags.Sense = "+"


STUDY = Study()


def uncertainty(
    beam: flags.BeamFile,
    /,
    *,
    vary: Annotated[tuple[flags.Pair, ...], flag(_TOLERANCE, read=_VARY, many=True)] = (),
    tolerances: Annotated[flags.File | None, flag(_FILE)] = None,
    study: Study = STUDY,
    mu: flags.Mu = None,
    margin: flags.Margin = 0.01,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Compute what tolerances do to engagement, torque, stiffness, stress: Monte Carlo, Sobol indices."""
    if study.indices:
        from squama.study.tolerances import statistics

        if study.indices < 64 or study.indices & (study.indices - 1):
            flags.problems().add("--indices", str(study.indices), "is no power of two from 64 on", "write e.g. 4096")
        with flags.problems().caught():
            statistics.needed()
    common.check(beam, *([tolerances] if tolerances else []))
    described = common.beam(beam, mu, friction=False)
    given: Mapping[str, object] = {}
    if described is not None:
        given = _tolerances(vary, tolerances, described, study)
        if "friction.mu" not in given and not flags.problems():
            flags.check_friction(beam, described)
        for name, text in (("--before", study.before), ("--at", study.at)):
            flags.asked(name, text, described, study.load)
    described = settled(described)

    from squama.study.tolerances.monte_carlo import uncertainty as solve

    keep = bool(common.csv or common.netcdf)
    with flags.laid(flags.arguments("at", "before")):
        found = solve(described, given, margin=margin, keep=keep, bare=False, **vars(study))
    written = output.write(common, lambda: found, "uncertainty_figure", flat)
    nominal = _bench(found, described, given) if common.json or full else None
    said = _summary(found, described, nominal).shown(full=full)
    return output.report(common.json, beam, written, _record(found, nominal), said)


def _bench(u: xr.Dataset, beam: Beam, given: Mapping[str, object]) -> Bench | None:
    """Return the nominal beam with its comparisons at the twist of the figures; None for hinges."""
    if u.attrs["joint"] == "hinge":
        return None
    from squama.curves import bench, doors
    from squama.study.models import Twist
    from squama.study.tolerances.distributions import nominal, tolerances

    if beam.friction.mu is None:
        (friction,) = tolerances({"friction.mu": given["friction.mu"]}, beam, joint="compliant")
        beam = beam.replace(friction={"mu": nominal(friction, beam)})
    at, ideal = float(Twist.from_text(u.attrs["at"]).per_pitch(beam.pitch)), u.attrs["scales"] == THIN
    how = doors.How(joint="compliant", ideal=ideal)
    answer = doors.respond(beam, u.attrs["load"], to=at / beam.pitch, sense=u.attrs["sense"], **how)
    return bench.bench(beam, answer, ideal=ideal, at=at)


def _tolerances(vary: Iterable[flags.Pair], path: str | None, beam: Beam, study: Study) -> dict[str, object]:
    """Return the tolerances of flags and file, by names of the beam file; mistakes are collected."""
    from squama.curves.chosen import chosen
    from squama.study.tolerances.distributions import tolerances

    before, kind = len(flags.problems()), LOADS[study.load]
    means = chosen(beam, kind, law=kind.law(study.law), joint=study.joint, ideal=study.ideal, elements=False)
    read = partial(tolerances, beam=beam, bare=False, joint=means.joint, ideal=means.ideal)
    found = given_tolerances("--vary", vary, path, read)
    if not found and len(flags.problems()) == before and "--vary" not in flags.problems().flags:
        flags.problems().add("--vary", "", "no tolerance is given", 'write e.g. --vary scale.alpha="60 deg +- 1 deg"')
    return found


def given_tolerances(
    flag: str, pairs: Iterable[flags.Pair], path: str | None, read: Callable[[Mapping[str, object]], list[Tolerance]]
) -> dict[str, object]:
    """Return the tolerances of a file and of a flag, which takes precedence; mistakes are collected."""
    found: dict[str, object] = {}

    def add(group: Mapping[str, object]) -> None:
        # a distribution in SI units can be read again unchanged
        found.update({t.name: (t.kind, *t.numbers) for t in (read(group) if group else ())})

    if path is not None:
        with flags.problems().caught():
            table = tolerance_table(path)
            with naming(source=label(path)):
                add(table)
    given = flags.once(flag, pairs)
    with flags.problems().caught(), flags.laid({name: f"{flag} {name}" for name in given}):
        add(given)
    return found


def tolerance_table(path: str) -> dict[str, object]:
    """Return the table [tolerance] of a file."""
    name = label(path)
    text = read_text(path, missing='write one with [tolerance] and e.g. mu = "normal(0.25, 0.03)"')
    with naming(source=name):
        tables = beamfile.loads(text)
    found = tables.pop("tolerance", None)
    if tables or not isinstance(found, dict) or not found:
        what = f"holds {', '.join(tables)} too" if tables else "has no tolerances"
        refuse(name, "", what, 'write [tolerance] and under it lines such as scale.alpha = "60 deg +- 1 deg"')
    return found


def flat(dataset: xr.Dataset) -> xr.Dataset:
    """Return the samples only, a row each."""
    names = [name for name, v in dataset.variables.items() if v.dims == ("sample",)]
    return dataset[names].drop_vars([name for name in dataset[names].coords if name not in names])


def _share(u: xr.Dataset, name: str, of: str = "known_samples") -> Probability:
    from squama.study.tolerances.statistics import Probability

    value = float(u[name])
    return Probability(value, float(u[f"{name}_se"]), round(value * u.attrs[of]))


def _ends(u: xr.Dataset) -> dict[str, Probability]:
    return {str(end): _share(u.sel(end=end), "probability", "samples") for end in u["end"].values}


def _record(u: xr.Dataset, nominal: Bench | None = None) -> dict[str, object]:
    """Return the record for JSON, without the samples; ``nominal``: the nominal beam with its comparisons."""
    from squama.beam.design import Beam

    figures: dict[str, object] = {}
    for name in u["figure"].values:
        f = u.sel(figure=name)
        levels = zip(f["level"].values, f["quantile"].values, f["quantile_se"].values, strict=True)
        quantiles = [{"level": level, "value": value, "se": se} for level, value, se in levels]
        known = {key: f[key].item() for key in (*_FIGURE, *(["own"] if "own" in u else []))}
        figures[str(name)] = {"unit": f["units"].item(), **known, "quantiles": quantiles}
    before = u.attrs["before"] and {
        "twist": u.attrs["before"],
        "compared_with": u.attrs["before_figure"],
        "locked": _share(u, "P_locked_before")._asdict(),
        "ended_otherwise": _share(u, "P_ended_before")._asdict(),
    }
    indices: dict[str, object] | None = None
    if "S1" in u:
        table = u[["S1", "S1_conf", "ST", "ST_conf"]].reset_coords(drop=True).to_dataframe()
        indices = {str(figure): table.loc[figure].to_dict("index") for figure in u["indexed"].values}
        indices["without"] = json.loads(u.attrs["without_indices"])
    same = "load law joint scales at sense margin samples sampler seed nominal_end"
    return {
        **{key: u.attrs[key] for key in same.split() if key in u.attrs},
        "tolerances": {name: u["distribution"].sel(parameter=name).item() for name in u["parameter"].values},
        "chances": {name: p._asdict() for name, p in _ends(u).items()},
        **{name: _share(u, f"P_{name}")._asdict() for name in _SHARES if f"P_{name}" in u},
        "before": before or None,
        "statistics": figures,
        "indices": indices,
        "notes": u.attrs["notes"].splitlines(),
        "warnings": u.attrs["warnings"].splitlines(),
        "bench": nominal and nominal.record,
        "beam": Beam.from_toml_text(u.attrs["beam"]).model_dump(),
    }


def _summary(u: xr.Dataset, beam: Beam, nominal: Bench | None) -> Summary:
    """Return the summary: 5 and 95 % quantiles and probabilities; ``nominal``: the nominal beam and simpler ones."""
    from squama.study.models import Twist

    load, n, names = LOADS[u.attrs["load"]], u.attrs["known_samples"], u["figure"].values
    factor, unit = degrees(beam)
    own = ("finite_torque", "finite_stiffness_ratio") if "finite_torque" in names else ("torque", "stiffness_ratio")
    newton = torque_unit(float(u["nominal"].sel(figure=own[0]))) if own[0] in names else (1.0, "N m")
    rows = {
        f"{load.angle}_e": ("scales touch", factor, unit),
        f"{load.angle}_end": ("end of the curve", factor, unit),
        own[0]: (load.torque_words, *newton),
        own[1]: ("tangent stiffness", 1.0, "times that before contact"),
        "stress": ("largest stress in a scale", 1e-6, "MPa"),
    }
    spread = {name: _spread(u.sel(figure=name), *row[1:]) for name, row in rows.items() if name in names}
    name = next((name for name in (own[1], f"{load.angle}_end", f"{load.angle}_e") if name in spread), "")
    verdict = f"nine of ten beams: {rows[name][0]} {spread[name]}" if name else "too few beams have these figures"
    chances = [(words, _said(_share(u, f"P_{name}"), n)) for name, words in _SHARES.items() if f"P_{name}" in u]
    if text := u.attrs["before"]:
        chances.append((f"locked before {text}", _said(_share(u, "P_locked_before"), n)))
        other = _share(u, "P_ended_before")
        chances.append((f"ended otherwise before {text}", _said(other, n) if other.number else ""))
    at = turned(float(Twist.from_text(u.attrs["at"]).per_pitch(beam.pitch)), beam) if "at" in u.attrs else ""
    finite = f"; torque and stiffness of {beam.extent} {ending(u.attrs['ends'])}" if "own" in u else ""
    figures = [
        ("figures at", at),
        *((row[0], spread.get(name, "")) for name, row in rows.items()),
        *chances,
        ("beams", f"{u.attrs['samples']}, {_DRAWN[u.attrs['sampler']]}, seed {u.attrs['seed']}"),
        ("model", modelled(beam, u.attrs, f"endless beam{finite}")),
    ]
    notes = [f"note: {line}" for line in u.attrs["notes"].splitlines()]
    return Summary(verdict, figures, notes, u.attrs["warnings"], _all(u, beam, nominal))


def _spread(one: xr.Dataset, factor: float, unit: str) -> str:
    """Return the 5 and 95 % quantiles of a figure, and its nominal value, as text."""
    levels = [int(abs(one["level"].values - p).argmin()) for p in (0.05, 0.95)]
    low, high = (figure(factor * float(one["quantile"][i])) for i in levels)
    between = f"{low} to {high} {unit}" if low != high else f"{low} {unit} in all"
    return f"{between}; as designed {figure(factor * float(one['nominal']))}"


def _all(u: xr.Dataset, beam: Beam, nominal: Bench | None) -> Iterable[str | Table]:
    """Yield tolerances, the table of all figures, ends, and Sobol indices."""
    n = u.attrs["samples"]
    if nominal is not None:
        yield f"the nominal beam at {turned(nominal.at, beam)}:"
        yield from nominal.lines
    yield "tolerances:"
    yield from (f"  {t.parameter.item()} = {t.item()}" for t in u["distribution"])
    yield ""
    # the levels nearest to 5, 50 and 95 %
    picked = u.isel(level=sorted({int(abs(u["level"].values - p).argmin()) for p in (0.05, 0.5, 0.95)}))
    yield _figures(picked, beam)
    if "own" in u:
        of = " but for rows finite_..." if "finite_torque" in u["figure"].values else ""
        yield f"{_own(u)}: the nominal beam {ending(u.attrs['ends'])}; all other columns are endless{of}"
    spread = picked.isel(figure=(picked["sd"] != 0).values)
    shares = (spread[key] / spread["sd"] for key in ("mean_se", "quantile_se"))
    means, quantiles = (float(share.max()) if spread.sizes["figure"] else 0.0 for share in shares)
    errors = f"of the means up to {means:.2g} sd, of the quantiles shown up to {quantiles:.2g} sd"
    yield f"standard errors: {errors}; in: beams that have the figure"
    yield ""
    yield from (f"  {name}: {_said(p, n)}" for name, p in _ends(u).items())
    yield f"the nominal beam: {u.attrs['nominal_end']}"
    if "S1" in u:
        yield ""
        yield "share of the variance (total Sobol index, +- half a 95 % interval):"
        yield from _influences(u)


def _figures(u: xr.Dataset, beam: Beam) -> Table:
    """Return a table with a row per figure, in the units of the summary."""
    rows: list[list[str]] = []
    keys = (*(("own",) if "own" in u else ()), "nominal", "mean", "sd")
    for name in u["figure"].values:
        f = u.sel(figure=name)
        factor, unit = _unit(f["units"].item(), float(f["nominal"]), beam)
        # an inclination belongs to a scale, other angles to the beam
        factor, unit = (math.degrees(1), "deg") if name.startswith("theta") else (factor, unit)
        values = [*(float(f[key]) for key in keys), *f["quantile"].values]
        rows.append([name, unit, *(number(v * factor) for v in values), f"{100 * float(f['share']):.5g}"])
    names = [_own(u) if key == "own" else key for key in keys]
    head = ("figure", "unit", *names, *(f"{p * 100:g} %" for p in u["level"].values), "in %")
    return output.table(head, rows, left=2, gap=1)


def _own(u: xr.Dataset) -> str:
    """Return the column title of the nominal beam with its own number of scales."""
    return f"{u.attrs['own_scales']} scales"


def _unit(unit: str, value: float, beam: Beam) -> tuple[float, str]:
    """Return the unit in which texts show a figure, after its factor from SI."""
    if unit == "rad":
        return degrees(beam)
    if unit == "J/m":
        return energy_unit(value, beam)
    return readable(unit, value) if unit in ("N m", "N m^2") else for_people(unit)


def _said(p: Probability, n: int) -> str:
    """Return a probability with its standard error as text; the rule of three where none or all have the property."""
    if p.number == 0:
        return f"none of {n} beams (below {300 / n:.2g} % with 95 % confidence)"
    if p.number == n:
        return f"all of {n} beams (at most {300 / n:.2g} % do not, with 95 % confidence)"
    digits = max(0, -math.floor(math.log10(100 * p.se)) + 1) if p.se else 2
    return f"{100 * p.value:.{digits}f} % (standard error {100 * p.se:.2g} %)"


def _influences(u: xr.Dataset) -> Iterable[str]:
    for name in u["indexed"].values:
        on = u.sel(indexed=name)
        most = sorted(zip(-on["ST"].values, on["parameter"].values, on["ST_conf"].values, strict=True))[:INFLUENCES]
        yield f"  {name}: {', '.join(f'{one} {-s:.2f} +- {c:.2f}' for s, one, c in most if -s > 5e-3)}"
    yield from (f"  {name}: none, it {why}" for name, why in json.loads(u.attrs["without_indices"]).items())
