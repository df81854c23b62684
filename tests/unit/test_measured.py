"""Measured points: names, units and abscissas that are understood, and what is said about the rest."""

import json
import math
from pathlib import Path

import pytest

from squama.errors import InputError, TableWarning
from squama.io import measured, tabular

DEG = math.pi / 180
BEAM = {"pitch": 0.02, "scales": 25}


def _read(tmp_path, text, load="twisting"):
    path = tmp_path / "test 1.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return measured.read(path, load=load, **BEAM)


@pytest.mark.parametrize(
    ("header", "rate", "load"),
    [
        ("Phi (rad/m), T (N m)", 1, 1),
        ("Phi (deg/mm), T (N mm)", DEG * 1e3, 1e-3),
        ("Phi [1/m], T [kN m]", 1, 1e3),
        ("twist rate (deg/m),torque (N*cm)", DEG, 1e-2),
        ("Twist rate (rad per cm),Torque (Nm)", 1e2, 1),
        ("phi (rad), T (N m)", 1 / 0.02, 1),
        ("phi (deg/pitch), T (N m)", DEG / 0.02, 1),
        ("phi (rad/m), T (N m)", 1, 1),
        ("Phi (deg/pitch), T (N m)", DEG / 0.02, 1),
        ("twist per pitch (deg), T (N m)", DEG / 0.02, 1),
        ("total (deg), T (N m)", DEG / 0.5, 1),
        ("total twist (\u00b0), T (N\u00b7m)", DEG / 0.5, 1),
    ],
)
def test_twisting(header, rate, load, tmp_path):
    found = _read(tmp_path, f"{header}\n2,3\n-4e-1, 0\n")
    assert found.rate == pytest.approx([2 * rate, -0.4 * rate], rel=1e-13)
    assert found.load == pytest.approx([3 * load, 0], rel=1e-13)
    assert found.label == "test 1"


@pytest.mark.parametrize(
    ("header", "rate", "load"),
    [
        ("kappa (1/mm), M (N mm)", 1e3, 1e-3),
        ("curvature (deg/m), moment (N m)", DEG, 1),
        ("psi (deg), bending moment (N m)", DEG / 0.02, 1),
        ("total bend (deg), M (N m)", DEG / 0.5, 1),
    ],
)
def test_bending(header, rate, load, tmp_path):
    found = _read(tmp_path, f"{header}\n2,3\n", "bending")
    assert found.rate == pytest.approx([2 * rate], rel=1e-13)
    assert found.load == pytest.approx([3 * load], rel=1e-13)


@pytest.mark.parametrize(
    "text",
    [
        "# a comment\n#\n\nPhi (rad/m),T (N m)\n2,3\n\n",
        "T (N m);note;Phi (rad/m)\n3;x, y;2\n",
        "Phi (rad/m)\tT (N m)\r\n2\t3\r\n",
        '\ufeff"Phi (rad/m)","T (N m)"\n"2"," 3 "\n',
        "Phi (rad/m),phi (rad),T (N m)\n2,9,3\n",
        "Phi (rad/m),T (N m)\r2,3\r",
    ],
)
def test_spreadsheets_of_all_kinds(text, tmp_path):
    found = _read(tmp_path, text)
    assert (found.rate.tolist(), found.load.tolist()) == ([2.0], [3.0])


def test_a_saved_response_is_a_measurement_too(tmp_path):
    import squama

    r = squama.twist(squama.Beam.from_ratios(), mu=0.2, points=9, joint="hinge")
    found = measured.read(squama.save(r, tmp_path / "a.csv"), **BEAM)
    assert found.rate.tolist() == r.Phi.values.tolist()
    assert found.load.tolist() == r["T"].values.tolist()


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("1,2\n3,4\n", [["line 1", '"1,2" are numbers where the header', "Phi (rad/m), T (N m)"]]),
        ("time,force\n1,2\n", [["line 1", '"time,force" has none of the columns', "like: Phi (rad/m), T (N m)"]]),
        ("a (m),T (N m)\n3,4\n", [["line 1", "no column of a twist", '"a (m), T (N m)"']]),
        ("Phi,T (N m)\n1,2\n", [["line 1", 'column "Phi": has no unit', "Phi (rad/m)"]]),
        ("Phi (),T\n1,2\n", [['"Phi ()": has no unit'], ['"T": has no unit']]),
        ("Phi (deg),T (N m)\n1,2\n", [['"Phi (deg)"', "over which length", '"Phi (deg/mm)"', '"total (deg)"']]),
        ("Phi (mm),T (N m)\n1,2\n", [['"Phi (mm)": mm is no unit of a twist']]),
        ("Phi (rad/m),T (N)\n1,2\n", [['"T (N)": N is no unit of a torque']]),
        ("Phi (elephants),T (N m)\n1,2\n", [["elephants is no unit"]]),
        ("Phi (rad/m),T (N m),T (N mm)\n1,2,3\n", [["line 1", '"T" is given twice']]),
        ("Phi (rad/m),T (N m)\n1,a\n,2\n", [["line 2", 'T (N m) = "a"', "not a number"]]),
        ("# x\nPhi (rad/m),T (N m)\n1,nan\ninf,2\n", [["line 4", "inf", "finite"]]),
        ('Phi (rad/m);T (N m)\n"1,5";2.5\n', [["line 2", "decimal comma", "write 1.5"]]),
        (
            "Winkel 1 (deg);Winkel 2 (deg);T (N m)\n1;2;3\n",
            [["line 1", "several columns may be a twist rate", '"2=total']],
        ),
        ("Phi (rad/m),T (N m)\n1\n1,2,3\n", [["line 3", "has 3 cells"]]),
        ("kappa (deg/m),T (N m)\n1,2\n", [["line 1", "no column of a twist rate"]]),
        ("Winkel (deg),bending moment (N m)\n1,2\n", [["line 1", "no column of a torque"]]),
        ("Phi (rad/m),T (N m)\n1,1_0\n", [["line 2", "1_0"]]),
        ("Phi (rad/m),T (N m)\n", [["no rows"]]),
        ("# only\n", [["comments only"]]),
        ("", [["is empty"]]),
        (" \n\n", [["is empty"]]),
        (b"\x89PNG\x00", [["binary"]]),
        ("a,b\n1,2\n".encode("utf-16"), [["line 1", "none of the columns"]]),
        (b"\xff\xfeP\x00h", [["begins as UTF-16 text but is none"]]),
        (b"Phi (\xb0/m)\x01,T (N m)\n1,2\n", [["binary"]]),
        ('Phi (rad/m),T (N m)\n1,2\n1,"2\n', [["line 3", "quotes"]]),
    ],
)
def test_mistakes(text, lines, tmp_path):
    with pytest.raises(InputError) as caught:
        _read(tmp_path, text)
    said = str(caught.value).splitlines()
    assert len(said) == len(lines)
    for line, words in zip(said, lines, strict=True):
        assert line.startswith(f"{tmp_path / 'test 1.csv'}: ")
        for word in words:
            assert word in line


def test_no_such_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        measured.read(tmp_path / "none.csv", **BEAM)


@pytest.mark.parametrize(
    ("cell", "remedy"),
    [("", "leave the row out"), ("nan", "leave the row out"), ("x", "write e.g. 3"), ("1,5", "write 1.5")],
)
def test_a_gap_is_not_filled_by_an_example(cell, remedy):
    with pytest.raises(InputError) as caught:
        tabular.number(cell, "3", gap="leave the row out")
    assert caught.value.problems[0].remedy == remedy


# ---- tables as laboratories write them --------------------------------------------------------------------

LAB = "Winkel;Drehmoment\n\u00b0;Nmm\n0,0;0\n90;1,5\n-180,0;-2,5e3\n"
RATES, LOADS = [0.0, math.pi, -2 * math.pi], [0.0, 1.5e-3, -2.5]
TOTAL = '"Winkel (\u00b0)" as the twist of the whole beam'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (LAB, ["with the units of line 2", "with decimal commas", TOTAL, "as the torque"]),
        (LAB.replace(";", "\t"), ["decimal commas"]),
        (LAB.replace(",", "."), ["units of line 2"]),
        (LAB.encode("utf-8-sig"), ["decimal commas"]),
        (LAB.encode("utf-16"), ["decimal commas"]),
        (b"\xfe\xff" + LAB.encode("utf-16-be"), ["decimal commas"]),
        (LAB.encode("latin-1"), ["in latin-1"]),
        ("Pr\u00fcfung 12;A\nDatum;1.2.2024\n\n" + LAB, ["without 2 lines above the header", "units of line 5"]),
        ("% Probe 3\n# 1,2;3\n" + LAB.replace("90", "// Pause\n90"), ["units of line 4"]),
        (LAB.replace("\n\u00b0;Nmm", "\n[\u00b0];(N-mm)"), ["units of line 2"]),
        (
            LAB.replace("\n\u00b0;Nmm", "").replace("Winkel;Drehmoment", "Winkel [Grad];Moment (Nmm)"),
            ["decimal commas"],
        ),
        ("turns (rev);moment, measured (mNm)\n0;0\n,25;1,5\n-0,5;-2,5e3\n", ["twist of the whole beam"]),
        ("Zeit;Winkel;M1\ns;U;Nmm\n0;0;0\n1;,25;1,5\n2;-0,5;-2500\n", ["units of line 2"]),
        ("a;b\n(deg);(N mm)\n0;0\n90;1.5\n-180;-2500\n", ['"a (deg)" as the twist', '"b (N mm)" as the torque']),
    ],
)
def test_tables_of_laboratories(text, said, tmp_path):
    with pytest.warns(TableWarning) as caught:
        found = _read(tmp_path, text)
    assert found.rate == pytest.approx(RATES, rel=1e-13)
    assert found.load == pytest.approx(LOADS, rel=1e-13)
    (line,) = [str(w.message) for w in caught]
    assert "\n" not in line
    assert line.startswith(f"{tmp_path / 'test 1.csv'} is read ")
    assert all(words in line for words in said), line


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("Weg;x;y\n1;0;0\n2;90;1.5\n3;-180;-2500\n", {"columns": "x=total (deg), y=T (N mm)"}),
        ("1;0;0\n2;90;1.5\n3;-180;-2500\n", {"columns": {"2": "total (deg)", "3": "T (N mm)"}}),
        ("x (deg);T (N mm);Mz (N mm)\n0;9;0\n90;9;1.5\n-180;9;-2500\n", {"columns": "1=total,Mz=T"}),
        ("x;y\n0;0\n90;1,5\n-180;-2500\n", {"columns": "x=total (deg), y=T (N mm)", "decimal": ","}),
        ('total (deg),T (N mm)\n0,0\n90,"1,5"\n-180,-2500\n', {"decimal": ","}),
    ],
)
def test_what_is_said_is_not_guessed(text, given, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(text)
    found = measured.read(path, **BEAM, **given)
    assert found.rate == pytest.approx(RATES, rel=1e-13)
    assert found.load == pytest.approx(LOADS, rel=1e-13)
    assert found.lines.tolist() == [i + text[0].isalpha() for i in (1, 2, 3)]


@pytest.mark.parametrize(
    ("text", "given", "words"),
    [
        (LAB, {"decimal": "."}, 'line 3: Winkel (\u00b0) = "0,0": has a decimal comma; write 0.0'),
        ("total (deg);T (N m)\n1.5;2\n", {"decimal": ","}, "has a point, but decimals are set off by commas here"),
        (LAB, {"decimal": ";"}, 'decimal = ";": must be "." or ","'),
        (
            LAB,
            {"columns": "Weg=total"},
            'columns: no column is called "Weg" among "Winkel (\u00b0), Drehm',
        ),
        ("a;a\n1;2\n", {"columns": "a=T (N m)"}, 'several columns are called "a"'),
        (LAB, {"columns": "3=T (N m)"}, "numbers from 1 to 2"),
        (LAB, {"columns": "total (deg)"}, "does not name columns"),
        (LAB, {"columns": "1=total (m), 2=T"}, "m is no unit of a twist or curvature"),
        ("a;b\n1;2\n", {"columns": "1=total, 2=T (N m)"}, 'column "total": has no unit'),
    ],
)
def test_mistakes_in_what_is_said(text, given, words, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        measured.read(path, **BEAM, **given)
    assert words in str(caught.value).splitlines()[0]


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_commands_and_targets_read_them_alike_and_say_what_is_guessed(tmp_path, capsys, monkeypatch):
    import squama
    from squama.cli import main
    from squama.inverse.target import read_target

    monkeypatch.chdir(tmp_path)
    beam = squama.Beam.from_ratios(youngs_modulus="2 MPa", mu=0.3).replace(hold="bend, lateral bend")
    Path("beam.toml").write_text(beam.to_toml())
    r = squama.twist(beam, points=60, to="0.2 rad/pitch", joint="hinge")
    rows = [
        f"{math.degrees(p) * beam.pitches:.9g};{1e3 * t:.9g}" for p, t in zip(r.phi.values, r["T"].values, strict=True)
    ]
    plain = "total (deg);T (N mm)\n" + "\n".join(rows) + "\n"
    lab = "Winkel;Moment\n\u00b0;Nmm\n" + "\n".join(rows).replace(".", ",") + "\n"
    Path("plain.csv").write_text(plain)
    Path("lab.csv").write_bytes(lab.encode("latin-1"))
    said = {}
    for name, more in (("plain", []), ("lab", []), ("lab", ["--decimal", ",", "--columns", "1=total, 2=T"])):
        assert main(["fit", f"{name}.csv", "beam.toml", "--joint", "hinge", "--json", *more]) == 0
        out = capsys.readouterr()
        said[name, len(more)] = json.loads(out.out)["parameters"]["mu"]["estimate"], out.err
    assert len({estimate for estimate, _ in said.values()}) == 1
    assert said["plain", 0][1] == ""
    assert said["lab", 0][1].startswith(
        "squama: warning: lab.csv is read in latin-1, with the units of line 2, with decimal"
    )
    assert said["lab", 0][1].count("\n") == 1
    assert (
        said["lab", 4][1] == "squama: warning: lab.csv is read in latin-1, with the units of line 2; if that is "
        "wrong, set decimal and columns\n"
    )
    assert main(["twist", "beam.toml", "--joint", "hinge", "--data", "lab.csv", "--plot", "a.svg"]) == 0
    assert "is read in latin-1" in capsys.readouterr().err
    assert main(["twist", "beam.toml", "--data", "lab.csv", "--columns", "9=T", "--plot", "b.svg"]) == 2
    assert '--columns: no column is called "9"' in capsys.readouterr().err
    target = {"target": {"curve": "lab.csv"}, "vary": {"scale": {"theta0": ("5 deg", "20 deg")}}}
    with pytest.warns(TableWarning):
        goals = read_target(target, beam=beam).goals
    assert goals[-1].asked == pytest.approx(float(r["T"].max()), rel=1e-7)
    assert goals[-1].want.at.per_pitch(beam.pitch, beam.pitches) == pytest.approx(float(r.phi.max()), rel=1e-7)
    with pytest.warns(TableWarning):
        fit = squama.fit(squama.read_measured("lab.csv", beam), beam, joint="hinge")
    assert fit.values["mu"] == pytest.approx(said["plain", 0][0], rel=1e-6)
