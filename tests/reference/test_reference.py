"""twisting.json through the public functions: 40 designs, both laws, 1e-10 relative (they agree to some 1e-14)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import squama

RECORDED = json.loads((Path(__file__).parent / "twisting.json").read_text(encoding="utf-8"))
KEY = {"plate": "paper", "edge": "edge"}
ENDS = {
    "friction": "frictional lock",
    "kinematic": "kinematic lock",
    "edge-tip": "off tip edge",
    "edge-side": "off side edge",
}
FIELDS = ("phi", "p", "q", "dphi_dtheta", "dr_dtheta", "f0", "N0", "dT_over_K")


def relative(got: Any, want: Any) -> float:
    """Relative difference; absolute where a zero is wanted."""
    return float(np.max(np.abs(np.asarray(got, float) - np.asarray(want, float)) / scale(want)))


def scale(want: Any) -> Any:
    size = np.abs(np.asarray(want, float))
    return np.where(size > 0, size, 1.0)


def ratios(row: dict[str, Any]) -> dict[str, float]:
    return {name: row[name] for name in ("eta", "beta", "lam")} | {"alpha": np.radians(row["alpha_deg"])}


def expected(row: dict[str, Any], law: str) -> tuple[str, float, float]:
    """Return end, theta_end and phi_end in the package's words: the neighbour's contact comes before ours."""
    want = row[KEY[law]]
    if want["neighbour"] is not None:
        return "other contact", want["neighbour"]["theta"], want["neighbour"]["phi"]
    theta, phi = want["theta_end"], want["phi_end"]
    if want["end"] == "friction":
        if relative(np.radians(row["theta0_deg"]), theta) < 1e-13:
            return "static lock", theta, phi
        if row["mu"] == 0 and law == "edge":
            # both locks coincide, and the kinematic one is named
            return "kinematic lock", theta, phi
    return ENDS[want["end"]], theta, phi


@pytest.mark.parametrize("law", ["plate", "edge"])
@pytest.mark.parametrize("row", RECORDED, ids=range(len(RECORDED)))
def test_recorded_design(row: dict[str, Any], law: str) -> None:
    shape, theta0 = ratios(row), np.radians(row["theta0_deg"])
    e = squama.ends(**shape, theta0=theta0, mu=row["mu"], law=law)
    end, theta_end, phi_end = expected(row, law)
    assert (str(e.end), int(e.neighbour)) == (end, 1)
    assert relative(e.phi_e, row["phi_e"]) < 1e-10
    assert relative(e.theta_end, theta_end) < 1e-10
    assert relative(e.phi_end, phi_end) < 1e-10
    other = row[KEY[law]]["neighbour"]
    words = "" if other is None else f"tip edge C1B1 on side edge D{1 + other['k']}C{1 + other['k']}"
    assert words in str(e.other)
    assert bool(words) == bool(str(e.other))
    if "mid" not in row[KEY[law]]:
        assert end == "static lock"
        return
    mid = row[KEY[law]]["mid"]
    theta = float(mid["theta"])
    c = squama.contact(theta, **shape)
    f = squama.forces(theta, **shape, theta0=theta0, mu=row["mu"], law=law)
    got = (c.phi, c.p, c.s, c.dphi_dtheta, f.dr_dtheta, f.friction, f.normal, f.torque)
    worst = {name: relative(value, mid[name]) for name, value in zip(FIELDS, got, strict=True)}
    assert max(worst.values()) < 1e-10, worst
    assert c.on_edges


@pytest.mark.parametrize("law", ["plate", "edge"])
def test_all_recorded_designs_in_one_call(law: str) -> None:
    columns = {name: np.array([ratios(row)[name] for row in RECORDED]) for name in ratios(RECORDED[0])}
    theta0 = np.radians([row["theta0_deg"] for row in RECORDED])
    e = squama.ends(**columns, theta0=theta0, mu=[row["mu"] for row in RECORDED], law=law)
    end, theta_end, phi_end = zip(*(expected(row, law) for row in RECORDED), strict=True)
    assert e.end.tolist() == list(end)
    assert relative(e.theta_end, theta_end) < 1e-10
    assert relative(e.phi_end, phi_end) < 1e-10
    assert relative(e.phi_e, [row["phi_e"] for row in RECORDED]) < 1e-10


def test_the_record_holds_every_kind_of_end_it_is_said_to_hold() -> None:
    seen = {law: {expected(row, law)[0] for row in RECORDED} for law in KEY}
    assert seen["edge"] >= {"frictional lock", "kinematic lock", "off tip edge", "static lock", "other contact"}
    assert seen["plate"] >= {"frictional lock", "off tip edge", "static lock", "other contact"}
