"""The JAX engine: it agrees with the NumPy engine, minds the user's settings, and says when JAX is missing."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import squama
from properties.designs import many, mirrored
from squama.model import energy, mechanics
from squama.model.paths import Twist

PAPER = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": np.pi / 4, "theta0": np.radians(10), "mu": 0.5}


@pytest.mark.parametrize("law", ["edge", "plate"])
@pytest.mark.parametrize("sense", ["+", "-"])
def test_agrees_with_numpy(law: str, sense: str) -> None:
    pytest.importorskip("jax")
    n = 3000
    columns = many(n, 41) if sense == "+" else mirrored(n, 42)
    columns["stiffness_ratio"] = np.linspace(0, 50, n)
    mine = squama.solve(**columns, law=law, sense=sense, engine="jax")
    theirs = squama.solve(**columns, law=law, sense=sense, engine="numpy")
    assert np.array_equal(mine.end, theirs.end)
    assert np.array_equal(mine.neighbour, theirs.neighbour)
    for name in ("load_e", "theta_end", "load_end", "theta_c", "load_c", "f0", "torque", "U_el", "W_fr", "RED"):
        value = getattr(mine, name)
        assert isinstance(value, np.ndarray)
        assert value.dtype == np.float64
        # where a lock follows engagement at once, the last digit of its place shows in the distance from it
        with np.errstate(divide="ignore"):
            digit = 2e-15 * theirs.theta_end / (0.01 * (theirs.theta_end - columns["theta0"]))
        allowed = (1e-9 + np.where(theirs.f0 > 0, digit, 0)) * np.abs(getattr(theirs, name)) + 1e-13
        same = value == getattr(theirs, name)
        with np.errstate(invalid="ignore"):
            assert (same | (np.abs(value - getattr(theirs, name)) <= allowed)).all(), name


@pytest.mark.parametrize("margin", [0.3, 1e-5])
def test_margins_shapes_and_bending(margin: float) -> None:
    pytest.importorskip("jax")
    design = PAPER | {"mu": np.array([[0.0, 0.2], [0.5, 30.0]])}
    for settings in ({"law": "plate"}, {"load": "bending"}):
        mine = squama.solve(**design, **settings, margin=margin, engine="jax")
        theirs = squama.solve(**design, **settings, margin=margin, engine="numpy")
        assert mine.RED.shape == (2, 2)
        assert np.array_equal(mine.end, theirs.end)
        np.testing.assert_allclose(mine.W_fr, theirs.W_fr, rtol=1e-9)
        np.testing.assert_allclose(mine.torque, theirs.torque, rtol=1e-9)


def test_most_designs_are_not_handed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("jax")
    from squama.engines import xla

    handed = []
    run = xla.reference.run

    def spy(problem: Any) -> Any:
        handed.append(problem.eta.size)
        return run(problem)

    monkeypatch.setattr(xla.reference, "run", spy)
    n = 1000
    columns = PAPER | {"mu": np.linspace(0.05, 1, n)}
    squama.solve(**columns, engine="jax")
    assert sum(handed) < 0.2 * n


@pytest.mark.parametrize("user", [False, True])
def test_the_settings_of_the_user_stay(user: bool) -> None:
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    try:
        jax.config.update("jax_enable_x64", user)
        kind = jax.numpy.ones(3).dtype
        s = squama.solve(**PAPER, engine="jax")
        assert jax.config.jax_enable_x64 is user
        assert jax.numpy.ones(3).dtype == kind
        assert kind == (np.float64 if user else np.float32)
        assert s.W_fr == pytest.approx(1.7751860, rel=1e-7)
        # and within the user's own compiled code of single precision
        assert jax.jit(lambda x: 2 * x)(np.float32(1.5)).dtype == np.float32
    finally:
        jax.config.update("jax_enable_x64", before)


def test_few_programs_are_compiled() -> None:
    pytest.importorskip("jax")
    from squama.engines import xla

    for n in (3, 40, 500, 1024):
        squama.solve(**(PAPER | {"mu": np.linspace(0.1, 0.9, n)}), engine="jax")
    # of single and of many designs one program: blocks are padded to one size
    assert xla.compiled("block", law="edge")._cache_size() <= len(xla.SIZES["cpu"])  # type: ignore[attr-defined]


def test_without_jax_the_message_tells_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "jax", None)
    with pytest.raises(squama.InputError) as caught:
        squama.solve(**PAPER, engine="jax")
    assert "pip install squama[jax]" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_gradient_against_jax(law: str) -> None:
    """At frictional locks: one Newton step from the solved lock makes JAX's forward mode see it move."""
    jax = pytest.importorskip("jax")
    from squama.engines import xla, xla_paths

    columns = many(300, 43)
    solved = squama.solve(**columns, law=law, margin=0.05)
    chosen = np.flatnonzero((solved.end == "frictional lock") & (solved.neighbour == 1))
    columns = {name: v[chosen] for name, v in columns.items()}
    # open paths only: the derivative of what the fold moves is not in this test
    names = ("eta", "beta", "lam", "alpha", "theta0", "mu")
    g = squama.gradient(**columns, law=law, margin=0.05, wrt=names)

    def figures(values: Any, lock: Any) -> Any:
        jnp, ops = jax.numpy, xla_paths.operations()
        eta, beta, lam, alpha, theta0, mu = values
        row = Twist(eta, beta, lam, jnp.sin(alpha), jnp.cos(alpha), theta0)

        def D(x: Any) -> Any:
            return mechanics.forces(row.point(x, law, ops), theta0, mu).D

        x_end = lock - D(lock) / jax.lax.stop_gradient(jax.grad(D)(lock))
        x_c = theta0 + 0.95 * (x_end - theta0)
        pt = row.point(x_c, law, ops)
        f = mechanics.forces(pt, theta0, mu)
        one = Twist(*(jnp.reshape(v, 1) for v in row))
        work, _ = xla_paths.works(one, mu, x_c, x_end, law, 4 * energy.FEW_NODES)
        lift = pt.theta - theta0
        load_end = row.point(x_end, law, ops).load
        return jnp.stack(
            [x_end, load_end, pt.theta, pt.load, f.f * eta, f.torque, lift**2 / 2, work[0]],
        )

    of = ("theta_end", "load_end", "theta_c", "load_c", "f0", "torque", "U_el", "W_fr")
    with xla.double(jax):
        values = np.stack([columns[name] for name in names])
        lock = solved.theta_end[chosen]
        slopes = np.asarray(jax.vmap(jax.jacfwd(figures), (1, 0))(values, lock))
    open_path = np.isfinite(slopes).all(axis=(1, 2)) & ~folded(columns, law)
    assert open_path.sum() > 80
    mine = np.moveaxis(np.stack([[g[o, w] for w in names] for o in of]), 2, 0)
    size = np.abs(slopes).max(axis=2, keepdims=True)
    assert (np.abs(mine - slopes)[open_path] <= 1e-8 * size[open_path] + 1e-12).all()


def folded(columns: dict[str, np.ndarray], law: str) -> np.ndarray:
    """Whether the path is followed through a fold."""
    from squama.model.paths import FoldedTwist
    from squama.model.solution import solve_twisting

    found = np.zeros(columns["eta"].size, bool)
    for index, track in solve_twisting(*columns.values(), law=law, sense="+").tracks:
        found[index] = isinstance(track.row, FoldedTwist)
    return found
