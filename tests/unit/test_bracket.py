"""One root on plain floats, against SciPy's Brent."""

import math
import random

import pytest
from scipy.optimize import brentq

from squama.model.bracket import bracketed

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
