"""One root on plain floats, against SciPy's Brent."""

import math
import random
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from squama.model.bracket import STILL, bracketed, zero
from squama.model.tracks import at_loads

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
        assert abs(f(x)) <= abs(f(y)) or x == pytest.approx(y, rel=1e-13)
    assert mine[0] <= 2 * brent[0]


def test_many_roots_at_once_are_held_between_their_bounds():
    """Of a load that levels off, where a step of Newton's leads far out."""

    class Path:
        def point(self, x, law, ops):
            assert ((x >= 0) & (x <= 1)).all()
            return SimpleNamespace(load=np.arctan(40 * (x - 0.7)), load_rate=40 / (1 + (40 * (x - 0.7)) ** 2))

    want = np.linspace(0.0, 1.0, 21)
    low, high = np.zeros(21), np.ones(21)
    load, ends = np.arctan(40 * (want - 0.7)), (np.full(21, np.arctan(-28)), np.full(21, np.arctan(12)))
    np.testing.assert_allclose(at_loads(Path(), load, (low, high), ends), want, atol=1e-12)
    # beyond the ends are the ends
    beyond = at_loads(Path(), np.array([-2.0, 2.0]), (low[:2], high[:2]), (ends[0][:2], ends[1][:2]))
    np.testing.assert_array_equal(beyond, [0, 1])


def test_ends_that_are_roots_and_brackets_that_hold_none():
    assert bracketed(lambda x: x - 1, 0.0, 1.0) == 1.0
    assert bracketed(lambda x: x, 0.0, 1.0) == 0.0
    assert math.isfinite(bracketed(lambda x: math.nan if x > 0.7 else 1 - 2 * x, 0.0, 1.0))
    with pytest.raises(ValueError, match="no change of sign"):
        bracketed(lambda x: x + 3, 0.0, 1.0)


def test_simple_zeros_in_few_steps_and_to_all_digits():
    """As margins have them: the place that interpolation hardly moves any more is the last."""
    dice, asked = random.Random(5), []
    for n in range(3000):
        c = dice.choice([-1, 1]) * 10.0 ** dice.uniform(-9, 3)
        w = abs(c) * 10.0 ** dice.uniform(-2, 2)

        def f(x, c, w, shape=n % 3):
            asked.append(x)
            z = (x - c) / w
            return -(math.sinh(min(max(z, -20), 20)), math.tanh(5 * z), z + 100 * z**3)[shape]

        a, b = c - w * dice.uniform(0.1, 3), c + w * dice.uniform(0.1, 3)
        third = a - w
        for at, value in ((a, f(a, c, w)), (third, f(third, c, w)), (a, math.nan)):
            x = zero(f, a, f(a, c, w), b, f(b, c, w), at, value, True, c, w)
            assert abs(x - c) <= STILL * abs(c)
    assert len(asked) < 45 * 3000


def test_what_is_no_number_counts_as_below_zero():
    def f(x, c):
        return math.nan if x > c + 0.5 else c - x

    for c in (0.3, 0.9):
        assert zero(f, 0.0, f(0.0, c), 1.0, f(1.0, c), 0.0, math.nan, True, c) == pytest.approx(c, rel=1e-13)
    assert zero(f, 0.0, 0.0, 1.0, -1.0, 0.0, math.nan, True, 0.0) == 0
