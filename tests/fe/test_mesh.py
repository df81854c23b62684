"""Meshes: they fill the pitch, their back is the image of their front, and what does not fit is refused."""

import subprocess
import sys

import numpy as np
import pytest

import squama
from squama.fe.geometry import geometry

pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")

from squama.fe.mesh import EDGES, bar_mesh, pitch_mesh, tile


def volumes(nodes, tets):
    corners = nodes[tets[:, :4]]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6


def enclosed(nodes, surface):
    """Volume by the divergence theorem, and the sum of the outward areas."""
    a, b, c = (nodes[surface[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a) / 2
    return float((normals * (a + b + c)).sum()) / 9, normals.sum(axis=0)


def slot_volume(g):
    """The part of the scale below the scaled face, all of it inside the bar's sides."""
    return 2 * g.beta * g.thickness * g.zeta


def test_geometry_is_that_of_the_beam() -> None:
    beam = squama.Beam.from_ratios(beta=0.6, lam=0.32, zeta=0.18, slenderness=45)
    g = geometry(beam)
    assert g == pytest.approx((1.28, 0.32, 0.18, 3, 0.6, 0.004, np.pi / 4, np.pi / 18, 0.25))
    np.testing.assert_allclose(g.rest.axes @ g.rest.axes.T, np.eye(3), atol=1e-13)
    np.testing.assert_allclose(g.rest.axes[0] @ [0, 1, 0], np.sin(g.theta0))
    np.testing.assert_allclose(g.rest.base, [0, 0.32, 0])


def test_the_pitch_is_filled(fig6b, pitch) -> None:
    parts = volumes(pitch.nodes, pitch.tets)
    whole = 2 * fig6b.width * fig6b.lam - slot_volume(fig6b)
    assert parts.min() > 0
    assert parts.sum() == pytest.approx(whole, rel=1e-6)
    volume, areas = enclosed(pitch.nodes, pitch.surface)
    assert volume == pytest.approx(whole, rel=1e-6)
    np.testing.assert_allclose(areas, 0, atol=1e-12)


def test_middle_nodes_are_in_the_middle(pitch) -> None:
    ends = pitch.nodes[pitch.tets[:, EDGES]]
    np.testing.assert_allclose(pitch.nodes[pitch.tets[:, 4:]], ends.mean(axis=2), atol=1e-13)
    assert np.array_equal(np.unique(pitch.tets), np.arange(len(pitch.nodes)))
    a, b, c = (pitch.nodes[pitch.surface[:, i]] for i in range(3))
    middles = np.stack([(a + b) / 2, (b + c) / 2, (c + a) / 2], axis=1)
    np.testing.assert_allclose(pitch.nodes[pitch.surface[:, 3:]], middles, atol=1e-13)


def test_the_back_is_the_front_a_pitch_further(fig6b, pitch) -> None:
    away = pitch.nodes[pitch.back] - pitch.nodes[pitch.front]
    np.testing.assert_allclose(away, np.broadcast_to([0, 0, 1], away.shape), atol=1e-12)
    place = pitch.nodes[:, 2] - pitch.nodes[:, 0] * np.tan(fig6b.alpha) - fig6b.cut
    assert set(pitch.front) == set(np.flatnonzero(np.abs(place) < 1e-9))
    assert set(pitch.back) == set(np.flatnonzero(np.abs(place - 1) < 1e-9))
    weights, x = pitch.shares, pitch.nodes[pitch.front]
    # the section's moments over its area: the weights integrate a quadratic
    np.testing.assert_allclose(weights @ x[:, :2], 0, atol=1e-12)
    assert weights @ x[:, 0] ** 2 == pytest.approx(fig6b.width**2 / 12)
    assert weights @ x[:, 1] ** 2 == pytest.approx(fig6b.lam**2 / 3)


def test_tied_nodes_are_on_the_walls_of_the_slot(fig6b, pitch) -> None:
    p = fig6b.local(pitch.nodes[pitch.tied])
    walls = np.stack([p[:, 0] + fig6b.zeta, np.abs(p[:, 1]) - fig6b.beta, np.abs(p[:, 2]) - fig6b.thickness / 2])
    assert (np.abs(walls).min(axis=0) < 1e-9).all()
    # both faces, the end and both sides
    for wall in (p[:, 2] - 0.002, p[:, 2] + 0.002, p[:, 0] + 0.18, p[:, 1] - 0.6, p[:, 1] + 0.6):
        assert (np.abs(wall) < 1e-9).sum() > 20
    assert set(pitch.tied) == set(np.flatnonzero(fig6b.in_slot(pitch.nodes)))
    assert not set(pitch.tied) & {*pitch.front, *pitch.back}


def test_elements_are_small_at_the_scales_edges(fig6b, pitch) -> None:
    p = fig6b.local(pitch.nodes)
    corners = np.unique(pitch.tets[:, :4])
    edge = corners[(np.abs(p[corners, 0] + 0.18) < 1e-9) & (np.abs(p[corners, 2] - 0.002) < 1e-9)]
    steps = np.diff(np.sort(p[edge, 1]))
    assert 0.03 < steps.max() < 0.07
    assert len(pitch_mesh(fig6b, 0.3, 0.3).tets) < len(pitch.tets)


@pytest.mark.slow
def test_meshes_are_the_same_in_every_run(fig6b) -> None:
    code = (
        "import numpy as np; from squama.fe.geometry import Geometry; from squama.fe.mesh import pitch_mesh\n"
        f"p = pitch_mesh(Geometry{tuple(fig6b)!r}, 0.3, 0.2)\n"
        "print(len(p.tets), p.nodes.sum().hex(), int((p.tets * np.arange(10)).sum()))"
    )
    code = code.replace("np.float64", "float")
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(2)]
    assert runs[0].stdout == runs[1].stdout
    assert len(runs[0].stdout.splitlines()) == 1
    assert not runs[0].stderr


def test_the_bare_bar(fig6b) -> None:
    # triangles fine enough to lie in the mouth of the slot that is not there
    bar = bar_mesh(fig6b._replace(thickness=0.1, theta0=0.4), 0.2)
    assert volumes(bar.nodes, bar.tets).sum() == pytest.approx(2 * fig6b.width * fig6b.lam)
    assert bar.tied.size == 0
    assert bar.front.size == bar.back.size > 20


def test_pitches_join(fig6b, pitch) -> None:
    three = tile(pitch, 3)
    assert len(three.tets) == 3 * len(pitch.tets)
    assert len(three.nodes) == 3 * (len(pitch.nodes) - pitch.front.size) + pitch.front.size
    assert np.array_equal(np.unique(three.tets), np.arange(len(three.nodes)))
    parts = volumes(three.nodes, three.tets).reshape(3, -1)
    np.testing.assert_allclose(parts, np.broadcast_to(volumes(pitch.nodes, pitch.tets), parts.shape), rtol=1e-7)
    for k, tied in enumerate(three.tied):
        np.testing.assert_allclose(three.nodes[tied], pitch.nodes[pitch.tied] + [0, 0, k], atol=1e-12)
    np.testing.assert_allclose(three.nodes[three.cuts[0]], pitch.nodes[pitch.front], atol=1e-12)
    np.testing.assert_allclose(three.nodes[three.cuts[-1]], pitch.nodes[pitch.back] + [0, 0, 2], atol=1e-12)
    one = tile(pitch, 1)
    np.testing.assert_allclose(one.nodes[one.tets], pitch.nodes[pitch.tets], atol=1e-12)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "change",
    [
        {"beta": 1.5},  # leaves both sides
        {"beta": 0.64 * np.sqrt(2) - 1e-3},  # comes close to a side
        {"alpha": np.radians(70)},
        {"theta0": np.radians(60), "zeta": 0.3},
        {"thickness": 0.02},
    ],
)
def test_other_geometries(fig6b, change) -> None:
    g = fig6b._replace(**change)
    p = pitch_mesh(g, 0.3, 0.15)
    parts = volumes(p.nodes, p.tets)
    assert parts.min() > 0
    clipped = 2 * g.width * g.lam - parts.sum()
    assert 0 < clipped < slot_volume(g) * (1 + 1e-6)
    if g.beta < 0.8:
        assert clipped == pytest.approx(slot_volume(g), rel=1e-6)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"zeta": 0.9, "theta0": np.radians(60)}, r"comes out of the substrate's other face.*at most 0.7"),
        ({"zeta": 0.005}, r"does not close over the scale.*more than 0.01134"),
        ({"alpha": np.radians(89)}, "scale.thickness = .*: the embedded parts of neighbours meet.*less than 0.003031"),
    ],
)
def test_what_does_not_fit_is_refused(fig6b, change, said) -> None:
    with pytest.raises(squama.InputError, match=said) as caught:
        pitch_mesh(fig6b._replace(**change))
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("sizes", "said"),
    [
        ({"size": 0.0}, "element size = 0 pitches: must be 0.0001 to 1.28"),
        ({"edge_size": float("nan")}, "element edge size = nan"),
        ({"size": 0.005}, "about .* elements; take larger ones"),
    ],
)
def test_sizes_are_checked(fig6b, sizes, said) -> None:
    with pytest.raises(squama.InputError, match=said):
        pitch_mesh(fig6b, **sizes)


def test_a_mesher_that_fails_is_one_sentence(fig6b, monkeypatch) -> None:
    from netgen import occ

    def fail(*args, **kwargs):
        raise RuntimeError("problem in\nsurface meshing")

    monkeypatch.setattr(occ.OCCGeometry, "GenerateMesh", fail)
    with pytest.raises(squama.InputError, match=r"could not be meshed \(problem in surface meshing\): take another"):
        pitch_mesh(fig6b)


def test_a_missing_mesher_is_one_sentence(fig6b, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "netgen.occ", None)
    with pytest.raises(squama.InputError, match=r"need netgen-mesher; install them with: pip install 'squama\[fe\]'"):
        pitch_mesh(fig6b)
