"""Work of friction: the figures of theory section 4, the balance of energies, the logarithm, the margin."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from oracle.path import path_end
from oracle.vectors import MP, Design
from oracle.work import red, work
from squama.arrays import solution
from squama.errors import ValidityWarning
from squama.model import energy, figures, mechanics
from squama.model.evaluation import NAMES, OPEN, Room
from squama.model.figures import Rules
from squama.model.follow import FRICTIONAL, Followed, follow
from squama.model.paths import ARRAY, FLOAT, Twist

SECTION_4 = {
    "plate": ("0.79735182", "1.9954132", "3.2098540", "4.4256845"),
    "edge": ("0.72050262", "1.7751860", "2.8452067", "3.9166511"),
}
LOCKS = {"plate": (1.194017478, 0.2661368122), "edge": (1.218912547, 0.2690567103)}
MARGINS = (1e-1, 1e-2, 1e-3, 1e-4)
laws = pytest.mark.parametrize("law", ["plate", "edge"])


def paper_beam(**changes) -> squama.Beam:
    return squama.Beam.from_ratios(**changes)


def in_springs(r, beam: squama.Beam, name: str) -> float:
    """Energy per length as a multiple of K_theta / d."""
    return float(r[name]) * beam.pitch / beam.joint_stiffness


@laws
def test_figures_of_section_4(law: str) -> None:
    beam = paper_beam()
    for margin, want in zip(MARGINS, SECTION_4[law], strict=True):
        r = squama.twist(beam, mu=0.5, law=law, margin=margin, points=20, joint="hinge")
        # tolerance: the figures have eight to ten digits
        assert in_springs(r, beam, "W_fr_c") == pytest.approx(float(want), rel=3e-8)
        theta, phi = LOCKS[law]
        assert float(r.theta_end) == pytest.approx(theta, abs=6e-10)
        assert float(r.phi_end) == pytest.approx(phi, abs=6e-11)
        theta0 = math.radians(10)
        assert float(r.theta_c) == pytest.approx(theta0 + (1 - margin) * (float(r.theta_end) - theta0), rel=1e-13)
        assert r.attrs["margin"] == margin


@pytest.mark.slow(but=1)
@laws
@pytest.mark.parametrize("design", [(3, 45, 1.25, 0.45, 10, 0.5), (4, 30, 0.6, 0.32, 5, 0.2)])
def test_work_and_red_against_the_oracle(design: tuple[float, ...], law: str) -> None:
    *shape, mu = design
    d, eta, alpha, beta, lam, theta0 = Design.of(*shape), *shape
    e = path_end(d, MP.mpf(str(mu)), law)
    w = work(d, MP.mpf(str(mu)), law, e, "0.01")
    beam = paper_beam(
        eta=eta, beta=beta, lam=lam, zeta=0.2, alpha=f"{alpha} deg", theta0=f"{theta0} deg", stiffness="2 N m"
    )
    r = squama.twist(beam, mu=mu, law=law, joint="hinge")
    assert in_springs(r, beam, "W_fr_c") == pytest.approx(float(w.W), rel=1e-9)
    stiffness = beam.torsional_rigidity / (beam.joint_stiffness * beam.pitch)
    assert float(r.RED_c) == pytest.approx(float(red(w, stiffness)), rel=1e-9)
    assert float(r.phi_end) == pytest.approx(float(e.phi), rel=1e-12)
    # Eq. 15a: the substrate's and the springs' parts
    Phi, lift = float(r.Phi_c), float(r.theta_c) - beam.scale.theta0
    elastic = beam.torsional_rigidity * Phi**2 / 2 + beam.joint_stiffness * lift**2 / (2 * beam.pitch)
    assert float(r.U_el_c) == pytest.approx(elastic, rel=1e-13)


def work_of_torque(beam: squama.Beam, r, name: str, rate: str, at, law: dict) -> float:
    """Integral of the load from no load to the cut-off: Gauss-Legendre, with the singularity at the end built in."""
    nodes, weights = np.polynomial.legendre.leggauss(80)
    start, cut, last = (float(r[f"{rate}_{w}"]) for w in ("e", "c", "end"))
    y_end = math.log((last - start) / (last - cut))
    y = y_end * (nodes + 1) / 2
    rest = (last - start) * np.exp(-y)
    loads = at(beam, at=last - rest, **law)[name].values
    straight = at(beam, at=[start], **law)[name].values[0] * start / 2
    return straight + float(np.sum(weights * loads * rest)) * y_end / 2


@laws
@pytest.mark.parametrize("changes", [{}, {"alpha": "60 deg", "eta": 5.0}, {"alpha": "40 deg", "beta": 0.8, "eta": 3.5}])
def test_the_work_of_the_torque_is_stored_or_dissipated(changes: dict, law: str) -> None:
    beam = paper_beam(**changes, stiffness="40 N m")
    at = {"mu": 0.4, "law": law, "joint": "hinge"}
    r = squama.twist(beam, **at, points=50)
    assert r.end.item() == "frictional lock"
    done = work_of_torque(beam, r, "T", "Phi", squama.twist, at)
    assert done == pytest.approx(float(r.U_el_c) + float(r.W_fr_c), rel=1e-9)
    # and at every point of the curve: U_el + W_fr by the trapezoid rule of T, to its own accuracy
    fine = squama.twist(beam, **at, points=4000)
    sums = np.concatenate([[0], np.cumsum(np.diff(fine.Phi) * (fine["T"].values[1:] + fine["T"].values[:-1]) / 2)])
    np.testing.assert_allclose(sums, fine.U_el + fine.W_fr, rtol=2e-4, atol=1e-6 * sums[-1])


def test_the_work_of_the_moment_is_stored_or_dissipated() -> None:
    beam = paper_beam(eta=5.0, theta0="5 deg", stiffness="400 N m")
    r = squama.bend(beam, mu=0.3, joint="hinge")
    done = work_of_torque(beam, r, "M", "kappa", squama.bend, {"mu": 0.3, "joint": "hinge"})
    assert done == pytest.approx(float(r.U_el_c) + float(r.W_fr_c), rel=1e-9)


@laws
def test_the_work_grows_like_a_logarithm_and_red_to_one(law: str) -> None:
    beam = paper_beam(stiffness="1e6 N m")
    margins = 10.0 ** -np.arange(2, 9)
    results = [squama.twist(beam, mu=0.5, law=law, margin=m, points=3, joint="hinge") for m in margins]
    W = np.array([in_springs(r, beam, "W_fr_c") for r in results])
    steps = np.diff(W)
    # equal factors of the margin add equal work: the residue of the pole, times ln 10
    assert steps[-1] == pytest.approx(steps[-2], rel=1e-4)
    np.testing.assert_allclose(steps[2:], steps[4], rtol=2e-3)
    x_p = LOCKS[law][0]
    row = Twist(3.0, 1.25, 0.45, math.sqrt(0.5), math.sqrt(0.5), math.radians(10))
    h = 1e-6
    before = row.point(float(results[0].theta_end) - h, law, FLOAT)
    D = -(before.M_N + 0.5 * before.M_f)
    residue = 0.5 * (x_p - math.radians(10)) * before.slip_rate * h / D
    assert steps[4] == pytest.approx(residue * math.log(10), rel=1e-4)
    RED = np.array([float(r.RED_c) for r in results])
    assert np.all(np.diff(RED) > 0)
    elastic = np.array([in_springs(r, beam, "U_el_c") for r in results])
    np.testing.assert_allclose(1 - RED, elastic / (elastic + W), rtol=1e-12)
    assert RED[-1] > 0.93


def test_friction_of_one_is_no_special_case() -> None:
    beam = paper_beam()
    W = [in_springs(squama.twist(beam, mu=mu, joint="hinge"), beam, "W_fr_c") for mu in (1 - 1e-9, 1.0, 1 + 1e-9)]
    assert W[1] == pytest.approx(W[0], rel=1e-7)
    assert W[1] == pytest.approx(W[2], rel=1e-7)
    assert W[1] > 1


def test_no_margin_where_the_end_is_no_lock() -> None:
    beam = paper_beam(alpha="10 deg", theta0="10 deg", beta=0.4, eta=2.0)
    few, most = (squama.twist(beam, mu=0.1, margin=m, points=30, joint="hinge") for m in (0.3, 1e-6))
    assert few.end.item() == most.end.item()
    assert few.end.item() in ("off tip edge", "off side edge", "other contact")
    for name in ("theta_c", "Phi_c", "W_fr_c", "RED_c"):
        assert float(few[name]) == pytest.approx(float(most[name]), rel=1e-12)
    assert float(few.theta_c) == pytest.approx(float(few.theta_end), rel=1e-13)
    assert 0 < float(few.RED_c) < 1


def test_static_lock_and_no_friction_dissipate_nothing() -> None:
    beam = paper_beam()
    for mu, locked in ((9.0, True), (0.0, False)):
        r = squama.twist(beam, mu=mu, joint="hinge")
        assert (r.end.item() == "static lock") == locked
        assert (float(r.theta_c) == beam.scale.theta0) == locked
        assert float(r.W_fr_c) == 0
        assert float(r.RED_c) == 0
        assert np.all(r.W_fr == 0)
        assert np.all(r.RED == 0)


def test_the_series_tells_when_it_has_not_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    row = Twist(3.0, 1.25, 0.45, math.sqrt(0.5), math.sqrt(0.5), math.radians(10))
    end = LOCKS["edge"][0]
    good = energy.work(row, row.theta0, end - 1e-3, end, 0.5, "edge")
    monkeypatch.setattr(energy, "MOST_NODES", 4)
    monkeypatch.setattr(energy, "NODES", 4)
    with pytest.warns(ValidityWarning, match=r"converged to \d"):
        poor = energy.work(row, row.theta0, end - 1e-3, end, 0.5, "edge")
    x = end - 1e-3
    assert poor.coefficients.size < good.coefficients.size
    assert abs(float(poor(x)) / float(good(x)) - 1) > 1e-9
    # the work starts from nothing and the series is its own antiderivative
    assert abs(float(good(row.theta0))) < 1e-10 * float(good(x))
    grid = np.linspace(row.theta0, x, 7)
    assert np.all(np.diff(good(grid)) > 0)


def followed(mu: float, law: str = "edge") -> tuple[Followed, Room]:
    room, half = Room(), math.sqrt(0.5)
    return follow(Twist(3.0, 1.25, 0.45, half, half, math.radians(10)), mu, OPEN, NAMES.index(law), room), room


def series(f: Followed, stop: float, law: str = "edge") -> float:
    row = Twist(f.d.eta, f.d.beta, f.d.lam, f.d.sa, f.d.ca, f.d.theta0)
    return float(energy.work(row, f.x0, stop, f.x_end, f.d.mu, law)(stop))


NO_RULE = Rules(np.zeros(0, np.int64), np.zeros((4, 0)), 0.0)


def test_the_number_of_nodes_grows_until_the_work_is_exact(monkeypatch: pytest.MonkeyPatch) -> None:
    """From few nodes the series and the work of many paths come to the same, also where the work is tiny or large."""
    all_rules = figures.legendre_rules()
    monkeypatch.setattr(figures, "LEGENDRE_SIZES", (3, 5))
    few = figures.legendre_rules.__wrapped__()
    cases = [(*followed(mu), share) for mu, share in ((0.5, 0.999), (1e-9, 0.99), (1.0, 0.3))]
    assert {f.code for f, *_ in cases} == {FRICTIONAL}
    want = []
    for f, room, share in cases:
        reach = f.x_end - f.x0
        stop, y_end = f.x0 + share * reach, -math.log1p(-share)
        want.append(series(f, stop))
        with monkeypatch.context() as patch:
            patch.setattr(energy, "NODES", 8)
            assert series(f, stop) == pytest.approx(want[-1], rel=1e-9, abs=0)
        # rules with too few nodes: the path is taken in parts, and those in parts again
        for rules in (all_rules, few):
            assert figures.worked(f, stop, NO_RULE, rules, room) == pytest.approx(want[-1], rel=1e-9, abs=0)
        got = figures.in_parts(f.d, f.x0, reach, y_end, all_rules, room)
        assert got == pytest.approx(want[-1], rel=1e-10, abs=0)
    monkeypatch.setattr(figures, "DEPTH", 1)
    monkeypatch.setattr(figures, "PARTS", 2)
    f, room, share = cases[0]
    rough = figures.worked(f, f.x0 + share * (f.x_end - f.x0), NO_RULE, few, room)
    assert rough == pytest.approx(want[0], rel=0.1)
    assert rough != pytest.approx(want[0], rel=1e-11)


@pytest.mark.parametrize("margin", [0.3, 0.01, 1e-4])
def test_the_rule_for_a_path_cut_before_its_pole(margin: float) -> None:
    """Fourteen nodes do what the series does, and few do for what the others are asked for."""
    for law in ("edge", "plate"):
        f, room = followed(0.5, law)
        stop = f.x0 + (1 - margin) * (f.x_end - f.x0)
        want = series(f, stop, law)
        for cut in (figures.pole_rules(margin), NO_RULE):
            assert figures.worked(f, stop, cut, figures.legendre_rules(), room) == pytest.approx(want, rel=1e-11)


def test_a_path_that_no_rule_of_the_pole_serves(monkeypatch: pytest.MonkeyPatch) -> None:
    f, room = followed(0.5)
    stop = f.x0 + 0.99 * (f.x_end - f.x0)
    monkeypatch.setattr(figures, "SIZES", (2, 3))
    few = figures.pole_rules.__wrapped__(0.01)
    assert figures.worked(f, stop, few, figures.legendre_rules(), room) == pytest.approx(series(f, stop), rel=1e-9)


def test_a_sharp_corner_of_the_slip_is_cut_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """A folded path on which the slip all but comes to rest and turns: against Gauss sums over 6000 panels."""
    d = {
        "eta": 3.452570707333269,
        "beta": 1.9368477496868548,
        "lam": 0.2529463174266702,
        "alpha": 0.08771552832405677,
        "theta0": 0.29224458450728935,
        "mu": 1.2876723256122566,
    }
    sol = solution.solve({name: np.array([v]) for name, v in d.items()}, law="edge", sense="+")
    ((_, t),) = sol.tracks
    x, w = np.polynomial.legendre.leggauss(20)
    half = (t.x_end - t.x0) / 12_000
    places = t.x0 + half * (2 * np.arange(6000)[:, None] + 1 + x)
    pt = t.row.point(places.ravel(), "edge", ARRAY)
    power = mechanics.forces(pt, d["theta0"], d["mu"]).f * pt.slip_rate
    want = (power.reshape(6000, 20) @ w * half).sum()
    asked = []
    parts = figures.in_parts
    monkeypatch.setattr(figures, "in_parts", lambda *args: asked.append(1) or parts(*args))
    assert squama.solve(**d).W_fr == pytest.approx(want, rel=1e-11)
    assert asked
    # sizes of parts do not matter, but one has to cut
    for few in (2, 5, 40):
        monkeypatch.setattr(figures, "PARTS", few)
        monkeypatch.setattr(figures, "DEPTH", 16)
        assert squama.solve(**d).W_fr == pytest.approx(want, rel=1e-10)
    monkeypatch.setattr(figures, "PARTS", 2)
    monkeypatch.setattr(figures, "DEPTH", 2)
    assert squama.solve(**d).W_fr != pytest.approx(want, rel=1e-10)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("size", [1.0, 1e-12, 1e12])
@pytest.mark.parametrize("pole", [1.01, 1e4])
def test_corners_anywhere(monkeypatch: pytest.MonkeyPatch, size: float, pole: float) -> None:
    """Paths that have a corner in place of a contact's power: the rules see that they do not serve, the parts do.

    Not seen is a corner between the end of a part and its first node, 3 in 200 at most, which makes little.
    """
    n = 200
    places = np.random.default_rng(8).uniform(0.0, 1.0, n)
    f, room = followed(0.5)
    f, rules = f._replace(x0=0.0, x_end=pole), figures.legendre_rules()
    wrong = np.empty((2, n))
    for i, c in enumerate(places):

        def looks(_d: object, room: Room, low: int, high: int, c: float = c) -> None:
            for j in range(low, high):
                room.power[j] = size * abs(room.x[j] - c)

        monkeypatch.setattr(figures, "looks", looks)
        got = (
            figures.worked(f, 1.0, NO_RULE, rules, room),
            figures.in_parts(f.d, 0.0, pole, -math.log1p(-1 / pole), rules, room),
        )
        wrong[:, i] = abs(np.array(got) / (size * (c**2 + (1 - c) ** 2) / 2) - 1)
    # tolerance: of 200 places 1 is not seen, 3 may be
    assert np.all(np.mean(wrong > 1e-9, axis=1) < 0.016)
    assert wrong.max() < 2e-4


def test_no_work_before_the_path_starts() -> None:
    row = Twist(3.0, 1.25, 0.45, math.sqrt(0.5), math.sqrt(0.5), math.radians(10))
    for series in (
        energy.work(row, 0.2, 0.2, 1.0, 0.5, "edge"),
        energy.work(row, 0.2, 0.4, 1.0, 0.0, "edge"),
    ):
        assert np.all(series(np.array([0.2, 0.3])) == 0)


@laws
def test_the_pole_is_at_the_lock_or_ahead(law: str) -> None:
    """Also where the path ends before the lock: the estimate by the slope of D comes near it."""
    one = np.ones(1)
    row = Twist(
        3 * one, 1.25 * one, 0.45 * one, math.sqrt(0.5) * one, math.sqrt(0.5) * one, math.radians(10) * one, one
    )
    lock = LOCKS[law][0]
    mu, x0 = 0.5 * one, row.theta0
    assert float(energy.pole(row, lock * one, mu, law, x0)[0]) == pytest.approx(lock, abs=1e-8)
    early = float(energy.pole(row, (lock - 0.01) * one, mu, law, x0)[0])
    assert early == pytest.approx(lock, abs=1e-3)
    # without a pole ahead it lies far out
    far = float(energy.pole(row, 0.5 * one, 0 * one, "edge", x0)[0])
    assert far > 1.5
