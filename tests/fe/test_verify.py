"""`squama verify --scales`: finite beams beside the endless one, run as a user runs it."""

import functools
import json

import numpy as np
import pytest

pytest.importorskip("netgen", reason="needs netgen-mesher (the extra fe)")
pytest.importorskip("ipctk", reason="needs the extra fe")
pytest.importorskip("numba", reason="needs the extra fe")

import squama
from squama.cli import main
from squama.curves import compliant
from squama.fe import mesh
from squama.fe.geometry import geometry
from squama.fe.pitch_stiffness import response
from squama.joints import choice
from squama.study import parts
from squama.study import verification as study

BEAM = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
MESH = ["--mesh", "0.4,0.2", "--beam-mesh", "0.4,0.2", "--increment", "0.02", "--scales", "2"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A beam's file; the stiffness of the coarse mesh serves for that of elements of no size, which takes a minute."""
    monkeypatch.chdir(tmp_path)
    # one matrix for all
    own = functools.cache(lambda beam: response(mesh.pitch_mesh(geometry(beam), 0.4, 0.2), geometry(beam)).K[:7, :7])
    monkeypatch.setattr(study, "own_matrix", lambda beam, size: own(beam))
    held = functools.cache(lambda beam: choice.Joint(own(beam), "elements", "", 0.0, None))
    monkeypatch.setattr(compliant, "joint_of", held)
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    return tmp_path


@pytest.mark.slow
def test_a_finite_beam_beside_the_endless_one(folder, capsys):
    asked = ["verify", "beam.toml", *MESH, "-o", "out", "--to", "0.08 rad/pitch"]
    assert main([*asked, "--json"]) == 0
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert found["tested"]
    assert "finite beam of 2 scales" in said.err
    assert list(found["models"]) == ["edge", "plate", "own", "thin", "compliant", "mesh", "beam", "row"]
    assert {path.name for path in (folder / "out").iterdir()} == {
        "beam.nc", "beam.npz", "comparison.csv", "comparison.png", "elements.nc", "elements.npz",
    }  # fmt: skip
    beam, table = squama.read("out/beam.nc"), squama.read("out/comparison.csv")
    phi = np.array(found["curve"]["phi"])
    assert phi[-1] == pytest.approx(0.08)
    one = table.sel(model="beam")
    np.testing.assert_allclose(one["T"], np.interp(phi, beam["phi"], beam["T"]), rtol=1e-12)
    # of two scales the second is shown, the one that is pressed down
    np.testing.assert_allclose(one["theta"], np.interp(phi, beam["phi"], beam["theta"][:, 1]), rtol=1e-12)
    assert float(one["theta"][-1]) < BEAM.scale.theta0
    row = squama.row(BEAM, scales=2, to="0.08 rad/pitch", points=400, joint="hinge")
    ours = table.sel(model="row")
    np.testing.assert_allclose(ours["T"], np.interp(phi, row["Phi"] * BEAM.pitch, row["T"]), rtol=2e-3)
    # the mesh's own joint is what the elements have before contact
    before = (phi > 0) & (phi < 0.05)
    np.testing.assert_allclose(table["dT"].sel(model="mesh").values[before], 0, atol=2e-3)
    # once more: nothing is left to do, the words are for people
    csv = (folder / "out" / "comparison.csv").read_text()
    assert main(asked) == 0
    said = capsys.readouterr()
    assert "phi =" not in said.err
    assert (folder / "out" / "comparison.csv").read_text() == csv
    assert "finite beam of 2 scales, theta of scale 2: beside the endless one the torque is" in said.out
    assert "row of 2 hinges, theta of scale 2: beside the finite beam the torque is" in said.out
    # another number of scales is another run
    assert main([*asked[:-5], "3", *asked[-4:]]) == 2
    assert "beam.npz: belongs to a run with scales = 2, not 3" in capsys.readouterr().err


@pytest.mark.parametrize("scales", [2, 5])
def test_a_total_twist_is_that_of_the_beam_that_is_described(scales, folder, monkeypatch):
    asked = {}

    def stop(beam, **arguments):
        asked.update(arguments)
        raise KeyboardInterrupt

    monkeypatch.setattr(study.runs, "cell", stop)
    with pytest.raises(KeyboardInterrupt):
        study.verify(BEAM.replace(scales=scales), folder / "out", to="0.2 rad total", scales=3)
    assert asked["to"] * BEAM.pitch == pytest.approx(0.2 / scales)


@pytest.mark.slow
def test_grips_that_leave_nothing_free_are_named(folder, capsys):
    steep = BEAM.replace(scale={"alpha": "70 deg", "width": "10 mm"})
    (folder / "beam.toml").write_text(steep.to_toml())
    asked = ["cell", "beam.toml", "--scales", "2", "--mesh", "0.4,0.2", "--to", "0.002 rad/pitch", "--quiet"]
    assert main(asked) == 0
    assert (
        "warning: the gripped end sections run along with the scales' bases, over 3.52 pitches of the bar: of 2 "
        in (capsys.readouterr().out)
    )


@pytest.mark.slow
def test_a_twist_at_which_nothing_touches_tests_nothing(folder, capsys):
    """No model is praised, the exit status says so, and where the scales would touch is told."""
    asked = ["verify", "beam.toml", "--mesh", "0.4,0.2", "--increment", "0.02", "-o", "out"]
    assert main([*asked, "--to", "0.02 rad/pitch", "--quiet", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert (found["tested"], found["load"]) == (False, "twisting")
    assert "no contact up to here: nothing was tested; they touch at" in found["verdict"]
    # the same run is read again
    assert main([*asked, "--to", "0.02 rad/pitch", "--quiet"]) == 1
    out = capsys.readouterr().out
    assert "twisted in sense +" in out
    assert "warning: twisted to 28.6 deg (1.15 deg per pitch), no contact up to here: nothing was tested" in out
    assert "as far as both go" not in out
    # further on there is a test
    pressed = squama.twist(BEAM, to="0.1 rad/pitch", joint="hinge", points=20)
    assert 0.02 < parts.touched(pressed, "phi") < 0.1
    words = study.verdict(parts.touched(pressed, "phi"), 0.1, 0.05, 57.3)
    assert words.startswith("twisted to 5.73 deg (5.73 deg per pitch), the scales touch from 3.")
