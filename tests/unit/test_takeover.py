"""Curves of the real beam where general contact takes over."""

import math

import numpy as np
import pytest

import squama


@pytest.mark.xfail(strict=True, reason="no stiffness where general contact takes over: one contact solver (next issue)")
def test_the_stiffness_is_known_where_general_contact_takes_over():
    pytest.importorskip("ipctk", reason="needs the extra fe")
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    r = squama.twist(beam, mu=0.5, to="0.212 rad/pitch", points=10)
    assert math.isfinite(float(r.phi_general))
    assert np.isfinite(r["T"].values).all()
    assert np.isfinite(r["K_t"].values).all()
