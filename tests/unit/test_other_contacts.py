"""Contacts that come in, part and come again along paths on compliant joints: seen where they do, whatever is asked."""

import numpy as np
import pytest
from scipy.optimize import brentq

import squama
from legs import Bent, follow_legs
from oracle import boxes
from squama.contacts import events, increments, path
from squama.curves import compliant
from squama.joints import law

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None, hold="bend, twist, lateral bend")


def twisted_then_bent(n: int) -> Bent:
    """Side edges on base edges; a tip edge comes to a face as the beam is bent, within the last hundredths of a rad."""
    shape = law.Shape(2.398, 0.46794, 0.15, 1.127, 0.0282208, 0.480876, 0.102639, 0.45)
    one = path.Scale(4.2025, shape.beta, shape.lam, shape.alpha, shape.theta0, shape.thickness)
    bends = np.linspace(0.0, 0.03711, n + 1)[1:]
    corners = np.vstack([(0.0, -0.067126), np.column_stack([bends, np.full(n, -0.067126)])])
    return follow_legs(one, law.stiffness(shape), 0.40939, corners)


@pytest.mark.parametrize("n", [1, 3, 40])
def test_a_contact_takes_over_at_one_place_whatever_is_asked(n: int) -> None:
    found, other = twisted_then_bent(n), twisted_then_bent(200)
    assert found.answers.contact().words == "side edge on base edge (k = 1)"
    here, there = (events.second(events.events(one.answers)) for one in (found, other))
    assert here.contact == there.contact == "BF"
    # tolerance: the steps to it, 1e-6 of friction's way, on every processor
    assert here.way == pytest.approx(there.way, abs=1e-4)
    assert (here.psi, here.phi) == pytest.approx((here.way - 0.067126, -0.067126), abs=1e-9)
    # it takes over; the states behind it know of it
    ways, names = found.column("phi"), events.touching(found.answers)
    assert set(names[ways > here.way]) == {"BF"}
    assert set(names[ways < here.way]) <= {"", "SB"}


@pytest.mark.parametrize("points", [3, 40, 200])
def test_a_contact_that_opens_closes_again_where_it_did_first(points: int) -> None:
    way = "twist 0.08 rad/pitch; twist 0.02 rad/pitch; twist 0.09 rad/pitch"
    r = squama.bend_twist(SKIN, way, points=points)
    assert r.event.values.tolist() == [
        "engagement (TS)", "corner", "TS slides", "release", "corner", "engagement (TS)", "range end",
    ]  # fmt: skip
    first, again = r.phi_event.values[[0, 5]]
    assert again == pytest.approx(first, rel=1e-9)
    # between them it is back on the line without contact, so that the last way is a first one
    once = squama.bend_twist(SKIN, "twist 0.09 rad/pitch", points=points)
    np.testing.assert_allclose([r["T"][-1], r.M[-1]], [once["T"][-1], once.M[-1]], rtol=1e-3)


@pytest.mark.parametrize("beyond", [1e-6, 1e-4, 1e-3])
@pytest.mark.parametrize("more", ["", "; twist 0.02 rad/pitch; twist 0.09 rad/pitch"])
def test_a_path_that_ends_or_turns_shortly_behind_engagement_engages(beyond: float, more: str) -> None:
    engaged = float(squama.bend_twist(SKIN, "twist 0.08 rad/pitch", points=3).phi_e)
    r = squama.bend_twist(SKIN, f"twist {engaged + beyond:.17g} rad/pitch" + more, points=11)
    assert str(r.end.values) == "range end"
    assert r.event.values[0] == "engagement (TS)"
    assert float(r.phi_e) == pytest.approx(engaged, rel=1e-9)
    if more:
        assert r.phi_event.values[r.event.values == "engagement (TS)"] == pytest.approx([engaged] * 2, rel=1e-9)


@pytest.mark.parametrize("ideal", [False, True])
def test_a_contact_closes_again_on_another_leg_than_the_next(ideal: bool) -> None:
    """Legs to and fro without contact between; the same whether stations are many or few."""
    one, K = compliant.scale(SKIN, ideal=ideal), compliant.Held.of(SKIN).K
    turns = np.array([(0.0, 0.09), (0.0, 0.01), (0.0, 0.03), (0.01, 0.02), (0.0, 0.02), (0.0, 0.085)])
    few = follow_legs(one, K, 0.25, turns)
    start, many = np.zeros(2), []
    for end in turns:
        many.append(start + (end - start) * np.linspace(0.0, 1.0, 60)[1:, None])
        start = end
    fine = follow_legs(one, K, 0.25, np.concatenate(many))
    assert few.answers.end().code == fine.answers.end().code == increments.RANGE
    np.testing.assert_allclose(few.M[-1], fine.M[-1], rtol=1e-3)
    np.testing.assert_allclose(few.T[-1], fine.T[-1], rtol=1e-3)
    # without contact it is a spring
    np.testing.assert_allclose(few.T[1], few.T[2] / 3, rtol=1e-9)


# lengths over the pitch, angles in rad, rigid
WITHOUT_OVERLAP = {
    "late": {"eta": 0.727, "beta": 0.864, "lam": 0.76, "zeta": 0.244, "alpha": 0.647, "theta0": 0.237,
             "thickness": 0.0767, "width": 2.248, "nu": 0.281, "mu": 0.04},
    "late, steeper": {"eta": 0.659, "beta": 0.949, "lam": 0.476, "zeta": 0.148, "alpha": 0.738, "theta0": 0.339,
                      "thickness": 0.0805, "width": 3.023, "nu": 0.296, "mu": 0.26},
    "missed": {"eta": 0.648, "beta": 0.947, "lam": 0.436, "zeta": 0.248, "alpha": 0.772, "theta0": 0.386,
               "thickness": 0.0948, "width": 3.418, "nu": 0.409, "mu": 0.0},
}  # fmt: skip


@pytest.mark.parametrize("name", WITHOUT_OVERLAP)
def test_scales_without_overlap_touch_where_boxes_do(name: str) -> None:
    """Looked at from edge to edge of the plates their contact came in late, or not at all."""
    beam = WITHOUT_OVERLAP[name]
    K, free = law.stiffness(law.Shape(*(beam[key] for key in law.Shape._fields))), [*range(6), 8]
    rates = -np.linalg.solve(K[np.ix_(free, free)], K[free, 6])
    size = tuple(beam[key] for key in ("eta", "beta", "lam", "alpha", "thickness"))

    def gap(phi: float) -> float:
        return boxes.displaced(size, beam["theta0"], phi, 1, rates[:6] * phi, rates[6] * phi)

    found = squama.response(np.linspace(0.01, 0.3, 30), **beam, hold="bend, lateral bend")
    twists = np.linspace(0.0, 0.3, 61)
    first = next(i for i, phi in enumerate(twists) if gap(phi) < 0)
    assert float(found.phi_e) == pytest.approx(brentq(gap, twists[first - 1], twists[first], xtol=1e-14), rel=1e-9)
