"""Runs that stop say why: where the scales snap, and where they do not."""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("netgen", reason="needs netgen-mesher (the extra fe)")
pytest.importorskip("ipctk", reason="needs the extra fe")
pytest.importorskip("numba", reason="needs the extra fe")

from matrices import INCREMENT, shape, straight

import squama
from squama.fe import runs
from squama.fe.walk import Ended, Walk
from squama.people import per_pitch

# narrow scales: the contact comes to the tip edge's end early; the compliant model snaps at .138 rad per pitch
NARROW = squama.Beam.from_ratios(eta=3, beta=0.4, lam=0.32, zeta=0.18, slenderness=45, mu=0.5)
MESH = (0.4, 0.2)
STOPPED = Ended(False, "stopped at 11.46 deg per pitch: no balance of the contact was found")


def stopped(beta, lam, goal, **options):
    """A beam on a matrix of the given half width and height, twisted as far as it goes."""
    K = np.diag([1.1, 0.8, 1.1, 0.17, 0.021, 0.15, 0.05])
    K[2, 4] = K[4, 2] = 0.096
    walk = straight(shape(3, beta, lam), K, 0.5, **options)
    assert not walk.run(walk.aim(0.0, goal), INCREMENT).reached
    return walk


@pytest.mark.slow
def test_a_contact_that_slips_off_a_corner_is_a_snap():
    walk = stopped(0.4, 0.32, 0.3)
    told = walk.explained(STOPPED, 0.3, INCREMENT)
    assert not told.reached
    assert told.sentence.startswith(f"stopped at {per_pitch(walk.phi, 4)}: the scales snap there; let go, they")
    assert "energy is lost on the way, and the curve ends" in told.sentence


def test_scales_that_stay_where_they_are_do_not_snap():
    walk = straight(shape(3, 1.25, 0.45), np.diag([1e4, 1e4, 1e4, 1, 0.021, 1, 0.05]), 0.5, hinged=True)
    assert walk.run(walk.aim(0.0, 0.2), INCREMENT).reached
    assert walk.explained(STOPPED, 0.28, INCREMENT) is STOPPED


@pytest.mark.parametrize(
    "ended",
    [Ended(True, "the asked twist was reached"), Ended(False, "stopped at 5.73 deg per pitch: elements invert")],
)
def test_other_ends_keep_their_words(ended):
    # nothing is asked of the walk
    assert Walk.explained(SimpleNamespace(), ended, 0.5, 0.01) is ended


@pytest.mark.slow
def test_a_cell_says_that_its_scales_snap():
    data = runs.cell(NARROW, to="0.2 rad/pitch", mesh=MESH, increment=0.02, ideal=True)
    assert data.attrs["reached"] == 0
    assert "the scales snap there" in data.attrs["sentence"]
    # the contact has come to the end of the tip edge
    # tolerance: the last increment before the corner, 7e-4 measured, on every processor
    assert np.nanmax(data["p"].values) == pytest.approx(0.4 * NARROW.pitch, rel=5e-3)
    assert 0.12 < float(data["phi"][-1]) < 0.15
    # what was done is there, and balanced
    assert data.sizes["point"] > 6
    assert abs(data.attrs["energy_error"]) < 0.01


@pytest.mark.slow
def test_a_finite_beam_says_that_its_scales_snap():
    data = runs.cell(NARROW, scales=3, to="0.3 rad/pitch", mesh=MESH, increment=0.02, ideal=True)
    assert data.attrs["reached"] == 0
    assert "the scales snap there" in data.attrs["sentence"]
    assert 0.15 < float(data["phi"][-1]) < 0.25
    assert "corner B2 on side edge D3C3" in str(data["contact"].values[-1])
