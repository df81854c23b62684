"""Sweeps that are stopped: SIGKILL at any moment, Ctrl-C, a full disk, a dead worker; the result is always the same."""

import errno
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from zarr.storage import _local as zarr_files

import squama
from squama.cli import main
from squama.errors import InputError
from squama.study import store, sweeping
from squama.study.sweeping import make_plan, run

BEAM = squama.Beam.from_ratios()
ARGUMENTS = [
    "sweep",
    "beam.toml",
    "--joint",
    "hinge",
    "--over",
    "mu=0:2:24",
    "--over",
    "alpha=15deg:75deg:24",
    "--tile",
    "36",
]


def contents(store):
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(Path(store).rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    BEAM.to_toml(folder / "beam.toml")
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert main([*ARGUMENTS, "-o", "map.zarr"]) == 0
    finally:
        os.chdir(before)
    return contents(folder / "map.zarr")


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    BEAM.to_toml("beam.toml")
    return tmp_path


# No tile is begun once so many are done, until there is a file "go": what is stopped can't have ended before.
_HELD = """
import sys, time
from pathlib import Path
from squama.cli import main
from squama.study import sweeping

solve = sweeping.one_tile

def held(store, tile, *values):
    while len(list(Path(store, "status").glob("c.*[0-9]"))) >= most and not Path(store).with_name("go").exists():
        time.sleep(0.01)
    return solve(store, tile, *values)

if __name__ == "__main__":
    most = int(sys.argv[1])
    sweeping.one_tile = held
    sys.exit(main(sys.argv[2:]))
"""


def start(*more, **options):
    command = [sys.executable, "-m", "squama", *ARGUMENTS, "-o", "map.zarr", *more]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **options)


def start_held(most, *more, **options):
    """Start a sweep that waits when so many of its tiles are done."""
    Path("held.py").write_text(_HELD)
    command = [sys.executable, "held.py", str(most), *ARGUMENTS, "-o", "map.zarr", "--progress", "json", *more]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **options)


def wait_for_tiles(process, count):
    """Read the lines of --progress json until so many tiles are done."""
    for line in process.stderr:
        if f'"tiles_done": {count},' in line:
            return
    pytest.fail(f"ended before {count} tiles were done")


@pytest.mark.slow
def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(place, undisturbed):
    dice = random.Random(20)
    for round_ in range(3):
        process = start_held(5 * round_ + 5)
        wait_for_tiles(process, 5 * round_ + 1)
        time.sleep(dice.uniform(0, 0.15))
        process.kill()
        process.wait()
        process.stderr.close()
        assert process.returncode == -signal.SIGKILL
        done = store.prepare(Path("map.zarr"), store.read_plan(Path("map.zarr")))
        assert 0 < done.sum() < done.size
    assert main([*ARGUMENTS, "-o", "map.zarr"]) == 0
    assert contents("map.zarr") == undisturbed


STEPS = ((zarr_files, "_put"), (Path, "replace"), (store, "flush"), (os, "fsync"), (Path, "unlink"))
"""What changes the disk while a tile is written: a new file, its move, what waits for the disk, the end of a claim."""


def _dying(n):
    """Make functions that can be called n times in all; then the process ends."""
    steps = iter(range(n))

    def step(original):
        def wrapped(*arguments, **options):
            if next(steps, None) is None:
                os.kill(os.getpid(), signal.SIGKILL)
            return original(*arguments, **options)

        return wrapped

    return step


@pytest.mark.slow
def test_killed_between_any_two_steps_of_writing(place, undisturbed, monkeypatch):
    """The process ends without a word before the n-th change of the disk, all through the writing of a tile."""
    plan = make_plan(BEAM, {"mu": (0, 2, 24), "alpha": ("15 deg", "75 deg", 24)}, tile=36, joint="hinge")
    path = Path("map.zarr")
    store.prepare(path, plan)
    todo = plan.tiles()
    tile = next(todo)
    for n in range(0, 90, 3):
        child = os.fork()
        if child == 0:
            step = _dying(n)
            for home, name in STEPS:
                setattr(home, name, step(getattr(home, name)))
            sweeping.one_tile(str(path), tile)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        marked = (path / "status" / store.key(tile)).exists()
        if os.WIFEXITED(status):
            assert marked
            break
        assert store.check(path, plan)[tile] == marked
        tile = next(todo) if marked else tile
    else:
        pytest.fail("the writing of a tile takes more steps than were tried")
    assert n > 60
    assert list(path.rglob("*.partial"))
    run(plan, path)
    assert contents(path) == undisturbed


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("more", [[], ["--dask", "local:1"]], ids=["alone", "dask"])
def test_ctrl_c_stops_after_the_running_tile(more, place, undisturbed):
    process = start_held(3, *more, start_new_session=True)
    wait_for_tiles(process, 2)
    # a terminal tells every process of the command
    os.killpg(process.pid, signal.SIGINT)
    time.sleep(0.3)
    Path("go").touch()
    said = process.communicate(timeout=60)[1].splitlines()
    assert process.returncode == 130
    assert said[-1].startswith("squama: map.zarr: stopped after ")
    assert said[-1].endswith("tiles; the same command goes on from there")
    assert not list(Path("map.zarr").rglob("*.partial"))
    assert main([*ARGUMENTS, "-o", "map.zarr"]) == 0
    assert contents("map.zarr") == undisturbed


@pytest.mark.slow
def test_two_runs_at_once_share_the_tiles(place, undisturbed):
    runs = [start("--progress", "none") for _ in range(2)]
    for process in runs:
        assert process.communicate(timeout=60)[1] == ""
        assert process.returncode == 0
    assert contents("map.zarr") == undisturbed


def test_a_tile_that_another_process_has_is_left_to_it(place):
    plan = make_plan(BEAM, {"mu": (0, 1, 4)}, tile=2, joint="hinge")
    store.prepare(Path("map.zarr"), plan)
    writer = store.Writer(Path("map.zarr"), plan)
    with writer.claim((0,)) as mine, writer.claim((0,)) as second:
        assert mine
        assert not second
        assert run(plan, Path("map.zarr")) == (1, 2)
        writer.write((0,), sweeping.compute(plan, (0,)))
    with writer.claim((0,)) as again:
        assert not again
    assert run(plan, Path("map.zarr")) == (2, 2)
    assert not list(Path("map.zarr").rglob("*.partial"))


def test_what_the_dead_have_left_is_swept_when_no_writer_lives(place):
    plan, path = make_plan(BEAM, {"mu": (0, 1, 4)}, tile=2, joint="hinge"), Path("map.zarr")
    store.prepare(path, plan)
    sweeping.one_tile(str(path), (0,))
    whole = contents(path)
    for name in ("RED/c.9a.partial", "status/c.9b.partial", "status/c.1.partial"):
        (path / name).write_bytes(b"half")
    # the mark of a tile whose data were lost with the power of the machine
    (path / "status/c.1").touch()
    with store.Writer(path, plan).claim((1,)):
        store.sweep_orphans(path, plan)
        assert (path / "RED/c.9a.partial").exists()
    assert store.prepare(path, plan).tolist() == [True, False]
    assert contents(path) == whole


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("step", [0, 12, 25, 62, 65])
def test_a_full_disk_leaves_the_store_as_it_was(step, place, undisturbed, monkeypatch, capsys):
    plan = make_plan(BEAM, {"mu": (0, 2, 24), "alpha": ("15 deg", "75 deg", 24)}, tile=36, joint="hinge")
    store.prepare(Path("map.zarr"), plan)
    assert sweeping.one_tile("map.zarr", next(plan.tiles()))
    before = contents("map.zarr")
    room = iter(range(step))

    def full(original):
        def wrapped(*arguments, **options):
            if next(room, None) is None:
                raise OSError(errno.ENOSPC, "No space left on device")
            return original(*arguments, **options)

        return wrapped

    with monkeypatch.context() as patch:
        for home, name in STEPS[:-1]:
            patch.setattr(home, name, full(getattr(home, name)))
        assert main([*ARGUMENTS, "-o", "map.zarr", "--progress", "none"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert said == [
        "squama: error: map.zarr: the disk is full; make room and run the same command again, finished tiles are kept"
    ]
    assert contents("map.zarr") == before
    assert main([*ARGUMENTS, "-o", "map.zarr"]) == 0
    assert contents("map.zarr") == undisturbed


def test_a_full_disk_when_the_store_is_made_leaves_nothing(place, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(store, "flush", full)
    with pytest.raises(InputError, match="the disk is full"):
        squama.sweep(BEAM, {"mu": (0, 1, 3)}, out="map.zarr", joint="hinge")
    assert sorted(p.name for p in Path().iterdir()) == ["beam.toml"]


@pytest.mark.slow
def test_killed_while_the_store_is_made_it_leaves_nothing_for_long(place, undisturbed):
    made = """
import os, signal, sys
from squama.study import store
from squama.cli import main
steps = iter(range(int(sys.argv[1])))
flush = store.flush
def dying(place):
    if next(steps, None) is None:
        os.kill(os.getpid(), signal.SIGKILL)
    flush(place)
store.flush = dying
main(sys.argv[2:])
"""
    others = [".map.zarr.0123456789abc.new", ".map.zarr.new", ".other.zarr.0123456789ab.new"]
    for name in others:
        Path(name).mkdir()
    for step in (0, 9, 20):
        command = [sys.executable, "-c", made, str(step), *ARGUMENTS, "-o", "map.zarr"]
        done = subprocess.run(command, check=False, capture_output=True, timeout=60)
        assert done.returncode == -signal.SIGKILL
        assert not Path("map.zarr").exists()
        # that of this run; it has taken away that of the one before
        assert len([p for p in place.glob(".*") if p.name not in others]) == 1
    assert main([*ARGUMENTS, "-o", "map.zarr"]) == 0
    assert contents("map.zarr") == undisturbed
    assert sorted(p.name for p in place.glob(".*")) == others


def test_a_store_that_lacks_an_axis_is_not_gone_on_with(tmp_path):
    plan, path = make_plan(BEAM, {"mu": (0, 1, 3)}, joint="hinge"), tmp_path / "map.zarr"
    store.prepare(path, plan)
    shutil.rmtree(path / "mu")
    with pytest.raises(InputError, match=r"is damaged \(mu\)"):
        store.prepare(path, plan)


def test_leftovers_are_cleared_away_and_nothing_else(tmp_path):
    others = [".map.zarr.0123456789abc.new", ".map.zarr.new", ".other.zarr.0123456789ab.new"]
    for name in (*others, ".map.zarr.0123456789ab.new"):
        (tmp_path / name).mkdir()
    (tmp_path / ".map.zarr.aaaaaaaaaaaa.new").symlink_to(others[0])
    store._clear(tmp_path / "map.zarr")
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([*others, ".map.zarr.aaaaaaaaaaaa.new"])


@pytest.mark.slow
def test_what_a_living_process_makes_is_left_to_it(place, undisturbed, monkeypatch):
    fill, seen = store.fill, []

    def meanwhile(beside, plan):
        fill(beside, plan)
        if not seen:
            # another run of the same sweep is quicker, and looks for leftovers
            seen.append(beside)
            command = [sys.executable, "-m", "squama", *ARGUMENTS, "-o", "map.zarr"]
            subprocess.run(command, check=True, capture_output=True, timeout=60)
            assert beside.is_dir()

    monkeypatch.setattr(store, "fill", meanwhile)
    assert main([*ARGUMENTS, "-o", "map.zarr"]) == 0
    assert seen
    assert contents("map.zarr") == undisturbed
    assert sorted(p.name for p in place.iterdir()) == ["beam.toml", "map.zarr"]


def test_a_folder_that_is_taken_away_while_it_is_filled_is_made_again(place, undisturbed, monkeypatch):
    fill, seen = store.fill, []

    def meanwhile(beside, plan):
        if not seen:
            seen.append(beside)
            beside.rmdir()
            raise FileNotFoundError
        fill(beside, plan)

    monkeypatch.setattr(store, "fill", meanwhile)
    assert main([*ARGUMENTS, "-o", "map.zarr"]) == 0
    assert contents("map.zarr") == undisturbed


_WORKER_DIES = """
import os, signal, sys, threading, time
from pathlib import Path
import distributed
import squama
from squama.study import store, sweeping

def kill_one(client):
    while len(list(Path("map.zarr/status").glob("c.?.?"))) < 3:
        time.sleep(0.02)
    pid = next(iter(client.run(os.getpid).values()))
    os.kill(pid, signal.SIGKILL)
    print("killed", flush=True)

if __name__ == "__main__":
    beam = squama.Beam.from_toml("beam.toml")
    plan = sweeping.make_plan(beam, {"mu": (0, 2, 24), "alpha": ("15 deg", "75 deg", 24)}, tile=36, joint="hinge")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        with distributed.Client(cluster) as client:
            killer = threading.Thread(target=kill_one, args=(client,))
            killer.start()
            done = sweeping.run(plan, Path("map.zarr"), dask=client)
            killer.join()
            print(*done)
"""


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_its_tile_only(place, undisturbed):
    Path("job.py").write_text(_WORKER_DIES)
    done = subprocess.run([sys.executable, "job.py"], capture_output=True, text=True, check=False, timeout=120)
    assert done.stdout.split() == ["killed", "16", "16"], done.stderr
    assert contents("map.zarr") == undisturbed
