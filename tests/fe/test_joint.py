"""The joint's stiffness: bars and moves whose answer is known, fe.md's figures, symmetry, mirror, cache, command."""

import errno
import json
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import squama

pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
pytest.importorskip("numba", reason="elements need numba (the extra fe)")

from solids import stiffness

from squama.cli.joint import _meshes
from squama.fe import stiffness as joint
from squama.fe.elements import Material
from squama.fe.geometry import geometry
from squama.fe.mesh import SIZE, MeshError, bar_mesh, pitch_mesh
from squama.fe.pitch_stiffness import Response, response

ANEW = "each run makes the joint's stiffness anew"
FIG6B = {"beta": 0.6, "lam": 0.32, "zeta": 0.18, "slenderness": 45, "mu": 0.2}


def saint_venant(width, thickness):
    """Torsion constant J of a rectangle (Timoshenko and Goodier, Theory of Elasticity, section 109)."""
    a, b = max(width, thickness), min(width, thickness)
    n = np.arange(1, 60, 2)
    return a * b**3 * (1 - 192 * b / (np.pi**5 * a) * (np.tanh(n * np.pi * a / (2 * b)) / n**5).sum()) / 3


@pytest.fixture(scope="module")
def K(fig6b, pitch):
    return response(pitch, fig6b).K[:7, :7]


def test_patch(fig6b, pitch):
    """A linear field has no force inside and the exact energy, also in the slivers at the slot."""
    A = stiffness(pitch.nodes, pitch.tets, Material(1.0, fig6b.nu))
    strain = np.array([[0.3, -0.2, 0.5], [0.4, 0.1, -0.6], [0.2, 0.7, -0.8]])
    u = (pitch.nodes @ strain.T + [1.0, 2.0, 3.0]).ravel()
    force = (A @ u).reshape(-1, 3)
    inside = np.setdiff1d(np.arange(len(pitch.nodes)), pitch.surface)
    assert np.abs(force[inside]).max() < 1e-10 * np.abs(force).max()
    e = (strain + strain.T) / 2
    lame, G = Material(1.0, fig6b.nu).lame
    energy = lame / 2 * np.trace(e) ** 2 + G * (e**2).sum()
    corners = pitch.nodes[pitch.tets[:, :4]]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6
    assert u @ (A @ u) / 2 == pytest.approx(energy * volume, rel=1e-9)


def test_rigid_motions_cost_nothing(fig6b, pitch):
    A = stiffness(pitch.nodes, pitch.tets, Material(1.0, fig6b.nu))
    size = abs(A).max()
    for axis in np.eye(3):
        assert np.abs(A @ np.tile(axis, len(pitch.nodes))).max() < 1e-12 * size
        assert np.abs(A @ np.cross(axis, pitch.nodes).ravel()).max() < 1e-11 * size


@pytest.mark.slow
def test_the_bare_bar_converges_with_the_order_of_the_elements(fig6b):
    exact = saint_venant(fig6b.width, 2 * fig6b.lam) / (2 * (1 + fig6b.nu))
    # the square of side 1 has J = .1405770 (Timoshenko)
    assert saint_venant(1.0, 1.0) == pytest.approx(0.140577, abs=1e-6)
    over = [response(bar_mesh(fig6b, h), fig6b).K[6, 6] / exact - 1 for h in (0.2, 0.1)]
    # tolerance: the mesh, 0.4 % measured, on every processor
    assert 0 < over[0] < 0.005
    # energy errs in the fourth power of the size; the meshes are not exactly similar
    assert 2**2.5 < over[0] / over[1] < 2**5.5


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", ["coarse", "medium", "fine"])
def test_the_bare_bar_of_every_mesh_that_has_a_name(fig6b, name):
    from squama.fe.sizes import MESHES

    exact = saint_venant(fig6b.width, 2 * fig6b.lam) / (2 * (1 + fig6b.nu))
    bar = bar_mesh(fig6b, MESHES[name][0])
    # tolerance: the mesh, 0.4 % measured, on every processor
    assert 0 < response(bar, fig6b).K[6, 6] / exact - 1 < 0.005


def test_the_coarsest_elements_at_the_edges_are_a_fifth_of_the_smaller_length():
    shape = geometry(squama.Beam.from_ratios(**FIG6B))
    for zeta, beta in ((0.3, 0.1), (0.1, 0.7)):
        _, edges = joint.sizes(shape._replace(zeta=zeta, beta=beta), 3)
        assert edges == pytest.approx([0.02, 0.01, 0.005])


def test_the_matrix_is_symmetric_and_positive(K):
    np.testing.assert_allclose(K, K.T, atol=1e-13)
    assert np.linalg.eigvalsh(K).min() > 0


def test_a_turn_of_everything_with_the_section_costs_the_same_from_any_axis(fig6b, pitch, K):
    """Energy does not depend on where the six motions are counted from: shifting the base along n_X shifts K."""
    from squama.fe.averages import Section
    from squama.fe.body import Body
    from squama.fe.elements import Elements, Helical
    from squama.fe.plate import Carried, Rest

    master, turned, rest = pitch.images
    tied = master[pitch.tied]
    shift = 0.3
    moved = Rest(fig6b.eta, fig6b.beta, fig6b.rest.axes, fig6b.rest.base + shift * fig6b.rest.axes[0])
    elements = Helical(Elements(pitch.nodes, pitch.tets, Material(1.0, fig6b.nu)), master, turned)
    section = Section.of_pitch(master[pitch.front], rest[master[pitch.front]], pitch.shares)
    body = Body(elements, rest, [(tied, Carried(moved, rest[tied]))], sections=[section])
    S = body.reduce(body.start(), np.zeros(6), 0.0).S
    body.solver.close()
    # motion of the base by that of the other point: u = u' - w x (shift n_X)
    T = np.eye(6)
    T[1, 5], T[2, 4] = -shift, shift
    np.testing.assert_allclose(S, T.T @ K[:6, :6] @ T, atol=1e-9)


def test_figures_at_one_coarse_mesh(K):
    """Stiff by the size of the elements, not soft, and within what edges of .06 pitches are worth."""
    assert 0.0119 < joint.inclination_stiffness(K) < 0.0119 * 1.2
    exact = saint_venant(1.28, 0.64) / 2.5
    assert 1.418 < joint.twisting_stiffness(K) / exact < 1.418 * 1.02
    # before contact the inclination falls by about .05 phi: a turn about +n_Y
    rate = -np.linalg.solve(K[:6, :6], K[:6, 6])[4]
    assert 0.04 < rate < 0.07


@pytest.mark.slow
def test_other_meshes_of_about_that_size_agree(fig6b, K):
    other = response(pitch_mesh(fig6b, 0.17, 0.055), fig6b).K[:7, :7]
    # tolerance: meshes of that size differ by 1 and 0.2 %
    assert joint.inclination_stiffness(other) == pytest.approx(joint.inclination_stiffness(K), rel=0.03)
    assert joint.twisting_stiffness(other) == pytest.approx(joint.twisting_stiffness(K), rel=0.005)


@pytest.mark.slow
def test_the_mirrored_pitch_has_the_mirrored_matrix(fig6b, K):
    mirrored = fig6b._replace(alpha=-fig6b.alpha)
    other = response(pitch_mesh(mirrored, 0.2, 0.06), mirrored).K[:7, :7]
    # across the plane x = 0: n_Y turns round, turns are axial, the twist changes its sense
    sign = np.array([1, -1, 1, -1, 1, -1, -1.0])
    scale = np.sqrt(np.outer(np.diag(K), np.diag(K)))
    # tolerance: the mesh of the mirror image is another one, 0.6 % measured
    np.testing.assert_allclose(other * np.outer(sign, sign) / scale, K / scale, atol=0.02)
    assert K[3, 6] * other[3, 6] > 0 > K[4, 6] * other[4, 6]


def test_extrapolation_and_its_bar():
    def level(h, c=0.5):
        return joint.Level(h, 1, np.eye(9) * (2 + c * h), 0.0, np.zeros((4, 9, 9)))

    exact = joint.JointMatrix(joint.extrapolated([level(0.4), level(0.2)]), (level(0.4), level(0.2)), 0.1, 1.0, 1.0)
    assert exact.K_theta.value == pytest.approx(2)
    assert exact.K_theta.error == pytest.approx(0.1)
    three = exact._replace(levels=(level(0.4), level(0.2), level(0.1)))
    assert three.order == pytest.approx(1)
    # the table of meshes has the change from each to the next in per cent: 2.2, 2.1, then 2
    _, _, K, changed, C, also = (column._cells for column in _meshes(exact).columns)
    assert [*K] == [*C] == ["2.2", "2.1", "2"]
    assert [*changed] == [*also] == ["", "-4.55 %", "-4.76 %"]
    assert three.K_theta.error == pytest.approx(0.025)
    assert exact._replace(levels=(level(0.4),)).K_theta.error == np.inf
    # a trend that would lead below zero is not followed
    steep = [joint.Level(h, 1, np.eye(9) * k, 0.0, np.zeros((4, 9, 9))) for h, k in ((0.4, 3.0), (0.2, 1.0))]
    np.testing.assert_array_equal(joint.extrapolated(steep), np.eye(9))


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "squama" / "joints"


def test_elements_in_the_bulk_are_three_through_the_thickness_but_not_too_many(cache, monkeypatch):
    monkeypatch.setattr(joint, "pitch_mesh", lambda *_, **__: SimpleNamespace(tets=[]))
    monkeypatch.setattr(joint, "bar_mesh", lambda *_: None)
    monkeypatch.setattr(joint, "response", lambda *_: Response(np.eye(9), np.zeros((4, 9, 9)), 0))

    def size(edge_size=0.01, **ratios):
        beam = squama.Beam.from_ratios(**{**FIG6B, **ratios})
        return joint.joint(beam, edge_size=edge_size, levels=1).size, geometry(beam)

    assert size()[0] == SIZE
    thin, shape = size(lam=0.1, zeta=0.05)
    assert thin == pytest.approx(0.75 * shape.lam)
    # a bar of this volume holds as many tetrahedra of that edge, each a sixth of its cube
    many, shape = size(width="2 m")
    assert many > SIZE
    assert 2 * shape.width * shape.lam / (many**3 / 6) == pytest.approx(20_000)
    # and none is smaller than those along the edges of the scale
    assert size(edge_size=0.8)[0] == pytest.approx(0.4)


def test_two_meshes_suffice_where_the_third_fails(cache, monkeypatch):
    left, kind = [], MeshError

    def mesh(*_, **__):
        if not left:
            message = "the substrate could not be meshed"
            raise kind(message)
        return SimpleNamespace(K=left.pop() * np.eye(9))

    monkeypatch.setattr(joint, "pitch_mesh", mesh)
    monkeypatch.setattr(joint, "bar_mesh", lambda *_: SimpleNamespace(K=np.eye(9)))
    monkeypatch.setattr(joint, "response", lambda one, *_: Response(one.K, np.zeros((4, 9, 9)), 7))
    beam = squama.Beam.from_ratios(**FIG6B)
    left[:] = [4.0, 5.0]
    found = joint.joint(beam)
    assert len(found.levels) == 2
    # linear in the size of elements, with the correction for an error bar
    assert (found.K_theta.value, found.K_theta.error) == (pytest.approx(3.0), pytest.approx(1.0))
    left[:] = [5.0]
    with pytest.raises(squama.InputError, match="could not be meshed"):
        joint.joint(beam, fresh=True)
    # other mistakes are told however many meshes there are
    left[:], kind = [4.0, 5.0], squama.InputError
    with pytest.raises(squama.InputError, match="could not be meshed"):
        joint.joint(beam, fresh=True)


@pytest.mark.slow
def test_results_are_kept_and_damaged_ones_made_anew(cache, monkeypatch):
    beam = squama.Beam.from_ratios(**FIG6B)
    told = []
    first = joint.joint(beam, edge_size=0.3, levels=1, progress=told.append)
    assert len(told) == 1
    assert told[0].seconds > 0
    assert len(list(cache.iterdir())) == 2
    with monkeypatch.context() as m:
        m.setattr(joint, "response", None)
        # the exposed length, the size of the beam and its modulus make no difference
        bigger = squama.Beam.from_ratios(**FIG6B, eta=2, width="64 mm", thickness="32 mm", youngs_modulus="1 GPa")
        again = joint.joint(bigger, edge_size=0.3, levels=1)
    np.testing.assert_array_equal(first.K, again.K)
    assert again.levels[0].seconds == 0
    for place in cache.iterdir():
        place.write_text('{"array": [[1', encoding="utf-8")
    anew = joint.joint(beam, edge_size=0.3, levels=1)
    np.testing.assert_allclose(first.K, anew.K, rtol=1e-9, atol=1e-12)
    assert anew.levels[0].seconds > 0


def test_without_a_place_for_the_cache(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    calls = []

    def compute():
        calls.append(1)
        return np.eye(2), 3

    for _ in range(2):
        array, count, fresh = joint.kept(("a", 1.0), False, compute)
        assert (array.shape, count, fresh) == ((2, 2), 3, True)
    assert len(calls) == 2
    (line,) = caplog.messages
    assert line.startswith(f"squama: {tmp_path / 'file' / 'squama' / 'joints'}: the cache cannot be written (")
    assert line.endswith(f"; {ANEW}")


def test_a_full_disk_under_the_cache_costs_one_line(cache, monkeypatch, caplog):
    def full(self, *_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_text", full)
    for _ in range(2):
        assert joint.kept(("a", 1.0), False, lambda: (np.eye(2), 3))[1:] == (3, True)
    assert caplog.messages == [f"squama: {cache}: the cache cannot be written (the disk is full); {ANEW}"]


def test_the_bulk_has_three_elements_through_the_thickness_and_not_too_many(cache, monkeypatch):
    monkeypatch.setattr(joint, "pitch_mesh", lambda *_, **__: SimpleNamespace(tets=()))
    monkeypatch.setattr(joint, "bar_mesh", lambda *_: None)
    monkeypatch.setattr(joint, "response", lambda *_: Response(np.eye(9), np.zeros((4, 9, 9)), 0))
    tetrahedra = []
    for changes, size in (({}, 0.15), ({"lam": 0.1}, 0.075), ({"width": "2 m"}, None)):
        beam = squama.Beam.from_ratios(**(FIG6B | changes))
        found = joint.joint(beam, levels=1)
        assert found.size == pytest.approx(size or found.size)
        assert 2 * beam.lam / found.size > 2
        # a cube is six tetrahedra
        tetrahedra.append(6 * 2 * beam.lam * beam.substrate.width / beam.pitch / found.size**3)
    assert max(tetrahedra) == tetrahedra[2] == pytest.approx(20_000)
    # no finer than the finest edge
    edge = joint.joint(squama.Beam.from_ratios(**FIG6B), edge_size=0.5, levels=1)
    assert edge.size == 0.25


def test_bad_levels_and_beams():
    beam = squama.Beam.from_ratios(**FIG6B)
    with pytest.raises(squama.InputError, match="levels = 0: must be 1 to 6"):
        joint.joint(beam, levels=0)
    with pytest.raises(squama.InputError, match="comes out of the substrate's other face"):
        joint.joint(squama.Beam.from_ratios(**(FIG6B | {"zeta": 3.65})))


def test_the_command(cache, tmp_path, monkeypatch, capsys):
    from squama.cli import main

    monkeypatch.chdir(tmp_path)
    squama.Beam.from_ratios(**FIG6B).to_toml("beam.toml")
    assert main(["joint", "beam.toml", "--edge-size", "0.3", "--levels", "2", "--toml", "fe.toml"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("beam.toml: K_theta = ")
    assert "scaling law" in said.out
    assert "wrote fe.toml" in said.out
    assert said.err.count("elements, ") == 2
    assert main(["joint", "beam.toml", "--edge-size", "0.3", "--levels", "2", "--json"]) == 0
    said = capsys.readouterr()
    assert said.err.count("from the cache") == 2
    found = json.loads(said.out)
    made = squama.Beam.from_toml("fe.toml")
    assert made.joint_stiffness == pytest.approx(found["factors"]["K_theta"]["elements"], rel=1e-12)
    assert made.C_f == pytest.approx(found["factors"]["C_f"]["elements"], rel=1e-12)
    assert found["factors"]["K_theta"]["law"] == pytest.approx(squama.Beam.from_toml("beam.toml").joint_stiffness)
    assert np.array(found["matrix"]).shape == (9, 9)


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--levels", "9"], "--levels"),
        (["--edge-size", "big"], "--edge-size"),
        (["--toml", "x.txt"], "x.txt"),
        (["--set", "scale.embedded=91.25 mm"], "comes out of the substrate's other face"),
        (["--tab", "elastic"], "scale.youngs_modulus: is needed for an elastic tab"),
        (["--tab", "soft"], "--tab"),
    ],
)
def test_bad_flags(flags, words, cache, tmp_path, monkeypatch, capsys):
    from squama.cli import main

    monkeypatch.chdir(tmp_path)
    squama.Beam.from_ratios(**FIG6B).to_toml("beam.toml")
    assert main(["joint", "beam.toml", *flags]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "Traceback" not in said


def test_an_interrupted_command_says_what_is_kept(cache, tmp_path, monkeypatch, capsys):
    from squama.cli import main

    def interrupt(*args):
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(joint, "response", interrupt)
    squama.Beam.from_ratios(**FIG6B).to_toml("beam.toml")
    assert main(["joint", "beam.toml", "--edge-size", "0.3"]) == 130
    assert capsys.readouterr().err == (
        "squama: beam.toml: interrupted; meshes that are done are kept: run it again to go on\n"
    )


@pytest.mark.slow
def test_extrapolated_to_no_size(cache):
    """K_theta = .0119 within 2 %, C_f = 1.418 within 2 %; the bars hold the values of twice finer meshes."""
    found = joint.joint(squama.Beam.from_ratios(**FIG6B), edge_size=0.04)
    assert found.K_theta.value == pytest.approx(0.0119, rel=0.02)
    assert found.C_f.value == pytest.approx(1.418, rel=0.003)
    assert found.bar / found.exact == pytest.approx(1, abs=0.002)
    assert abs(found.K_theta.value - 0.0119) < found.K_theta.error < 0.0119 * 0.03
