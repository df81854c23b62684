"""The periodic cell with thick and elastic scales on a very coarse mesh: limits, works, what is said of the plates."""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
pytest.importorskip("ipctk", reason="contact needs ipctk (the extra fe)")
pytest.importorskip("numba", reason="elements need numba (the extra fe)")

import squama
from squama.fe import runs
from squama.fe.assembly import _endless, make_walk
from squama.fe.bending import solid
from squama.fe.elements import Material
from squama.fe.exposed import box
from squama.fe.geometry import geometry
from squama.fe.mesh import pitch_mesh
from squama.study.parts import joint_of
from squama.study.verification import own_matrix

MESH = (0.5, 0.3)
PRINTED = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
BEAM = PRINTED.replace(scale={"youngs_modulus": None, "poisson_ratio": None})
SHAPE = geometry(BEAM)
H = SHAPE.thickness
GOAL = 0.08


@pytest.fixture(scope="module")
def mesh():
    return pitch_mesh(SHAPE, *MESH)


def walked(mesh, exposed, mu=0.25):
    walk = make_walk(mesh, SHAPE, mu, exposed=exposed)
    ended = walk.run(GOAL, 0.02)
    assert ended.reached, ended.sentence
    return walk


def state(walk):
    return {**_endless(walk), "v": walk.v[:6]}


def elastic(E, mesh=(6, 4)):
    return solid(SHAPE.eta, SHAPE.beta, H, Material(E, 0.35), bricks=mesh)


@pytest.fixture(scope="module")
def thick(mesh):
    return walked(mesh, box(SHAPE.eta, SHAPE.beta, H))


@pytest.mark.slow
def test_thin_plates_are_the_limit_of_thick_ones(mesh, thick):
    thin, slim = (state(walked(mesh, exposed)) for exposed in (None, box(SHAPE.eta, SHAPE.beta, 1e-6)))
    for name in ("T", "N", "theta", "p", "s"):
        # tolerance: the steps, 5e-4 measured, on every processor
        assert slim[name] == pytest.approx(thin[name], rel=1e-3), name
    # engagement comes earlier: by h over the rate of the gap
    assert 1.2 * thin["T"] < thick.T


@pytest.mark.slow
def test_rigid_scales_are_the_limit_of_stiff_ones(mesh, thick):
    stiff, rigid = state(walked(mesh, elastic(1e9))), state(thick)
    for name in ("T", "N", "theta", "p", "s", "v"):
        # tolerance: scales of a finite stiffness, and steps that end elsewhere: 6e-4 of the largest measured
        largest = np.abs(rigid[name]).max()
        np.testing.assert_allclose(stiff[name], rigid[name], rtol=0.0, atol=1e-2 * largest, err_msg=name)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_the_torques_work_is_stored_in_bar_and_scales_or_rubbed_away(mesh, mu):
    walk = walked(mesh, elastic(2e3), mu)
    # tolerance: the increments, 0.4 % measured, on every processor
    assert abs(walk.W - walk.reduced.energy - walk.W_fr) < 0.005 * walk.W
    assert (walk.W_fr > 0) == (mu > 0)
    assert 0.05 < walk.deflection < 0.3
    assert walk.columns["contact"][-1] == "tip edge C1B1 on side edge D2C2 (k = 1)"


def test_two_scales_bend_between_grips(mesh):
    walk = make_walk(mesh, SHAPE, 0.25, scales=2, exposed=elastic(2e3, (4, 2)))
    assert walk.run(0.08, 0.02).reached
    N = walk.columns["N"][-1]
    assert N[0] > 0
    assert np.isnan(N[1])
    assert walk.deflection > 0.01
    # tolerance: the increments, 0.04 % measured, on every processor
    assert abs(walk.W - walk.reduced.energy - walk.W_fr) < 0.01 * walk.W


@pytest.mark.slow
def test_the_compliant_model_follows_nonlinear_elements_on_the_joint_of_their_mesh():
    """The beam that stiffens, to twice its engagement: large strains make little of it."""
    beam, mesh = (
        squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(friction={"mu": 0.3}),
        (0.3, 0.1),
    )
    data = runs.cell(beam, to="0.106 rad/pitch", mesh=mesh, increment=0.0265)
    r = squama.twist(beam.replace(joint=joint_of(beam, own_matrix(beam, mesh))), at=data.Phi.values[1:])
    assert data["T"].values[-1] > 8 * data["T"].values[2]
    # tolerance: a coarse mesh and its barrier, 1.2 and 1.5 % measured, on every processor
    np.testing.assert_allclose(r["T"], data["T"].values[1:], rtol=0.02)
    np.testing.assert_allclose(r["N"][2:], data["N"].values[3:], rtol=0.02)


@pytest.mark.slow
def test_what_the_scales_are_is_said():
    exposed, words = runs.exposed_part(BEAM, SHAPE)
    assert words == "0.04 pitches thick, rigid, since their modulus is not given"
    assert exposed.amplitudes == 0
    exposed, words = runs.exposed_part(PRINTED, SHAPE)
    assert "elastic (3 GPa, nu 0.35): 12 x 6 x 2 quadratic bricks, about 0.8 % too stiff, of which 24 motions" in words
    assert exposed.amplitudes == 24
    for beam in (BEAM, PRINTED):
        points = runs.exposed_part(beam, SHAPE)[0].points
        np.testing.assert_allclose(np.ptp(points, axis=0), [SHAPE.eta, 2 * SHAPE.beta, H])


def test_far_bent_scales_are_told():
    walk = SimpleNamespace(
        columns={"deflection": [0.0, 0.45]}, contact=SimpleNamespace(row=SimpleNamespace(rest=SHAPE.rest))
    )
    assert runs._bent_far(walk)[0].startswith("the scales are bent by 15 % of their length; their elements are linear")
    walk.columns["deflection"] = [0.2]
    assert runs._bent_far(walk) == []


def test_a_run_in_si_units(tmp_path):
    asked = {"mesh": MESH, "increment": 0.02, "restart": tmp_path / "run.npz"}
    runs.cell(BEAM, to="0.02 rad/pitch", **asked)
    data = runs.cell(BEAM, to="0.04 rad/pitch", **asked)
    assert data.attrs["plates"] == "0.04 pitches thick, rigid, since their modulus is not given"
    assert data.attrs["warnings"] == ""
    assert (data["deflection"].values == 0).all()
    # thin scales touch at .05 only
    assert data["N"].values[-1] > 0
    with pytest.raises(squama.InputError, match=r"belongs to a run with plates = 0\.04 pitches thick"):
        runs.cell(BEAM, to="0.06 rad/pitch", ideal=True, **asked)
