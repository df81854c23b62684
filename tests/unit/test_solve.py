"""squama.solve: arrays of designs give what the single curves give."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from plane import plane
from squama.arrays import solution
from squama.model import energy
from squama.model.outcome import CODES, End
from squama.model.tracks import scalar

LAWS = ("edge", "plate")
solve = squama.solve


def designs(n: int, seed: int = 3) -> dict[str, np.ndarray]:
    """Random designs in wide ranges, folds, static locks and designs that do not engage among them."""
    g = np.random.default_rng(seed)
    return {
        "eta": g.uniform(1.1, 7, n),
        "beta": g.uniform(0.2, 2.2, n),
        "lam": g.uniform(0.1, 1.2, n),
        "alpha": np.radians(g.uniform(1, 85, n)),
        "theta0": np.radians(10 ** g.uniform(-1, 1.6, n)),
        "mu": np.where(g.uniform(size=n) < 0.1, 0.0, 10 ** g.uniform(-2, 0.8, n)),
    }


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("margin", [0.1, 1e-2, 1e-4])
def test_work_of_many_paths_is_that_of_each(law: str, margin: float) -> None:
    d = designs(160)
    solved = solve(**d, law=law, margin=margin)
    sol = solution.solve(d, law=law, sense="+")
    seen = 0
    for index, t in sol.tracks:
        locks = np.isin(t.code, [CODES.index(End.FRICTIONAL), CODES.index(End.KINEMATIC)])
        x_c = energy.cutoff(t.row, t.x0, t.x_end, locks, margin)
        poles = energy.pole(t.row, t.x_end, d["mu"][index], law, t.x0)
        assert np.all(poles >= t.x_end)
        for n, i in enumerate(index):
            one = scalar(t.row, n)
            series = energy.work(one, t.x0[n], float(x_c[n]), float(poles[n]), float(d["mu"][i]), law)
            assert solved.W_fr[i] == pytest.approx(float(series(x_c[n])), rel=1e-8, abs=1e-300)
            seen += solved.W_fr[i] > 0
    assert seen > 80


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("sense", ["+", "-"])
def test_figures_are_those_of_the_curve(law: str, sense: str) -> None:
    d = designs(60, seed=8)
    beams = [
        squama.Beam.from_ratios(
            eta=e, beta=b, lam=la, alpha=float(al), theta0=float(t0), zeta=0.1, slenderness=30, stiffness=2.0
        )
        for e, b, la, al, t0 in zip(*list(d.values())[:5], strict=True)
    ]
    ratio = np.array([b.torsional_rigidity / (b.joint_stiffness * b.pitch) for b in beams])
    solved = solve(**d, stiffness_ratio=ratio, law=law, sense=sense)
    compared = 0
    for i, beam in enumerate(beams):
        r = squama.twist(beam, mu=d["mu"][i], law=law, sense=sense, points=10, joint="hinge")
        if r.end.item() in ("other contact", "no engagement"):
            # the curve looks at all plates, the arrays at tip-side contacts only
            assert float(r.phi_end) <= solved.load_end[i]
            continue
        assert r.end.item() == solved.end[i]
        compared += 1
        K, pitch = beam.joint_stiffness, beam.pitch
        assert solved.load_e[i] == pytest.approx(float(r.phi_e), rel=1e-12)
        assert solved.load_end[i] == pytest.approx(float(r.phi_end), rel=1e-10)
        assert solved.theta_end[i] == pytest.approx(float(r.theta_end), rel=1e-10)
        assert solved.torque[i] * K == pytest.approx(float(r.T_c), rel=1e-9)
        assert solved.U_el[i] * K / pitch == pytest.approx(float(r.U_el_c), rel=1e-9)
        assert solved.W_fr[i] * K / pitch == pytest.approx(float(r.W_fr_c), rel=1e-9, abs=1e-12)
        assert solved.RED[i] == pytest.approx(float(r.RED_c), rel=1e-9, abs=1e-12)
        assert solved.f0[i] == pytest.approx(float(r.f0[-1]), rel=1e-8, abs=1e-12)
    assert compared > (5 if sense == "+" else -1)


def test_ends_are_those_of_squama_ends() -> None:
    d = designs(300, seed=5)
    e, s = squama.ends(**d), solve(**d)
    assert np.array_equal(e.end, s.end)
    assert np.array_equal(e.phi_e, s.load_e)
    assert np.array_equal(e.neighbour, s.neighbour)
    assert np.array_equal(e.phi_end, s.load_end)
    nothing = s.end == "no engagement"
    assert nothing.any()
    assert np.all(np.isinf(s.load_e[nothing]))
    for field in ("f0", "torque", "W_fr", "RED", "U_el", "load_c"):
        assert np.all(getattr(s, field)[nothing] == 0), field
    static = s.end == "static lock"
    assert static.any()
    assert np.all(s.RED[static] == 0)
    assert np.array_equal(s.load_c[static], s.load_e[static])


def test_bending_gives_the_closed_forms() -> None:
    mu = np.array([0.0, 0.3, 0.6, 1.0, 11.0])
    flat = {"beta": 1.0, "lam": 0.0, "alpha": 0.0, "theta0": np.radians(5), "load": "bending"}
    s = solve(eta=5.0, mu=mu, stiffness_ratio=0.1, **flat)
    # tolerance: the figures have five decimals
    assert 5 * s.load_end[:4] == pytest.approx([1.00507, 0.96228, 0.86068, 0.70889], abs=5e-6)
    assert list(s.end) == ["kinematic lock", *["frictional lock"] * 3, "static lock"]
    beam = squama.Beam.from_ratios(eta=5, theta0="5 deg", inclusion_factor=1)
    ratio = beam.bending_rigidity / (beam.joint_stiffness * beam.pitch)
    s = solve(eta=5.0, mu=mu[1], stiffness_ratio=ratio, **flat)
    r = plane(beam, mu=mu[1], points=5)
    assert float(s.torque) * beam.joint_stiffness == pytest.approx(float(r.M_c), rel=1e-10)
    assert float(s.RED) == pytest.approx(float(r.RED_c), rel=1e-10)


def test_the_contact_of_a_short_scale_never_starts_in_bending() -> None:
    s = solve(eta=[0.9, 1.0], beta=1.0, lam=0.0, alpha=0.0, theta0=0.2, mu=0.1, load="bending")
    assert list(s.end) == ["no engagement", "frictional lock"]


def test_shapes_broadcast_and_empty_arrays_come_back() -> None:
    mu = np.linspace(0, 1, 4)
    s = solve(eta=[[3.0], [4.0]], beta=1.25, lam=0.45, alpha=0.8, theta0=0.2, mu=mu)
    assert s.RED.shape == s.end.shape == (2, 4)
    one = solve(eta=4.0, beta=1.25, lam=0.45, alpha=0.8, theta0=0.2, mu=mu[2])
    assert one.RED.shape == ()
    assert float(one.RED) == pytest.approx(s.RED[1, 2], rel=1e-12)
    assert solve(eta=[], beta=1.0, lam=1.0, alpha=0.5, theta0=0.2, mu=0.1).RED.shape == (0,)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"eta": -1.0}, "eta = -1: must be more than 0, up to 100; write e.g. 3"),
        ({"mu": [0.1, -0.2]}, "mu = -0.2: must be 0 or more"),
        ({"alpha": 45.0}, "np.radians(45)"),
        ({"theta0": 0.0}, "theta0 = 0"),
        ({"eta": float("nan")}, "finite number"),
        ({"eta": [1.0, 2.0], "mu": [1.0, 2.0, 3.0]}, "shapes that broadcast"),
        ({"law": "glue"}, 'law = "glue"'),
        ({"sense": "left"}, 'sense = "left"'),
        ({"load": "pulling"}, 'load = "pulling"'),
        ({"margin": 0.0}, "margin = 0"),
        ({"margin": [0.1, 0.2]}, "one number"),
    ],
)
def test_bad_arguments_are_one_line(change: dict[str, object], words: str) -> None:
    given = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": 0.8, "theta0": 0.2, "mu": 0.5, **change}
    with pytest.raises(squama.InputError) as caught:
        squama.solve(**given)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
