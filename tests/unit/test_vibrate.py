"""Beams that swing or are shaken, and the commands: figures in SI units, files, refusals."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import squama
from squama.cli import main
from squama.curves.compliant import STRAIN_LIMIT
from squama.dynamics import joint_branches, motion, systems
from squama.dynamics.modes import SHAPES
from squama.loads import LOADS

ROOT = Path(__file__).parents[2]
BEAM = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3)
HINGE = {"joint": "hinge", "ideal": True}
ROTOR = "0.01 kg m2"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    BEAM.to_toml("beam.toml")
    return tmp_path


def test_the_bare_frequencies_are_those_of_books():
    L, s = BEAM.length, BEAM.substrate
    still = {"release": "0.001 rad/pitch", "swings": 1, **HINGE}
    twisted = squama.vibrate(BEAM, rotor=ROTOR, **still)
    assert 2 * math.pi * float(twisted.f_0) == pytest.approx(math.sqrt(BEAM.torsional_rigidity / (L * 0.01)), rel=1e-12)
    heavy = squama.vibrate(BEAM, rotor=ROTOR, density="1000 kg/m3", **still)
    polar = s.width * s.thickness * (s.width**2 + s.thickness**2) / 12
    assert heavy.attrs["inertia"] == pytest.approx(0.01 + 1000 * polar * L / 3, rel=1e-12)
    bent = squama.vibrate(BEAM, load="bending", rotor=ROTOR, **still)
    omega = math.sqrt(2 * BEAM.bending_rigidity / (L * 0.01))
    assert 2 * math.pi * float(bent.f_0) == pytest.approx(omega, rel=1e-12)
    mass = 1000 * s.width * s.thickness
    for mode, number, square in (("simply supported", math.pi, 1 / 2), ("cantilever", 1.875104, 1 / 4)):
        m = squama.vibrate(BEAM, load="bending", mode=mode, density=1000, **still)
        omega = (number / L) ** 2 * math.sqrt(BEAM.bending_rigidity / mass)
        assert 2 * math.pi * float(m.f_0) == pytest.approx(omega, rel=3e-6)
        assert float(m.period[0] * m.f_0) == pytest.approx(1.0, rel=1e-12)
        bar = BEAM.bending_rigidity * (0.001 / BEAM.pitch) ** 2 / 2 * L * square
        assert m.U_turn.values == pytest.approx(bar, rel=1e-12)


def test_energies_are_those_of_cycle():
    v = squama.vibrate(BEAM, release="0.15 rad/pitch", rotor=ROTOR, swings=1, **HINGE)
    c = squama.cycle(BEAM, "0.15 rad/pitch", **HINGE)
    assert float(v.U_turn[0]) == pytest.approx(float(c.U_el.max()) * BEAM.length, rel=1e-9)
    # at the trough the bar alone is twisted
    bare = BEAM.torsional_rigidity * (float(v.phi_turn[1]) / BEAM.pitch) ** 2 / 2 * BEAM.length
    assert float(v.U_turn[1]) == pytest.approx(bare, rel=1e-9)


def test_energies_of_the_compliant_beam_hold_those_of_its_plates():
    soft = BEAM.replace(scale={"youngs_modulus": "1 GPa", "poisson_ratio": 0.3})
    v = squama.vibrate(soft, release="0.09 rad/pitch", rotor=ROTOR, swings=1)
    c = squama.cycle(soft, "0.09 rad/pitch", points=300)
    top = float(c.U_el.max())
    assert float(c.U_plate.max()) > 2e-4 * top
    assert float(v.U_turn[0]) == pytest.approx(top * BEAM.length, rel=1e-4)


def test_a_note_tells_how_far_it_goes_in_either_sense():
    top, turns, both = 1.005 * STRAIN_LIMIT, [], BEAM.replace(faces="mirrored")
    for release in (top, -top):
        v = squama.vibrate(both, release=f"{release} rad/pitch", rotor=ROTOR, swings=1)
        assert abs(v.phi_turn.values[1]) < STRAIN_LIMIT
        assert f"to {math.degrees(STRAIN_LIMIT):.3g} deg per pitch" in str(v.attrs)
        turns.append(v.phi_turn.values)
    # mirrored scales close alike
    assert turns[0] == pytest.approx(-turns[1], rel=1e-12)


def test_engagement_is_told_where_the_swing_ends_before():
    beam = squama.Beam.from_toml(ROOT / "examples" / "stiff_skin.toml").replace(scales=None)
    v = squama.vibrate(beam, rotor="1e-4 kg m2", release="60 deg total", damping=0.02)
    assert float(v.phi_turn[0]) < float(v.phi_e) == pytest.approx(float(squama.twist(beam, points=3).phi_e), rel=1e-9)
    # the bare bar's decay
    assert float(v.phi_turn[1] / v.phi_turn[0]) == pytest.approx(
        -np.exp(-np.pi * 0.02 / np.sqrt(1 - 0.02**2)), rel=1e-5
    )


def test_an_impulse_gives_its_energy():
    v = squama.vibrate(BEAM, impulse="0.002 N m s", rotor=ROTOR, swings=1, **HINGE)
    # below engagement nothing is lost
    assert float(v.phi_turn[0]) < float(v.phi_e)
    assert float(v.U_turn[0]) == pytest.approx(0.002**2 / 0.01 / 2, rel=1e-9)
    assert float(v.t_turn[0] * v.f_0) == pytest.approx(0.25, rel=1e-9)
    # on either of two rotors
    bent = squama.vibrate(BEAM, load="bending", impulse="0.0005 N m s", rotor=ROTOR, swings=1)
    assert float(bent.psi_turn[0]) < float(bent.psi_e)
    assert float(bent.U_turn[0]) == pytest.approx(0.0005**2 / 0.01, rel=1e-9)


def test_the_record_goes_through_the_turning_points():
    v = squama.vibrate(BEAM, release="-0.1 rad/pitch", rotor=ROTOR, swings=3, **HINGE)
    assert float(v.phi_turn[0]) == pytest.approx(-0.1)
    assert np.interp(v.t_turn, v.t, v.phi) == pytest.approx(v.phi_turn.values, abs=1e-8)
    speed = v.phi_speed.values
    way = np.diff(v.t.values) * (speed[1:] + speed[:-1]) / 2
    assert np.diff(v.phi.values) == pytest.approx(way, abs=2e-4)


def test_a_beam_that_jams_stays():
    beam = squama.Beam.from_ratios(alpha="20 deg", youngs_modulus="2 MPa", stiffness="20 N m", inclusion_factor=1)
    c = squama.cycle(beam, "0.3 rad/pitch", mu=0.5, **HINGE)
    jam = float(c.phi_jam[0])
    for share, end in ((0.99, "rings"), (1.01, "jams")):
        for damping in (0.0, 0.01):
            release = f"{share * jam} rad/pitch"
            v = squama.vibrate(beam, release=release, rotor=ROTOR, mu=0.5, damping=damping, swings=1, **HINGE)
            assert v.end.item() == end
            assert math.isnan(float(v.phi_rest)) == (end == "rings")
            if end == "jams":
                assert v.phi.values.tolist() == [float(v.phi_turn[0])] * 2
                assert float(v.t[-1] * v.f_0) == pytest.approx(1.0)


def test_arrays_of_designs_have_the_figures_of_single_ones():
    given = {"eta": 3, "beta": 1.25, "lam": 0.45, "alpha": 0.8, "theta0": 0.17, "kappa": 2, "swings": 2}
    mu, amplitude = np.array([0.1, 0.3]), np.array([[0.1], [0.15], [0.6]])
    v = squama.free_vibration(**given, mu=mu, amplitude=amplitude)
    assert v.peaks.shape == (3, 2, 3)
    one = squama.free_vibration(**given, mu=0.3, amplitude=0.15)
    np.testing.assert_array_equal(v.peaks[1, 1], one.peaks)
    assert v.end.tolist() == [["rings"] * 2] * 2 + [["beyond"] * 2]


def test_without_friction_a_lock_takes_finite_energy():
    given = {"eta": 3, "beta": 1.25, "lam": 0.45, "alpha": math.pi / 4, "theta0": math.radians(10), "kappa": 2}
    hit = squama.free_vibration(**given, mu=0, impulse=2.0, swings=1)
    assert hit.end.item() == "beyond"
    assert hit.energy.item() == pytest.approx(2 * 2.0**2 / 2)
    held = squama.free_vibration(**given, mu=0.2, impulse=2.0, swings=1)
    assert held.end.item() == "rings"
    assert held.peaks[0] < squama.solve(**{k: v for k, v in given.items() if k != "kappa"}, mu=0.2).load_end


def test_shaking_both_ways():
    s = squama.shake(BEAM, [0.3, 0.6, 1.2], static="0.06 rad/pitch", rotor=ROTOR, damping=0.05, **HINGE)
    assert s.settled.values.all()
    assert s.W_fed.values == pytest.approx((s.W_rubbed + s.W_damped).values, rel=1e-6)
    ratio = 1.2 / float(s.f_0)
    assert s.phi_high.values[:, 2] == pytest.approx(0.06 / math.hypot(1 - ratio**2, 0.1 * ratio), rel=1e-12)
    assert s.W_rubbed.values[:, 2].tolist() == [0.0, 0.0]
    torque = float(BEAM.torsional_rigidity * 0.06 / BEAM.pitch)
    again = squama.shake(BEAM, [0.6], torque=torque, rotor=ROTOR, damping=0.05, **HINGE)
    assert again.phi_high.values[0, 0] == pytest.approx(s.phi_high.values[0, 1], rel=1e-6)


def test_parts_of_a_period_are_counted(monkeypatch):
    given = {"static": "0.06 rad/pitch", "rotor": ROTOR, "damping": 0.05, **HINGE}
    s = squama.shake(BEAM, [0.6], **given)
    # up, engaged, back, open: twice turned, twice through engagement
    assert 4 <= s.turns.values[0, 0] <= 12
    assert s.settled.values.all()
    monkeypatch.setattr(motion, "MOST_PERIODS", 2)
    short = squama.shake(BEAM, [0.6], **given)
    assert not short.settled.values[0, 0]
    assert short.periods.values[0, 0] == 2
    monkeypatch.setattr(motion, "MOST_PARTS", 3)
    with pytest.raises(squama.InputError, match="turns and sticks more than 3 times"):
        squama.shake(BEAM, [0.6], **given)


def test_a_beam_on_compliant_joints_is_shaken_too():
    s = squama.shake(BEAM, [0.55], static="0.02 rad/pitch", rotor=ROTOR, damping=0.1)
    assert s.attrs["joint"] == "compliant"
    assert float(s.phi_high[0, 0]) > float(s.phi_e)
    assert s.W_fed.values == pytest.approx((s.W_rubbed + s.W_damped).values, rel=1e-3)


def test_the_way_back_begins_a_hair_beyond_a_place_on_the_way_up():
    beam = squama.Beam.from_toml(ROOT / "src/squama/cli/example.toml").replace(scales=None)
    held = systems.Model(LOADS["twisting"], 0.25, "edge", "compliant", False)
    side = systems.sides(beam, held, "uniform", 1, 0.6).plus
    places = np.linspace(side.y_e, 0.6, joint_branches.STEPS)[1:40]
    for top in places + 1.5e-7:
        back = side.falling(top)
        assert float(back.force(top)) == pytest.approx(float(side.up.force(top)), rel=1e-4)
        assert float(back.force(0.999 * top)) < float(side.up.force(0.999 * top))


def test_density_and_rotor_go_through_a_file(folder):
    beam = squama.Beam.from_toml("beam.toml", overrides={"beam": {"density": "1.1 g/cm3", "rotor": "500 g cm^2"}})
    assert (beam.density, beam.rotor) == (1100.0, pytest.approx(5e-5))
    assert squama.Beam.from_toml_text(beam.to_toml()) == beam
    v = squama.vibrate(beam, release="0.1 rad/pitch", swings=1)
    assert v.attrs["inertia"] > 5e-5


def test_the_commands_write_what_they_say(folder, capsys):
    flags = ["--rotor", ROTOR, "--joint", "hinge", "--ideal", "--json"]
    swing = [
        "vibrate",
        "beam.toml",
        "--release",
        "0.1 rad/pitch",
        "--swings",
        "2",
        "--csv",
        "v.csv",
        "--netcdf",
        "v.nc",
    ]
    assert main([*swing, *flags]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["cycles"]["zeta_cycle"]) == 2
    assert told["written"] == ["v.csv", "v.nc"]
    table = squama.read("v.csv")
    assert table.sizes["turn"] == 5
    assert squama.read("v.nc").zeta_cycle.values.tolist() == told["cycles"]["zeta_cycle"]
    span = ["--lowest", "0.9 Hz", "--highest", "1.2 Hz", "--points", "2", "--static", "0.05 rad/pitch"]
    assert main(["shake", "beam.toml", *span, "--csv", "s.csv", "--netcdf", "s.nc", *flags]) == 0
    told = json.loads(capsys.readouterr().out)
    assert squama.read("s.csv")["phi_high_up"].values.tolist() == told["states"]["phi_high"][0]
    assert squama.read("s.nc").phi_low.values.tolist() == told["states"]["phi_low"]
    assert main(["shake", "beam.toml", *span, *flags[:-1]]) == 0
    assert main([*swing[:6], *flags[:-1]]) == 0
    assert "rings on unless its material damps" in capsys.readouterr().out


SWING = ["vibrate", "beam.toml", "--release", "0.1 rad/pitch", "--rotor", ROTOR]
SHAKE = ["shake", "beam.toml", "--static", "0.1 rad/pitch", "--rotor", ROTOR, "--lowest", "1 Hz", "--highest", "2 Hz"]
WRONG = {
    "no unit": ([*SWING[:-1], "0.01"], ['--rotor = "0.01"', "has no unit", "0.01 kg m2"]),
    "no rotor": (SWING[:-2], ["--rotor", "is not given", "under [beam]"]),
    "neither": (["vibrate", "beam.toml", "--rotor", ROTOR], ["--release, --impulse", "needs exactly one of the two"]),
    "both": ([*SWING, "--impulse", "1 N m s"], ["--release, --impulse", "needs exactly one of the two"]),
    "damping": ([*SWING, "--damping", "0.7"], ['--damping = "0.7"', "0 to 0.5"]),
    "mode": ([*SWING, "--mode", "cantilever"], ["--mode", "bending"]),
    "density": ([*SWING, "--mode", "cantilever", "--load", "bending"], ["--density", "not given", "1150 kg/m3"]),
    "nothing": ([*SWING[:3], "0 rad/pitch", *SWING[4:]], ["--release = 0", "nothing moves"]),
    "too little": (
        [*SWING[:3], "1e-320 rad/m", *SWING[4:]],
        ["--release = ", "is below 5.73e-05 deg per pitch: nothing moves"],
    ),
    "shaken too little": ([*SHAKE[:3], "1e-9 rad/m", *SHAKE[4:]], ["--static = ", "is below 5.73e-05 deg per pitch"]),
    "too far": (
        ["vibrate", "beam.toml", "--release", "0.4 rad/pitch", "--rotor", ROTOR, "--joint", "hinge"],
        ["--release = 22.9183 deg per pitch", "is beyond", "lock", 'write at most "16.'],
    ),
    "range": ([*SHAKE[:-1], "0.5 Hz"], ["--lowest, --highest", "growing"]),
    "hertz": ([*SHAKE[:-1], "2"], ['--highest = "2"', "has no unit", "2 Hz"]),
    "no static": ([*SHAKE[:2], *SHAKE[4:]], ["--static, --torque", "needs exactly one of the two"]),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_refused(name, folder, capsys):
    command, words = WRONG[name]
    refused(command, [words], capsys)


def test_a_swing_with_too_much_energy_is_refused_with_both_energies():
    with pytest.raises(squama.InputError, match=r"has 200 J, and [\d.]+ J take it to .* other contact"):
        squama.vibrate(BEAM, impulse="2 N m s", rotor=ROTOR, mu=0, **HINGE)


def test_a_later_swing_with_too_much_energy_names_its_sense():
    """Let go in the sense -, whose contact goes farther, it swings beyond where that of the sense + ends."""
    beam = BEAM.replace(scale={"alpha": math.radians(5)})
    with pytest.raises(squama.InputError, match=r"a swing in the sense \+ has [\d.]+ J"):
        squama.vibrate(beam, release="-0.5 rad/pitch", rotor=ROTOR, mu=0, **HINGE)


def test_energies_with_material_damping_are_those_of_cycle():
    v = squama.vibrate(BEAM, release="0.2 rad/pitch", rotor=ROTOR, damping=0.01, swings=1, **HINGE)
    phi, stored = v.phi_turn.values, v.U_turn.values
    bar = BEAM.torsional_rigidity * (phi / BEAM.pitch) ** 2 / 2 * BEAM.length
    assert stored[1] == pytest.approx(bar[1], rel=1e-12)
    for i in (0, 2):
        c = squama.cycle(BEAM, f"{phi[i]:.16g} rad/pitch", **HINGE)
        assert stored[i] > 1.01 * bar[i]
        assert stored[i] == pytest.approx(float(c.U_el.max()) * BEAM.length, rel=1e-9)


def test_a_frictional_lock_takes_any_energy():
    for damping in (0.0, 0.01):
        v = squama.vibrate(BEAM, impulse="20 N m s", rotor=ROTOR, mu=0.5, damping=damping, swings=1, **HINGE)
        assert v.end.item() == "rings"
        assert float(v.phi_turn[0]) == pytest.approx(float(squama.twist(BEAM, mu=0.5, **HINGE).phi_end), rel=1e-3)


def test_shapes_of_modes():
    for mode, end in (("cantilever", 1.0), ("simply supported", 0.5)):
        m = SHAPES[mode]
        s = np.linspace(0, end, 50)
        chi = m.shape(s)
        assert (chi[0], chi[-1]) == pytest.approx((1, 0), abs=1e-12)
        assert (np.diff(chi) < 0).all()
        # tolerance: at the end of a cantilever chi rises from 0 with its square, so rounding shows by its root, 1e-8
        assert m.far(chi) == pytest.approx(s, abs=1e-6)
        assert m.far(chi[:-5]) == pytest.approx(s[:-5], abs=1e-11)
