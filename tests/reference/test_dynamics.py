"""dynamics.json: 13 cases of free and forced vibration, each within its own tolerance."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import squama
from squama.arrays import solution
from squama.curves import hinge
from squama.curves.way import Case
from squama.dynamics import hinge_branches, motion
from squama.dynamics.branches import APART, Branch, Side
from squama.dynamics.decay import Sides, decay

CASES = json.loads((Path(__file__).parent / "dynamics.json").read_text(encoding="utf-8"))["cases"]
FREE = [c for c in CASES if c["case"][0] in "TB" and "peaks" in c]
FORCED = [c for c in CASES if c["case"][0] == "F"]


def named(name: str) -> list[dict]:
    return [c for c in CASES if c["case"].startswith(name)]


def ratios(case: dict) -> dict[str, Any]:
    given = {name: case[name] for name in ("eta", "beta", "lam", "mu", "kappa") if name in case}
    angles = {name: math.radians(case[f"{name}_deg"]) for name in ("alpha", "theta0") if f"{name}_deg" in case}
    bent = case["load"].startswith("bend") if "load" in case else "alpha_deg" not in case
    if bent:
        # edges across the beam, the length of the face kept
        given, angles = {**given, "beta": 1.0, "lam": 0.0}, {**angles, "alpha": 0.0}
    mode = next((mode for mode in ("simply supported", "cantilever") if mode in case["case"]), "uniform")
    return {**given, **angles, "load": "bending" if bent else "twisting", "mode": mode}


def path(case: dict) -> hinge.Path:
    """The solved path of a case."""
    r = {"beta": 1.0, "lam": 0.0, "alpha": 0.0, "kappa": 1.0, **ratios(case)}
    columns = {name: np.array([float(r[name])]) for name in solution.COLUMNS}
    sol = solution.solve(columns, load=r["load"], law="edge", sense="+")
    return hinge.path(Case(1.0, r["kappa"], 1.0, r["eta"], r["theta0"]), sol, None, r["mu"], "edge", 1e-6)


def side(case: dict) -> Side:
    """Branches of a case."""
    return hinge_branches.of_path(path(case), case["kappa"])


@pytest.mark.parametrize("case", FREE, ids=[c["case"] for c in FREE])
def test_a_decay_is_the_recorded_one(case: dict) -> None:
    v = squama.free_vibration(**ratios(case), amplitude=case["A0"], swings=len(case["peaks"]) - 1)
    tolerance = case["tolerance"]
    assert v.peaks == pytest.approx(case["peaks"], abs=tolerance)
    assert v.troughs == pytest.approx(case["troughs"], abs=tolerance)
    if "zeta_per_cycle" in case:
        assert v.zeta == pytest.approx(case["zeta_per_cycle"], abs=tolerance)
    if "period_first" in case:
        assert v.peak_times[1] == pytest.approx(case["period_first"], abs=tolerance)
    assert v.end.item() == "rings"


def test_an_impulse_leads_to_the_recorded_peak() -> None:
    (case,) = named("T7")
    v = squama.free_vibration(**ratios(case), impulse=case["v0"], swings=1)
    assert v.peaks[0] == pytest.approx(case["first_peak"], abs=case["tolerance"])
    assert v.peak_times[0] == pytest.approx(case["ode_time"], abs=case["tolerance"])


@pytest.mark.parametrize("case", named("S "), ids=[str(c["alpha_deg"]) for c in named("S ")])
def test_slopes_at_engagement(case: dict) -> None:
    way = path(case)
    at, wanted = np.array([way.x0]), [case["slope_plus"], case["slope_minus"]]
    slopes = [float(hinge.touching(way.row, "edge", at, mu)["tangent"][0]) for mu in (way.mu, -way.mu)]
    assert slopes == pytest.approx(wanted, rel=case["tolerance"])
    plateau = math.log((1 + slopes[0]) / (1 + slopes[1])) / (4 * math.pi)
    assert plateau == pytest.approx(case["zeta_plateau_kappa_1"], abs=case["tolerance"])
    # the splines that motion in time goes along
    found = side({**case, "kappa": 1.0})
    assert [float(b.force(found.y_e, 1)) for b in (found.up, found.falling(0.25))] == pytest.approx(wanted, rel=2e-7)


def test_piecewise_linear_scales_are_exact() -> None:
    (case,) = named("L ")
    y = np.linspace(case["y_e"], 0.4, 9)
    up, down = (Branch(y, case[f"slope_{name}_over_kappa"] * (y - y[0])) for name in ("plus", "minus"))
    sides = Sides(Side(y[0], 0.4, "", up, lambda _: down), APART)
    found = decay(sides, start=case["A0"], turns=2 * len(case["peaks"]) - 1).single()
    assert found.y[::2] == pytest.approx(case["peaks"], abs=case["tolerance"])
    assert found.y[1] == pytest.approx(case["first_trough"], abs=case["tolerance"])
    assert found.t[2] == pytest.approx(case["period_first"], abs=1e-11)


@pytest.mark.parametrize("case", FORCED, ids=[str(c["Omega"]) for c in FORCED])
def test_a_forced_state_is_the_recorded_one(case: dict) -> None:
    drive = motion.Drive(case["zeta_m"], case["F"], case["Omega"])
    found = motion.steady(Sides(side(case), APART), drive)
    assert found.settled
    # Newton's method finds the last digits
    assert found.periods < 45
    bare = case.get("amplitude", math.nan)
    high, low = case.get("y_max", bare), case.get("y_min", -bare)
    assert (found.high, found.low) == pytest.approx((high, low), abs=min(case["tolerance"], 1e-7))
    if "W_friction_cycle" in case:
        assert found.rubbed * case["kappa"] == pytest.approx(case["W_friction_cycle"], abs=1e-8)
    assert found.fed == pytest.approx(found.rubbed + found.damped, rel=1e-7)


@pytest.mark.slow
def test_two_states_at_one_frequency() -> None:
    """Beyond the frequencies recorded: the upper state goes on where the linear one, from rest, has come in."""
    case = next(c for c in FORCED if c["Omega"] == 1.3)
    for mu, recorded in ((case["mu"], {1.4: 0.1876, 1.45: 0.2083}), (0.05, {1.4: 0.0, 1.45: 0.0, 1.54: 0.0})):
        sides, y, v = Sides(side({**case, "mu": mu}), APART), 0.0, 0.0
        for omega, high in {1.3: 0.0, **recorded}.items():
            drive = motion.Drive(case["zeta_m"], case["F"], omega)
            state = motion.steady(sides, drive, y, v)
            y, v = state.y, state.v
            # tolerance: recorded with four decimals
            assert state.high == pytest.approx(high or state.high, abs=1e-4)
    rest = motion.steady(sides, drive)
    assert state.settled
    assert rest.settled
    assert state.high > 0.2
    assert rest.high == pytest.approx(drive.steady()[0], rel=1e-12)


def test_a_loop_of_bending_has_the_recorded_work() -> None:
    (case,) = named("W ")
    found = side({**case, "kappa": 1.0})
    work = found.up.work(0.16) - found.falling(0.16).work(0.16)
    assert float(work) == pytest.approx(case["W_d_over_K"], abs=10 * case["tolerance"])
