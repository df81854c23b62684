"""Curves on compliant joints where a second contact comes in."""

import math

import numpy as np
import pytest

import squama


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("beyond", [1e-3, 0.02])
def test_the_stiffness_is_known_where_a_second_contact_comes_in(beyond):
    """At a single point there, too: the last one of the curve."""
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    whole = squama.twist(beam, mu=0.5, to="0.25 rad/pitch", points=10)
    start = float(whole.phi_second)
    assert math.isfinite(start)
    r = squama.twist(beam, mu=0.5, to=f"{start + beyond} rad/pitch", points=10)
    assert np.isfinite(r["T"].values).all()
    assert np.isfinite(r["K_t"].values).all()
    assert 0 < float(r.stiffness_ratio[-1]) < 3
