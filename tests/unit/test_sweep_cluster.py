"""Sweeps on a scheduler at an address: a real one with a worker of its own, one that goes, and none."""

import contextlib
import json
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import squama
from squama.cli import main
from squama.errors import InputError
from squama.study import cluster, store, sweeping

pytest.importorskip("distributed")

ARGUMENTS = [
    "sweep",
    "beam.toml",
    "--joint",
    "hinge",
    "--over",
    "mu=0:2:12",
    "--over",
    "alpha=15deg:75deg:12",
    "--tile",
    "36",
]
LONG = 120
"""Seconds after which a test gives up; nothing is measured against it."""

# No tile is begun once two are done, until there is a file "go".
_HELD = """
import time
from pathlib import Path
from squama.study import sweeping

def held(store, tile):
    while len(list(Path(store, "status").glob("c.*[0-9]"))) >= 2 and not Path(store).with_name("go").exists():
        time.sleep(0.01)
    return sweeping.not_held(store, tile)

# a worker may load this twice
if not hasattr(sweeping, "not_held"):
    sweeping.not_held, sweeping.one_tile = sweeping.one_tile, held
"""


def contents(store):
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(Path(store).rglob("*")) if p.is_file()}


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    squama.Beam.from_ratios().to_toml("beam.toml")
    return tmp_path


@contextlib.contextmanager
def running(module, *arguments):
    """Run a command of dask in a process group of its own, and end all of it."""
    command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
    with Path(f"{module}.log").open("wb") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True)
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@contextlib.contextmanager
def scheduler():
    """Run a scheduler at a port that is free; yield its address and its process."""
    told = Path("scheduler.json").absolute()
    where = ("--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(told))
    with running("dask_scheduler", *where, "--no-dashboard") as process:
        end = time.monotonic() + LONG
        address = None
        while address is None:
            assert process.poll() is None, Path("dask_scheduler.log").read_text()
            assert time.monotonic() < end
            time.sleep(0.05)
            with contextlib.suppress(OSError, ValueError):
                address = json.loads(told.read_text())["address"]
        yield address, process


def worker(address, *more):
    """Run a worker with one thread; one that has no scheduler any more ends."""
    arguments = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", str(LONG))
    return running("dask_worker", address, *arguments, "--local-directory", str(Path("scratch").absolute()), *more)


def run(*more):
    """Run the sweep in another process; return exit status, output and lines of the error stream."""
    command = [sys.executable, "-m", "squama", *ARGUMENTS, "-o", "map.zarr", *more]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONG)
    return done.returncode, done.stdout, done.stderr.splitlines()


@pytest.mark.slow
def test_a_scheduler_at_an_address_gives_the_same_bytes(place):
    assert main([*ARGUMENTS, "-o", "alone.zarr"]) == 0
    # the worker may come before the tiles or after them
    with scheduler() as (address, _), worker(address):
        assert address.startswith("tcp://127.0.0.1:")
        status, said, errors = run("--dask", address)
        assert (status, errors) == (0, []), Path("dask_worker.log").read_text()
        assert said.startswith("beam.toml: all 144 beams are computed (12 mu x 12 alpha)")
        assert contents("map.zarr") == contents("alone.zarr")
        # all is done: no tile is asked for, and nothing is written
        assert run("--dask", address)[0] == 0
    assert contents("map.zarr") == contents("alone.zarr")


@pytest.mark.slow
def test_a_scheduler_that_goes_is_one_line_and_the_rest_can_be_done(place):
    assert main([*ARGUMENTS, "-o", "alone.zarr"]) == 0
    Path("held.py").write_text(_HELD)
    command = [sys.executable, "-m", "squama", *ARGUMENTS, "-o", "map.zarr", "--progress", "json", "--dask"]
    with scheduler() as (address, process), worker(address, "--preload", str(Path("held.py").absolute())):
        with subprocess.Popen([*command, address], stderr=subprocess.PIPE, text=True) as client:
            watch = threading.Timer(LONG, client.kill)
            watch.start()
            try:
                for line in client.stderr:
                    if '"tiles_done": 2,' in line:
                        break
                else:
                    pytest.fail("ended before two tiles were done")
                os.killpg(process.pid, signal.SIGKILL)
                said = client.communicate(timeout=LONG)[1].splitlines()
            finally:
                watch.cancel()
                client.kill()
        assert client.returncode == 2
        assert [line for line in said if not line.startswith("{")] == [
            "squama: error: dask: the scheduler has gone; start it and run the same command again, "
            "finished tiles are kept"
        ]
    plan = store.read_plan(Path("map.zarr"))
    assert store.check(Path("map.zarr"), plan).sum() == 2
    assert run()[0] == 0
    assert contents("map.zarr") == contents("alone.zarr")


def free_port(listens):
    """Return a socket that nobody else can take and that does not answer, and its address."""
    held = socket.socket()
    held.bind(("127.0.0.1", 0))
    if listens:
        held.listen()
    return held, f"tcp://127.0.0.1:{held.getsockname()[1]}"


@pytest.mark.parametrize("listens", [False, True], ids=["refused", "silent"])
def test_an_address_where_no_scheduler_answers_is_one_line_and_leaves_no_store(listens, place, monkeypatch, capfd):
    monkeypatch.setattr(cluster, "WAIT", 0.5)
    held, address = free_port(listens)
    before = set(place.iterdir())
    with held:
        assert main([*ARGUMENTS, "-o", "map.zarr", "--dask", address]) == 2
    said, error = capfd.readouterr()
    assert (said, error.count("\n")) == ("", 1)
    assert error.startswith(f'squama: error: dask = "{address}": no scheduler answers there (')
    assert set(place.iterdir()) == before


def test_a_worker_with_other_versions_writes_nothing(place, monkeypatch):
    plan = sweeping.make_plan(squama.Beam.from_ratios(), {"mu": (0, 1, 4)}, tile=2, joint="hinge")
    Path("elsewhere").mkdir()
    with monkeypatch.context() as there:
        # what is known of a store of the same name in another folder says nothing of this one
        there.chdir("elsewhere")
        store.prepare(Path("map.zarr"), plan)
        assert sweeping.one_tile("map.zarr", (0,))
    store.prepare(Path("map.zarr"), plan)
    before = contents("map.zarr")
    monkeypatch.setattr(sweeping, "versions", lambda: {**plan.versions, "numpy": "1.0"})
    with pytest.raises(
        squama.InputError, match=r"other versions: numpy .* against 1.0 \(stored against the worker's\)"
    ):
        sweeping.one_tile("map.zarr", (0,))
    assert contents("map.zarr") == before


@pytest.mark.parametrize("name", ["batched", "client", "core", "comm.tcp"])
def test_dask_writes_no_lines_of_its_own_beside_ours(name):
    """Which part of it sees first that the scheduler has gone is a matter of luck."""
    logger = logging.getLogger(f"distributed.{name}")
    before = logger.getEffectiveLevel()
    assert before < logging.CRITICAL
    with cluster._silent():
        assert not logger.isEnabledFor(logging.CRITICAL)
    assert logger.getEffectiveLevel() == before


def test_a_call_that_the_scheduler_does_not_take_means_that_it_has_gone(monkeypatch):
    """The client may try to call before it has seen that its own line is cut."""

    class Cut:
        def nthreads(self):
            message = "timed out trying to connect to tcp://127.0.0.1:1 after 30 s"
            raise OSError(message)

    monkeypatch.setattr("distributed.as_completed", list)
    with pytest.raises(InputError, match="the scheduler has gone; start it"):
        cluster.run(Cut(), lambda *_: True, Path("map.zarr"), iter([(0, 0)]), lambda *_: None, lambda: False)
