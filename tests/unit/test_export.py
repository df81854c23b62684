"""squama export: files read back by readers of their own, the folder, the command."""

from __future__ import annotations

import csv
import io
import itertools
import math
import struct
import zipfile
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import squama
from squama import arguments, needs
from squama.errors import InputError, SquamaError
from squama.fabrication import bodies, exporting, formats, mesh
from squama.fabrication.bodies import BENCH, block
from squama.fabrication.mesh import TRIANGLES, Mesh

pytest.importorskip("manifold3d")
pytest.importorskip("trimesh")

EXAMPLE = Path(__file__).parents[2] / "examples" / "pla_on_vps.toml"
BEAM = squama.Beam.from_toml(EXAMPLE)
A, TH = math.radians(60), math.radians(15)
BAR, SLOT, SCALE = 32 * 16 * (3 * 20 + 60), 6.2 * 24.4 * 1.2, 66 * 24 * 0.8
CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"


def read_stl(path):
    data = Path(path).read_bytes()
    (count,) = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count
    assert not data.startswith(b"solid")
    rows = [struct.unpack_from("<12fH", data, 84 + 50 * i) for i in range(count)]
    return [(np.array(r[:3]), np.array(r[3:12]).reshape(3, 3)) for r in rows]


def volume(triangles):
    """Exact sum over the corners as they stand in the file."""
    total = Fraction(0)
    for t in triangles:
        a, b, c = ([Fraction(float(x)) for x in corner] for corner in t)
        total += sum(a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3))
    return float(total / 6)


def edges_close(triangles):
    edges = {}
    for t in triangles:
        corners = [tuple(corner) for corner in t]
        for p, q in itertools.pairwise([*corners, corners[0]]):
            edges[p, q] = edges.get((p, q), 0) + 1
    return all(edges.get((q, p), 0) == n for (p, q), n in edges.items())


def read_3mf(path):
    """Name, triangles and unit of every solid, transforms applied."""
    with zipfile.ZipFile(path) as package:
        assert package.testzip() is None
        # the hour at which it was written is not in it
        assert {entry.date_time for entry in package.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert set(package.namelist()) == {"[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"}
        root = ElementTree.fromstring(package.read("3D/3dmodel.model"))
    assert root.get("unit") == "millimeter"
    objects = {o.get("id"): o for o in root.iter(f"{CORE}object")}
    found = {}

    def put(number, matrix, name=None):
        obj = objects[number]
        name = name or obj.get("name")
        for c in obj.iter(f"{CORE}component"):
            own = np.array([float(x) for x in c.get("transform").split()]).reshape(4, 3)
            put(c.get("objectid"), np.vstack([own[:3] @ matrix[:3], own[3] @ matrix[:3] + matrix[3]]), name)
        points = np.array([[float(v.get(k)) for k in "xyz"] for v in obj.iter(f"{CORE}vertex")])
        if points.size:
            numbers = [[int(t.get(f"v{i}")) for i in (1, 2, 3)] for t in obj.iter(f"{CORE}triangle")]
            found[name] = (points @ matrix[:3] + matrix[3])[np.array(numbers)]

    for item in root.iter(f"{CORE}item"):
        text = item.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0")
        put(item.get("objectid"), np.array([float(x) for x in text.split()]).reshape(4, 3))
    return found


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return squama.export(BEAM, tmp_path_factory.mktemp("export") / "solids", scales=3)


def test_stl_files_by_a_reader_of_our_own(made):
    folder = made.files[0].parent
    for name, expected in {
        "scale": SCALE,
        "scales": 3 * SCALE,
        "substrate": BAR - 3 * SLOT,
        "assembly": BAR - 3 * SLOT + 3 * SCALE,
    }.items():
        rows = read_stl(folder / f"{name}.stl")
        triangles = [corners for _, corners in rows]
        assert volume(triangles) == pytest.approx(expected, rel=1e-4), name
        assert edges_close(triangles), name
        for normal, (a, b, c) in rows:
            whole = np.cross(b - a, c - a)
            assert np.linalg.norm(whole - normal * np.linalg.norm(whole)) < 3e-4 * np.linalg.norm(whole) + 3e-4
    for stem in ("tray", "lid", "blade", "mould"):
        assert edges_close([corners for _, corners in read_stl(folder / f"{stem}.stl")])


def test_3mf_files_by_zip_and_xml(made):
    folder = made.files[0].parent
    beam = read_3mf(folder / "assembly.3mf")
    assert list(beam) == ["substrate", "scale 1", "scale 2", "scale 3"]
    assert volume(beam["substrate"]) == pytest.approx(BAR - 3 * SLOT, rel=1e-12)
    n_x = np.array([math.cos(A) * math.cos(TH), -math.sin(A) * math.cos(TH), math.sin(TH)])
    n_y = np.array([math.sin(A), math.cos(A), 0])
    n_z = np.cross(n_x, n_y)
    for k in range(3):
        triangles = beam[f"scale {k + 1}"]
        assert volume(triangles) == pytest.approx(SCALE, rel=1e-9)
        o = np.array([30 + 20 * (k + 0.5), 0, 16])
        signs = itertools.product((-6, 60), (-12, 12), (-0.4, 0.4))
        expected = np.array([o + x * n_x + y * n_y + z * n_z for x, y, z in signs])
        seen = np.unique(np.round(triangles.reshape(-1, 3), 9), axis=0)
        np.testing.assert_allclose(seen, expected[np.lexsort(np.round(expected, 9).T[::-1])], atol=1e-8)
    mould = read_3mf(folder / "mould.3mf")
    assert list(mould) == ["tray", "lid", "blade 1", "blade 2", "blade 3"]
    assert list(read_3mf(folder / "scale.3mf")) == ["scale"]
    flat = read_3mf(folder / "scales.3mf")
    boxes = sorted((t.reshape(-1, 3).min(0).tolist(), t.reshape(-1, 3).max(0).tolist()) for t in flat.values())
    for (low, high), (other, _) in itertools.pairwise(boxes):
        assert max(np.subtract(other, high)[:2]) >= 2 - 1e-9 or max(np.subtract(low, high)[:2]) >= 2
        assert low[2] == 0


def test_the_bill(made):
    rows = {row.part: row for row in made.bill}
    assert rows["scale"].number == rows["blade"].number == 3
    assert rows["scale"].volume == pytest.approx(SCALE)
    assert rows["scale"].mass == pytest.approx(SCALE * 1e-3 * 1.24)
    assert rows["substrate"].mass == pytest.approx((BAR - 3 * SLOT) * 1e-3 * 1.15)
    # what is left of a slot below the face around the tab: (L + c) t - L t_s in the section, times the widths
    assert rows["glue in a slot"].volume == pytest.approx(SLOT - 6 * 24 * 0.8)
    with (made.files[0].parent / "bill.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [row["part"] for row in table] == list(rows)
    for row in table:
        assert float(row["total_mass_g"]) == pytest.approx(
            float(row["volume_mm3"]) * 1e-3 * float(row["density_g_cm3"]) * int(row["count"]), rel=1e-8
        )
    heavy = squama.export(BEAM, made.files[0].parent.parent / "heavy", scales=2, parts="scale", scale_density=2.48)
    assert heavy.bill[0].mass == pytest.approx(2 * rows["scale"].mass)


def test_checks_are_reported_and_meshes_given(made):
    assert all(check.holds for check in made.checks)
    read = [c for c in made.checks if c.what == "volume" and "." in c.solid]
    assert len(read) == 8 + 1 + 3 + 1 + 1 + 1 + 1 + 5 + 4
    found = {name: mesh.volume for name, mesh in ((m.name, m) for m in made.solids["assembly"])}
    assert found["scale 2"] == pytest.approx(SCALE)
    assert made.plan.total == 120


def test_the_same_bytes_for_the_same_input(made, tmp_path):
    again = squama.export(BEAM, tmp_path / "again", scales=3)
    for one, other in zip(made.files, again.files, strict=True):
        assert one.name == other.name
        assert one.read_bytes() == other.read_bytes()


def test_files_of_others_are_not_lost(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "scale.stl").write_text("mine")
    (folder / "notes.txt").write_text("mine too")
    few = {"scales": 2, "parts": ["scale"], "formats": ["stl"]}
    with pytest.raises(InputError, match=r"scale\.stl: is there and was not written"):
        squama.export(BEAM, folder, **few)
    assert sorted(p.name for p in folder.iterdir()) == ["notes.txt", "scale.stl"]
    assert (folder / "scale.stl").read_text() == "mine"
    squama.export(BEAM, folder, **few, force=True)
    # what an export has written may be written again, also with another design
    squama.export(BEAM.replace(scale={"thickness": "1 mm"}), folder, **few)
    squama.export(BEAM, folder, scales=2, parts=["substrate"], formats=["stl"])
    squama.export(BEAM, folder, **few)
    assert (folder / "notes.txt").read_text() == "mine too"
    with (folder / "scale.stl").open("ab") as file:
        file.write(b"changed")
    with pytest.raises(InputError, match="was changed since"):
        squama.export(BEAM, folder, **few)
    assert (folder / "scale.stl").read_bytes().endswith(b"changed")
    (folder / "export.json").write_text("[]")
    with pytest.raises(InputError) as caught:
        squama.export(BEAM, folder, **few)
    assert str(caught.value).count("\n") == 3


def test_places_that_take_no_files(tmp_path):
    few = {"scales": 2, "parts": ["scale"], "formats": ["stl"]}
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="is a file"):
        squama.export(BEAM, tmp_path / "file", **few)
    with pytest.raises(InputError, match="does not exist"):
        squama.export(BEAM, tmp_path / "no" / "where", **few)
    (tmp_path / "out" / "scale.stl").mkdir(parents=True)
    with pytest.raises(InputError, match="is a folder"):
        squama.export(BEAM, tmp_path / "out", **few)
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o555)
    with pytest.raises(InputError, match="read-only"):
        squama.export(BEAM, locked, **few)


def test_a_file_that_is_not_as_it_should_be_is_not_put_there(tmp_path, monkeypatch):
    few = {"scales": 2, "parts": ["scale"], "formats": ["stl"]}
    whole = formats.stl
    # a triangle is lost on the way to the file
    monkeypatch.setattr(
        formats,
        "stl",
        lambda solids: (d := whole(solids))[:80] + struct.pack("<I", (len(d) - 84) // 50 - 1) + d[84:-50],
    )
    with pytest.raises(SquamaError, match=r"scale\.stl, scale: watertight = 0, should be 1"):
        squama.export(BEAM, tmp_path / "out", **few)
    assert list((tmp_path / "out").iterdir()) == []
    monkeypatch.setattr(formats, "stl", whole)
    monkeypatch.setattr(mesh, "VOLUME", -1.0)
    with pytest.raises(SquamaError, match="scale: volume"):
        squama.export(BEAM, tmp_path / "other", **few)
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"scales": 0}, "scales = 0: must be a whole number from 1 to 500"),
        ({"scales": 2.5}, "scales = 2.5"),
        ({"parts": ["scale", "lid"]}, 'parts = "lid": must be "scale" or "substrate"'),
        ({"parts": []}, "parts: is empty"),
        ({"formats": "obj"}, 'formats = "obj": must be "stl" or "3mf" or "step"'),
        ({"clearance": "-0.1 mm"}, 'clearance = "-0.1 mm"'),
        ({"clearance": "2 deg"}, "is an angle, but a length is needed"),
        ({"feature": "0 mm", "wall": "x"}, "feature = "),
        ({"draft": "30 deg"}, "0 to 20 deg"),
        ({"bed": "0 mm"}, "bed = "),
        ({"scale_density": -1}, "scale_density = -1: must be a density"),
        ({"ends": "2 mm"}, "ends = 2 mm: a slot opens at the bar's end; write at least 4.038 mm"),
    ],
)
def test_bad_arguments(tmp_path, arguments, words):
    with pytest.raises(InputError) as caught:
        squama.export(BEAM, tmp_path / "out", **arguments)
    assert words in str(caught.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("module", "words"),
    [
        ("manifold3d", "solids need manifold3d; install it with: pip install 'squama[export]'"),
        ("trimesh", "solids need trimesh; install it with: pip install 'squama[export]'"),
        ("networkx", "solids need networkx; install it with: pip install 'squama[export]'"),
        ("lxml", "solids need lxml; install it with: pip install 'squama[export]'"),
        ("build123d", "STEP files need build123d; install it with: pip install 'squama[step]'"),
        ("netgen.occ", "finite elements need netgen-mesher; install them with: pip install 'squama[fe]'"),
        ("ipctk", "finite elements need ipctk; install them with: pip install 'squama[fe]'"),
    ],
)
def test_a_package_that_is_missing_is_named(monkeypatch, module, words):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(needs, "import_module", missing)
    with pytest.raises(InputError) as caught:
        needs.need(module)
    assert str(caught.value) == words


@pytest.mark.parametrize("name", ["stiff_skin", "pla_on_vps"])
def test_the_beams_of_the_examples_can_be_printed(name, tmp_path):
    made = squama.export(squama.Beam.from_toml(EXAMPLE.with_stem(name)), tmp_path, formats=["stl"])
    assert {path.name for path in made.files} == {path.name for path in tmp_path.iterdir()}
    assert set(made.solids) >= set(exporting.PARTS)


def test_step_files_in_millimetres(tmp_path):
    cad = pytest.importorskip("build123d")
    made = squama.export(BEAM, tmp_path / "a", scales=3, formats=["step"])
    again = squama.export(BEAM, tmp_path / "b", scales=3, formats=["step"])
    for one, other in zip(made.files, again.files, strict=True):
        assert one.read_bytes() == other.read_bytes()
    whole = cad.import_step(tmp_path / "a" / "assembly.step")
    solids = whole.solids()
    assert len(solids) == 4
    assert sum(s.volume for s in solids) == pytest.approx(BAR - 3 * SLOT + 3 * SCALE, rel=1e-9)
    names = {c.label.replace("_", " ") for c in whole.children}
    assert names == {"substrate", "scale 1", "scale 2", "scale 3"}
    box = whole.bounding_box()
    points = np.concatenate([m.vertices for m in made.solids["assembly"]])
    np.testing.assert_allclose([*box.min], points.min(0), atol=1e-4)
    np.testing.assert_allclose([*box.max], points.max(0), atol=1e-4)
    assert "SI_UNIT(.MILLI.,.METRE.)" in (tmp_path / "a" / "scale.step").read_text()


def test_occurrences_of_a_step_file_are_numbered_from_1():
    name = b"NEXT_ASSEMBLY_USAGE_OCCURRENCE"
    text = b"#1 = %s('27','tray','',#5,#35,$);\n#2 =\n  %s('109',\n'a b','',#5,#3,$);" % (name, name)
    expected = b"#1 = %s('1','tray','',#5,#35,$);\n#2 = %s('2','a b','',#5,#3,$);" % (name, name)
    assert formats._numbered(text) == expected


def test_names_are_quoted_in_3mf():
    mesh = Mesh('a "b" <&>', block((0, 0, 0), (1, 1, 1)), TRIANGLES)
    placed = formats.Placed(mesh.name, bodies.Recipe(mesh.name, mesh.vertices, (), 1.0), mesh)
    model = zipfile.ZipFile(io.BytesIO(formats.three_mf([placed]))).read("3D/3dmodel.model")
    root = ElementTree.fromstring(model)
    assert next(root.iter(f"{CORE}object")).get("name") == 'a "b" <&>'


def test_the_bench_is_a_rotation():
    assert np.linalg.det(BENCH) == 1
    np.testing.assert_array_equal(BENCH @ BENCH.T, np.eye(3))


def test_parts_and_formats_in_any_order():
    assert arguments.several("parts", ["mould", "scale", "mould"], exporting.PARTS) == ("scale", "mould")


@pytest.mark.parametrize("faces", ["mirrored", "turned, shifted"])
def test_scales_of_both_faces_stand_where_the_map_puts_them(faces, tmp_path):
    beam = BEAM.replace(faces=faces)
    made = squama.export(beam, tmp_path, scales=3, parts=["substrate", "assembly"], formats=["stl"])
    bar, *scales = made.solids["assembly"]
    assert [row.number for row in made.bill if row.part == "scale"] == [6]
    # along, across, up of the bar's middle line
    S = np.array(beam.other.S)[[2, 0, 1]]
    middle, shift = np.array([0, 0, 8.0]), [20 * beam.other.shift, 0, 0]
    for own, other in zip(scales[:3], scales[3:], strict=True):
        there = (own.vertices - middle) * S + middle + shift
        assert np.abs(there[:, None] - other.vertices).sum(axis=2).min(axis=1).max() < 1e-9
    assert bar.volume == pytest.approx(BAR - 6 * SLOT, rel=1e-9)
    assert {check.measured for check in made.checks if check.what == "slots"} == {3}
    assert len([check for check in made.checks if check.what == "slots"]) == 2
    for change, parts, said in (
        ({}, ["mould"], "casts the slots of one face"),
        ({"scale": {"embedded": "28 mm", "width": "10 mm"}}, ["substrate"], "comes to those of the other face"),
    ):
        with pytest.raises(InputError, match=said):
            squama.export(beam.replace(**change), tmp_path / "refused", scales=3, parts=parts)
