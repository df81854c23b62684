"""Derivatives of designs through the contact solver, against differences of the real path; E = d = 1."""

from __future__ import annotations

import numpy as np
import pytest

from squama.contacts import increments, path
from squama.contacts.moved import moved
from squama.joints import law, processes
from squama.types import Array

STEP = 1e-30
SLENDER = {"eta": 3.2, "beta": 0.8, "lam": 0.4, "alpha": 0.9, "theta0": 0.3, "h": 0.03, "mu": 0.2, "D": np.inf}
SOFT = {"eta": 4.513, "beta": 0.866, "lam": 0.455, "alpha": 0.671, "theta0": 0.113, "h": 0.029, "mu": 0.1, "D": 0.045}
SOFTER = {"eta": 4.334, "beta": 0.905, "lam": 0.376, "alpha": 1.076, "theta0": 0.21, "h": 0.018, "mu": 0.0, "D": 0.011}
STEEP = {"eta": 3.816, "beta": 0.662, "lam": 0.335, "alpha": 0.863, "theta0": 0.101, "h": 0.042, "mu": 0.3, "D": np.inf}
LONG = {"eta": 4.68, "beta": 0.313, "lam": 0.512, "alpha": 0.501, "theta0": 0.226, "h": 0.032, "mu": 0.3, "D": np.inf}
FIGURES = [path.COLUMNS.index(name) for name in ("T", "M", "N", "W_fr", "W", "energy", "u_Z", "w_X", "x", "psi")]
AT = np.linspace(0.004, 0.3, 75)
E, S = increments.ENGAGE, increments.SNAP


def made(sizes: dict[str, float], n: int = 1, **changes: Array) -> path.entry.Beams:
    """Return a beam n times, each with changes (n,) of its own, the joint's among them."""
    g = {name: np.full(n, v) + changes.get(name, 0.0) for name, v in sizes.items()}
    one = np.ones(n)
    shape = law.Shape(2.0 * one, g["lam"], 0.3 * one, g["beta"], g["h"], g["alpha"], g["theta0"], 0.45 * one)
    scale = path.Scale(**{name: v for name, v in g.items() if name != "mu"}, nu=0.3 * one)
    # one fit for all: what follows is of the path
    return path.beams(scale, law.stiffness(shape, processes.shipped()), g["mu"], free=path.STRETCHING)


def names(sizes: dict[str, float]) -> list[str]:
    return [name for name, v in sizes.items() if np.isfinite(v) and v > 0.0]


def derived(sizes: dict[str, float], at: Array = AT, corners: Array | None = None) -> path.Answers:
    """Return the beam's path, once for each of its sizes, which is changed."""
    n = len(names(sizes))
    steps = {name: STEP * 1j * (np.arange(n) == i) for i, name in enumerate(names(sizes))}
    corners = None if corners is None else corners[None].repeat(n, axis=0)
    return moved(made(sizes, n, **steps), np.repeat(at[None], n, axis=0), n, most=0.0, corners=corners)


def differences(sizes: dict[str, float], name: str, step: float, at: Array, corners: Array | None) -> Array:
    both = made(sizes, 2, **{name: step * sizes[name] * np.array([1.0, -1.0])})
    corners = None if corners is None else corners[None].repeat(2, axis=0)
    rows = path.follow_all(both, np.repeat(at[None], 2, axis=0), most=0.0, corners=corners).rows
    return (rows[0] - rows[1]) / (2 * step * sizes[name])


def missed(sizes: dict[str, float], found: path.Answers, at: Array = AT, corners: Array | None = None) -> Array:
    """Return by how much derivatives miss differences (sizes, figures), of the largest one along the path."""
    out = np.full((len(names(sizes)), len(FIGURES)), np.inf)
    for i, name in enumerate(names(sizes)):
        exact = found.rows[i][:, FIGURES].imag / STEP
        for step in (1e-4, 3e-5):
            by = differences(sizes, name, step, at, corners)[:, FIGURES]
            known = np.isfinite(exact) & np.isfinite(by)
            size = np.maximum(np.abs(np.where(known, exact, 0.0)).max(axis=0), 1e-9)
            out[i] = np.minimum(out[i], (np.abs(np.where(known, exact - by, 0.0)) / size).max(axis=0))
    return out


def kinds(found: path.Answers) -> list[int]:
    return found.events[0, : int(found.ends[0, 2]), 0].real.astype(int).tolist()


@pytest.mark.parametrize(
    ("sizes", "events", "tolerance"),
    [
        (SLENDER, [E], 1e-4),
        (SLENDER | {"D": 0.5}, [E], 3e-3),
        (SOFT, [E, E, E], 1e-2),
        (SOFTER, [E, E, E, E], 2e-2),
        (STEEP, [E, increments.STICK, increments.SLIDE], 3e-2),
    ],
)
def test_derivatives_are_those_of_the_path(sizes: dict[str, float], events: list[int], tolerance: float) -> None:
    found = derived(sizes)
    assert kinds(found) == events
    assert np.isfinite(found.rows[:, :, FIGURES[0]].imag).all()
    # tolerance: differences of paths whose increments are others, 3e-7, 4e-5, 4e-4, 1e-4 and 5e-4 measured
    assert missed(sizes, found).max() < tolerance


def test_derivatives_there_and_back_along_a_polygon() -> None:
    ways = np.linspace(0.01, 0.3, 30)
    phi = np.where(ways < 0.2, ways, 0.4 - ways)
    corners = np.column_stack([0.1 * phi, phi])
    found = derived(SLENDER, ways, corners)
    assert kinds(found)[:2] == [E, increments.SLIDE]
    # tolerance: differences, 2e-6 measured
    assert missed(SLENDER, found, ways, corners).max() < 1e-3


def test_real_parts_and_engagement() -> None:
    found, real = derived(SLENDER), path.follow_all(made(SLENDER), AT[None], most=0.0)
    # Newton's method has another Jacobian where one is noted
    np.testing.assert_allclose(found.rows[2].real, real.rows[0], rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(found.contacts[2].real, real.contacts[0], rtol=1e-9, atol=1e-10)
    for i, name in enumerate(names(SLENDER)):
        step = 1e-4 * SLENDER[name]
        both = path.follow_all(made(SLENDER, 2, **{name: step * np.array([1.0, -1.0])}), np.repeat(AT[None], 2, axis=0))
        by = (both.contacts[0, 3:] - both.contacts[1, 3:]) / (2 * step)
        # tolerance: differences, 2e-7 measured
        np.testing.assert_allclose(found.contacts[i, 3].imag / STEP, by[0], rtol=1e-4, atol=1e-5)


def test_no_derivatives_behind_a_snap() -> None:
    found = derived(LONG)
    at = kinds(found).index(S)
    way = found.events[0, at, 1].real
    T = found.rows[:, :, FIGURES[0]]
    assert np.isfinite(T.real).all()
    assert np.isfinite(T.imag[:, way > AT]).all()
    assert np.isnan(T.imag[:, way < AT]).all()


def test_steps_of_targets_go_along_the_path() -> None:
    beams = made(SLENDER)
    found = moved(beams, AT[None] * (1 + STEP * 1j), 1, most=0.0)
    T, phi = found.rows[0, :, FIGURES[0]], AT
    touched = found.contacts[0, 3].real < 0.98 * phi
    slope = np.gradient(T.real, phi, edge_order=2)
    # tolerance: parabolas through points, 2e-3 measured
    inside = touched & (np.arange(phi.size) < phi.size - 1)
    np.testing.assert_allclose(T.imag[inside] / STEP / phi[inside], slope[inside], rtol=0.05)


def test_notes_take_more_room_where_they_need_it(monkeypatch: pytest.MonkeyPatch) -> None:
    found = derived(SLENDER)
    monkeypatch.setattr("squama.contacts.moved.NOTES", 5_000)
    np.testing.assert_array_equal(derived(SLENDER).rows, found.rows)
