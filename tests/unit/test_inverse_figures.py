"""Figures that a target may name: against the responses of single beams, and derivatives against differences."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import squama
from squama.inverse.hinge_figures import evaluate
from squama.inverse.limits import LIMITS, Sizes, shear_factor
from squama.inverse.named_figures import At, Options, Want, flat, harmless
from squama.inverse.residuals import MISSING, Residuals
from squama.inverse.search import lsi
from squama.inverse.space import Space, Variable, cells_of
from squama.inverse.target import read_target
from squama.model.sensitivity import STEP
from squama.study.columns import beam_at, columns
from squama.study.parameters import FACTOR

BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
RANGES = {
    "scale.length": (0.03, 0.08),
    "scale.width": (0.015, 0.03),
    "scale.embedded": (0.004, 0.008),
    "scale.thickness": (0.0006, 0.001),
    "alpha": (0.9, 1.25),
    "theta0": (0.1, 0.3),
    "beam.pitch": (0.015, 0.025),
    "substrate.thickness": (0.01, 0.02),
    "mu": (0.1, 0.4),
    "substrate.youngs_modulus": (1e6, 2e6),
}
N = 14
WANTS = [
    *(Want(f) for f in ("engagement", "lock", "range", "stiffness", "RED", "W_fr", "critical_mu", "reach")),
    Want("torque", At(0, 0.09)),
    Want("torque", At(3.0, 0)),
    Want("tangent", At(0, 0.09)),
    Want("tangent", At(4.0, 0)),
]


def sample():
    rng = np.random.default_rng(0)
    return {key: rng.uniform(*span, N) for key, span in RANGES.items()}


def cells(values, load):
    return flat(columns(BEAM, values, load=load))


def test_the_factor_of_a_joint_is_a_column_as_the_others_are():
    c = flat(columns(BEAM, {FACTOR: np.array([0.5, 1.0, 2.0]), "scale.length": np.array([[0.05], [0.06]])}))
    assert c.joint_factor.tolist() == [0.5, 1.0, 2.0] * 2
    assert c.eta.shape == (6,)
    assert harmless(c, np.array([True, True, False] * 2)).joint_factor.tolist() == [0.5, 1.0, 1.0] * 2


@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_figures_are_those_of_the_responses(load):
    values = sample()
    found = evaluate(cells(values, load), [], WANTS, Options(load=load), plates=True)
    locked = 0
    for i in range(N):
        beam = beam_at(BEAM, load, {key: float(v[i]) for key, v in values.items()})
        respond, angle, torque, tangent = {
            "twisting": (functools.partial(squama.twist, joint="hinge"), "phi", "T", "K_t"),
            "bending": (functools.partial(squama.bend, joint="hinge"), "psi", "M", "K_b"),
        }[load]
        r = respond(beam, at=[0.09 / beam.pitch, 3.0, 4.0])
        lock = squama.End(r.end.item()).locks
        locked += lock
        at_lock = {
            "lock": float(r[f"{angle}_end"]),
            "range": float(r[f"{angle}_end"] - r[f"{angle}_e"]),
            "RED": float(r.RED_c),
            "W_fr": float(r.W_fr_c),
        }
        expected = [
            float(r[f"{angle}_e"]),
            *(at_lock[name] if lock else np.nan for name in ("lock", "range")),
            beam.torsional_rigidity if load == "twisting" else beam.bending_rigidity,
            *(at_lock[name] if lock else np.nan for name in ("RED", "W_fr")),
            float(r.mu_static),
            np.nan,
            *r[torque].values[:2],
            r[tangent].values[0],
            r[tangent].values[2],
        ]
        for want, value, other in zip(WANTS, found.values[:, i], expected, strict=True):
            if want.figure == "reach" or not np.isfinite(other):
                assert want.figure == "reach" or np.isnan(value), want
            else:
                assert value == pytest.approx(other, rel=1e-9), want
        if np.isfinite(r[f"{angle}_end"]):
            assert found.load_end[i] == pytest.approx(float(r[f"{angle}_end"]), rel=1e-12)
    assert locked >= 4


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_derivatives_against_central_differences(load):
    values = sample()
    options = Options(load=load)
    inside = [Want("tip"), Want("side")] if load == "twisting" else []
    wants = [*WANTS, *inside]
    moved = [cells({**values, key: values[key] + 1j * STEP}, load) for key in RANGES]
    found = evaluate(cells(values, load), moved, wants, options, plates=True)
    tested = np.zeros(len(wants), int)
    for j, key in enumerate(RANGES):
        h = 1e-5 * values[key]
        up, down = (
            evaluate(cells({**values, key: values[key] + s * h}, load), [], wants, options, plates=True)
            for s in (1, -1)
        )
        differences = (up.values - down.values) / (2 * h)
        scale = np.nanmax(np.abs(found.slopes[:, j]), axis=1)[:, None] + np.abs(found.values / values[key])
        error = np.abs(differences - found.slopes[:, j]) / scale
        smooth = (up.code == found.code) & (down.code == found.code) & np.isfinite(error)
        assert np.all(error[smooth & np.ones_like(error, bool)] < 1e-6), key
        tested += smooth.sum(axis=1)
    assert (tested >= 30).all()


@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_slopes_of_residuals_and_limits_against_central_differences(load):
    """With twists asked as rates, so that the asked value moves with the pitch."""
    words = {"twisting": "torque", "bending": "moment"}[load]
    limits = {"strain": 0.4, "gap": "1 mm"} if load == "twisting" else {"gap": "1 mm"}
    data = {
        "load": load,
        "vary": {"scale.length": ("40 mm", "80 mm"), "scale.theta0": ("6 deg", "15 deg"), "beam.pitch": (0.015, 0.025)},
        "target": {
            "lock": ">= 20 rad/m",
            "engagement": "2 rad/m",
            "points": [{"twist": "3.5 rad/m", words: "0.1 N m", "weight": 2}, {"twist": "0.06 rad/pitch", words: 0.1}],
            "tangent": [{"twist": "4.5 rad/m", "stiffness": 0.1}],
        },
        "limits": limits,
    }
    at = Residuals(read_target(data, beam=BEAM))
    y = np.random.default_rng(3).uniform(0.1, 0.9, (60, 3))
    found, h = at.look(y, slopes=True, plates=False), 1e-6
    tested = []
    for j in range(3):
        up, down = (at.look(y + s * h * (np.arange(3) == j), slopes=False, plates=False) for s in (1, -1))
        for slopes, a, b in ((found.J[:, j], up.r, down.r), (found.G[:, j], up.g, down.g)):
            differences = (a - b) / (2 * h)
            # not across the border of what is smooth, nor where a figure is not there
            smooth = (np.abs(differences) < 1e3) & (up.code == down.code)
            smooth &= (np.abs(a) < MISSING) & (np.abs(b) < MISSING)
            error = np.abs(differences - slopes) / (1 + np.abs(differences))
            assert np.all(error[smooth] < 1e-5), j
            tested.append((smooth & (slopes != 0)).sum(axis=1))
    assert (np.concatenate(tested[0::2]).reshape(3, -1).sum(axis=0) >= 10).all()
    assert (np.concatenate(tested[1::2]).reshape(3, -1).sum(axis=0) >= 10).all()


def test_a_twist_that_is_not_reached_counts_by_how_much_it_lacks():
    data = {
        "joint": "hinge",
        "vary": {"scale.length": ("40 mm", "80 mm")},
        "target": {"points": [{"twist": "0.2 rad/pitch", "torque": 1}]},
    }
    at = Residuals(read_target(data, beam=BEAM))
    found = at.look(np.linspace(0, 1, 9)[:, None], slopes=False, plates=False)
    end, (r,) = found.load_end, found.r
    there = end > 0.2
    assert 0 < there.sum() < 9
    np.testing.assert_allclose(r[~there], MISSING + (0.2 - end[~there]) / 0.2)
    assert (np.abs(r[there]) < MISSING).all()


def test_the_unit_cube_is_divided_evenly_or_in_equal_ratios():
    space = Space(BEAM, "twisting", (Variable("scale.length", 0.03, 0.08), Variable("scale.thickness", 1e-4, 1e-2)))
    y = np.array([[0.0, 0.0], [0.5, 0.5], [0.25, 0.75], [1.0, 1.0]])
    length, thickness = space.values(y).values()
    np.testing.assert_allclose(length, [0.03, 0.055, 0.0425, 0.08])
    np.testing.assert_allclose(thickness, [1e-4, 1e-3, 1e-2 / np.sqrt(10), 1e-2])
    for point, *sizes in zip(y, length, thickness, strict=True):
        values = dict(zip((v.key for v in space.variables), sizes, strict=True))
        np.testing.assert_allclose(space.place(values), point, atol=1e-12)
    outside = dict(zip((v.key for v in space.variables), (0.01, 1.0), strict=True))
    np.testing.assert_allclose(space.place(outside), [0, 1])
    # steps are those of the cube
    by_length, by_thickness = space.moved(y)
    np.testing.assert_allclose(np.imag(by_length.sizes["scale"]["length"]) / STEP, 0.05)
    np.testing.assert_allclose(np.imag(by_thickness.sizes["scale"]["thickness"]) / STEP, thickness * np.log(100))


def test_limits_measure_what_they_say():
    beam = BEAM
    s = Sizes.of(cells_of(beam, "twisting", {}, 1), "twisting", 3.0)
    got = {name: float(np.ravel(limit.measure(s))[0]) for name, limit in LIMITS.items()}
    a, t0, d = beam.scale.alpha, beam.scale.theta0, beam.pitch
    # two neighbouring base lines on the surface: distance along the axis d, along their normal d cos(alpha)
    normal = np.array([-np.sin(a) * np.sin(t0), -np.cos(t0), np.cos(a) * np.sin(t0)])
    assert got["gap"] == pytest.approx(abs(normal @ [0, 0, d]) - beam.scale.thickness)
    assert got["web"] == pytest.approx(d * np.cos(a) - beam.scale.thickness / np.sin(t0))
    assert got["edge"] == pytest.approx((0.032 - 0.024 * np.cos(a)) / 2)
    assert got["cover"] == pytest.approx(0.016 - 0.006 * np.sin(t0))
    assert got["overlap"] == pytest.approx(3)
    assert got["beam_length"] == pytest.approx(0.5)
    assert got["scale_thickness"] == pytest.approx(0.0008)
    # Timoshenko's table for a bar twice as wide as thick: 0.930
    # tolerance: the table's three digits
    assert got["strain"] == pytest.approx(3.0 * 0.016 * 0.930, rel=1e-3)
    assert shear_factor(1e3, 1.0) == pytest.approx(1)
    assert shear_factor(1.0, 3.0) == shear_factor(3.0, 1.0) == pytest.approx(0.985, abs=5e-4)


def test_least_squares_under_inequalities_against_slsqp():
    from scipy.optimize import minimize

    rng = np.random.default_rng(2)
    apart = 0
    for _ in range(40):
        E, f, G = rng.normal(size=(5, 3)), rng.normal(size=5), rng.normal(size=(4, 3))
        h = G @ rng.normal(size=3) - 0.1
        x = lsi(E, f, G, h)
        assert x is not None
        assert (G @ x >= h - 1e-9).all()
        other = minimize(
            lambda v, E=E, f=f: ((E @ v - f) ** 2).sum(),
            np.zeros(3),
            method="SLSQP",
            constraints={"type": "ineq", "fun": lambda v, G=G, h=h: G @ v - h},
            options={"ftol": 1e-14, "maxiter": 500},
        )
        assert ((E @ x - f) ** 2).sum() <= other.fun + 1e-6
        apart += np.abs(x - np.linalg.lstsq(E, f, rcond=None)[0]).max() > 1e-3
    assert apart > 10
    # a row of zeros holds, or never
    for bound, expected in ((-1.0, [1.0]), (1.0, None)):
        x = lsi(np.eye(1), np.zeros(1), np.array([[0.0], [1.0]]), np.array([bound, 1.0]))
        assert x is None if expected is None else x == pytest.approx(expected)
    assert lsi(np.eye(1), np.zeros(1), np.array([[1.0], [-1.0]]), np.array([1.0, 0.0])) is None
