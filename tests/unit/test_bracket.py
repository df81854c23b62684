"""One root on plain floats, against SciPy's Brent, and many in lock-step."""

import math
import random

import numpy as np
import pytest
from scipy.optimize import brentq

from squama.model.bracket import bracketed
from squama.model.solve import STILL, first_zero

FUNCTIONS = {
    "power": lambda x, c, w, k: (x - c) ** k,
    "step": lambda x, c, w, k: math.tanh((x - c) / w),
    "growth": lambda x, c, w, k: math.expm1(min((x - c) / w, 50)),
    "corner": lambda x, c, w, k: (x - c) / (1e-6 + abs(x - c)),
    "cubic": lambda x, c, w, k: (x - c) * (1 + ((x - c) / w) ** 2),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_as_good_as_brent(name):
    dice = random.Random(name)
    mine, brent = [0], [0]
    for _ in range(500):
        c, w = dice.uniform(-1, 1) * 10 ** dice.uniform(-12, 3), 10 ** dice.uniform(-8, 2)
        args = (c, w, dice.choice([1, 3, 5, 9]))
        low, high = c - w * dice.uniform(0.1, 3), c + w * dice.uniform(0.1, 3)

        def f(x, args=args, count=mine):
            count[0] += 1
            return FUNCTIONS[name](x, *args)

        x = bracketed(f, low, high)
        y = brentq(lambda x, args=args: f(x, args, brent), low, high, xtol=1e-300, rtol=8.9e-16, maxiter=500)
        assert abs(f(x)) <= abs(f(y)) or x == pytest.approx(y, rel=4e-15)
    assert mine[0] <= 2 * brent[0]


def test_ends_that_are_roots_and_brackets_that_hold_none():
    assert bracketed(lambda x: x - 1, 0.0, 1.0) == 1.0
    assert bracketed(lambda x: x, 0.0, 1.0) == 0.0
    assert math.isfinite(bracketed(lambda x: math.nan if x > 0.7 else 1 - 2 * x, 0.0, 1.0))
    with pytest.raises(ValueError, match="no change of sign"):
        bracketed(lambda x: x + 3, 0.0, 1.0)


@pytest.mark.parametrize("known", [False, True])
def test_many_lanes_at_once_are_as_good_as_one(known):
    """Simple zeros, as margins have them."""
    dice, n = np.random.default_rng(5), 3000
    c = dice.choice([-1, 1], n) * 10.0 ** dice.uniform(-9, 3, n)
    w = abs(c) * 10.0 ** dice.uniform(-2, 2, n)
    shape = dice.integers(0, 3, n)
    a, b = c - w * dice.uniform(0.1, 3, n), c + w * dice.uniform(0.1, 3, n)
    asked = []

    def f(x, c, w, shape):
        asked.append(x.size)
        z = (x - c) / w
        return -np.choose(shape, (np.sinh(np.clip(z, -20, 20)), np.tanh(5 * z), z + 100 * z**3))

    seen = (f(a, c, w, shape), f(b, c, w, shape), np.full(n, np.nan), np.full(n, np.nan)) if known else None
    x = first_zero(f, a, b, (c, w, shape), seen)
    assert np.max(abs(x - c) / abs(c)) <= STILL
    # lanes that are done are left out
    assert sum(asked) < 15 * n
    few = slice(0, n, 10)
    one = [
        bracketed(lambda v, i=i: float(f(np.array([v]), c[i], w[i], shape[i])[0]), a[i], b[i]) for i in range(n)[few]
    ]
    np.testing.assert_allclose(x[few], one, rtol=STILL)


def test_lanes_without_a_change_of_sign_and_lanes_that_start_at_their_zero():
    def f(x, c):
        return np.where(x > c + 0.5, np.nan, c - x)

    c = np.array([0.3, 2.0, 0.0, -1.0, 0.9])
    x = first_zero(f, np.zeros(5), np.ones(5), (c,))
    assert x[[0, 4]] == pytest.approx([0.3, 0.9], rel=1e-15)
    assert x[2] == 0
    assert np.isnan(x[[1, 3]]).all()
