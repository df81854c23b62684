"""Designs refined for their own number of scales."""

import numpy as np
import pytest

import squama
from squama.inverse.residuals import Ends


def test_figures_of_scales_with_ends():
    ends = Ends(*(np.array([v]).T for v in ([4.0, 2.0, 3.0], [16.0, 2.5, 5.0], [0.4, 1.0, 1.7])))
    at, h = np.array([[12.0, 16.0, 40.0], [2.0, 2.5, -1.0], [3.0, 5.0, 8.0]]), 1e-6
    slopes = np.ones((3, 1, 3))
    figures, rates = ends.figures(at, slopes)
    np.testing.assert_allclose(figures[:, 1], ends.own[:, 0], rtol=1e-14)
    # a power of 1 is a share, also of a figure that has changed its sign
    np.testing.assert_allclose(figures[1], 0.8 * at[1], rtol=1e-14)
    np.testing.assert_allclose(figures[0], 4 * (at[0] / 16) ** 0.4, rtol=1e-14)
    up, down = (ends.figures(at + step, slopes)[0] for step in (h, -h))
    np.testing.assert_allclose(rates[:, 0], (up - down) / (2 * h), rtol=1e-6)
    np.testing.assert_allclose(ends.rates, rates[:, 0, 1:2], rtol=1e-14)
    lost = ends._replace(own=ends.own * np.nan)
    np.testing.assert_allclose(lost.figures(at, slopes)[0][1], at[1])


@pytest.mark.slow
@pytest.mark.parametrize("asked", [3.6, 4.0])
def test_a_ratio_that_the_end_scale_limits_is_found(asked):
    """The last of eight scales has no neighbour: the endless beam is 20 times as stiff as the bar where these are 4."""
    data = {
        "load": "bending",
        "designs": 1,
        "target": {
            "engagement": "at least 35 deg total",
            "points": [{"twist": "55 deg total", "stiffness_ratio": asked}],
        },
        "vary": {
            "scale.length": ("15 mm", "40 mm"),
            "scale.width": ("8 mm", "18 mm"),
            "scale.alpha": ("10 deg", "30 deg"),
            "scale.theta0": ("8 deg", "25 deg"),
        },
        "limits": {"printable": False},
    }
    beam = squama.Beam.from_toml("examples/finger.toml").replace(scales=8)
    found = squama.inverse_design(data, beam=beam, starts=512)
    assert found.met, found.verdict
    r = squama.bend(found[0].beam, at="55 deg total")
    assert float(r.stiffness_ratio[0]) == pytest.approx(asked, rel=0.01)
