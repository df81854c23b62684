"""The table of loads: every name in it is a symbol, and its figures are the beam's."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.arrays.solution import solve
from squama.loads import LOADS
from squama.symbols import SYMBOLS

ROLES = (
    *(f"load{end}" for end in ("", "_e", "_end", "_touch")),
    *(f"rate{end}" for end in ("", "_e", "_end", "_c")),
    *("torque", "torque_c", "scales", "tangent", "theta", "theta_touch", "p", "s", "mu_lock", "drop"),
    *("base", "top", "residual", "jam", "most"),
)


@pytest.mark.parametrize("load", LOADS.values(), ids=list(LOADS))
def test_variables_are_symbols_of_the_right_unit(load):
    names = load.variables(ROLES)
    assert set(ROLES) - set(names) == set(load.missing)
    assert len(set(names.values())) == len(names)
    for role, name in names.items():
        unit = SYMBOLS[name].unit
        expected = {"load": "rad", "rate": "rad/m", "torque": "N m", "scales": "N m", "tangent": "N m^2"}
        assert unit == expected.get(role.partition("_")[0], unit)
    shown = [SYMBOLS[name].long_name for name in (load.angle, load.rate, load.torque)]
    assert [shown[0], shown[1], shown[2].split()[-1]] == [load.angle_words, load.rate_words, load.torque_words]


def test_figures_are_those_of_the_beam():
    beam = squama.Beam.from_ratios(inclusion_factor=1.1, mu=0.3)
    twisting, bending = LOADS["twisting"], LOADS["bending"]
    assert twisting.rigidity(beam) == beam.C_f * beam.J * beam.G_B
    assert bending.rigidity(beam) == beam.bending_rigidity
    assert twisting.inclusion(beam) == bending.inclusion(beam) == 1.1
    assert twisting.read("0.2 rad/pitch", pitch=0.02, scales=5) == bending.read("10 rad/m", pitch=0.02, scales=5)
    assert (twisting.law("plate"), bending.law("plate")) == ("plate", "edge")
    heights = [load.height(0.4, line) for load in (twisting, bending) for line in ("middle", "face")]
    assert heights == [0.4, 0.4, 0.4, 0.0]
    assert (bending.other_way("--sense -"), bool(twisting.other_way("--sense -"))) == ("", True)


@pytest.mark.parametrize("load", LOADS.values(), ids=list(LOADS))
def test_the_solver_takes_the_ratios_of_a_beam(load):
    beam = squama.Beam.from_ratios(mu=0.3)
    columns = {name: np.array([value]) for name, value in {**beam.ratios, "mu": 0.3}.items()}
    sol = solve(columns, load=load.name, law="edge", sense="+")
    curve = squama.twist(beam, joint="hinge") if load.sided else squama.bend(beam, joint="hinge")
    assert float(sol.found.load_e[0]) == pytest.approx(float(curve[load.variable("load_e")]), rel=1e-12)
