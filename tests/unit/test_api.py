"""The public functions over arrays: shapes, defaults, what is refused and in which words."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import squama
from squama.errors import InputError

SHAPE = {"eta": 3, "beta": 1.25, "lam": 0.45, "alpha": math.radians(45)}
FRICTION = {"theta0": math.radians(10), "mu": 0.5}
BEAM = squama.Beam.from_ratios(mu=0.5)
CALLS = {
    "contact": lambda **k: squama.contact(**{"theta": 0.5, **SHAPE, **k}),
    "forces": lambda **k: squama.forces(**{"theta": 0.5, **SHAPE, **FRICTION, **k}),
    "ends": lambda **k: squama.ends(**{**SHAPE, **FRICTION, **k}),
    "twist": lambda **k: squama.twist(BEAM, **k),
    "bend": lambda **k: squama.bend(BEAM, **k),
}
RATIOS = ("contact", "forces", "ends")
BAD = [
    *((f, {name: v}, name, "above 0") for f in RATIOS for name in ("lam",) for v in (0.0, -1.0)),
    *((f, {n: v}, n, "above 0; write e.g.") for f in ("contact", "forces") for n in ("eta", "beta") for v in (0, -1.0)),
    *((f, {n: v}, n, "up to 100; write e.g.") for f in ("ends",) for n in ("eta", "beta") for v in (0, -1.0, 101, 1e9)),
    *((f, {"mu": -1}, "mu = -1", "0 or more; write e.g. 0.25") for f in ("forces", "ends", "twist", "bend")),
    *((f, {"margin": 2}, "margin = 2", "write e.g. 0.01") for f in ("twist", "bend")),
    *((f, {"points": 2.5}, "points = 2.5", "write e.g. 200") for f in ("twist", "bend")),
    *((f, {"at": ["1 rad/m", v]}, "at = ", "write") for f in ("twist", "bend") for v in ("90 deg", "3 mm", "x")),
    *(
        (f, {name: v}, name, "finite")
        for f in RATIOS
        for name in ("eta", "beta", "lam", "alpha")
        for v in (math.nan, math.inf)
    ),
    *((f, {"alpha": v}, "alpha", "radians") for f in RATIOS for v in (-0.1, math.pi / 2, 45)),
    *((f, {"theta": v}, "theta", "radians") for f in ("contact", "forces") for v in (0.0, math.pi, 50)),
    *((f, {"theta0": v}, "theta0", "radians") for f in ("forces", "ends") for v in (0.0, math.pi / 2, 10)),
    *((f, {"mu": v}, "mu", "0 or more") for f in ("forces", "ends", "twist", "bend") for v in (-0.1, [0.1, -0.2])),
    *((f, {"mu": v}, "mu", "finite") for f in ("forces", "ends", "twist", "bend") for v in (math.nan, math.inf)),
    *((f, {"mu": "rough"}, "mu", "number") for f in ("forces", "ends", "twist", "bend")),
    *((f, {"law": v}, "law", '"edge" or "plate"') for f in ("forces", "ends", "twist") for v in ("Edge", "", "paper")),
    *(
        (f, {"sense": v}, "sense", '"+" or "-"')
        for f in ("contact", "forces", "ends", "twist")
        for v in ("", "*", "left")
    ),
    ("ends", {"contacts": "some"}, "contacts", '"tip" or "all"'),
    ("ends", {"eta": [1.0, 2.0], "mu": [0.1, 0.2, 0.3]}, "shapes", "broadcast"),
    *((f, {"eta": [1.0, 2.0], "theta": [0.1, 0.2, 0.3]}, "shapes", "broadcast") for f in ("contact", "forces")),
    *((f, {"neighbour": v}, "neighbour", "1") for f in ("contact", "forces") for v in (0, -1, 1.5, 1001)),
    *((f, {"margin": v}, "margin", "below 1") for f in ("twist", "bend") for v in (0.0, 1.0, -0.01, 2)),
    *((f, {"margin": math.nan}, "margin", "finite") for f in ("twist", "bend")),
    *((f, {"margin": [0.1, 0.2]}, "margin", "one number") for f in ("twist", "bend")),
    *((f, {"points": v}, "points", "from 3") for f in ("twist", "bend") for v in (0, 2, -5, 3.7, 1_000_001)),
    *((f, {"at": v}, "at", "0 or more") for f in ("twist", "bend") for v in (-1.0, [1.0, -2.0])),
    *((f, {"at": [[1.0, 2.0]]}, "at", "sequence") for f in ("twist", "bend")),
    *((f, {"at": [1.0, math.nan]}, "at", "finite") for f in ("twist", "bend")),
    *((f, {"to": v}, "to", "above 0") for f in ("twist", "bend") for v in (0.0, -2.0, "-1 rad/m")),
    *((f, {"mu": v}, "mu", "sequence") for f in ("twist", "bend") for v in ([], [[0.1]])),
]


@pytest.mark.parametrize(("function", "given", "name", "allowed"), BAD)
def test_bad_arguments_are_refused_in_one_line(function: str, given: dict, name: str, allowed: str) -> None:
    with warnings.catch_warnings(), pytest.raises(InputError) as caught:
        CALLS[function](**given)
    text = str(caught.value)
    assert "\n" not in text
    assert name in text
    assert allowed in text
    assert len(text) < 200


@pytest.mark.parametrize("to", ["90 deg", "3 mm", "fast", "", "nan rad/m"])
def test_bad_twists_are_refused(to: str) -> None:
    for call in (CALLS["twist"], CALLS["bend"]):
        with pytest.raises(InputError) as caught:
            call(to=to)
        assert "\n" not in str(caught.value)


def test_degrees_are_recognised() -> None:
    with pytest.raises(InputError, match=r"np\.radians\(45\)"):
        CALLS["contact"](alpha=45)
    with pytest.raises(InputError, match=r"eta = -1 \(and 1 more\)"):
        CALLS["ends"](eta=[-1, 2, -3])


def test_friction_must_be_given() -> None:
    with pytest.raises(InputError, match=r"mu: is not given; .*\[friction\]"):
        squama.twist(squama.Beam.from_ratios(), joint="hinge")
    with pytest.raises(InputError, match="mu: is not given"):
        squama.bend(squama.Beam.from_ratios())


@pytest.mark.parametrize("function", ["contact", "forces"])
def test_scalars_arrays_and_broadcasting(function: str) -> None:
    theta = np.radians([[12.0, 30.0, 60.0]])
    eta = np.array([[2.0], [3.0]])
    both = CALLS[function](theta=theta, eta=eta)
    assert {np.shape(v) for v in both} == {(2, 3)}
    for i in range(2):
        for j in range(3):
            one = CALLS[function](theta=theta[0, j], eta=eta[i, 0])
            assert {np.shape(v) for v in one} == {()}
            for got, want in zip(one, both, strict=True):
                assert got == pytest.approx(want[i, j], rel=1e-13, abs=1e-15)
    # lists and whole numbers
    lists = CALLS[function](theta=theta[0].tolist(), eta=3)
    np.testing.assert_allclose(lists[0], both[0][1], rtol=1e-13)


def test_no_twist_of_contact_is_nan_and_silent() -> None:
    c = squama.contact([0.5, 0.7], **{**SHAPE, "alpha": math.radians(5)})
    assert np.isfinite(c.phi[0])
    assert np.isnan(c.phi[1])
    assert c.on_edges.tolist() == [True, False]
    f = squama.forces([0.5, 0.7], **{**SHAPE, "alpha": math.radians(5)}, **FRICTION)
    assert np.isnan(f.torque[1])


def test_places_off_the_edges_are_told() -> None:
    theta = np.radians([30.0, 60.0, 75.0])
    c = squama.contact(theta, **{**SHAPE, "beta": 0.5, "alpha": math.radians(30)})
    off = (abs(c.p) > 0.5) | (c.s < 0) | (c.s > 3)
    assert off.any()
    assert not off.all()
    assert c.on_edges.tolist() == (~off).tolist()


def test_rates_of_places_are_derivatives() -> None:
    theta, h = np.radians([12.0, 40.0, 80.0]), 1e-6
    for extra in (
        {},
        {"neighbour": 2},
        {"sense": "-", "eta": 4, "alpha": 1.0, "beta": 0.5, "lam": 0.6, "theta": theta / 10},
    ):
        at = {**SHAPE, "theta": theta, **extra}
        here = CALLS["contact"](**at)
        up, down = (CALLS["contact"](**{**at, "theta": at["theta"] + s * h}) for s in (1, -1))
        for name in ("phi", "s", "p"):
            slope = (getattr(up, name) - getattr(down, name)) / (2 * h)
            np.testing.assert_allclose(getattr(here, f"d{name}_dtheta"), slope, rtol=1e-5, atol=1e-6)


def test_forces_beyond_a_lock_change_sign_there() -> None:
    lock = float(squama.ends(**SHAPE, **FRICTION).theta_end)
    f = squama.forces([lock - 1e-6, lock + 1e-6], **SHAPE, **FRICTION)
    assert f.normal[0] > 1e4
    assert f.normal[1] < -1e4


def test_the_facade_lists_what_it_offers() -> None:
    for name in squama.__all__:
        assert getattr(squama, name) is not None
    assert set(squama.__all__) <= set(dir(squama))
    with pytest.raises(AttributeError, match="no attribute 'untwist'"):
        _ = squama.untwist
    assert squama.Contact._fields[:3] == ("phi", "p", "s")
    assert squama.Forces._fields[:3] == ("normal", "friction", "torque")
    assert squama.Ends._fields[5:] == ("other", "sense", "phi_touch", "theta_touch")
    assert squama.Ends._fields[:5] == ("phi_e", "theta_end", "phi_end", "end", "neighbour")
