"""Solids for the printer, against vectors, half-spaces and readers of their own."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

import squama
from squama.errors import SquamaError
from squama.fabrication import bodies, kinds, mesh, solids
from squama.fabrication.bodies import block
from squama.fabrication.mesh import Check
from squama.fabrication.plan import Plan, apart, between
from squama.fabrication.plan import plan as make_plan
from squama.fe import geometry as elements
from squama.plot import projection as drawn

pytest.importorskip("manifold3d")

PLA = Plan(32, 16, 20, 4, 60, 6, 24, 0.8, math.radians(60), math.radians(15))
STEEP = Plan(40, 20, 18, 3, 30, 7, 20, 1.1, math.radians(25), math.radians(35), clearance=0.1, bed=55.0)
SIDE = Plan(30, 14, 21, 3, 25, 9, 9, 0.6, math.radians(80), math.radians(20), draft=math.radians(2))
LONG = Plan(25, 12.5, 10, 5, 23.2, 12.8, 6, 1, math.radians(40), math.radians(10), clearance=0.05, feature=0.2)
PLANS = pytest.mark.parametrize("plan", [PLA, STEEP, SIDE, LONG], ids=["pla", "steep", "side", "long tabs"])


def directions(plan):
    """Axes of the scales as along, across, up, from the formulas of the theory."""
    a, th = plan.alpha, plan.theta0
    x = np.array([math.cos(a) * math.cos(th), -math.sin(a) * math.cos(th), math.sin(th)])
    y = np.array([math.sin(a), math.cos(a), 0])
    return np.array([x, y, np.cross(x, y)])


def base(plan, k):
    return np.array([plan.ends + (k + 0.5) * plan.pitch, 0, plan.height])


def convex_volume(normals, offsets):
    """Volume of the points with normals . p <= offsets, and its corners, by half-spaces."""
    norms = np.linalg.norm(normals, axis=1)
    found = linprog([0, 0, 0, -1], np.c_[normals, norms], offsets, bounds=[(None, None)] * 3 + [(0, None)])
    if not found.success or found.x[3] < 1e-12:
        return 0.0, np.empty((0, 3))
    corners = HalfspaceIntersection(np.c_[normals, -np.asarray(offsets)], found.x[:3]).intersections
    return ConvexHull(corners).volume, corners


def slot_in_bar(plan, k):
    """Slot of scale k within the bar, by half-spaces."""
    x, y, z = directions(plan)
    c, o = plan.clearance, base(plan, k)
    sides = [(-x, plan.embedded + c), (y, plan.breadth / 2 + c), (-y, plan.breadth / 2 + c)]
    sides += [(z, plan.thickness / 2 + c), (-z, plan.thickness / 2 + c)]
    e = np.eye(3)
    normals = [n for n, _ in sides] + [e[0], -e[0], e[1], -e[1], e[2], -e[2]]
    offsets = [h + n @ o for n, h in sides] + [plan.total, 0, plan.width / 2, plan.width / 2, plan.height, 0]
    return convex_volume(np.array(normals), np.array(offsets))


def inside(body, points):
    """Whether points lie in a closed mesh: winding number by solid angles."""
    total = np.zeros(len(points))
    for triangle in body.vertices[body.triangles]:
        a, b, c = (corner - points for corner in triangle)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        num = np.einsum("ij,ij->i", a, np.cross(b, c))
        den = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        total += 2 * np.arctan2(num, den)
    return total > 2 * math.pi


@PLANS
def test_volume_of_the_substrate_by_half_spaces(plan):
    body = mesh.build(bodies.substrate(plan))
    slots = sum(slot_in_bar(plan, k)[0] for k in range(plan.scales))
    expected = plan.width * plan.height * plan.total - slots
    assert body.volume == pytest.approx(expected, rel=1e-10)
    assert bodies.substrate(plan).volume == pytest.approx(expected, rel=1e-10)
    lowest = min(slot_in_bar(plan, k)[1][:, 2].min() for k in range(plan.scales))
    depth = next(c for c in mesh.slots(plan, body) if c.what == "depth of slots")
    assert depth.measured == pytest.approx(plan.height - lowest, abs=1e-9)


@PLANS
def test_the_plates_sit_where_the_elements_have_them(plan):
    """With no clearance a point of the bar is in the mesh exactly if the elements' slot does not hold it."""
    tight = plan._replace(clearance=0.0, scales=2)
    d = tight.pitch * 1e-3
    beam = squama.Beam(
        scale={
            "length": tight.length * 1e-3,
            "embedded": tight.embedded * 1e-3,
            "width": tight.breadth * 1e-3,
            "thickness": tight.thickness * 1e-3,
            "alpha": tight.alpha,
            "theta0": tight.theta0,
        },
        substrate={
            "width": tight.width * 1e-3,
            "thickness": tight.height * 1e-3,
            "youngs_modulus": 1e6,
            "poisson_ratio": 0.4,
        },
        pitch=d,
        scales=2,
    )
    described = elements.geometry(beam)
    random = np.random.default_rng(5)
    # along, across, up of points around the second slot
    low = base(tight, 1) - [tight.embedded + tight.breadth, tight.width / 2, tight.height / 3]
    high = base(tight, 1) + np.array([tight.breadth, tight.width / 2, 0])
    points = random.uniform(low, np.minimum(high, [tight.total, np.inf, np.inf]), (4000, 3))
    points[:2000] = base(tight, 1) + random.uniform(-1, 1, (2000, 3)) * [
        tight.embedded,
        tight.breadth / 2,
        tight.thickness,
    ] @ directions(tight)
    points = points[(points[:, 2] < tight.height) & (np.abs(points[:, 1]) < tight.width / 2)]
    held = np.zeros(len(points), bool)
    for k in range(2):
        local = points - base(tight, k)
        # to across, out of the face, along in pitches, from the bar's middle
        held |= described.in_slot(local[:, [1, 2, 0]] / tight.pitch + [0, described.lam, 0], slack=0)
    assert 0.05 < held.mean() < 0.95
    assert (inside(mesh.build(bodies.substrate(tight)), points) == ~held).all()
    np.testing.assert_allclose(tight.axes, described.rest.axes, atol=1e-15)


@PLANS
def test_every_scale_stands_in_its_slot(plan):
    flat = mesh.build(bodies.scale(plan))
    assert flat.volume == pytest.approx((plan.length + plan.embedded) * plan.breadth * plan.thickness, rel=1e-12)
    for k in range(plan.scales):
        seated = flat.moved(*bodies.seat(plan, k, plan.thickness))
        local = (seated.vertices - base(plan, k)) @ directions(plan).T
        np.testing.assert_allclose(local.min(0), [-plan.embedded, -plan.breadth / 2, -plan.thickness / 2], atol=1e-10)
        np.testing.assert_allclose(local.max(0), [plan.length, plan.breadth / 2, plan.thickness / 2], atol=1e-10)


@PLANS
def test_the_mould_is_the_negative_of_the_bar(plan):
    cavity = 0.0
    for recipe in bodies.trays(plan):
        made = mesh.build(recipe)
        box = np.prod(np.ptp(made.bounds, axis=0))
        cavity += box - made.volume
    if plan.draft == 0:
        assert cavity == pytest.approx(plan.width * plan.height * plan.total, rel=1e-12)
    else:
        # the middle section is the bar's; bottom and rim by hand
        slope = plan.height * math.tan(plan.draft)

        def area(s):
            return (plan.width + s) * (plan.total + s)

        assert cavity == pytest.approx(plan.height * (area(-slope) + 4 * area(0) + area(slope)) / 6, rel=1e-12)
    knife = mesh.build(bodies.blade(plan))
    deep, across, t = (
        plan.embedded + plan.clearance,
        plan.breadth + 2 * plan.clearance,
        plan.thickness + 2 * plan.clearance,
    )
    shank = knife.vertices[knife.vertices[:, 0] < plan.shank - 1e-9]
    assert np.ptp(shank[:, 1]) == pytest.approx(across)
    assert np.ptp(knife.vertices[:, 2]) == pytest.approx(t)
    # what is under the face when its head rests on the lid
    turn, shift = bodies.seat(plan, 1, t)
    seated = knife.moved(turn, shift)
    below, _ = slot_in_bar(plan, 1)
    body = mesh.manifold(seated) ^ mesh.manifold(
        mesh.Mesh("", block((0, -500, 0), (1e3, 500, plan.height)), mesh.TRIANGLES)
    )
    assert body.volume() == pytest.approx(below, rel=1e-9)
    assert seated.vertices[:, 2].min() == pytest.approx(
        plan.height - deep * math.sin(plan.theta0) - t / 2 * math.cos(plan.theta0)
    )


@pytest.mark.parametrize("plan", [STEEP, PLA._replace(bed=210.0, scales=25)], ids=["upright", "oblique"])
def test_pieces_fit_on_the_bed_and_make_up_the_whole(plan):
    whole = plan._replace(bed=None)
    for make in (bodies.trays, bodies.lids):
        pieces, one = [mesh.build(r) for r in make(plan)], mesh.build(make(whole)[0])
        assert len(pieces) > 1
        assert max(np.ptp(p.bounds, axis=0)[0] for p in pieces) <= plan.bed
        assert sum(p.volume for p in pieces) == pytest.approx(one.volume, rel=1e-12)
        joined = np.array([p.bounds for p in pieces])
        np.testing.assert_allclose(joined[:, 0].min(0), one.bounds[0])
        np.testing.assert_allclose(joined[:, 1].max(0), one.bounds[1])
    assert len({r.name for r in bodies.trays(plan)}) > 1
    assert (bodies.seam(plan).by_y == 0) == (plan is STEEP)
    made = solids.make(plan, ["mould"])
    assert not [c.line() for c in made.checks if not c.holds]


@PLANS
def test_everything_that_is_measured_holds(plan):
    made = solids.make(plan, kinds.PARTS)
    assert not [c.line() for c in made.checks if not c.holds]
    assert {"thickness", "theta0", "alpha", "volume", "slots", "slits", "pieces"} <= {c.what for c in made.checks}
    assert sum(c.what == "thickness" for c in made.checks) == plan.scales


def test_a_wrong_solid_does_not_pass():
    flat, bar = mesh.build(bodies.scale(PLA)), mesh.build(bodies.substrate(PLA))

    def failed(checks):
        return {c.what for c in checks if not c.holds}

    seated = flat.moved(*bodies.seat(PLA, 0, PLA.thickness))
    assert failed(mesh.scale(PLA, seated)) == set()
    assert failed(mesh.scale(PLA._replace(thickness=0.81), seated)) == {"thickness"}
    assert failed(mesh.scale(PLA._replace(theta0=PLA.theta0 + 1e-6), seated)) == {"theta0"}
    assert failed(mesh.scale(PLA._replace(alpha=-PLA.alpha), seated)) == {"alpha"}
    mirrored = seated._replace(vertices=seated.vertices * [1, -1, 1], triangles=seated.triangles[:, ::-1])
    assert failed(mesh.scale(PLA, mirrored)) == {"alpha"}
    assert failed(mesh.scale(PLA._replace(alpha=-PLA.alpha), mirrored)) == set()
    for changed, what in [
        ({"alpha": -PLA.alpha}, {"alpha"}),
        ({"clearance": 0.25}, {"thickness of slots", "depth of slots"}),
        ({"embedded": 6.1}, {"depth of slots"}),
        ({"pitch": 20.001}, {"distance of slots"}),
        ({"scales": 5}, {"slots"}),
    ]:
        assert failed(mesh.slots(PLA._replace(**changed), bar)) == what
    assert failed(mesh.solid(bodies.scale(PLA)._replace(volume=1267.21), flat)) == {"volume"}
    assert failed(mesh.slots(PLA, flat)) == {"slots"}
    assert mesh.open_edges(flat) == 0
    assert mesh.open_edges(flat._replace(triangles=flat.triangles[1:])) == 3
    turned = flat.triangles.copy()
    turned[0] = turned[0][::-1]
    assert mesh.open_edges(flat._replace(triangles=turned)) > 0
    with pytest.raises(SquamaError, match="not a manifold"):
        mesh.manifold(flat._replace(triangles=flat.triangles[1:]))
    assert mesh.closed(flat.triangles)
    assert not mesh.closed(flat.triangles[1:])
    assert not mesh.closed(turned)
    # two tetrahedra that touch in a point
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    four = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    both = mesh.Mesh(
        "", np.concatenate([corners, -corners[1:]]), np.concatenate([four, np.where(four, four + 3, 0)[:, ::-1]])
    )
    assert mesh.open_edges(both) == 0
    pinched = next(c for c in mesh.solid(bodies.scale(PLA), both) if c.what == "pinched vertices")
    assert (pinched.measured, pinched.holds) == (1, False)


def test_overlaps_are_found_with_their_volume():
    flat = mesh.build(bodies.scale(PLA))
    moved = flat.moved(np.eye(3), (3.0, -2.0, 0.3))
    common = (66 - 3) * (24 - 2) * (0.8 - 0.3)
    assert mesh.overlaps([flat, moved], "").measured == pytest.approx(common, rel=1e-12)
    thick = PLA._replace(thickness=3.0)
    plates = [mesh.build(bodies.scale(thick)).moved(*bodies.seat(thick, k, 3.0)) for k in range(2)]
    x, y, z = np.abs(directions(thick) @ [thick.pitch, 0, 0])
    lens = (66 - x) * (24 - y) * (3 - z)
    assert mesh.overlaps(plates, "").measured == pytest.approx(lens, rel=1e-9)
    assert not mesh.overlaps(plates, "").holds


@PLANS
def test_neighbours_are_as_far_apart_as_their_corners_say(plan):
    """Distance of two equal boxes: what separates them along each of their axes."""
    plates = [mesh.build(bodies.scale(plan)).moved(*bodies.seat(plan, k, plan.thickness)) for k in range(2)]
    step = np.abs(directions(plan) @ [plan.pitch, 0, 0])
    free = np.maximum(step - [plan.length + plan.embedded, plan.breadth, plan.thickness], 0)
    assert mesh.gap(plates[0], plates[1:], 50.0) == pytest.approx(np.linalg.norm(free), abs=1e-9)


def test_distance_of_polygons_by_points_on_them():
    random = np.random.default_rng(2)
    share = np.linspace(0, 1, 90)[:, None]
    seen = set()
    for _ in range(60):
        a, b = (random.normal(size=(7, 2)) + random.uniform(-4, 4, 2) for _ in range(2))
        a, b = a[ConvexHull(a).vertices], b[ConvexHull(b).vertices]
        edges = [
            np.concatenate([p + share * (q - p) for p, q in itertools.pairwise([*poly, poly[0]])]) for poly in (a, b)
        ]
        brute = np.linalg.norm(edges[0][:, None] - edges[1], axis=-1).min()
        found = apart(a, b)
        seen.add(found > 0)
        if found > 0:
            assert brute - 0.06 < found <= brute + 1e-12
        else:
            hulls = [ConvexHull(p).equations for p in (a, b)]
            both = np.concatenate(hulls)
            assert linprog([0, 0], both[:, :2], -both[:, 2], bounds=[(None, None)] * 2).success
    assert seen == {True, False}
    assert between(PLA, PLA.slot_profile, PLA.slot[1]) > 0


def test_rays_through_a_box():
    box = mesh.Mesh("box", block((0, 0, 0), (2, 3, 4)), mesh.TRIANGLES)
    origins = np.array([[-1, 1, 1], [1, 1, 1], [5, 1, 1], [-1, 9, 1.0]])
    np.testing.assert_allclose(mesh.cast(box, origins, np.array([1.0, 0, 0])), [1, 1, np.inf, np.inf])
    first = mesh.faces(box)[0]
    assert first.area == pytest.approx(12)
    assert np.abs(first.normal).tolist() == [1, 0, 0]
    assert box.volume == pytest.approx(24)


def test_a_picture_covers_what_is_seen():
    flat = mesh.build(bodies.scale(PLA))
    view = drawn.fitted([flat], drawn.look(30, 40))
    image = drawn.picture([flat], [(1, 0, 0)], view, 400)
    pixel = (view.right - view.left) / 400
    seen = (image[..., 3] / 255).sum() * pixel**2
    shadow = ConvexHull(flat.vertices @ view.axes[:2].T).volume
    # tolerance: pixels at the rim, 0.7 % measured
    assert seen == pytest.approx(shadow, rel=0.02)
    assert np.linalg.det(view.axes) == pytest.approx(1)
    # the nearer one hides the other, whatever their order
    above = flat.moved(np.eye(3), (0, 0, 5.0))
    top = drawn.fitted([flat], drawn.look(0, 90))
    for order in ((0, 1), (1, 0)):
        both, colours = [flat, above], [(1, 0, 0), (0, 0, 1)]
        image = drawn.picture([both[i] for i in order], [colours[i] for i in order], top, 100)
        middle = image[image.shape[0] // 2, 50]
        assert middle[2] > middle[0]


def test_a_check_says_what_differs():
    assert Check("volume", "scale", 2.0, 2.5, "mm^3", 0.1).line() == "scale: volume = 2.5 mm^3, should be 2 mm^3"


def test_sizes_of_a_beam_in_millimetres():
    beam = squama.Beam.from_toml_text(squama.Beam.from_ratios(beta=0.6, scales=7).replace(pitch="17.3 mm").to_toml())
    plan = make_plan(beam, None, {"ends": 0.0125, "draft": 0.1})
    assert (plan.pitch, plan.scales, plan.ends, plan.draft) == (17.3, 7, 12.5, 0.1)
    assert plan.breadth == pytest.approx(beam.scale.width * 1e3, rel=1e-12)
