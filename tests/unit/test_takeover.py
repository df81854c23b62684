"""Curves of the real beam where general contact takes over."""

import math

import numpy as np
import pytest

import squama


@pytest.mark.parametrize("beyond", [1e-3, 0.02])
def test_the_stiffness_is_known_where_general_contact_takes_over(beyond):
    """At a single point there, too: the last one of the curve."""
    pytest.importorskip("ipctk", reason="needs the extra fe")
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    whole = squama.twist(beam, mu=0.5, to="0.25 rad/pitch", points=10)
    start = float(whole.phi_general)
    assert math.isfinite(start)
    r = squama.twist(beam, mu=0.5, to=f"{start + beyond} rad/pitch", points=10)
    assert np.isfinite(r["T"].values).all()
    assert np.isfinite(r["K_t"].values).all()
    assert 0 < float(r.stiffness_ratio[-1]) < 3
