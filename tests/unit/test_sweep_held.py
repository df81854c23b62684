"""Sweeps over the bend in which a beam is held while it is twisted: cells against single paths, refusals."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import squama
from squama.beam import matrixfile
from squama.cli import main
from squama.errors import InputError
from squama.joints.choice import joint_of
from squama.study import slices

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
MAIN = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg", mu=0.2)


@pytest.mark.parametrize("sense", ["+", "-"])
def test_every_cell_on_compliant_joints_is_its_path(sense: str, tmp_path: Path) -> None:
    over = {"psi": ["-1 deg", "0 deg", "0.8 deg", "2 deg"], "mu": [0.0, 0.3]}
    data = squama.sweep(SKIN, over, at="0.09 rad/pitch", sense=sense, out=tmp_path / "held.zarr")
    for i, j in ((0, 1), (2, 0), (2, 1), (3, 1)):
        cell = data.isel(psi=i, mu=j)
        path = f"bend {float(cell.psi)} rad/pitch; twist {sense}0.09 rad/pitch"
        r = squama.bend_twist(SKIN, path, mu=float(cell.mu), points=90, ends="endless")
        assert slices.ends(cell) == r.end.item()
        if r.end.item() == "range end":
            assert float(cell.phi_e) == pytest.approx(abs(float(r.phi_e)), rel=1e-9)
            # tolerance: differences of three points of 90, 0.5 % measured, on every processor
            slope = np.gradient(r["T"].values[-3:], r.Phi.values[-3:], edge_order=2)[1]
            assert float(cell.tangent) == pytest.approx(slope, rel=1e-2)
        assert float(cell.torque) == pytest.approx(abs(float(r["T"][-1])), rel=1e-4)
        for name in ("W_fr", "U_el", "RED", "stress"):
            assert float(cell[name]) == pytest.approx(float(r[name][-1]), rel=1e-3, abs=1e-12, nan_ok=True), name
    # a bend towards the scales brings them together sooner
    if sense == "+":
        assert (np.diff(data.phi_e.values, axis=0) < 0).all()
        assert (np.diff(data.torque.values, axis=0) > 0).all()


def test_cells_on_hinges_are_their_paths(tmp_path: Path) -> None:
    over = {"psi": [-0.05, 0.0, 0.04, 0.35], "eta": [2.5, 3.0]}
    data = squama.sweep(MAIN, over, joint="hinge", out=tmp_path / "held.zarr")
    for i, j in ((0, 0), (2, 1), (3, 1)):
        cell = data.isel(psi=i, eta=j)
        beam = MAIN.replace(scale={"length": float(cell.eta) * MAIN.pitch})
        r = squama.bend_twist(beam, f"bend {float(cell.psi)} rad/pitch; twist 1 rad/pitch", joint="hinge")
        assert slices.ends(cell) == r.end.item()
        assert float(cell.theta_end) == pytest.approx(float(r.theta_end), rel=1e-12)
        assert float(cell.phi_end) == pytest.approx(float(r.phi_end), rel=1e-12)
        if i < 3:
            for name in ("torque", "W_fr", "RED"):
                own = float(r["T_c"] if name == "torque" else r[f"{name}_c"])
                assert float(cell[name]) == pytest.approx(own, rel=1e-12), name
    # 0.35 rad per pitch lock while the beam is bent
    assert (data.phi_end.isel(psi=3) == 0).all()
    assert np.isnan(data.torque.isel(psi=3)).all()
    # not bent it is the contact of twisting
    s = squama.solve(**MAIN.ratios, mu=0.2)
    one = data.sel(psi=0.0, eta=3.0)
    assert (float(one.phi_e), float(one.phi_end)) == pytest.approx((float(s.load_e), float(s.load_end)), rel=1e-9)


def test_margins_and_senses_on_hinges(tmp_path: Path) -> None:
    over = {"psi": [0.02, 0.04], "margin": [0.01, 0.1]}
    both = [squama.sweep(MAIN, over, joint="hinge", sense=s, out=tmp_path / f"{s}.zarr") for s in "+-"]
    assert (both[0].torque.isel(margin=0) > 1.5 * both[0].torque.isel(margin=1)).all()
    r = squama.bend_twist(MAIN, "bend 0.04 rad/pitch; twist -1 rad/pitch", joint="hinge")
    assert float(both[1].phi_end.isel(psi=1, margin=0)) == pytest.approx(-float(r.phi_end), rel=1e-12)
    assert float(both[1].torque.isel(psi=1, margin=0)) == pytest.approx(-float(r["T_c"]), rel=1e-9)


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"load": "bending"}, "psi: is what bending changes; leave it out"),
        ({"law": "plate"}, "law = plate: is not available on hinges in bending"),
        ({"joint": "hinge", "ideal": False}, "ideal = False: is not available on hinges in bending"),
    ],
    ids=str,
)
def test_what_knows_no_bend_is_refused(how: dict[str, Any], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        squama.sweep(SKIN, {"psi": (0.0, 0.02, 3)}, out=tmp_path / "no.zarr", **how)
    assert words in str(error.value)
    assert not (tmp_path / "no.zarr").exists()


def test_a_matrix_of_seven_motions_means_hinges(tmp_path: Path) -> None:
    K = joint_of(SKIN).K
    assert K is not None
    seven = SKIN.replace(joint={"matrix": matrixfile.stored(SKIN, K[:7, :7])})
    over = {"psi": [0.0, 0.01]}
    with pytest.raises(InputError, match="holds six motions and the twist, not the bend"):
        squama.sweep(seven, over, joint="compliant", out=tmp_path / "a.zarr")
    data = squama.sweep(seven, over, out=tmp_path / "b.zarr")
    assert data.joint == "hinge"
    assert "not the bend" in data.warnings


def test_the_command_and_the_map(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store, picture = str(tmp_path / "held.zarr"), str(tmp_path / "held.png")
    over = ["--over", "psi=-1deg:1deg:5", "--over", "alpha=40deg:50deg:3"]
    assert main(["sweep", "examples/stiff_skin.toml", *over, "--at", "0.09 rad/pitch", "-o", store]) == 0
    assert "all 15 beams are computed (5 psi x 3 alpha)" in capsys.readouterr().out
    assert main(["map", store, "--variable", "torque", "--plot", picture]) == 0
    assert Path(picture).stat().st_size > 10_000
    assert main(["sweep", "examples/stiff_skin.toml", "--over", "psi=2", "-o", store]) == 2
    assert main(["uncertainty", "examples/stiff_skin.toml", "--vary", "psi=1 deg +- 0.1 deg"]) == 2
    assert "Traceback" not in capsys.readouterr().err
