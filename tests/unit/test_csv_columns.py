"""CSV of every command: the load first, one order of columns whatever model answered, units that others read."""

from itertools import combinations
from pathlib import Path

import pytest

import squama
from squama.cli import main, output
from squama.io.headers import split
from squama.symbols import OF_A_SCALE, SYMBOLS

BEAM = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
PINT = {"1", "Hz", "J", "J/m", "N", "N m", "N m^2", "Pa", "m", "rad", "rad/m", "rad/s", "s"}
"""Units as they are written, each of which pint.Unit takes."""
SCALES = {*OF_A_SCALE, "r"} - {"contact"}
HINGE, FEW, END = ["--joint", "hinge"], ["--points", "6"], ["--to", "0.1 rad/pitch"]
SWING = ["--rotor", "1e-4 kg m2"]
RUNS = {
    "twist": (["twist", "one.toml", *FEW, *END], "Phi phi T T_scales K_t"),
    "twist of 3 scales": (["twist", "three.toml", *FEW, *END], "Phi phi scale T T_scales K_t"),
    "twist on hinges": (["twist", "one.toml", *HINGE], "Phi phi T T_scales K_t"),
    "family": (["twist", "one.toml", *FEW, *END, "--mu", "0,0.2"], "Phi phi mu T T_scales K_t"),
    "bend": (["bend", "one.toml", *FEW, *END], "kappa psi M M_scales K_b"),
    "bend of 3 scales": (["bend", "three.toml", *FEW, *END], "kappa psi scale M M_scales K_b"),
    "row": (["row", "three.toml", *HINGE, *FEW, *END], "Phi phi scale T T_scales K_t"),
    "path": (
        ["bend-twist", "one.toml", "--path", "bend 2 rad/m; twist 3 rad/m", *FEW],
        "kappa Phi psi phi M M_scales T",
    ),
    "path of 3": (["bend-twist", "three.toml", "--path", "bend 2 rad/m", *FEW], "kappa Phi psi phi scale M M_scales T"),
    "cycle": (["cycle", "one.toml", *FEW, *END], "Phi phi T T_scales K_t"),
    "cycle of 3 scales": (["cycle", "three.toml", *FEW, *END], "Phi phi scale T T_scales K_t"),
    "force": (["load", "three.toml", "--load", "2 mm up at tip", "--points", "5"], "share travel scale F F_bare"),
    "torque": (["load", "three.toml", "--load", "5 deg twist", "--points", "5"], "share turn scale moment moment_bare"),
    "vibrate": (["vibrate", "one.toml", *SWING, *HINGE, "--release", "0.1 rad/pitch"], "t phi phi_speed"),
    "shake": (
        [
            "shake",
            "one.toml",
            *SWING,
            *HINGE,
            "--lowest",
            "1 Hz",
            "--highest",
            "2 Hz",
            "--points",
            "2",
            "--torque",
            "1 N mm",
        ],
        "frequency phi_high_up phi_high_down",
    ),
    "uncertainty": (
        ["uncertainty", "one.toml", *HINGE, "--vary", "mu=+- 0.1", "--samples", "3200"],
        "friction.mu phi_e",
    ),
    "plan": (["plan", "three.toml", *HINGE, "--noise", "5 N mm", "--find", "mu"], "loop top total readings torque"),
    "fit": (["fit", "test.csv", "one.toml", *HINGE, "--find", "mu"], "Phi phi T"),
    "map": (["map", "grid.zarr"], "alpha mu"),
}


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Columns (name, unit) and path of the files of every command."""
    found, written, write = {}, [], output.write_csv
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("tables"))
        patch.setattr(output, "write_csv", lambda path, data: (written.append(data), write(path, data))[1])
        BEAM.replace(scales=None).to_toml("one.toml")
        BEAM.replace(scales=3).to_toml("three.toml")
        loop = squama.cycle(BEAM, "0.1 rad/pitch", joint="hinge")
        squama.save(loop, "test.csv")
        squama.sweep(BEAM, {"alpha": ("30 deg", "60 deg", 2), "mu": (0, 1, 3)}, out="grid.zarr", joint="hinge")
        for i, (name, (given, _)) in enumerate(RUNS.items()):
            # netCDF holds what CSV holds; files take longer than most curves
            more = ["--netcdf", f"{i}.nc"] if name in ("twist of 3 scales", "family") else []
            assert main([*given, "--csv", f"{i}.csv", *more]) == 0, name
            lines = Path(f"{i}.csv").read_text(encoding="utf-8").splitlines()
            head = next(line for line in lines if not line.startswith("#"))
            found[name] = [split(cell) for cell in head.split(",")]
            assert squama.read(f"{i}.csv").identical(written[-1]), name
            if more:
                assert squama.read(f"{i}.nc").identical(written[-1]), name
    return found


@pytest.mark.parametrize("name", RUNS)
def test_the_load_comes_first(name, tables):
    first = RUNS[name][1].split()
    assert [column for column, _ in tables[name]][: len(first)] == first


@pytest.mark.parametrize("name", RUNS)
def test_units_are_in_the_header(name, tables):
    assert {unit for _, unit in tables[name]} <= PINT | {""}
    bare = [column for column, unit in tables[name] if not unit]
    # texts, and numbers that count
    assert all(SYMBOLS[column].unit == "" for column in bare if column in SYMBOLS)


@pytest.mark.parametrize("load", ["twist", "bend", "path", "cycle"])
def test_the_order_is_one(load, tables):
    """Columns of points, and those of scales, are in the same order for every model and number of scales."""
    orders = [[c for c, _ in columns] for name, columns in tables.items() if name.split()[0] == load]
    for a, b in combinations(orders, 2):
        for of_scales in (False, True):
            both = [c for c in a if c in b and (c in SCALES) == of_scales]
            assert both == [c for c in b if c in both]


def test_every_symbol_has_a_unit_that_others_read():
    assert {symbol.unit for symbol in SYMBOLS.values()} <= PINT | {""}
