"""Vibration: the map of energies against motion in time by the contact itself, limits, balances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import squama
from squama.arrays import solution
from squama.curves import hinge
from squama.curves.way import Case
from squama.dynamics import hinge_branches, motion
from squama.dynamics.branches import APART, Branch, Side
from squama.dynamics.decay import Sides, decay
from squama.dynamics.modes import SHAPES
from squama.loads import LOADS, MODES
from squama.model import mechanics
from squama.model.paths import FLOAT
from squama.model.tracks import at_loads, scalar

MAIN = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": math.pi / 4, "theta0": math.radians(10)}
BENT = {"eta": 5.0, "beta": 1.0, "lam": 0.2, "alpha": 0.3, "theta0": math.radians(5), "mu": 0.3}
BEAM = squama.Beam.from_ratios(youngs_modulus="2 MPa")
ROTOR = "0.01 kg m2"
HINGE = {"joint": "hinge", "ideal": True}


def drawn(seed: int, load: str) -> dict[str, float]:
    r = np.random.default_rng(seed)
    theta0 = math.radians(r.uniform(5, 15))
    bent = {"eta": r.uniform(3, 6), "theta0": theta0, "mu": r.uniform(0, 0.4), "kappa": r.uniform(2, 20)}
    sizes = {"beta": r.uniform(1, 1.5), "lam": r.uniform(0.3, 0.6), "alpha": math.radians(r.uniform(30, 50))}
    if load == "bending":
        return {**bent, **sizes, "alpha": sizes["alpha"] / 2}
    return {**bent, **sizes, "eta": r.uniform(2.5, 4), "kappa": r.uniform(1, 5)}


def integrated(d: dict[str, float], load: str, top: float) -> tuple[list[float], list[float]]:
    """Turning points and their times by the contact's own path parameter, forces evaluated at every step."""
    columns = {name: np.array([d[name]]) for name in solution.COLUMNS}
    row = scalar(solution.solve(columns, load=load, law="edge", sense="+").tracks[0][1].row)
    y_e = row.point(row.theta0, "edge", FLOAT).load
    ends = (np.array([row.theta0]), np.array([row.theta0 + 1.2]))

    def inclination(y: float) -> float:
        seen = [np.array([y_e]), np.array([math.inf])]
        return float(at_loads(row, np.array([y]), ends, (seen[0], seen[1]))[0])

    def rates(way: int):
        def f(_, s):
            pt = row.point(float(s[0]), "edge", FLOAT)
            q = mechanics.forces(pt, row.theta0, way * d["mu"]).torque / d["kappa"]
            return [s[1] / pt.load_rate, -pt.load - q]

        return f

    def event(i: int, at: float, direction: int):
        def g(_, s):
            return s[i] - at

        g.terminal, g.direction = True, direction
        return g

    how = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    turns, times, t, x = [top], [0.0], 0.0, inclination(top)
    for _ in range(2):
        down = solve_ivp(rates(-1), (0, 50), [x, 0.0], events=event(0, row.theta0, -1), **how)
        v = -down.y[1, -1]
        lowest = math.hypot(y_e, v)
        below = math.pi + 2 * math.atan(y_e / v)
        up = solve_ivp(rates(1), (0, 50), [row.theta0, v], events=event(1, 0.0, -1), **how)
        x = float(up.y[0, -1])
        turns += [-lowest, row.point(x, "edge", FLOAT).load]
        times += [t + down.t[-1] + below / 2, t + down.t[-1] + below + up.t[-1]]
        t = times[-1]
    return turns, times


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("seed", range(4))
def test_the_map_is_what_motion_in_time_gives(load: str, seed: int) -> None:
    d = drawn(seed, load)
    s = squama.solve(**{name: v for name, v in d.items() if name != "kappa"}, load=load)
    top = float(s.load_e + 0.6 * (s.load_end - s.load_e))
    v = squama.free_vibration(**d, amplitude=top, swings=2, load=load)
    turns, times = integrated(d, load, top)
    assert np.ravel([v.peaks[:2], v.troughs], "F") == pytest.approx(turns[:4], abs=1e-9)
    assert v.peaks[2] == pytest.approx(turns[4], abs=1e-9)
    assert [v.trough_times[0], v.peak_times[1], v.trough_times[1], v.peak_times[2]] == pytest.approx(
        times[1:], abs=1e-8
    )


@pytest.mark.parametrize("mode", SHAPES)
def test_a_mode_is_the_mean_over_the_beam(mode: str) -> None:
    """Its torque is that of many pieces of the beam, by the trapezoidal rule; its energies are balanced."""
    d = BENT
    side = of_ratios(d, 10.0)
    found, m = of_ratios(d, 10.0, mode=mode), SHAPES[mode]
    x = np.linspace(0, 1 / m.weight, 200_001)
    chi = m.shape(x)
    assert m.weight * np.trapezoid(chi**2, x) == pytest.approx(m.square, rel=1e-9)
    for a in (0.03, 0.1, 0.15):
        local = np.maximum(a * chi, side.y_e)
        q = m.weight * np.trapezoid(chi * side.falling(a).force(local), x) / m.square
        assert float(found.falling(a).force(a)) == pytest.approx(q, rel=1e-7)
    got = decay(Sides(found, APART), start=0.15, turns=5).single()
    parts = motion.follow(Sides(found, APART), motion.Drive(), motion.State(0.0, 0.15, 0.0), got.t[-1] + 0.1)
    turned = [p.last.y for p in parts if p.why == motion.TURNED]
    assert turned[:4] == pytest.approx(got.y[1:], abs=1e-8)


def of_ratios(d: dict[str, float], kappa: float, load: str = "bending", mode: str = "uniform") -> Side:
    return hinge_branches.of_path(followed(d, kappa, load), kappa, mode)


def followed(d: dict[str, float], kappa: float, load: str) -> hinge.Path:
    columns = {name: np.array([d[name]]) for name in solution.COLUMNS}
    sol = solution.solve(columns, load=load, law="edge", sense="+")
    return hinge.path(Case(1.0, kappa, 1.0, d["eta"], d["theta0"]), sol, None, d["mu"], "edge", hinge_branches.FINEST)


@pytest.mark.parametrize(("load", "mode"), [("twisting", "uniform"), *(("bending", mode) for mode in MODES)])
def test_polynomials_of_many_designs_are_the_splines_of_one(load: str, mode: str) -> None:
    d = {**MAIN, "mu": 0.3} if load == "twisting" else BENT
    one = decay(Sides(of_ratios(d, 2.0, load, mode), APART), speed=0.5, turns=5).single()
    many = squama.free_vibration(**d, kappa=2.0, impulse=[0.02, 0.5], swings=2, load=load, mode=mode)
    assert many.peaks[1] == pytest.approx(one.y[::2], abs=1e-9)
    assert many.troughs[1] == pytest.approx(one.y[1::2], abs=1e-9)
    assert many.peak_times[1] == pytest.approx(one.t[::2], abs=1e-7)
    assert many.zeta[1] == pytest.approx(np.log(one.stored[:-1:2] / one.stored[2::2]) / (4 * math.pi), abs=1e-9)


def test_where_friction_holds_the_scales_the_beam_stays() -> None:
    """Much friction: beyond a place on the way no normal force lets the spring push the scale back."""
    d = {"eta": 1.523, "beta": 2.608, "lam": 1.678, "alpha": 0.378, "theta0": 0.773, "mu": 1.945}
    p = followed(d, 1.0, "twisting")

    def drive(x: float) -> float:
        pt = p.row.point(x, "edge", FLOAT)
        return d["mu"] * pt.M_f - pt.M_N

    every = np.linspace(p.x0, p.x_c, 2000)
    first = next(x for x in every if drive(x) <= 0)
    y_h = float(p.row.point(brentq(drive, p.x0, first), "edge", FLOAT).load)
    v = squama.free_vibration(**d, kappa=1e4, amplitude=np.array([1.001, 0.98]) * y_h, swings=1)
    assert v.end.tolist() == ["jams", "rings"]
    assert v.rest[0] == v.peaks[0, 0] == 1.001 * y_h
    # struck, it comes up there, and stays
    w = squama.free_vibration(**d, kappa=1e4, impulse=np.array([1.05, 0.9]) * y_h, swings=1)
    assert w.end.tolist() == ["jams", "rings"]
    assert w.rest[0] == w.peaks[0, 0] > y_h


def test_designs_do_not_depend_on_their_company() -> None:
    """Some ring, some jam, some leave the model, some do not engage, in one array: each as by itself."""
    r = np.random.default_rng(8)
    n = 40
    d = {"eta": r.uniform(1.5, 5, n), "beta": r.uniform(0.6, 1.8, n), "lam": r.uniform(0.2, 0.8, n)}
    d |= {"alpha": r.uniform(0.3, 1.2, n), "theta0": r.uniform(0.05, 0.4, n), "mu": r.uniform(0, 0.9, n)}
    d |= {"kappa": 10 ** r.uniform(-2, 1, n), "impulse": r.uniform(0.02, 4, n)}
    together = squama.free_vibration(**d, swings=3, faces="mirrored")
    assert set(together.end) == {"rings", "jams", "beyond"}
    for i in range(n):
        one = squama.free_vibration(**{name: v[i] for name, v in d.items()}, swings=3, faces="mirrored")
        assert one.end == together.end[i]
        for single, many in zip(one, together, strict=True):
            if single.dtype.kind == "f":
                assert single == pytest.approx(many[i], rel=1e-10, abs=1e-12, nan_ok=True)


def test_without_friction_nothing_is_lost() -> None:
    v = squama.free_vibration(**MAIN, mu=0, kappa=2, amplitude=0.22, swings=20)
    assert v.peaks == pytest.approx(np.full(21, 0.22), abs=1e-12)
    assert v.zeta == pytest.approx(np.zeros(20), abs=1e-12)


def test_below_engagement_it_is_a_linear_oscillator() -> None:
    v = squama.free_vibration(**MAIN, mu=0.5, kappa=2, amplitude=0.04, swings=3)
    assert v.peaks.tolist() == [0.04] * 4
    assert v.troughs == pytest.approx([-0.04] * 3, rel=1e-13)
    assert v.peak_times == pytest.approx(2 * math.pi * np.arange(4), rel=1e-13)


@pytest.mark.slow
def test_the_decay_ends_at_engagement() -> None:
    v = squama.free_vibration(**MAIN, mu=0.5, kappa=2, amplitude=0.22, swings=2000)
    left = v.peaks - squama.solve(**MAIN, mu=0.5).load_e
    assert (np.diff(left) < 0).all()
    assert left[-1] > 0
    # the excess falls as 1/n
    # tolerance: the next order, 1.7 % on every processor
    assert left[2000] * 2000 == pytest.approx(left[1000] * 1000, rel=0.02)


def test_small_loss_is_the_loop_of_cycle() -> None:
    mu = 1e-4
    c = squama.cycle(BEAM, "0.15 rad/pitch", mu=mu, **HINGE)
    v = squama.vibrate(BEAM, release="0.15 rad/pitch", rotor=ROTOR, mu=mu, swings=1, **HINGE)
    assert float(v.zeta_cycle[0]) == pytest.approx(float(c.zeta_eq[0]), rel=1e-3)


def test_what_a_cycle_loses_is_in_the_loops() -> None:
    """At a jump from peak to peak: W- of the way down and W+ of the way up, from loops of cycle to both peaks."""
    v = squama.vibrate(BEAM, release="0.15 rad/pitch", rotor=ROTOR, mu=0.3, swings=1, **HINGE)
    first, second = (f"{v.phi_turn.values[i]:.16g} rad/pitch" for i in (0, 2))
    work = []
    for top in (first, second):
        c = squama.cycle(BEAM, top, mu=0.3, points=200, **HINGE)
        up = float(c.W_fr[c.branch.values == "loading"].max())
        work.append((up, float(c.W_fr[-1]) - up))
    lost = (work[0][1] + work[1][0]) * BEAM.length
    assert float(v.U_turn[0] - v.U_turn[2]) == pytest.approx(lost, rel=1e-9)


def test_a_compliant_beam_loses_what_its_loops_do() -> None:
    """Its ways back are walked from each peak, so that energies balance as those of cycle do, to 1e-4."""
    v = squama.vibrate(BEAM, release="0.15 rad/pitch", rotor=ROTOR, mu=0.3, swings=1)
    work = []
    for i in (0, 2):
        c = squama.cycle(BEAM, f"{v.phi_turn.values[i]:.16g} rad/pitch", mu=0.3, points=300)
        top = int(np.argmax(c.phi.values))
        work.append((float(c.W_fr[top]), float(c.W_fr[-1] - c.W_fr[top])))
    lost = (work[0][1] + work[1][0]) * BEAM.length
    assert float(v.U_turn[0] - v.U_turn[2]) == pytest.approx(lost, rel=5e-3)
    assert v.attrs["joint"] == "compliant"


def test_stiff_compliant_joints_are_the_hinge() -> None:
    matrix = np.diag([1e6, 1e6, 1e6, 1e6, 1.0, 1e6, 2.0])
    from squama.contacts import path, states
    from squama.curves import compliant

    way = path.Path.of(compliant.scale(BEAM, ideal=True), matrix, 0.3, sense=1, most=0.15)
    y = np.linspace(way.contact.phi, 0.15, 200)
    q = way.states(np.append(0.0, y), 5e-4)[0][1:, 1] / states.bare(way.beams)[0, 0, 0] - y
    hinge = of_ratios({**MAIN, "mu": 0.3}, 2.0, "twisting")
    assert q[-1] == pytest.approx(float(hinge.up.force(0.15)), rel=2e-3)


def test_speed_is_no_group() -> None:
    slow, fast = (squama.vibrate(BEAM, release="5 rad/m", rotor=r, mu=0.3, **HINGE) for r in ("1 kg m2", "1e-4 kg m2"))
    assert slow.zeta_cycle.values == pytest.approx(fast.zeta_cycle.values, rel=1e-12)
    assert (slow.period / fast.period).values == pytest.approx(np.full(8, 100.0), rel=1e-10)


def test_scales_on_both_faces_take_turns_or_work_together() -> None:
    """Mirrored, each sense closes one face, so a trough is the next peak of one face; turned, one sense closes both."""
    given = {"joint": {"inclusion_factor": 2.0}}
    one, mirrored, turned = (
        squama.vibrate(BEAM.replace(faces=f, **given), release="5 rad/m", rotor=ROTOR, mu=0.3, **HINGE)
        for f in ("one", "mirrored", "turned")
    )
    assert -mirrored.phi_turn.values[1] == pytest.approx(one.phi_turn.values[2], rel=1e-9)
    # two joints against the bar are one against half of it
    rigidity, K = BEAM.replace(**given).torsional_rigidity, BEAM.joint_stiffness
    ratios = BEAM.ratios | {"mu": 0.3, "amplitude": 5 * BEAM.pitch, "kappa": rigidity / (K * BEAM.pitch) / 2}
    assert turned.phi_turn.values[::2] == pytest.approx(squama.free_vibration(**ratios).peaks, rel=1e-9)
    told = squama.free_vibration(**ratios | {"kappa": 2 * ratios["kappa"]}, faces="turned")
    assert told.peaks == pytest.approx(turned.phi_turn.values[::2], rel=1e-9)


def test_the_bound_of_a_free_motion_is_its_envelope() -> None:
    drive, t = motion.Drive(0.4), np.linspace(0, 20, 20_001)
    w = math.sqrt(1 - 0.4**2)
    y = np.exp(-0.4 * t) * (0.2 * np.cos(w * t) + (1 + 0.4 * 0.2) / w * np.sin(w * t))
    assert motion._swing(drive, 0.2, 1.0) == pytest.approx(np.abs(y * np.exp(0.4 * t)).max(), rel=1e-6)


def test_material_damping_goes_on_below_engagement() -> None:
    v = squama.vibrate(BEAM, release="0.04 rad/pitch", rotor=ROTOR, mu=0.3, damping=0.02, swings=5, **HINGE)
    peaks = v.phi_turn.values[::2]
    decrement = 2 * math.pi * 0.02 / math.sqrt(1 - 0.02**2)
    assert peaks == pytest.approx(0.04 * np.exp(-decrement * np.arange(6)), rel=1e-7)
    assert v.zeta_cycle.values == pytest.approx(np.full(5, decrement / (2 * math.pi)), rel=1e-6)
    assert (np.diff(v.t_turn.values) > 0).all()


def test_stick_holds_until_the_force_leaves_the_interval() -> None:
    """Slow force, strong friction: between its turning points the bar follows the branches, statically."""
    y = np.linspace(0.1, 1.0, 40)
    up, down = Branch(y, 3.0 * (y - 0.1)), Branch(y, 1.0 * (y - 0.1))
    sides = Sides(Side(0.1, 1.0, "", up, lambda _: down), APART)
    w, F = 1e-3, 0.5
    drive = motion.Drive(0.4, F, w)
    parts = list(motion.follow(sides, drive, motion.State(0.0, 0.0, w * F), 2 * math.pi / w))
    top = max(part.last.y for part in parts)
    assert top + 3.0 * (top - 0.1) == pytest.approx(F, rel=1e-4)
    stuck = max(parts, key=lambda p: p.last.t - p.t[0] if p.v[0] == p.v[-1] == 0 else 0.0)
    # it leaves where the force has come down to the unloading branch
    leaves = drive.at(stuck.last.t) - (stuck.last.y + 1.0 * (stuck.last.y - 0.1))
    assert leaves == pytest.approx(0.0, abs=1e-9)


def test_a_beam_that_slides_back_a_part_stays_there() -> None:
    """Where the way back takes in more than it gives; the motion in time says so too."""
    y = np.linspace(0.1, 1.0, 400)
    up, down = Branch(y, 5.0 * (y - 0.1)), Branch(y, (y - 0.1) * (1.2 - 20.0 * np.exp(-(((y - 0.5) / 0.1) ** 2))))
    sides = Sides(Side(0.1, 1.0, "", up, lambda _: down), APART)
    found = decay(sides, start=0.9, turns=3).single()
    assert found.end == "jams"
    assert decay(sides, start=0.9, turns=1).single().end == "rings"
    assert 0.4 < found.rest < 0.9
    last = list(motion.follow(sides, motion.Drive(), motion.State(0.0, 0.9, 0.0), 100.0))[-1]
    assert last.why == motion.STUCK
    assert last.last.y == pytest.approx(found.rest, abs=1e-8)


@pytest.mark.parametrize("start", [-0.100001, -0.10001, -0.10003, -0.1001])
def test_a_swing_that_only_just_engages_is_seen(start: float) -> None:
    y = np.linspace(0.1, 1.0, 40)
    up, down = Branch(y, 50.0 * (y - 0.1)), Branch(y, 20.0 * (y - 0.1))
    assert up.quick(1.0) == pytest.approx(45.0, rel=1e-12)
    sides = Sides(Side(0.1, 1.0, "", up, lambda _: down), APART)
    parts = motion.follow(sides, motion.Drive(), motion.State(0.0, start, 0.0), 2 * math.pi)
    energy = [p.last.y for p in parts if p.why == motion.TURNED]
    assert energy[0] == pytest.approx(decay(sides, start=start, turns=2).single().y[1], rel=1e-9)


def test_scales_on_both_sides_are_met_in_either_sense() -> None:
    y = np.linspace(0.1, 1.0, 40)
    up, down = Branch(y, 50.0 * (y - 0.1)), Branch(y, 20.0 * (y - 0.1))
    side = Side(0.1, 1.0, "", up, lambda _: down)
    for speed in (-0.10001, 0.10001, -0.2, 0.2):
        parts = motion.follow(Sides(side, side), motion.Drive(), motion.State(0.0, 0.0, speed), 2 * math.pi)
        turned = [p.last.y for p in parts if p.why == motion.TURNED]
        wanted = decay(Sides(side, side), speed=speed, turns=2).single().y
        assert turned[:2] == pytest.approx(wanted, rel=1e-8)
