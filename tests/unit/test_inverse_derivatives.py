"""Figures of many beams on compliant joints that a target may name, beside each beam's curve, and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.inverse import joint_figures
from squama.inverse.named_figures import AT_TWIST, OF_BEAM, At, Options, Want
from squama.inverse.residuals import Residuals
from squama.inverse.space import cells_of, stepped
from squama.inverse.target import read_target
from squama.joints import law
from squama.joints.choice import shape
from squama.study.columns import beam_at

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
RANGES = {
    "scale.length": (0.06, 0.08),
    "scale.width": (0.02, 0.026),
    "scale.thickness": (0.0012, 0.0018),
    "alpha": (0.7, 0.9),
    "theta0": (0.3, 0.4),
    "beam.pitch": (0.0195, 0.0205),
    "mu": (0.1, 0.4),
    "scale.youngs_modulus": (1e9, 5e9),
    "substrate.thickness": (0.013, 0.015),
}
AT = At(0.0, 0.09)
WANTS = [*(Want(name, AT) for name in AT_TWIST), *(Want(name) for name in OF_BEAM)]
OPTIONS = Options(joint="compliant")


def sample(n):
    rng = np.random.default_rng(3)
    return {key: rng.uniform(*span, n) for key, span in RANGES.items()}


def evaluate(values, moved=()):
    c = cells_of(BEAM, "twisting", values, len(values["mu"]))
    return joint_figures.evaluate(c, moved, WANTS, OPTIONS, plates=True)


def test_figures_are_those_of_each_beams_curve():
    values = sample(20)
    found = evaluate(values)
    beams = [beam_at(BEAM, "twisting", {key: float(v[i]) for key, v in values.items()}) for i in range(20)]
    known = [i for i, beam in enumerate(beams) if not law.outside(shape(beam))]
    assert len(known) > 4
    for i, beam in enumerate(beams):
        if i not in known:
            assert np.isnan(found.values[: len(AT_TWIST), i]).all()
            continue
        own, answer = joint_figures.followed(beam, WANTS, OPTIONS)
        # tolerance: points of curves beside steps to the figures, 0.15 % measured, on every processor
        np.testing.assert_allclose(found.values[:, i], own, rtol=6e-3)
        assert float(answer["T"][0]) == pytest.approx(float(squama.twist(beam, at="0.09 rad/pitch")["T"][0]), rel=1e-12)
        share = own[4] * beam.scale.strength
        assert own[3] == pytest.approx(share)


def differences(values, key, rate, h):
    up, down = (evaluate({**values, key: values[key] + s * h * rate}).values for s in (1, -1))
    return (up - down) / (2 * h)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 1.0])
def test_derivatives_against_differences(friction):
    """Of 200 beams by 9 dimensions.

    Differences see Newton's tolerance where they are small, and where they are large now and then a step more or less
    along the curve: the nearer of two counts.
    """
    values = sample(200)
    values["mu"] *= friction
    rates = {key: np.mean(span) for key, span in RANGES.items() if friction or key != "mu"}
    found = evaluate(values, [stepped(BEAM, "twisting", values, key, rate, 200) for key, rate in rates.items()])
    np.testing.assert_allclose(found.values, evaluate(values).values, rtol=1e-7)
    has = [bool(friction) or want.figure not in ("W_fr", "RED") for want in WANTS]
    whole = np.isfinite(found.values[has]).all(axis=0) & (found.load_e < 0.085)
    assert whole.sum() > 150
    names, smooth = [want.figure for want in WANTS], ["torque", "stress", "engagement", "stiffness"]
    for j, (key, rate) in enumerate(rates.items()):
        slopes = [differences(values, key, rate, h) for h in (3e-4, 3e-5)]
        # over the figure itself, or its steepest slope
        scale = np.maximum(np.abs(found.values), np.abs(found.slopes).max(axis=1))[has][:, whole]
        off = np.min([np.abs(found.slopes[:, j] - slope)[has][:, whole] for slope in slopes], axis=0) / scale
        off = dict(zip(np.array(names)[has], off, strict=True))
        for name in off:
            assert np.median(off[name]) < (2e-5 if name in smooth else 1e-4), (key, name)
        for name in smooth:
            # beyond the quantile a difference has a step more along the curve at one of its ends
            quantile, most = (0.9, 1e-4) if friction else (0.97, 2e-5)
            assert np.quantile(off[name], quantile) < most, (key, name)


def test_derivatives_by_the_number_of_scales():
    """As if it were no whole number: of figures at a twist of the whole beam, and of what is asked so."""
    values = sample(40) | {"beam.scales": np.full(40, 25.0)}
    wants = [Want(name, At(0.0, 0.0, 0.09 * 25)) for name in ("torque", "stress")] + [Want("length")]

    def at(scales):
        c = cells_of(BEAM, "twisting", values | {"beam.scales": scales}, 40)
        return joint_figures.evaluate(c, [], wants, OPTIONS, plates=True).values

    c = cells_of(BEAM, "twisting", values, 40)
    moved = [stepped(BEAM, "twisting", values, "beam.scales", 1.0, 40)]
    found = joint_figures.evaluate(c, moved, wants, OPTIONS, plates=True)
    slope = (at(25.0 + 1e-3) - at(25.0 - 1e-3)) / 2e-3
    there = np.isfinite(found.values[0]) & (found.load_e < 0.085)
    assert there.sum() > 20
    by, slope = found.slopes[:, 0, there], slope[:, there]
    assert (by[:2] < 0).all()
    assert (np.median(np.abs(by / slope - 1), axis=1) < 1e-5).all()
    target = {"target": {"engagement": "60 deg total"}, "vary": {"beam.scales": (10, 40)}}
    residuals = Residuals(read_target(target, beam=BEAM))
    y = np.array([[0.5]])
    look = residuals.look(y, slopes=True, plates=True)
    up, down = (residuals.look(y + h, slopes=False, plates=True).r[0, 0] for h in (1e-5, -1e-5))
    assert look.J[0, 0, 0] == pytest.approx((up - down) / 2e-5, rel=1e-6)


def test_derivatives_are_there_at_no_friction_and_where_nothing_touches():
    values = {key: np.full(3, np.mean(span)) for key, span in RANGES.items()}
    # not known to the law; touches; the twist is not enough to touch
    values |= {"mu": np.zeros(3), "scale.thickness": np.array([0.02, 0.0015, 0.0015])}
    values["scale.length"] = np.array([0.07, 0.07, 0.03])
    moved = [stepped(BEAM, "twisting", values, key, 1.0, 3) for key in ("mu", "substrate.youngs_modulus")]
    found = evaluate(values, moved)
    torque = [want.figure for want in WANTS].index("torque")
    assert np.isfinite(found.slopes).all()
    more = evaluate({**values, "mu": np.full(3, 1e-4)}).values
    assert found.slopes[torque, 0, 1] == pytest.approx((more - found.values)[torque, 1] / 1e-4, rel=2e-3)
    assert found.load_e[2] > 0.09
    assert found.slopes[torque, 0, 2] == 0.0
    # a bar alone is as stiff as its modulus
    E = BEAM.substrate.youngs_modulus
    assert found.slopes[torque, 1, 2] * E == pytest.approx(found.values[torque, 2], rel=1e-12)
