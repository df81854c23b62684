"""What a beam weighs: masses and moments of inertia of bar and scales, against sums over points of the solids."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import squama
from squama.beam import mass

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
BARE = SKIN.replace(density=None, scale={"density": None})
ROTOR = "1e-4 kg m2"
STILL = {"release": "0.001 rad/pitch", "swings": 1}


def points(beam: squama.Beam, low: float, high: float) -> tuple[np.ndarray, float]:
    """Return Gauss points (X across, Y up, Z along) of a scale between two lengths, and the volume of each."""
    s = beam.scale
    sides = ((low, high), (-s.width / 2, s.width / 2), (-s.thickness / 2, s.thickness / 2))
    lines = [(a + b) / 2 + (b - a) / 2 * np.array([-1.0, 1.0]) / math.sqrt(3) for a, b in sides]
    x, y, z = (v.ravel() for v in np.meshgrid(*lines, indexing="ij"))
    # lying along the beam, lifted about X, turned about the normal of the face
    lying = np.column_stack([y, z, x])
    stands = Rotation.from_rotvec([0, -s.alpha, 0]) * Rotation.from_rotvec([-s.theta0, 0, 0])
    volume = math.prod(b - a for a, b in sides) / x.size
    return stands.apply(lying) + np.array([0, beam.substrate.thickness / 2, 0]), volume


@pytest.mark.parametrize("alpha", [0.0, 0.9])
def test_masses_and_moments_of_inertia(alpha):
    beam, d = SKIN.replace(scale={"alpha": alpha}), SKIN.pitch
    s, b = beam.scale, beam.substrate
    m, polar, across = 0.0, 0.0, 0.0
    for low, high, density in ((0.0, s.length, 1240.0), (-s.embedded, 0.0, 1240.0 - 1150.0)):
        at, volume = points(beam, low, high)
        m += density * volume * len(at)
        polar += density * volume * (at[:, :2] ** 2).sum()
        across += density * volume * (at[:, 1:] ** 2).sum()
    found, bar = mass.of(beam, 1150.0, 1240.0), 1150.0 * b.width * b.thickness
    assert found.mass == pytest.approx(bar + m / d, rel=1e-9)
    assert found.polar == pytest.approx(bar * (b.width**2 + b.thickness**2) / 12 + polar / d, rel=1e-9)
    assert found.across == pytest.approx(across / d, rel=1e-9)
    both = mass.of(beam.replace(faces="mirrored"), 1150.0, 1240.0)
    assert both.mass == pytest.approx(bar + 2 * m / d, rel=1e-9)
    assert mass.of(beam, 0.0, 1240.0).mass == pytest.approx(1240 * (s.length + s.embedded) * s.width * s.thickness / d)
    assert mass.of(beam, 1150.0, 0.0).mass == bar


@pytest.mark.slow
def test_bar_and_scales_swing_with_the_rotor():
    v = squama.vibrate(SKIN, rotor=ROTOR, **STILL)
    m, L = mass.of(SKIN, SKIN.density, SKIN.scale.density), SKIN.length
    # the twist grows along the beam
    x = L * (np.arange(1000) + 0.5) / 1000
    inertia = 1e-4 + m.polar * float(((x / L) ** 2).mean()) * L
    assert v.attrs["inertia"] == pytest.approx(inertia, rel=1e-4)
    rigidity = squama.twist(SKIN, points=3).attrs["rigidity"]
    assert 2 * math.pi * float(v.f_0) == pytest.approx(math.sqrt(rigidity / (L * inertia)), rel=1e-4)
    assert not v.attrs["warnings"]
    alone = squama.vibrate(BARE, rotor=ROTOR, **STILL)
    assert 2 * math.pi * float(alone.f_0) == pytest.approx(math.sqrt(rigidity / (L * 1e-4)), rel=1e-9)
    assert float(v.f_0 / alone.f_0) == pytest.approx(math.sqrt(1e-4 / inertia), rel=1e-4)


def test_what_is_not_known_is_left_out_with_one_warning_that_tells_the_share():
    whole = float(squama.vibrate(SKIN, rotor=ROTOR, **STILL).f_0)
    for beam, words in (
        (BARE, "the mass of the bar and the scales is not known"),
        (SKIN.replace(density=None), "the mass of the bar is not known"),
        (SKIN.replace(scale={"density": None}), "the mass of the scales is not known"),
    ):
        v = squama.vibrate(beam, rotor=ROTOR, **STILL)
        (line,) = v.attrs["warnings"].splitlines()
        assert words in line
        share = 1 - whole / float(v.f_0)
        assert f"{share:.1%} lower; write density under" in line
    # where it hardly counts nothing is said
    assert not squama.vibrate(BARE, rotor="0.1 kg m2", **STILL).attrs["warnings"]


@pytest.mark.parametrize("mode", ["uniform", "simply supported", "cantilever"])
def test_in_bending_by_the_kinetic_energy_of_the_shape(mode):
    how = {"load": "bending", "mode": mode, "joint": "hinge", **STILL}
    v = squama.vibrate(SKIN, rotor=ROTOR, **how)
    m, L, n = mass.of(SKIN, SKIN.density, SKIN.scale.density), SKIN.length, 4000
    x = L * (np.arange(n) + 0.5) / n
    b = 1.875104068711961
    k = (math.sinh(b) - math.sin(b)) / (math.cosh(b) + math.cos(b))
    w, slope = {
        "uniform": (x * (x - L) / 2, x - L / 2),
        "simply supported": (np.sin(math.pi * x / L), math.pi / L * np.cos(math.pi * x / L)),
        "cantilever": (
            np.cosh(b * x / L) - np.cos(b * x / L) - k * (np.sinh(b * x / L) - np.sin(b * x / L)),
            b / L * (np.sinh(b * x / L) + np.sin(b * x / L) - k * (np.cosh(b * x / L) - np.cos(b * x / L))),
        ),
    }[mode]
    moving = (m.mass * (w**2).mean() + m.across * (slope**2).mean()) * L
    if mode == "uniform":
        # two rotors, each turning by half of L times the curvature
        assert v.attrs["inertia"] == pytest.approx(1e-4 + moving / 2 / (L / 2) ** 2, rel=1e-4)
        assert "the beam has more inertia than its rotor" in v.attrs["warnings"]
    else:
        assert v.attrs["inertia"] == pytest.approx(moving / ((w**2).mean() * L), rel=1e-4)
        light = squama.vibrate(SKIN.replace(scale={"density": None}), **how)
        assert "the mass of the scales is not known" in light.attrs["warnings"]
        assert float(light.f_0 / v.f_0) == pytest.approx(
            math.sqrt(v.attrs["inertia"] / light.attrs["inertia"]), rel=1e-9
        )


def test_densities_go_through_a_file():
    beam = squama.Beam.from_toml("examples/stiff_skin.toml", overrides={"scale": {"density": "1.27 g/cm3"}})
    assert (beam.density, beam.scale.density) == (1150.0, 1270.0)
    assert squama.Beam.from_toml_text(beam.to_toml()) == beam
    with pytest.raises(squama.InputError, match=r"scale\.density"):
        SKIN.replace(scale={"density": -1})
