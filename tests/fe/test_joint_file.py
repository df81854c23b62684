"""`squama joint --matrix`: what the elements give is what a beam file takes."""

import json

import numpy as np
import pytest

pytest.importorskip("netgen", reason="needs netgen-mesher (the extra fe)")
pytest.importorskip("numba", reason="needs the extra fe")

import squama
from squama.cli import main
from squama.joints.choice import joint_of

BEAM = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where beam.toml is; results of joints are kept there."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    BEAM.to_toml("beam.toml")
    return tmp_path


def test_the_matrix_of_the_elements_is_that_of_the_file(folder, capsys):
    asked = ["joint", "beam.toml", "--edge-size", "0.3", "--levels", "1", "--matrix", "joint.csv", "--quiet"]
    assert main([*asked, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["written"] == ["joint.csv"]
    beam = BEAM.replace(joint={"matrix": "joint.csv"}, hold="bend, lateral bend")
    np.testing.assert_allclose(joint_of(beam).K, np.array(found["matrix"]), rtol=1e-9, atol=1e-12)
    assert beam.joint_stiffness == pytest.approx(found["factors"]["K_theta"]["elements"])
    # tolerance: the bare bar of the elements is 0.1 % stiffer than the exact one
    assert found["factors"]["C_f"]["elements"] == pytest.approx(beam.C_f, rel=3e-3)
    assert beam.warnings() == []
    # laws stay laws, and a new run replaces the file's matrix
    beam.to_toml("beam.toml")
    assert main([*asked, "--toml", "new.toml"]) == 0
    said = capsys.readouterr().out
    assert "wrote joint.csv" in said
    new = squama.Beam.from_toml("new.toml").joint
    assert (new.matrix, new.stiffness is None) == (None, False)
    assert f"{BEAM.C_f:.3g} by the scaling law" in said
    assert main([*asked[:-3], "--matrix", "-", "--quiet"]) == 0
    assert capsys.readouterr().out == (folder / "joint.csv").read_text(encoding="utf-8")


def test_a_deck_on_standard_output(folder, capsys):
    how = ["deck", "beam.toml", "--scales", "2", "--size", "0.5", "--edge-size", "0.3"]
    assert main([*how, "-o", "beam.inp"]) == 0
    capsys.readouterr()
    assert main([*how, "-o", "-"]) == 0
    assert capsys.readouterr().out == (folder / "beam.inp").read_text(encoding="utf-8")
    assert main([*how, "-o", "-", "--json"]) == 2
    assert "is printed, and so is --json" in capsys.readouterr().err


@pytest.mark.parametrize("place", ["joint.txt", "none/joint.csv"])
def test_a_place_that_takes_no_matrix(place, folder, capsys):
    assert main(["joint", "beam.toml", "--matrix", place]) == 2
    assert place.split("/", maxsplit=1)[0] in capsys.readouterr().err
