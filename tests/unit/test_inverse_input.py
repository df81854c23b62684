"""Target files: every mistake one line; the commands squama design and squama pareto."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

import squama
from squama.cli import main
from squama.inverse.targetfile import Context, quantity
from squama.plot import front_figure, inverse_figure
from squama.units import Dimension

BEAM = Path("examples/pla_on_vps.toml").read_text(encoding="utf-8")
GOOD = """start = "beam.toml"
designs = 2
[target]
lock = "120 deg total"
[vary]
scale.length = ["30 mm", "80 mm"]
beam.pitch = ["12 mm", "25 mm"]
"""
FRONT = """start = "beam.toml"
[vary]
scale.length = ["40 mm", "80 mm"]
beam.pitch = ["12 mm", "25 mm"]
[front]
maximise = ["range", "RED"]
population = 16
generations = 4
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(BEAM)
    (tmp_path / "test.csv").write_text("total (deg), T (N mm)\n20, 1\n20, 2\n")
    return tmp_path


def run(text, capsys, *flags, command="design"):
    Path("t.toml").write_text(text)
    status = main([command, "t.toml", *flags])
    return status, capsys.readouterr()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('lock = "120 deg total"', "", "[target]: asks for nothing"),
        ("[target]\nlock", "[targets]\nlock", "targets: unknown key; did you mean target?"),
        ('lock = "120 deg total"', 'lok = "120 deg total"', "target.lok: unknown key; did you mean lock?"),
        ('"120 deg total"', '"120 deg"', 'target.lock = "120 deg": does not say over which length'),
        ('"120 deg total"', "120", "target.lock = 120: has no unit"),
        (
            '"120 deg total"',
            '"-120 deg total"',
            'target.lock = "-120 deg total": must be more than 0; for the other way',
        ),
        ('"120 deg total"', '"5000 deg total"', "half a turn per pitch or more"),
        ('"120 deg total"', '{ value = "120 deg total", weigh = 2 }', "target.lock.weigh: unknown key"),
        (
            '"120 deg total"',
            '{ value = "120 deg total", weight = 0 }',
            "target.lock.weight = 0: must be a number above 0",
        ),
        ('lock = "120 deg total"', "RED = 1.2", "target.RED = 1.2: a part of the work cannot be 1 or more"),
        ('lock = "120 deg total"', "RED = -0.1", "target.RED = -0.1: must be more than 0"),
        ('lock = "120 deg total"', "critical_mu = 20", "target.critical_mu = 20: is out of range"),
        (
            'lock = "120 deg total"',
            'stiffness = "0.5 N m"',
            'target.stiffness = "0.5 N m": is a torque, but a stiffness of a beam is needed',
        ),
        ('lock = "120 deg total"', "stiffness = 0.5", "target.stiffness = 0.5: has no unit"),
        (
            'lock = "120 deg total"',
            'lock = "40 deg total"\nengagement = "50 deg total"',
            "must be larger than target.engagement",
        ),
        (
            'lock = "120 deg total"',
            'lock = "40 deg total"\npoints = [{ twist = "50 deg total", torque = "1 N m" }]',
            "torque at 50 deg total: is at or beyond the lock at 40 deg total",
        ),
        (
            'lock = "120 deg total"',
            'points = [{ twist = "5 rad/m", torque = "1 N m" }, { twist = "5 rad/m", torque = "2 N m" }]',
            "torque at 5 rad/m: is asked twice, 1 N m and 2 N m; keep one",
        ),
        ('lock = "120 deg total"', 'points = [{ twist = "5 rad/m" }]', "target.points[0].torque: is missing"),
        ('lock = "120 deg total"', 'points = [{ torque = "1 N m" }]', "target.points[0].twist: is missing"),
        ('lock = "120 deg total"', 'points = [{ twist = "5 rad/m", torque = "1 mm" }]', 'points[0].torque = "1 mm"'),
        ('lock = "120 deg total"', "points = 5", "target.points = 5: is no list of tables"),
        ('lock = "120 deg total"', 'curve = "test.csv"', "test.csv: points 1 and 2 have one twist and two torques"),
        ('lock = "120 deg total"', 'curve = "nowhere.csv"', "nowhere.csv: no such file"),
        ('lock = "120 deg total"', 'lock = "120 deg total"\nlock_by = "glue"', 'target.lock_by = "glue": is not known'),
        (
            'lock = "120 deg total"',
            'lock = "120 deg total"\naccept = "200 %"',
            'target.accept = "200 %": must be below 1',
        ),
        ('scale.length = ["30 mm", "80 mm"]\nbeam.pitch = ["12 mm", "25 mm"]\n', "", "[vary]: nothing to vary"),
        ('["30 mm", "80 mm"]', '["80 mm", "30 mm"]', 'is reversed; write ["30 mm", "80 mm"]'),
        ('["30 mm", "80 mm"]', "[30, 80]", "vary.scale.length = 30: has no unit"),
        ('["30 mm", "80 mm"]', '["30 deg", "80 mm"]', 'vary.scale.length = "30 deg": is an angle'),
        ('["30 mm", "80 mm"]', '["30 mm", "30 mm"]', "begins where it ends"),
        (
            '["30 mm", "80 mm"]',
            '"30 mm"',
            'vary.scale.length = "30 mm": is no pair of bounds; write e.g. scale.length = [',
        ),
        ('["30 mm", "80 mm"]', '["30 mm", "8e9 mm"]', "vary.scale.length"),
        ("scale.length", "scale.lenght", "vary.scale.lenght: is no dimension of a beam; did you mean scale.length?"),
        ("scale.length", "alpha", "did you mean scale.alpha?"),
        ("beam.pitch", "beam.scales", "vary.beam.scales: cannot be varied on hinges"),
        ('start = "beam.toml"', "", 'start: is missing; write start = "beam.toml"'),
        ('start = "beam.toml"', 'start = "none.toml"', "none.toml: no such file"),
        ('start = "beam.toml"', "start = 5", "start = 5: is no file name"),
        ("designs = 2", "designs = 0", "designs = 0: must be a whole number"),
        ("designs = 2", 'designs = "two"', 'designs = "two": is no plain number'),
        ("designs = 2", 'load = "shear"', 'load = "shear": must be "twisting" or "bending"'),
        ("designs = 2", "margin = 1", "margin = 1: must be at least 1e-9 and below 1"),
        ("designs = 2", "limits = 5", "limits = 5: is not a table"),
        ("[vary]", '[limits]\ngapp = "1 mm"\n[vary]', "limits.gapp: unknown limit; did you mean gap?"),
        ("[vary]", '[limits]\ngap = "1 deg"\n[vary]', 'limits.gap = "1 deg": is an angle'),
        ("[vary]", "[limits]\njoint_law = 1\n[vary]", "limits.joint_law = 1: must be true or false"),
        (
            "[vary]",
            '[limits]\ngap = "40 mm"\n[vary]',
            "limits: no beam within the bounds keeps them all; the nearest breaks gap",
        ),
        ("[vary]", '[tolerance]\nscale.length = "-1 mm"\n[vary]', 'tolerance.scale.length = "-1 mm": is below 0'),
        ("[vary]", '[tolerance]\nscale.lengt = "1 mm"\n[vary]', "tolerance.scale.lengt: is no dimension of a beam"),
        ("[vary]", '[scale]\nlenght = "1 mm"\n[vary]', "scale.lenght: unknown key; did you mean length?"),
        ("[target]", "[target", "t.toml: line 3"),
        ("[vary]", "[friction]\nmu = 0\n[vary]", "passes"),
    ],
)
def test_mistakes_are_one_line_each(folder, capsys, old, new, words):
    assert old in GOOD
    if words == "passes":
        text = GOOD.replace(old, new).replace('lock = "120 deg total"', "RED = 0.3")
        words = "target.RED: needs friction"
    else:
        text = GOOD.replace(old, new, 1)
    status, said = run(text, capsys, "--starts", "16", "-o", "out")
    assert status == 2
    assert words in said.err
    assert said.err.count("\n") == 1
    assert said.err.startswith("squama: error: t.toml: ")
    assert said.out == ""
    assert not (folder / "out").exists()


def test_several_mistakes_are_told_together(folder, capsys):
    text = GOOD.replace('"120 deg total"', '"120 deg"').replace('["30 mm", "80 mm"]', '["80 mm", "30 mm"]')
    status, said = run(text, capsys, "--starts", "3", "--plot", "a.gif", "--designs", "x")
    assert status == 2
    assert said.err.count("\n") == 5
    without_mu = BEAM.replace("mu = 0.25", "# mu")
    Path("beam.toml").write_text(without_mu)
    status, said = run(GOOD, capsys)
    assert "friction.mu: is missing" in said.err


def test_stiffnesses_are_read():
    context = Context(25, "twisting", bare=False)
    for text in ("0.5 N m^2", "0.5 N m2", "0.5 Nm^2", "0.5 N*m^2/rad", "500000 N mm^2", "0.5 N m²", "500 mN m^2"):
        assert quantity("x", text, Dimension.RIGIDITY, context).si == pytest.approx(0.5), text
    assert quantity("x", "at most 2 N m^2", Dimension.RIGIDITY, context).sense == "<="
    assert quantity("x", 0.5, Dimension.RIGIDITY, context._replace(bare=True)).si == 0.5
    for text in ("0.5 N m^3", "0.5 mm^2", "x", "0.5", True, None, "-1 N m^2", 0.5):
        with pytest.raises(squama.InputError, match="N m"):
            quantity("x", text, Dimension.RIGIDITY, context)


def test_the_command_design(folder, capsys):
    flags = ("--starts", "32", "-o", "out", "--plot", "d.png")
    status, said = run(GOOD, capsys, *flags)
    assert status == 0
    assert "t.toml: target reached on hinges (endless, held straight)" in said.out
    assert "; 2 designs\n" in said.out
    assert "  model " in said.out
    assert "thin, rigid scales on hinges" in said.out
    assert "wrote out/design_2.toml" in said.out
    assert (folder / "d.png").stat().st_size > 10_000
    files = sorted(p.name for p in (folder / "out").iterdir())
    assert files == ["design_1.toml", "design_2.toml"]
    for name in files:
        assert main(["twist", f"out/{name}", "--joint", "hinge", "--json"]) == 0
        record = json.loads(capsys.readouterr().out)
        assert math.degrees(record["figures"]["phi_end"]) * 25 == pytest.approx(120, rel=1e-9)
    # nothing is replaced unasked
    status, said = run(GOOD, capsys, *flags)
    assert status == 2
    assert "holds design_1.toml and 1 more already" in said.err
    status, said = run(GOOD, capsys, *flags, "--force", "--designs", "1", "--json")
    assert status == 0
    assert [p.name for p in (folder / "out").iterdir()] == ["design_1.toml"]
    record = json.loads(said.out)
    assert record["met"] is True
    assert record["written"] == ["out/design_1.toml", "d.png"]
    (goal,) = record["designs"][0]["goals"]
    assert goal["reached"] == pytest.approx(120)
    assert goal["effects"]["scale.alpha"] < 0
    assert squama.Beam.from_toml("out/design_1.toml").model_dump() == record["designs"][0]["beam"]


@pytest.mark.slow
def test_what_is_not_reached_is_no_error(folder, capsys):
    status, said = run(GOOD.replace("120 deg", "10 deg"), capsys, "--starts", "64")
    assert status == 0
    assert "target not reached, nearest attainable" in said.out
    assert "not reached: lock: asked 10 deg total, nearest" in said.out
    assert "scale.length at its upper bound 80 mm" in said.out


@pytest.mark.slow
@pytest.mark.usefixtures("unasked")
def test_a_target_with_its_own_beam_and_values_in_place(folder, capsys):
    whole = "\n".join(line for line in BEAM.splitlines() if not line.startswith("#"))
    own = GOOD.replace('start = "beam.toml"\n', "") + whole
    found = [
        json.loads(run(text, capsys, "--starts", "64", "--json", *more)[1].out)
        for text, *more in ((GOOD,), (own,), (GOOD + "[friction]\nmu = 0.1\n",), (GOOD, "--set", "friction.mu=0.1"))
    ]
    assert found[0]["designs"] == found[1]["designs"]
    assert found[2]["designs"] == found[3]["designs"]
    assert found[2]["designs"][0]["beam"]["friction"]["mu"] == 0.1


def test_the_command_pareto(folder, capsys):
    pytest.importorskip("pymoo")
    flags = ("-o", "out", "--pick", "1,3", "--plot", "f.png", "--csv", "f.csv", "--netcdf", "f.nc")
    status, said = run(FRONT, capsys, *flags, command="pareto")
    assert status == 0
    assert said.out.splitlines()[0].split(" ", 2)[2].startswith("designs; range ")
    assert "wrote 2 beam files into out" in said.out
    assert sorted(p.name for p in (folder / "out").iterdir()) == ["design_1.toml", "design_3.toml"]
    front = squama.read("f.nc")
    table = squama.read("f.csv")
    assert table["range"].values == pytest.approx(front["range"].values)
    assert (folder / "f.png").stat().st_size > 10_000
    r = squama.twist(squama.Beam.from_toml("out/design_3.toml"), joint="hinge")
    assert float(r.phi_end - r.phi_e) == pytest.approx(float(front["range"].sel(design=3)), rel=1e-9)
    assert float(r.RED_c) == pytest.approx(float(front.RED.sel(design=3)), rel=1e-9)
    status, said = run(FRONT, capsys, "--json", command="pareto")
    assert json.loads(said.out)["front"]["RED"] == pytest.approx(front.RED.values.tolist())


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"range", "RED"', '"rnage", "RED"', 'front.maximise: "rnage" is not known; did you mean range?'),
        ('"range", "RED"', '"RED", "RED"', "front.maximise: RED is given twice"),
        ('["range", "RED"]', '["RED"]', "[front]: names 1 objectives; give 2 to 5"),
        ('["range", "RED"]', '"RED"', 'front.maximise = "RED": is no list'),
        ('"range", "RED"', '"tangent", "RED"', "front.at: is missing; tangent needs a twist"),
        ("population = 16", "population = 2.5", "front.population = 2.5: is not a whole number"),
        ("population = 16", "populatoin = 16", "front.populatoin: unknown key; did you mean population?"),
        ("[front]\n", "[target]\n", "target.maximise: unknown key"),
        ('["12 mm", "25 mm"]', '["40 mm", "50 mm"]', "front: none of 64 beams within the bounds has all these figures"),
    ],
)
def test_mistakes_in_a_front(folder, capsys, old, new, words):
    pytest.importorskip("pymoo")
    assert old in FRONT
    status, said = run(FRONT.replace(old, new), capsys, "--csv", "f.csv", command="pareto")
    assert status == 2
    assert words in said.err
    assert said.err.startswith("squama: error: t.toml: ")
    assert not (folder / "f.csv").exists()


@pytest.mark.slow
def test_pictures_without_a_lock_and_with_points(folder):
    from squama.inverse.target import read_target

    data = {
        "start": "beam.toml",
        "target": {"points": [{"twist": "20 deg total", "torque": 0.01}], "stiffness": 0.03},
        "vary": {"substrate.thickness": ("10 mm", "20 mm")},
    }
    target = read_target(data)
    figure = inverse_figure(squama.inverse_design(target, starts=32), target)
    words = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    assert "asked" in words
    assert figure.axes[0].get_xlabel() == "Twist of 25 scales (deg)"


def test_a_front_of_two_objectives_is_one_panel():
    pytest.importorskip("pymoo")
    front = squama.pareto(
        {
            "vary": {"scale.length": ("40 mm", "70 mm"), "scale.alpha": ("40 deg", "60 deg")},
            "front": {"maximise": ["range", "RED"], "population": 16, "generations": 3},
        },
        beam=squama.Beam.from_ratios(mu=0.3),
    )
    figure = front_figure(front)
    assert [bool(ax.get_xlabel()) for ax in figure.axes].count(True) >= 1
    assert "larger is better" in figure.axes[0].get_xlabel()
