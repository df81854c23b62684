"""Vibration in bending of thick, elastic scales on joints: the model of squama.cycle; in modes place by place."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import squama
from squama.cli import main
from squama.dynamics import systems
from squama.dynamics.modes import SHAPES
from squama.loads import LOADS

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
HOW = {"load": "bending", "rotor": "0.1 kg m2"}


@pytest.fixture(scope="module")
def swung():
    return squama.vibrate(SKIN, release="0.1 rad/pitch", swings=3, **HOW)


def test_it_is_the_beam_of_cycle(swung):
    c = squama.cycle(SKIN, "0.1 rad/pitch", load="bending", points=200)
    for name in ("joint", "scales", "neutral", "load"):
        assert swung.attrs[name] == c.attrs[name], name
    assert swung.attrs["joint"] == "compliant"
    assert float(swung.psi_e) == pytest.approx(float(c.psi_e[0]), rel=1e-6)
    L = SKIN.length
    assert 2 * math.pi * float(swung.f_0) == pytest.approx(
        math.sqrt(2 * c.attrs["rigidity"] / (L * swung.attrs["inertia"])), rel=1e-9
    )
    assert float(swung.U_turn[0]) == pytest.approx(float(c.U_el.max()) * L, rel=1e-5)


def test_what_a_swing_loses_is_what_cycle_rubs_away(swung):
    first, second = swung.psi_turn.values[[0, 2]]
    lost = float(swung.U_turn[0] - swung.U_turn[2])
    # down from the first peak, and up to the second one
    histories = [squama.cycle(SKIN, f"{top:.12g} rad/pitch", load="bending", points=200) for top in (first, second)]
    down = float(histories[0].W_fr[-1] - histories[0].W_fr[int(np.argmax(histories[0].psi.values))])
    up = float(histories[1].W_fr[int(np.argmax(histories[1].psi.values))])
    assert lost == pytest.approx((down + up) * SKIN.length, rel=2e-3)
    # away from the scales the bar swings alone
    bar = float(2 * math.pi * swung.f_0) ** 2 * swung.attrs["inertia"] / 2
    assert float(swung.U_turn[1]) == pytest.approx(bar * (float(swung.psi_turn[1]) * SKIN.pitches) ** 2 / 2, rel=1e-6)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("mode", ["simply supported", "cantilever"])
def test_in_a_mode_each_cell_follows_its_own_moment(mode):
    top, shape = 0.11, SHAPES[mode].of_cells(SKIN.pitches)
    v = squama.vibrate(SKIN, load="bending", mode=mode, release=f"{top} rad/pitch", swings=1)
    assert v.attrs["joint"] == "compliant"
    # the bends of cells whose moments are like the mode's, by the curve of an endless beam
    curve = squama.bend(SKIN, to="0.2 rad/pitch", points=400)

    def bends(moment):
        return np.interp(moment * shape, curve.M.values, curve.psi.values)

    most = brentq(lambda moment: bends(moment) @ shape / (shape @ shape) - top, 0, float(curve.M[-1]))
    psi = bends(most)
    assert psi.max() < 0.2
    stored = rubbed = 0.0
    for one in psi:
        c = squama.cycle(SKIN, f"{one:.12g} rad/pitch", load="bending", points=60)
        at = int(np.argmax(c.psi.values))
        stored += float(c.U_el[at]) * SKIN.pitch
        rubbed += float(c.W_fr[-1] - c.W_fr[at]) * SKIN.pitch
    # the mean square of the shape is that of a smooth one
    smooth = SHAPES[mode].square * SKIN.pitches / float(shape @ shape)
    assert float(v.U_turn[0]) == pytest.approx(stored * smooth, rel=3e-3)
    # at the trough the bar alone is bent
    assert float(v.U_turn[0] - v.U_turn[1]) == pytest.approx(rubbed * smooth, rel=2e-2)


def test_scales_on_both_faces_swing_alike():
    both = SKIN.replace(faces="mirrored")
    one, other = (squama.vibrate(both, release=f"{a} rad/pitch", swings=1, **HOW) for a in (0.09, -0.09))
    np.testing.assert_allclose(one.psi_turn, -other.psi_turn, rtol=1e-9)
    c = squama.cycle(both, "0.05 rad/pitch", load="bending")
    held = systems.Model(LOADS["bending"], 0.25, "edge", "compliant", False)
    # before contact it is the bar, with the tabs of both faces
    np.testing.assert_allclose(c.stiffness_ratio[1:], 1.0, rtol=1e-9)
    assert c.attrs["rigidity"] == pytest.approx(held.rigidity(both), rel=1e-9)


def test_without_friction_it_comes_back():
    v = squama.vibrate(SKIN, release="0.1 rad/pitch", mu=0, swings=2, **HOW)
    assert v.psi_turn.values[::2] == pytest.approx([0.1] * 3, rel=1e-5)


def test_it_is_shaken_and_damped():
    s = squama.shake(SKIN, [0.036], static="0.05 rad/pitch", damping=0.05, **HOW)
    assert s.attrs["joint"] == "compliant"
    assert float(s.psi_high[0, 0]) > float(s.psi_e)
    assert s.W_fed.values == pytest.approx((s.W_rubbed + s.W_damped).values, rel=1e-4)


def test_where_the_joint_is_not_known_a_warning_says_so_and_hinges_are_asked_for():
    hinge = squama.vibrate(SKIN, release="0.1 rad/pitch", joint="hinge", swings=1, **HOW)
    assert hinge.attrs["joint"] == "hinge"
    tiny = SKIN.replace(scale={"embedded": "0.1 mm"})
    v = squama.vibrate(tiny, release="0.1 rad/pitch", swings=1, **HOW)
    assert v.attrs["joint"] == "hinge"
    assert "joint" in v.attrs["warnings"]


def test_beyond_the_contact_it_is_refused(capsys):
    given = [
        "vibrate",
        "examples/pla_on_vps.toml",
        "--load",
        "bending",
        "--rotor",
        "0.1 kg m2",
        "--ends",
        "endless",
        "--release",
    ]
    assert main([*given, "0.8 rad/pitch", "--hold", "twist, lateral bend"]) == 2
    assert "is beyond 29." in capsys.readouterr().err
    assert main([*given, "0.1 rad/pitch", "--swings", "1"]) == 0
    said = capsys.readouterr().out
    assert "thick, elastic scales on compliant joints; endless beam; uniform" in said
