"""Units of texts and pictures: one rule for both, by the largest value."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

import squama
from squama import plot
from squama.people import readable
from squama.plot import maps, style


@pytest.mark.parametrize(
    ("unit", "largest", "factor", "name"),
    [
        ("N m", 0.02, 1e3, "N mm"),
        ("N m", 0.3, 1.0, "N m"),
        ("N m", -0.02, 1e3, "N mm"),
        ("N m^2", 0.02, 1e6, "N mm2"),
        ("N m^2", 2.0, 1.0, "N m2"),
        ("N", 0.05, 1.0, "N"),
        ("N", 2e-4, 1e6, "µN"),
        ("J/m", 0.02, 1e3, "mJ/m"),
    ],
)
def test_a_quantity_has_the_unit_of_its_size(unit, largest, factor, name):
    found = readable(unit, largest)
    assert found[0] == pytest.approx(factor, rel=1e-12)
    assert found[1] == name


def test_a_picture_shows_the_torque_in_the_unit_of_the_summary():
    beam = squama.Beam.from_toml("examples/stiff_skin.toml")
    r = squama.twist(beam, ends="endless", to="0.1 rad/pitch", points=5)
    torque, force, *_ = plot.response_figure(r).axes
    assert torque.get_ylabel() == "Torque $T$ (N mm)"
    assert force.get_ylabel() == "Friction force $f$ (N)"
    drawn = max(float(np.max(line.get_ydata())) for line in torque.lines if len(line.get_xdata()) > 2)
    assert drawn == pytest.approx(1e3 * float(r["T"].max()), rel=1e-9)
    assert style.prefixed("K_t", 3e-3)[1].endswith("(N mm$^2$)")


def test_a_region_that_tapers_is_outlined_to_its_tip():
    x, y = np.arange(90.0), np.arange(90.0)
    wedge = y[:, None] < 10 - x / 3
    ax = Figure().subplots()
    maps._outline(ax, x, y, wedge)
    (line,) = ax.collections
    far = max(float(path.vertices[:, 0].max()) for path in line.get_paths())
    assert far > 26
    # a piece that is thin everywhere has no line
    thin = Figure().subplots()
    maps._outline(thin, x, y, np.broadcast_to(y[:, None] < 2, (90, 90)))
    assert not any(len(path) for one in thin.collections for path in one.get_paths())


def test_the_endless_beam_beside_a_row_names_its_model():
    beam = squama.Beam.from_toml("examples/stiff_skin.toml")
    words = {
        "compliant": "thick, elastic scales on compliant joints",
        "hinge": "thin, rigid scales on hinges, edge law",
    }
    for joint, model in words.items():
        r = squama.row(beam, scales=3, to="0.05 rad/pitch", points=3, joint=joint)
        assert r.T_periodic.attrs["long_name"] == f"torque of the endless beam ({model})"
