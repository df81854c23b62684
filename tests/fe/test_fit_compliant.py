"""Fits with the compliant joint: what is found from a loop that was walked with another friction and another matrix."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.beam import matrixfile

K = np.array(
    [
        [1.6819, -0.2141, 0.0830, 0.1005, 0.0328, 0.0954, -0.0501],
        [-0.2141, 1.2319, 0.0294, -0.0268, -0.0101, -0.1892, 0.0060],
        [0.0830, 0.0294, 2.1384, 0.0319, 0.2853, -0.0152, 0.1372],
        [0.1005, -0.0268, 0.0319, 0.4225, -0.0185, 0.0574, -0.0180],
        [0.0328, -0.0101, 0.2853, -0.0185, 0.1082, -0.0131, 0.0181],
        [0.0954, -0.1892, -0.0152, 0.0574, -0.0131, 0.3949, -0.0897],
        [-0.0501, 0.0060, 0.1372, -0.0180, 0.0181, -0.0897, 0.1285],
    ]
)
"""Stiffness of a joint, E = 1 and d = 1, as elements give it for the example's beam."""
START = (
    squama.Beam.from_toml("examples/pla_on_vps.toml")
    .replace(scales=None)
    .replace(scales=None)
    .replace(scale={"theta0": "2 deg", "thickness": "0.1 mm", "youngs_modulus": None})
)
HISTORY = "0, 0.018, 0.011 rad/pitch"


def with_matrix(joint=1.0, mu=0.25, bar=1.0):
    """The beam with that matrix, its K_theta and its rigidity without contact times factors."""
    beam = START.replace(joint={"matrix": matrixfile.stored(START, K)}, friction={"mu": mu})
    return beam.replace(joint={"stiffness": joint * beam.joint_stiffness, "inclusion_factor": bar * beam.C_f})


BEAM = with_matrix()


@pytest.mark.slow
def test_a_walked_loop_gives_its_parameters_back():
    truth = with_matrix(1.3, 0.35, 0.9)
    loop = squama.cycle(truth, HISTORY, joint="compliant", points=20)
    fit = squama.fit(loop, BEAM, ("mu", "K_theta", "C_f"), joint="compliant")
    # of C_f few points say much: those before engagement
    expected = {"mu": (0.35, 2e-3), "K_theta": (truth.joint_stiffness, 2e-3), "C_f": (truth.C_f, 5e-3)}
    for name, (value, near) in expected.items():
        assert fit.values[name] == pytest.approx(value, rel=near), name
    assert fit.rms < 1e-3 * float(loop["T"].max())
    # hinges have no such loop
    assert squama.fit(loop, BEAM, ("mu", "K_theta", "C_f"), joint="hinge").rms > 5 * fit.rms
    # the fitted beam has its matrix and what was found: it answers as the specimen did
    assert fit.beam.joint.matrix == BEAM.joint.matrix
    assert fit.beam.joint_stiffness == pytest.approx(fit.values["K_theta"], rel=1e-12)
    assert fit.beam.C_f == pytest.approx(fit.values["C_f"], rel=1e-12)
    again = squama.cycle(fit.beam, HISTORY, joint="compliant", points=20)
    np.testing.assert_allclose(again["T"], loop["T"], atol=2e-3 * float(loop["T"].max()))
    drawn = fit.dataset()
    assert set(drawn.leg.values.tolist()) == {1, 2}
    assert float(drawn.T_curve.max()) == pytest.approx(float(loop["T"].max()), rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"parameters": "mu,theta0"}, 'parameters: theta0 is not found with joint="compliant"'),
        ({"load": "bending", "parameters": "mu,C_f"}, 'parameters: C_f is not found with joint="compliant" in bending'),
        ({"law": "plate"}, 'law = "plate": is not covered by joint="compliant"'),
        ({"joint": "glue"}, 'joint = "glue": must be "hinge" or "compliant"'),
    ],
)
def test_what_the_compliant_joint_does_not_cover(arguments, words):
    data = {"phi": np.linspace(0, 0.02, 5), "T": np.linspace(0, 0.1, 5)}
    with pytest.raises(squama.InputError) as caught:
        squama.fit(data, BEAM, **{"joint": "compliant", **arguments})
    assert str(caught.value).startswith(words)


def test_twists_that_the_scales_do_not_follow_are_refused():
    far = {"phi": np.linspace(0, 0.9, 5), "T": np.linspace(0, 9, 5)}
    with pytest.raises(squama.InputError, match=r"followed to .* deg per pitch|half a turn"):
        squama.fit(far, BEAM.replace(friction={"mu": 2.5}), joint="compliant")
