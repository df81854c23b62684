"""One load imposed, the other free: independent figures, the onset, and the line on which two contacts share."""

import json
from pathlib import Path

import numpy as np
import pytest

from squama.model.screw_free import relaxed
from squama.model.screw_path import Design, followed

FILE = Path(__file__).parents[1] / "reference" / "combined.json"
CASES = [c for c in json.loads(FILE.read_text())["cases"] if "rows_psi_phi_theta_valid" in c]
MAIN = Design(3.0, 1.25, 0.45, np.radians(45), np.radians(10), 0.0)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("case", CASES, ids=[case["id"] for case in CASES])
def test_bent_and_free_to_twist_it_is_the_reference(case):
    one = {k: float(v) for k, v in case["design"].items()}
    design = Design(one["eta"], one["beta"], one["lam"], one["alpha"], one["theta0"], 0.0, one["neutral_height"])
    rows = np.array([[float(v) for v in row[:3]] for row in case["rows_psi_phi_theta_valid"]])
    valid = np.array([row[3] for row in case["rows_psi_phi_theta_valid"]])
    bar = float(case["bar_torsion"])
    f = relaxed(design, rows[:, 0], bar, free=1)
    # the reference follows corner B on the face, also where a base contact has come in
    alone = f.contact == "BF"
    assert alone.any()
    assert valid[alone].all()
    np.testing.assert_allclose(f.phi[alone], rows[alone, 1], rtol=1e-10)
    np.testing.assert_allclose(f.theta[alone], rows[alone, 2], rtol=1e-10)
    np.testing.assert_allclose(f.T, -bar * f.phi, rtol=1e-8)
    line = f.contact == "BF+TS"
    np.testing.assert_array_equal(line, ~valid)
    np.testing.assert_allclose(f.phi[line], np.tan(design.alpha) * f.psi[line], rtol=1e-9)
    if line.any():
        # the closed form on the line (docs, theory), y_n = 0
        rho, cos = f.psi[line] / np.cos(design.alpha), np.cos(design.alpha)
        sine = design.eta * rho * np.cos(rho / 2) / (cos - design.lam * rho)
        np.testing.assert_allclose(f.theta[line], np.arcsin(sine) - rho / 2, rtol=3e-7)


@pytest.mark.parametrize(("alpha", "slope"), [(5, 1.427), (20, 0.374), (45, -1.560), (60, -0.994)])
def test_coupling_at_the_onset(alpha, slope):
    """The figures of an independent derivation: twist per bend of a beam free to twist, bar and joint alike stiff."""
    design = MAIN._replace(alpha=np.radians(alpha))
    onset = 0.2 * next(followed(design, [(0.2, 0.0)])).x1
    f = relaxed(design, np.array([onset - 1e-6, onset + 1e-6]), 1.0, free=1)
    assert f.contact.tolist() == ["", "BF"]
    assert f.phi[0] == 0
    # tolerance: the figures have three decimals
    assert f.phi[1] / 1e-6 == pytest.approx(slope, abs=1e-3)


def test_where_nothing_holds_it_stops():
    f = relaxed(MAIN, np.array([0.0, 0.1, 2.0, 2.1]), 1e9, free=1)
    np.testing.assert_array_equal(np.isfinite(f.theta), [True, True, False, False])
