"""Standard input in place of a file, a table on standard output; coordinates and columns in a fixed order."""

from __future__ import annotations

import csv
import io
import itertools
import sys
from pathlib import Path

import pytest

import squama
from squama.cli import main

SKIN = Path("examples/stiff_skin.toml")
HOW = ["--joint", "hinge", "--points", "5"]


def _typed(monkeypatch, data: bytes) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))


def test_a_beam_from_standard_input_is_that_of_its_file(monkeypatch, capsys):
    assert main(["twist", str(SKIN), *HOW]) == 0
    expected = capsys.readouterr().out
    _typed(monkeypatch, SKIN.read_bytes())
    assert main(["twist", "-", *HOW]) == 0
    assert capsys.readouterr().out == expected.replace(str(SKIN), "standard input", 1)
    _typed(monkeypatch, SKIN.read_bytes())
    assert main(["twist", "--json", "-", *HOW]) == 0
    assert '"file": "standard input"' in capsys.readouterr().out
    _typed(monkeypatch, b"[beam]\n")
    assert main(["twist", "-", *HOW]) == 2
    assert capsys.readouterr().err.startswith("squama: error: standard input: ")


def test_what_a_beam_on_standard_input_names_is_in_the_current_folder(tmp_path, monkeypatch, capsys):
    named = SKIN.read_bytes().replace(b"[joint]", b'[joint]\nmatrix = "no.csv"')
    monkeypatch.chdir(tmp_path)
    _typed(monkeypatch, named)
    assert main(["twist", "-", *HOW]) == 2
    assert "no.csv: no such file" in capsys.readouterr().err


def test_no_more_of_standard_input_is_read_than_any_file_may_have(monkeypatch, capsys):
    class Endless(io.RawIOBase):
        """A device without an end."""

        def readable(self):
            return True

        def readinto(self, buffer):
            buffer[:] = b"#" * len(buffer)
            return len(buffer)

    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BufferedReader(Endless())))
    assert main(["twist", "-"]) == 2
    assert "standard input: is larger than" in capsys.readouterr().err


def test_a_table_alone_on_standard_output(tmp_path, monkeypatch, capsys):
    assert main(["twist", str(SKIN), *HOW, "--csv", "-"]) == 0
    (tmp_path / "a.csv").write_text(capsys.readouterr().out)
    expected = squama.twist(squama.Beam.from_toml(SKIN), joint="hinge", points=5)
    assert squama.read(tmp_path / "a.csv").identical(expected)
    # thin scales on hinges are outside the law of the joint: a warning stands beside the table
    assert main(["twist", str(SKIN), "--joint", "hinge", "--ideal", "--points", "5", "--csv", "-"]) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith("#")
    assert printed.err.startswith("warning: ")
    assert main(["twist", str(SKIN), *HOW, "--csv", "-", "--json"]) == 2
    assert "--csv = -: is printed, and so is --json" in capsys.readouterr().err
    # the sign stays the value of a flag
    assert main(["twist", str(SKIN), *HOW, "--sense", "-"]) == 0
    assert "sense -" in capsys.readouterr().out


def test_the_example_and_the_law_of_a_section_on_standard_output(tmp_path, capsys):
    assert main(["new", "-"]) == 0
    printed = capsys.readouterr()
    assert printed.out == Path("examples/pla_on_vps.toml").read_text(encoding="utf-8")
    assert printed.err == ""
    how = ["law", str(SKIN), "--mu", "0", "--uncoupled", "--points", "3", "--twist", "4 rad/m"]
    assert main([*how, "-o", str(tmp_path / "law.csv")]) == 0
    capsys.readouterr()
    assert main([*how, "-o", "-"]) == 0
    assert capsys.readouterr().out == (tmp_path / "law.csv").read_text(encoding="utf-8")
    for wrong, words in ((["--json"], "is printed, and so is --json"), (["--format", "npz"], "cannot print a binary")):
        assert main([*how, "-o", "-", *wrong]) == 2
        assert words in capsys.readouterr().err


def test_a_slice_of_a_sweep_on_standard_output(tmp_path, capsys):
    beam, store, file = squama.Beam.from_toml(SKIN), tmp_path / "a.zarr", tmp_path / "a.csv"
    squama.sweep(beam, {"mu": (0, 1, 3)}, joint="hinge", out=store)
    assert main(["map", str(store), "--csv", str(file)]) == 0
    capsys.readouterr()
    assert main(["map", str(store), "--csv", "-"]) == 0
    rows = [text.splitlines() for text in (capsys.readouterr().out, file.read_text(encoding="utf-8"))]
    assert [row for row in rows[0] if row[0] != "#"] == [row for row in rows[1] if row[0] != "#"]
    assert len(rows[0]) > 4


def test_a_folder_is_not_standard_output(tmp_path, monkeypatch, capsys):
    target = Path("examples/lock_at_120.toml").resolve()
    monkeypatch.chdir(tmp_path)
    for command in (["paper", "fig4", "-o", "-"], ["design", str(target), "-o", "-"]):
        assert main(command) == 2
        assert "-: is standard output, which holds no folder; give the name of a folder" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("run", "load"), [(squama.twist, ("Phi", "phi")), (squama.bend, ("kappa", "psi"))])
def test_the_load_is_a_coordinate_and_comes_first(run, load, tmp_path):
    beam = squama.Beam.from_toml(SKIN).replace(scales=None)
    heads, finite = [], beam.replace(scales=5)
    for one, how in ((beam, {"joint": "hinge"}), (beam, {}), (beam, {"ideal": True}), (finite, {})):
        r = run(one, points=3, **how)
        assert {*load} <= {*r.coords}
        lines = squama.save(r, tmp_path / "a.csv").read_text().splitlines()
        head = next(csv.reader(line for line in lines if not line.startswith("#")))
        assert [cell.split(" (")[0] for cell in head[:2]] == list(load)
        heads.append([cell for cell in head if cell.split(" (")[0] in r.variables])
    # columns that two models have stand in the same order
    for one, other in itertools.pairwise(heads):
        both = [cell for cell in one if cell in other]
        assert both == [cell for cell in other if cell in both]
        assert len(both) > 8
