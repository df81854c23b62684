"""Section constants against a second series and the textbook's table; the joint's laws and their ranges."""

import math
import random

import mpmath as mp
import pytest

from squama.model import joint, neighbours, section
from squama.model.paths import FLOAT, Twist


def _prandtl_double_sine(a, b, terms):
    """J by the Navier double series of Prandtl's stress function: independent of the tanh series."""
    odd = range(1, terms, 2)
    total = sum(1 / (m * m * n * n * (m * m / a**2 + n * n / b**2)) for m in odd for n in odd)
    # J is twice the stress function's integral over the section, for unit G Phi
    return 256 / math.pi**6 * a * b * total


# Roark's Formulas for Stress and Strain, 8th ed., Table 10.7 / Timoshenko and Goodier: J = k a b^3
@pytest.mark.parametrize(
    ("ratio", "k"),
    [(1, 0.1406), (1.5, 0.196), (2, 0.229), (2.5, 0.249), (3, 0.263), (4, 0.281), (5, 0.291), (10, 0.312)],
)
def test_torsion_constant_matches_the_textbook(ratio, k):
    # tolerance: the table's digits
    assert section.torsion_constant(ratio * 0.7, 0.7) / (ratio * 0.7**4) == pytest.approx(k, abs=5.5e-4)


@pytest.mark.parametrize("sides", [(1.0, 1.0), (32.0, 16.0), (1.0, 3.7)])
def test_torsion_constant_matches_the_double_series(sides):
    # the tail of the double series falls like 1 / terms^3
    assert section.torsion_constant(*sides) == pytest.approx(_prandtl_double_sine(*sides, 400), rel=2e-6)


@pytest.mark.parametrize("ratio", [1, 1.001, 2, 5, 300, 1e6])
def test_torsion_constant_is_exact_to_double_precision(ratio):
    with mp.workdps(30):
        tail = mp.nsum(lambda k: mp.tanh((2 * k + 1) * mp.pi * mp.mpf(ratio) / 2) / (2 * k + 1) ** 5, [0, mp.inf])
        exact = mp.mpf(ratio) / 3 - 64 / mp.pi**5 * tail
    assert section.torsion_constant(ratio, 1.0) == pytest.approx(float(exact), rel=1e-13)
    assert section.torsion_constant(1.0, ratio) == section.torsion_constant(ratio, 1.0)


@pytest.mark.parametrize(("length", "elements"), [(5, 1.077), (12, 1.032), (25, 1.016)])
def test_plane_clamps_against_elements(length, elements):
    """Nonlinear elements of the bar of stiff_skin at rest, docs: a finite row."""
    ratio = section.clamped_ratio(1.4, 0.7, length, 0.49)
    # tolerance: of what clamps add; the elements' mesh adds some
    assert ratio - 1 == pytest.approx(elements - 1, rel=0.15)
    assert section.clamped_ratio(0.7, 1.4, length, 0.49) == pytest.approx(ratio, rel=1e-9)


def test_clamps_of_a_thin_strip_are_vlasovs():
    """Warping x y, Gamma = (w t)^3/144; J/I vanishes with t/w, and a long strip loses a length at each end."""
    w, t, nu, long = 1.0, 1e-3, 0.3, 100.0
    lost = long / 2 * (1 - 1 / section.clamped_ratio(w, t, long, nu))
    assert lost == pytest.approx(w * math.sqrt(2 * (1 + nu) * 3 / 144), rel=5e-3)


def test_the_papers_section():
    # tolerance: the figures have so many digits
    assert section.torsion_constant(32, 16) == pytest.approx(29974, abs=0.5)
    assert section.polar_moment(32, 16) == pytest.approx(54613, abs=0.5)
    assert section.warping_coefficient(32, 16) == pytest.approx(0.549, abs=5e-4)
    assert section.bending_moment_of_area(32, 16) == pytest.approx(32 * 16**3 / 12)
    assert section.shear_modulus(25e9, 0.25) == pytest.approx(10e9)
    # the second moments about both axes add to the polar one
    both = section.bending_moment_of_area(32, 16) + section.bending_moment_of_area(16, 32)
    assert section.polar_moment(32, 16) == pytest.approx(both)


def test_joint_laws_at_fig_6b():
    # d = 1, E_B = 1: fe.md gives .01269 and 1.449 for the paper's laws
    # tolerance: the figures have four digits
    assert joint.stiffness(1, 0.004, 0.6, 0.18) == pytest.approx(0.01269, rel=5e-4)
    assert joint.inclusion_twisting(0.18, 0.6, 0.32) == pytest.approx(1.449, abs=5e-4)
    assert joint.inclusion_bending(0.18, 0.6, 0.32) == 1


INSIDE = {"t_s/d": 0.004, "L/d": 0.18, "L/(2t)": 0.28, "t_s/(l + L)": 0.0013, "zeta beta/lambda": 0.34}


@pytest.mark.parametrize(
    ("load", "ratio", "value"),
    [
        ("stiffness", "t_s/d", 0.0019),
        ("stiffness", "t_s/d", 0.017),
        ("stiffness", "L/d", 0.08),
        ("stiffness", "L/d", 0.37),
        ("stiffness", "L/(2t)", 0.6),
        ("stiffness", "t_s/(l + L)", 0.06),
        ("inclusion twisting", "zeta beta/lambda", 1.1),
    ],
)
def test_each_limit_is_told(load, ratio, value):
    law = joint.LAWS[load]
    assert joint.outside(law, INSIDE) == []
    (line,) = joint.outside(law, INSIDE | {ratio: value})
    for words in (law.name, ratio, f"{value:.3g}", "outside its range", law.remedy):
        assert words in line


def test_the_limits_belong_to_the_range():
    law = joint.LAWS["stiffness"]
    for limit in law.limits:
        assert joint.outside(law, INSIDE | {limit.ratio: limit.high * (1 + 1e-15)}) == []


def _thick_condition(phi, eta, beta, lam, alpha, theta0, tau):
    """Lower tip edge of scale 1 against the upper side edge of scale 2, as explicit plates with mpmath."""
    sa, ca, st, ct = mp.sin(alpha), mp.cos(alpha), mp.sin(theta0), mp.cos(theta0)
    x = mp.matrix([-sa * ct, st, ca * ct])
    y = mp.matrix([ca, 0, sa])

    def cross(u, v):
        return mp.matrix([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]])

    z = cross(x, y)
    base = mp.matrix([0, lam, 0])
    turn = mp.matrix([[mp.cos(phi), mp.sin(phi), 0], [-mp.sin(phi), mp.cos(phi), 0], [0, 0, 1]])
    tip = base + eta * x - tau / 2 * z
    side = turn * (base - beta * y + tau / 2 * z) + mp.matrix([0, 0, 1])
    normal = cross(y, turn * x)
    gap = tip - side
    return sum(gap[i] * normal[i] for i in range(3))


def meets(eta, beta, lam, alpha, theta0, tau=0.0):
    row = Twist(eta, beta, lam, math.sin(alpha), math.cos(alpha), theta0, thickness=tau)
    return neighbours.meets(row, FLOAT)


def test_thick_plates_engage_where_their_edges_meet():
    rng = random.Random(7)
    met = 0
    for _ in range(60):
        eta, beta, lam = rng.uniform(1.5, 6), rng.uniform(0.3, 2), rng.uniform(0.2, 0.7)
        alpha, theta0 = math.radians(rng.uniform(15, 70)), math.radians(rng.uniform(3, 25))
        tau = rng.uniform(0, 0.9) * math.cos(alpha) * math.sin(theta0)
        phi = meets(eta, beta, lam, alpha, theta0, tau)
        if not phi > 0:
            continue
        met += 1
        args = (eta, beta, lam, alpha, theta0, tau)
        assert abs(_thick_condition(phi, *args)) < 1e-13
        # open all the way up to it: the smallest root
        assert all(_thick_condition(phi * i / 50, *args) < 0 for i in range(50))
    assert met > 50


def test_thin_plates_engage_as_the_model_says():
    a, t = math.radians(45), math.radians(10)
    # fe.md: .05905 at Fig. 6b
    # tolerance: the figure has five decimals
    assert meets(3, 0.6, 0.32, a, t) == pytest.approx(0.05905, abs=5e-6)
    assert meets(3, 0.6, 0.32, a, t, math.cos(a) * math.sin(t)) == pytest.approx(0, abs=1e-15)
