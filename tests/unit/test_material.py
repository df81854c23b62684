"""What a beam says of its material: modulus, Poisson's ratio and strength of the scales, strength of the bar."""

import math

import numpy as np
import pytest

import squama
from squama import InputError
from squama.beam import parts
from squama.cli import main
from squama.curves import compliant
from squama.inverse.space import DIMENSIONS
from squama.study import parameters
from squama.units import Dimension, quantity

RIGID = squama.Beam.from_ratios(beta=0.6, youngs_modulus="1.5 MPa", mu=0.25)
MATERIAL = {"youngs_modulus": "3 GPa", "poisson_ratio": 0.35, "strength": "50 MPa"}
BEAM = RIGID.replace(scale=MATERIAL, substrate={"strength": "4 MPa", "strain_limit": "200 %"})


def test_text_numbers_and_files_make_equal_beams(tmp_path):
    assert BEAM.scale.youngs_modulus == 3e9
    assert (BEAM.scale.strength, BEAM.substrate.strength, BEAM.substrate.strain_limit) == (5e7, 4e6, 2.0)
    BEAM.to_toml(tmp_path / "beam.toml")
    again = squama.Beam.from_toml(tmp_path / "beam.toml")
    assert again == BEAM
    assert hash(again) == hash(BEAM)
    assert again != RIGID
    assert (
        BEAM.replace(scale=dict.fromkeys(MATERIAL), substrate={"strength": None, "strain_limit": None}).to_toml()
        == RIGID.to_toml()
    )


def test_a_file_of_before_reads_and_is_written_as_before():
    """Stores of sweeps are known by the text of their beam."""
    text = RIGID.to_toml()
    assert "E_s" not in text
    assert not any(word in text for word in ("strength", "strain_limit", "nu_s"))
    assert squama.Beam.from_toml_text(text) == RIGID


def test_a_result_keeps_the_material(tmp_path):
    for ending in (".nc", ".csv"):
        squama.save(squama.twist(BEAM, points=4, joint="hinge"), tmp_path / f"a{ending}")
        assert squama.Beam.from_toml_text(squama.read(tmp_path / f"a{ending}").attrs["beam"]) == BEAM
    # no model asks for it so far
    one, other = (squama.twist(beam, points=4, joint="hinge") for beam in (BEAM, RIGID))
    np.testing.assert_array_equal(one["T"], other["T"])


def test_ratios_of_the_plate():
    """A strip of width w bent to a curvature c over its length a takes the moment D w c, if its sides stay straight."""
    assert BEAM.thickness_ratio == pytest.approx(BEAM.zeta / BEAM.slenderness)
    assert BEAM.modulus_ratio == pytest.approx(2000)
    # stress through the thickness, sum of E/(1 - nu^2) z^2 c dz
    n, t = 20_000, BEAM.scale.thickness
    z = (np.arange(n) + 0.5) / n * t - t / 2
    assert BEAM.plate_rigidity == pytest.approx(3e9 / (1 - 0.35**2) * np.sum(z**2) * t / n, rel=1e-7)
    assert RIGID.plate_rigidity == RIGID.modulus_ratio == math.inf
    without = BEAM.replace(scale={"poisson_ratio": None})
    assert without.plate_rigidity == BEAM.plate_rigidity
    assert (without.scale.nu, BEAM.replace(scale={"poisson_ratio": 0}).scale.nu) == (parts.PLASTIC, 0) == (0.35, 0)
    # the model of compliant joints takes the same plate
    plate = compliant.scale(without, ideal=False)
    assert (plate.D, plate.nu) == (pytest.approx(BEAM.plate_rigidity / (1.5e6 * BEAM.pitch**3)), 0.35)
    assert BEAM.replace(scale={"poisson_ratio": 0}).plate_rigidity == pytest.approx(BEAM.plate_rigidity * (1 - 0.35**2))


def test_the_ratio_of_the_moduli_gives_the_modulus():
    beam = squama.Beam.from_ratios(youngs_modulus="2 MPa", modulus_ratio=1500, scale_poisson_ratio=0.3)
    assert beam.scale.youngs_modulus == pytest.approx(3e9)
    assert beam.scale.poisson_ratio == 0.3
    assert squama.Beam.from_ratios().scale.youngs_modulus is None
    for value in (0, -1, "3 GPa", float("nan"), 1e10):
        with pytest.raises(InputError, match="modulus_ratio") as caught:
            squama.Beam.from_ratios(modulus_ratio=value)
        assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("part", "key", "value", "words"),
    [
        ("scale", "youngs_modulus", "3 mm", "is a length, but a pressure is needed"),
        ("scale", "youngs_modulus", "3", "has no unit"),
        ("scale", "youngs_modulus", "0 GPa", "out of range (more than 0; 1e-6 Pa to 1e15 Pa)"),
        ("scale", "youngs_modulus", "-3 GPa", "out of range"),
        ("scale", "poisson_ratio", 0.5, "out of range (-1 to 0.5, exclusive)"),
        ("scale", "poisson_ratio", -1, "out of range"),
        ("scale", "poisson_ratio", "0.3 MPa", "is a pressure, but a plain number is needed"),
        ("scale", "strength", "50 N", "50 N"),
        ("scale", "strength", "-50 MPa", "out of range"),
        ("scale", "strength", True, "is no number"),
        ("substrate", "strength", "4 deg", "is an angle, but a pressure is needed"),
        ("substrate", "strain_limit", "2 mm", "is a length, but a plain number is needed"),
        ("substrate", "strain_limit", 0, "out of range (more than 0; 1e-6 to 100)"),
        ("substrate", "strain_limit", 1e3, "out of range"),
    ],
)
def test_bad_values_are_one_line(part, key, value, words):
    with pytest.raises(InputError) as caught:
        squama.Beam.from_toml_text(BEAM.to_toml(), overrides={part: {key: value}})
    (line,) = str(caught.value).splitlines()
    assert line.startswith(f"beam: {part}.{key} = ")
    assert words in line
    assert "; write " in line


def test_a_scale_far_softer_than_its_joint_is_refused_with_what_would_do():
    wide = {"scale": {"thickness": "0.05 mm"}, "joint": {"stiffness": "100 N m"}}
    with pytest.raises(InputError) as caught:
        BEAM.replace(**wide)
    (line,) = str(caught.value).splitlines()
    D = 3e9 * 5e-5**3 / 12 / (1 - 0.35**2)
    plate = 3 * D * BEAM.scale.width / BEAM.scale.length
    # tolerance: the message has three digits
    assert plate < 1e-4
    assert f"3 D 2b/l = {plate:.3g} N m against K_theta = 100 N m" in line
    assert line.startswith("scale.youngs_modulus = 3 GPa: is that of a scale more than 1,000,000 times softer than")
    enough = line.partition("write at least ")[2]
    assert quantity(enough, Dimension.PRESSURE) == pytest.approx(3e9 * 1e-4 / plate, rel=2e-3)
    BEAM.replace(**wide | {"scale": {"thickness": "0.05 mm", "youngs_modulus": enough}})
    # a rigid one may be as thin
    BEAM.replace(**wide | {"scale": {"thickness": "0.05 mm", "youngs_modulus": None}})


def test_a_key_of_two_tables_is_told_with_both():
    with pytest.raises(InputError, match=r"friction\.youngs_modulus: .*it belongs in \[scale\] or \[substrate\]; "):
        squama.Beam.from_toml_text(BEAM.to_toml() + "youngs_modulus = '3 GPa'\n")


def test_flags_set_the_material(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    RIGID.to_toml("beam.toml")
    assert main(["twist", "beam.toml", "--set", 'scale.youngs_modulus="3 GPa"', "--set", "substrate.strain_limit=2",
                 "--netcdf", "a.nc"]) == 0  # fmt: skip
    kept = squama.Beam.from_toml_text(squama.read("a.nc").attrs["beam"])
    assert (kept.scale.youngs_modulus, kept.substrate.strain_limit) == (3e9, 2)
    capsys.readouterr()
    assert main(["twist", "beam.toml", "--set", 'scale.strength="3 mm"']) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "scale.strength" in line
    assert "a pressure is needed" in line


@pytest.mark.parametrize("name", [*parameters.UNUSED, *parameters.ELASTIC])
def test_what_changes_no_figure_is_not_swept_varied_or_scattered(name):
    # designs on compliant joints vary what scales are made of
    assert (name in DIMENSIONS) == (name in parameters.ELASTIC)
    for how in ({"joint": "hinge"}, {"ideal": True}):
        why = (
            "changes no figure of many beams" if name in parameters.UNUSED else "changes nothing where scales are rigid"
        )
        with pytest.raises(InputError, match=f"{name}: {why}"):
            squama.sweep(BEAM, {name: [1.0, 2.0]}, out="never.zarr", **how)
        with pytest.raises(InputError, match=name):
            squama.uncertainty(BEAM, {name: "3 +- 1"}, **how)


def test_the_example_has_typical_values(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "beam.toml"]) == 0
    beam = squama.Beam.from_toml("beam.toml")
    assert (beam.scale.youngs_modulus, beam.scale.poisson_ratio, beam.scale.strength) == (3e9, 0.35, 5e7)
    text = (tmp_path / "beam.toml").read_text()
    # what is commented out is a file, too
    freed = text.replace('# strength = "4', 'strength = "4').replace("# strain_limit", "strain_limit")
    assert squama.Beam.from_toml_text(freed).substrate.strain_limit == 2
