"""The table of designs: cells unchanged, results beside them, bad rows named and left out."""

import csv
import math

import numpy as np
import pytest

import squama
from squama.arrays import designs_table
from squama.errors import InputError

HEADER = "eta,beta,lambda,alpha_deg,theta0_deg,mu"
GOOD = "3,1.25,0.45,45,10,0.5"


def _solve(tmp_path, text, **kwargs):
    path = tmp_path / "d.csv"
    path.write_text(text)
    return designs_table.solve(path, **kwargs)


def _written(solved, tmp_path):
    with designs_table.write(solved, tmp_path / "o.csv").open(newline="") as file:
        return list(csv.DictReader(file, delimiter=solved.delimiter))


@pytest.mark.parametrize("law", ["edge", "plate"])
@pytest.mark.parametrize("sense", ["+", "-"])
@pytest.mark.parametrize("contacts", ["tip", "all"])
def test_same_as_one_by_one(law, sense, contacts, tmp_path):
    text = "\n".join([HEADER, GOOD, "3,1.25,0.45,45,10,0", "1.5,2,.8,30,15,0", "2,.6,.8,45,20,.5"])
    rows = _written(_solve(tmp_path, text, law=law, sense=sense, contacts=contacts), tmp_path)
    assert len(rows) == 4
    for row in rows:
        one = squama.ends(
            eta=float(row["eta"]),
            beta=float(row["beta"]),
            lam=float(row["lambda"]),
            alpha=math.radians(float(row["alpha_deg"])),
            theta0=math.radians(float(row["theta0_deg"])),
            mu=float(row["mu"]),
            law=law,
            sense=sense,
            contacts=contacts,
        )
        assert float(row["phi_e_rad"]) == pytest.approx(float(one.phi_e), rel=1e-13)
        assert float(row["phi_end_rad"]) == pytest.approx(float(one.phi_end), rel=1e-12)
        assert float(row["theta_end_deg"]) == pytest.approx(math.degrees(float(one.theta_end)), rel=1e-12)
        assert row["end"] == one.end.item()
        assert row["neighbour"] == str(int(one.neighbour))
        assert row["sense"] == one.sense.item() == sense
        assert row.get("other_contact", "") == (one.other.item() if contacts == "all" else "")


def test_cells_and_order_are_kept(tmp_path):
    text = 'note,mu,theta0_deg,alpha_deg,lambda,beta,eta,id\n"a, ""b""", 0.50 ,1e1,45.0,.45,1.25,+3,007\n'
    rows = _written(_solve(tmp_path, text), tmp_path)
    assert list(rows[0])[:8] == ["note", "mu", "theta0_deg", "alpha_deg", "lambda", "beta", "eta", "id"]
    assert list(rows[0])[8:] == ["phi_e_rad", "end", "theta_end_deg", "phi_end_rad", "neighbour", "sense"]
    assert list(rows[0].values())[:8] == ['a, "b"', " 0.50 ", "1e1", "45.0", ".45", "1.25", "+3", "007"]
    assert rows[0]["end"] == "frictional lock"
    # tolerance: the figure has six digits
    assert float(rows[0]["phi_e_rad"]) == pytest.approx(0.0481936, rel=1e-5)


def test_a_beam_that_never_engages(tmp_path):
    row = _written(_solve(tmp_path, f"{HEADER}\n.8,.4,.45,60,5,.25\n"), tmp_path)[0]
    assert (row["phi_e_rad"], row["end"], row["neighbour"]) == ("inf", "no engagement", "0")


def test_an_output_can_be_computed_again(tmp_path):
    first = _solve(tmp_path, f"{HEADER},id\n{GOOD},7\n")
    path = designs_table.write(first, tmp_path / "again.csv")
    second = designs_table.solve(path)
    assert (second.header, second.rows) == (first.header, first.rows)


def test_semicolons(tmp_path):
    text = f"{HEADER},note\n{GOOD},x\n".replace(",", ";").replace("x", "a,b")
    solved = _solve(tmp_path, text)
    assert _written(solved, tmp_path)[0]["note"] == "a,b"


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("x,1.25,0.45,45,10,0.5", [['eta = "x"', "not a number"]]),
        (",1.25,0.45,45,10,0.5", [['eta = ""', "is empty"]]),
        ("0,1.25,0.45,45,10,0.5", [["eta = 0", "allowed: more than 0, up to 100; write e.g. 3"]]),
        ("1e6,1e9,0.45,45,10,0.5", [["eta = 1e6", "up to 100; write"], ["beta = 1e9", "up to 100; write e.g. 1.25"]]),
        ("-3,1.25,0.45,45,10,0.5", [["eta = -3", "more than 0"]]),
        ("nan,1.25,0.45,45,10,0.5", [["eta = nan", "finite"]]),
        ("inf,1.25,0.45,45,10,0.5", [["eta = inf", "finite"]]),
        ("3,0,0.45,45,10,0.5", [["beta = 0", "more than 0"]]),
        ("3,1.25,-1,45,10,0.5", [["lambda = -1", "more than 0", "write e.g. 0.45"]]),
        ("3,1.25,0.45,90,10,0.5", [["alpha_deg = 90", "0 to 90 deg, exclusive; write e.g. 45"]]),
        ("3,1.25,0.45,0,10,0.5", [["alpha_deg = 0", "0 to 90 deg"]]),
        ("3,1.25,0.45,45 deg,10,0.5", [['alpha_deg = "45 deg"', "not a number"]]),
        ("3,1.25,0.45,45,100,0.5", [["theta0_deg = 100", "0 to 90 deg, exclusive; write e.g. 10"]]),
        ("3,1.25,0.45,45,10,-0.1", [["mu = -0.1", "0 to 10"]]),
        ("3,1.25,0.45,45,10,11", [["mu = 11", "0 to 10; write e.g. 0.25"]]),
        ("3,1.25,0.45,45,10", [["has 5 cells, the header has 6"]]),
        ("3,1.25,0.45,45,10,0.5,9", [["has 7 cells"]]),
        ('"3,5",1.25,0.45,45,10,0.5', [["eta", "decimal comma", "3.5"]]),
        ("0,x,0.45,45,10,0.5", [["eta = 0"], ['beta = "x"']]),
    ],
)
def test_bad_rows(row, words, tmp_path):
    solved = _solve(tmp_path, f"{HEADER}\n{GOOD}\n\n{row}\n{GOOD}\n")
    assert solved.bad == 1
    assert [r[:6] for r in solved.rows] == [GOOD.split(",")] * 2
    assert solved.ends == {"frictional lock": 2}
    assert len(solved.problems) == len(words)
    for line, expected in zip(map(str, solved.problems), words, strict=True):
        assert line.startswith(f"{tmp_path / 'd.csv'}: line 4: ")
        for word in expected:
            assert word in line


def test_bad_rows_are_named_in_their_order(tmp_path):
    rows = ["0,1.25,0.45,45,10,0.5", "3", GOOD, "3,1.25,0.45,45,10,x"]
    solved = _solve(tmp_path, "\n".join([HEADER, *rows]))
    assert [p.source.split(": ")[1] for p in solved.problems] == ["line 2", "line 3", "line 5"]
    assert solved.bad == 3


def test_lines_are_those_of_the_file(tmp_path):
    solved = _solve(tmp_path, f'# note\n{HEADER},id\n{GOOD},"two\nlines"\n\n{GOOD.replace("45", "x")},1\n')
    assert [p.source.split(": ")[1] for p in solved.problems] == ["line 6", "line 6"]
    assert solved.rows[0][6] == "two\nlines"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"{GOOD}\n{GOOD}\n", [f'line 1: "{GOOD}" are numbers where the header must stand; write above']),
        ("a,b\n1,2\n", [f'"a,b" has none of the columns that are needed; write a header like: {HEADER}']),
        (f"{HEADER},end\n{GOOD},x\n", ["the column end has the name of a result; rename it"]),
        (f"{HEADER},sense,id\n{GOOD},x,1\n", ["the column sense has the name of a result; rename it"]),
        (f"{HEADER.replace(',mu', '')}\n3,1,1,45,10\n", ["column mu is missing"]),
        (f"{HEADER.replace('lambda', 'lamda')}\n{GOOD}\n", ["lambda is missing; rename lamda to lambda"]),
        (f"{HEADER.replace('alpha_deg', 'alpha')}\n{GOOD}\n", ["rename alpha to alpha_deg"]),
        (f"{HEADER},mu\n{GOOD},1\n", ["column mu is given twice"]),
        (f"{HEADER}\n", ["no rows"]),
        ("", ["is empty"]),
    ],
)
def test_bad_tables(text, words, tmp_path):
    with pytest.raises(InputError) as caught:
        _solve(tmp_path, text)
    lines = str(caught.value).splitlines()
    assert len(lines) == len(words)
    for line, word in zip(lines, words, strict=True):
        assert word in line
        assert line.startswith(f"{tmp_path / 'd.csv'}: ")


def test_many(tmp_path):
    rng = np.random.default_rng(3)
    low, high = [1.5, 0.5, 0.2, 10, 2, 0], [8, 2, 1, 80, 20, 1]
    table = rng.uniform(low, high, (3000, 6)).astype(object)
    table[::10, 5] = "bad"
    solved = _solve(tmp_path, "\n".join([HEADER, *(",".join(map(str, row)) for row in table)]))
    assert (len(solved.rows), solved.bad, len(solved.problems)) == (2700, 300, 300)
    assert sum(solved.ends.values()) == 2700
