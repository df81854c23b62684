"""`result.squama`: every kind of result finds its figure, says what it is, and draws into axes that are there."""

import functools
import re
import subprocess
import sys
from html import unescape
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import squama
from squama import plot
from squama.io.measured import Measured

EXAMPLES = Path(__file__).parents[2] / "examples"
HINGED = squama.Beam.from_ratios(mu=0.3)
ON_HINGES = {"joint": "hinge", "ideal": True}


def sweep() -> xr.Dataset:
    with TemporaryDirectory() as folder:
        over = {"mu": [0.1, 0.3, 0.5], "eta": [2, 2.5, 3]}
        return squama.sweep(HINGED, over, out=f"{folder}/map.zarr", **ON_HINGES).load()


@functools.cache
def fitted() -> squama.Fit:
    beam = squama.Beam.from_toml(EXAMPLES / "pla_on_vps.toml")
    return squama.fit(EXAMPLES / "measured_loop.csv", beam, joint="hinge", starts=1, nuisances="none")


RESULTS = {
    "response_figure": lambda: squama.twist(HINGED, points=20, **ON_HINGES),
    "cycle_figure": lambda: squama.cycle(HINGED, "0.2 rad/pitch", points=20, **ON_HINGES),
    "row_figure": lambda: squama.row(HINGED.replace(scales=5), to="0.2 rad/pitch", joint="hinge", points=5),
    "plane_figure": lambda: squama.bend_twist_map(HINGED, "bend 1 rad/m; twist 8 rad/m", joint="hinge", points=9),
    "path_figure": lambda: squama.bend_twist(HINGED, "bend 1 rad/m; twist 8 rad/m", **ON_HINGES),
    "vibration_figure": lambda: squama.vibrate(HINGED, rotor="1 kg m2", release="0.15 rad/pitch", **ON_HINGES),
    "shaken_figure": lambda: squama.shake(HINGED, [2, 3], static="0.06 rad/pitch", rotor="0.01 kg m2", **ON_HINGES),
    "fit_figure": lambda: fitted().dataset(),
    "prediction_figure": lambda: fitted().predict("0.1 rad/pitch", samples=12, points=20),
    "plan_figure": lambda: squama.plan(HINGED, ("mu", "K_theta"), noise="5 N mm", joint="hinge").dataset(),
    "map_figure": sweep,
    "uncertainty_figure": lambda: squama.uncertainty(
        HINGED, {"theta0": "10 deg +- 1 deg"}, samples=3200, indices=64, **ON_HINGES
    ),
    "front_figure": lambda: xr.Dataset(
        {
            name: ("design", np.array([1.0, 3.0, 2.0]) * k, {"objective": "max", "units": "1"})
            for k, name in enumerate(("range", "RED", "lock"), 1)
        },
        attrs={"load": "twisting", "law": "edge", "objectives": ["a front"]},
    ),
}
PANELS = {
    # call, panel of the whole figure, what one of its lines shows across and up
    "curve": ("response_figure", ("T",), 0, "Phi", "T"),
    "curve of theta": ("response_figure", ("theta",), 2, "Phi", "theta"),
    "loops": ("cycle_figure", (), 0, None, None),
    "energies": ("cycle_figure", (), 1, None, "U_el"),
    "inclinations": ("row_figure", (), 0, None, None),
    "plane_path": ("path_figure", (), 0, "psi_event", "phi_event"),
    "path_loads": ("path_figure", (), 1, None, "M"),
    "plane_contacts": ("plane_figure", (), 0, None, None),
    "plane_load": ("plane_figure", ("M",), 1, None, None),
    "record": ("vibration_figure", (), 0, "t", "phi"),
    "damping": ("vibration_figure", (), 1, None, "zeta_cycle"),
    "phase_plane": ("vibration_figure", (), 2, "phi", "phi_speed"),
    "fitted": ("fit_figure", (), 0, None, None),
    "residuals": ("fit_figure", (), 1, None, None),
    "expected_errors": ("plan_figure", ("mu",), 0, None, None),
    "histogram": ("uncertainty_figure", (), 0, None, None),
    "cumulative": ("uncertainty_figure", (), 1, None, None),
    "sobol": ("uncertainty_figure", (), 2, None, None),
    "tradeoff": ("front_figure", ("range", "RED"), 0, None, None),
    "map_slice": ("map_figure", ("RED",), 0, None, None),
    "map_slice of ends": ("map_figure", ("end",), 0, None, None),
}
UNITS = {"rad": 1, "deg": np.pi / 180, "N m": 1, "kN m": 1e3, "J/m": 1, "kJ/m": 1e3, "s": 1, "rad/m": 1, "rad/s": 1}
"""Units in the labels of axes, in SI."""


@functools.cache
def result(kind: str) -> xr.Dataset:
    return RESULTS[kind]()


@pytest.mark.parametrize("kind", [kind for kind in RESULTS if kind != "row_figure"])
def test_every_kind_finds_its_figure(kind, monkeypatch) -> None:
    drawn = []
    monkeypatch.setattr(plot, kind, lambda *given, **options: drawn.append((given, options)), raising=False)
    result(kind).squama.plot(dark=1)
    ((given, options),) = drawn
    assert given[0] is result(kind)
    assert options == {"dark": 1}


def test_a_variable_of_the_row_is_drawn_over_that_of_each_scale() -> None:
    data = result("row_figure")
    lines = plot.line(data, "T", x="theta").lines
    assert [line.get_label() for line in lines] == [f"scale = {i}" for i in range(1, 6)]
    for line, theta in zip(lines, data["theta"].transpose("scale", "point").values, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), theta)
        np.testing.assert_array_equal(line.get_ydata(), data["T"])


def test_a_part_turned_by_a_moment_finds_the_figure_of_a_part(monkeypatch) -> None:
    # its record has a turn too, as has that of a vibration
    for name in ("part_figure", "vibration_figure"):
        monkeypatch.setattr(plot, name, lambda *_, name=name: name, raising=False)
    beam = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
    assert squama.load(squama.Part(beam, "2 deg bend"), scales=3, points=3).squama.plot() == "part_figure"


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
        ({"name": "K_t", "unit": "N mm"}, 'unit = "N mm": is no unit of K_t, which is in N m^2'),
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
            assert f"{data[name].item():.3g} {unit}" in words
    assert data["end"].item() in text
    assert "thin, rigid scales on hinges, edge law" in text.splitlines()[0]
    assert "<svg" in shown
    for warning in data.attrs["warnings"].splitlines():
        assert f"warning: {warning}" in text
    # a loop's figures are there, its points are not
    cycle = result("cycle_figure").squama.summary()
    assert f"{result('cycle_figure')['zeta_eq'].item():.3g}" in cycle
    assert "torque T" not in cycle
    assert repr(data.squama) == text


@pytest.mark.slow
def test_a_file_that_was_read_knows_it_too(tmp_path) -> None:
    squama.save(result("response_figure"), tmp_path / "a.nc")
    code = (
        f"import squama; print(len(squama.read({str(tmp_path / 'a.nc')!r}).squama.plot().axes), squama.plot.__name__)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.split() == ["4", "squama.plot"]


def panel(kind: str, ax: Axes | None = None) -> Axes:
    figure, given, *_ = PANELS[kind]
    over = {"x": "eta", "y": "mu"} if figure == "map_figure" else {}
    return getattr(plot, kind.partition(" ")[0])(result(figure), *given, ax=ax, **over)


def drawn(ax: Axes) -> list[object]:
    """Return what axes show, in units of the data: lines, bars, and the colours of areas."""
    lines = [np.asarray(line.get_xydata()) for line in ax.lines]
    bars = [part.get_patch_transform().transform(part.get_path().vertices) for part in ax.patches]
    return [*lines, *bars, *(part.get_facecolor() for part in ax.collections)]


@pytest.mark.parametrize("kind", PANELS)
def test_a_panel_goes_into_its_axes_and_nowhere_else(kind) -> None:
    # other tests may have left some open
    before = plt.get_fignums()
    figure = Figure()
    ax, other = figure.subplots(1, 2)
    assert panel(kind, ax) is ax
    assert ax.has_data()
    assert all(re.search(r"\w", words) for words in (ax.get_ylabel(), ax.get_xlabel() or "bars"))
    assert not other.has_data()
    assert (other.get_xlabel(), other.get_ylabel(), other.get_legend()) == ("", "", None)
    # a bar of colours takes its place beside
    assert len(figure.axes) == 2 + (kind in ("plane_load", "tradeoff", "map_slice"))
    assert not figure.legends
    assert plt.get_fignums() == before
    own = panel(kind)
    assert own.figure is not figure
    assert plt.get_fignums() == before


@pytest.mark.parametrize("kind", PANELS)
def test_figures_are_made_of_panels(kind) -> None:
    name, given, place, *_ = PANELS[kind]
    options = {"variable": given[0], "x": "eta", "y": "mu"} if name == "map_figure" else {}
    whole = getattr(plot, name)(result(name), **options).axes[place]
    assert drawn(whole)
    for one, two in zip(drawn(panel(kind)), drawn(whole), strict=True):
        np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("kind", [kind for kind, (*_, up) in PANELS.items() if up])
def test_lines_show_what_the_labels_say(kind) -> None:
    name, _, _, across, up = PANELS[kind]
    data, ax = result(name), panel(kind)
    factors = [
        UNITS[found[1]] if (found := re.search(r"\(([^()]*)\)$", words)) else 1
        for words in (ax.get_xlabel().replace("per pitch)", ")").replace(" )", ")"), ax.get_ylabel())
    ]
    wanted = data[up].values
    shown = [factors[1] * np.asarray(line.get_ydata()) for line in ax.lines]
    places = [factors[0] * np.asarray(line.get_xdata()) for line in ax.lines]
    same = [i for i, y in enumerate(shown) if y.shape == wanted.shape and np.allclose(y, wanted)]
    assert same
    if across:
        assert any(np.allclose(places[i], data[across].values) for i in same)


@pytest.mark.parametrize("kind", PANELS)
def test_a_panel_of_another_kind_of_result_is_refused(kind) -> None:
    # a row is a curve, too
    curve = PANELS[kind][0] in ("row_figure", "response_figure")
    for other in ("shaken_figure", "cycle_figure" if curve else "row_figure"):
        with pytest.raises(squama.InputError, match=r"^this dataset is no result of \S.*; its \.squama\.plot\(\)"):
            getattr(plot, kind.partition(" ")[0])(
                result(other), *PANELS[kind][1], **({"x": "eta"} if "map" in kind else {})
            )


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: plot.curve(result("response_figure"), "end"), 'name = "end": is no number along the points'),
        (lambda: plot.plane_load(result("plane_figure"), "N"), 'name = "N": is no load of this plane; allowed: M, T'),
        (
            lambda: plot.tradeoff(result("front_figure"), "range", "cost"),
            'y = "cost": is not a figure of this front; allowed: ',
        ),
        (
            lambda: plot.tradeoff(result("front_figure"), "range", "RED", by="mu"),
            'by = "mu": is not a figure of this front; allowed: range, RED, lock',
        ),
        (lambda: plot.map_slice(result("map_figure"), "U", x="eta"), 'variable = "U": is not in this sweep; allowed: '),
        (
            lambda: plot.map_slice(result("map_figure"), x="eta"),
            "this slice has the dimensions eta, mu, to be drawn over eta; choose one value of every other",
        ),
    ],
)
def test_a_panel_that_cannot_be_drawn_is_one_line(call, words) -> None:
    with pytest.raises(squama.InputError, match=f"^{re.escape(words)}"):
        call()


def test_the_hinge_stands_beside_a_curve_and_measured_points_lead_the_axes() -> None:
    data = result("response_figure")
    ax = plot.curve(data, "T", hinge=data)
    alone = plot.curve(data, "T")
    assert ax.get_ylim() == alone.get_ylim()
    assert "thin, rigid scales on hinges" in [text.get_text() for text in ax.get_legend().get_texts()]
    points = Measured(np.array([0.0, 1.0, 2.0]), np.array([0.0, 50.0, 90.0]), "test")
    ax = plot.curve(data, "T", measured=points)
    assert 2 < ax.get_xlim()[1] < 1.5 * max(2.0, float(data["Phi_e"]))
    assert "measured" in [text.get_text() for text in ax.get_legend().get_texts()]
    assert plot.curve(data, "f0", measured=points).get_legend() is None
