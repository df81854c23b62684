"""A beam with a number of scales swings by the torque of all of them, between free ends."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.cli import main

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=6)
ROTOR = "1e-4 kg m2"


@pytest.mark.parametrize("load", ["twisting", "bending"])
@pytest.mark.parametrize("ends", ["free", "equal"])
def test_energies_are_those_of_its_cycle(load, ends):
    v = squama.vibrate(SKIN, release="0.07 rad/pitch", rotor=ROTOR, swings=1, load=load, ends=ends)
    c = squama.cycle(SKIN, "0.07 rad/pitch", load=load, points=150, ends=ends)
    angle = "phi" if load == "twisting" else "psi"
    assert v.attrs["ends"] == ends
    assert float(v.U_turn[0]) == pytest.approx(float(c.U_el.max()) * SKIN.length, rel=1e-6)
    # let go at the top, it loses what the way back rubs away; in the other sense the bar swings alone
    assert float(v[f"{angle}_turn"][1]) < 0
    lost = float(v.U_turn[0] - v.U_turn[1])
    assert 0 < lost < 0.1 * float(v.U_turn[0])
    rubbed = float((c.W_fr[-1] - c.W_fr)[int(np.argmax(c.U_el.values))])
    # tolerance: places of the branches, 96 each
    assert lost == pytest.approx(rubbed * SKIN.length, rel=1e-3)
    assert np.interp(v.t_turn, v.t, v[angle]) == pytest.approx(v[f"{angle}_turn"].values, abs=1e-6)


def test_ends_take_damping_and_frequency_away():
    own, endless = (
        squama.vibrate(SKIN, release="0.1 rad/pitch", rotor=ROTOR, swings=2, ends=e) for e in (None, "endless")
    )
    assert own.attrs["ends"] == "free"
    assert "ends" not in endless.attrs
    assert (own.zeta_cycle > 0).all()
    assert (own.zeta_cycle < 0.7 * endless.zeta_cycle).all()
    assert (own.period > endless.period).all()
    assert float(own.f_0) == float(endless.f_0)
    assert float(own.phi_e) == pytest.approx(float(endless.phi_e), rel=1e-9)
    # more scales come nearer to the endless beam
    more = squama.vibrate(SKIN.replace(scales=24), release="0.1 rad/pitch", rotor=ROTOR, swings=1)
    assert float(own.zeta_cycle[0]) < float(more.zeta_cycle[0]) < float(endless.zeta_cycle[0])


def test_a_shaken_beam_has_its_own_scales():
    given = {"static": "0.01 rad/pitch", "damping": 0.05, "rotor": ROTOR}
    f_0 = float(squama.vibrate(SKIN, release="0.01 rad/pitch", rotor=ROTOR, swings=1).f_0)
    own, endless = (squama.shake(SKIN, [f_0], ends=ends, **given) for ends in ("free", "endless"))
    assert own.attrs["ends"] == "free"
    assert own.settled.all()
    # what is softer goes farther where the stiffer one is detuned
    assert float(own.phi_high[0, 0]) > 1.005 * float(endless.phi_high[0, 0])
    fed, rubbed, damped = (float(own[name][0, 0]) for name in ("W_fed", "W_rubbed", "W_damped"))
    assert rubbed > 0
    assert fed == pytest.approx(rubbed + damped, rel=1e-5)


def test_who_swings_with_ends():
    given = {"release": "0.03 rad/pitch", "rotor": ROTOR, "swings": 1}
    mode = {"load": "bending", "mode": "cantilever", "density": 1150}
    for beam, how in (
        (SKIN.replace(scales=None), {}),
        (SKIN.replace(scales=201), {}),
        (SKIN, {"joint": "hinge"}),
        (SKIN, mode | {"ends": "endless"}),
    ):
        assert "ends" not in squama.vibrate(beam, **given, **how).attrs
    assert squama.vibrate(SKIN, **given, **mode).attrs["ends"] == "cantilever"
    # grips hold a beam that stands still
    assert squama.vibrate(SKIN.replace(ends="gripped"), **given).attrs["ends"] == "free"
    for how, words in (
        ({"ends": "gripped"}, "is not known of a beam that is loaded so"),
        ({"ends": "free", **mode}, "a cantilever bar is held by its mode"),
    ):
        with pytest.raises(squama.InputError, match=words):
            squama.vibrate(SKIN, **given, **how)


def test_the_commands_name_the_ends(tmp_path, capsys):
    file = tmp_path / "beam.toml"
    SKIN.to_toml(file)
    given = ["vibrate", str(file), "--release", "0.08 rad/pitch", "--rotor", ROTOR, "--swings", "1"]
    assert main(given) == 0
    assert "6 scales with free ends" in capsys.readouterr().out
    assert main([*given, "--ends", "endless"]) == 0
    assert "endless beam" in capsys.readouterr().out
    assert main([*given, "--ends", "gripped"]) == 2
    assert '--ends = "gripped": is not known' in capsys.readouterr().err
