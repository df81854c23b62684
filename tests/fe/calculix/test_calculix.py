"""CalculiX runs our decks, and gives what our own finite beam and the row of hinges give; how the two are compared."""

import shutil

import numpy as np
import pytest
import xarray as xr
from beside import beside
from scipy.spatial.transform import Rotation

import squama
from squama.errors import InputError
from squama.fe import ccx
from squama.fe.geometry import geometry

BEAM = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
COARSE = {"size": 0.4, "edge_size": 0.2}
D, E = BEAM.pitch, BEAM.substrate.youngs_modulus
needs_ccx = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed (calculix-ccx)")


def test_inclinations_are_seen_from_one_section():
    """Attitudes of both programs are put into one frame: a scale that stands still in space, seen from two sections."""
    n, mean = 2, 0.1
    own = xr.Dataset(
        {
            "T": ("point", [0.0, 2.0]),
            "gap": ("point", [np.inf, 5e-5 * D]),
            **{name: (("point", "scale"), np.zeros((2, n))) for name in ("w_X", "w_Y", "w_Z")},
            "twist": (("point", "scale"), np.array([[0.0, 0.0], [mean, mean]])),
        },
        coords={"phi": ("point", [0.0, mean]), "scale": [1, 2]},
    )
    shape = geometry(BEAM)
    turn = (np.arange(n) - shape.cut) * mean
    seen = turn - [0.03, -0.02]
    w = []
    for extra in turn - seen:
        c, s = np.cos(extra), np.sin(extra)
        Q = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        w.append(Rotation.from_matrix(shape.rest.axes @ Q @ shape.rest.axes.T).as_rotvec())
    w = np.array(w)
    theirs = xr.Dataset(
        {
            "T": ("point", [0.0, 1.0, 2.02]),
            "theta": (("point", "scale"), shape.theta0 - np.stack([0 * w[:, 1], 0.3 * w[:, 1], w[:, 1]])),
            "w_X": (("point", "scale"), np.stack([0 * w[:, 0], 0.3 * w[:, 0], w[:, 0]])),
            "w_Z": (("point", "scale"), np.stack([0 * w[:, 2], 0.3 * w[:, 2], w[:, 2]])),
            "local_twist": (("point", "scale"), np.stack([0 * seen, 0.5 * turn - 0.3 * (turn - seen), seen])),
            "gap": (("point", "scale"), [[0.1, np.nan], [np.nan, np.nan], [-1e-3, np.nan]]),
        },
        coords={"phi": ("point", [0.0, 0.05, 0.1]), "scale": [1, 2]},
    )
    both = beside(BEAM, own, theirs)
    np.testing.assert_allclose(both["theta_calculix"], both["theta"], atol=1e-12)
    assert np.abs(both["theta"].values[-1] - shape.theta0).max() > 1e-3
    np.testing.assert_allclose(both["dT"], [0, 0.01], atol=1e-12)
    np.testing.assert_allclose(both["gap_calculix"], [np.nan, -1e-3])
    assert float(both["gap"][-1]) == pytest.approx(5e-5)
    with pytest.raises(InputError, match="2 scales here, 1 in CalculiX"):
        beside(BEAM, own, theirs.isel(scale=[0]))


def run(tmp_path, scales, increments, twist):
    """Run a coarse deck and return its results beside the row of hinges with the elements' joint."""
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    from squama.fe import deck

    place = tmp_path / "beam.inp"
    model = deck.model(BEAM, scales=scales, mu=0.2, twist=twist, increments=increments, ideal=True, **COARSE)
    place.write_text(deck.write(model, "calculix"))
    found = ccx.run_calculix(place, folder=tmp_path / "run", timeout=3000)
    joint = {"stiffness": 0.0119 * E * D**3, "inclusion_factor": 1.418}
    row = squama.row(BEAM.replace(joint=joint), scales=scales, to=f"{twist} rad/pitch", joint="hinge")
    return found, row.swap_dims(point="phi").drop_vars("T_periodic").interp(phi=found.phi.values)


def ours(scales, increments, twist):
    """Our finite beam on the mesh of the deck."""
    pytest.importorskip("ipctk", reason="needs the extra fe")
    from squama.fe.runs import cell

    mesh = COARSE["size"], COARSE["edge_size"]
    return cell(BEAM, scales=scales, to=f"{twist} rad/pitch", mesh=mesh, increment=twist / increments, ideal=True)


def agree(found, own, torque, angle):
    """Hold CalculiX to our beam: torque (share) and inclinations (deg) in contact, and gaps of both in all increments.

    Before contact only the volume terms of the two neo-Hookean solids differ; in contact the penalty lets edges
    overlap.
    """
    both = beside(BEAM, own, found)
    assert both.sizes["point"] == found.sizes["point"] - 1
    free = np.isnan(both["gap"].values)
    assert free[0]
    assert not free[-1]
    np.testing.assert_allclose(both["dT"].values[free], 0, atol=1e-3)
    away = np.degrees(np.abs(both["theta_calculix"] - both["theta"]).values)
    assert away[free].max() < 0.005
    np.testing.assert_allclose(both["dT"].values, 0, atol=torque)
    assert away.max() < angle
    assert (both["gap"].values[~free] > 0).all()
    assert (both["gap"].values[~free] < 1e-4).all()
    assert np.nanmin(both["gap_calculix"].values) > -0.005


def compare(found, row):
    """What holds for any number of scales."""
    touching = found.gap.values[:, :-1]
    assert touching[0].min() > 0.05
    # the penalty lets the edges overlap by thousandths of a pitch once they touch, and by no more
    assert np.abs(touching[-1]).max() < 0.01
    assert (np.diff(found["T"].values) > 0).all()
    # scales rise at the free end and are pressed down at the other, as in the row
    lift = found.theta.values[-1] - found.theta.values[0]
    assert lift[0] > 0 > lift[-1]
    assert (np.diff(found.theta.values[-1]) < 0).all()
    return np.abs(found.theta.values - row.theta.values).max(axis=1)


@needs_ccx
@pytest.mark.slow
def test_calculix_with_two_scales(tmp_path):
    found, row = run(tmp_path, 2, 4, 0.08)
    agree(found, ours(2, 4, 0.08), torque=0.003, angle=0.05)
    away = compare(found, row)
    # the clamped ends twist less than the middle, so the row, twisted alike everywhere, lags behind
    assert away[-1] < 0.02
    share = found.local_twist.values[-1, 1] - found.local_twist.values[-1, 0]
    assert 1.1 < share / 0.08 < 1.4


@needs_ccx
@pytest.mark.slow
def test_calculix_with_five_scales(tmp_path):
    found, row = run(tmp_path, 5, 12, 0.12)
    agree(found, ours(5, 12, 0.12), torque=0.01, angle=0.25)
    assert compare(found, row)[-1] < 0.03


@needs_ccx
@pytest.mark.slow
def test_calculix_with_elastic_scales(tmp_path):
    """Printed scales, thick, nonlinear in CalculiX, linear in their frames here; they touch from .08 on."""
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    from squama.fe import deck
    from squama.fe.runs import cell

    beam, mesh = squama.Beam.from_toml("examples/pla_on_vps.toml"), (0.4, 0.1)
    model = deck.model(beam, scales=2, mu=0.25, twist=0.12, increments=12, size=mesh[0], edge_size=mesh[1])
    place = tmp_path / "beam.inp"
    place.write_text(deck.write(model, "calculix"))
    found = ccx.run_calculix(place, timeout=3000)
    own = cell(beam, scales=2, to="0.12 rad/pitch", mu=0.25, mesh=mesh, increment=0.01)
    both = beside(beam, own, found)
    np.testing.assert_allclose(both["dT"].values, 0, atol=0.005)
    assert np.degrees(np.abs(both["theta_calculix"] - both["theta"]).values).max() < 0.1
    assert np.nanmin(both["gap_calculix"].values) > -0.01
    assert float(own["deflection"][-1]) > 0.015 * beam.pitch
