"""Inverse design: known beams recovered, brute force, round trips through files, tolerances, what cannot be reached."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from squama.inverse.residuals import Residuals
from squama.inverse.target import read_target

pytestmark = pytest.mark.usefixtures("unasked")
BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
DENSE = BEAM.replace(pitch="14 mm", scale={"width": "20 mm"})
VARY = {
    "scale.length": ("30 mm", "80 mm"),
    "scale.alpha": ("40 deg", "70 deg"),
    "beam.pitch": ("12 mm", "25 mm"),
}


def find(target, vary=VARY, *, beam=BEAM, limits=None, starts=256, **more):
    extra = {name: more.pop(name) for name in ("joint", "law", "sense", "load", "margin", "tolerance") if name in more}
    data = {"target": target, "vary": vary, "limits": limits or {}, **extra}
    return squama.inverse_design(data, beam=beam, starts=starts, **more)


def again(design, tmp_path, load="twisting", **arguments):
    """Respond to the design's own file."""
    path = tmp_path / "again.toml"
    path.write_text(design.to_toml("a test"))
    beam = squama.Beam.from_toml(path)
    door = squama.twist if load == "twisting" else squama.bend
    return beam, door(beam, joint="hinge", **arguments)


def test_every_design_does_what_is_said_of_it(tmp_path):
    found = find({"lock": "120 deg total", "stiffness": "at most 0.05 N m^2", "RED": "at least 0.3"}, designs=4)
    assert found.met
    assert len(found) == 4
    for d in found.designs:
        assert d.met
        beam, r = again(d, tmp_path)
        lock, stiffness, red = d.goals
        assert squama.End(r.end.item()).locks
        assert math.degrees(float(r.phi_end)) * beam.pitches == pytest.approx(lock.reached, rel=1e-9)
        assert lock.reached == pytest.approx(120, rel=1e-9)
        assert beam.torsional_rigidity == pytest.approx(stiffness.reached, rel=1e-9)
        assert float(r.RED_c) == pytest.approx(red.reached, rel=1e-9)
        assert stiffness.reached <= 0.05 * 1.01
        assert red.reached >= 0.3 * 0.99
        for name, value in d.values.items():
            low, high = found.bounds[name]
            assert low <= value <= high
            table, _, key = name.partition(".")
            assert value == (beam.pitch if table == "beam" else getattr(getattr(beam, table), key))
        assert beam.scale.width * math.cos(beam.scale.alpha) <= beam.substrate.width
    for i, a in enumerate(found.designs):
        for b in found.designs[:i]:
            apart = [abs(a.values[n] - b.values[n]) / (high - low) for n, (low, high) in found.bounds.items()]
            assert max(apart) >= 0.1


def test_a_known_beam_is_recovered():
    truth = DENSE
    r = squama.twist(truth, at=["60 deg total", "100 deg total"], joint="hinge")
    points = [
        {"twist": t, "torque": float(v)} for t, v in zip(("60 deg total", "100 deg total"), r["T"].values, strict=True)
    ]
    lock = f"{math.degrees(float(r.phi_end)) * truth.pitches!r} deg total"
    vary = {"scale.length": ("40 mm", "80 mm"), "scale.alpha": ("45 deg", "70 deg"), "friction.mu": (0.05, 0.5)}
    start = truth.replace(scale={"length": "45 mm", "alpha": "50 deg"}, friction={"mu": 0.1})
    found = find({"lock": lock, "points": points}, vary, beam=start, starts=64)
    assert found.met
    best = found[0].beam
    assert best.scale.length == pytest.approx(truth.scale.length, rel=1e-6)
    assert best.scale.alpha == pytest.approx(truth.scale.alpha, rel=1e-6)
    assert best.friction.mu == pytest.approx(truth.friction.mu, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["edge", "plate"])
def test_brute_force_finds_no_better_beam(law):
    vary = {"scale.length": ("40 mm", "70 mm"), "scale.alpha": ("50 deg", "68 deg")}
    point = {"twist": "80 deg total", "torque": "3 N m"}
    target = {"lock": "150 deg total", "points": [point]}
    data = {"target": target, "vary": vary, "limits": {"gap": "1.4 mm"}, "law": law}
    found = squama.inverse_design(data, beam=BEAM)
    problem = Residuals(read_target(data, beam=BEAM))
    side = np.linspace(0, 1, 61)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    brute = problem.look(grid, slopes=False, plates=False)
    kept = (brute.g >= 0).all(axis=0) & np.isfinite(brute.merit)
    best = problem.look(
        problem.space.place({"scale.length": found[0].values["scale.length"], "alpha": found[0].values["scale.alpha"]})[
            None
        ],
        slopes=False,
        plates=True,
    )
    assert not found.met
    assert found[0].active
    assert float(best.merit[0]) <= brute.merit[kept].min() + 1e-12
    # and the grid is fine enough to come near
    assert brute.merit[kept].min() <= 1.2 * float(best.merit[0]) + 1e-3


@pytest.mark.slow
def test_what_cannot_be_reached_names_what_holds_it(tmp_path):
    found = find({"lock": "40 deg total"}, {"scale.length": ("40 mm", "60 mm"), "beam.pitch": ("18 mm", "25 mm")})
    assert not found.met
    d = found[0]
    assert d.active == ("scale.length at its upper bound 60 mm", "beam.pitch at its lower bound 18 mm")
    assert d.goals[0].difference == pytest.approx(d.goals[0].reached - 40)
    assert d.goals[0].difference > 0
    nearest = BEAM.replace(pitch="18 mm", scale={"length": "60 mm"})
    r = squama.twist(nearest, points=3, joint="hinge")
    assert d.goals[0].reached == pytest.approx(math.degrees(float(r.phi_end)) * 25, rel=1e-9)
    assert d.beam.pitch == pytest.approx(nearest.pitch, rel=1e-9)


@pytest.mark.slow
def test_a_limit_that_holds_the_nearest_beam():
    vary, limits = {"scale.theta0": ("5 deg", "20 deg")}, {"gap": "0.9 mm"}
    found = find({"engagement": "2 deg total"}, vary, limits=limits, joint="hinge")
    assert found[0].active == ("limit gap 0.9 mm",)
    beam = found[0].beam
    gap = beam.pitch * math.sin(beam.scale.theta0) * math.cos(beam.scale.alpha) - beam.scale.thickness
    assert gap == pytest.approx(0.9e-3, rel=1e-6)
    assert gap >= 0.9e-3 * (1 - 1e-9)


@pytest.mark.slow
def test_a_beam_that_does_not_lock_is_no_lock(tmp_path):
    vary = {"scale.alpha": ("5 deg", "20 deg"), "scale.length": ("30 mm", "50 mm")}
    found = find({"lock": "120 deg total"}, vary)
    assert not found.met
    assert math.isnan(found[0].goals[0].reached)
    _, r = again(found[0], tmp_path, points=3)
    assert r.end.item() == found[0].end
    assert not squama.End(found[0].end).locks


@pytest.mark.slow
def test_other_contacts_of_the_plates_are_looked_for():
    # with little friction the lock comes late, and other plates often meet before
    vary = {"scale.length": ("25 mm", "80 mm"), "scale.width": ("10 mm", "60 mm"), "scale.alpha": ("20 deg", "75 deg")}
    data = {"target": {"lock": "at least 100 deg total"}, "vary": vary, "limits": {"edge": False}}
    start = BEAM.replace(friction={"mu": 0.05})
    problem = Residuals(read_target(data, beam=start))
    y = np.random.default_rng(0).random((150, 3))
    alone, all_plates = (problem.look(y, slopes=False, plates=plates) for plates in (False, True))
    cut = np.flatnonzero(np.isfinite(alone.values[0]) & np.isnan(all_plates.values[0]))
    assert cut.size > 3
    for i in cut[:3]:
        r = squama.twist(problem.space.beam_of(y[i]), points=3, joint="hinge")
        assert r.end.item() == "other contact"
    found = squama.inverse_design(data, beam=start, starts=256)
    assert found.met
    for d in found.designs:
        assert squama.twist(d.beam, points=3, joint="hinge").end.item() == d.end
        assert squama.End(d.end).locks
    # without friction they always do
    found = squama.inverse_design(data, beam=BEAM.replace(friction={"mu": 0.0}), starts=128)
    assert not found.met
    assert squama.twist(found[0].beam, points=3, joint="hinge").end.item() == found[0].end == "other contact"
    assert found[0].other_contact


@pytest.mark.slow
def test_tolerances_against_changed_beams():
    found = find(
        {"lock": "120 deg total", "critical_mu": "at least 1"}, tolerance={"scale.length": "0.3 mm", "relative": "2 %"}
    )
    d = found[0]
    assert found.tolerance["scale.length"] == 3e-4
    assert found.tolerance["friction.mu"] == pytest.approx(0.02 * BEAM.friction.mu)
    assert found.tolerance["scale.width"] == 1e-4

    def reached(beam):
        r = squama.twist(beam, points=3, joint="hinge")
        return math.degrees(float(r.phi_end)) * beam.pitches, float(r.mu_static)

    for name, size in found.tolerance.items():
        table, _, key = name.partition(".")
        ends = []
        for step in (1e-4, -1e-4):
            old = d.beam.pitch if table == "beam" else getattr(getattr(d.beam, table), key)
            new = old + step * size
            ends.append(reached(d.beam.replace(**({"pitch": new} if table == "beam" else {table: {key: new}}))))
        for goal, up, down in zip(d.goals, *ends, strict=True):
            assert goal.effects[name] == pytest.approx((up - down) / 2e-4, rel=1e-5, abs=1e-6 * goal.spread)
    for goal in d.goals:
        assert goal.spread == pytest.approx(math.sqrt(sum(v**2 for v in goal.effects.values())))
    spreads = [x.goals[0].spread for x in found.designs]
    assert spreads == sorted(spreads)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("text", "reached"),
    [
        ("6 rad/m", lambda r, beam: float(r.Phi_end)),
        ("0.1 rad/pitch", lambda r, beam: float(r.phi_end)),
        ("130 deg total", lambda r, beam: math.degrees(float(r.phi_end)) * 25),
    ],
)
def test_a_twist_keeps_its_meaning_while_the_pitch_changes(text, reached, tmp_path):
    found = find({"lock": text}, {**VARY, "beam.pitch": ("12 mm", "22 mm")}, designs=3)
    assert found.met
    assert len({round(d.beam.pitch, 4) for d in found.designs}) == 3
    for d in found.designs:
        beam, r = again(d, tmp_path, points=3)
        assert reached(r, beam) == pytest.approx(float(text.split()[0]), rel=1e-9)
        pitch = d.goals[0].effects["beam.pitch"]
        h = 1e-5
        up, down = (squama.twist(beam.replace(pitch=beam.pitch + x), points=3, joint="hinge") for x in (h, -h))
        assert pitch == pytest.approx((reached(up, beam) - reached(down, beam)) / (2 * h) * 1e-4, rel=1e-3)


@pytest.mark.slow
def test_a_curve_and_a_tangent(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    truth = DENSE
    r = squama.twist(truth, to="100 deg total", points=60, joint="hinge")
    degrees = np.degrees(r.phi.values) * 25
    lines = [f"{x},{t * 1e3}" for x, t in zip(degrees, r["T"].values, strict=True)]
    (tmp_path / "test.csv").write_text("\n".join(["total (deg), T (N mm)", *lines]))
    vary = {"scale.length": ("40 mm", "80 mm"), "substrate.youngs_modulus": ("0.5 MPa", "5 MPa")}
    start = truth.replace(scale={"length": "50 mm"}, substrate={"youngs_modulus": "1 MPa"})
    found = find({"curve": "test.csv"}, vary, beam=start, joint="hinge")
    assert found.met
    assert found[0].goals[0].reached < 1e-6
    assert found[0].values["scale.length"] == pytest.approx(0.06, rel=1e-6)
    assert found[0].values["substrate.youngs_modulus"] == pytest.approx(1.5e6, rel=1e-6)
    tangent = {"twist": "80 deg total", "stiffness": "2 N m^2"}
    found = find({"tangent": [tangent]}, {"scale.length": ("40 mm", "80 mm")}, beam=truth, joint="hinge")
    assert found.met
    _, r = again(found[0], tmp_path, at="80 deg total")
    assert float(r.K_t[0]) == pytest.approx(2, rel=1e-8)


def test_bending_and_the_kind_of_lock(tmp_path):
    truth = squama.bend(BEAM.replace(pitch="15 mm", scale={"length": "70 mm"}), at="100 deg total", joint="hinge")
    lock = math.degrees(float(truth.psi_end)) * 25
    point = {"twist": "100 deg total", "moment": float(truth["M"][0])}
    vary = {"scale.length": ("30 mm", "80 mm"), "beam.pitch": ("12 mm", "25 mm")}
    found = find({"lock": f"{lock!r} deg total", "points": [point]}, vary, load="bending", starts=64, designs=2)
    assert found.met
    for d in found.designs:
        _, r = again(d, tmp_path, "bending", at="100 deg total")
        assert math.degrees(float(r.psi_end)) * 25 == pytest.approx(lock, rel=1e-9)
        assert float(r["M"][0]) == pytest.approx(d.goals[1].reached, rel=1e-9)
        assert d.goals[1].reached == pytest.approx(float(truth["M"][0]), rel=1e-6)
    vary = {"friction.mu": (0.2, 9), "scale.length": ("30 mm", "80 mm")}
    static = find({"lock": "65 deg total", "lock_by": "static"}, vary, starts=64)
    assert static.met
    assert {d.end for d in static.designs} == {"static lock"}
    assert find(
        {"lock": "at most 100 deg total", "critical_mu": 0.5}, {"scale.theta0": ("1 deg", "60 deg"), **vary}, starts=64
    ).designs


@pytest.mark.slow
def test_the_same_seed_gives_the_same_designs():
    one, two = (find({"lock": "120 deg total"}, starts=256) for _ in range(2))
    assert one.designs == two.designs
    other = find({"lock": "120 deg total"}, starts=256, seed=7)
    assert [d.values for d in other.designs] != [d.values for d in one.designs]


@pytest.mark.slow
def test_what_has_no_effect_stays_and_is_named():
    vary = {**VARY, "substrate.youngs_modulus": ("1 MPa", "3 MPa")}
    found = find({"lock": "120 deg total"}, vary)
    no_effect, lock = found.notes
    assert no_effect == "substrate.youngs_modulus has no effect on the goals"
    assert lock.startswith("only thin, rigid scales on hinges lock")
    assert {d.beam.substrate.youngs_modulus for d in found.designs} == {1.5e6}


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "law"), [(0, "edge"), (1, "plate"), (5, "edge")])
def test_four_figures_of_a_random_beam_are_met_together(seed, law):
    rng = np.random.default_rng(seed)
    while True:
        sizes = {name: float(rng.uniform(*span)) for name, span in (("length", (0.03, 0.08)), ("alpha", (0.5, 1.2)))}
        truth = BEAM.replace(pitch=float(rng.uniform(0.012, 0.025)), scale=sizes, friction={"mu": 0.3})
        r = squama.twist(truth, law=law, points=3, joint="hinge")
        if squama.End(r.end.item()).locks:
            break
    phi = 0.3 * float(r.phi_e) + 0.7 * float(r.phi_end)
    torque = float(squama.twist(truth, law=law, at=phi / truth.pitch, joint="hinge")["T"][0])
    asked = {
        "lock": f"{float(r.phi_end)!r} rad/pitch",
        "engagement": f"{float(r.phi_e)!r} rad/pitch",
        "points": [{"twist": f"{phi!r} rad/pitch", "torque": torque}],
        "RED": float(r.RED_c),
    }
    vary = {**VARY, "scale.alpha": ("28 deg", "70 deg"), "scale.theta0": ("5 deg", "25 deg"), "friction.mu": (0.1, 0.5)}
    found = find(asked, vary, limits={"edge": False}, law=law, starts=512)
    assert found.met
    assert max(abs(goal.difference / goal.asked) for goal in found[0].goals) < 1e-9
