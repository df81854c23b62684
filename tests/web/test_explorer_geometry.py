"""The view's own geometry, in the page's scripts, against the package's and against the oracle's vectors."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import squama
from oracle.twisting import places, side
from oracle.vectors import FP, Design, add, mul
from oracle.vectors import scale as oracle_scale
from squama.fe import plate
from squama.scene import geometry, look, picture
from squama.scene.motion import Motion, Setting, State, shape, shapes
from squama.web import state

hinged = functools.partial(Setting, joint="hinge")
CASES = [
    hinged(squama.Beam.from_ratios(scales=9), 0.5),
    hinged(squama.Beam.from_ratios(scales=9, alpha="20 deg", eta=4), 0.2, law="plate"),
    hinged(
        squama.Beam.from_ratios(eta=1.0683, beta=0.80579, lam=1.034, alpha=0.15793, theta0=0.11, zeta=0.02),
        0.2,
        sense="-",
    ),
    hinged(squama.Beam.from_ratios(scales=9), 0.3, load="bending"),
]
SCRIPT = """(cases) => cases.map(([d, load, theta, slip, k]) => ({
  scale: squamaGeometry.scale(d, load, theta, k), contact: squamaGeometry.contact(d, load, theta, k),
  directions: squamaGeometry.directions(d, load, theta, slip, k), bar: squamaGeometry.bar(d, load),
  arrow: squamaGeometry.arrow(theta) }))"""

CAMERA = """() => { squamaView.reset(); const c = squamaView.camera; c.updateMatrixWorld();
  const seen = squamaView.contacts.map((p) => new c.position.constructor(...p).project(c).toArray());
  return {aspect: c.aspect, eye: c.position.toArray(), seen}; }"""


ENDS = """([d, s]) => ({ bar: squamaGeometry.bar(d, s.strains),
  point: squamaGeometry.contact(d, s.strains, s.each[1].pose, -0.5, s.each[1].bent, s.each[2]).point,
  corners: squamaGeometry.scales([[d, s]]).map((one) => one[2].corners) })"""
BODIES = """(cases) => cases.map(([d, s, k]) => ({
  ...squamaGeometry.plate(d, s.bent), bar: squamaGeometry.bar(d, s.strains),
  scale: squamaGeometry.scale(d, s.strains, s.pose, k).corners,
  point: squamaGeometry.contact(d, s.strains, s.pose, k, s.bent).point }))"""


def of_thick_scales() -> list[tuple[dict, State, float]]:
    """Return states of beams that bow, their thick scales bent."""
    beam, found = squama.Beam.from_toml("examples/stiff_skin.toml"), []
    for load, faces in (("twisting", "one"), ("bending", "one"), ("twisting", "mirrored, shifted")):
        motion = Motion(Setting(beam.replace(faces=faces), 0.25, load=load))
        state = motion.state(0.6 * motion.last)
        found += [(d, of(state), k) for d, of in shapes(motion) for k in (-2.0, 1.5)]
    return found


@pytest.fixture
def states(monkeypatch) -> list:
    monkeypatch.setattr("squama.arrays.solution.touch", lambda *_, **__: None)
    found = []
    for setting in CASES:
        motion = Motion(setting)
        d = shape(setting, motion.neighbour)
        e = motion.load_e
        for fraction in (0.1, 0.6, 0.95):
            s = motion.state(e + fraction * (motion.last - e))
            found += [(d, s.load, s.theta, list(s.slip), k) for k in (-3.0, 0.0, 2.5)]
    return found


def of_both_faces() -> list:
    """Return states of both faces' scales."""
    found = []
    for faces, load in (("turned, shifted", "twisting"), ("mirrored", "bending")):
        motion = Motion(hinged(squama.Beam.from_ratios(scales=9).replace(faces=faces), 0.2, load=load))
        state = motion.state(0.6 * motion.last)
        for d, of in shapes(motion):
            s = of(state)
            found.append((d, s.load, s.theta, list(s.slip), 0.5))
    return found


def moved(d: dict) -> list[list[float]]:
    """Return the pose of a scale whose base has moved and that has turned about all axes."""
    rest = plate.Rest.at(d["eta"], d["beta"], d["lam"], d["alpha"], 0.2)
    c, R = plate.pose(rest, np.array([0.02, -0.01, 0.03, 0.1, 0.3, -0.2]))
    return np.array([c - rest.base, *(R @ rest.axes[:2].T).T]).tolist()


def test_the_scripts_geometry_is_the_packages(visit, states: list) -> None:
    page = visit()
    states += of_both_faces()
    states += [(d, load, moved(d), slip, k) for d, load, _, slip, k in states[::4]]
    for (d, load, theta, slip, k), js in zip(states, page.page.evaluate(SCRIPT, states), strict=True):
        one, c = geometry.scale(d, load, theta, k), geometry.contact(d, load, theta, k)
        for name, mine in one._asdict().items():
            assert np.allclose(js["scale"][name], mine, rtol=0, atol=1e-12), name
        for name, mine in c._asdict().items():
            assert np.allclose(js["contact"][name], mine, rtol=0, atol=1e-12), name
        n, t = geometry.directions(d, load, theta, tuple(slip), k)
        assert np.allclose([js["directions"]["normal"], js["directions"]["friction"]], [n, t], rtol=0, atol=1e-9)
        assert np.allclose(js["bar"], geometry.bar(d, load)[0], rtol=0, atol=1e-12)
        if isinstance(theta, float):
            assert js["arrow"] == pytest.approx(geometry.arrow(theta), rel=1e-13)


@pytest.mark.slow
def test_scales_of_a_beam_with_ends_are_the_packages(visit) -> None:
    beam = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=4)
    motion = Motion(Setting(beam, 0.25, ends="free", to=0.12))
    (d, _), s = shapes(motion)[0], motion.state(0.12)
    js = visit().page.evaluate(ENDS, [d, {**s._asdict(), "each": [one._asdict() for one in s.each]}])
    one, two = s.each[1:3]
    stand = geometry.Stand(two.attitude, two.bent)
    mine = {
        "bar": geometry.bar(d, s.at)[0],
        "point": geometry.contact(d, s.at, one.attitude, -0.5, one.bent, stand).point,
        "corners": [geometry.scale(d, s.at, s.of(i).attitude, i - 1.5).corners for i in range(4)],
    }
    for name, values in mine.items():
        assert np.allclose(js[name], values, rtol=0, atol=1e-11), name


@pytest.mark.slow
def test_thick_bent_scales_on_a_bar_that_bows_are_the_packages(visit) -> None:
    page, cases = visit(), of_thick_scales()
    assert [bool(s.bent) for _, s, _ in cases].count(True) >= 6
    for (d, s, k), js in zip(
        cases, page.page.evaluate(BODIES, [(d, s._asdict(), k) for d, s, k in cases]), strict=True
    ):
        plate = geometry.plate(d, s.bent)
        mine = {
            **plate._asdict(),
            "bar": geometry.bar(d, s.at)[0],
            "scale": geometry.scale(d, s.at, s.attitude, k).corners,
            "point": geometry.contact(d, s.at, s.attitude, k, s.bent).point,
        }
        for name, values in mine.items():
            assert np.allclose(js[name], values, rtol=0, atol=1e-11), name


@pytest.mark.slow
def test_contact_points_of_the_scripts_are_the_oracles(visit, states: list) -> None:
    page = visit()
    twisted = [s for s in states if s[0]["kind"] == "twisting"]
    assert len(twisted) > 20
    for (d, load, theta, _, k), js in zip(twisted, page.page.evaluate(SCRIPT, twisted), strict=True):
        o = Design(d["eta"], d["alpha"], d["beta"], d["lam"], 0.1, d["sense"], d["neighbour"])
        p, s = places(FP, o, theta, load)
        assert (js["contact"]["p"], js["contact"]["s"]) == pytest.approx((p, s), abs=1e-9)
        two = oracle_scale(FP, o, theta, load, k + d["neighbour"])
        assert np.allclose(js["contact"]["point"], add(side(o, two), mul(s, two.x)), rtol=0, atol=1e-9)


def test_the_page_draws_what_the_kernel_says(visit) -> None:
    """Places on the edges as the page has them, for the beam that it shows, against squama.twist."""
    page = visit("?" + state.query(state.preset("pla").hinged))
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml")
    for text in ("0.08", "0.12", "0.16"):
        page.enter("twist", f"{text} rad/pitch")
        page.until(f"Math.abs(squamaView.state.load - {text}) < 1e-9")
        now = page.page.evaluate(
            "(() => { const {design: d, state: s} = squamaView; return {theta: s.theta, "
            "...squamaGeometry.contact(d, s.load, s.theta, 0), drawn: squamaView.contacts.length}; })()"
        )
        r = squama.twist(beam, at=[f"{text} rad/pitch"], joint="hinge")
        assert now["theta"] == pytest.approx(r.theta.item(), abs=1e-9)
        assert (now["p"], now["s"]) == pytest.approx((r.p.item() / 0.02, r.s.item() / 0.02), abs=1e-9)
        assert now["drawn"] == 24


@pytest.mark.slow
def test_the_still_picture_is_taken_from_where_the_page_looks(visit) -> None:
    page = visit()
    js = page.page.evaluate(CAMERA)
    motion = Motion(Setting(squama.Beam.from_toml("examples/pla_on_vps.toml"), 0.25))
    s, d = motion.state(page.state()["load"]), motion.shape()
    tips = [tips for _, tips in picture._arrows(d, s, motion.setting.mu)[1]]
    camera = look.fitted(np.concatenate([look.outline(d, s.at, s.attitude), *tips]), js["aspect"])
    assert np.allclose(camera.eye, js["eye"], rtol=0, atol=1e-9)
    places = geometry.first(d) + np.arange(24)
    points = np.array([geometry.contact(d, s.at, s.attitude, k, s.bent).point for k in places])
    assert np.allclose(camera.seen(points)[:, :2], np.array(js["seen"])[:, :2], rtol=0, atol=1e-6)


OUTSIDE = """() => { const {camera: c, design: d, state: s} = squamaView, V = c.position.constructor;
  c.updateMatrixWorld();
  const all = squamaGeometry.bar(d, s.strains ?? s.load).flat();
  for (let i = 0; i < d.scales; i++)
    all.push(...squamaGeometry.scale(d, s.strains ?? s.load, s.pose ?? s.theta, squamaGeometry.first(d) + i).corners);
  const seen = all.map((p) => new V(...p).project(c));
  return Math.max(...seen.flatMap((q) => [Math.abs(q.x), Math.abs(q.y)])); }"""


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080), (2560, 1440)])
def test_what_leaves_the_view_is_framed_anew(visit, size) -> None:
    page = visit(
        "?" + state.query(state.preset("pla").change("twist", "0.21 rad/pitch")),
        viewport={"width": size[0], "height": size[1]},
    )
    page.until("Math.abs(squamaView.state.load - 0.21) < 1e-9")
    assert page.page.evaluate(OUTSIDE) < 1
    way = "squamaView.camera.position.clone().sub(squamaView.controls.target).normalize().toArray()"
    before = page.page.evaluate(way)
    page.enter("twist", "0.05 rad/pitch")
    page.until("Math.abs(squamaView.state.load - 0.05) < 1e-9")
    page.page.wait_for_timeout(200)
    page.shot(f"framed_{size[0]}")
    assert page.page.evaluate(OUTSIDE) < 1
    assert page.page.evaluate(way) == pytest.approx(before)
    # turned by hand it is turned still, and whole
    canvas = page.page.locator("canvas[tabindex='0']")
    for _ in range(4):
        canvas.press("ArrowLeft")
    turned = page.page.evaluate(way)
    assert turned != pytest.approx(before, abs=1e-2)
    for load in ("0.21", "0.05"):
        page.enter("twist", f"{load} rad/pitch")
        page.until(f"Math.abs(squamaView.state.load - {load}) < 1e-9")
        assert page.page.evaluate(OUTSIDE) < 1
    assert page.page.evaluate(way) == pytest.approx(turned, abs=1e-6)
    # who has come near stays there
    for _ in range(8):
        canvas.press("+")
    near = page.page.evaluate("squamaView.camera.position.toArray()")
    page.enter("twist", "0.1 rad/pitch")
    page.until("Math.abs(squamaView.state.load - 0.1) < 1e-9")
    assert page.page.evaluate("squamaView.camera.position.toArray()") == near


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080)])
def test_a_decay_stays_in_the_view(visit, size) -> None:
    now = state.preset("pla").change("path", "decay").change("twist", "0.22 rad/pitch")
    page = visit("?" + state.query(now), viewport={"width": size[0], "height": size[1]})
    page.until("Math.abs(squamaView.state.load - 0.22) < 1e-9")
    page.page.evaluate(f"() => {{ window.far = []; squamaView.onDraw = () => far.push(({OUTSIDE})()); }}")
    page.page.locator("[data-do=release]").click()
    page.until("far.length > 40 && squamaView.design.sense === -1")
    page.shot(f"decay_{size[0]}")
    assert max(page.page.evaluate("far")) < 1
