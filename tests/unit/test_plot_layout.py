"""Figures as they are laid out: nothing is cut off, legends stand beside the data, every line has a name."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure

import squama
from squama.inverse.target import read_target
from squama.io.measured import Measured
from squama.paper import maps, twisting2020
from squama.paper import parameters as par
from squama.plot import (
    cycle_figure,
    inverse_figure,
    map_figure,
    part_figure,
    path_figure,
    plane_figure,
    red_figure,
    response_figure,
    row_figure,
    shaken_figure,
    solids_figure,
    uncertainty_figure,
    vibration_figure,
)
from squama.plot.maps import contours
from squama.plot.plan import Plain
from squama.plot.plane import FLUSH
from squama.plot.response import LOCK, WITHOUT_ENDS
from squama.plot.style import BARE, headline
from squama.plot.sweep import axis_values
from squama.study.parameters import PARAMETERS

ROOT = Path(__file__).parents[2]
BEAM = squama.Beam.from_toml(ROOT / "examples/pla_on_vps.toml").replace(scales=None)
SKIN = squama.Beam.from_toml(ROOT / "examples/stiff_skin.toml").replace(scales=None)
POINTS = Measured(np.array([0.0, 3.0, 5.0]), np.array([0.0, 0.4, 2.2]), "test")


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    over = {"mu": np.linspace(0, 3, 13), "alpha": np.radians(np.linspace(5, 75, 15))}
    return squama.sweep(BEAM, over, joint="hinge", out=tmp_path_factory.mktemp("map") / "map.zarr").load()


def row(joint):
    return row_figure(squama.row(BEAM, scales=8, to="0.1 rad/pitch", points=20, joint=joint))


def design():
    target = read_target(ROOT / "examples/lock_at_120.toml")
    return inverse_figure(squama.inverse_design(target, starts=256), target)


def solids():
    pytest.importorskip("manifold3d")
    with TemporaryDirectory() as folder:
        return solids_figure(squama.export(BEAM, f"{folder}/out", scales=4, formats=["stl"]))


def tolerances():
    found = squama.uncertainty(
        BEAM, vary={"scale.alpha": "+- 1 deg"}, joint="hinge", before="240 deg total", samples=4096
    )
    return uncertainty_figure(found)


def compliant_map(folder):
    over = {"mu": (0, 0.6, 5), "alpha": ("40 deg", "60 deg", 9)}
    found = squama.sweep(BEAM, over, at="0.1 rad/pitch", out=folder / "compliant.zarr")
    return map_figure(found, "stiffness_ratio", x="alpha", y="mu")


def compliant_tolerances():
    return uncertainty_figure(squama.uncertainty(BEAM, {"scale.alpha": "+- 1 deg"}, at="0.1 rad/pitch", samples=4096))


FIGURES = {
    "map": lambda data: map_figure(data, x="alpha", y="mu"),
    "map of torques": lambda data: map_figure(data, "torque", x="alpha", y="mu"),
    "map of ends": lambda data: map_figure(data, "end", x="alpha", y="mu"),
    "envelopes": lambda data: map_figure(data, "lock", x="alpha", y="mu", lines=[0.0, 0.5]),
    "line": lambda data: map_figure(data.sel(mu=0.5), x="alpha"),
    "row": lambda _: row(None),
    "row on hinges": lambda _: row("hinge"),
    "part": lambda _: part_figure(squama.load(SKIN, "40 mm down at middle", support="simple", scales=9, points=12)),
    "part from above": lambda _: part_figure(squama.load(SKIN, "40 mm left at tip", scales=9, points=12, back=True)),
    "measured": lambda _: response_figure(squama.twist(BEAM, joint="hinge"), POINTS),
    "family": lambda _: response_figure(
        squama.twist(BEAM, mu=[0, 0.5], to="0.1 rad/pitch"), POINTS, squama.twist(BEAM, mu=[0, 0.5], joint="hinge")
    ),
    "cycle": lambda _: cycle_figure(squama.cycle(BEAM, "0.1 rad/pitch")),
    "vibration": lambda _: vibration_figure(squama.vibrate(BEAM, release="0.1 rad/pitch", rotor=1e-4)),
    "shaken": lambda _: shaken_figure(
        squama.shake(BEAM, [3.0, 3.6, 4.2], static="0.02 rad/pitch", rotor=1e-4, damping=0.05)
    ),
    "tolerances": lambda _: tolerances(),
    "tolerances on compliant joints": lambda _: compliant_tolerances(),
    "designs": lambda _: design(),
    "solids": lambda _: solids(),
    "fig7b": lambda _: red_figure(
        maps.red_map(par.main(), "alpha", np.radians(np.linspace(1, 75, 23)), np.linspace(0, 6, 25))
    ),
}
ONE_MODEL = (
    "row",
    "row on hinges",
    "measured",
    "family",
    "cycle",
    "vibration",
    "shaken",
    "tolerances",
    "designs",
    "map",
)


def whole(figure):
    """Draw a figure and hold it to its frame: texts inside, legends beside what they tell of."""
    figure.canvas.draw()
    box, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
    assert box.x0 > -0.01
    assert box.y0 > -0.01
    assert box.x1 < width + 0.01
    assert box.y1 < height + 0.01
    title = figure._suptitle.get_window_extent() if figure._suptitle else None
    for legend in figure.legends:
        frame = legend.get_window_extent()
        assert not any(frame.overlaps(ax.get_window_extent()) for ax in figure.axes)
        assert title is None or not frame.overlaps(title)
    for ax in figure.axes:
        if (legend := ax.get_legend()) is None:
            continue
        frame = legend.get_window_extent()
        for line in ax.lines:
            places = line.get_transform().transform(np.asarray(line.get_xydata(), float))
            inside = frame.contains
            seen = [p for p in places if np.isfinite(p).all() and ax.bbox.contains(*p)]
            assert not any(inside(*p) for p in seen), line.get_label()


def test_a_map_takes_dimensions_in_any_order(sweep):
    drawn = [map_figure(data, "end", x="alpha", y="mu") for data in (sweep, sweep.transpose(..., "alpha", "mu"))]
    assert drawn[0]._repr_png_() == drawn[1]._repr_png_()


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("name", FIGURES)
def test_nothing_is_cut_off_and_legends_are_beside_the_data(name, sweep):
    figure = FIGURES[name](sweep)
    whole(figure)
    if name in ONE_MODEL:
        words = figure._suptitle.get_text()
        assert "on hinges" in words or "on compliant joints" in words


def test_a_map_on_compliant_joints_is_whole(tmp_path):
    whole(compliant_map(tmp_path))


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", ["fig4", "fig5a", "fig6a", "bending"])
def test_the_papers_figures_are_whole(name, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(twisting2020, "save_figure", lambda figure, path: drawn.append(figure) or path)
    twisting2020.write([name], tmp_path / "out")
    whole(drawn[0])


def test_axes_follow_the_measured_points():
    r = squama.twist(BEAM, joint="hinge")
    figure = response_figure(r, POINTS)
    load, friction, inclination, last = figure.axes
    assert load.get_xlim()[1] == pytest.approx(1.3 * 5)
    assert 2.2 < load.get_ylim()[1] < 1.5 * 2.2
    # the other panels show what lies within, not the pole at the lock
    here = r["Phi"].values <= 6.5
    newton = {"(N)": 1, "(mN)": 1e3, "(kN)": 1e-3}[friction.get_ylabel().split()[-1]]
    for ax, values in ((friction, newton * r["f"]), (inclination, np.degrees(r["theta"])), (last, r["RED"])):
        seen = float(values.values[here].max())
        assert seen < ax.get_ylim()[1] < 1.3 * seen
    words = [t.get_text() for t in figure.legends[0].get_texts()]
    assert "lock" not in words
    assert "measured" in words
    # a model far below the points does not hide them
    soft = response_figure(squama.twist(BEAM, to="0.1 rad/pitch"), POINTS).axes[0]
    assert soft.get_ylim()[1] > 2.2


def test_a_unit_is_not_torn_apart_by_the_end_of_a_line():
    for letters in range(60, 110):
        figure = Figure(figsize=(7.2, 2))
        headline(figure, "x" * letters + " 1.5 N m and more")
        assert "N\nm" not in figure._suptitle.get_text()


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("scale.thickness", "Scale thickness $t_s$ (mm)"),
        ("joint.stiffness", r"Joint $K_\theta$ of one scale (N m)"),
        ("scale.poisson_ratio", r"Scale poisson ratio $\nu_s$"),
        ("mu", r"Coefficient of friction $\mu$"),
    ],
)
def test_symbols_of_an_axis_are_set_as_formulas(name, label):
    part = xr.Dataset(coords={name: (name, [0.0, 1.0], PARAMETERS[name].symbol.attrs)})
    assert axis_values(part, name)[1] == label


def test_twists_of_a_row_are_in_degrees_of_the_whole_beam():
    r = squama.row(BEAM, scales=8, to="0.1 rad/pitch", points=20, joint="hinge")
    left, right = row_figure(r).axes
    assert right.get_xlabel() == "Twist over 8 scales (deg)"
    far = np.degrees(0.8)
    assert right.lines[0].get_xdata()[-1] == pytest.approx(far, rel=1e-6)
    marked = next(line for line in right.lines if line.get_label() == "engagement")
    assert marked.get_xdata()[0] == pytest.approx(np.degrees(8 * float(r.phi_e)), rel=1e-9)
    texts = [text.get_text() for text in left.get_legend().get_texts()]
    assert f"{far:.3g}" in texts


def test_every_mark_of_a_path_and_of_a_plane_has_a_name():
    way = "bend 0.1 rad/pitch; twist 0.15 rad/pitch"
    figures = (
        path_figure(squama.bend_twist(BEAM, way, joint="hinge")),
        plane_figure(squama.bend_twist_map(BEAM, way, joint="hinge", points=9)),
    )
    path, plane = ([text.get_text() for text in figure.legends[0].get_texts()] for figure in figures)
    assert {"event on the path", FLUSH} <= {*path}
    assert FLUSH in plane


def test_a_line_of_equal_inclination_does_not_follow_the_engagement():
    way = "bend 0.1 rad/pitch; twist 0.15 rad/pitch"
    made = squama.bend_twist_map(SKIN.replace(friction={"mu": 0.25}), way, joint="hinge", points=9)
    (lines,) = (child for child in plane_figure(made).axes[0].get_children() if isinstance(child, QuadContourSet))
    # theta0 is 20 deg
    assert lines.levels.min() == 30


def test_a_lock_and_the_endless_beam_have_dashes_of_their_own():
    assert len({str(look["linestyle"]) for look in (LOCK, WITHOUT_ENDS, BARE)}) == 3


def test_small_values_of_a_logarithmic_axis_have_no_exponent():
    figure = Figure(figsize=(2.4, 3.2))
    ax = figure.subplots()
    ax.set(yscale="log", ylim=(0.45, 5.5))
    ax.yaxis.set_minor_formatter(Plain(minor_thresholds=(1.5, 0.5)))
    FigureCanvasAgg(figure).draw()
    texts = [tick.label1.get_text() for tick in ax.yaxis.get_minor_ticks()]
    assert "0.6" in texts
    assert not [text for text in texts if "e" in text]


@pytest.mark.slow
def test_every_line_of_a_row_and_of_designs_has_a_name():
    texts = [t.get_text() for ax in row("hinge").axes for t in ax.get_legend().get_texts()]
    assert texts.count("endless beam") == 2
    assert {"row of 8 scales", "engagement"} <= {*texts}
    asked = [t.get_text() for t in design().axes[0].get_legend().get_texts()]
    assert {"lock of a design", "asked: lock 120 deg total"} <= {*asked}


def test_contours_do_not_run_across_a_jump():
    from matplotlib.figure import Figure

    x, y = np.linspace(0, 1, 21), np.linspace(0, 1, 21)
    right = np.broadcast_to(x > 0.5, (21, 21))
    values = np.where(right, 10.0 + y[:, None], y[:, None])
    for groups, expected in (([right, ~right], set()), ([right | ~right], {2.0, 5.0})):
        ax = Figure().subplots()
        ax.set(xlim=(0, 1), ylim=(0, 1))
        contours(ax, (x, y, values), groups, {"levels": [0, 0.5, 2, 5, 10.5, 12]})
        lines = [c for c in ax.collections if not c.filled]
        drawn = {float(level) for c in lines for level, path in zip(c.levels, c.get_paths(), strict=True) if len(path)}
        assert drawn == {0.5, 10.5} | expected
        # what jumps is cut at the border between the groups
        assert all((c.get_clip_path() is not None) == (len(groups) > 1) for c in lines)
        numbers = [text.get_text() for c in lines for text in c.labelTexts]
        assert {"0.5", "10.5"} <= {*numbers}
        assert all(text.get_path_effects() for c in lines for text in c.labelTexts), "read on dark grounds"


@pytest.mark.slow
def test_solids_fit_a_page_and_their_colours_are_named():
    figure = solids()
    assert figure.get_figheight() < 8
    words = [t.get_text() for t in figure.legends[0].get_texts()]
    assert words[:2] == ["substrate", "scale"]
    assert any("blade" in word for word in words)
