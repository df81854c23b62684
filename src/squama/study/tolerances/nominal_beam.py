"""The nominal beam of a tolerance study with its own number of scales; samples are endless beams."""

from __future__ import annotations

import math
from collections.abc import Sequence

from squama.curves import doors
from squama.errors import InputError
from squama.loads import ENDLESS, LOADS
from squama.study.columns import beam_at
from squama.study.parameters import FACTOR
from squama.study.tolerances.distributions import nominal
from squama.study.tolerances.statistics import Case


def figures(case: Case, names: Sequence[str]) -> tuple[str, list[float]]:
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
        one = beam_at(beam, "twisting", values)
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
