"""Warm curves: a solved path of 200 points with all its variables, and what squama.twist and squama.row answer."""

from __future__ import annotations

import numpy as np

import squama
from squama.arrays.solution import solve
from squama.curves.hinge import path
from squama.curves.way import Case

BEAM = squama.Beam.from_ratios()


def test_curve_of_200_points(benchmark) -> None:
    case = Case.of(BEAM, "twisting")
    columns = {name: np.array([v]) for name, v in {**BEAM.ratios, "mu": 0.5}.items()}

    def run() -> None:
        solved = solve(columns, law="edge", sense="+")
        path(case, solved, None, 0.5, "edge", 0.01).curve(points=200)

    benchmark(run)


def test_evaluation_of_200_points(benchmark) -> None:
    case = Case.of(BEAM, "twisting")
    columns = {name: np.array([v]) for name, v in {**BEAM.ratios, "mu": 0.5}.items()}
    solved = path(case, solve(columns, law="edge", sense="+"), None, 0.5, "edge", 0.01)
    benchmark(lambda: solved.curve(points=200))


def test_twist_with_all_contacts_and_labels(benchmark) -> None:
    benchmark(lambda: squama.twist(BEAM, mu=0.5, joint="hinge"))


def test_forces_at_200_points(benchmark) -> None:
    theta = np.linspace(0.18, 1.2, 200)
    ratios = BEAM.ratios
    benchmark(lambda: squama.forces(theta, mu=0.5, **ratios))


def test_row_of_25_thick_elastic_scales(benchmark) -> None:
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scale={"youngs_modulus": "200 GPa"})
    r = benchmark(lambda: squama.row(beam, scales=25, to="0.1 rad/pitch"))
    assert r.attrs["scales"] == "thick, elastic scales"
    assert r.end == "range end"


def test_bent_and_twisted(benchmark) -> None:
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    r = benchmark(lambda: squama.bend_twist(beam, "bend 5 rad/m; twist 8 rad/m"))
    assert r.end == "range end"
