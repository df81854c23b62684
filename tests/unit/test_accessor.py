"""`result.squama`: every kind of result finds its figure, says what it is, and draws into axes that are there."""

import functools
import re
import subprocess
import sys
from html import unescape
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import squama
from squama import plot

EXAMPLES = Path(__file__).parents[2] / "examples"
HINGED = squama.Beam.from_ratios(mu=0.3)
ON_HINGES = {"joint": "hinge", "ideal": True}
RESULTS = {
    "response_figure": lambda: squama.twist(HINGED, points=20, **ON_HINGES),
    "cycle_figure": lambda: squama.cycle(HINGED, "0.2 rad/pitch", points=20, **ON_HINGES),
    "row_figure": lambda: squama.row(HINGED.replace(scales=5), to="0.2 rad/pitch", joint="hinge", points=5),
    "plane_figure": lambda: squama.bend_twist_map(HINGED, "bend 1 rad/m; twist 8 rad/m", joint="hinge", points=9),
    "path_figure": lambda: squama.bend_twist(HINGED, "bend 1 rad/m; twist 8 rad/m", **ON_HINGES),
    "vibration_figure": lambda: squama.vibrate(HINGED, rotor="1 kg m2", release="0.15 rad/pitch", **ON_HINGES),
    "shaken_figure": lambda: squama.shake(HINGED, [0.5, 0.6], static="0.06 rad/pitch", rotor="0.01 kg m2", **ON_HINGES),
    "fit_figure": lambda: squama.fit(
        EXAMPLES / "measured_loop.csv", squama.Beam.from_toml(EXAMPLES / "pla_on_vps.toml"), joint="hinge"
    ).dataset(),
    "map_figure": lambda: squama.sweep(HINGED, {"eta": [2, 3]}, **ON_HINGES),
    "uncertainty_figure": lambda: squama.uncertainty(HINGED, {"theta0": "10 deg +- 1 deg"}, samples=3200, **ON_HINGES),
}


@functools.cache
def result(kind: str) -> xr.Dataset:
    return RESULTS[kind]()


@pytest.mark.parametrize("kind", RESULTS)
def test_every_kind_finds_its_figure(kind, monkeypatch) -> None:
    drawn = []
    monkeypatch.setattr(plot, kind, lambda *given, **options: drawn.append((given, options)), raising=False)
    result(kind).squama.plot(dark=1)
    ((given, options),) = drawn
    assert given[0] is result(kind)
    assert options == {"dark": 1}


@pytest.mark.parametrize("kind", ["response_figure", "cycle_figure", "path_figure", "row_figure", "vibration_figure"])
def test_the_figure_is_one_and_a_variable_goes_into_axes_that_are_there(kind) -> None:
    data = result(kind)
    assert len(data.squama.plot().axes) > 1
    ax = Figure().subplots()
    name = "phi" if "t" in data else "theta"
    assert data.squama.line(name, ax, unit="deg") is ax
    lines = ax.lines
    over = "t" if "t" in data else "Phi"
    values = np.degrees(data[name].transpose(..., "point").values.reshape(len(lines), -1))
    for drawn, wanted in zip(lines, values, strict=True):
        np.testing.assert_allclose(drawn.get_xdata(), data[over].values)
        np.testing.assert_allclose(drawn.get_ydata(), wanted)
    assert ax.get_ylabel().endswith("(deg)")


def test_a_family_names_its_lines_and_labels_that_are_there_stay() -> None:
    family = squama.twist(HINGED, mu=[0.1, 0.4], points=20, **ON_HINGES)
    ax = Figure().subplots()
    ax.set_ylabel("mine")
    family.squama.line("T", ax, x="phi", x_unit="deg", unit="kN m", color="red")
    assert [line.get_label() for line in ax.lines] == ["mu = 0.1", "mu = 0.4"]
    assert {line.get_color() for line in ax.lines} == {"red"}
    np.testing.assert_allclose(ax.lines[1].get_ydata(), family["T"][1] / 1e3)
    np.testing.assert_allclose(ax.lines[1].get_xdata(), np.degrees(family["phi"][1]))
    assert ax.get_ylabel() == "mine"
    assert ax.get_xlabel().endswith("(deg)")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"name": "end"}, 'name = "end": is no number along the points of this result; allowed: Phi, phi, '),
        ({"name": "T", "x": "mu"}, 'x = "mu": is no number along'),
        ({"name": "T", "unit": "mm"}, 'unit = "mm": is no unit of T, which is in N m'),
        ({"name": "K_t", "unit": "N mm2"}, 'unit = "N mm2": is no unit of K_t, which is in N m2'),
    ],
)
def test_what_cannot_be_drawn_is_one_line(given, words) -> None:
    with pytest.raises(squama.InputError, match=f"^{re.escape(words)}"):
        result("response_figure").squama.line(**given)


def test_other_datasets_have_no_figure() -> None:
    with pytest.raises(squama.InputError, match="no figure of this dataset"):
        xr.Dataset({"a": 1}).squama.plot()
    assert xr.Dataset({"a": 1}).squama.summary().splitlines()[0] == "dataset"


def test_the_summary_and_the_card_have_the_figures() -> None:
    data = result("response_figure")
    text, shown = data.squama.summary(), unescape(data.squama._repr_html_())
    for name, unit in (("phi_e", "rad"), ("T_c", "N m"), ("Phi_end", "rad/m")):
        for words in (text, shown):
            assert f"{data[name].item():.4g} {unit}" in words
    assert data["end"].item() in text
    assert "thin, rigid scales on hinges, edge law" in text.splitlines()[0]
    assert "<svg" in shown
    for warning in data.attrs["warnings"].splitlines():
        assert f"warning: {warning}" in text
    # a loop's figures are there, its points are not
    cycle = result("cycle_figure").squama.summary()
    assert f"{result('cycle_figure')['zeta_eq'].item():.4g}" in cycle
    assert "torque T" not in cycle
    assert repr(data.squama) == text


def test_a_file_that_was_read_knows_it_too(tmp_path) -> None:
    squama.save(result("response_figure"), tmp_path / "a.nc")
    code = (
        f"import squama; print(len(squama.read({str(tmp_path / 'a.nc')!r}).squama.plot().axes), squama.plot.__name__)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.split() == ["4", "squama.plot"]
