"""Contacts that come in, part and come again along paths of the real beam: seen where they do, whatever is asked."""

import numpy as np
import pytest

import squama
from squama.curves import real
from squama.joints import law
from squama.real import changes, path
from squama.real.legs import Bent, follow_legs

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")


def twisted_then_bent(n: int) -> Bent:
    """Side edges on base edges; a tip edge comes to a face as the beam is bent, within the last hundredths of a rad."""
    shape = law.Shape(2.398, 0.46794, 0.15, 1.127, 0.0282208, 0.480876, 0.102639, 0.45)
    one = path.Scale(4.2025, shape.beta, shape.lam, shape.alpha, shape.theta0, shape.thickness)
    bends = np.linspace(0.0, 0.03711, n + 1)[1:]
    corners = np.vstack([(0.0, -0.067126), np.column_stack([bends, np.full(n, -0.067126)])])
    return follow_legs(one, law.stiffness(shape), 0.40939, corners)


@pytest.mark.parametrize("n", [1, 3, 40])
def test_no_state_stands_behind_a_contact_that_has_come_in(n: int) -> None:
    found, other = twisted_then_bent(n), twisted_then_bent(200)
    assert found.answers.contact().words == "side edge on base edge (k = 1)"
    end = found.answers.end()
    # told, though it comes in within the last steps; located to 1e-7 of the way
    assert (end.code, end.edge, end.k) == (changes.OTHER, 0, 1)
    assert end.phi == pytest.approx(other.answers.end().phi, abs=1e-5)
    way = np.cumsum(np.hypot(*np.diff(np.column_stack([found.psi, found.phi]), axis=0, prepend=0.0).T))
    reached = np.isfinite(found.M)
    assert (way[reached] <= end.phi + 1e-6).all()
    assert reached.sum() == 1 + int((end.phi - 0.067126) / 0.03711 * n)


@pytest.mark.parametrize("points", [3, 40, 200])
def test_a_contact_that_opens_closes_again_where_it_did_first(points: int) -> None:
    way = "twist 0.08 rad/pitch; twist 0.02 rad/pitch; twist 0.09 rad/pitch"
    r = squama.bend_twist(SKIN, way, points=points)
    assert r.event.values.tolist() == [
        "engagement (TS)", "corner", "release", "corner", "engagement (TS)", "range end",
    ]  # fmt: skip
    assert r.attrs["followed"] == "one contact"
    first, again = r.phi_event.values[[0, 4]]
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
    one, K = real.scale(SKIN, ideal=ideal), real.Held.of(SKIN).K
    turns = np.array([(0.0, 0.09), (0.0, 0.01), (0.0, 0.03), (0.01, 0.02), (0.0, 0.02), (0.0, 0.085)])
    few = follow_legs(one, K, 0.25, turns)
    start, many = np.zeros(2), []
    for end in turns:
        many.append(start + (end - start) * np.linspace(0.0, 1.0, 60)[1:, None])
        start = end
    fine = follow_legs(one, K, 0.25, np.concatenate(many))
    assert few.answers.end().code == fine.answers.end().code == changes.RANGE
    np.testing.assert_allclose(few.M[-1], fine.M[-1], rtol=1e-3)
    np.testing.assert_allclose(few.T[-1], fine.T[-1], rtol=1e-3)
    # without contact it is a spring
    np.testing.assert_allclose(few.T[1], few.T[2] / 3, rtol=1e-9)
