"""What is found from a loop without noise: every parameter, every pair, and a beam that has the fitted curve."""

from __future__ import annotations

import functools
import itertools

import numpy as np
import pytest

import squama
from squama.curves import compliant
from squama.identify.estimate import derivatives
from squama.identify.prepare import Wanted, prepared
from squama.identify.records import ALL, read
from squama.loads import LOADS

pytestmark = pytest.mark.usefixtures("alone")
BEAM = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(hold="bend, lateral bend")
HISTORY = {"twisting": "0.1, 0.06 rad/pitch", "bending": "0.2, 0.12 rad/pitch"}
NEAR = {"compliant": 2e-4, "hinge": 1e-9}
"""Relative: where a contact begins to slide again, steps of the compliant joint's path hang on rounding, 2e-6 of the
largest torque."""
FACTORS = {"mu": 1.2, "K_theta": 1.07, "C_f": 0.94, "E_B": 0.85, "theta0": 1.04}
"""True values over those of the beam that a fit starts from."""
COMPLIANT = ("mu", "K_theta", "C_f", "E_B")
ON_HINGES = (*COMPLIANT, "theta0")


def sets(names):
    return [*((n,) for n in names), *itertools.combinations(names, 2), ("mu", "K_theta", "E_B")]


def begun(joint, load):
    """The beam that a fit starts from, and the true value of each parameter."""
    held = compliant.Held.of(BEAM)
    own = {
        "mu": 0.25,
        "K_theta": BEAM.joint_stiffness,
        "C_f": LOADS[load].inclusion(BEAM),
        "E_B": BEAM.substrate.youngs_modulus,
        "theta0": BEAM.scale.theta0,
    }
    if joint == "compliant":
        own |= {"K_theta": held.K_theta, "C_f": held.rigidity / (BEAM.G_B * BEAM.J)}
    return {name: value * FACTORS[name] for name, value in own.items()}


PLACES = {
    "mu": "friction.mu",
    "K_theta": "joint.stiffness",
    "C_f": "joint.inclusion_factor",
    "E_B": "substrate.youngs_modulus",
    "theta0": "scale.theta0",
}


@functools.cache
def measured(names, joint, load):
    """The true values of some parameters, and the loop of a beam that has them."""
    truth = {name: value for name, value in begun(joint, load).items() if name in names}
    beam = BEAM._with({PLACES[name]: value for name, value in truth.items()})
    return truth, solved(squama.cycle(beam, HISTORY[load], load=load, joint=joint, points=25))


def solved(loop):
    """A loop without the points at which scales begin to slide, to which the compliant joint's is continued.

    Their torque is 3e-4 of the largest off that of a beam that is walked to their twist.
    """
    onset = (loop.branch.values[:-1] == "stick") & (loop.branch.values[1:] != "stick")
    return loop.isel(point=np.flatnonzero(~np.append(onset, False) | (loop.joint != "compliant")))


@pytest.mark.slow(but=3)
@pytest.mark.parametrize("names", sets(COMPLIANT), ids=",".join)
def test_the_compliant_joint_gives_its_parameters_back(names):
    _gives_back(names, "compliant", "twisting")


@pytest.mark.parametrize("load", ["twisting", "bending"])
@pytest.mark.parametrize("names", sets(ON_HINGES), ids=",".join)
def test_hinges_give_their_parameters_back(names, load):
    _gives_back(names, "hinge", load)


def _gives_back(names, joint, load):
    truth, loop = measured(names, joint, load)
    fit = squama.fit(loop, BEAM, names, joint=joint, load=load, nuisances="none", starts=2)
    near = NEAR[joint]
    for name, value in truth.items():
        assert fit.values[name] == pytest.approx(value, rel=near), name
    assert fit.holds
    # the fitted beam is the specimen, so that every answer about it has the fitted curve
    again = solved(squama.cycle(fit.beam, HISTORY[load], load=load, joint=joint, points=25))
    torque = "T" if load == "twisting" else "M"
    size = float(loop[torque].max())
    up, down = (fit.used & (loop.leg.values == leg) for leg in (1, 2))
    np.testing.assert_allclose(again[torque].values[up], fit.fitted[up], rtol=0, atol=1e-6 * size)
    np.testing.assert_allclose(again[torque].values[down], fit.fitted[down], rtol=0, atol=near * size)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("names", [("mu", "K_theta", "E_B"), ("C_f",)], ids=",".join)
def test_twist_of_the_fitted_beam_has_the_fitted_curve(names):
    _, loop = measured(names, "compliant", "twisting")
    fit = squama.fit(loop, BEAM, names, joint="compliant", nuisances="none", starts=1)
    up = fit.used & (loop.leg.values == 1)
    again = squama.twist(fit.beam, at=loop.Phi.values[up], joint="compliant")["T"].values
    np.testing.assert_allclose(again, fit.fitted[up], rtol=0, atol=NEAR["compliant"] * float(loop["T"].max()))


def test_all_of_the_matrix_goes_with_the_modulus_of_the_bar():
    """Twice the modulus of bar, joint and scales is twice the torque; a joint whose stiffness is given stays."""
    stiff = BEAM.replace(scale={"youngs_modulus": None})
    _, loop = measured(("mu",), "compliant", "twisting")
    wanted = Wanted(stiff, read(loop, stiff, "twisting"), ("E_B",), "twisting", "edge", None, ALL, None, 1, ())
    made = prepared("compliant", wanted)
    at = made.asked.start
    one, two = (made.points.torque(made.asked.physical(factor * at)) for factor in (1, 2))
    np.testing.assert_allclose(two, 2 * one, rtol=0, atol=1e-4 * one.max())
    given = stiff.replace(joint={"stiffness": compliant.Held.of(stiff).K_theta})
    other = prepared("compliant", wanted._replace(beam=given))
    np.testing.assert_allclose(other.points.torque(other.asked.physical(at)), one, rtol=0, atol=1e-4 * one.max())
    assert np.abs(other.points.torque(other.asked.physical(2 * at)) - two).max() > 0.05 * one.max()


def test_derivatives_to_the_modulus_and_the_inclusion_factor():
    """Against differences ten times as wide."""
    _, loop = measured(("mu",), "compliant", "twisting")
    names = COMPLIANT
    wanted = Wanted(BEAM, read(loop, BEAM, "twisting"), names, "twisting", "edge", None, ALL, None, 1, ())
    for some in (names, ("mu", "C_f", "E_B")):
        made = prepared("compliant", wanted._replace(names=some))
        p = made.asked.start
        J = derivatives(made.points, made.asked, p)
        for i, size in enumerate(p):
            step = np.zeros(p.size)
            step[i] = 0.01 * size
            up, down = (made.points.torque(made.asked.physical(q)) for q in (p + step, p - step))
            slope = (up - down) / (0.02 * size)
            np.testing.assert_allclose(J[:, i], slope, rtol=0, atol=0.06 * np.abs(slope).max(), err_msg=some[i])
