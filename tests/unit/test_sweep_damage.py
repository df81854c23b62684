"""Damaged stores of sweeps: what is noticed when they are gone on with, opened and read, and what is done anew."""

import json
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

import squama
from squama import needs
from squama.cli import main
from squama.errors import InputError
from squama.study import store, sweeping
from squama.study.plan import VARIABLES
from squama.study.sweeping import make_plan, run

BEAM = squama.Beam.from_ratios()
RANGES = {"mu": (0.0, 2.0, 9), "alpha": ("15 deg", "75 deg", 7)}
PLAN = make_plan(BEAM, RANGES, tile=20, joint="hinge")
ANEW = "; run the same sweep again: it does this tile anew"


def contents(store):
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(Path(store).rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    place = tmp_path_factory.mktemp("finished") / "map.zarr"
    run(PLAN, place)
    return place


@pytest.fixture
def path(finished, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(finished, "map.zarr")
    return Path("map.zarr")


def flip(*places):
    for place in places:
        data = bytearray(place.read_bytes())
        data[len(data) // 2] ^= 4
        place.write_bytes(data)


def cut(place):
    place.write_bytes(place.read_bytes()[:-5])


def empty(place):
    place.write_bytes(b"")


def swap(one, other):
    first, second = one.read_bytes(), other.read_bytes()
    one.write_bytes(second)
    other.write_bytes(first)


def swap_tiles(path):
    """Swap every file of two tiles, the checksums too."""
    for part in (*VARIABLES["hinge", "twisting"], "status"):
        swap(path / part / "c.0.0", path / part / "c.1.0")
    swap(path / "checksums/c.0.0.0", path / "checksums/c.1.0.0")


# what is done to the store, the tiles that are done anew
TILES = {
    "a bit of a chunk": (lambda p: flip(p / "RED/c.0.1"), {"c.0.1"}),
    "bits of two tiles": (lambda p: flip(p / "RED/c.0.1", p / "end/c.1.0"), {"c.0.1", "c.1.0"}),
    "a chunk cut off": (lambda p: cut(p / "neighbour/c.0.1"), {"c.0.1"}),
    "an empty chunk": (lambda p: empty(p / "f0/c.0.1"), {"c.0.1"}),
    "no chunk": (lambda p: (p / "torque/c.1.1").unlink(), {"c.1.1"}),
    "chunks swapped": (lambda p: swap(p / "RED/c.0.1", p / "RED/c.1.1"), {"c.0.1", "c.1.1"}),
    "variables swapped": (lambda p: swap(p / "RED/c.0.1", p / "f0/c.0.1"), {"c.0.1"}),
    "tiles swapped": (swap_tiles, {"c.0.0", "c.1.0"}),
    "a bit of a mark": (lambda p: flip(p / "status/c.0.1"), {"c.0.1"}),
    "a chunk as a mark": (lambda p: shutil.copy(p / "end/c.0.1", p / "status/c.0.1"), {"c.0.1"}),
    "a bit of the checksums": (lambda p: flip(p / "checksums/c.0.1.0"), {"c.0.1"}),
    "no checksums": (lambda p: (p / "checksums/c.0.1.0").unlink(), {"c.0.1"}),
    "checksums swapped": (lambda p: swap(p / "checksums/c.0.1.0", p / "checksums/c.1.1.0"), {"c.0.1", "c.1.1"}),
}


@pytest.mark.parametrize("name", TILES)
def test_a_damaged_tile_is_done_anew_and_no_other(name, path, finished, monkeypatch):
    damage, tiles = TILES[name]
    damage(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError) as caught:
            squama.open_sweep(path).load()
    (problem,) = caught.value.problems
    assert problem.where == "map.zarr"
    assert problem.reason.removeprefix("is damaged (tile ").partition(":")[0] in {t.removeprefix("c.") for t in tiles}
    assert str(caught.value).endswith(ANEW)
    solve, solved = sweeping.compute, set()
    monkeypatch.setattr(sweeping, "compute", lambda plan, tile: (solved.add(store.key(tile)), solve(plan, tile))[1])
    assert run(PLAN, path) == (4, 4)
    assert solved == tiles
    assert contents(path) == contents(finished)


def test_each_shard_mends_its_own_tiles(path, finished):
    flip(path / "RED/c.0.0", path / "RED/c.0.1")
    run(PLAN, path, shard="1/2")
    with pytest.raises(InputError, match=r"tile 0.1: RED/c.0.1 does not fit its checksum"):
        squama.open_sweep(path).RED.load()
    run(PLAN, path, shard="2/2")
    assert contents(path) == contents(finished)


def test_workers_mend_a_store(path, finished):
    distributed = pytest.importorskip("distributed")
    flip(path / "RED/c.0.0", path / "status/c.0.1")
    (path / "end/c.1.1").unlink()
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        assert run(PLAN, path, dask=client) == (4, 4)
    assert contents(path) == contents(finished)


def test_only_what_is_read_is_held_against_its_checksum(path, finished, monkeypatch):
    flip(path / "RED/c.0.1")
    reading, read = Path.read_bytes, []
    monkeypatch.setattr(Path, "read_bytes", lambda self: (read.append(self), reading(self))[1])
    data = squama.open_sweep(path)
    assert not [p for p in read if p.parent.name in VARIABLES["hinge", "twisting"] and p.name.startswith("c.")]
    whole = squama.open_sweep(finished)
    assert np.array_equal(data.torque.values, whole.torque.values)
    assert np.array_equal(data.RED[5:].values, whole.RED[5:].values)
    with pytest.raises(InputError, match=r"^map.zarr: is damaged \(tile 0.1: RED/c.0.1 does not fit its checksum\)"):
        data.RED.load()


def test_a_tile_without_a_mark_is_not_read(path):
    (path / "status/c.0.1").unlink()
    flip(path / "RED/c.0.1")
    data = squama.open_sweep(path).load()
    tile = PLAN.place((0, 1))
    assert int((data.status == 0).sum()) == 1
    assert np.isnan(data.RED.values[tile]).all()
    assert (data.end.values[tile] == -1).all()
    assert int(np.isnan(data.RED).sum()) == PLAN.size((0, 1))


METADATA = ["RED/zarr.json", "status/zarr.json", "checksums/zarr.json", "mu/zarr.json", "mu/c.0"]


@pytest.mark.parametrize("damage", [flip, cut, empty, Path.unlink], ids=lambda f: f.__name__)
@pytest.mark.parametrize("place", METADATA)
def test_what_follows_from_the_plan_is_written_anew(place, damage, path, finished):
    damage(path / place)
    with pytest.raises(InputError, match=r"^map.zarr: is damaged \(.*\); run the same sweep again") as caught:
        squama.open_sweep(path)
    assert place in str(caught.value)
    assert run(PLAN, path) == (4, 4)
    assert contents(path) == contents(finished)


@pytest.mark.parametrize("damage", [flip, cut, empty], ids=lambda f: f.__name__)
def test_without_its_plan_a_store_is_one_line(damage, path):
    damage(path / "zarr.json")
    for call in (lambda: squama.open_sweep(path), lambda: run(PLAN, path)):
        with pytest.raises(InputError, match=r"^map.zarr: is damaged \(.*\); remove it and run the sweep again$"):
            call()


def test_a_store_of_another_layout_is_one_line(path, finished):
    text = (path / "zarr.json").read_text()
    document = json.loads(text)
    document["attributes"]["squama_sweep"] = 1
    (path / "zarr.json").write_text(json.dumps(document))
    for call in (lambda: squama.open_sweep(path), lambda: run(PLAN, path)):
        with pytest.raises(
            InputError, match=r"^map.zarr: was written by another version of squama \(layout 1\); make a"
        ):
            call()
    (path / "zarr.json").write_text(text)
    assert contents(path) == contents(finished)


def _no_extra(*_):
    raise InputError("a sweep needs zarr")


def _no_tile(*_):
    raise InputError("no tile")


@pytest.mark.parametrize("dask", [None, "local:1"])
@pytest.mark.parametrize(
    ("home", "name", "fails"),
    [(store, "need", _no_extra), (sweeping.cluster, "need", _no_extra), (sweeping, "compute", _no_tile)],
    ids=["zarr", "dask", "first tile"],
)
def test_what_cannot_begin_leaves_nothing(home, name, fails, dask, tmp_path, monkeypatch):
    if (home, dask) == (sweeping.cluster, None):
        pytest.skip("is not asked for")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(home, name, fails)
    if home is sweeping:
        # what is started for nothing takes time
        monkeypatch.setattr(sweeping.cluster, "need", needs.need)
    with pytest.raises(InputError):
        run(PLAN, Path("map.zarr"), dask=dask)
    assert list(tmp_path.iterdir()) == []


def test_the_command_mends(path, finished, capsys):
    BEAM.to_toml("beam.toml")
    over = [word for range_ in ("mu=0:2:9", "alpha=15deg:75deg:7") for word in ("--over", range_)]
    # one tile only: of two damaged ones the message names that which is read first
    shutil.copy(path / "RED/c.1.1", path / "RED/c.0.1")
    assert main(["map", "map.zarr", "--csv", "map.csv"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == (
        "squama: error: map.zarr: is damaged (tile 0.1: RED/c.0.1 does not fit the checksum of its place)" + ANEW + "\n"
    )
    assert not Path("map.csv").exists()
    assert main(["sweep", "beam.toml", "--joint", "hinge", *over, "--tile", "20", "-o", "map.zarr"]) == 0
    assert main(["map", "map.zarr", "--csv", "map.csv"]) == 0
    assert contents(path) == contents(finished)
