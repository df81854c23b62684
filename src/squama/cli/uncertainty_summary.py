"""The result of ``squama uncertainty`` for people, and as JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squama.cli.summary import number

if TYPE_CHECKING:
    from squama.study.uncertainty import Uncertain
    from squama.study.uncertainty_statistics import Probability

SHOWN_LEVELS = 3
INFLUENCES = 4
"""Tolerances that are named for a figure at most."""


def record(file: str, u: Uncertain, written: Sequence[Path]) -> None:
    """Print everything but the samples as JSON."""
    from squama.cli import record as json
    from squama.study.uncertainty import figures_of

    about = {f.name: f for f in figures_of(u.case.load)}
    figures = {
        name: {
            "unit": about[name].unit,
            "meaning": about[name].meaning,
            "nominal": u.nominal[name],
            **{key: value for key, value in s._asdict().items() if not key.startswith("quantiles")},
            "quantiles": [
                {"level": p, "value": q, "se": se}
                for p, q, se in zip(u.levels, s.quantiles, s.quantiles_se, strict=True)
            ],
        }
        for name, s in u.summaries.items()
    }
    before = None
    if u.before is not None:
        before = {
            "twist": u.before.text,
            "compared_with": {f.role: f.name for f in about.values()}[u.before.role],
            "locked": u.before.locks._asdict(),
            "ended_otherwise": u.before.ends._asdict(),
        }
    indices: dict[str, Any] | None = None
    if u.indices is not None:
        rows = zip(*u.indices[:5], strict=True)
        names = [t.name for t in u.case.tolerances]
        indices = {
            figure: {
                name: {"S1": a, "S1_conf": b, "ST": c, "ST_conf": d}
                for name, a, b, c, d in zip(names, *values, strict=True)
            }
            for figure, *values in rows
        }
        indices = {**indices, "without": u.indices.left_out}
    json.show(
        {
            "file": file,
            **{key: getattr(u.case, key) for key in ("load", "law", "sense", "margin")},
            **{key: getattr(u, key) for key in ("samples", "sampler", "seed")},
            "tolerances": {t.name: t.text for t in u.case.tolerances},
            "nominal_end": u.nominal_end,
            "ends": {name: p._asdict() for name, p in u.ends.items()},
            "engaged": u.engaged._asdict(),
            "locked": u.locked._asdict(),
            "before": before,
            "figures": figures,
            "indices": indices,
            "notes": list(u.notes),
            "warnings": u.case.beam.warnings(u.case.load),
            "beam": u.case.beam.model_dump(),
            "written": [str(path) for path in written],
        }
    )


def show(file: str, u: Uncertain, written: Sequence[Path]) -> None:
    """Print the summary."""
    from rich.console import Console
    from rich.table import Table

    from squama.files import label
    from squama.study.uncertainty import figures_of

    console = Console(highlight=False, markup=False, emoji=False)
    console = Console(highlight=False, markup=False, emoji=False, width=max(console.width, 100))
    law = f", {u.case.law} law" if u.case.load == "twisting" else ""
    points = {"sobol": "scrambled Sobol points", "random": "random points (PCG64)"}[u.sampler]
    console.print(
        f"{file} in {u.case.load}{law}: {u.samples} beams, {points}, seed {u.seed}", style="bold", soft_wrap=True
    )
    for t in u.case.tolerances:
        console.print(f"  {t.name} = {t.text}", soft_wrap=True)
    console.print()
    picked = _picked(u.levels)
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    for name in ("figure", "unit", "nominal", "mean", "sd", *(f"{u.levels[i] * 100:g} %" for i in picked), "in"):
        table.add_column(name, header_style="bold", justify="left" if name in ("figure", "unit") else "right")
    worst = [0.0, 0.0]
    total = u.case.beam.scales * 180 / math.pi
    for f in figures_of(u.case.load):
        if f.name not in u.summaries:
            continue
        s = u.summaries[f.name]
        rows = [(f.name, f.unit if f.unit != "1" else "", 1.0)]
        if f.role in ("load_e", "load_end"):
            rows = [(f.name, "rad/pitch", 1.0), ("  in total", "deg", total)]
        for name, unit, factor in rows:
            values = [u.nominal[f.name], s.mean, s.sd, *(s.quantiles[i] for i in picked)]
            table.add_row(name, unit, *(number(v * factor) for v in values), f"{s.share:.4g}")
        if s.sd:
            worst = [
                max(worst[0], s.mean_se / s.sd),
                max(worst[1], float(max(s.quantiles_se[i] for i in picked)) / s.sd),
            ]
    console.print(table)
    lines = [
        f"standard errors: of the means up to {worst[0]:.2g} sd, of the quantiles shown up to {worst[1]:.2g} sd; "
        "in: share of the beams that have the figure",
        "",
        f"engagement: {_share(u.engaged, u.samples)}; locked: {_share(u.locked, u.samples)}",
        *(f"  {name}: {_share(p, u.samples)}" for name, p in u.ends.items()),
        f"the nominal beam: {u.nominal_end}",
    ]
    if u.before is not None:
        lines.append(f"locked before {u.before.text}: {_share(u.before.locks, u.samples)}")
        if u.before.ends.number:
            lines.append(f"ended otherwise before {u.before.text}: {_share(u.before.ends, u.samples)}")
    if u.indices is not None:
        lines += ["", "share of the variance (total Sobol index, +- half a 95 % interval):"]
        lines += _influences(u)
    lines += [f"note: {line}" for line in u.notes]
    lines += [f"warning: {line}" for line in u.case.beam.warnings(u.case.load)]
    lines += [f"wrote {label(place)}" for place in written]
    for line in lines:
        console.print(line, soft_wrap=True)


def _picked(levels: Sequence[float]) -> list[int]:
    """Return the levels nearest to 5, 50 and 95 %."""
    return sorted({int(np.argmin(np.abs(np.array(levels) - p))) for p in (0.05, 0.5, 0.95)})


def _share(p: Probability, n: int) -> str:
    """Return a probability with its standard error; the rule of three where none or all have the property."""
    if p.number == 0:
        return f"none of {n} beams (below {3 / n:.2g} with 95 % confidence)"
    if p.number == n:
        return f"all of {n} beams (above 1 - {3 / n:.2g} with 95 % confidence)"
    digits = max(0, -math.floor(math.log10(100 * p.se)) + 1) if p.se else 2
    return f"{100 * p.value:.{digits}f} % (standard error {100 * p.se:.2g} %)"


def _influences(u: Uncertain) -> list[str]:
    assert u.indices is not None
    names = [t.name for t in u.case.tolerances]
    lines = []
    for i, figure in enumerate(u.indices.figures):
        order = np.argsort(-u.indices.ST[i])[:INFLUENCES]
        parts = [f"{names[j]} {u.indices.ST[i, j]:.3f} +- {u.indices.ST_conf[i, j]:.3f}" for j in order]
        lines.append(
            f"  {figure}: {', '.join(p for p, j in zip(parts, order, strict=True) if u.indices.ST[i, j] > 5e-4)}"
        )
    lines += [f"  {figure}: none, it {why}" for figure, why in u.indices.left_out.items()]
    return lines
