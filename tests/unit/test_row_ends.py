"""Rows whose cells have strains of their own: stationary points by plain NumPy, the endless beam, work, derivatives."""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from uncompiled import said

import squama
from squama.contacts import entry, increments, path, row, states
from squama.contacts.path import Path, Scale
from squama.contacts.system import EQUAL, PHI, PSI, UNTIED
from squama.contacts.ties import COUPLE, GRIPPED, LOOSE, freed, of_ends
from squama.contacts.touch import LIES
from squama.curves import compliant
from squama.errors import InputError
from squama.joints import law

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")


def made(mu=0.0, beam=SKIN, free=(1, 0, 1, 1), **changes):
    """Return a beam on the solver; ``changes`` of its scale."""
    held = compliant.Held.of(beam)
    plate = compliant.scale(beam, ideal=False)._replace(**changes)
    return Path.of(plate, held.K, mu, most=0.3, free=free, aside=held.aside)


def oblique(mu=0.0, free=(1, 0, 1, 1)):
    """Return a beam with short, thick scales, whose second neighbours are in reach."""
    a, t, h = 0.8, 0.25, 0.06
    K = law.stiffness(law.Shape(2.0, 0.5, 0.4, 0.9, h, a, t, 0.45))
    return Path.of(Scale(4.0, 0.9, 0.5, a, t, h, 0.5, 0.35), K, mu, most=0.5, free=free, aside=3.0)


def column(track, name):
    """A column of the states, (points, n)."""
    return path.named(track.rows)[name]


# ---- all that follows from strains and motions, once more, by matrices of four rows ----------------------------------


def screw(strains):
    """Return the matrix of a cell's screw (combined.md, section 1)."""
    psi, phi, chi, eps = strains
    x, y, z = -psi, -chi, -phi
    return np.array([[0, -z, y, 0], [z, 0, -x, 0], [-y, x, 0, 1 + eps], [0, 0, 0, 0]])


def sections(strains):
    """Return the frames of all scales seen from the near end of the bar, and that of the far end."""
    out, frame = [], np.eye(4)
    for e in strains:
        half = expm(screw(e) / 2)
        out.append(frame @ half)
        frame = frame @ half @ half
    return out, frame


def spot(way, q, b, x, y, side):
    """Return a place of a scale's lower (-1) or upper sheet in its section, and the scale's axes at rest there."""
    s, w = way.scale, q[3:]
    length = [-np.sin(s.alpha) * np.cos(s.theta0), np.sin(s.theta0), np.cos(s.alpha) * np.cos(s.theta0)]
    width = [np.cos(s.alpha), 0.0, np.sin(s.alpha)]
    axes = np.array([length, width, np.cross(length, width)])
    W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    bent = (x / s.eta) ** np.arange(2, 8) @ b.reshape(6, 4) @ (y / s.beta) ** np.arange(4)
    own = q[:3] + expm(W) @ np.array([x, y, bent + side * s.h / 2])
    return np.array([0, s.lam, 0]) + axes.T @ own, axes


def action(way, q, strains, bends, contacts):
    """Return the energy of joints and bar less the work of given forces on the gaps of contacts."""
    order, K = [0, 1, 2, 3, 4, 5, 7, 6, 9], np.zeros((10, 10))
    K[np.ix_(order, order)] = way.beams.K[0]
    K[8, 8] = way.beams.aside[0] * way.beams.K[0, 7, 7]
    z = np.hstack([q, strains])
    total = np.einsum("ia,ab,ib->", z, K, z) / 2
    frames, _ = sections(strains)
    for c in contacts:
        i, j = int(c[0]), int(c[0] + c[1])
        (one, axes), (other, _) = spot(way, q[i], bends[i], *c[6:8], -1), spot(way, q[j], bends[j], *c[8:10], 1)
        seen = np.linalg.solve(frames[i], frames[j] @ np.append(other, 1.0))[:3]
        total = total - (axes.T @ c[10:13]) @ (one - seen)
    return total


def far_end(strains):
    """Return the turns about x, y and z and the shifts by which the far end moved."""
    G = sections(strains)[1]
    return np.array([-G[1, 2], G[0, 2], np.arctan(G[1, 0] / G[0, 0]), *G[:3, 3]])


def turn(strains):
    """Return the angle by which the far end is turned about the near end's axis, then tilted; and its axis."""
    R = sections(strains)[1]
    z = -R[:3, :3]
    # the turn that is left when the shortest rotation has brought the far axis back
    v = np.cross(-z[:, 2], [0, 0, 1.0])
    V = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    left = (np.eye(3) + V + V @ V / (1 - z[2, 2])) @ -z
    return np.arctan(left[0, 1] / left[0, 0])


def slopes(f, x):
    """Return the derivatives of f by all numbers in x, by complex steps."""
    out = []
    for i in np.ndindex(x.shape):
        step = x.astype(complex)
        step[i] += 1e-30j
        out.append(np.imag(f(step)) * 1e30)
    return np.array(out)


WAYS = {"slender": made, "oblique": oblique}


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("name", WAYS)
@pytest.mark.parametrize("ends", [LOOSE, COUPLE, GRIPPED])
def test_a_row_is_in_balance(name, ends, mu):
    """Forces of contacts on both scales, joints and bar against the one load at the ends, carried to each cell."""
    way, n = WAYS[name](mu), 5
    phi = 1.8 * way.contact.phi
    t = row.track(way, n, np.array([phi]), ends=ends)
    q, strains = path.motions(t.rows[0])[:, :6], t.cells[0, :, :4]
    bends, contacts = path.deflections(t.rows[0]), t.contacts[0][(t.contacts[0][:, 10:13] != 0).any(axis=1)]
    assert len(contacts) >= n - 1
    assert (contacts[:, 2] != LIES).all()
    scale = np.abs(t.cells[0, :, 5]).max()
    np.testing.assert_allclose(slopes(lambda q: action(way, q, strains, bends, contacts), q), 0, atol=1e-8 * scale)
    carried = slopes(lambda e: action(way, q, e, bends, contacts), strains).reshape(n, 4)
    np.testing.assert_allclose(carried, t.cells[0, :, 4:], atol=1e-8 * scale)
    torque = column(t, "torque")[0, 0]
    assert strains[:, 1].mean() == pytest.approx(phi, rel=1e-9 if ends == LOOSE else 0.1)
    if ends == COUPLE:
        np.testing.assert_allclose(carried.ravel(), torque * slopes(turn, strains), atol=1e-8 * scale)
        assert math.tan(turn(strains)) == pytest.approx(math.tan(n * phi), rel=1e-9)
        # one couple in space
        frames, end = sections(strains)
        both = end[:3, 2] + [0, 0, 1]
        fixed = torque * both / (1 + end[2, 2])
        along = [-fixed @ expm_half for expm_half in (f[:3, 2] for f in frames)]
        np.testing.assert_allclose(-np.array(along), carried[:, 1], rtol=1e-3)
        return
    if ends == LOOSE:
        np.testing.assert_allclose(carried, np.outer(np.ones(n), [0, torque, 0, 0]), atol=1e-8 * scale)
        return
    moved = slopes(far_end, strains).T
    wrench, *_ = np.linalg.lstsq(moved[[0, 1, 2, 3, 4]].T, carried.ravel())
    np.testing.assert_allclose(wrench @ moved[[0, 1, 2, 3, 4]], carried.ravel(), atol=1e-7 * scale)
    assert torque == pytest.approx(-wrench[2], rel=1e-7)
    end = far_end(strains)
    np.testing.assert_allclose(end[:5], [0, 0, math.atan(math.tan(-n * phi)), 0, 0], atol=1e-9)
    # they come nearer, and are bent between
    assert end[5] < n
    assert np.abs(t.cells[0, :, 4]).max() > 0.01 * torque


# ---- against the row of equal cells, the endless beam, and the work of the loads -------------------------------------


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("name", WAYS)
def test_cells_that_are_held_alike_are_the_row_of_equal_cells(name, mu):
    way = WAYS[name](mu, free=(0, 0, 0, 0))
    phis = way.contact.phi * np.linspace(0.8, 1.8, 8)
    same = row.track(way, 7, phis)
    own = row.tied(way, 7, row.legs(phis, PHI), UNTIED, way.beams.free)
    for name in ("torque", "M", "P", "N", "f", "u_Z", "w_Y", "x", "y", "W", "W_fr", "energy"):
        expected = column(same, name)
        np.testing.assert_allclose(
            column(own, name), expected, atol=1e-9 * np.nanmax(np.abs(expected)) + 1e-12, rtol=0, err_msg=name
        )
    np.testing.assert_allclose(own.cells[..., 5].mean(axis=1), column(same, "torque")[:, 0], rtol=1e-9)
    # the cells at the ends carry less than those in the middle, as their neighbour is missing
    assert own.cells[-1, 0, 5] < 0.9 * own.cells[-1, 3, 5]


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("name", WAYS)
def test_the_middle_of_a_long_row_under_end_torque_is_the_endless_beam(name, mu):
    way = WAYS[name](mu)
    t = row.track(way, 61, way.contact.phi * np.linspace(0.9, 1.6, 15)[1:], ends=LOOSE)
    assert t.end.code == increments.RANGE
    torques = t.cells[-1, :, 5]
    np.testing.assert_allclose(torques, torques[0], rtol=1e-9)
    np.testing.assert_allclose(t.cells[-1, :, [4, 6, 7]], 0, atol=1e-9 * torques[0])
    middle = {name: v[-1, 30] for name, v in path.named(t.rows).items()}
    # the same twists, so that friction has the same way behind it
    endless = path.named(way.states(t.cells[:, 30, 1])[0])
    for name in ("torque", "psi", "aside", "stretch", "N", "f", "x", "y", "u_Z", "w_Y"):
        value = middle["torque"] if name == "torque" else middle[name]
        assert value == pytest.approx(endless[name][-1], rel=3e-4, abs=1e-9), name
    # the ends are felt
    assert abs(t.cells[-1, 0, 1] / t.cells[-1, 30, 1] - 1) > 0.02


def test_the_middle_of_a_long_row_under_end_moments_is_the_endless_beam():
    """Bent by moments at the ends, free to twist."""
    way = made(free=(0, 1, 1, 1))
    psis = np.linspace(0.02, 0.22, 11)
    t = row.track(way, 41, psis, ends=LOOSE, load=PSI)
    assert t.end.code == increments.RANGE
    moments = t.cells[-1, :, 4]
    np.testing.assert_allclose(moments, moments[0], rtol=1e-9)
    np.testing.assert_allclose(t.cells[-1, :, 5:], 0, atol=1e-9 * moments[0])
    bends = t.cells[:, 20, 0]
    beams = way.beams._replace(free=np.array([[0.0, 1.0, 1.0, 1.0]]))
    endless = path.follow_all(beams, bends[None], corners=np.column_stack([bends, 0 * bends])[None], most=0.3)
    far = {name: v[-1] for name, v in path.named(endless.rows[0]).items()}
    assert far["N"] > 0
    for name in ("M", "N", "x", "y", "stretch"):
        assert column(t, name)[-1, 20] == pytest.approx(far[name], rel=1e-4), name


@pytest.mark.parametrize("ends", [LOOSE, COUPLE, GRIPPED])
@pytest.mark.parametrize("name", WAYS)
def test_the_slope_of_the_energy_is_the_torque(name, ends):
    way, h = WAYS[name](), 2e-4
    t = row.track(way, 6, 1.5 * way.contact.phi + h * np.arange(-3, 4), 1e-3, ends=ends)
    U = column(t, "energy").sum(axis=1)
    slope = (U[6] - 9 * U[5] + 45 * U[4] - 45 * U[2] + 9 * U[1] - U[0]) / (60 * h)
    assert slope == pytest.approx(6 * column(t, "torque")[3, 0], rel=1e-8)


@pytest.mark.parametrize("ends", [LOOSE, COUPLE, GRIPPED])
@pytest.mark.parametrize("name", WAYS)
def test_energy_is_balanced_with_friction(name, ends):
    way = WAYS[name](0.4)
    t = row.track(way, 9, way.contact.phi * np.linspace(0, 2, 41)[1:], ends=ends)
    U, rubbed, lost, work = (column(t, name).sum(axis=1) for name in ("energy", "W_fr", "W_snap", "W"))
    np.testing.assert_allclose(work, U + rubbed + lost, atol=2e-4 * U.max())
    assert rubbed[-1] > 1e-3 * U[-1]


def test_a_straight_bar_stays_straight_between_grips():
    """Scales that do not couple bend and twist, and do not touch."""
    way = made()
    K = np.diag(np.diag(way.beams.K[0]))
    way = way._replace(beams=way.beams._replace(K=K[None]))
    t = row.track(way, 8, np.array([0.5 * way.contact.phi]), ends=GRIPPED)
    np.testing.assert_allclose(t.cells[0, :, :4], np.outer(np.ones(8), [0, 0.5 * way.contact.phi, 0, 0]), atol=1e-12)
    np.testing.assert_allclose(t.cells[0, :, 5], K[6, 6] * 0.5 * way.contact.phi, rtol=1e-12)


def test_grips_that_keep_their_distance_pull():
    held = row.track(made(free=(1, 0, 1, 0)), 8, np.array([0.08]), ends=GRIPPED)
    free = row.track(made(), 8, np.array([0.08]), ends=GRIPPED)
    assert far_end(held.cells[0, :, :4])[5] == pytest.approx(8, abs=1e-9)
    assert far_end(free.cells[0, :, :4])[5] < 8 - 1e-3
    assert (held.cells[0, :, 7] > 0).all()
    assert column(held, "torque")[0, 0] > column(free, "torque")[0, 0]


@pytest.mark.parametrize("rows", [("equal", "turned, on supports"), pytest.param((), marks=pytest.mark.slow)])
def test_derivatives_are_those_of_complex_steps(rows):
    """Of all that is written down, with friction and without; second rates of a cell's own strains roughly."""
    told = said("own_strains.py", *rows)
    assert told.pop("found") == [False, True, False]
    assert told.pop("room") == []
    for name, found in told.items():
        for missed in found:
            # tolerance: the normal's own turn times a friction of 1e-12
            assert missed["other"] < 2e-9, name
            assert missed["own"] < 1e-3, name


# ---- against finite elements -----------------------------------------------------------------------------------------


def clamped(way, n, warping):
    """Return a row of n scales whose end sections stay plane: the stiffness of cells against twist, by Vlasov's theory.

    ``warping``: the length, in pitches, along which a clamp is felt.
    """
    bounds = (np.arange(n + 1) - n / 2) / warping
    shares = 1 - warping * np.diff(np.sinh(bounds)) / np.cosh(bounds[-1])
    beams = entry.Beams._make(v.repeat(n, axis=0) for v in way.beams)
    K = beams.K[0]
    beams.K[:, 6, 6] += (K[6, 6] - K[6, :6] @ np.linalg.solve(K[:6, :6], K[:6, 6])) * (1 / shares - 1)
    return way._replace(beams=beams)


def test_five_gripped_scales_against_elements():
    """CalculiX, 2525 quadratic tetrahedra, elastic scales, end sections rigid; the model knows of no warping.

    So one number is theirs: the length along which a clamp is felt, by which the bar is 1.42 times as stiff before
    contact. All that comes behind is the model's. Rigid sections half a pitch beyond the outer scales hold these, too:
    the elements have no tilt there.
    """
    phis, theirs = np.array([0.04, 0.06, 0.07, 0.08, 0.09]), np.array([3.791, 6.919, 8.937, 10.950, 12.958])
    n, way, unit = 5, made(SKIN.friction.mu), 1e3 * SKIN.unit_moment
    held, free_of_grips = of_ends(n, GRIPPED), freed(np.ones((n, 4)), PHI, ends=GRIPPED)
    found = row.tied(clamped(way, n, 0.74), n, row.legs(phis, PHI), held, free_of_grips)
    torque = column(found, "torque")[:, 0] * unit
    assert torque[0] == pytest.approx(theirs[0], rel=0.02)
    # tolerance: 1.7 % at most; small strains of the joint, elements of one size
    np.testing.assert_allclose(torque, theirs, rtol=0.04)
    free = column(row.track(way, n, phis, ends=GRIPPED), "torque")[:, 0] * unit
    assert free[-1] < 0.7 * theirs[-1]
    tilts = np.tile(compliant.Held.of(SKIN).tilt, (1, 1))
    tilted = clamped(way._replace(beams=way.beams._replace(tilts=tilts)), n, 0.74)
    torque = column(row.tied(tilted, n, row.legs(phis, PHI), held, free_of_grips), "torque")[:, 0] * unit
    assert 0.88 < torque[-1] / theirs[-1] < 0.95


# ---- the door --------------------------------------------------------------------------------------------------------


def test_where_a_cell_leaves_what_was_compared_is_told():
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=8)
    r = squama.twist(beam, to="0.29 rad/pitch", points=30)
    cells = np.abs(r.phi_cell.values)
    (line,) = r.attrs["warnings"].splitlines()
    most = np.degrees(cells.max())
    assert f" deg per pitch): pitch {cells.max(axis=0).argmax() + 1} twists by up to {most:.3g} deg, and" in line
    mean = np.radians(float(line.partition(" deg (")[2].split()[0]))
    # tolerance: three digits of the mean are told
    assert np.interp(mean, r.phi, cells.max(axis=1)) == pytest.approx(0.3, rel=0.01)
    short = squama.twist(beam, to=f"{mean - 0.002} rad/pitch", points=10)
    assert short.attrs["warnings"] == ""


def test_the_door():
    r = squama.row(SKIN, scales=9, to="0.1 rad/pitch", points=30)
    assert r.attrs["ends"] == "free"
    assert r.phi_cell.dims == ("point", "scale")
    np.testing.assert_allclose(r.phi_cell.mean("scale"), r.phi, atol=1e-9)
    assert "T_cell" not in r
    work = np.trapezoid(r["T"], r.Phi)
    assert work == pytest.approx(float((r.U_el + r.W_fr)[-1]), rel=2e-3)
    gripped = squama.row(SKIN, scales=9, to="0.1 rad/pitch", points=30, ends="gripped")
    equal = squama.row(SKIN, scales=9, to="0.1 rad/pitch", points=30, ends="equal")
    assert "phi_cell" not in equal
    assert float(r["T"][-1]) < float(equal["T"][-1]) < float(gripped["T"][-1])
    # tolerance: axes of cells lean out of the line between the grips, 0.8 % of the torque on every processor
    np.testing.assert_allclose(gripped.T_cell[-1], gripped["T"][-1], rtol=0.02)
    # before contact cells do what the endless beam does, told with the same signs
    for sense in "+-":
        bare = squama.row(SKIN, scales=3, to="0.04 rad/pitch", points=5, sense=sense).isel(point=-1, scale=0)
        endless = squama.twist(SKIN, at=[0.04 / SKIN.pitch], sense=sense).isel(point=0)
        for name in ("phi", "psi", "chi", "stretch"):
            assert float(bare[f"{name}_cell"]) == pytest.approx(float(endless[name]), rel=1e-6), name
    held = squama.row(SKIN, scales=3, to="0.04 rad/pitch", points=5, hold="bend")
    assert "psi_cell" in held
    assert "M_lat_cell" not in held
    M = float(squama.twist(SKIN, at=[0.04 / SKIN.pitch], hold="bend").M[0])
    assert float(held.M_cell[-1, 0]) == pytest.approx(M, rel=1e-6)
    assert squama.row(SKIN, scales=3, points=4, to="0.02 rad/pitch", joint="hinge").attrs["ends"] == "equal"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"ends": "clamped"}, 'must be one of "free", "couple", "gripped", "equal"'),
        ({"ends": "free", "joint": "hinge"}, "is not known of a row on hinges"),
        ({"ends": "endless", "joint": "hinge"}, 'has no row of scales; leave it out, or write ends="equal"'),
        ({"ends": "gripped", "hold": "lateral bend"}, "the cells' bend is held"),
        ({"ends": "gripped", "scales": 61}, "must be 60 or less between grips"),
        ({"ends": "couple", "scales": 61}, "must be 60 or less under a couple"),
    ],
)
def test_ends_that_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        squama.row(SKIN, **{"scales": 3} | given)


def test_the_effect_of_an_end_decays_as_said():
    """Cells that find their own strains hand less on than those of one twist."""
    way = made()
    N = column(row.track(way, 40, np.array([1.001 * way.contact.phi]), ends=LOOSE), "N")[0]
    fall = (N[20] - N[1:5]) / (N[20] - N[:4])
    np.testing.assert_allclose(fall, row.decay(way, LOOSE), rtol=0.01)
    assert row.decay(way, LOOSE) < 0.5 * row.decay(way, EQUAL)


def test_energies_are_those_of_each_cell():
    way = made()
    t = row.track(way, 5, np.array([0.08]), ends=LOOSE)
    whole = sum(states.energies(way, t.rows[0]).values())
    assert whole.sum() == pytest.approx(column(t, "W")[0].sum(), rel=1e-6)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("scales", "to", "ends", "told"),
    [(12, 0.096, "free", True), (12, 0.06, "free", False), (12, 0.096, "couple", False), (12, 0.096, "gripped", False)],
)
def test_free_ends_that_turn_far_say_so(scales, to, ends, told):
    r = squama.twist(SKIN.replace(scales=scales), to=f"{to} rad/pitch", points=20, ends=ends)
    assert ('write ends="couple"' in r.attrs["warnings"]) is told
    cycle = squama.cycle(SKIN.replace(scales=scales), f"{to} rad/pitch", points=10, ends=ends)
    assert ('write ends="couple"' in cycle.attrs["warnings"]) is told
    if told:
        # the bow by the dataset's own cells
        bow = math.degrees(math.hypot(*(float(r[name][-1].sum()) for name in ("psi_cell", "chi_cell"))))
        assert f"turn by {bow:.3g} deg" in r.attrs["warnings"]
