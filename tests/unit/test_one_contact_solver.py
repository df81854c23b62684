"""What followers of one contact got wrong: smooth tangents, ends that do not depend on points, snaps by name."""

import math

import numpy as np
import pytest

import squama
from squama.contacts import increments, path
from squama.joints import law

GIVEN = {"lam": 0.5, "zeta": 0.3, "thickness": 0.02, "width": 2.0, "nu": 0.45, "mu": 0.2}


def test_the_tangent_of_a_curve_is_smooth_where_several_contacts_act() -> None:
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
    r = squama.twist(beam, mu=0.5, to="0.24 rad/pitch", points=161)
    assert float(r.phi_second) < 0.235
    behind = r.phi.values > float(r.phi_e) * 1.05
    ratio = r.stiffness_ratio.values[behind]
    # contacts may come in at a few places, and the tangent leap there once, but not up and down again
    between = np.abs(ratio[1:-1] - np.median([ratio[:-2], ratio[1:-1], ratio[2:]], axis=0))
    assert between.max() < 0.05 * ratio.mean()


def test_an_end_is_the_same_whatever_points_are_asked() -> None:
    beam = GIVEN | {"eta": 3.7, "beta": 0.6, "alpha": 1.0, "theta0": 0.12, "modulus_ratio": 2e7}
    points = [np.linspace(0.3 / n, 0.3, n) for n in (40, 200, 450)]
    found = [squama.response(at, **beam, hold="bend, lateral bend") for at in points]
    np.testing.assert_allclose([float(r.phi_end) for r in found], 0.3)
    # tolerance: increments follow the points, 8e-5 of the torque on every processor
    np.testing.assert_allclose([float(r.torque[-1]) for r in found], float(found[-1].torque[-1]), rtol=3e-3)


def test_events_are_at_one_place_whatever_points_are_asked() -> None:
    """Where an elastic scale meets a face, and what a snap loses."""
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
    found = [squama.twist(beam, mu=0.5, to="0.24 rad/pitch", points=n) for n in (12, 40, 90)]
    assert {str(r.other_contact.values).split(" at ")[0] for r in found} == {"face on side edge (k = 1)"}
    for name in ("phi_e", "phi_second"):
        # tolerance: what is promised of events; 2e-7 measured, on every processor
        np.testing.assert_allclose([float(r[name]) for r in found], float(found[-1][name]), rtol=0, atol=1e-6)
    skin = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(hold="straight")
    snapped = [float(squama.twist(skin, mu=0, points=n).W_snap[-1]) for n in (12, 40)]
    assert snapped[0] > 0.1
    assert snapped[1] == pytest.approx(snapped[0], rel=1e-6)


@pytest.mark.parametrize(
    ("beam", "way"),
    [
        ({"eta": 3.9, "beta": 0.5, "alpha": 0.8, "theta0": 0.3}, 0.19955),
        ({"eta": 4.1, "beta": 0.4, "alpha": 0.5, "theta0": 0.29}, 0.19837),
    ],
)
def test_a_contact_that_leaves_the_tip_edge_snaps(beam: dict[str, float], way: float) -> None:
    """A side edge comes to the other's side edge; energy is lost, and the path goes on."""
    g = GIVEN | beam
    h = g["thickness"]
    K = law.stiffness(law.Shape(g["width"], g["lam"], g["zeta"], g["beta"], h, g["alpha"], g["theta0"], g["nu"]))
    D = 2e5 * h**3 / (12 * (1 - 0.35**2))
    scale = path.Scale(g["eta"], g["beta"], g["lam"], g["alpha"], g["theta0"], h, D, 0.35)
    found = path.Path.of(scale, K, g["mu"], free=path.STRETCHING).follow(np.linspace(0.01, 0.3, 30))
    events = found.events[0, : int(found.ends[0, 2])]
    assert events[:, 0].tolist() == [increments.ENGAGE, increments.SNAP]
    assert events[1, 1] == pytest.approx(way, abs=1e-4)
    assert events[1, 12] > 1e-5
    rows = path.named(found.rows[0])
    assert found.end().phi == pytest.approx(0.3)
    work = rows["energy"] + rows["W_fr"] + rows["W_snap"]
    # tolerance: trapezia of increments, 2e-5 on every processor
    assert math.isclose(rows["W"][-1], work[-1], rel_tol=1e-3)
