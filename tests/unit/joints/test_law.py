"""The law of the joint: what holds by construction, its derivatives, its file, and elements that were not fitted."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from shapes import drawn

import squama
from squama.beam import matrixfile
from squama.errors import InputError
from squama.fe.geometry import Geometry
from squama.joints import factor, law, processes

SAMPLE = Path(__file__).parents[3] / "tools" / "joint_law_sample.npz"
LATER = 100_000


def _between(n: int) -> law.Shape:
    """Return n shapes, half of them in the margin of the core or a little before and behind it."""
    some, rest = drawn(60 * n, seed=3, region=law.WHOLE), drawn(n - n // 2, seed=3, region=law.WHOLE)
    share = law.wider(some)
    near = some.at(np.flatnonzero((share > 0.05) & (share < 0.95))[: n // 2])
    assert len(near.zeta) == n // 2
    return law.Shape(*(np.append(a, b) for a, b in zip(near, rest, strict=True)))


def test_positive_definite_over_and_beyond_the_range() -> None:
    for wider, region, least in ((0.0, law.CORE, 1e-2), (0.3, law.CORE, 1e-9), (0.1, law.WHOLE, 1e-9)):
        K = law.stiffness(drawn(2000, wider=wider, region=region))
        np.testing.assert_allclose(K, np.swapaxes(K, 1, 2), rtol=0, atol=1e-14)
        d = np.sqrt(np.diagonal(K, axis1=1, axis2=2))
        assert np.linalg.eigvalsh(K / (d[:, :, None] * d[:, None, :])).min() > least


def test_a_negative_alpha_is_the_mirror() -> None:
    shape = drawn(50, region=law.WHOLE)
    M = np.diag(factor.MIRROR)
    there = law.stiffness(shape._replace(alpha=-shape.alpha))
    np.testing.assert_allclose(there, M @ law.stiffness(shape) @ M, rtol=1e-12, atol=1e-14)
    # what changes sign vanishes at alpha = 0
    flat = law.stiffness(shape._replace(alpha=0 * shape.alpha))
    np.testing.assert_allclose(flat, M @ flat @ M, rtol=0, atol=0)


def test_one_shape_and_many_are_the_same() -> None:
    shape = drawn(300, region=law.WHOLE)
    K = law.stiffness(shape)
    for i in (0, 150, 299):
        one = law.Shape(*(float(x[i]) for x in shape))
        assert law.stiffness(one).shape == (9, 9)
        np.testing.assert_allclose(law.stiffness(one), K[i], rtol=1e-7, atol=1e-10)
    # numbers beside arrays
    nu = law.stiffness(one._replace(nu=np.array([one.nu, 0.3])))
    np.testing.assert_allclose(nu[0], K[299], rtol=1e-7, atol=1e-10)


@pytest.mark.parametrize("name", law.Shape._fields)
def test_complex_steps_are_the_derivatives(name: str) -> None:
    # from the core, the rest, and the margin between them
    shape = _between(60)
    x = getattr(shape, name)
    h = 1e-5 * x
    slope = law.stiffness(shape._replace(**{name: x + 1e-30j})).imag / 1e-30
    ahead, behind = (law.stiffness(shape._replace(**{name: x + step})) for step in (h, -h))
    np.testing.assert_allclose(
        slope, (ahead - behind) / (2 * h[:, None, None]), rtol=5e-5, atol=5e-5 * np.abs(slope).max()
    )


def test_steps_in_many_ways_at_once() -> None:
    shape = _between(20)
    steps = 1e-30j * np.eye(8)
    many = law.Shape(*(x[:, None] + steps[k] for k, x in enumerate(shape)))
    K = law.stiffness(many)
    assert K.shape == (20, 8, 9, 9)
    np.testing.assert_allclose(K.real, np.repeat(law.stiffness(shape)[:, None], 8, axis=1), rtol=1e-8, atol=1e-9)
    for k, name in enumerate(law.Shape._fields):
        one = law.stiffness(shape._replace(**{name: shape[k] + 1e-30j})).imag
        np.testing.assert_allclose(K.imag[:, k], one, rtol=1e-6, atol=1e-8 * np.abs(one).max())
    # the factor's own, too
    whole = factor.factor(K)
    np.testing.assert_allclose(factor.product(whole).imag, K.imag, rtol=1e-10, atol=1e-14 * np.abs(K.imag).max())
    assert not np.triu(whole, 1).any()


def test_pivots_are_the_figures() -> None:
    K = law.stiffness(drawn(20))
    found = factor.pivots(K)
    inverse = np.linalg.inv(K[:, :6, :6])
    np.testing.assert_allclose(found[:, factor.K_THETA], 1 / inverse[:, 4, 4], rtol=1e-10)
    own = np.linalg.solve(K[:, :6, :6], K[:, :6, 6:7])
    rigidity = K[:, 6, 6] - (K[:, 6:7, :6] @ own)[:, 0, 0]
    np.testing.assert_allclose(found[:, factor.TWIST], rigidity, rtol=1e-10)
    np.testing.assert_allclose(found[:, factor.STRETCH], 1 / np.linalg.inv(K)[:, 8, 8], rtol=1e-10)
    np.testing.assert_allclose(factor.product(factor.factor(K)), K, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(factor.pivots(K[:, :7, :7]), found[:, :7], rtol=1e-12)


def test_scaled_to_measured_figures() -> None:
    K = law.stiffness(drawn(1))[0]
    for part in (K, K[:7, :7]):
        to = factor.scaled(part, K_theta=0.02, rigidity=0.5)
        before, after = factor.pivots(part), factor.pivots(to)
        assert after[factor.K_THETA] == pytest.approx(0.02, rel=1e-12)
        assert after[factor.TWIST] == pytest.approx(0.5, rel=1e-12)
        np.testing.assert_allclose(after[: factor.K_THETA], before[: factor.K_THETA], rtol=1e-10)
        # torque per twist is given beside the joint: nothing else changes by it
        alone = factor.scaled(part, rigidity=0.5) - part
        alone[factor.TWIST, factor.TWIST] = 0.0
        np.testing.assert_allclose(alone, 0, atol=1e-13)
        # a scale goes by itself with the twist as before
        own = [np.linalg.solve(x[:6, :6], x[:6, 6]) for x in (part, to)]
        np.testing.assert_allclose(*own, rtol=1e-10)
    np.testing.assert_allclose(factor.scaled(K), K, rtol=1e-12, atol=1e-15)
    # any torque per twist of a bar that may bow, which is limited by its bending without what acts beside it
    for rigidity in (0.01, 0.5, 50.0):
        found = matrixfile.twisting_stiffness(factor.scaled(K, rigidity=rigidity, free=(1, 0, 1, 1)), (1, 0, 1, 1))
        assert found == pytest.approx(rigidity, rel=1e-9)


def test_it_is_near_elements_that_were_not_fitted() -> None:
    with np.load(SAMPLE) as file:
        coarse, fine = (file[f"held_out_{name}"].astype(float) for name in ("coarse", "fine"))
        shapes, index = file["held_out_shape"], file["held_out_index"]
    i, j = np.tril_indices(9)
    limit = np.zeros((len(coarse), 9, 9))
    limit[:, i, j] = limit[:, j, i] = 2 * fine - coarse
    shape = law.Shape(*shapes.astype(float).T)
    inside = law.within(shape, law.CORE)
    off = factor.pivots(law.stiffness(shape)) / factor.pivots(limit) - 1
    # designs of higher numbers were drawn from a larger range, after the errors in the core had been stated
    core, later, rest = inside & (index < LATER), inside & (index >= LATER), law.within(shape) & ~inside
    told, beyond = law.errors(), law.errors(law.WHOLE)
    assert (core.sum(), rest.sum()) == (told.designs, beyond.designs)
    assert min(later.sum(), rest.sum()) >= 50
    for place, name in ((factor.K_THETA, "K_theta"), (factor.TWIST, "rigidity")):
        error = getattr(told, name)
        assert np.sqrt((off[core, place] ** 2).mean()) == pytest.approx(error.rms, rel=0.01)
        assert np.abs(off[core, place]).max() == pytest.approx(error.worst, rel=0.01)
        assert np.sqrt((off[later, place] ** 2).mean()) <= 2 * error.rms
        assert np.abs(off[later, place]).max() <= 2.5 * error.worst
        error = getattr(beyond, name)
        assert np.sqrt((off[rest, place] ** 2).mean()) == pytest.approx(error.rms, rel=0.01)
        assert np.abs(off[rest, place]).max() == pytest.approx(error.worst, rel=0.01)
    for each in (told, beyond):
        _small(each)


def _small(told: processes.Errors) -> None:
    for error, rms, worst in zip(told[1:], (0.02, 0.02, 0.02, 0.06), (0.07, 0.06, 0.12, 0.3), strict=True):
        assert error.rms <= rms
        assert error.worst <= worst


def test_where_it_ends() -> None:
    shape = law.Shape(*map(np.append, drawn(400, seed=5, wider=0.1), drawn(400, seed=5, wider=0.1, region=law.WHOLE)))
    inside = law.within(shape)
    assert 50 < inside[:400].sum() < 350
    assert 30 < inside[400:].sum() < 350
    for i, found in enumerate(inside):
        one = law.Shape(*(float(x[i]) for x in shape))
        assert bool(law.outside(one)) is not bool(found)
    fits = np.array([_fits(*(float(x[i]) for x in shape)) for i in range(800)])
    assert not (inside & ~fits).any()
    assert (~fits).sum() > 20


def _fits(*shape: float) -> bool:
    one = law.Shape(*shape)
    try:
        Geometry(*one[:3], 1.0, *one[3:])._replace(alpha=abs(one.alpha)).check()
    except InputError:
        return False
    return True


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("alpha", np.radians(76), "scale.alpha = 76 deg: the law of the joint goes from 0 to 75 deg"),
        ("theta0", np.radians(3), "scale.theta0 = 3 deg: the law of the joint goes from 3.1 to 30 deg"),
        ("beta", 0.2, "scale.width = 0.4 pitches: the law of the joint goes from 0.69 to 2.5 pitches"),
        ("zeta", 0.05, "scale.embedded = 0.05 pitches: the law of the joint goes from 0.1 to 0.7 pitches"),
        ("thickness", 0.002, "scale.thickness = 0.01629 of the gap: the law"),
        ("lam", 1.2, "substrate.thickness = 2.4 pitches: the law of the joint goes from 0.58 to 1.88 pitches"),
        ("width", 5.0, "substrate.width = 5.893 of the scale's: the law of the joint goes from 1.01 to 3.15"),
        ("nu", 0.1, "substrate.poisson_ratio = 0.1: the law of the joint goes from 0.245 to 0.495"),
        ("zeta", 0.6, "scale.embedded = 0.6 pitches: longer than the law"),
        ("zeta", 0.63, "longer than the law of the joint reaches (zeta up to 0.598 beside its neighbour)"),
        ("zeta", 1.2, "longer than the law of the joint reaches (zeta up to 0.598 beside its neighbour)"),
    ],
)
def test_ranges_are_named_as_in_the_beam_file(name: str, value: float, words: str) -> None:
    shape = law.Shape(1.28, 0.32, 0.18, 0.6, 0.004, np.pi / 4, np.radians(10), 0.25)
    assert law.outside(shape) == []
    assert words in "\n".join(map(str, law.outside(shape._replace(**{name: value}))))


def test_what_limits_long_tabs_is_named() -> None:
    """Deep ones beyond the core, in thin bars; long ones everywhere."""
    deep = law.Shape(2.0, 0.3, 0.4, 0.8, 0.02, 0.3, np.radians(29), 0.4)
    long = law.Shape(2.0, 0.8, 0.65, 0.8, 0.1, 0.6, 0.35, 0.4)
    for shape, place in ((deep, "in a bar of this thickness"), (long, "beside its neighbour")):
        (problem,) = law.outside(shape)
        most = float(re.search(rf"zeta up to ([\d.]+) {place}", str(problem))[1])
        assert law.within(shape._replace(zeta=most - 0.001))
        assert not law.within(shape._replace(zeta=most + 0.001))
    assert law.outside(deep._replace(theta0=np.radians(25))) == []


def test_embedded_parts_meet_where_parallel_plates_do() -> None:
    """A reason is one, and true: neighbours meet only where they are thicker than the gap between their planes."""
    rng, seen = np.random.default_rng(11), {"meet": 0, "longer": 0}
    for _ in range(400):
        angles = np.radians(rng.uniform((0, 5), (75, 40)))
        shape = law.Shape(2.0, 0.5, rng.uniform(0.05, 1.4), 0.6, rng.uniform(0.02, 0.6), *angles, 0.4)
        said = "\n".join(map(str, law.outside(shape)))
        apart = Geometry(*shape[:3], 1.0, *shape[3:]).rest.axes[2, 2]
        meet = "the embedded parts of neighbours meet" in said
        assert meet == (shape.thickness >= abs(apart)), said
        seen["meet"] += meet
        seen["longer"] += "longer than the law of the joint reaches" in said
        assert said.count("scale.embedded") <= 1
        assert not meet or "\n" not in said
    assert min(seen.values()) > 20


@pytest.mark.parametrize("damage", ["gone", "cut", "flipped", "other"])
def test_a_damaged_file_is_one_line(damage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, data = tmp_path / "law.npz", processes.PLACE.read_bytes()
    if damage == "cut":
        place.write_bytes(data[: len(data) // 2])
    elif damage == "flipped":
        place.write_bytes(data[:5000] + bytes([data[5000] ^ 255]) + data[5001:])
    elif damage == "other":
        np.savez(place, version=0)
    monkeypatch.setattr(processes, "PLACE", place)
    processes.shipped.cache_clear()
    try:
        with pytest.raises(squama.InputError, match=r"law\.npz: the law of the joint is missing, damaged"):
            law.stiffness(drawn(1))
    finally:
        processes.shipped.cache_clear()


def test_strains_are_never_negative_and_have_their_mirror() -> None:
    shape = drawn(200)
    forms = law.strain(shape)
    assert forms.shape == (200, 4, 9, 9)
    d = np.sqrt(np.diagonal(forms, axis1=2, axis2=3))
    assert np.linalg.eigvalsh(forms / (d[..., :, None] * d[..., None, :])).min() > -1e-12
    there = law.strain(shape._replace(alpha=-shape.alpha))
    M = np.diag(factor.MIRROR)
    # the sides at -Y and at +Y change places
    np.testing.assert_allclose(there, (M @ forms @ M)[:, [0, 2, 1, 3]], rtol=1e-9)
    one = law.Shape(*(float(x[7]) for x in shape))
    np.testing.assert_allclose(law.strain(one), forms[7], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(law.strain(one._replace(alpha=-one.alpha)), there[7], rtol=1e-9, atol=1e-9)
    h, x = 1e-6, one.zeta
    ahead, behind = (law.strain(one._replace(zeta=x + step)) for step in (h, -h))
    slope = law.strain(one._replace(zeta=x + 1e-30j)).imag / 1e-30
    np.testing.assert_allclose(slope, (ahead - behind) / (2 * h), rtol=1e-4, atol=1e-6 * np.abs(slope).max())
