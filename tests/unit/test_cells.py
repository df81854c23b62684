"""Cells with a scale on each face: two scales that share the strains of the bar, by the compiled solver."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.contacts import entry, increments, path
from squama.contacts.system import ENDLESS, EQUAL, UNTIED
from squama.curves import compliant

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")


def cells(b: entry.Beams, scales: int, *, periodic: bool) -> tuple[np.ndarray, np.ndarray]:
    """Follow so many scales of a beam to a twist and back; return the loads (m, 4) of a cell and motions (m, N, 6)."""
    twists = np.array([0.1, 0.2, 0.25, 0.2])
    ways = np.cumsum(np.abs(np.diff(twists, prepend=0.0)))[None]
    strains, m = np.zeros((1, 4, 4)), len(twists)
    strains[0, :, 1] = twists
    sizes = (m, increments.LINE), (m, scales, 6), (m, scales, 24), (m, 8, increments.CONTACT), (999, 99), (4,)
    found, none = increments.Written(*(np.zeros((1, *size)) for size in sizes)), np.zeros((1, 0))
    legs = increments.Legs(ways, strains, np.zeros(1), path.STEP)
    entry.many(b, scales, ENDLESS if periodic else EQUAL, UNTIED, 8 * scales, legs, found, none, none)
    assert found.ends[0, 0] == increments.RANGE
    return found.rows[0, :, 5:9], found.motions[0]


def beams_of(beam: squama.Beam, mu: float = 0.3) -> entry.Beams:
    """Return a beam for the solver."""
    held, scale = compliant.Held.of(beam), path.Scale(*np.array([compliant.scale(beam, ideal=False)]).T)
    return path.beams(scale, held.K[None], np.array([mu]), **held.bar)


@pytest.mark.parametrize("faces", ["mirrored", "turned"])
def test_two_cells_with_both_faces_do_what_one_does(faces):
    """Their neighbours are of the same face, and loads those of one cell."""
    b = beams_of(SKIN.replace(faces=faces, hold="nothing"))
    (one, q), (two, p) = (cells(b, n, periodic=True) for n in (2, 4))
    np.testing.assert_allclose(two, one, rtol=0, atol=1e-7 * np.abs(one).max())
    np.testing.assert_allclose(p, np.concatenate([q, q], axis=1), rtol=0, atol=1e-6 * np.abs(q).max())


def test_a_held_row_of_both_faces_is_two_rows():
    """Three cells with ends: nothing but the bar, which counts once, is shared."""
    both = SKIN.replace(faces="turned", hold="straight")
    b, n = beams_of(both, 0.0), 3
    loads, q = cells(b, 2 * n, periodic=False)
    alone, p = cells(beams_of(SKIN.replace(hold="straight"), 0.0), n, periodic=False)
    np.testing.assert_allclose(q[:, ::2], p, rtol=0, atol=1e-8)
    np.testing.assert_allclose(q[:, 1::2], p, rtol=0, atol=1e-8)
    twists = np.array([0.1, 0.2, 0.25, 0.2])
    bar = compliant.Held.of(both).own[1] * twists
    np.testing.assert_allclose(loads[:, 1], 2 * alone[:, 1] - bar, rtol=1e-7)
