"""Models beside a reference, on curves whose differences are known."""

import numpy as np
import pytest
import xarray as xr

from squama.cli.elements import finite, ranges
from squama.fe.agreement import compare
from squama.io import datasets
from squama.plot import compare_figure, elements_figure
from squama.study.verification import flat

PHI = np.linspace(0, 0.3, 31)


def curve(T, theta=None, phi=PHI, **attrs):
    theta = 0.1 + phi if theta is None else theta
    return xr.Dataset({"phi": ("point", phi), "T": ("point", T), "theta": ("point", theta)}, attrs=attrs)


@pytest.fixture
def table():
    models = {
        "near": ("1 % more", curve(1.01 * PHI)),
        "leaves": ("a difference of phi/2", curve(PHI * (1 + PHI / 2), theta=0.1 + 2 * PHI)),
        "below": ("10 % less from the start", curve(0.9 * PHI)),
        "ends": ("ends at .2", curve(np.where(PHI < 0.205, PHI, np.nan))),
        "other": ("at other twists", curve(np.linspace(0, 0.26, 14), phi=np.linspace(0, 0.26, 14))),
        "none": ("nothing", curve(np.full(31, np.nan))),
    }
    return compare(curve(PHI, mesh="a mesh"), models, title="Models")


def test_how_far_models_hold(table):
    within = dict(zip(table["model"].values, table["within"].values, strict=True))
    assert within["near"] == 0.3
    assert within["leaves"] == pytest.approx(0.1)
    assert within["below"] == 0
    assert within["ends"] == pytest.approx(0.2)
    assert within["other"] == pytest.approx(0.26)
    assert np.isnan(within["none"])
    assert float(table["last"].sel(model="ends")) == pytest.approx(0.2)


def test_a_difference_that_leaves_and_comes_back_ends_the_range_where_it_left():
    off = np.where((PHI > 0.1) & (PHI < 0.2), 0.08, 0.0)
    table = compare(curve(PHI), {"a": ("a", curve(PHI * (1 + off)))})
    assert 0.1 < float(table["within"][0]) < 0.11
    assert float(table["dT_last"][0]) == pytest.approx(0)


def test_differences(table):
    one = table.sel(model="leaves")
    np.testing.assert_allclose(one["dT"].values[1:], PHI[1:] / 2, rtol=1e-12)
    assert np.isnan(one["dT"].values[0])
    np.testing.assert_allclose(one["dtheta"].values, PHI, atol=1e-15)
    assert float(one["dT_last"]) == pytest.approx(0.15)
    assert float(one["dtheta_last"]) == pytest.approx(0.3)
    np.testing.assert_allclose(table["dT"].sel(model="below").values[1:], -0.1, rtol=1e-12)
    assert np.isnan(table["T"].sel(model="other").values[-4:]).all()
    np.testing.assert_allclose(table["T"].sel(model="other").values[:27], PHI[:27], atol=1e-12)


def test_a_share_of_ones_own():
    table = compare(curve(PHI), {"a": ("a", curve(PHI * (1 + PHI / 2)))}, share=0.1)
    assert float(table["within"][0]) == pytest.approx(0.2)
    assert table.attrs["share"] == 0.1


def test_the_table_is_a_file_and_comes_back(table, tmp_path):
    for ending in (".csv", ".nc"):
        back = datasets.read(datasets.save(flat(table), tmp_path / f"table{ending}"))
        np.testing.assert_array_equal(back["dT"].values, table["dT"].values)
        assert list(back["words"].values) == list(table["words"].values)
    header = next(line for line in (tmp_path / "table.csv").read_text().splitlines() if not line.startswith("#"))
    assert header == "model,phi (rad),T_elements (N m),theta_elements (rad),T (N m),theta (rad),dT (1),dtheta (rad)"


def test_the_ranges_in_words(table):
    near, leaves, below, ends, _, none = ranges(table)
    assert near[:2] == ("1 % more", "17.2")
    assert leaves[1:] == ("5.73", "+15 %", "+17.2")
    assert below[1:3] == ("0", "-10 %")
    assert ends[1] == "11.5"
    assert none == ("nothing", "-", "-", "-")


def test_finite_beams_are_set_beside_each_other():
    models = {
        "near": ("1 % more", curve(1.01 * PHI)),
        "beam": ("finite beam", curve(0.5 * PHI)),
        "row": ("row", curve(np.where(PHI < 0.205, 0.4 * PHI, np.nan), theta=0.2 + PHI)),
    }
    table = compare(curve(PHI, mesh="a mesh"), models)
    assert [row[0] for row in ranges(table)] == ["1 % more"]
    beam, row = finite(table)
    assert "one the torque is -50 % at 0.573 deg per pitch and -50 % at 17.2 deg per pitch, theta +0.00 deg" in beam
    assert "beam the torque is -20 % at 0.573 deg per pitch and -20 % at 11.5 deg per pitch, theta +5.73 deg" in row
    assert finite(table.sel(model=["near"])) == []
    # what makes a beam finite is no error of a model: not in the panels of differences
    torque, off, theta, apart = compare_figure(table).axes
    assert [len(ax.lines) for ax in (torque, theta)] == [4, 4]
    assert (len(off.lines), len(apart.lines)) == (1, 2)


def test_the_figure_shows_every_model(table):
    figure = compare_figure(table)
    torque, off, theta, apart = figure.axes
    assert len(torque.lines) == 7
    assert len(theta.lines) == 7
    np.testing.assert_allclose(off.lines[1].get_ydata()[1:], 50 * PHI[1:])
    low, high = off.get_ylim()
    assert low <= -10
    assert high >= 15
    assert apart.get_ylabel() == r"Difference of $\theta$ (deg)"
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert words == ["finite elements: a mesh", *table["words"].values, "within 5 %"]


def test_the_figure_of_a_run():
    zero = np.zeros(31)
    names = ("N", "f", "U_el", "W_fr", "W")
    about = {"mesh": "a mesh", "joint": "elements", "sense": "+", "reached": 0, "sentence": "stopped"}
    data = curve(np.maximum(PHI, 3 * PHI - 0.2), plates="thin, rigid", **about)
    data = data.assign(dict.fromkeys(names, ("point", zero + (PHI > 0.1)))).assign(Phi=("point", PHI / 0.025))
    words = np.where(PHI > 0.1, "tip edge on side edge", "")
    data = data.assign(contact=("point", words)).assign_coords(mu=0.2)
    figure = elements_figure(data)
    assert len(figure.axes) == 4
    assert figure.axes[0].get_ylabel() == r"Torque $T$ (N m)"
    assert "stopped" in figure.get_suptitle()
    assert "scales thin, rigid" in figure.get_suptitle()
    assert "from 6.3 deg per pitch: tip edge on side edge" in [t.get_text() for t in figure.legends[0].get_texts()]
