"""Arrays of beams on compliant joints: against single curves, and what must not matter."""

import numpy as np
import pytest

import squama
from squama.contacts import path
from squama.joints import lateral, law
from squama.model import section

DESIGN = {
    "eta": 4.0, "beta": 0.5, "lam": 0.4, "zeta": 0.35, "alpha": np.radians(45), "theta0": np.radians(15),
    "thickness": 0.06, "width": 1.2, "nu": 0.48, "mu": 0.3,
}  # fmt: skip
PHI = np.linspace(0, 0.14, 36)


def some(n: int, seed: int = 5) -> dict[str, np.ndarray]:
    """Random designs, a part of them outside the law's range, every third rigid."""
    r = np.random.default_rng(seed)
    beta, alpha, theta0 = r.uniform(0.36, 1.2, n), np.radians(r.uniform(20, 70, n)), np.radians(r.uniform(6, 25, n))
    ratio = np.where(np.arange(n) % 3 == 0, np.inf, 10 ** r.uniform(3, 5.2, n))
    return {
        "eta": r.uniform(1.2, 4.5, n), "beta": beta, "lam": r.uniform(0.3, 0.8, n), "zeta": r.uniform(0.1, 0.5, n),
        "alpha": alpha, "theta0": theta0, "thickness": np.cos(alpha) * np.sin(theta0) * r.uniform(0.05, 0.6, n),
        "width": r.uniform(1.05, 1.95, n) * 2 * beta * np.cos(alpha), "nu": r.uniform(0.25, 0.495, n),
        "mu": r.uniform(0, 0.6, n), "modulus_ratio": ratio,
    }  # fmt: skip


def test_a_beam_of_a_file_has_the_curve_of_twist() -> None:
    beam = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    s, d, substrate = beam.scale, beam.pitch, beam.substrate
    many = squama.response(
        PHI, eta=beam.eta, beta=beam.beta, lam=beam.lam, zeta=beam.zeta, alpha=s.alpha, theta0=s.theta0,
        thickness=s.thickness / d, width=substrate.width / d, nu=substrate.poisson_ratio, mu=beam.friction.mu,
        modulus_ratio=s.youngs_modulus / substrate.youngs_modulus, scale_nu=s.nu,
    )  # fmt: skip
    one = squama.twist(beam, at=[f"{x} rad/pitch" for x in PHI])
    unit = substrate.youngs_modulus * d**3
    assert many.phi_e == pytest.approx(float(one.phi_e), rel=1e-12)
    assert many.end == str(one.end.values)
    # tolerance: coarser steps than twist's, 1e-6 to 8e-5 measured, on every processor
    np.testing.assert_allclose(many.torque * unit, one["T"].values, rtol=1e-5)
    np.testing.assert_allclose(many.N * unit / d, one.N.values, rtol=1e-4)
    np.testing.assert_allclose(many.W_fr * unit / d, one.W_fr.values, rtol=0, atol=1e-3 * one.W_fr.values[-1])
    assert float(many.K_theta) * unit == pytest.approx(one.attrs["K_theta"])
    assert float(many.rigidity) * unit * d == pytest.approx(one.attrs["rigidity"])
    # slopes between the twists against those of finer steps
    np.testing.assert_allclose(many.stiffness_ratio[:-1], one.stiffness_ratio.values[:-1], rtol=5e-3)


def test_neither_company_nor_threads_matter() -> None:
    designs = some(300)
    all_at_once, threads = (squama.response(PHI, **designs, threads=n) for n in (1, 3))
    alone = [squama.response(PHI, **{name: v[i] for name, v in designs.items()}) for i in range(0, 300, 7)]
    stacked = squama.Response(*(np.stack(field) for field in zip(*alone, strict=True)))
    for i, other in ((slice(None), threads), (slice(None, None, 7), stacked)):
        for name, x, y in zip(squama.Response._fields, all_at_once, other, strict=True):
            # company changes the last digits of the law's products
            if name in ("end", "in_range") or other is threads:
                np.testing.assert_array_equal(x[i], y, err_msg=name)
            elif name != "stiffness_ratio":
                np.testing.assert_allclose(x[i], y, rtol=1e-6, atol=1e-9, err_msg=name)


def test_designs_outside_the_law_have_no_figures_and_all_others_an_end() -> None:
    designs = some(400)
    r = squama.response(PHI, **designs)
    assert 100 < r.in_range.sum() < 400
    joint = law.Shape(*(designs[name] for name in law.Shape._fields))
    np.testing.assert_array_equal(r.in_range, law.within(joint))
    for values in (r.phi_e, r.phi_end, r.K_theta, r.torque[:, 0]):
        np.testing.assert_array_equal(np.isnan(values), ~r.in_range)
    words = {str(word) for word in path.WORDS}
    assert set(r.end[r.in_range]) <= words
    assert set(r.end[~r.in_range]) == {""}
    # a curve goes to its end, and no further
    reached = np.isfinite(r.torque[r.in_range])
    np.testing.assert_array_equal(reached, r.phi_end[r.in_range, None] * (1 + 1e-9) >= PHI)
    free = r.in_range & (r.end == "no engagement")
    assert free.any()
    np.testing.assert_allclose(r.torque[free], r.rigidity[free, None] * PHI, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(r.stiffness_ratio[free], 1, rtol=1e-9)


def test_the_other_sense_is_that_of_the_mirror_image() -> None:
    """A beam whose scales, and so whose joint, are turned the other way round, in the first sense."""
    narrow = {"eta": 2.0, "alpha": np.radians(4), "theta0": np.radians(7), "thickness": 0.04, "beta": 0.9, "width": 2.4}
    design = DESIGN | narrow
    many = squama.response(PHI, **design, sense="-")
    turned = design | {"alpha": -design["alpha"]}
    shape = law.Shape(*(turned[name] for name in law.Shape._fields))
    K = law.stiffness(shape)
    scale = path.Scale(*(turned[name] for name in ("eta", "beta", "lam", "alpha", "theta0", "thickness")))
    aside = float(lateral.stiffness(K, shape) / K[7, 7])
    one = path.Path.of(scale, K, design["mu"], free=(1, 0, 1, 1), aside=aside)
    rows, end = one.states(PHI)
    assert 0 < many.phi_e < 0.1
    assert many.phi_e == pytest.approx(one.contact.phi, rel=1e-9)
    assert many.phi_end == pytest.approx(end.phi, rel=1e-6)
    np.testing.assert_allclose(many.torque, rows[:, 1], rtol=1e-6, atol=1e-12)


def test_modulus_to_infinity_is_rigid() -> None:
    rigid, stiff = (squama.response(PHI, **DESIGN, modulus_ratio=ratio) for ratio in (np.inf, 1e13))
    assert rigid.stiffness_ratio.max() > 2
    np.testing.assert_allclose(stiff.torque, rigid.torque, rtol=1e-4)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"phi": [0.1, 0.1]}, "phi: must be a rising sequence"),
        ({"phi": []}, "phi: must be a rising sequence"),
        ({"phi": [0.1, 4.0]}, "phi: must be a rising sequence of twists below pi"),
        ({"phi": [-0.1, 4.0]}, "phi = -0.1: must be 0 or more"),
        ({"nu": 0.5}, "nu = 0.5: must be above 0 and below 0.5"),
        ({"scale_nu": 0.7}, "scale_nu = 0.7: must be above 0 and below 0.5"),
        ({"modulus_ratio": np.nan}, "modulus_ratio = nan: must be a finite number"),
        ({"modulus_ratio": "PLA"}, 'modulus_ratio = "PLA": is a text; give a number or an array'),
        ({"modulus_ratio": -np.inf}, "modulus_ratio = -inf: must be a finite number"),
        ({"zeta": 0}, "zeta = 0: must be above 0"),
        ({"zeta": [0.1, 0.2], "width": [1, 2, 3]}, "shapes do not fit each other"),
        ({"sense": "left"}, 'sense = "left": must be'),
    ],
)
def test_bad_arguments(given: dict, said: str) -> None:
    with pytest.raises(squama.InputError) as caught:
        squama.response(**({"phi": PHI} | DESIGN | given))
    assert str(caught.value).startswith(said)
    assert "\n" not in str(caught.value)


JUST_BEHIND = {
    "eta": 3.834595409581805, "beta": 0.5118778629992609, "lam": 0.40571785265200433, "zeta": 0.24593358828854037,
    "alpha": 0.5311747895749378, "theta0": 0.29619922537090626, "thickness": 0.0555789851544197, "width": 2.2,
    "nu": 0.45, "mu": 0.25, "modulus_ratio": 2e4,
}  # fmt: skip


def test_a_twist_just_behind_engagement_ends_no_curve() -> None:
    phi_e = float(squama.response([0.2], **JUST_BEHIND).phi_e)
    # one of them is behind it by its last bit, or before
    x = np.linspace(0, 2.5 * phi_e, 31)[1:]
    for place in (x[11], *(phi_e * (1 + v) for v in (-1e-14, 0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6))):
        near = np.append(x[:11], [place, *x[12:]])
        r = squama.response(near, **JUST_BEHIND)
        assert r.end == "range end"
        assert np.isfinite(r.torque).all()
        # the same as by twists of which none is near it, up to what steps are even
        far = squama.response(np.append(x[:11], x[12:]), **JUST_BEHIND)
        np.testing.assert_allclose(np.delete(r.torque, 11), far.torque, rtol=1e-6)
        assert r.torque[11] == pytest.approx(r.rigidity * phi_e, rel=1e-4)


@pytest.mark.parametrize("apart", [1e-13, 1e-11, 1e-9, 1e-7])
def test_twists_that_are_all_but_equal_end_no_curve(apart: float) -> None:
    """Random beams; twists in contact that lie so near to others that no rate can be had between them."""
    r = np.random.default_rng(31)
    n = 30
    thickness = r.uniform(0.03, 0.06, n)
    given = {
        "eta": r.uniform(2.5, 4.5, n), "beta": r.uniform(0.4, 0.8, n), "lam": r.uniform(0.35, 0.6, n),
        "zeta": r.uniform(0.2, 0.4, n), "alpha": r.uniform(0.5, 0.9, n), "theta0": r.uniform(0.2, 0.3, n),
        "thickness": thickness, "width": 2.0, "nu": 0.45, "mu": r.uniform(0.0, 0.4, n), "modulus_ratio": 2e4,
    }  # fmt: skip
    x = np.linspace(0.01, 0.2, 20)
    far = squama.response(x, **given)
    near = squama.response(np.sort(np.append(x, x * (1 + apart))), **given)
    assert np.isfinite(far.torque[:, 0]).sum() > 20
    np.testing.assert_array_equal(near.end, far.end)
    np.testing.assert_allclose(near.torque[:, ::2], far.torque, rtol=1e-4)
    np.testing.assert_allclose(near.torque[:, 1::2], near.torque[:, ::2], rtol=1e-4)


@pytest.mark.slow
def test_the_work_is_stored_rubbed_away_or_lost_in_snaps() -> None:
    designs = some(60, seed=11)
    shape = law.Shape(*(designs[name] for name in law.Shape._fields))
    known = law.within(shape)
    own = {name: v[known] for name, v in designs.items()}
    scale = path.Scale(
        *(own[name] for name in ("eta", "beta", "lam", "alpha", "theta0", "thickness")),
        D=section.plate_rigidity(own["modulus_ratio"], own["thickness"], 0.3),
    )
    K = law.stiffness(shape.at(np.flatnonzero(known)))
    beams = path.beams(scale._replace(nu=np.full(len(K), 0.3)), K, own["mu"], free=path.STRETCHING)
    v = path.named(path.follow_all(beams, np.broadcast_to(PHI, (len(K), len(PHI)))).rows)
    for values in (v["W_fr"], v["W_snap"]):
        steps = np.diff(values)
        assert (steps[np.isfinite(steps)] >= 0).all()
    missed = v["W"] - v["energy"] - v["W_fr"] - v["W_snap"]
    np.testing.assert_allclose(missed[np.isfinite(missed)], 0, atol=1e-2 * np.nanmax(v["W"]))
    r = squama.response(PHI, **designs)
    np.testing.assert_array_equal(np.isnan(r.W_snap), np.isnan(r.W))
