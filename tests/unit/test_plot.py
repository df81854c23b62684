"""Figures are made for every kind of response, with units on their axes, and saved whole or not at all."""

import functools
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import squama
from squama.plot import response_figure, save_figure
from squama.plot.style import FORMATS, label, prefixed, shades
from squama.symbols import SYMBOLS

BEAM = squama.Beam.from_ratios(youngs_modulus="1.5 MPa", mu=0.25)
RESPONSES = {
    "single": lambda: squama.twist(BEAM, points=40, joint="hinge"),
    "family": lambda: squama.twist(BEAM, mu=[0, 0.3, 2, 7], points=40, joint="hinge"),
    "frictionless": lambda: squama.twist(BEAM, mu=0, points=40, joint="hinge"),
    "static lock": lambda: squama.twist(BEAM, mu=7, points=40, joint="hinge"),
    "no engagement": lambda: squama.twist(BEAM, sense="-", points=40, joint="hinge"),
    "off the tip edge": lambda: squama.twist(BEAM.replace(scale={"alpha": "15 deg"}), points=40, joint="hinge"),
    "range end": lambda: squama.twist(BEAM, to="10 rad/m", points=40, joint="hinge"),
    "range ends before contact": lambda: squama.twist(BEAM, to="1 rad/m", points=40, joint="hinge"),
    "given rates": lambda: squama.twist(BEAM, at=[12.0, 1.0, 30.0, 5.0], joint="hinge"),
    "bending": lambda: squama.bend(BEAM, points=40),
    "bending family": lambda: squama.bend(BEAM, mu=[0, 0.5], points=40),
}


@functools.cache
def response(kind):
    return RESPONSES[kind]()


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("kind", RESPONSES)
def test_four_panels_with_units(kind, tmp_path):
    figure = response_figure(response(kind))
    load, friction, inclination, last = figure.axes
    texts = [ax.get_ylabel() for ax in figure.axes]
    assert "(N m" in texts[0]
    assert "(deg)" in texts[2]
    assert all("(rad/m)" in ax.get_xlabel() for ax in (inclination, last))
    assert "(deg)" in load.child_axes[0].get_xlabel()
    for ax in figure.axes:
        assert ax.has_data() or ax.texts
        assert all(np.isfinite(ax.get_ylim())), ax.get_ylabel()
        assert ax.get_ylim()[1] > ax.get_ylim()[0]
        assert ax.get_xlim()[1] < 1e3
    assert friction.get_ylabel()
    assert save_figure(figure, tmp_path / "f.png").stat().st_size > 10_000


def test_axis_ends_before_the_lock_but_shows_the_curve():
    r = squama.twist(BEAM, mu=0.5, joint="hinge")
    load = response_figure(r).axes[0]
    top = load.get_ylim()[1]
    bare = BEAM.torsional_rigidity * float(r.Phi_end)
    assert 2 * bare < top < 0.2 * float(r.T.max())


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.25, [0, 0.25, 0.5]])
def test_the_hinge_stands_beside_the_compliant_beam_and_does_not_squash_it(mu):
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    thick = squama.twist(beam, mu=mu, to="0.2 rad/pitch")
    hinge = squama.twist(beam, mu=mu, joint="hinge")
    alone, both = response_figure(thick), response_figure(thick, hinge=hinge)
    count = np.size(mu)
    for one, two in zip(alone.axes, both.axes, strict=True):
        assert one.get_ylim() == two.get_ylim()
        assert one.get_xlim() == two.get_xlim()
        assert sum(line.get_linewidth() == 0.7 for line in two.lines) == count
    load, friction = both.axes[:2]
    assert load.get_ylim()[1] < 1e3 * float(hinge["T"].max()), "in mN m; the hinge leaves the axes"
    circles, squares = ([line.get_xdata()[0] for line in load.lines if line.get_marker() == mark] for mark in "os")
    assert circles == pytest.approx(np.atleast_1d(thick.Phi_e))
    assert squares == pytest.approx(np.atleast_1d(hinge.Phi_e))
    # both in one unit
    thin = next(line for line in friction.lines[::-1] if line.get_linewidth() == 0.7)
    f = (hinge if count == 1 else hinge.isel(mu=-1))["f"].values
    factor = {"(N)": 1, "(mN)": 1e3}[friction.get_ylabel().split()[-1]]
    assert thin.get_ydata() == pytest.approx(factor * f)
    texts = [text.get_text() for text in both.legends[0].get_texts()]
    assert {"thick, elastic scales on compliant joints", "thin, rigid scales on hinges", "lock on hinges"} <= {*texts}
    both.canvas.draw()
    box, width = both.legends[0].get_window_extent(), both.bbox.width
    assert box.x0 >= 0
    assert box.x1 <= width


def test_measured_points_lie_inside():
    points = SimpleNamespace(rate=np.array([1.0, 30.0]), load=np.array([0.1, 500.0]))
    load = response_figure(squama.twist(BEAM, points=40, joint="hinge"), points).axes[0]
    assert load.get_xlim()[1] > 30
    assert load.get_ylim()[1] > 500
    drawn = [line for line in load.lines if line.get_marker() == "." and len(line.get_xdata()) == 2]
    assert list(drawn[0].get_ydata()) == [0.1, 500.0]


def test_engagement_and_lock_are_marked_where_they_are():
    r = squama.twist(BEAM, mu=0.5, points=40, joint="hinge")
    load = response_figure(r).axes[0]
    circle = next(line for line in load.lines if line.get_marker() == "o")
    assert circle.get_xdata()[0] == pytest.approx(float(r.Phi_e))
    assert circle.get_ydata()[0] == pytest.approx(BEAM.torsional_rigidity * float(r.Phi_e))
    locks = [line.get_xdata()[0] for line in load.lines if line.get_linestyle() == "-."]
    assert locks == [pytest.approx(float(r.Phi_end))]


def test_title_names_the_end():
    assert "static lock" in response_figure(response("static lock"))._suptitle.get_text()
    text = response_figure(response("no engagement"))._suptitle.get_text()
    assert "no engagement; side edge" in text


@pytest.mark.parametrize("kind", RESPONSES)
def test_letters_stand_clear_of_the_curves(kind):
    figure = response_figure(response(kind))
    for ax in figure.axes:
        low, high = ax.get_ylim()
        for line in ax.lines:
            x, y = np.asarray(line.get_xydata(), float).T
            near = y[(x < 0.14 * ax.get_xlim()[1]) & np.isfinite(y)]
            assert near.size == 0 or near.max() <= low + 0.85 * (high - low), ax.get_ylabel()


def test_marks_on_the_axis_are_whole_and_a_force_of_zero_has_an_axis():
    figure = response_figure(squama.twist(BEAM, mu=[0, 0.5], points=40, joint="hinge"))
    ends = [line for line in figure.axes[1].lines if line.get_marker() == "x"]
    assert [(line.get_ydata()[0], line.get_clip_on()) for line in ends] == [(0.0, False)]
    # without friction it slides, with much it is locked at once: no friction force in either
    assert response_figure(squama.twist(BEAM, mu=[0, 7], points=40, joint="hinge")).axes[1].get_ylim() == (0, 1)


def test_a_beam_that_nothing_touches_has_no_end_in_its_picture():
    beam = BEAM.replace(scale={"length": "8 mm"})
    never, touching = (response_figure(squama.twist(b, sense="-", points=40, joint="hinge")) for b in (beam, BEAM))
    for figure, marks in ((never, 0), (touching, 1)):
        assert sum(line.get_marker() == "x" for line in figure.axes[0].lines) == marks
        assert ("end, no lock" in [t.get_text() for t in figure.legends[0].get_texts()]) == bool(marks)
    assert "touches at 554 deg" in touching._suptitle.get_text().replace("\n", " ")
    assert all(ax.get_xlabel()[:1].isupper() for ax in (touching.axes[0].child_axes[0], touching.axes[2]))


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("ending", FORMATS)
def test_the_same_figure_gives_the_same_bytes(ending, tmp_path):
    files = [tmp_path / f"{name}{ending}" for name in "ab"]
    for file in files:
        save_figure(response_figure(squama.twist(BEAM, points=20, joint="hinge")), file)
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_figure_shows_itself_in_a_notebook():
    figure = response_figure(squama.twist(BEAM, points=20, joint="hinge"))
    made = figure._repr_png_()
    width = int.from_bytes(made[16:20], "big")
    assert made.startswith(b"\x89PNG")
    assert width == round(200 * figure.get_figwidth())


@pytest.fixture(scope="module")
def figure():
    return response_figure(squama.twist(BEAM, points=20, joint="hinge"))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("f.jpg", 'f.jpg: the ending ".jpg" is not known; write a name that ends in .png, .svg or .pdf'),
        ("f", "f: has no ending; write a name that ends in .png, .svg or .pdf"),
        ("none/f.png", "does not exist; make it first"),
        ("folder.png", "is a folder"),
    ],
)
def test_a_place_that_cannot_be_written(name, words, figure, tmp_path):
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(squama.InputError) as error:
        save_figure(figure, tmp_path / name)
    assert words in str(error.value)
    assert [p.name for p in tmp_path.iterdir()] == ["folder.png"]


def test_labels_have_the_unit_of_the_table():
    for name, symbol in SYMBOLS.items():
        if symbol.unit not in ("", "1"):
            assert f"({symbol.unit.replace('N m^2', 'N m$^2$')})" in label(name), name
    assert label("theta", "deg").endswith("(deg)")


@pytest.mark.parametrize(
    ("largest", "factor", "unit"),
    [(25.0, 1.0, "(N m)"), (0.02, 1e3, "(N mm)"), (4.4e6, 1.0, "(N m)"), (3e-7, 1e3, "(N mm)"), (0.0, 1.0, "(N m)")],
)
def test_prefix_of_an_axis(largest, factor, unit):
    got, text = prefixed("T", largest)
    assert got == factor
    assert text.endswith(unit)


@pytest.mark.parametrize("n", [2, 4, 8])
def test_colours_stay_apart_in_grey(n):
    grey = [0.299 * r + 0.587 * g + 0.114 * b for r, g, b in shades(n)]
    assert np.all(np.diff(grey) > 0.5 / n)
    assert max(grey) < 0.8


@pytest.mark.slow
def test_no_display_no_pyplot_and_settings_untouched():
    code = (
        "import sys, matplotlib as mpl, squama; before = mpl.rcParams.copy(); from squama.plot import response_figure;"
        "response_figure(squama.twist(squama.Beam.from_ratios(), mu=0.3, points=20)).canvas.draw();"
        "assert 'matplotlib.pyplot' not in sys.modules; assert mpl.rcParams.copy() == before"
    )
    subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=True)
