"""Tables of tests as they come from machines, loggers and spreadsheets: each is read, or refused in one line."""

import io
import math
import warnings
import zipfile

import pytest

from squama.errors import InputError, TableWarning
from squama.io import laboratory, measured, workbook

BEAM = {"pitch": 0.02, "scales": 25}
DEG = math.pi / 180 / 0.5
GAP = "without 1 row (line 3) that has no value"
GROUPED = "total (deg);T (N mm)\n0;0\n60;22\n120;{};60;700\n0;-3\n".replace("{};", "{}\n")
LOOP = [(0, 0), (60, 22), (120, 1110.5), (60, 700), (0, -3)]
"""Twist of the whole beam (deg) and torque (N mm)."""
SEMI = "0;0\n60;22\n120;1110,5\n60;700\n0;-3\n"
POINT = SEMI.replace(",", ".")
COMMA = POINT.replace(";", ",")


def _read(tmp_path, text, **given):
    path = tmp_path / "test.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = measured.read(path, **BEAM, **given)
    assert len(said) <= 1
    assert all(w.category is TableWarning and "\n" not in str(w.message) for w in said)
    return found, " ".join(str(w.message) for w in said)


def _holds(found, points=LOOP):
    twist, torque = zip(*points, strict=True)
    assert found.rate == pytest.approx([a * DEG for a in twist], rel=1e-13)
    assert found.load == pytest.approx([m * 1e-3 for m in torque], rel=1e-13)


def _timed(rows, times=1):
    return "".join(f"{i};{row}\n" * times for i, row in enumerate(rows.split()))


READ = {
    "plain": ("total (deg), T (N mm)\n" + COMMA, ""),
    "excel's first line": ("sep=;\nWinkel (deg);Drehmoment (Nmm)\n" + SEMI, "with decimal commas"),
    "excel's first line, quoted, with a mark": (
        '\ufeff"sep=\t"\nAngle (deg)\tTorque (Nmm)\n' + POINT.replace(";", "\t"),
        "",
    ),
    "byte order mark": ("\ufefftotal (deg);T (N mm)\n" + POINT, ""),
    "utf-16 with its mark": (("Winkel (\u00b0);Moment (N\u00b7mm)\n" + SEMI).encode("utf-16"), "with decimal commas"),
    "utf-16 without a mark": (("total (deg);T (N mm)\r\n" + POINT).encode("utf-16-le"), "in utf-16-le"),
    "utf-16 the other way": (("total (deg);T (N mm)\r\n" + POINT).encode("utf-16-be"), "in utf-16-be"),
    "latin-1": (("Winkel (\u00b0);Moment (Nmm);Pr\u00fcfung\n" + SEMI).encode("latin-1"), "in latin-1"),
    "tabs": ("total (deg)\tT (N mm)\r\n" + POINT.replace(";", "\t").replace("\n", "\r\n"), ""),
    "several spaces": ("  Angle (deg)   Torque (N mm)\n" + POINT.replace(";", "     "), ""),
    "spaces, each column right": (
        "Angle[deg] Torque[Nmm]\n   0    0.0\n  60   22.0\n 120 1110.5\n  60  700.0\n   0   -3.0\n",
        "",
    ),
    "one space and a decimal comma": ("Winkel/deg Moment/Nmm\n" + SEMI.replace(";", " "), "with decimal commas"),
    "spaces, units below": ("Angle   Torque\ndeg     N mm\n" + POINT.replace(";", "   "), "with the units of line 2"),
    "bars": ("Angle (deg) | Torque (N mm)\n" + POINT.replace(";", " | "), '"Angle (deg)" as the twist'),
    "a temperature called T": (
        "T (degC);Angle (deg);Torque (N mm)\n" + "".join(f"20;{row}\n" for row in POINT.split()),
        '"Angle (deg)" as the twist',
    ),
    "old Mac's ends of lines": (("total (deg);T (N mm)\n" + POINT).replace("\n", "\r"), ""),
    "thousands, English": (GROUPED.format("1,110.5"), "with commas between thousands"),
    "thousands, German": (GROUPED.format("1.110,5"), "with points between thousands"),
    "thousands, French": (GROUPED.format("1\u202f110,5"), "with spaces between thousands"),
    "thousands, Swiss": (GROUPED.format("1'110.5"), "with apostrophes between thousands"),
    "a minus sign of typesetters": ("total (deg);T (N mm)\n" + POINT.replace("-", "\u2212"), ""),
    "preamble": (
        "Sample: vinyl, 3\nDate: 2024-02-01\nRange: 5 Nm\n\nAngle (deg);Torque (N mm)\n" + POINT,
        "without 3 lines above",
    ),
    "preamble with cells and numbers": (
        "Sample;vinyl 3\nLength;0,5;m\nSpeed;1;deg/s\nAngle;Torque\ndeg;Nmm\n" + SEMI,
        "without 3 lines above",
    ),
    "preamble that names a quantity": (
        "Torque;calibrated\nOperator;A\nAngle (deg);Torque (N mm)\n" + POINT,
        "without 2 lines above",
    ),
    "row of units, quoted": ("'Angle','Torque'\n'deg','N mm'\n".replace("'", '"') + COMMA, "with the units of line 2"),
    "units only": ("deg;N mm\n" + POINT, '"(deg)" as the twist of the whole beam'),
    "in Grad": ("Winkel in Grad;Drehmoment in Nmm\n" + SEMI, '"Winkel in Grad" as the twist of the whole beam'),
    "Torque Nmm": ("Angle deg;Torque Nmm\n" + POINT, '"Angle deg" as the twist of the whole beam'),
    "Drehmoment_Nmm": ("Verdrehung_deg;Drehmoment_Nmm\n" + SEMI, '"Drehmoment_Nmm" as the torque'),
    "M [Nmm]": ("phi [\u00b0];M [Nmm]\n".replace("phi", "Torsionswinkel") + SEMI, '"M [Nmm]" as the torque'),
    "angle/deg": ("angle/deg,torque/N mm\n" + COMMA, '"angle/deg" as the twist'),
    "T, N mm": ("Twist, deg;T, N\u00b7mm\n" + POINT, '"Twist, deg" as the twist'),
    "French": ("temps (s);rotation (deg);couple (N.mm)\n" + _timed(SEMI), '"couple (N.mm)" as the torque'),
    "angle in turns": (
        "Drehwinkel (U);Moment (mNm)\n"
        + SEMI.replace("60;", f"{1 / 6},;")
        .replace(".", ",")
        .replace(",;", ";")
        .replace("120;", f"{1 / 3};".replace(".", ",")),
        "with decimal commas",
    ),
    "braces": ("Angle {deg};Torque {N mm}\n" + POINT, ""),
    "set and measured angle": (
        "Angle set (deg);Angle (deg);Torque (N mm)\n" + _timed(POINT),
        '"Angle (deg)" as the twist',
    ),
    "names in two lines": ('"Angle\n(deg)";"Torque\n(N mm)"\n' + POINT, '"Angle (deg)" as the twist'),
    "empty cells": (
        "total (deg);T (N mm)\n0;0\n;5\n60;22\n120;1110.5\n100;\n60;700\n0;-3\n",
        "without 2 rows (lines 3, 6) that have no value",
    ),
    "NaN": ("total (deg),T (N mm)\n0,0\nNaN,nan\n" + COMMA[4:], GAP),
    "#N/A": ("total (deg),T (N mm)\n0,0\n#N/A,#N/A\n" + COMMA[4:], GAP),
    "a dash": ("total (deg);T (N mm)\n0;0\n60;-\n" + POINT[4:], GAP),
    "#NV of a German Excel": ("Winkel (deg);Moment (Nmm)\n0;0\n60;#NV\n" + SEMI[4:], GAP),
    "cells cut off behind the last one": ("total (deg);T (N mm);remark\n" + POINT.replace("22", "22;slow"), ""),
    "columns of nothing": ("total (deg);T (N mm);;\n" + POINT.replace("\n", ";;\n"), ""),
    "rows twice": (
        "t (s);total (deg);T (N mm)\n" + _timed(POINT, 2),
        "without 5 rows (lines 3, 5, 7, 9, 11) that repeat",
    ),
    "comments between": ("# test\ntotal (deg);T (N mm)\n% pause\n" + POINT.replace("120", "// on\n120"), ""),
    "a blank line between two rows": ("total (deg);T (N mm)\n" + POINT.replace("120", "\n120"), ""),
    "double spaced": (("total (deg);T (N mm)\n" + POINT).replace("\n", "\n\n"), ""),
    "scientific": ("total (deg);T (N m)\n0;0\n6.0e1;2.2E-2\n1.2E+02;1.1105e+00\n60;0.7\n0;-3e-3\n", ""),
}


@pytest.mark.parametrize(("text", "said"), READ.values(), ids=READ)
def test_it_is_read(text, said, tmp_path):
    found, line = _read(tmp_path, text)
    _holds(found)
    assert found.names is None
    assert said in line, line


@pytest.mark.parametrize(
    ("text", "given"),
    [
        (SEMI, {"columns": "1=total (deg), 2=T (N mm)"}),
        ("Sample 3;vinyl;x\n" + SEMI, {"columns": "1=total (deg), 2=T (N mm)"}),
        ("a b\n" + POINT.replace(";", " "), {"columns": {"a": "total (deg)", "b": "T (N mm)"}}),
        (
            "Winkel;Moment\n" + SEMI.replace("1110,5", "1.110,5"),
            {"columns": "Winkel=total (deg), Moment=T (N mm)", "decimal": ","},
        ),
    ],
)
def test_columns_that_are_told(text, given, tmp_path):
    _holds(_read(tmp_path, text, **given)[0])


@pytest.mark.parametrize(
    ("whole", "torques"),
    [
        ("900 950 1,000 1,050", [900, 950, 1000, 1050]),
        ("900 950 1.000 1.050", [900, 950, 1000, 1050]),
        ("0,000 0,900 1,000 1,050", [0, 0.9, 1, 1.05]),
        ("0.5 0.9 1.000 1.050", [0.5, 0.9, 1, 1.05]),
        ("12,5 1.000 1.050 990", [12.5, 1000, 1050, 990]),
        ("12.5 1,000 1,050 990", [12.5, 1000, 1050, 990]),
        ("1,234,567 2 3 4", [1234567, 2, 3, 4]),
        ("0 1,234 2,345 3,456", [0, 1.234, 2.345, 3.456]),
    ],
)
def test_a_mark_before_three_digits(whole, torques, tmp_path):
    rows = "".join(f"{10 * i};{cell}\n" for i, cell in enumerate(whole.split()))
    found, _ = _read(tmp_path, "total (deg);T (N mm)\n" + rows)
    assert found.load == pytest.approx([1e-3 * m for m in torques], rel=1e-13)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("total (deg);T (N mm)\n" + POINT + "\n" + POINT, ["loop 1", "loop 2"]),
        ("total (deg);T (N mm)\n" + POINT + ";\n;\n" + POINT, ["loop 1", "loop 2"]),
        ("total (deg);T (N mm)\n" + POINT + "total (deg);T (N mm)\n" + POINT, ["loop 1", "loop 2"]),
        (
            "Angle;Torque\ndeg;N mm\n" + POINT + "\nLoop 2\nSpeed;1 deg/s\nAngle;Torque\ndeg;N mm\n" + POINT,
            ["loop 1", "loop 2"],
        ),
        (
            "t (s);total (deg);T (N mm)\n" + _timed(POINT) * 2,
            ["loop 1", "loop 2"],
        ),
        # the way back stands in a block of its own: one loop
        ("total (deg);T (N mm)\n0;0\n60;22\n120;1110.5\n\n60;700\n30;5\n0;-3\n", None),
    ],
)
def test_blocks_are_loops(text, names, tmp_path):
    found, line = _read(tmp_path, text)
    if names is None:
        assert found.names is None
        return
    assert "as 2 loops" in line
    parts = found.specimens()
    assert [part.label for part in parts] == names
    for part in parts:
        _holds(part)
        assert part.where(4).startswith(f"{tmp_path}")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            SEMI,
            'line 1: "0;0" are numbers where the header must stand; write above the rows a line like: '
            'Phi (rad/m), T (N m); or give columns, e.g. "1=total (deg), 2=T (N m)"',
        ),
        ("Sample 3\n\n" + SEMI, 'line 3: "0;0" are numbers'),
        ("a;b\n" + POINT, 'the header "a;b" has none of the columns'),
        (
            "Winkel;Drehmoment\n" + POINT,
            'column "Winkel": has no unit; write a header like: '
            'Phi (rad/m), T (N m); or give its unit with columns, e.g. "Winkel=total (deg)"',
        ),
        ("Angle 1 (deg);Angle 2 (deg);T (N mm)\n1;2;3\n", "several columns may be a twist rate"),
        ("total (deg);T (N mm)\n0;0\n60;zwei\n", 'line 3: T (N mm) = "zwei": is not a number; write e.g. 0.25'),
        ("total (deg);T (N mm)\n0;0\n60;inf\n", "line 3: T (N mm) = inf: is not a finite number; leave the cell empty"),
        ("total (deg);T (N mm)\n0;0\n60;12h\n", 'line 3: T (N mm) = "12h": is not a number'),
        ("total (deg);T (N mm)\n0;0\n60;1;2\n", "line 3: has 3 cells, the header has 2; give one for each column"),
        ("total (deg);T (N mm)\nNaN;1\n60;\n", 'no row has a value of both "total (deg)" and "T (N mm)"'),
        ("Angle (mm);T (N mm)\n" + POINT, "no column of a twist rate"),
        ("total (deg);T (N)\n" + POINT, 'column "T (N)": N is no unit of a torque'),
        (
            "t (s);total (deg);T (N mm)\n0;0;0\n9;1;1\n1;2;3\n8;3;4\n2;4;9\n",
            "line 4: the time goes back, from 9 to 1: the rows are sorted by the twist; sort the rows by the time",
        ),
        (
            "t (s);total (deg);T (N mm)\n0;0;0\n9;1;1\n5;2;3\n8;0;4\n",
            "line 4: the time goes back, from 9 to 5; sort the rows by the time",
        ),
        ("total (deg);T (N mm)\n1,5;2\n2;1.5\n", 'line 2: total (deg) = "1,5": has a decimal comma; write 1.5'),
        ("total (deg)  T (N mm)\n0  0\n60\n120  5\n", "line 3: has 1 cell, the header has 2"),
        (
            "Angle (deg),Torque (N mm)\n0,0,0,0\n6,5,1,2\n",
            "line 2: all rows have 4 cells, the header has 2: commas part",
        ),
        ("Angle (deg);T (N mm);Angle (deg);T (N mm)\n0;0;0;0\n1;2;3;4\n", 'line 1: the column "T" is given twice'),
        ("Angle (deg);Torque 1 (N mm);Torque 2 (N mm);Angle (deg)\n0;0;0;0\n", "several columns may be a twist rate"),
        ("Angle (deg);Torque (N mm)\n" + "1" * 300_000 + ";2\n", "line 2: is not a row of a table (field larger than"),
        (";".join(["a"] * 300) + "\n" + ";".join("1" * 300), "has 300 cells in line 1 (256 at most)"),
        ("# nothing\n% more\n", "has comments only"),
        ("total (deg);T (N mm)\n", "has a header but no rows"),
        (
            b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(99),
            "is a workbook of an old Excel (.xls); save it as .xlsx or as CSV",
        ),
        (b"PK\x03\x04" + bytes(99), "is a damaged workbook"),
        (b"%PDF-1.4\x00\x01", "is a binary file"),
    ],
)
def test_it_is_refused_in_one_line(text, words, tmp_path):
    with pytest.raises(InputError) as caught:
        _read(tmp_path, text)
    line = str(caught.value).splitlines()[0]
    assert line.startswith(f"{tmp_path / 'test.csv'}: ")
    assert words in line, line


def test_a_table_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(laboratory, "ROWS", 5)
    with pytest.raises(InputError, match="has more than 5 lines; thin it out"):
        _read(tmp_path, "total (deg);T (N mm)\n" + POINT)
    monkeypatch.setattr(laboratory, "LARGEST", 40)
    with pytest.raises(InputError, match="is larger than 40 bytes"):
        _read(tmp_path, "total (deg);T (N mm)\n" + POINT)


# ---- workbooks --------------------------------------------------------------------------------------------

NAMESPACE = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
RELATIONS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
FAR = '<row r="1048576"><c r="XFD1048576"><v>2</v></c></row>'
TYPES = "application/vnd.openxmlformats-officedocument.spreadsheetml"


def _book(**sheets):
    """Pack a workbook by hand: each sheet is the XML of its rows."""
    parts = "".join(
        f'<Override PartName="/xl/worksheets/s{i}.xml" ContentType="{TYPES}.worksheet+xml"/>'
        for i in range(len(sheets))
    )
    files = {
        "[Content_Types].xml": '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        f'<Override PartName="/xl/workbook.xml" ContentType="{TYPES}.sheet.main+xml"/>{parts}</Types>',
        "_rels/.rels": '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
        f'<Relationship Id="r" Type="{RELATIONS}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'<workbook {NAMESPACE} xmlns:r="{RELATIONS}"><sheets>'
        + "".join(f'<sheet name="{name}" sheetId="{i + 1}" r:id="r{i}"/>' for i, name in enumerate(sheets))
        + "</sheets></workbook>",
        "xl/_rels/workbook.xml.rels": '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
        + "".join(
            f'<Relationship Id="r{i}" Type="{RELATIONS}/worksheet" Target="worksheets/s{i}.xml"/>'
            for i in range(len(sheets))
        )
        + "</Relationships>",
    }
    for i, rows in enumerate(sheets.values()):
        files[f"xl/worksheets/s{i}.xml"] = f"<worksheet {NAMESPACE}><sheetData>{rows}</sheetData></worksheet>"
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return packed.getvalue()


def _cells(number, *cells):
    found = ""
    for letter, cell in zip("ABCD", cells, strict=False):
        if isinstance(cell, str) and cell[0] != "#":
            found += f'<c r="{letter}{number}" t="inlineStr"><is><t>{cell}</t></is></c>'
        elif cell is not None:
            kind = ' t="e"' if isinstance(cell, str) else ""
            found += f'<c r="{letter}{number}"{kind}><v>{cell}</v></c>'
    return f'<row r="{number}">{found}</row>'


def _table(first=1, points=LOOP):
    rows = [_cells(first, "Winkel in Grad", "Drehmoment (Nmm)")]
    return "".join(rows + [_cells(first + i, *point) for i, point in enumerate(points, 1)])


def test_a_workbook(tmp_path):
    pytest.importorskip("openpyxl")
    gaps = [*LOOP[:2], (None, 5), (80, "#N/A"), *LOOP[2:]]
    found, line = _read(tmp_path, _book(Info=_cells(1, "Sample", "vinyl 3"), Loop=_table(4, gaps)))
    _holds(found)
    assert 'without sheet "Info"' in line
    assert "without 2 rows (lines 7, 8) that have no value" in line
    assert found.where(2) == f'{tmp_path / "test.csv"}: sheet "Loop": line 9'


def test_sheets_and_blocks_of_a_workbook_are_loops(tmp_path):
    pytest.importorskip("openpyxl")
    parts = _read(tmp_path, _book(slow=_table(), fast=_table(3)))[0].specimens()
    assert [part.label for part in parts] == ["slow", "fast"]
    for part in parts:
        _holds(part)
    assert parts[1].where(0) == f'{tmp_path / "test.csv"}: line 4 of sheet "fast"'
    again = "".join(_cells(20 + i, *point) for i, point in enumerate(LOOP))
    parts = _read(tmp_path, _book(both=_table() + again))[0].specimens()
    assert [part.label for part in parts] == ["loop 1", "loop 2"]
    _holds(parts[1])


@pytest.mark.parametrize(
    ("book", "words"),
    [
        (lambda: _book(A=_table() + FAR), 'sheet "A": has more than 200,000 rows'),
        (lambda: _book(A=_table() + " " * (workbook.LARGEST + 1)), "(100,000,000 at most); save the table alone"),
        (lambda: _book(A=""), "has no sheet with values"),
        (lambda: _book(A="<row><c>"), "is a damaged workbook"),
        (lambda: _book(A=_table().replace("(Nmm)", "(elephants)")), "elephants is no unit of a torque"),
        (lambda: _book(A=_table())[:-40], "is a damaged workbook"),
    ],
)
def test_a_workbook_is_bounded(book, words, tmp_path):
    pytest.importorskip("openpyxl")
    with pytest.raises(InputError) as caught:
        _read(tmp_path, book())
    (line,) = str(caught.value).splitlines()
    assert words in line, line


def test_another_packed_file_is_no_workbook(tmp_path):
    pytest.importorskip("openpyxl")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("content.xml", "<a/>")
    with pytest.raises(InputError, match="is a packed file, but no workbook of Excel"):
        _read(tmp_path, packed.getvalue())
