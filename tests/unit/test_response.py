"""The labelled response of a beam: what is in it, where it begins and ends, and how its parts agree."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

import squama
from properties.designs import Drawn
from squama.arrays import solution
from squama.curves.doors import respond as respond_to
from squama.curves.hinge import path
from squama.curves.way import Case

BEAM = squama.Beam.from_ratios(mu=0.5)
BEAM_THICK = squama.Beam.from_ratios(slenderness=10, mu=0.5)
BENT = squama.Beam.from_ratios(eta=5, theta0="5 deg", mu=0.3)
DIMENSIONS = {"Phi": "rad/m", "phi": "rad", "theta": "rad", "T": "N m", "T_scales": "N m", "K_t": "N m^2", "f0": "1"}
DIMENSIONS |= {"N": "N", "f": "N", "p": "m", "s": "m", "U_el": "J/m", "W_fr": "J/m", "RED": "1", "mu_lock": "1"}
both = pytest.mark.parametrize(
    ("load", "rate", "torque", "tangent"), [("twist", "Phi", "T", "K_t"), ("bend", "kappa", "M", "K_b")]
)
laws = pytest.mark.parametrize("law", ["plate", "edge"])


def respond(load: str, **kwargs):
    return (
        squama.twist(BEAM, **kwargs, joint="hinge") if load == "twist" else squama.bend(BENT, **kwargs, joint="hinge")
    )


def test_every_variable_is_labelled() -> None:
    for r in (squama.twist(BEAM, joint="hinge"), squama.bend(BENT, joint="hinge")):
        for name, variable in {**r.data_vars, **r.coords}.items():
            assert variable.attrs["long_name"] == squama.SYMBOLS[name].long_name
            assert variable.attrs["units"] == squama.SYMBOLS[name].unit
        assert r.sizes == {"point": 200}
        assert r.mu.item() in (0.5, 0.3)
    assert respond_to(BEAM, "twisting")["T"].shape == (200,)
    r = squama.twist(BEAM, joint="hinge")
    assert {name: r[name].attrs["units"] for name in DIMENSIONS} == DIMENSIONS
    assert r["T"].attrs["equation"] == "paper Eq. 14"


def test_attributes_say_what_was_computed() -> None:
    r = squama.twist(BEAM, law="plate", margin=0.05, sense="-")
    assert {k: r.attrs[k] for k in ("load", "law", "margin", "sense")} == {
        "load": "twisting",
        "law": "plate",
        "margin": 0.05,
        "sense": "-",
    }
    assert r.attrs["squama_version"] == squama.__version__
    assert squama.Beam.from_toml_text(r.attrs["beam"]) == BEAM
    assert "not thin" in r.attrs["warnings"]
    assert squama.bend(BENT, joint="hinge").attrs["load"] == "bending"


@both
def test_the_curve_begins_at_rest_and_is_continuous(load: str, rate: str, torque: str, tangent: str) -> None:
    r = respond(load, points=400)
    assert r.sizes["point"] == 400
    first = {name: float(r[name][0]) for name in (rate, torque, "N", "f", "U_el", "W_fr", "RED")}
    assert set(first.values()) == {0.0}
    assert float(r.theta[0]) == (BEAM if load == "twist" else BENT).scale.theta0
    assert np.all(np.diff(r[rate]) > 0)
    assert np.all(np.diff(r.theta) >= 0)
    assert np.all(np.diff(r[torque]) > 0)
    # the load is continuous where the scales engage, and its slope is not
    e = float(r[f"{rate}_e"])
    at = respond(load, at=e * (1 + np.array([-1e-7, 0, 1e-7])))
    values = at[torque].values
    # tolerance: 1e-7 of the rate, and five times that where it is steeper
    assert values[1] == pytest.approx(values[0], rel=2e-7)
    assert values[2] == pytest.approx(values[1], rel=1e-4)
    assert at[tangent][2] > 1.5 * at[tangent][0]
    rigidity = BEAM.torsional_rigidity if load == "twist" else BENT.bending_rigidity
    before = r[rate] <= e
    assert 5 < int(before.sum()) < 100
    np.testing.assert_allclose(r[torque][before], rigidity * r[rate][before], rtol=1e-9)
    np.testing.assert_allclose(r[tangent][r[rate] < 0.999 * e], rigidity, rtol=1e-12)
    # the last point is the cut-off, and what the figures say
    for name in ("theta", rate, torque):
        assert float(r[name][-1]) == pytest.approx(float(r[f"{name}_c"]), rel=1e-12)
    for name in ("U_el", "W_fr", "RED"):
        assert float(r[name][-1]) == pytest.approx(float(r[f"{name}_c"]), rel=1e-9)
    assert float(r.stiffening) == pytest.approx(float(r[torque][-1] / (rigidity * r[rate][-1])), rel=1e-12)


@both
@pytest.mark.parametrize("law", ["plate", "edge"])
def test_tangent_stiffness_is_the_derivative(load: str, rate: str, torque: str, tangent: str, law: str) -> None:
    kind = {"law": law} if load == "twist" else {}
    r = respond(load, points=30, **kind)
    middle = r[rate].values[6:-3]
    h = 1e-6 * middle
    up, here, down = (respond(load, at=middle + s * h, **kind) for s in (1, 0, -1))
    slope = (up[torque].values - down[torque].values) / (2 * h)
    np.testing.assert_allclose(here[tangent], slope, rtol=1e-5)
    np.testing.assert_allclose(here[torque], r[torque][6:-3], rtol=1e-9)
    # and W_fr' = f dr: the rest of the work goes into U_el
    stored = (up.U_el.values - down.U_el.values + up.W_fr.values - down.W_fr.values) / (2 * h)
    np.testing.assert_allclose(stored, here[torque], rtol=1e-5)


@laws
def test_variables_are_those_of_the_array_functions(law: str) -> None:
    r = squama.twist(BEAM, law=law, points=50, joint="hinge")
    on = r.theta > BEAM.scale.theta0 * (1 + 1e-9)
    theta = r.theta[on].values
    shape = {**BEAM.ratios}
    theta0 = shape.pop("theta0")
    c = squama.contact(theta, **shape)
    f = squama.forces(theta, **shape, theta0=theta0, mu=0.5, law=law)
    d, K = BEAM.pitch, BEAM.joint_stiffness
    np.testing.assert_allclose(r.phi[on], c.phi, rtol=1e-12)
    np.testing.assert_allclose(r.Phi, r.phi / d, rtol=1e-13)
    for name, want in (("p", d * c.p), ("s", d * c.s), ("f0", f.friction), ("mu_lock", f.mu_lock)):
        np.testing.assert_allclose(r[name][on], want, rtol=1e-10, atol=1e-14)
    np.testing.assert_allclose(r.N[on], f.normal * K / BEAM.scale.length, rtol=1e-10)
    np.testing.assert_allclose(r.f, 0.5 * r.N, rtol=1e-13)
    np.testing.assert_allclose(r.T_scales[on], K * f.torque, rtol=1e-10)
    np.testing.assert_allclose(r["T"], r.T_scales + BEAM.torsional_rigidity * r.Phi, rtol=1e-13)
    elastic = (BEAM.torsional_rigidity * r.Phi**2 + K / d * (r.theta - theta0) ** 2) / 2
    np.testing.assert_allclose(r.U_el, elastic, rtol=1e-13)
    np.testing.assert_allclose(r.RED[1:], (r.W_fr / (r.W_fr + r.U_el))[1:], rtol=1e-13, atol=1e-300)
    e = squama.ends(**shape, theta0=theta0, mu=0.5, law=law)
    assert (r.end.item(), r.neighbour.item()) == (str(e.end), int(e.neighbour))
    for name in ("phi_e", "phi_end", "theta_end"):
        assert float(r[name]) == pytest.approx(float(getattr(e, name)), rel=1e-12)
    static = squama.forces(theta0, **shape, theta0=theta0, mu=0, law=law).mu_lock
    assert float(r.mu_static) == pytest.approx(float(static), rel=1e-10)


def test_at_gives_the_curve_at_any_rate_and_nan_beyond_the_end() -> None:
    r = squama.twist(BEAM, joint="hinge")
    end = float(r.Phi_end)
    rates = [0.0, 0.5 * float(r.Phi_e), 10.0, end * (1 - 1e-9), end * 1.001, 1e3]
    s = squama.twist(BEAM, at=rates, joint="hinge")
    np.testing.assert_allclose(s.Phi, rates, rtol=1e-13)
    np.testing.assert_allclose(s.phi, np.array(rates) * BEAM.pitch, rtol=1e-13)
    for name in ("theta", "T", "T_scales", "K_t", "N", "f", "f0", "U_el", "W_fr", "RED"):
        assert np.isfinite(s[name][:4]).all(), name
        assert np.isnan(s[name][4:]).all(), name
    assert np.isnan(s.p[:2]).all()
    assert np.isfinite(s.p[2:4]).all()
    # the curve between its own points
    np.testing.assert_allclose(s["T"][2], np.interp(10, r.Phi, r["T"]), rtol=3e-3)
    assert float(s.theta[3]) == pytest.approx(float(r.theta_end), rel=1e-3)
    # any order, repeated, one number, nothing else changed
    again = squama.twist(BEAM, at=[1000.0, 10.0, 10.0, 0.0], joint="hinge")
    np.testing.assert_array_equal(again["T"][1:], s["T"].values[[2, 2, 0]])
    np.testing.assert_allclose(squama.twist(BEAM, at=10.0, joint="hinge")["T"], s["T"][2], rtol=1e-12)
    for name in ("phi_end", "theta_end", "W_fr_c", "RED_c"):
        assert float(s[name]) == pytest.approx(float(r[name]), rel=1e-9)


@pytest.mark.parametrize("given", [{"to": 5.0}, {"to": "0.01 rad/pitch"}, {"mu": 9.0}, {"sense": "-"}])
def test_a_load_that_meets_the_end_but_for_rounding_belongs_to_the_curve(given) -> None:
    r = squama.twist(BEAM, **given, joint="hinge")
    end = float(r.Phi_end if np.isfinite(r.Phi_end) else r.Phi[-1])
    s = squama.twist(BEAM, at=end * np.array([1, 1 + 3e-16, 1 + 9e-13, 1 + 2e-12]), **given, joint="hinge")
    for name in ("theta", "T", "U_el", "W_fr"):
        assert np.isfinite(s[name][:3]).all(), name
        np.testing.assert_allclose(s[name][1:3], s[name][0].item(), rtol=1e-9, err_msg=name)
        assert np.isnan(s[name][3]), name


def test_points_and_order_of_the_work() -> None:
    few, most = (squama.twist(BEAM, points=n, joint="hinge") for n in (3, 5000))
    assert few.sizes["point"] == 3
    assert most.sizes["point"] == 5000
    assert float(few.RED_c) == float(most.RED_c)
    assert np.all(np.diff(most.W_fr[most.Phi > most.Phi_e]) > 0)
    same = squama.twist(BEAM, at=most.Phi.values[[4000, 1000]], joint="hinge")
    np.testing.assert_allclose(same.W_fr, most.W_fr[[4000, 1000]], rtol=1e-9)


@pytest.mark.parametrize(
    "to", [5.0, "5 rad/m", "0.005 rad/mm", "0.08888888888888889 rad/pitch", "2.2222222222222223 rad total"]
)
def test_to_stops_the_curve(to: float | str) -> None:
    r, full = squama.twist(BEAM, to=to, points=60, joint="hinge"), squama.twist(BEAM, joint="hinge")
    assert r.end.item() == "range end"
    assert r.other_contact.item() == ""
    for name in ("Phi_end", "Phi_c"):
        assert float(r[name]) == pytest.approx(5.0, rel=1e-12)
    assert float(r.Phi[-1]) == pytest.approx(5.0, rel=1e-12)
    assert float(r.theta_c) == pytest.approx(float(r.theta_end), rel=1e-13)
    at = squama.twist(BEAM, at=[5.0], joint="hinge")
    for name in ("T", "theta", "W_fr", "RED"):
        assert float(r[name][-1]) == pytest.approx(float(at[name][0]), rel=1e-9)
    assert float(r.phi_e) == float(full.phi_e)


def test_to_before_engagement_and_beyond_the_end() -> None:
    early = squama.twist(BEAM, to=1.0, points=20, joint="hinge")
    assert early.end.item() == "range end"
    np.testing.assert_allclose(early["T"], BEAM.torsional_rigidity * early.Phi, rtol=1e-13)
    assert float(early.Phi[-1]) == pytest.approx(1.0)
    assert float(early.theta_end) == BEAM.scale.theta0
    assert float(early.stiffening) == pytest.approx(1.0)
    assert float(early.RED_c) == 0
    late = squama.twist(BEAM, to=1e3, joint="hinge")
    assert late.end.item() == "frictional lock"
    none = squama.twist(BEAM, sense="-", to=2.0, joint="hinge")
    assert none.end.item() == "no engagement"
    assert float(none.Phi[-1]) == pytest.approx(2.0)


@pytest.mark.parametrize("load", ["twist", "bend"])
def test_rates_as_texts(load: str) -> None:
    beam = BEAM if load == "twist" else BENT
    rates = [0.05 / beam.pitch, 2.0, math.radians(90) / beam.length]
    texts = respond(load, at=["0.05 rad/pitch", "2 rad/m", "90 deg total"])
    xr.testing.assert_allclose(texts, respond(load, at=rates), rtol=1e-13)
    xr.testing.assert_identical(respond(load, at="2 rad/m"), respond(load, at=2.0))


def test_friction_is_in_the_attributes() -> None:
    assert squama.twist(BEAM, joint="hinge").attrs["mu"] == 0.5
    assert squama.bend(BENT, mu=[0.1], joint="hinge").attrs["mu"] == [0.1]
    assert squama.twist(BEAM, mu=np.array([0.0, 0.2]), joint="hinge").attrs["mu"] == [0.0, 0.2]
    assert squama.row(BEAM, scales=3, mu=0.2, points=5, joint="hinge").attrs["mu"] == 0.2


def test_warnings_are_those_of_the_sense() -> None:
    # a beam that engages both ways, at other twists
    shape = {"eta": 1.356, "beta": 1.729, "lam": 0.81, "alpha": "4.54 deg", "theta0": "17.91 deg"}
    beam = squama.Beam.from_ratios(**shape, slenderness=10, mu=0.1)
    for sense in ("+", "-"):
        r = squama.twist(beam, sense=sense, joint="hinge")
        (line,) = [w for w in r.attrs["warnings"].splitlines() if "not thin" in w]
        assert f"the model's thin ones at {math.degrees(float(r.phi_e)):.3g} deg per pitch" in line
    (line,) = [
        w for w in squama.twist(BEAM_THICK, sense="-", joint="hinge").attrs["warnings"].splitlines() if "not thin" in w
    ]
    assert "in this sense of twist the model's thin plates do not meet" in line


def test_a_family_of_curves() -> None:
    mus = [0.0, 0.2, 9.0]
    family = squama.twist(BEAM, mu=mus, points=40, joint="hinge")
    assert family.sizes == {"mu": 3, "point": 40}
    assert family.mu.values.tolist() == mus
    for m in mus:
        one = squama.twist(BEAM, mu=m, points=40, joint="hinge")
        part = family.sel(mu=m)
        assert one.mu.item() == m
        for name in one.data_vars:
            if one[name].dtype.kind == "f":
                np.testing.assert_allclose(part[name], one[name], rtol=1e-12, atol=1e-14)
            else:
                np.testing.assert_array_equal(part[name], one[name])
    assert family.end.values.tolist() == ["other contact", "frictional lock", "static lock"]
    at = squama.twist(BEAM, mu=mus, at=[1.0, 8.0], joint="hinge")
    assert np.isnan(at["T"].sel(mu=9.0)[1])
    assert at["T"].sel(mu=0.2)[1] > at["T"].sel(mu=0.0)[1]
    assert squama.bend(BENT, mu=[0.1, 0.3], joint="hinge").sizes["mu"] == 2
    given = BEAM.replace(friction={"mu": 0.2})
    np.testing.assert_array_equal(squama.twist(given, points=40, joint="hinge")["T"], family["T"].sel(mu=0.2))
    one = respond_to(BEAM, "twisting", mu=mus, points=40, joint="hinge").pick(1).dataset()
    xr.testing.assert_equal(one, family.isel(mu=1))


def test_static_lock() -> None:
    r = squama.twist(BEAM, mu=9.0, joint="hinge")
    assert r.end.item() == "static lock"
    assert float(r.mu_static) < 9
    assert float(r.phi_end) == float(r.phi_e)
    assert float(r.theta_end) == float(r.theta_c) == BEAM.scale.theta0
    assert float(r.Phi[-1]) == pytest.approx(float(r.Phi_e), rel=1e-13)
    np.testing.assert_allclose(r["T"], BEAM.torsional_rigidity * r.Phi, rtol=1e-13)
    assert float(r.RED_c) == 0
    assert np.isnan(squama.twist(BEAM, mu=9.0, at=[1.01 * float(r.Phi_e)], joint="hinge")["T"][0])


def test_the_other_sense_and_no_engagement() -> None:
    r = squama.twist(BEAM, sense="-", joint="hinge")
    assert (r.end.item(), r.neighbour.item()) == ("no engagement", 0)
    assert np.isinf(r.phi_e)
    assert float(r.theta_end) == BEAM.scale.theta0
    # the plates do touch: the bare beam goes on to there, and that is said
    assert r.other_contact.item() == "side edge A1B1 on base edge D2A2 (k = 1)"
    assert np.isinf([r.phi_end, r.Phi_end]).all()
    assert float(r.phi_touch) == pytest.approx(0.386690988, abs=1e-9)
    assert float(r.theta_touch) == BEAM.scale.theta0
    assert float(r.Phi[-1]) * BEAM.pitch == pytest.approx(float(r.phi_touch))
    np.testing.assert_allclose(r["T"], BEAM.torsional_rigidity * r.Phi, rtol=1e-13)
    assert float(r.RED_c) == 0


def test_plates_that_touch_before_the_contact_engages() -> None:
    beam = squama.Beam.from_ratios(eta=1.356, beta=1.729, lam=0.81, zeta=0.1, alpha="4.54 deg", theta0="17.91 deg")
    r = squama.twist(beam, mu=0.046, sense="-", joint="hinge")
    assert (r.end.item(), int(r.neighbour)) == ("other contact", 1)
    assert r.other_contact.item() == "corner A2 on the face of scale 1 (k = 1)"
    assert float(r.phi_e) == pytest.approx(0.20512333722279022, rel=1e-10)
    assert float(r.phi_end) == pytest.approx(0.2005938093, abs=1e-9)
    assert (float(r.phi_touch), float(r.theta_touch)) == (float(r.phi_end), float(r.theta_end))
    assert float(r.phi[-1]) == pytest.approx(float(r.phi_end), rel=1e-13)
    assert float(r.stiffening) == pytest.approx(1.0)
    np.testing.assert_allclose(r["T"], beam.torsional_rigidity * r.Phi, rtol=1e-13)
    assert np.isnan(squama.twist(beam, mu=0.046, sense="-", at=[float(r.Phi_e)], joint="hinge")["T"][0])


def released(law: str):
    """A path through its fold and back to theta0, with the plates of other pairs left out."""
    d = Drawn(1.292, 0.92, 0.744, math.radians(4.3), math.radians(12.22), 0.2)
    sol = solution.solve({name: np.array([v]) for name, v in d._asdict().items()}, law=law, sense="+")
    case = Case(1.0, 2.0, 3.0, d.eta, d.theta0)
    p = path(case, sol, None, d.mu, law, 0.01)
    return d, case, p, p.curve(points=200)


def test_a_path_through_its_fold_is_followed_until_the_scales_are_back() -> None:
    d, case, p, c = released("edge")
    assert str(p.end) == "released"
    theta, load = c.along["theta"], c.along["load"]
    assert np.all(np.diff(load) > 0)
    turn = int(np.argmax(theta))
    assert 20 < turn < 190
    assert theta[-1] == pytest.approx(d.theta0, rel=1e-12)
    assert c.figures["theta_c"] == pytest.approx(d.theta0, rel=1e-12)
    # released springs press no more, and the torque is the bare beam's again
    assert c.along["N"][-1] == pytest.approx(0, abs=1e-12)
    assert c.along["torque"][-1] == pytest.approx(case.rigidity * c.along["rate"][-1], rel=1e-9)
    assert c.figures["W_fr_c"] > 0
    # beyond the fold the springs give back: the scales' torque turns negative without friction's part
    beyond = p.curve(points=3, at=np.array([0.5 * (load[turn] + load[-1])]))
    assert beyond.along["theta"][0] < theta.max()
    assert beyond.along["theta"][0] == pytest.approx(np.interp(beyond.along["load"][0], load, theta), abs=5e-4)
    # energy balance over the whole way: int T dPhi = U_el + W_fr
    nodes, weights = np.polynomial.legendre.leggauss(120)
    start, stop = p.load_e, p.load_end
    at = start + (stop - start) * (nodes + 1) / 2
    torque = p.curve(points=3, at=at).along["torque"]
    done = float(weights @ torque) * (stop - start) / 2 + case.rigidity * start**2 / 2
    assert done == pytest.approx(c.figures["U_el_c"] + c.figures["W_fr_c"], rel=1e-9)
