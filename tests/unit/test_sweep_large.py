"""A sweep that is much larger than memory: its peak memory, time and place on the disk, and its cells."""

import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr

import squama
from squama.study import columns, compliant_columns

BEAM = squama.Beam.from_ratios()
ROOM = 12e9
"""Free bytes on the disk without which the large sweep is not begun; it takes half of them."""

SKIN = squama.Beam.from_toml(Path(__file__).parents[2] / "examples" / "stiff_skin.toml")
CORES, LIMIT = 2, 360
"""A million beams on compliant joints take no more than so many seconds on so many cores."""

# A process between, because a child begins with the peak of the process that forks it.
_MEASURED = """
import resource, subprocess, sys
done = subprocess.run([sys.executable, "-m", "squama", *sys.argv[1:]], stdout=subprocess.DEVNULL)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(used.ru_maxrss / 1024, used.ru_utime + used.ru_stime)
sys.exit(done.returncode)
"""


class Cost(NamedTuple):
    """Peak MB, seconds, seconds of processor time, bytes on the disk."""

    peak: float
    seconds: float
    cpu: float
    size: int

    def __str__(self):
        return (
            f"{self.seconds:.0f} s, {self.cpu:.0f} s of processor time, {self.size / 1e6:.0f} MB on the disk, "
            f"peak {self.peak:.0f} MB"
        )


def sweep(out, *arguments):
    """Run a sweep as a command; return what it takes."""
    start = time.monotonic()
    command = [sys.executable, "-c", _MEASURED, "sweep", "beam.toml", *arguments, "-o", out]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    seconds = time.monotonic() - start
    peak, cpu = map(float, done.stdout.split())
    return Cost(peak, seconds, cpu, sum(p.stat().st_size for p in Path(out).rglob("*") if p.is_file()))


def hinged(n, out):
    """Solve n x n cells over two parameters that both matter."""
    over = ["--over", f"mu=0:2:{n}", "--over", f"alpha=1deg:75deg:{n}"]
    return sweep(out, "--joint", "hinge", *over, "--tile", "65536")


def chosen(out, n, count):
    """Return cells taken at random."""
    data = squama.open_sweep(out)
    assert bool((data.status == 1).all())
    places = np.random.default_rng(8).integers(0, n, (2, count))
    cells = {dim: xr.DataArray(i, dims="cell") for dim, i in zip(data.RED.dims, places, strict=True)}
    assert set(data.RED.sizes.values()) == {n}
    return data.isel(cells).load()


def compare(out, n, count):
    """Compare cells taken at random with the answers of a few cells."""
    some = chosen(out, n, count)
    K, d = BEAM.joint_stiffness, BEAM.pitch
    wanted = squama.solve(
        eta=BEAM.eta,
        beta=BEAM.beta,
        lam=BEAM.lam,
        theta0=BEAM.scale.theta0,
        alpha=some.alpha.values,
        mu=some.mu.values,
        stiffness_ratio=BEAM.torsional_rigidity / (K * d),
    )
    assert np.array_equal(some.end.values, wanted.code)
    assert np.array_equal(some.neighbour.values, wanted.neighbour)
    figures = {
        "phi_e": wanted.load_e,
        "theta_end": wanted.theta_end,
        "phi_end": wanted.load_end,
        "f0": wanted.f0,
        "torque": wanted.torque * K,
        "U_el": wanted.U_el * K / d,
        "W_fr": wanted.W_fr * K / d,
        "RED": wanted.RED,
    }
    for name, value in figures.items():
        assert np.allclose(some[name].values, value, rtol=1e-9, atol=1e-13), name


@pytest.mark.slow
def test_a_hundred_million_cells_in_bounded_memory(tmp_path, monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.chdir(tmp_path)
    if shutil.disk_usage(tmp_path).free < ROOM:
        pytest.skip(f"needs {ROOM / 1e9:.0f} GB of free disk")
    BEAM.to_toml("beam.toml")
    hinged(300, "first.zarr")  # which compiles, if need be
    small = hinged(1000, "small.zarr")
    try:
        large = hinged(10_000, "large.zarr")
        compare("large.zarr", 10_000, 4000)
    finally:
        shutil.rmtree("large.zarr", ignore_errors=True)
    for n, cost in ((10**6, small), (10**8, large)):
        print(f"\n{n} cells: {cost}", end="")
    # a tile of the large one may lie where many paths need thousands of nodes; the engine takes 1024 of them at a time
    assert large.peak < small.peak + 320
    assert large.size < 66e8 * 1.01


@pytest.mark.slow
def test_a_million_beams_in_six_minutes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    SKIN.to_toml("beam.toml")

    def over(n):
        return ["--over", f"mu=0:1:{n}", "--over", f"scale.length=50mm:90mm:{n}", "--at", "0.1 rad/pitch"]

    small, large = sweep("first.zarr", *over(100)), sweep("map.zarr", *over(1000))
    print(f"\n10000 beams: {small}\n1000000 beams: {large}", end="")
    assert large.cpu < CORES * LIMIT
    assert large.peak < small.peak + 200
    some = chosen("map.zarr", 1000, 400)
    c = columns.columns(SKIN, {name: some[name].values for name in ("mu", "scale.length")})
    wanted = compliant_columns.solved(c, 0.1)
    assert np.array_equal(some.end.values, wanted.code)
    figures = {"phi_e": "load_e", "phi_fivefold": "load_fivefold"} | {
        n: n for n in ("torque", "stiffness_ratio", "RED")
    }
    for name, field in figures.items():
        # company changes a figure by less than that
        assert np.allclose(some[name].values, getattr(wanted, field), rtol=1e-6, equal_nan=True), name
