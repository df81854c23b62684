"""A sweep that is much larger than memory: its peak memory, time and place on the disk, and its cells."""

import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import squama

BEAM = squama.Beam.from_ratios()
ROOM = 12e9
"""Free bytes on the disk without which the large sweep is not begun; it takes half of them."""

# A process between, because a child begins with the peak of the process that forks it.
_MEASURED = """
import resource, subprocess, sys
done = subprocess.run([sys.executable, "-m", "squama", *sys.argv[1:]], stdout=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)
sys.exit(done.returncode)
"""


def sweep(n, out):
    """Solve n x n cells over two parameters that both matter; return peak MB, seconds, bytes on the disk."""
    over = ["--over", f"mu=0:2:{n}", "--over", f"alpha=1deg:75deg:{n}"]
    arguments = ["sweep", "beam.toml", *over, "--tile", "65536", "-o", out]
    start = time.monotonic()
    command = [sys.executable, "-c", _MEASURED, *arguments]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    seconds = time.monotonic() - start
    return float(done.stdout), seconds, sum(p.stat().st_size for p in Path(out).rglob("*") if p.is_file())


def compare(out, n, count):
    """Compare cells taken at random with the answers of a few cells."""
    data = squama.open_sweep(out)
    assert bool((data.status == 1).all())
    assert dict(data.RED.sizes) == {"mu": n, "alpha": n}
    i, j = np.random.default_rng(8).integers(0, n, (2, count))
    some = data.isel(mu=xr.DataArray(i, dims="cell"), alpha=xr.DataArray(j, dims="cell")).load()
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
    sweep(300, "first.zarr")  # which compiles, if need be
    small = sweep(1000, "small.zarr")
    try:
        large = sweep(10_000, "large.zarr")
        compare("large.zarr", 10_000, 4000)
    finally:
        shutil.rmtree("large.zarr", ignore_errors=True)
    for n, (peak, seconds, size) in ((10**6, small), (10**8, large)):
        print(f"\n{n} cells: {seconds:.0f} s, {size / 1e6:.0f} MB on the disk, peak {peak:.0f} MB", end="")
    # a tile of the large one may lie where many paths need thousands of nodes; the engine takes 1024 of them at a time
    assert large[0] < small[0] + 320
    assert large[2] < 66e8 * 1.01
