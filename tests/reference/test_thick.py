"""thick.json through the public functions: 15 designs of thick plates, edge law, 1e-12 relative."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import squama

RECORDED = json.loads((Path(__file__).parent / "thick.json").read_text(encoding="utf-8"))
SHAPE = ("eta", "beta", "lam", "alpha", "thickness")


@pytest.mark.parametrize("design", RECORDED, ids=range(len(RECORDED)))
def test_recorded_design(design: dict) -> None:
    shape = {name: float(design[name]) for name in SHAPE}
    theta = np.array([float(row["theta"]) for row in design["rows"]])
    want = {name: np.array([float(row[name]) for row in design["rows"]]) for name in design["rows"][0]}
    theta0, mu = float(design["theta0"]), float(design["mu"])
    c, f = squama.contact(theta, **shape), squama.forces(theta, **shape, theta0=theta0, mu=mu)
    got = {name: getattr(c, name) for name in ("phi", "p", "s", "dphi_dtheta")}
    got |= {"slip_rate": f.dr_dtheta, "N": f.normal / shape["eta"], "T": f.torque, "mu_lock": f.mu_lock}
    for name, values in got.items():
        np.testing.assert_allclose(values, want[name], rtol=1e-12, atol=1e-13, err_msg=name)
    e = squama.ends(**shape, theta0=theta0, mu=mu)
    assert float(e.phi_e) == pytest.approx(float(design["phi_e"]), rel=1e-13)
