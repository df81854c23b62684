"""Warm curves: a solved path of 200 points with all its variables, and what squama.twist and squama.row answer."""

from __future__ import annotations

import numpy as np

import squama
from squama.arrays.solution import solve
from squama.curves import general_contact, real
from squama.curves.hinge import path
from squama.curves.path import Case
from squama.fe.assembly import make_bent
from squama.fe.geometry import geometry
from squama.joints.choice import joint_of

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


def test_bent_and_twisted_one_contact_at_a_time(benchmark) -> None:
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    r = benchmark(lambda: squama.bend_twist(beam, "bend 5 rad/m; twist 8 rad/m"))
    assert r.followed == "one contact"


def test_bent_and_twisted_by_general_contact(benchmark) -> None:
    """The same path on the same joint, increments of 1e-3 rad per pitch; moment and torque within 1.5 %."""
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    r, K, d = squama.bend_twist(beam, "bend 5 rad/m; twist 8 rad/m"), joint_of(beam).K, beam.pitch
    assert K is not None
    surface = general_contact.surface(real.scale(beam, ideal=False))

    def run() -> tuple[float, float]:
        led = make_bent(K, geometry(beam), float(r.mu), exposed=surface)
        for psi, phi in ((5 * d, 0.0), (5 * d, 8 * d)):
            assert led.run(led.aim(psi, phi), 1e-3).reached
        return led.columns["M"][-1], led.columns["T"][-1]

    found = benchmark.pedantic(run, rounds=2)
    unit = beam.unit_moment
    np.testing.assert_allclose(np.array(found) * unit, [r.M[-1], r["T"][-1]], rtol=0.015)
