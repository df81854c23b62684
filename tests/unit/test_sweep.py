"""Sweeps: the numbers of the cells, the labels, tiles, shards, and the memory they take."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.beam import joint_law
from squama.model.outcome import CODES
from squama.paper import maps as paper_maps
from squama.paper import parameters as paper
from squama.study import columns, parameters, slices, store
from squama.study.plan import VARIABLES, tile_shape
from squama.study.sweeping import make_plan, run

BEAM = squama.Beam.from_ratios()
RANGES = {"mu": (0.0, 2.0, 9), "alpha": ("15 deg", "75 deg", 7)}


def contents(store):
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(Path(store).rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    place = tmp_path_factory.mktemp("sweep") / "map.zarr"
    return squama.sweep(BEAM, RANGES, law=["edge", "plate"], out=place, tile=20, joint="hinge"), place


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("n", [11, 15])
def test_no_bit_depends_on_the_tiles(n, tmp_path):
    # 121 and 225 cells: few are solved by Python, more by compiled code
    ranges = {"mu": (0, 1, n), "alpha": (0.2, 1.3, n)}
    first, other = (
        squama.sweep(BEAM, ranges, out=tmp_path / f"{tile}.zarr", tile=tile, joint="hinge").load() for tile in (225, 20)
    )
    for name in VARIABLES["hinge", "twisting"]:
        assert first[name].values.tobytes() == other[name].values.tobytes(), name


def test_values_may_be_a_list_an_array_or_a_text():
    for values in ([0.1, 0.2, 0.5], np.array([0.1, 0.2, 0.5]), "0.1,0.2,0.5"):
        (axis,) = parameters.axes({"mu": values})
        np.testing.assert_array_equal(axis.values, [0.1, 0.2, 0.5])


def test_every_cell_is_the_response_of_its_beam(both):
    data, _ = both
    for law in ("edge", "plate"):
        for i, j in ((0, 0), (2, 3), (5, 6), (8, 1)):
            cell = data.sel(law=law).isel(mu=i, alpha=j)
            beam = BEAM.replace(scale={"alpha": float(cell.alpha)})
            r = squama.twist(beam, mu=float(cell.mu), law=law, points=3, joint="hinge")
            if str(r.end.item()) == "other contact":
                continue  # a response looks at every pair of plates, a sweep at the tip-side ones
            assert CODES[int(cell.end)] == r.end.item()
            for name, other in (
                ("phi_e", "phi_e"),
                ("phi_end", "phi_end"),
                ("theta_end", "theta_end"),
                ("torque", "T_c"),
                ("U_el", "U_el_c"),
                ("W_fr", "W_fr_c"),
                ("RED", "RED_c"),
            ):
                assert float(cell[name]) == pytest.approx(float(r[other]), rel=1e-8, abs=1e-14), (law, i, j, name)


SWEPT = [
    {"eta": (1.5, 6.0, 4), "zeta": (0.1, 0.4, 3)},
    {"lam": (0.2, 0.8, 4), "slenderness": (20.0, 60.0, 3)},
    {"beta": (0.5, 1.5, 3), "theta0": ("2 deg", "30 deg", 3)},
    {"scale.length": ("30 mm", "90 mm", 3), "beam.pitch": ("15 mm", "25 mm", 3)},
    {"scale.width": ("10 mm", "50 mm", 3), "scale.embedded": (0.0, "7 mm", 3)},
    {"substrate.thickness": ("8 mm", "24 mm", 3), "substrate.youngs_modulus": ("1 MPa", "2 MPa", 3)},
    {"substrate.width": ("20 mm", "60 mm", 3), "substrate.poisson_ratio": (0.2, 0.4, 2)},
    {"joint.stiffness": ("0.01 N m", "0.05 N m", 3), "joint.inclusion_factor": (1.0, 2.0, 2)},
    {"lam": (0.3, 0.6, 3), "substrate.thickness": ("8 mm", "24 mm", 2)},
]


@pytest.mark.parametrize("load", ["twisting", "bending"])
@pytest.mark.parametrize("ranges", SWEPT, ids=" ".join)
def test_columns_of_the_cells_are_those_of_their_beams(ranges, load):
    plan = make_plan(BEAM.replace(friction={"mu": 0.3}), ranges, load=load, joint="hinge")
    mesh = dict(zip(plan.dims, np.ix_(*(axis.values for axis in plan.axes)), strict=True))
    found = columns.columns(BEAM, mesh, load=load, each=joint_law.one_by_one)
    for index in np.ndindex(plan.shape):
        values = {axis.name: float(axis.values[i]) for axis, i in zip(plan.axes, index, strict=True)}
        beam = columns.beam_at(BEAM, load, values)
        stiffness = beam.joint_stiffness
        rigidity = beam.torsional_rigidity if load == "twisting" else beam.bending_rigidity
        wanted = {"eta": beam.eta, "beta": beam.beta, "lam": beam.lam, "K": stiffness, "d": beam.pitch}
        wanted["rigidity"] = rigidity
        for name, value in wanted.items():
            here = np.broadcast_to(getattr(found, name), plan.shape)[index]
            assert here == pytest.approx(value, rel=1e-12), (name, values)
    # a ratio leaves the others as they are
    for name in set(ranges) & {"eta", "beta", "lam", "zeta", "slenderness"}:
        others = {"eta", "beta", "lam", "zeta", "slenderness"} - set(ranges)
        beam = columns.beam_at(BEAM, load, {name: ranges[name][0]})
        assert all(getattr(beam, n) == pytest.approx(getattr(BEAM, n), rel=1e-12) for n in others)


def test_a_joint_without_stiffness_leaves_the_bare_beam(tmp_path):
    data = squama.sweep(
        BEAM,
        {"scale.embedded": (0.0, "6 mm", 3), "mu": (0.2, 0.4, 2)},
        out=tmp_path / "m.zarr",
        margin=0.1,
        joint="hinge",
    )
    cell = data.isel(mu=0).sel({"scale.embedded": 0.0})
    r = squama.twist(BEAM.replace(scale={"embedded": 0.0}), mu=0.2, margin=0.1, points=3, joint="hinge")
    assert float(cell.torque) == pytest.approx(float(r.T_c), rel=1e-9)
    assert float(cell.U_el) == pytest.approx(float(r.U_el_c), rel=1e-9)
    assert float(cell.RED) == float(cell.W_fr) == 0.0


def test_labels(both):
    data, place = both
    assert list(data.data_vars) == [*VARIABLES["hinge", "twisting"], "status"]
    assert data["RED"].dims == ("law", "mu", "alpha")
    for name in (*VARIABLES["hinge", "twisting"], "mu", "alpha"):
        assert data[name].attrs["long_name"]
    assert (data.torque.attrs["units"], data.U_el.attrs["units"], data.alpha.attrs["units"]) == ("N m", "J/m", "rad")
    assert data.end.dtype == "int8"
    assert data.end.attrs["flag_values"] == list(range(-1, len(CODES)))
    assert data.end.attrs["flag_meanings"].split()[1] == "frictional_lock"
    assert list(data.law.values) == ["edge", "plate"]
    assert (data.status == 1).all()
    attrs = data.attrs
    assert (attrs["margin"], attrs["law"], attrs["load"], attrs["sense"]) == (0.01, "edge plate", "twisting", "+")
    assert squama.Beam.from_toml_text(attrs["beam"]) == BEAM
    assert len(attrs["configuration_sha256"]) == 64
    assert set(attrs["versions"]) == {"squama", "numba", "numpy", "scipy"}
    document = json.loads((place / "RED" / "zarr.json").read_text())
    assert document["chunk_grid"]["configuration"]["chunk_shape"] == list(store.read_plan(place).tile)
    assert not data.RED.variable._in_memory
    assert squama.open_sweep(place).identical(data)


def test_a_margin_that_is_swept(tmp_path):
    margins = [0.001, 0.01, 0.1]
    data = squama.sweep(BEAM, {"margin": margins, "mu": (0.1, 0.5, 3)}, out=tmp_path / "m.zarr", joint="hinge")
    assert "margin" not in data.attrs
    for margin in margins:
        r = squama.twist(BEAM, mu=0.3, margin=margin, points=3, joint="hinge")
        assert float(data.sel(margin=margin).isel(mu=1).RED) == pytest.approx(float(r.RED_c), rel=1e-9)


@pytest.mark.parametrize("load", ["twisting", "bending"])
def test_a_path_runs_from_engagement_to_the_lock_without_friction(load, tmp_path):
    ranges = {"mu": (0.0, 2.0, 3), "theta0": ("5 deg", "20 deg", 4)}
    data = squama.sweep(BEAM, ranges, load=load, out=tmp_path / "m.zarr", joint="hinge")
    part = slices.take(data, x="theta0", y="mu")
    found = slices.paths(part, ["10 deg", "0.3 rad"], bare=False)
    assert list(found) == pytest.approx([np.radians(10), 0.3])
    cell, angle = data.isel(mu=0, theta0=1), "phi" if load == "twisting" else "psi"
    angles, theta = found[next(iter(found))]
    assert (angles[0], theta[0]) == pytest.approx((float(cell[f"{angle}_e"]), np.radians(10)))
    assert (angles[-1], theta[-1]) == pytest.approx((float(cell[f"{angle}_end"]), float(cell.theta_end)))


def test_bending(tmp_path):
    data = squama.sweep(
        BEAM, {"eta": (2.0, 6.0, 3), "mu": [0.1, 0.3]}, load="bending", out=tmp_path / "m.zarr", joint="hinge"
    )
    assert {"psi_e", "psi_end"} <= set(data.data_vars)
    r = squama.bend(squama.Beam.from_ratios(eta=4), mu=0.3, points=3, joint="hinge")
    cell = data.sel(eta=4.0, mu=0.3)
    assert [float(cell[n]) for n in ("psi_end", "torque", "RED")] == pytest.approx(
        [float(r[n]) for n in ("psi_end", "M_c", "RED_c")], rel=1e-9
    )


def test_red_is_that_of_the_papers_maps(tmp_path):
    """The path of squama.paper.maps, which shares neither engine nor tiles with a sweep."""
    _compare_with_paper(tmp_path, 14)


@pytest.mark.slow
def test_red_is_that_of_the_papers_maps_at_400_by_400(tmp_path):
    _compare_with_paper(tmp_path, 400)


def _compare_with_paper(folder, n):
    for over, values in (("eta", (1.5, 8.0, n)), ("alpha", ("1 deg", "75 deg", n))):
        ranges = {over: values, "mu": (0.0, 6.0, n)}
        data = squama.sweep(paper.main(), ranges, law=["plate", "edge"], out=folder / f"{over}.zarr", joint="hinge")
        grid = np.meshgrid(data[over].values, data["mu"].values, indexing="ij")
        r = paper_maps.sweep(paper.main(), over, grid[0].ravel())
        for law in ("plate", "edge"):
            wanted, _ = paper_maps.dissipation(paper.main(), r, grid[1].ravel(), law, 0.01)
            part = data.sel(law=law)
            assert np.array_equal(part.end.values.ravel(), wanted.code)
            assert np.allclose(part.RED.values.ravel(), wanted.RED, rtol=1e-9, atol=1e-12)


def test_tiles_cover_every_cell_once():
    for shape, most in (
        ((1,), 1),
        ((7, 9), 20),
        ((400, 400), 10_000),
        ((3, 100, 50, 2), 333),
        ((10_000, 10_000), 65_536),
    ):
        tile = tile_shape(shape, tuple("abcd"[: len(shape)]), most)
        assert np.prod(tile) <= most
        grid = [-(-n // m) for n, m in zip(shape, tile, strict=True)]
        assert np.prod(grid) <= 2.5 * max(1.0, np.prod(shape) / most) + len(shape)
    assert tile_shape((2, 3, 50), ("law", "margin", "mu"), 1000) == (1, 1, 50)


def test_shards_together_are_the_sweep(both, tmp_path):
    _, whole = both
    plan = store.read_plan(whole)
    done = [run(plan, tmp_path / "map.zarr", shard=f"{i}/3")[0] for i in (2, 1, 3)]
    assert done[0] < done[1] < done[2] == len(list(plan.tiles()))
    assert contents(tmp_path / "map.zarr") == contents(whole)


def test_progress_tells_tiles_and_time_left(tmp_path):
    states = []
    squama.sweep(BEAM, RANGES, out=tmp_path / "m.zarr", tile=20, progress=states.append, joint="hinge")
    assert [s.tiles_done for s in states] == list(range(states[0].tiles + 1))
    assert states[0].left_s is None
    assert states[-1].left_s == 0.0
    assert all(s.left_s > 0 for s in states[1:-1])
    assert states[-1].cells_done == states[-1].cells == 63
    states.clear()
    squama.sweep(BEAM, RANGES, out=tmp_path / "m.zarr", tile=20, progress=states.append, joint="hinge")
    assert [s.tiles_done for s in states] == [states[0].tiles]


_PEAK = """
import resource, sys, squama
n, out = int(sys.argv[1]), sys.argv[2]
beam = squama.Beam.from_ratios(mu=0.3, stiffness=0.02, inclusion_factor=1.4)
squama.sweep(beam, {"eta": (2, 6, 8), "mu": (0.1, 0.5, 4)}, out=f"{out}/small.zarr", joint="hinge")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
squama.sweep(beam, {"eta": (2, 6, 256), "mu": (0.1, 0.5, 256)}, out=f"{out}/tile.zarr", tile=65536, joint="hinge")
# with a joint that is given the thickness changes nothing, so a row of cells is solved once
over = {"scale.thickness": (1e-4, 2e-4, n), "eta": (2, 6, n)}
data = squama.sweep(beam, over, joint="hinge", out=f"{out}/m.zarr", tile=65536)
assert data.RED.size == n * n and bool((data.status == 1).all())
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


def _peak(n, out):
    """Growth of the peak memory in MB by one full tile that is solved, and n x n cells that are written."""
    command = [sys.executable, "-c", _PEAK, str(n), str(out)]
    return int(subprocess.run(command, capture_output=True, text=True, check=True).stdout) / 1024


@pytest.mark.slow
def test_memory_is_that_of_a_tile(tmp_path):
    # 66 bytes a cell are stored: six million cells hold 400 MB
    assert _peak(2450, tmp_path) < 200
