"""Tilt of the scales of a row: its law against linear elements, and contact forces against nonlinear ones."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.contacts import path
from squama.curves import compliant
from squama.curves.compliant import Held
from squama.errors import InputError
from squama.fe.geometry import geometry
from squama.fe.mesh import pitch_mesh
from squama.fe.pitch_stiffness import LATERAL, response
from squama.joints import lateral, law, tilt
from squama.joints.choice import shape
from squama.part import door
from squama.study import parts

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")
MESH = (0.3, 0.12)
U_Z, W_X, W_Y = 2, 3, 4
TOOL = runpy.run_path("tools/alternating.py")


@pytest.fixture(scope="module")
def elements():
    """B of a design that was not fitted, by linear elements, and the law's tilt on the joint of the same mesh."""
    beam = SKIN.replace(scale={"alpha": "35 deg", "embedded": "4 mm", "theta0": "17 deg"})
    g = geometry(beam)
    pitch = pitch_mesh(g, *MESH)
    K = response(pitch, g, motions=LATERAL).K
    joint = K.copy()
    joint[9], joint[:, 9] = 0.0, 0.0
    joint[9, 9] = lateral.stiffness(K[:9, :9], shape(beam))
    return TOOL["unshared"](TOOL["alternating"](pitch, g), joint, g.rest), tilt.tilts(shape(beam))


def test_the_law_is_that_of_alternating_elements(elements):
    B, g = elements
    assert g[2] ** 2 == pytest.approx(B[W_Y, W_Y], rel=0.15)
    assert g * g[2] == pytest.approx(B[[U_Z, W_X, W_Y], W_Y], abs=0.1 * B[W_Y, W_Y])


def test_a_rod_between_scales_has_the_compliance_of_many_cells(elements):
    """Of alternating loads on a long chain of joints, put together cell by cell."""
    beam, n = SKIN, 40
    K = np.zeros((10, 10))
    K[:9, :9] = law.stiffness(shape(beam))
    K[9, 9] = 0.3
    rest = geometry(beam).rest
    # rotations of sections, and displacements, by the strains of all cells: strain e of cell j acts on what is behind
    turns = np.array([[0, 0, -1.0], [-1, 0, 0], [0, 0, 0], [0, -1, 0]])
    G = np.zeros((6 * n, 10 * n))
    for i in range(n):
        G[6 * i : 6 * i + 6, 10 * i : 10 * i + 6] = np.eye(6)
        for j in range(i + 1):
            far = 0.5 if i == j else i - j + 0.5
            near = 0.0 if i == j else i - j - 0.5
            for e, o in enumerate(turns):
                shift = np.cross(o, [0, 0, (far**2 - near**2) / 2]) + np.array([0, 0, (far - near) * (e == 2)])
                turn = (far - near) * o
                G[6 * i : 6 * i + 3, 10 * j + 6 + e] = rest.axes @ (shift + np.cross(turn, rest.base))
                G[6 * i + 3 : 6 * i + 6, 10 * j + 6 + e] = rest.axes @ turn
    C = G @ np.kron(np.eye(n), np.linalg.inv(K)) @ G.T
    load = np.zeros((6 * n, 6))
    for i in range(4, n - 4):
        # two equal loads with the double between them bear no resultant that the clamp would feel
        load[6 * i : 6 * i + 6] = (-1.0) ** i * np.eye(6)
    for i, share in ((3, 0.75), (2, 0.25), (n - 4, 0.75), (n - 3, 0.25)):
        load[6 * i : 6 * i + 6] = share * (-1.0) ** i * np.eye(6)
    moved = (C @ load).reshape(n, 6, 6)
    i = n // 2
    # without the rigid motion: second differences of alternating motions
    found = (2 * moved[i] - moved[i - 1] - moved[i + 1]) / 4
    alone = np.linalg.inv(K)[:6, :6]
    B = TOOL["unshared"](np.linalg.inv(alone), K, rest)
    assert alone - B == pytest.approx(found, abs=2e-3 * np.abs(found).max())


def test_contact_forces_near_the_ends_are_those_of_elements():
    """Nonlinear elements of 5 scales in grips, mesh (0.3, 0.12): 0.768; on joints alone the model has 0.86.

    The bar of these elements ends along the bases of the scales, without plain bar.
    """
    part = parts.Closed.of(SKIN.replace(scales=5), 5, "38.5 deg twist", "gripped", 0)
    r = door.load(part, scales=7, mu=0.25, points=20)
    N = r.N.values[-1][1:5]
    assert N[0] / N[1] == pytest.approx(0.768, rel=0.05)
    assert N[3] / N[2] == pytest.approx(0.768, rel=0.05)
    # elements turn the first scale by 1.76 deg, the second by 0.61; the joints alone give 1.17 and 0.39 of it
    turned = np.degrees(r.theta.values[-1][1:3]) - 20
    assert turned == pytest.approx([1.76, 0.61], rel=0.1)


@pytest.mark.parametrize(
    ("change", "ends"),
    [({}, "couple"), ({"faces": "mirrored"}, "gripped"), ({"scale": {"length": "90 mm"}}, "free")],
    ids=["couple", "both faces", "long scales"],
)
def test_tilts_take_the_work_of_contacts(change, ends):
    beam = SKIN.replace(scales=6, ends=ends, **change)
    r = squama.twist(beam, mu=0.0, to="36 deg total", points=40)
    assert float(np.nanmax(r.N)) > 0
    assert abs(float(r.energy_error)) < 1e-7


def test_scales_that_bear_alike_do_not_tilt():
    """Inside a long row under its torque the scales move as in the endless beam."""
    beam = SKIN.replace(scales=41)
    r = squama.twist(beam, to="0.09 rad/pitch", points=30, mu=0.0)
    cells, N = r.phi_cell.values[-1], r.N.values[-1]
    endless = squama.twist(SKIN.replace(scales=None), at=[float(cells[20]) / SKIN.pitch], mu=0.0)
    assert float(N[20]) == pytest.approx(float(endless.N[0]), rel=1e-5)
    assert N[0] < 0.9 * N[20]


def test_a_roll_is_mirrored_with_the_beam():
    """As are the odd motions of the joint's matrix: twisted the other way, scales are those of the mirror image."""
    held, one = Held.of(SKIN), path.Scale(*np.array([compliant.scale(SKIN, ideal=False)]).T)
    ahead, back = (path.beams(one, held.K[None], np.zeros(1), sense=s, **held.bar).tilts[0] for s in (1, -1))
    assert ahead == pytest.approx(held.tilt)
    assert back == pytest.approx(held.tilt * np.array([1, -1, 1]))
    r = [squama.twist(SKIN.replace(scales=4), to="24 deg total", points=9, sense=s, mu=0.0) for s in "+-"]
    assert all(float(np.nanmax(x.N)) >= 0 and abs(float(x.energy_error)) < 1e-7 for x in r)


def test_designs_that_are_not_fitted_have_no_tilt():
    own = shape(SKIN)
    many = law.Shape(*(np.full(3, float(v)) for v in own))
    many = many._replace(alpha=np.array([own.alpha, 1.2, own.alpha]), zeta=np.array([own.zeta, own.zeta, 1.0]))
    found = tilt.tilts(many)
    assert found[0] == pytest.approx(Held.of(SKIN).tilt, rel=1e-9)
    assert (found[1:] == 0).all()
    assert Held.of(SKIN.replace(joint=parts.joint_of(SKIN, law.stiffness(own)[:7, :7]))).tilt == (0.0, 0.0, 0.0)


def test_a_damaged_file_is_told(monkeypatch, tmp_path):
    monkeypatch.setattr(tilt, "PLACE", tmp_path / "tilt.npz")
    tilt.shipped.cache_clear()
    (tmp_path / "tilt.npz").write_bytes(b"no numbers")
    with pytest.raises(InputError, match=r"tilt\.npz"):
        tilt.tilts(shape(SKIN))
    tilt.shipped.cache_clear()


def test_it_holds_on_later_designs_of_the_whole_range():
    """Linear elements of designs that the process was not fitted to (``tools/neighbours.py``)."""
    place = Path(__file__).parents[2] / "tools" / "neighbours.csv"
    table = np.genfromtxt(place, delimiter=",", names=True)
    shape = law.Shape(*(table[name] for name in law.Shape._fields))
    later = (table["index"] >= 100_000) & tilt.fitted(shape) & law.within(shape)
    beyond = later & ~law.within(shape, law.CORE)
    assert beyond.sum() > 40
    turn = tilt.tilts(shape)[:, 2] ** 2
    for which in (later, beyond):
        off = np.abs(turn / table["YY"] - 1)[which]
        assert np.median(off) < 0.05
        assert np.quantile(off, 0.9) < 0.25
    assert not tilt.tilts(shape)[~law.within(shape)].any()
