"""What is held of a beam and what is free: one rule for every load, in the beam, its file and the command line."""

from __future__ import annotations

import math

import numpy as np
import pytest

import squama
from squama import loads

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
AT = ["0.06 rad/pitch", "0.08 rad/pitch", "0.1 rad/pitch"]


@pytest.mark.parametrize(
    ("text", "held"),
    [
        ("nothing", ()),
        ("straight", loads.STRAINS),
        ("stretch,  bend", ("bend", "stretch")),
        ("lateral  bend", ("lateral bend",)),
    ],
)
def test_words(text, held):
    assert loads.hold(text) == held
    assert loads.hold(loads.holding(held)) == held


def test_a_beam_keeps_it_and_its_file_has_it():
    assert SKIN.hold is None
    assert SKIN.held == ()
    one = SKIN.replace(hold="stretch, bend")
    assert one.held == ("bend", "stretch")
    assert squama.Beam.from_toml_text(one.to_toml()) == one
    assert SKIN.replace(substrate={"neutral": "middle"}).held == ("stretch",)
    with pytest.raises(squama.InputError, match=r'beam\.hold = "bow": must be some of "bend"'):
        SKIN.replace(hold="bow")


def test_a_torque_alone():
    """The moment that holds the beam straight is five sixths of its torque; figures of the barrier of elements, 1 %."""
    # tolerance: another program's figures, of three digits
    free = squama.twist(SKIN, mu=0.25, at=AT, hold="lateral bend")
    np.testing.assert_allclose(1e3 * free["T"], [5.614, 9.515, 13.199], rtol=0.01)
    np.testing.assert_allclose(free.psi, [-0.0072, -0.0296, -0.0513], rtol=0.02)
    assert (free.M == 0).all()
    assert (free.P == 0).all()
    held = squama.twist(SKIN, mu=0.25, at=AT, hold="bend, lateral bend")
    np.testing.assert_allclose(1e3 * held["T"], [11.80, 35.44, 58.22], rtol=0.005)
    np.testing.assert_allclose(1e3 * held.M, [4.49, 19.17, 34.68], rtol=0.02)
    assert (held.psi == 0).all()
    assert (held.M_lat != 0).all()


@pytest.mark.parametrize("hold", ["nothing", "bend", "stretch", "lateral bend", "bend, stretch", "straight"])
def test_what_is_held_does_not_move_and_what_is_free_bears_nothing(hold):
    r = squama.twist(SKIN.replace(hold=hold), mu=0.25, at=AT)
    held = loads.hold(hold)
    assert r.attrs["hold"] == hold
    for strain, load, name in (("psi", "M", "bend"), ("chi", "M_lat", "lateral bend"), ("stretch", "P", "stretch")):
        still, idle = (r[strain] == 0).all().item(), (r[load] == 0).all().item()
        assert (still, idle) == ((True, False) if name in held else (False, True))


def test_a_moment_alone_twists_the_beam():
    r = squama.bend(SKIN, mu=0.25, at=AT)
    assert (r["T"] == 0).all()
    assert (np.diff(r.phi) < 0).all()
    held = squama.bend(SKIN, mu=0.25, at=AT, hold="twist, lateral bend")
    assert (held.phi == 0).all()
    assert (np.diff(held["T"]) > 0).all()
    assert (held.M > 2 * r.M)[1:].all()


@pytest.mark.slow
@pytest.mark.parametrize("hold", ["nothing", "bend", "straight"])
def test_every_door_says_the_same(hold, tmp_path):
    """The curve, a closed history, the beam beside a row, a sweep and a path of the plane."""
    beam = SKIN.replace(hold=hold)
    T = float(squama.twist(beam, mu=0.25, at=["0.08 rad/pitch"])["T"][0])
    there = squama.cycle(beam, "0.08 rad/pitch", mu=0.25)
    assert there["T"].max().item() == pytest.approx(T, rel=1e-4)
    row = squama.row(beam, scales=3, mu=0.25, to="0.08 rad/pitch")
    assert float(row.T_periodic[-1]) == pytest.approx(T, rel=1e-4)
    swept = squama.sweep(beam, {"mu": [0.2, 0.25]}, at="0.08 rad/pitch", out=tmp_path / "map.zarr")
    assert float(swept.torque.sel(mu=0.25)) == pytest.approx(T, rel=1e-4)
    alone = squama.bend_twist(beam, "twist 0.08 rad/pitch", mu=0.25)
    assert float(alone["T"][-1]) == pytest.approx(T, rel=1e-4)
    seen = squama.view(beam, mu=0.25, to="0.08 rad/pitch").state
    assert seen.torque == pytest.approx(T, rel=2e-4)
    s, d, substrate = beam.scale, beam.pitch, beam.substrate
    array = squama.response(
        np.linspace(0, 0.08, 41), eta=beam.eta, beta=beam.beta, lam=beam.lam, zeta=beam.zeta, alpha=s.alpha,
        theta0=s.theta0, thickness=s.thickness / d, width=substrate.width / d, nu=substrate.poisson_ratio, mu=0.25,
        modulus_ratio=s.youngs_modulus / substrate.youngs_modulus, scale_nu=s.nu, hold=hold,
    )  # fmt: skip
    assert float(array.torque[-1]) * beam.unit_moment == pytest.approx(T, rel=1e-4)
    certain = squama.uncertainty(
        beam.replace(friction={"mu": 0.25}), {"mu": "+- 1e-6"}, at="0.08 rad/pitch", samples=3200
    )
    assert float(certain["mean"].sel(figure="torque")) == pytest.approx(T, rel=1e-3)
    # a path that names the bend imposes it
    named = squama.bend_twist(beam, "bend 0 rad/pitch, twist 0.08 rad/pitch", mu=0.25)
    assert (named.psi == 0).all()


def test_the_work_of_the_torque_is_what_is_stored_and_rubbed_away():
    r = squama.twist(SKIN.replace(hold="nothing"), mu=0.25, to="0.1 rad/pitch")
    work = np.trapezoid(r["T"], r.Phi)
    assert work == pytest.approx(float(r.U_el[-1] + r.W_fr[-1]), rel=2e-3)
    assert math.isfinite(float(r.energy_error))
    assert abs(float(r.energy_error)) < 1e-3


def test_the_inclusion_factor_is_that_of_the_beam_as_it_is_held():
    for hold in ("nothing", "straight", "bend"):
        beam = SKIN.replace(hold=hold, joint={"inclusion_factor": 1.3})
        r = squama.twist(beam, mu=0.25, at=["1e-3 rad/pitch"])
        assert r.attrs["rigidity"] == pytest.approx(1.3 * beam.J * beam.G_B, rel=1e-9)
        assert float(r["T"][0] / r.Phi[0]) == pytest.approx(r.attrs["rigidity"], rel=1e-9)
