"""Parts in a file: [support], [[load]], [along] and tables of scales say what flags and arguments say."""

import json
import logging
from pathlib import Path

import numpy as np
import pytest

import squama
from squama import plot
from squama.cli import main
from squama.errors import InputError

EXAMPLE = Path("examples/cantilever.toml")
TEXT = EXAMPLE.read_text(encoding="utf-8")
BEAM = squama.Beam.from_toml_text(TEXT).replace(scales=5)
"""Its beam, with fewer scales."""
GRADES = {"scale.theta0": ["23 deg", "17 deg"], "scale.width": ["24 mm", "20 mm"]}
TABLE = "scale.theta0 (deg);scale.width (mm)\n23;24\n21.5;23\n20;22\n18.5;21\n17;20\n"


def written(folder, sections="", name="part.toml", **tables):
    """Write a file of the beam with sections, and tables beside it; return its path."""
    for table, text in tables.items():
        (folder / f"{table}.csv").write_text(text, encoding="utf-8")
    (folder / name).write_text(f"{BEAM.to_toml()}\n{sections}", encoding="utf-8")
    return str(folder / name)


def answered(capsys, *given):
    """Return what the command says as JSON."""
    assert main(["load", *given, "--points", "5", "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def same(one, other, rtol=1e-12):
    """Hold two answers of the command against each other."""
    assert (one["loads"], one["support"]) == (other["loads"], other["support"])
    for part in ("curve", "root", "each", "sections"):
        for name, values in one[part].items():
            mine, others = (np.array(v, dtype=float) for v in (values, other[part][name]))
            np.testing.assert_allclose(mine, others, rtol=rtol, atol=1e-15, err_msg=name)


# ---- the same by every door -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sections", "flags"),
    [
        ('[[load]]\ntext = "0.1 N up at tip"', ["--load", "0.1 N up at tip"]),
        pytest.param(
            '[support]\nkind = "simple"\nspan = "80 mm"\n[[load]]\ntext = "15 mm down at middle"',
            ["--load", "15 mm down at middle", "--support", "simple, span 80 mm"],
            marks=pytest.mark.slow,
        ),
        (
            '[support]\nspan = "80 mm"\nkind = "simple"\n[load]\ntext = "1.5 N down at 50 mm"\n'
            '[along]\nscale.theta0 = ["23 deg", "17 deg"]\n"scale.width" = ["24 mm", "20 mm"]',
            ["--load=1.5 N down at 50 mm", "--support=simple, span 80 mm"]
            + [f"--along={name}={', '.join(values)}" for name, values in GRADES.items()],
        ),
        (
            '[support]\nkind = "clamped"\n[[load]]\ntext = "50 mN up at tip"\n[[load]]\ntext = "1 N tendon at 5 mm"',
            ["--load", "50 mN up at tip", "--load", "1 N tendon at 5 mm"],
        ),
    ],
)
def test_the_file_says_what_flags_say(sections, flags, tmp_path, capsys):
    by_file = answered(capsys, written(tmp_path, sections))
    assert max(by_file["each"]["N"][-1][:-1]) > 0
    same(by_file, answered(capsys, written(tmp_path), *flags))


def test_a_table_is_the_grading_that_it_holds(tmp_path, capsys):
    flags = ["--load", "0.1 N up at tip"]
    path = written(tmp_path, scales=TABLE)
    graded = answered(capsys, path, *flags, *(f"--along={k}={', '.join(v)}" for k, v in GRADES.items()))
    assert np.degrees(graded["each"]["theta"][0]) == pytest.approx([23, 21.5, 20, 18.5, 17])
    # tolerance: angles between the ends are rounded, and a contact that has just closed shows it
    same(graded, answered(capsys, path, *flags, "--along", str(tmp_path / "scales.csv")), 1e-7)
    in_file = written(tmp_path, '[[load]]\ntext = "0.1 N up at tip"\n[along]\ntable = "scales.csv"', "other.toml")
    same(graded, answered(capsys, in_file), 1e-7)
    r = squama.load(BEAM, "0.1 N up at tip", along=tmp_path / "scales.csv", points=5)
    np.testing.assert_allclose(r.F, graded["curve"]["F"], rtol=1e-7)


def test_a_part_is_what_its_beam_and_arguments_are():
    part = squama.Part.from_toml(EXAMPLE, overrides={"beam": {"scales": 5}, "friction": {"mu": 0.1}})
    assert part.beam == BEAM.replace(friction={"mu": 0.1})
    one = squama.load(part, points=5)
    grades = {"scale.theta0": ["24 deg", "16 deg"]}
    for other in (
        squama.load(BEAM, "0.1 N up at tip", along=grades, points=5, mu=0.1),
        squama.load(squama.Part(BEAM, ["0.1 N up at tip"], along=grades), mu=0.1, points=5),
    ):
        np.testing.assert_array_equal(one.F, other.F)
        np.testing.assert_array_equal(one.N, other.N)
    # an argument takes the place of what the part says
    given = squama.load(part, "0.05 N up at tip", along={}, points=5)
    plain = squama.load(part.beam, "0.05 N up at tip", points=5)
    np.testing.assert_array_equal(given.F, plain.F)
    assert "graded" not in given.attrs


def test_flags_take_the_place_of_the_file_and_say_so(tmp_path, capsys):
    path = written(tmp_path, '[support]\nkind = "clamped"\n[[load]]\ntext = "0.1 N up at tip"')
    assert main(["load", path, "--load", "0.05 N up at tip", "--points", "4"]) == 0
    said = capsys.readouterr().out
    assert "0.05 N" in said
    assert said.count("in place of") == 1
    assert f"--load in place of {path}: [[load]]" in said
    same(
        answered(capsys, path, "--load", "10 mm down at middle", "--support", "simple"),
        answered(capsys, written(tmp_path), "--load", "10 mm down at middle", "--support", "simple"),
    )


# ---- the beam alone, and back to a file -----------------------------------------------------------------------------


def test_other_commands_answer_for_the_beam_alone(tmp_path, capsys, caplog):
    plain, part = written(tmp_path, name="plain.toml"), written(tmp_path, TEXT[TEXT.index("[support]") :])
    said = []
    for path in (plain, part):
        assert main(["twist", path, "--ends", "endless", "--points", "3", "--json"]) == 0
        said.append(capsys.readouterr())
    records = [json.loads(one.out) | {"file": ""} for one in said]
    assert records[0] == records[1]
    assert "beam alone" not in said[0].err
    (line,) = [line for line in said[1].err.splitlines() if "beam alone" in line]
    assert line.startswith(f"squama: {part}: the beam alone is read, without [support], [[load]], [along]")
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        assert squama.Part.from_toml(part).beam == squama.Beam.from_toml(plain)
    assert not caplog.records


def test_a_part_is_written_and_read_back(tmp_path):
    (tmp_path / "scales.csv").write_text(TABLE)
    for along in (GRADES, tmp_path / "scales.csv", None):
        part = squama.Part(BEAM, "0.1 N up at tip; 20 mN right at 60 mm", "clamped", along)
        again = squama.Part.from_toml_text(part.to_toml(tmp_path / "again.toml"))
        assert squama.Part.from_toml(tmp_path / "again.toml") == again
        assert again.beam == BEAM
        assert list(again.load) == ["0.1 N up at tip", "20 mN right at 60 mm"]
        one, other = (squama.load(p, points=4) for p in (part, again))
        np.testing.assert_array_equal(one.F, other.F)
        # a result holds its part
        kept = squama.Part.from_toml_text(one.attrs["beam"])
        assert kept == again
        assert one.squama.beam == BEAM


def test_the_picture_has_scales_of_their_own_length(tmp_path):
    r = squama.load(BEAM, "30 mN up at tip", along={"scale.length": ["70 mm", "40 mm"]}, points=4)
    ax = plot.shape(r)
    lines = [line for line in ax.lines if len(line.get_xdata()) == 15]
    x, y = (np.reshape(lines[0].get_data()[i], (5, 3)) for i in (0, 1))
    # seen from the side: the bar is straight there
    across = np.cos(np.radians(50)) * np.cos(np.radians(20)), np.sin(np.radians(20))
    seen = np.hypot(x[:, 1] - x[:, 0], y[:, 1] - y[:, 0])
    np.testing.assert_allclose(seen, np.linspace(70, 40, 5) * np.hypot(*across), rtol=1e-9)


# ---- refused --------------------------------------------------------------------------------------------------------

LOADED = '[[load]]\ntext = "0.1 N up at tip"\n'


@pytest.mark.parametrize(
    ("sections", "words"),
    [
        ("", "--load: is missing; give it"),
        ("[support]\n", "support.kind: is missing; write kind = "),
        ('[support]\nspan = "80 mm"', "support.kind: is missing"),
        (LOADED + '[support]\nkind = "glued"', '[support] = "glued": must be one of "clamped", "gripped", "simple"'),
        (LOADED + '[support]\nkind = "simple"\nspan = "3 m"', "must be one pitch to 100 mm long"),
        (LOADED + '[support]\nkind = "clamped"\nspan = "80 mm"', '[support] = "clamped, span 80 mm": must be'),
        ('[support]\nkind = "simple"\nspann = "80 mm"', "support.spann: unknown key; did you mean span?"),
        ("[support]\nkind = 3", "support.kind = 3: is no text"),
        ('[suport]\nkind = "clamped"', "[suport]: unknown table; did you mean [support]?"),
        ("[[load]]\n", "load.text: is missing"),
        ('[[load]]\nsize = "0.1 N"', "load.size: unknown key"),
        ('[[load]]\ntext = "0.2 N"', '[[load]] = "0.2 N": is no load'),
        ('[[load]]\ntext = "1 N up at 1 m"', "[[load]] = "),
        (LOADED + '[[load]]\ntext = "5 mm up at tip"', "stands alone"),
        (LOADED + "[along]\nscale.theta0 = [10, 20]", "along: scale.theta0 = 10: has no unit"),
        (LOADED + '[along]\nscale.theta0 = "10 deg"', "along: scale.theta0: is no list"),
        (LOADED + '[along]\nscale.theta0 = ["9 deg"]', "[along]: scale.theta0: has 1, but needs 2 values, or 5"),
        (LOADED + '[along]\nscale.theta0 = ["9 deg", "9 mm"]', "is a length, but an angle is needed"),
        (
            LOADED + '[along]\nscale.theta0 = ["9 deg", "95 deg"]',
            'along: scale.theta0 = "95 deg": is out of range (0 to 90 deg',
        ),
        (
            LOADED + '[along]\nscale.embedded = ["5 mm", "50 mm"]',
            "[along]: scale 5: scale.embedded = 50 mm: the tab goes",
        ),
        (LOADED + '[along]\nbeam.pitch = ["9 mm", "8 mm"]', '"beam.pitch": must be one of scale.length'),
        pytest.param(
            LOADED + '[along]\nscale.theta0 = ["10 deg", "40 deg"]',
            "[along]: scales touch before anything is loaded",
            marks=pytest.mark.slow,
        ),
        (LOADED + "[[along]]\n", "along = "),
        (LOADED + "[along]\ntable = 3", "along.table = 3: must be the name of a file"),
        (LOADED + '[along]\ntable = "none.csv"', "none.csv: no such file; write a CSV with a row for each scale"),
        (LOADED + '[along]\ntable = "a.csv"\nscale.theta0 = ["9 deg", "9 deg"]', "stands beside other keys"),
    ],
)
def test_a_bad_file_is_one_line(sections, words, tmp_path, capsys):
    assert main(["load", written(tmp_path, sections)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line
    assert "part.toml" in line or sections == ""


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (TABLE[:-6], "has 4 rows, but the part has 5 scales; give a row for each scale"),
        (TABLE + "16;20\n", "has 6 rows"),
        (TABLE.splitlines()[0], "has 0 rows"),
        ("23\n21\n20\n19\n18\n", 'line 1: column "23": is not known; allowed: scale.length (mm), '),
        (TABLE.replace("theta0", "theta"), 'column "scale.theta (deg)": is not known'),
        (TABLE.replace("scale.width (mm)", "scale.theta0 (deg)"), 'column "scale.theta0 (deg)": is there twice'),
        (TABLE.replace(" (deg)", ""), 'column "scale.theta0": has no unit; write scale.theta0 (deg)'),
        (TABLE.replace("(deg)", "(mm)"), "is a length, but an angle is needed"),
        (TABLE.replace("21.5", "x"), 'line 3: scale.theta0 = "x": is not a number'),
        (TABLE.replace("21.5", "21,5"), "has a decimal comma"),
        (TABLE.replace("21.5", "inf"), "is not a finite number"),
        (TABLE.replace("21.5;", ""), "line 3: has 1 cell, the header has 2"),
        (TABLE.replace("21.5", "99"), 'line 3: scale.theta0 = "99.0 deg": is out of range'),
        pytest.param(
            TABLE.replace("17;", "40;"),
            "scales touch before anything is loaded; let them differ less",
            marks=pytest.mark.slow,
        ),
        ("", "is empty"),
        (TABLE + "20;20\n" * 200_000, "is larger than 1,000,000 bytes"),
    ],
)
def test_a_bad_table_is_one_line(table, words, tmp_path, capsys):
    path = written(tmp_path, LOADED, scales=table)
    assert main(["load", path, "--along", str(tmp_path / "scales.csv")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line
    assert "--along" in line


def test_a_table_stands_alone(tmp_path, capsys):
    path = written(tmp_path, LOADED, scales=TABLE)
    given = ["--along", str(tmp_path / "scales.csv"), "--along", "scale.theta0=9 deg, 8 deg"]
    assert main(["load", path, *given]) == 2
    assert "stands beside others; give a table alone" in capsys.readouterr().err


def test_all_mistakes_of_a_file_are_told_at_once():
    text = TEXT.replace('"50 deg"', "50").replace("kind =", "kin =").replace("text =", "tex =")
    with pytest.raises(InputError) as caught:
        squama.Part.from_toml_text(text, source="part.toml")
    assert [line.split(":")[1].split()[0] for line in str(caught.value).splitlines()] == [
        "scale.alpha",
        "support.kin",
        "load.tex",
    ]
    with pytest.raises(InputError, match=r"^part\.toml: line 3: "):
        squama.Part.from_toml_text("[scale]\nlength = 3\na\n", source="part.toml")


def test_grading_by_which_scales_meet_at_rest_is_refused_before_joints_by_elements(monkeypatch):
    from squama.curves import compliant

    monkeypatch.setattr(compliant, "joint_of", None)
    with pytest.raises(InputError, match="scales touch before anything is loaded"):
        squama.load(BEAM, "0.1 N up at tip", along={"scale.theta0": ["10 deg", "40 deg"]})


def test_the_summary_says_that_all_of_the_load_is_on(capsys):
    """The strain at which it is on is located, so its share is not 1 exactly."""
    assert main(["load", "examples/pla_on_vps.toml", "--scales", "6", "--load", "2 N up at tip"]) == 0
    said = capsys.readouterr().out
    assert "2 N up at tip; all of it is on" in said
    assert "range end" not in said
