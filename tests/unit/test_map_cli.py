"""squama sweep and squama map: what they write and say, and every class of bad input."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import squama
from squama.cli import main
from squama.cli.short import EXAMPLE
from squama.study import cluster, sweeping


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """A finished store, one of four dimensions and both laws, a line, and one half done."""
    folder = tmp_path_factory.mktemp("stores")
    beam = squama.Beam.from_toml_text(EXAMPLE.read_text())
    squama.sweep(
        beam, {"mu": (0, 2, 9), "alpha": ("15 deg", "75 deg", 7)}, out=folder / "map.zarr", tile=20, joint="hinge"
    )
    many = {"mu": (0, 2, 5), "alpha": ("15 deg", "75 deg", 4), "eta": (2, 4, 3), "margin": [0.001, 0.01, 0.1]}
    squama.sweep(beam, many, law=["edge", "plate"], out=folder / "four.zarr", joint="hinge")
    squama.sweep(beam, {"mu": (0, 4, 20)}, out=folder / "line.zarr", joint="hinge")
    plan = sweeping.make_plan(beam, {"mu": (0, 2, 9), "alpha": ("15 deg", "75 deg", 7)}, tile=20, joint="hinge")
    sweeping.run(plan, folder / "half.zarr", shard="1/2")
    return folder


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """A folder with a beam file."""
    monkeypatch.chdir(tmp_path)
    Path("beam.toml").write_text(EXAMPLE.read_text())
    return tmp_path


@pytest.fixture(scope="module")
def made(tmp_path_factory, stores):
    """A folder with a beam file, the stores beside it, and some that are no good."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        spoil(stores)
    return folder


@pytest.fixture
def still(made, monkeypatch):
    """The folder itself, for commands that are refused, which change no file of it."""
    monkeypatch.chdir(made)


@pytest.fixture
def place(made, tmp_path, monkeypatch):
    """A copy of the folder."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def spoil(stores):
    """Copy stores, and damage copies of them."""
    Path("beam.toml").write_text(EXAMPLE.read_text())
    for store in stores.iterdir():
        shutil.copytree(store, store.name)
    shutil.copytree("map.zarr", "damaged.zarr")
    shutil.copytree("map.zarr", "holed.zarr")
    shutil.copytree("map.zarr", "bent.zarr")
    shutil.copytree("map.zarr", "gone.zarr")
    shutil.copytree("map.zarr", "swapped.zarr")
    Path("swapped.zarr/RED/c.0.0").rename("chunk")
    Path("swapped.zarr/RED/c.1.0").rename("swapped.zarr/RED/c.0.0")
    Path("chunk").rename("swapped.zarr/RED/c.1.0")
    shutil.copytree("half.zarr", "closed.zarr")
    Path("damaged.zarr/zarr.json").write_text(Path("damaged.zarr/zarr.json").read_text().replace('"mu', '"mo', 3))
    Path("holed.zarr/RED/c.0.0").unlink()
    chunk = Path("bent.zarr/RED/c.0.0")
    chunk.write_bytes(chunk.read_bytes()[:-9] + b"123456789")
    Path("gone.zarr/zarr.json").unlink()
    shutil.copytree("map.zarr", "blank.zarr")
    Path("blank.zarr/status/c.0.0").write_bytes(b"")
    shutil.copytree("map.zarr", "folder.zarr")
    Path("folder.zarr/RED/c.0.0").unlink()
    Path("folder.zarr/RED/c.0.0").mkdir()
    shutil.copytree("map.zarr", "bare.zarr")
    shutil.rmtree("bare.zarr/status")
    Path("closed.zarr/RED").chmod(0o555)
    Path("foreign.zarr").mkdir()
    Path("foreign.zarr/zarr.json").write_text('{"zarr_format": 3, "node_type": "group", "attributes": {}}')
    Path("empty.zarr").mkdir()
    Path("file.zarr").write_text("old")
    Path("old.csv").write_text("old")
    Path("sealed").mkdir(mode=0o555)


RANGES = [
    ("mu=0:2:0", ["--over mu = 0:2:0", "count", "from 2 to"]),
    ("mu=0:2:1", ["--over mu = 0:2:1", "count", "from 2 to"]),
    ("mu=0:2:-3", ["count", "from 2 to"]),
    ("mu=0:2:2.5", ["2.5", "whole number"]),
    ("mu=0:2:1e9", ["whole number from 2 to 10000000"]),
    ("mu=0:2:many", ['"many"', "whole number"]),
    ("mu=0:2:nan", ["whole number"]),
    ("mu=2:0:401", ["runs downwards", "write 0:2:401"]),
    ("mu=1:1:5", ["begins where it ends"]),
    ("mu=1:1.0000000000000002:9", ["narrower"]),
    ("mu=0:2", ["is no range low:high:count", "0.2:0.4:401"]),
    ("mu=0:2:5:7", ["is no range low:high:count"]),
    ("mu=:2:5", ["is no range low:high:count"]),
    ("mu=0,1:2:5", ["is no range low:high:count"]),
    ("mu=0.3", ["is one value, no range"]),
    ("mu=0.3,0.2", ["does not increase"]),
    ("mu=0.3,0.3", ["does not increase"]),
    ("mu=0.3,,0.4", ['--over mu = "": is not a plain number']),
    ("mu=a:b:5", ['--over mu = "a"', "is not a plain number"]),
    ("mu=0:nan:5", ['"nan"', "is not a plain number"]),
    ("mu=0:1e999:5", ["is not a finite number"]),
    ("mu=-1:1:5", ['"-1"', "0 to 10"]),
    ("mu=0:11:5", ['"11"', "0 to 10"]),
    ("mu=0deg:1deg:5", ["is an angle, but a plain number"]),
    ("alpha=15:75:5", ['--over alpha = "15"', "has no unit", '"15 deg"']),
    ("alpha=15mm:75mm:5", ["is a length, but an angle"]),
    ("alpha=15deg:95deg:5", ['"95deg"', "0 or more, below 90 deg"]),
    ("alpha=-1deg:45deg:5", ["0 or more, below 90 deg"]),
    ("scale.alpha=-1deg:45deg:5", ["--over scale.alpha", "below 90 deg"]),
    ("margin=0:0.1:5", ["1e-9"]),
    ("scale.length=0mm:60mm:5", ["more than 0"]),
    ("beam.pitch=10:20:5", ['"10 mm"']),
    ("joint.stiffness=1mm:2mm:5", ["is a length, but a torque"]),
    ("alfa=0:1:5", ["--over alfa", "is no parameter", "did you mean alpha?", "allowed: eta, beta"]),
    ("length=1mm:2mm:5", ["did you mean scale.length?"]),
    ("scale.lenght=1mm:2mm:5", ["did you mean scale.length?"]),
    ("width=1mm:2mm:5", ["did you mean scale.width or substrate.width?"]),
    ("beam.scales=2:20:5", ["--over beam.scales", "changes nothing"]),
    ("law=edge,plate", ["--law edge,plate"]),
    ("=0:1:5", ["is not name=low:high:count"]),
    ("mu", ["is not name=low:high:count"]),
    (
        "theta0=5deg:89deg:5",
        ["theta0 = 5 deg to 89 deg", "some cells are no valid beam", "at theta0 = 89 deg", "the tab"],
    ),
    ("zeta=0.1:100:5", ["zeta = 0.1 to 100", "some cells are no valid beam", "at zeta = 100"]),
    ("eta=1:1e9:5", ["--over eta =", "is out of range (more than 0, up to 100); write e.g. 3"]),
    ("scale.length=1mm:1000km:5", ["some cells are no valid beam", "eta = l/d = 5e+07", "up to 100; write at most"]),
    ("beam.pitch=1um:20mm:5", ["some cells are no valid beam", "eta = l/d", "beta = b/d"]),
]


@pytest.mark.parametrize(("over", "words"), RANGES, ids=lambda v: str(v)[:30])
def test_ranges(over, words, bench, capsys):
    thick = ["--set", "scale.embedded=16.5 mm"] if over.startswith("theta0") else []
    hinged = ["--joint", "hinge"] if over.startswith("margin") else []
    refused(["sweep", "beam.toml", "--over", over, "-o", "new.zarr", *thick, *hinged], [words], capsys)


FLAGS = [
    ([], ["--over: is missing"]),
    (["--over", "mu=0:1:5", "--over", "mu=0:2:5"], ["--over mu: is given twice"]),
    (["--over", "alpha=15deg:75deg:5", "--over", "scale.alpha=15deg:75deg:5"], ["scale.alpha: is given twice"]),
    (["--over", "lam=0.2:0.4:5", "--over", "beam.pitch=15mm:20mm:5"], ["lam changes beam.pitch too"]),
    (["--over", "eta=2:4:5", "--over", "scale.length=50mm:60mm:5"], ["eta changes scale.length too"]),
    (["--over", "mu=0:1:5", "--law", "smooth"], ["--law", "smooth", "edge"]),
    (["--over", "mu=0:1:5", "--law", "edge,edge"], ["--law", "give each law once"]),
    (["--over", "mu=0:1:5", "--sense", "left"], ["--sense", "left"]),
    (["--over", "mu=0:1:5", "--load", "pulling"], ["--load", "pulling"]),
    (["--over", "mu=0:1:5", "--engine", "steam"], ["--engine"]),
    (["--over", "mu=0:1:5", "--mu", "0.3"], ["--mu: mu is swept too"]),
    (["--over", "mu=0:1:5", "--margin", "2"], ["--margin", "below 1"]),
    (["--over", "mu=0:1:5", "--tile", "0"], ["--tile"]),
    (["--over", "mu=0:1:5", "--tile", "1.5"], ["--tile", "whole number"]),
    (["--over", "mu=0:1:5", "--shard", "5/4"], ["--shard", "from 1/4 to 4/4"]),
    (["--over", "mu=0:1:5", "--shard", "0/4"], ["--shard", "the first is 1"]),
    (["--over", "mu=0:1:5", "--shard", "four"], ["--shard", "1/4"]),
    (["--over", "mu=0:1:5", "--dask", "local"], ["--dask", "local:2"]),
    (["--over", "mu=0:1:5", "--dask", "local:0"], ["--dask", "local:2"]),
    (["--over", "mu=0:1:5", "--dask", "http://host"], ["--dask", "tcp://"]),
    (["--over", "mu=0:1:5", "--progress", "loud"], ["--progress", "bar, json or none"]),
    (["--over", "mu=0:1:5", "--set", "scale.alpha=45 mm"], ["--set scale.alpha", "is a length"]),
    (["--over", "mu=0:10:10000", "--over", "eta=2:3:1000", "--tile", "1"], ["--tile", "10,000,000 tiles"]),
]


@pytest.mark.parametrize(("flags", "words"), FLAGS, ids=lambda v: " ".join(v)[-40:])
def test_flags(flags, words, bench, capsys):
    refused(["sweep", "beam.toml", "-o", "new.zarr", *flags], [words], capsys)


PLACES = [
    ("foreign.zarr", ["foreign.zarr: is no store that squama sweep has written"]),
    ("empty.zarr", ["is no store that squama sweep has written"]),
    ("file.zarr", ["is no store that squama sweep has written"]),
    ("damaged.zarr", ["damaged.zarr: is damaged"]),
    ("gone.zarr", ["is damaged", "zarr.json"]),
    ("bare.zarr", ["is damaged", "status"]),
    ("folder.zarr", ["is damaged (tile 0.0: RED/c.0.0 is a folder)"]),
    ("closed.zarr", ["is read-only"]),
    ("sealed/new.zarr", ["sealed is read-only"]),
    ("nowhere/new.zarr", ["does not exist"]),
    ("new", ["extension .zarr"]),
    ("", ["--out: is empty"]),
    ("new.nc", ["extension .zarr"]),
]
SAME = ["sweep", "beam.toml", "--joint", "hinge", "--over", "mu=0:2:9", "--over", "alpha=15deg:75deg:7", "--tile", "20"]


@pytest.mark.parametrize(("out", "words"), PLACES, ids=lambda v: str(v)[:20])
def test_stores_that_cannot_be_used(out, words, still, capsys):
    refused([*SAME, "-o", out], [words], capsys)


DIFFERENCES = [
    (["--margin", "0.1"], ["margin 0.01 against 0.1"]),
    (["--law", "plate"], ["law edge against plate"]),
    (["--sense", "-"], ["sense + against -"]),
    (["--set", "scale.length=50 mm"], ["scale.length 60 mm against 50 mm"]),
    (
        ["--set", "joint.stiffness=0.02 N m", "--margin", "0.1"],
        ["joint.stiffness not given against 20 N mm", "margin 0.01"],
    ),
    (["--over", "eta=2:3:4"], ["over mu, alpha against mu, alpha, eta"]),
]


@pytest.mark.parametrize(("flags", "words"), DIFFERENCES, ids=lambda v: " ".join(v)[:40])
def test_another_configuration_is_refused(flags, words, still, capsys):
    refused([*SAME, *flags, "-o", "half.zarr"], [["half.zarr: belongs to another sweep", *words]], capsys)


def test_another_range_is_refused(still, capsys):
    other = [word.replace("mu=0:2:9", "mu=0:3:9") for word in SAME]
    refused([*other, "-o", "half.zarr"], [["over mu = 0 to 2 (9 values) against mu = 0 to 3 (9 values)"]], capsys)


ANEW = "; run the same sweep again: it does this tile anew"
LOCK = ["map.zarr", "--plot", "a.png", "--variable", "lock"]
MAPS = [
    (["map.zarr"], ["nothing to write"]),
    (["map.zarr", "--plot", "a.gif"], ["a.gif", ".png"]),
    (["map.zarr", "--csv", "a.txt"], ["a.txt", ".csv"]),
    (["map.zarr", "--plot", "a.png", "--plot", "./a.png"], ["is given twice"]),
    (["none.zarr", "--csv", "a.csv"], ["none.zarr: no such store"]),
    (["foreign.zarr", "--csv", "a.csv"], ["is no store"]),
    (["file.zarr", "--csv", "a.csv"], ["is no store"]),
    (["damaged.zarr", "--csv", "old.csv"], ["is damaged"]),
    (["holed.zarr", "--csv", "old.csv"], ["is damaged (tile 0.0: RED/c.0.0 is missing); run the same sweep again"]),
    (["bent.zarr", "--csv", "old.csv"], ["is damaged (tile 0.0: RED/c.0.0 does not fit its checksum)", ANEW]),
    (["swapped.zarr", "--csv", "old.csv"], ["is damaged (tile ", "does not fit the checksum of its place)", ANEW]),
    (["swapped.zarr", "--plot", "a.png"], ["is damaged (tile ", "does not fit the checksum of its place)"]),
    (["bent.zarr", "--plot", "a.png"], ["is damaged", "checksum"]),
    (["blank.zarr", "--plot", "a.png"], ["is damaged", "checksum"]),
    (["bare.zarr", "--plot", "a.png"], ["is damaged", "status"]),
    (["map.zarr", "--csv", "a.csv", "--variable", "red"], ["--variable", "RED"]),
    (["map.zarr", "--csv", "a.csv", "--x", "eta"], ["--x = eta", "no dimension of this sweep", "mu, alpha"]),
    (["map.zarr", "--csv", "a.csv", "--x", "alfa"], ["did you mean alpha?"]),
    (["map.zarr", "--csv", "a.csv", "--x", "mu", "--y", "mu"], ["mu: is used twice"]),
    (["map.zarr", "--csv", "a.csv", "--at", "mu=3"], ["--at mu = 3", "it has 0 to 2"]),
    (["map.zarr", "--csv", "a.csv", "--at", "alpha=30"], ["alpha", "has no unit"]),
    (["map.zarr", "--csv", "a.csv", "--at", "alpha"], ["--at", "name=value"]),
    (["map.zarr", "--csv", "a.csv", "--at", "mu=1", "--at", "mu=2"], ["--at mu: is given twice"]),
    (["map.zarr", "--csv", "a.csv", "--at", "mu=1", "--at", "alpha=30deg"], ["no dimension is left for x"]),
    (["map.zarr", "--csv", "a.csv", "--panels", "mu"], ["9 values", "6 panels at most"]),
    (["map.zarr", "--plot", "a.png", "--lines", "0.1"], ["--lines", "--variable lock"]),
    ([*LOCK, "--lines", "3"], ["--lines mu = 3", "it has 0 to 2"]),
    ([*LOCK, "--paths", "3"], ['--paths alpha = "3"', "has no unit"]),
    ([*LOCK, "--paths", "30deg,,45deg"], ['--paths alpha = ""']),
    (["map.zarr", "--plot", "a.png", "--paths", "30deg"], ["--paths", "--variable lock"]),
    (["map.zarr", "--plot", "a.png", "--variable", "lock", "--x", "mu", "--y", "alpha", "--paths", "1"], ["y = mu"]),
    (["four.zarr", "--csv", "a.csv"], ["is neither shown nor held"]),
    (["four.zarr", "--csv", "a.csv", "--at", "law=smooth"], ["law", "edge or plate"]),
    (["line.zarr", "--plot", "a.png", "--variable", "lock"], ["two dimensions"]),
]


@pytest.mark.parametrize(("arguments", "words"), MAPS, ids=lambda v: " ".join(v)[:40])
def test_maps_that_cannot_be_drawn(arguments, words, still, capsys):
    refused(["map", *arguments], [words], capsys)


HELD = ["--at", "law=edge", "--at", "eta=3", "--x", "alpha", "--y", "mu", "--panels", "margin"]
PICTURES = [
    ["map.zarr"],
    ["map.zarr", "--variable", "end"],
    ["map.zarr", "--variable", "torque", "--x", "mu", "--y", "alpha"],
    ["map.zarr", "--variable", "phi_end"],
    ["map.zarr", "--variable", "lock", "--lines", "0,0.5,2"],
    [*LOCK[:1], *LOCK[3:], "--paths", "30 deg, 45deg"],
    ["four.zarr", *LOCK[3:], "--x", "alpha", "--y", "mu", "--at", "eta=3", "--at", "margin=0.1", "--paths", "40deg"],
    ["map.zarr", "--at", "mu=0.5"],
    ["line.zarr", "--variable", "theta_end"],
    ["line.zarr", "--variable", "end"],
    ["four.zarr", *HELD],
    ["four.zarr", "--variable", "end", "--at", "eta=2.9", "--at", "margin=0.01"],
    ["four.zarr", "--variable", "lock", "--at", "margin=0.01", "--at", "mu=1", "--x", "alpha", "--y", "eta"],
    ["half.zarr", "--variable", "neighbour"],
]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("arguments", PICTURES, ids=" ".join)
def test_pictures(arguments, place, capsys):
    assert main(["map", *arguments, "--plot", "a.png"]) == 0
    said = capsys.readouterr().out
    assert said.splitlines()[-1] == "wrote a.png"
    assert ("not computed" in said) == (arguments[0] == "half.zarr")
    assert Path("a.png").stat().st_size > 8000


def test_csv_of_a_slice(place, capsys):
    assert main(["map", "four.zarr", *HELD, "--csv", "a.csv"]) == 0
    rows = list(csv.reader(line for line in Path("a.csv").read_text().splitlines() if not line.startswith("#")))
    assert rows[0][:5] == ["mu (1)", "alpha (rad)", "margin (1)", "phi_e (rad)", "theta_end (rad)"]
    assert "torque (N m)" in rows[0]
    assert len(rows) == 1 + 5 * 4 * 3
    data = squama.read("a.csv")
    whole = squama.open_sweep("four.zarr").sel(law="edge", eta=3.0)
    assert np.array_equal(data.RED.values, whole.RED.transpose(*data.RED.dims).values)
    assert set(np.unique(data.end)) <= {str(end) for end in squama.End}


def test_what_a_sweep_says(place, capsys):
    assert main([*SAME, "-o", "new.zarr", "--json", "--progress", "json"]) == 0
    captured = capsys.readouterr()
    said = json.loads(captured.out)
    assert (said["cells"], said["tiles"], said["tiles_done"]) == (63, 4, 4)
    lines = [json.loads(line) for line in captured.err.splitlines()]
    assert [line["tiles_done"] for line in lines] == [0, 1, 2, 3, 4]
    assert lines[0]["left_s"] is None
    assert lines[-1]["left_s"] == 0
    assert main([*SAME, "-o", "half.zarr", "--shard", "1/2", "--progress", "bar"]) == 0
    assert "shard 1/2 is done; 2 of 4 tiles are done" in capsys.readouterr().out
    assert main([*SAME, "-o", "half.zarr"]) == 0
    assert capsys.readouterr().out.startswith("beam.toml: all 63 beams are computed (9 mu x 7 alpha)")


def test_other_tiles_are_refused(still, capsys):
    refused([*SAME[:-1], "7", "-o", "half.zarr"], [["half.zarr: belongs to another sweep: tile "]], capsys)


def test_a_finished_store_may_be_read_only(place):
    for path in (Path("map.zarr"), *Path("map.zarr").iterdir()):
        path.chmod(0o555 if path.is_dir() else 0o444)
    assert main([*SAME, "-o", "map.zarr"]) == 0
    assert main(["map", "map.zarr", "--csv", "a.csv"]) == 0


def test_nothing_answers_at_the_address(monkeypatch):
    distributed = pytest.importorskip("distributed")

    def nobody(*_, **__):
        raise OSError

    monkeypatch.setattr(distributed, "Client", nobody)
    monkeypatch.setattr(cluster, "WAIT", 0.1)
    with pytest.raises(squama.InputError, match="no scheduler answers"), cluster.client("tcp://127.0.0.1:9"):
        pass


def test_a_map_as_json(place, capsys):
    assert main(["map", "half.zarr", "--csv", "a.csv", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["file"], told["x"], told["y"], told["written"]) == ("half.zarr", "alpha", "mu", ["a.csv"])
    assert 0 < told["tiles_missing"] < told["tiles"]
