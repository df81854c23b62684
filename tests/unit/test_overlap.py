"""Vertices of the overlap of two plates: which there are, their gaps, and the bounds by which pairs are passed over."""

import mpmath
import numba
import pytest
from uncompiled import said

from squama.contacts.geometry import slopes
from squama.contacts.vectors import turned


@pytest.mark.parametrize("pairs", ["1", pytest.param("6", marks=pytest.mark.slow)])
def test_vertices_and_their_slopes_are_those_of_plain_geometry(pairs):
    """Corners, crossings and tangent points: all of them, below any cap, with the gap and the slopes beside them.

    An edge that is tangent nowhere is replaced by the deepest of its ends. One that leaves a face, or ends over it,
    becomes a contact at the same places.
    """
    found = said("overlaps.py", pairs)
    assert found.pop("ends") == found.pop("left") == 0
    assert found.pop("spans") < 1e-13
    waves = found.pop("waves")
    assert waves["twice"] > 0
    assert waves["met"] == 0
    # the set, what is below a cap, and bounds are right or wrong
    for missed in found.values():
        assert missed["set"] == missed["caps"] == missed["clear"] == 0
        assert missed["bounds"] < 1e-14
        assert missed["unfolded"] == 0
    assert max(found["rigid"].values()) < 1e-14
    bent = found["bent"]
    assert bent["unfolds"] > 0
    # tolerance: bounds that let far pairs be passed over
    assert bent["wide"] < 3
    # tolerance: crossings of bent edges are found by four steps, 2e-8 measured
    assert max(bent["gaps"], bent["edges"], bent["again"]) < 1e-7
    assert bent["beside"] < 1e-14
    # tolerance: what the gap may be less between two places that are looked at
    assert max(bent["least 0"], bent["least 1"]) < 1e-3
    # tolerance: differences
    assert bent["slopes"] < 1e-8


@numba.njit
def _coefficients(t):
    e = turned((0.6 * t, 0.0, 0.8 * t))
    return (e.a, e.b, e.c, *slopes(e))


@pytest.mark.parametrize("t", [1e-3, 0.1, 0.2236, 0.2237, 1.0, 3.0])
def test_coefficients_of_rotations_and_their_slopes(t):
    """By series below the root of 0.05, by sines above."""

    def a(q):
        return mpmath.sin(mpmath.sqrt(q)) / mpmath.sqrt(q)

    def b(q):
        return (1 - mpmath.cos(mpmath.sqrt(q))) / q

    def c(q):
        return (1 - a(q)) / q

    with mpmath.workdps(40):
        q = mpmath.mpf(t) ** 2
        exact = [a(q), b(q), c(q), mpmath.diff(b, q), mpmath.diff(c, q)]
    assert _coefficients(t) == pytest.approx([float(v) for v in exact], rel=1e-11)
