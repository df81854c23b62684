"""What nobody should name, and what files may hold to harm: one line each, in time, and no effect."""

import os
import warnings
from pathlib import Path

import h5netcdf
import numpy as np
import pytest
import xarray as xr

import squama
from squama.cli import flags, main
from squama.errors import InputError, Problem
from squama.io import datasets, files, tabular

R = squama.twist(squama.Beam.from_ratios(mu=0.3), points=4, joint="hinge")
FORMULAS = ["=1+1", "-", "+", "+A1", "@SUM(A1)", "-2+3", "\tx", "'=1", "''-a", "'plain", "-1.5", "+5", "", "a,=b"]


def _line(call, *words):
    """Return the one line in which a call is refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError) as caught:
            call()
    text = str(caught.value)
    assert text.isprintable(), text
    assert len(text) < 1500
    for word in words:
        assert word in text, text
    return text


# ---- results ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"# sizes", b"# attribute deep: " + b"[" * 100_000 + b"\n# sizes"),
        (b'"dtype": "float64"', b'"dtype": 7'),
        (b'"dtype": "float64"', b'"dtype": "U999999999"'),
        (b'"value": "nan"', b'"value": 1' + b"0" * 400),
        (b'"attrs": {', b'"attrs": 3, "more": {'),
        (b'"dims": []', b'"dims": "point"'),
        (b'"dims": ["point"]', b'"dims": [["point"]]'),
        (b'{"point": 4}', b'{"point": 4, "a": 100000000000000000000}'),
        (b'{"point": 4}', b'{"point": NaN}'),
        (b"# variable T: ", b"# variable: "),
        (b"0.0,", b"0.5,"),
        (b"edge", b"edgy"),
        (b'"units": "N m"', b'"units": "N M"'),
    ],
)
@pytest.mark.parametrize("hashed", [True, False])
def test_a_changed_csv_result(old, new, hashed, tmp_path):
    path = squama.save(R, tmp_path / "a.csv")
    data = path.read_bytes()
    if old not in data:
        old, new = b'"value": ', b'"value": 1' + b"0" * 400 + b', "old": '
    if not hashed:
        data = b"".join(line for line in data.splitlines(True) if not line.startswith(b"# sha256"))
    path.write_bytes(data.replace(old, new, 1))
    if not hashed and old in (b"0.0,", b"edge", b'"units": "N m"'):
        # meant so by whoever took the hash away
        assert not squama.read(path).identical(R)
    else:
        _line(lambda: squama.read(path), str(path), "line ", "write the file anew")


def test_a_csv_result_changed_on_purpose_says_how(tmp_path):
    path = squama.save(R, tmp_path / "a.csv")
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert squama.read(path).identical(R)
    path.write_text(path.read_text().replace("edge", "edgy", 1))
    line = _line(lambda: squama.read(path), "by its hash", "or remove this line if it was changed on purpose")
    number = int(line.split("line ")[1].split(":")[0])
    lines = path.read_text().splitlines(True)
    assert lines.pop(number - 1).startswith("# sha256: ")
    path.write_text("".join(lines))
    assert squama.read(path).attrs["law"] == "edgy"


def test_a_flipped_bit_of_a_netcdf_result(tmp_path):
    path = squama.save(R, tmp_path / "a.nc")
    data = path.read_bytes()
    at = data.index(R["T"].values[1:3].tobytes())
    for place in (at + 3, data.index(b"paper Eq. 14"), len(data) - 400):
        path.write_bytes(data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :])
        _line(lambda: squama.read(path), str(path), "is damaged", "write it anew")
    with xr.open_dataset(path.parent / squama.save(R, tmp_path / "b.nc"), engine="h5netcdf") as other:
        assert other.attrs["law"] == "edge"


def _by_another_program(path, mark, **encoding):
    changed = R.assign_attrs({datasets.NETCDF_MARK: mark})
    changed.to_netcdf(path, engine="h5netcdf", format="NETCDF4")
    return path


@pytest.mark.slow
def test_a_netcdf_result_without_a_hash(tmp_path):
    assert squama.read(_by_another_program(tmp_path / "old.nc", 1)).equals(R)
    path = _by_another_program(tmp_path / "new.nc", 2)
    _line(lambda: squama.read(path), "its end is missing", "set its attribute squama_file to 1")


def test_values_that_expand_are_not_read(tmp_path):
    path = tmp_path / "bomb.nc"
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"x": 400_000_000}
        file.attrs[datasets.NETCDF_MARK] = 1
        file.create_variable("x", ("x",), float, compression="gzip", chunks=(1_000_000,), fillvalue=0.0)
    assert path.stat().st_size < 100_000
    _line(lambda: datasets.stored(path), str(path), "would take 3.2 GB", "1 GB at most")


# ---- formulas ---------------------------------------------------------------------------------------------


def test_formulas_are_quoted_and_read_back(tmp_path):
    data = xr.Dataset({"name": ("point", np.array(FORMULAS)), "=x": ("point", -np.arange(len(FORMULAS)) * 1.5)})
    data.attrs["title"] = 'x,=HYPERLINK("http://a")'
    path = squama.save(data, tmp_path / "a.csv")
    text = path.read_bytes().decode()
    for cell in ("'=1+1", "'+A1", "'@SUM(A1)", "'-2+3", "'\tx", "''=1", "'''-a", "\n-1.5,", "\n+5,", "'=x"):
        assert cell in text, cell
    assert ",=" not in text.replace('"a,=b"', "")
    assert squama.read(path).identical(data)


def test_cells_that_are_carried_along_stay(tmp_path):
    head = "name,eta,beta,lambda,alpha_deg,theta0_deg,mu\n"
    row = ",3,1.25,0.45,45,10,0.3\n"
    (tmp_path / "d.csv").write_text(head + "=cmd()" + row + "-7" + row)
    for source, to in (("d.csv", "e.csv"), ("e.csv", "f.csv")):
        assert main(["ends", str(tmp_path / source), "-o", str(tmp_path / to)]) == 0
    assert (tmp_path / "e.csv").read_text() == (tmp_path / "f.csv").read_text()
    assert [row.cells[0] for row in tabular.read(tmp_path / "f.csv").rows] == ["=cmd()", "-7"]
    assert "\n'=cmd()," in (tmp_path / "f.csv").read_text()


# ---- messages ---------------------------------------------------------------------------------------------


def test_messages_do_not_steer_the_terminal(tmp_path, capsys):
    text = str(Problem("a\x1b[2J", "\x9b1m", "is \u202egnorw", "give\n1", "f\u2066"))
    assert text == r"f\u2066: a\x1b[2J = \x9b1m: is \u202egnorw; give\n1"
    (tmp_path / "d.csv").write_text(
        "eta,beta,lambda,alpha_deg,theta0_deg,mu,\x1b]0;x\x07,\x1b]0;x\x07\n1,1,1,1,1,1,1,1\n"
    )
    assert main(["ends", str(tmp_path / "d.csv"), "-o", str(tmp_path / "e.csv")]) == 2
    said = capsys.readouterr().err
    assert "\x1b" not in said
    assert r"\x1b]0;x\x07 is given twice" in said


def test_messages_are_short():
    assert str(Problem("mu", "9" * 4000, "is out of range")) == f"mu = {'9' * 20}...: is out of range"
    assert len(str(Problem("w" * 10**6, "", "is not known"))) < 1100
    _line(lambda: flags.whole(0, 9, "3").read("--port", "7" * 4000), "777...")


# ---- places -----------------------------------------------------------------------------------------------


@pytest.fixture
def places(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(files, "PATIENCE", 0.2)
    Path("loop").symlink_to("loop")
    for ending in ("toml", "csv", "nc", "npz", "png", "zarr"):
        Path(f"loop.{ending}").symlink_to(f"loop.{ending}")
        os.mkfifo(f"pipe.{ending}")
        Path(f"zero.{ending}").symlink_to("/dev/zero")
    squama.Beam.from_ratios(mu=0.3).to_toml("beam.toml")
    return tmp_path


LONG = "n" * 300
READERS = {
    "toml": [squama.Beam.from_toml, files.read_text],
    "csv": [squama.read, tabular.read],
    "nc": [squama.read],
}


@pytest.mark.parametrize("ending", READERS)
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("loop", "is a loop of symbolic links"),
        ("pipe", " is "),
        ("zero", "is a device"),
        (LONG, "is too long for a name"),
        ("zero.toml/x", "no such file"),
    ],
)
def test_what_is_no_file(name, words, ending, places):
    for read in READERS[ending]:
        _line(lambda read=read: read(f"{name}.{ending}"), f"{name[:90]}", words)


def test_a_pipe_is_read_to_its_end(places):
    if (child := os.fork()) == 0:
        with Path("pipe.toml").open("wb") as out:
            for part in ("[beam]", "\nscales", " = 3\n"):
                out.write(part.encode())
                out.flush()
        os._exit(0)
    assert files.read_text("pipe.toml") == "[beam]\nscales = 3\n"
    os.waitpid(child, 0)


COMMANDS = [
    "twist {}.toml", "twist beam.toml --csv {}.csv", "twist beam.toml --plot {}.png", "bend {}.toml",
    "cycle {}.toml --path 0:1rad/m", "view {}.toml -o a.png", "ends {}.csv -o a.csv", "fit {}.csv beam.toml",
    "design {}.toml -o out", "pareto {}.toml -o out", "export {}.toml -o out", "export beam.toml -o {}",
    "uncertainty beam.toml --tolerances {}.toml", "joint {}.toml", "new {}.toml", "map {}.zarr --plot a.png",
    "sweep beam.toml --over mu=0:1:3 -o {}.zarr", "twist beam.toml --data {}.csv --plot a.png",
    "paper -o {}", "paper -o out --points {}.csv", "explore {}.toml", "row {}.toml", "design beam.toml -o {}",
]  # fmt: skip


@pytest.mark.parametrize("name", ["loop", LONG])
@pytest.mark.parametrize("command", COMMANDS)
def test_commands_refuse_places(command, name, places, capsys):
    before = sorted(Path().iterdir())
    assert main(command.format(name).split()) == 2
    said = capsys.readouterr().err
    assert said.startswith("squama: error: ")
    assert "Traceback" not in said
    assert sorted(Path().iterdir()) == before
