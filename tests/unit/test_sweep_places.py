"""Stores with loops of links, pipes, devices, folders and foreign arrays: refused by name, at once, or put right."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zarr

import squama
from squama.errors import InputError
from squama.io import files
from squama.study.sweeping import make_plan, run

PLAN = make_plan(squama.Beam.from_ratios(mu=0.3), {"mu": (0.0, 2.0, 3), "eta": (2.0, 4.0, 2)}, tile=3, joint="hinge")
PLACES = ("zarr.json", "RED/zarr.json", "mu/c.0", "status/c.0.0", "RED/c.0.0", "checksums/c.0.0.0")


def loop(place: Path) -> None:
    place.symlink_to(place.name)


def device(place: Path) -> None:
    place.symlink_to("/dev/zero")


def endless(place: Path) -> None:
    """A file of 64 GiB that takes no place on the disk."""
    with place.open("wb") as file:
        file.truncate(2**36)


KINDS: dict[str, Callable[[Path], object]] = {
    "loop": loop, "pipe": os.mkfifo, "device": device, "folder": os.mkdir, "endless": endless
}  # fmt: skip


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("finished") / "map.zarr"
    run(PLAN, place)
    return place


@pytest.fixture
def store(finished: Path, tmp_path: Path) -> Path:
    return shutil.copytree(finished, tmp_path / "map.zarr")


def contents(store: Path) -> dict[str, bytes]:
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(store.rglob("*")) if p.is_file()}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("place", PLACES)
def test_what_is_no_file_is_refused_by_name_or_made_anew(finished: Path, store: Path, place: str, kind: str) -> None:
    (store / place).unlink()
    KINDS[kind](store / place)
    name = place if kind != "folder" or "/c.0.0" in place else place.partition("/")[0]
    if (place, kind) == ("status/c.0.0", "loop"):
        # no mark: the tile is not done yet
        assert int((squama.open_sweep(store).status == 0).sum()) == 1
    else:
        with pytest.raises(InputError) as caught:
            squama.open_sweep(store).load()
        (line,) = str(caught.value).splitlines()
        assert f"{files.label(store)}: is damaged (" in line
        assert name in line
    if place == "zarr.json" or kind == "folder":
        with pytest.raises(InputError, match="remove it and run the") as caught:
            run(PLAN, store)
        assert "\n" not in str(caught.value)
    else:
        run(PLAN, store)
        assert contents(store) == contents(finished)


@pytest.mark.parametrize("kind", ["loop", "pipe", "device"])
def test_what_is_no_store_is_refused_and_left_as_it_is(tmp_path: Path, kind: str) -> None:
    place = tmp_path / "map.zarr"
    KINDS[kind](place)
    said = "is a loop of symbolic links" if kind == "loop" else "is no store that squama sweep has written"
    for door in (lambda: squama.open_sweep(place), lambda: run(PLAN, place)):
        with pytest.raises(InputError, match=f"map.zarr: {said}"):
            door()
    assert [p.name for p in tmp_path.iterdir()] == ["map.zarr"]


def test_foreign_things_in_a_store_do_no_harm(finished: Path, store: Path) -> None:
    wanted = squama.open_sweep(finished).load()
    zarr.open_group(store).create_array("other", data=np.arange(3.0))
    (store / "more").mkdir()
    device(store / "more" / "zarr.json")
    os.mkfifo(store / "a pipe")
    assert squama.open_sweep(store).load().identical(wanted)
    run(PLAN, store)
    assert squama.open_sweep(store).load().identical(wanted)


def test_what_could_not_be_written_anew_is_not_said_to_be(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The sweep itself does not say that the same sweep writes a part anew."""
    (store / "RED" / "zarr.json").write_bytes(b"{}")
    with pytest.raises(InputError, match="run the same sweep again: it writes this anew"):
        squama.open_sweep(store)
    monkeypatch.setattr(Path, "replace", lambda *_: (_ for _ in ()).throw(PermissionError()))
    with pytest.raises(InputError, match=r"is damaged \(RED/zarr.json\); make it writable and run the same sweep"):
        run(PLAN, store)
    monkeypatch.undo()
    run(PLAN, store)
    squama.open_sweep(store).load()
