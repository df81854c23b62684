"""Responses to files and back: nothing is lost, and what is wrong with a file is one line."""

import csv
import json

import numpy as np
import pytest
import xarray as xr

import squama
from squama.errors import InputError
from squama.io.datasets import check_place

BEAM = squama.Beam.from_ratios(alpha="45 deg", mu=0.3)
EXTENSIONS = [".nc", ".csv"]


def _responses():
    yield "one curve", squama.twist(BEAM, points=20, joint="hinge")
    yield "family", squama.twist(BEAM, mu=[0.0, 0.2, 6.0], points=20, joint="hinge")
    yield "never engages", squama.twist(BEAM.replace(scale={"alpha": "60 deg"}), sense="-", points=5, joint="hinge")
    yield "beyond the end", squama.twist(BEAM, at=[0.0, 1.0, 1e3], joint="hinge")
    yield "one of a family", squama.twist(BEAM, mu=[0.3, 0.4], points=20, joint="hinge").isel(mu=1)
    yield "dimensions turned", squama.twist(BEAM, mu=[0.3, 0.4], points=20, joint="hinge").transpose("point", "mu")
    yield "bending", squama.bend(BEAM, mu=[0.1, 0.2], points=20)
    odd = xr.Dataset(
        {
            "whole": ("point", np.array([1, 2, -3], np.int16)),
            "yes": ("point", np.array([True, False, True])),
            "small": ("point", np.array([0.1, -0.0, np.nan], np.float32)),
            "text": ("point", np.array(['a,"b"', "", "# c"])),
            "figure": ((), np.inf, {"units": "rad"}),
        },
        coords={"point": np.array([0.1, 0.2, 1 / 3])},
        attrs={"empty": "", "lines": "a\nb: c\n", "whole": 3, "part": 0.1, "greek": "\u03b1"},
    )
    yield "other types", odd


RESPONSES = dict(_responses())


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("name", RESPONSES)
def test_round_trip(name, extension, tmp_path):
    data = RESPONSES[name]
    again = squama.read(squama.save(data, tmp_path / f"a{extension}"))
    xr.testing.assert_identical(again, data)
    assert list(again.data_vars) == list(data.data_vars)
    for key, variable in data.variables.items():
        assert again[key].dtype.kind == variable.dtype.kind, key
        assert again[key].dtype == variable.dtype or variable.dtype.kind == "U", key
        # to the last bit, signs of zeros too
        if variable.dtype.kind == "f":
            assert again[key].values.tobytes() == variable.values.tobytes(), key
    assert {key: type(v) for key, v in again.attrs.items()} == {key: type(v) for key, v in data.attrs.items()}


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_the_beam_comes_back(extension, tmp_path):
    data = squama.read(squama.save(RESPONSES["one curve"], tmp_path / f"a{extension}"))
    assert squama.Beam.from_toml_text(data.attrs["beam"]) == BEAM


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_saved_again_it_is_the_same(extension, tmp_path):
    first = squama.save(RESPONSES["family"], tmp_path / f"a{extension}")
    second = squama.save(squama.read(first), tmp_path / f"b{extension}")
    xr.testing.assert_identical(squama.read(second), RESPONSES["family"])


def test_csv_for_people(tmp_path):
    data = RESPONSES["family"]
    lines = squama.save(data, tmp_path / "a.csv").read_text().splitlines()
    comments = [line for line in lines if line.startswith("# ")]
    rows = list(csv.reader(lines[len(comments) :]))
    assert rows[0][:4] == ["Phi (rad/m)", "phi (rad)", "mu (1)", "T (N m)"]
    assert len(rows) - 1 == 3 * 20
    assert {row[2] for row in rows[1:]} == {"0.0", "0.2", "6.0"}
    assert float(rows[-1][3]) == float(data["T"][-1, -1])
    values = {line.split(": ", 1)[0]: json.loads(line.split(": ", 1)[1]) for line in comments}
    assert values["# attribute law"] == "edge"
    assert values["# variable phi_e"]["value"] == data["phi_e"].values.tolist()
    assert values["# variable phi_e"]["attrs"]["units"] == "rad"


def _cut(data, fraction):
    return data[: int(len(data) * fraction)]


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda d: _cut(d, 0.9), ["line"]),
        (lambda d: d[: d.rstrip().rfind(b"\n") + 1], ["has 19 rows where squama wrote 20"]),
        (lambda d: d.replace(b"\n0.0,", b"\nzero,", 1), ['Phi (rad/m) = "zero"']),
        (lambda d: d.rstrip() + b",1\n", ["cells, the header has"]),
        (lambda d: d.replace(b'attribute law: "edge"', b"attribute law: edge"), ["line 5", "damaged"]),
        (lambda d: d.replace(b'"dtype": "float64"', b'"dtype": "complex"', 1), ["damaged"]),
        (lambda d: d.replace(b'"dtype": "float64"', b'"dtype": "O"', 1), ["damaged"]),
        (lambda d: d.replace(b"\nPhi (rad/m)", b"\nPhi (deg/m)"), ["damaged"]),
        (lambda d: d.replace(b"# sizes", b"# size"), ["damaged"]),
        (lambda _: b"Phi (rad/m),T (N m)\n1,2\n", ["not written by squama", "--data"]),
        (lambda _: b"# only\n", ["comments only"]),
        (lambda _: b"", ["is empty"]),
        (lambda _: b"\x00\x01", ["binary"]),
        (lambda _: b"\xff\xfea", ["not UTF-8"]),
        (lambda d: d + b'"', ["quotes"]),
    ],
)
def test_damaged_csv(damage, words, tmp_path):
    path = squama.save(RESPONSES["one curve"], tmp_path / "a.csv")
    path.write_bytes(damage(path.read_bytes()))
    _refused(lambda: squama.read(path), path, words)


def _foreign(path):
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(path, engine="h5netcdf")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: p.write_bytes(_cut(p.read_bytes(), 0.5)), ["damaged"]),
        (lambda p: p.write_bytes(p.read_bytes()[:8]), ["damaged"]),
        (lambda p: p.write_text("Phi,T\n1,2\n"), ["is no netCDF-4 file"]),
        (lambda p: p.write_bytes(b""), ["is no netCDF-4 file"]),
        (_foreign, ["not written by this version of squama"]),
    ],
)
def test_damaged_netcdf(make, words, tmp_path):
    path = squama.save(RESPONSES["one curve"], tmp_path / "a.nc")
    make(path)
    _refused(lambda: squama.read(path), path, words)


@pytest.mark.parametrize("call", [squama.read, lambda p: squama.save(RESPONSES["one curve"], p), None])
@pytest.mark.parametrize(("name", "words"), [("a.xyz", ["extension .xyz is not known"]), ("a", ["no extension"])])
def test_extensions(call, name, words, tmp_path):
    path = tmp_path / name
    _refused(lambda: (call or (lambda p: check_place(p, EXTENSIONS)))(path), path, [*words, "allowed: .nc, .csv"])


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_places_to_read_from(extension, tmp_path):
    _refused(lambda: squama.read(tmp_path / f"no{extension}"), tmp_path / f"no{extension}", ["no such file"])
    folder = tmp_path / f"folder{extension}"
    folder.mkdir()
    _refused(lambda: squama.read(folder), folder, ["is a folder"])


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("what", ["folder", "read-only file", "read-only folder", "no parent"])
def test_places_to_write_to(what, extension, tmp_path):
    path, words = tmp_path / f"a{extension}", what.split()[0]
    if what == "folder":
        path.mkdir()
    elif what == "read-only file":
        path.write_text("old")
        path.chmod(0o444)
    elif what == "read-only folder":
        path = tmp_path / "sealed" / f"a{extension}"
        path.parent.mkdir(mode=0o555)
    else:
        path, words = tmp_path / "none" / f"a{extension}", "does not exist"
    before = sorted(tmp_path.rglob("*"))
    for call in (lambda: squama.save(RESPONSES["one curve"], path), lambda: check_place(path)):
        _refused(call, path, [words])
    assert sorted(tmp_path.rglob("*")) == before
    if what == "read-only file":
        assert path.read_text() == "old"


def test_a_trial_of_a_place_leaves_nothing(tmp_path):
    check_place(tmp_path / "a.nc", EXTENSIONS)
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "a.nc").write_text("old")
    check_place(tmp_path / "a.nc", EXTENSIONS)
    assert (tmp_path / "a.nc").read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (xr.Dataset({"z": ("point", [1j])}), "complex"),
        (xr.Dataset({"z": ((), 1.0)}), "no points"),
        (xr.Dataset({"z": ("point", np.array([]))}), "no points"),
    ],
)
def test_csv_says_what_it_cannot_hold(data, words, tmp_path):
    with pytest.raises(InputError, match=words):
        squama.save(data, tmp_path / "a.csv")
    assert list(tmp_path.iterdir()) == []


def _refused(call, path, words):
    with pytest.raises(InputError) as caught:
        call()
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert len(text.splitlines()) == 1
    for word in words:
        assert word in text
