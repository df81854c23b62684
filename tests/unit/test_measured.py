"""Measured points: names, units and abscissas that are understood, and what is said about the rest."""

import math

import pytest

from squama.errors import InputError
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
    assert found.rate == pytest.approx([2 * rate, -0.4 * rate], rel=1e-14)
    assert found.load == pytest.approx([3 * load, 0], rel=1e-14)
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
    assert found.rate == pytest.approx([2 * rate], rel=1e-14)
    assert found.load == pytest.approx([3 * load], rel=1e-14)


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
        ("Phi (rad/m),T (N m)\n1,a\n,2\n", [["line 2", 'T (N m) = "a"', "not a number"], ["line 3", "is empty"]]),
        ("# x\nPhi (rad/m),T (N m)\n1,nan\ninf,2\n", [["line 3", "nan", "finite"], ["line 4", "inf", "finite"]]),
        ('Phi (rad/m);T (N m)\n"1,5";2\n', [["line 2", "decimal comma", "write 1.5"]]),
        ("Phi (rad/m),T (N m)\n1\n1,2,3\n", [["line 2", "has 1 cell,", "2"], ["line 3", "has 3 cells"]]),
        ("Phi (rad/m),T (N m)\n1,1_0\n", [["line 2", "1_0"]]),
        ("Phi (rad/m),T (N m)\n", [["no rows"]]),
        ("# only\n", [["comments only"]]),
        ("", [["is empty"]]),
        (" \n\n", [["is empty"]]),
        (b"\x89PNG\x00", [["binary"]]),
        (b"Phi (\xb0/m),T (N m)\n1,2\n", [["not UTF-8", "line 1"]]),
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
