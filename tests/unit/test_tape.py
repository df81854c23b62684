"""Programs of NumPy's functions against the formulas they were made of."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from squama.model import formulas, mechanics, tape
from squama.model.paths import ARRAY, FoldedTwist, Point, Twist
from squama.model.tape import Tape


def rows(n, kind=Twist):
    """Rows of contacts, most of which exist, of next neighbours."""
    dice = np.random.default_rng(n)
    alpha = dice.uniform(0.2, 1.2, n)
    columns = [dice.uniform(2, 5, n), dice.uniform(0.3, 1, n), dice.uniform(0.05, 0.2, n), np.sin(alpha), np.cos(alpha)]
    fold = [np.full(n, 0.9)] if kind is FoldedTwist else []
    return kind(*columns, np.full(n, 0.1), *fold, np.ones(n)), dice.uniform(0.1, 0.5, n)


@pytest.mark.parametrize("kind", [Twist, FoldedTwist])
@pytest.mark.parametrize("law", ["edge", "plate"])
@pytest.mark.parametrize("shape", [(9,), (300,), (7, 300), (5, 6000), (3, tape.PIECE + 5), (200, 90)])
def test_what_is_evaluated_at_many_places_is_the_contact_itself(kind, law, shape):
    row, mu = rows(shape[-1], kind)
    x = np.random.default_rng(1).uniform(0.11, 0.6, shape) * (1 if kind is Twist else -1)
    with np.errstate(all="ignore"):
        pt = row.point(x, law, ARRAY)
        each = mechanics.named_margins(row, pt, mu)
        found = formulas.margins(row, x, mu, law)
        work, least, points = (
            formulas.power(row, x, mu, law),
            formulas.least(row, x, mu, law),
            formulas.point(row, x, law),
        )
        given = np.empty((len(each) + 2, *shape))
        formulas.margins(row, x, mu, law, given)
        want = mechanics.forces(pt, row.theta0, mu).f * pt.slip_rate
    assert np.isfinite(found[0]).any()
    np.testing.assert_array_equal(given, found)
    np.testing.assert_array_equal(least, found[0])
    for got, values in zip(found[2:], each, strict=True):
        np.testing.assert_allclose(got, values, rtol=1e-14)
    np.testing.assert_allclose(found[0], np.min(np.broadcast_arrays(*each), axis=0), rtol=1e-14)
    np.testing.assert_allclose(work, want, rtol=1e-13)
    if kind is Twist:
        np.testing.assert_allclose(formulas.square(row, x), row.root(x, ARRAY).q2, rtol=1e-13, atol=1e-15)
    for name in Point._fields:
        np.testing.assert_allclose(getattr(points, name), np.broadcast_to(getattr(pt, name), shape), rtol=1e-14)


def test_lengths_are_in_units_of_the_neighbour_s_pitch():
    """Margins of places shrink with the unit, work does not."""
    row, mu = rows(500)
    far = row._replace(eta=2 * row.eta, beta=2 * row.beta, lam=2 * row.lam, k=2 * row.k)
    x = np.full(500, 0.3)
    with np.errstate(all="ignore"):
        one = far.point(x, "edge", ARRAY)
        want = mechanics.forces(one, far.theta0, mu).f * one.slip_rate
        np.testing.assert_allclose(formulas.power(row, x, mu, "edge"), want, rtol=1e-13)
        np.testing.assert_allclose(formulas.point(far, x, "edge").p, 2 * formulas.point(row, x, "edge").p, rtol=1e-13)


def test_a_program_holds_what_its_results_need_and_no_more():
    def formula(x, a, b):
        np.arctan(x)  # nothing asks for it
        s = np.sin(a) * 2
        y = x / 1 * s - np.sin(a) * 2
        low = (x > 0) & (y <= b)
        return np.minimum(y, b) * low, y, x, s, y

    made = Tape(formula, 2)
    assert [step.fill for step in made.before] == [np.sin, np.multiply]
    names = [step.fill.__name__.strip("_") for step in made.steps]
    assert names == [
        "multiply",
        "subtract",
        "greater",
        "less_equal",
        "multiply",
        "minimum",
        "multiply",
        *["positive"] * 3,
    ]
    assert made.registers == 2
    dice = np.random.default_rng(3)
    x, a, b = dice.normal(size=(4, 50)), dice.normal(size=50), dice.normal(size=50)
    for got, want in zip(made(x, a, b), formula(x, a, b), strict=True):
        np.testing.assert_array_equal(got, np.broadcast_to(want, x.shape))


def test_threads_do_not_share_places():
    row, mu = rows(3000)
    xs = [np.random.default_rng(i).uniform(0.11, 0.4, (5, 3000)) for i in range(8)]

    def work(x):
        with np.errstate(all="ignore"):
            return formulas.power(row, x, mu, "edge")

    want = [work(x) for x in xs]
    with ThreadPoolExecutor(4) as pool:
        for got, values in zip(pool.map(work, xs), want, strict=True):
            np.testing.assert_array_equal(got, values)
