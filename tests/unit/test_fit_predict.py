"""Predictions from a fit: the band of the draws against that of the covariance, and what is beyond."""

from __future__ import annotations

import functools
import json

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.errors import InputError

BEAM = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
WAY = "0.09 rad/pitch"


@functools.cache
def fitted():
    true = BEAM.replace(friction={"mu": 0.3}, joint={"stiffness": 0.75})
    c = squama.cycle(true, WAY, joint="hinge", ideal=True, points=60)
    T = c["T"].values + np.random.default_rng(1).normal(0, 0.02, c.phi.size)
    data = {"phi": c.phi.values, "T": T}
    return squama.fit(data, BEAM, joint="hinge", nuisances="none", starts=1, machine="rigid"), c


@pytest.mark.slow
@pytest.mark.usefixtures("alone")
def test_the_band_is_that_of_the_covariance():
    fit, true = fitted()
    found = fit.predict(WAY, samples=400, points=60)
    x, leg, T = (found[name].values for name in ("phi", "leg", "T"))
    half = (found["T_high"] - found["T_low"]).values / 2
    drawn = fit.curve()
    for number in (1, 2):
        here = np.flatnonzero((leg == number) & (np.abs(x) > 0.065) & (np.abs(x) < 0.085))
        curve = np.flatnonzero(drawn.leg == number)
        order = curve[np.argsort(drawn.load[curve], kind="stable")]
        error = np.interp(x[here], drawn.load[order], drawn.error[order])
        # tolerance: quantiles of 400 draws, 8 %
        np.testing.assert_allclose(half[here], 1.96 * error, rtol=0.25)
        np.testing.assert_allclose(T[here], np.interp(x[here], drawn.load[order], drawn.torque[order]), rtol=1e-3)
    # before engagement nothing that is found counts
    straight = (np.abs(x) < 0.03) & (leg == 1)
    np.testing.assert_allclose(half[straight], 0, atol=1e-9)
    assert found["work_low"] < found["work"] < found["work_high"]
    assert found["work_low"] < np.trapezoid(true["T"].values, true.phi.values) < found["work_high"]
    assert fit.predict(WAY, samples=20, seed=3).identical(fit.predict(WAY, samples=20, seed=3))
    narrow = fit.predict(WAY, samples=400, probability=0.5)
    assert float((narrow["T_high"] - narrow["T_low"]).max()) < 0.5 * 2 * half.max()


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(
    ("given", "words"), [({"samples": 1}, "samples"), ({"probability": 1.0}, "probability"), ({"seed": -1}, "seed")]
)
def test_what_is_no_prediction(given, words):
    with pytest.raises(InputError, match=words):
        fitted()[0].predict(WAY, **given)


@pytest.mark.slow
def test_a_prediction_by_the_command_is_that_of_the_fit(tmp_path, capsys):
    fit, loop = fitted()
    table = tmp_path / "loop.csv"
    read = loop["T"].values + np.random.default_rng(1).normal(0, 0.02, loop.phi.size)
    rows = "".join(f"{x!r},{T!r}\n" for x, T in zip(loop.phi.values.tolist(), read.tolist(), strict=True))
    table.write_text(f"phi (rad),T (N m)\n{rows}")
    files = [tmp_path / f"band{ending}" for ending in (".csv", ".nc", ".png")]
    BEAM.to_toml(tmp_path / "beam.toml")
    command = [
        "fit",
        str(table),
        str(tmp_path / "beam.toml"),
        "--joint",
        "hinge",
        "--nuisances",
        "none",
        "--starts",
        "1",
    ]
    bands = [word for path in files for word in ("--band", str(path))]
    assert main([*command, "--machine", "rigid", "--predict", "0.08 rad/pitch", *bands, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["prediction"]
    kept = squama.read(files[1])
    top = int(np.abs(kept.phi.values).argmax())
    assert kept.phi.values[top] == pytest.approx(0.08)
    assert told["T_low"][top] < told["T"][top] < told["T_high"][top]
    np.testing.assert_allclose(told["T_high"], kept["T_high"].values)
    np.testing.assert_allclose(squama.read(files[0])["T_low"].values, kept["T_low"].values)
    best = fit.predict("0.08 rad/pitch")
    np.testing.assert_allclose(told["T"], best["T"].values, rtol=1e-6)
    np.testing.assert_allclose(told["T_high"], best["T_high"].values, rtol=1e-4)
    assert files[2].stat().st_size > 10_000
    assert main([*command, "--band", str(files[2])]) == 2
    assert '--predict "0.1 rad/pitch"' in capsys.readouterr().err
