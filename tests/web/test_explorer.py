"""The explorer in a browser: what people do there, and what they then see."""

from __future__ import annotations

import re
import tomllib

import numpy as np
import pytest
from PIL import Image

import squama
from squama.scene.motion import Setting
from squama.web import live, state

HINGED = "?" + state.query(state.preset("pla").hinged.started())
CUT = """() => [...document.querySelectorAll('.compared tr')].filter((row) => {
  const r = row.getBoundingClientRect(), at = document.elementFromPoint(r.left + 5, r.bottom - 2);
  return r.height < 20 || r.bottom > innerHeight || r.right > innerWidth || !row.contains(at); })
  .map((row) => [row.getBoundingClientRect().toJSON(), row.outerHTML.slice(0, 99)])"""
SHORT = """() => [...document.querySelectorAll('select')].filter((s) => {
  const probe = document.createElement('canvas').getContext('2d'), style = getComputedStyle(s);
  probe.font = style.font;
  const wanted = probe.measureText(s.selectedOptions[0]?.textContent || '').width + parseFloat(style.paddingLeft);
  return s.getClientRects().length && wanted + 14 > s.clientWidth; }).map((s) => s.outerHTML.slice(0, 100))"""
MESH = "[...squamaView.scales.geometry.attributes.position.array]"


def curve(page, i: int) -> list:
    return page.page.evaluate("squamaTest.curve", i)


def test_the_page_opens_with_the_example_and_draws_it(visit) -> None:
    page = visit()
    page.until_chart(4, "options.series.length > 0")
    page.shot("light")
    assert page.page.title() == "squama explorer"
    assert page.state()["name"] == "sliding"
    # more contacts come in: the curve goes on to the end of the asked range
    verdict = page.page.locator(".outcome strong").inner_text()
    assert verdict.startswith("Endless beam: free until 46.9 deg (1.88 deg per pitch), 1.26 times")
    # the beam's own scales are fewer
    assert page.page.locator(".outcome .own").inner_text().startswith("Your 25 scales with free ends carry about 3.")
    assert "nothing locks before" in page.page.locator(".outcome .sentence").inner_text()
    assert "thick, elastic scales on compliant joints" in page.page.locator(".outcome").inner_text()
    colours = page.page.evaluate(
        """() => { const gl = squamaView.renderer.getContext(); squamaView.draw();
        const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
        gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight,
        gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        const seen = new Set(); for (let i = 0; i < pixels.length; i += 40)
        seen.add([...pixels.slice(i, i + 3)].map((c) => c >> 5).join()); return [...seen]; }"""
    )
    assert len(colours) > 10, "ground, bar, scales, arrows"


def test_a_slider_moves_curve_mesh_and_address(visit) -> None:
    page = visit()
    eta, seen = page.state()["eta"], [curve(page, 0), page.page.evaluate(MESH), page.page.url]
    slider = page.slider("eta")
    slider.focus()
    slider.press("ArrowRight")
    page.until(f"squamaView.design.eta !== {eta}")
    after = page.state()["eta"]
    assert after == pytest.approx(eta + 0.075, abs=1e-3)
    for i, what in enumerate(("squamaTest.curve(0)", MESH, "location.href")):
        page.page.wait_for_function(f"(seen) => JSON.stringify({what}) !== JSON.stringify(seen)", arg=seen[i])
    # the dimension follows the ratio
    page.eventually(lambda: float(page.number("length").input_value()), pytest.approx(20 * after))
    slider = page.slider("mu")
    slider.focus()
    slider.press("PageUp")
    page.until("squamaView.state.mu > 0.4")
    # torque and friction of the page are those of the package
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scale={"length": after * 0.02})
    mu = page.state()["mu"]
    last = live.motion(Setting(beam, mu)).last
    theta = squama.twist(beam, mu=mu, at=[f"{last} rad/pitch"], ends="endless").theta.item()
    page.eventually(lambda: curve(page, 1)[-1], pytest.approx([25 * np.degrees(last), np.degrees(theta)], rel=1e-4))


@pytest.mark.slow
def test_a_change_comes_in_one_message_and_the_address_at_rest(visit) -> None:
    page = visit()
    page.until_chart(4, "options.series.length > 0")
    # with the first one the page is told of scripts that it has
    for mu in (0.27, 0.29):
        page.page.evaluate("() => { window.came = []; socket.offAny().onAny((event) => came.push(event)); }")
        page.slider("mu").focus()
        page.slider("mu").press("ArrowRight")
        page.until(f"location.search.includes('friction.mu={mu}')")
    # each message more is another frame of the whole page
    assert page.page.evaluate("came") == ["update", "run_javascript"]


@pytest.mark.slow
def test_dragging_ends_at_the_last_value(visit) -> None:
    page = visit(HINGED)
    most = float(f"{np.degrees(25 * live.motion(state.read(HINGED).setting).most):.3g}")
    box = page.slider("twist").bounding_box()
    mouse = page.page.mouse
    mouse.move(box["x"] + 0.3 * box["width"], box["y"] + box["height"] / 2)
    mouse.down()
    for i in range(30, 100, 2):
        mouse.move(box["x"] + i / 100 * box["width"], box["y"] + box["height"] / 2)
    mouse.up()
    page.eventually(lambda: float(page.number("twist").input_value()), pytest.approx(most))
    assert page.slider("twist").input_value() == "1"
    page.eventually(lambda: page.state()["name"], "locked")
    page.eventually(lambda: "its last state" in page.page.locator(".sentence").inner_text(), True)
    page.shot("locked")


def test_an_entry_that_cannot_be_is_explained_and_changes_nothing(visit) -> None:
    page = visit()
    before = page.state(), page.page.url
    for name, text, words in (
        ("eta", "0", "more than 0"),
        ("alpha", "120", "below 90 deg"),
        ("mu", "rough", "not a plain number"),
    ):
        page.enter(name, text)
        wrong = page.page.locator(".field.wrong .error")
        wrong.wait_for()
        assert words in wrong.inner_text()
        assert page.number(name).get_attribute("aria-invalid") == "true"
        assert page.number(name).input_value() == text, "what was entered stays, to be corrected"
        assert (page.state(), page.page.url) == before
        page.shot(f"wrong_{name}")
        page.number(name).fill({"eta": "3", "alpha": "60", "mu": "0.25"}[name])
        page.number(name).press("Enter")
        wrong.wait_for(state="detached")
    page.enter("length", "5 cm")
    page.until("Math.abs(squamaView.design.eta - 2.5) < 1e-9")
    assert page.number("eta").input_value() == "2.5"


def test_a_click_on_the_map_takes_its_design(visit) -> None:
    page = visit()
    page.until_chart(4, "options.series.length > 0")
    at = page.page.evaluate("squamaTest.chart(4).convertToPixel({xAxisIndex: 0, yAxisIndex: 0}, [27, 10])")
    page.page.locator(".chart").nth(4).scroll_into_view_if_needed()
    box = page.page.locator(".chart").nth(4).bounding_box()
    page.page.mouse.click(box["x"] + at[0], box["y"] + at[1])
    page.until("squamaView.state.mu === 1.5")
    page.eventually(lambda: float(page.number("mu").input_value()), pytest.approx(1.5))
    page.eventually(lambda: float(page.number("alpha").input_value()), pytest.approx(2 + 78 * 10 / 28, abs=1e-4))

    def place() -> tuple[float, float]:
        mark = page.page.locator(".marks b").last.bounding_box()
        return mark["x"] + mark["width"] / 2, mark["y"] + mark["height"] / 2

    # the mark lies on the cell that was clicked, wherever the words above have moved the map to
    def moved() -> tuple[float, float]:
        now, (x, y) = page.page.locator(".chart").nth(4).bounding_box(), place()
        return x - now["x"], y - now["y"]

    page.eventually(moved, pytest.approx(tuple(at), abs=1.5))
    # other axes
    page.page.locator(".axes select").first.select_option("eta")
    page.until_chart(4, "options.xAxis[1].max > 7")
    page.eventually(lambda: page.page.locator(".ends li").count() > 1, True)


def test_a_link_restores_everything(visit) -> None:
    page = visit()
    page.page.locator("header select").select_option("fig6b3")
    page.until("Math.abs(squamaView.design.beta - 0.6) < 1e-9 && Math.abs(squamaView.design.lam - 0.32) < 1e-9")
    page.page.locator("[data-do=keep]").click()
    page.enter("alpha", "50")
    page.enter("twist", "0.1 rad/pitch")
    page.page.get_by_label("Force law", exact=True).select_option("plate")
    page.page.wait_for_function("location.search.includes('law=plate') && location.search.includes('keep=')")
    page.until("squamaView.design.law === 'plate' && Math.abs(squamaView.state.load - 0.1) < 1e-9")
    page.page.wait_for_function("location.search.includes('twist=0.1') && location.search.includes('alpha=50')")
    other = visit(page.page.url.partition("?")[1] + page.page.url.partition("?")[2])
    assert other.state() == page.state()
    other.eventually(lambda: other.number("alpha").input_value(), "50")
    other.eventually(lambda: other.page.locator(".compared tbody tr").count(), 2)
    other.shot("compared")
    for query in ("?scale.length=5", "?<b>x</b>=1"):
        page = visit(query)
        notice = page.page.locator(".notice")
        notice.get_by_text("The link cannot be used").wait_for()
        assert page.state()["eta"] == 3


@pytest.mark.slow
def test_up_to_three_designs_are_compared(visit) -> None:
    page = visit()
    for i, mu in enumerate(("0.1", "0.5", "1")):
        page.enter("mu", mu)
        page.until(f"squamaView.state.mu === {mu}")
        page.page.locator("[data-do=keep]").click()
        page.until(f"document.querySelectorAll('.compared tbody tr').length === {i + 2}")
    page.enter("mu", "0.25")
    page.until("squamaView.state.mu === 0.25")
    names = "['A', 'B', 'C', 'this design (endless beam)'].every((name) => options.series.some((s) => s.name === name))"
    page.until_chart(0, names)
    rows = page.page.locator(".compared tbody tr")
    for width, height in ((1280, 720), (1280, 800), (1600, 900), (1920, 1080)):
        page.page.set_viewport_size({"width": width, "height": height})
        page.page.wait_for_timeout(400)
        page.shot(f"three_{height}")
        top = page.page.locator(".compared").bounding_box()["y"]
        for i in (0, 1, 2, 4):
            box = page.page.locator(".chart").nth(i).bounding_box()
            assert box["y"] + box["height"] <= top, "both rows of plots stay in sight"
            assert box["height"] > 80
        if height > 720:
            assert page.page.evaluate(CUT) == [], "every row is whole and in sight"
    page.page.set_viewport_size({"width": 1280, "height": 720})
    for row in rows.all():
        row.scroll_into_view_if_needed()
        at = row.bounding_box()
        assert at["y"] + at["height"] <= 720
    assert [cell.inner_text() for cell in page.page.locator(".compared td:nth-child(2)").all()] == [
        f"μ = {mu}" for mu in ("0.1", "0.5", "1", "0.25")
    ]
    page.page.locator("[data-do=keep]").click()
    page.page.locator(".notice.shown").wait_for()
    assert "3 designs are kept" in page.page.locator(".notice").inner_text()
    # each has its letter on the map, and its line among those that are named
    marks = [mark.bounding_box() for mark in page.page.locator(".marks b", has_text=re.compile("[ABC]")).all()]
    assert len(marks) == 3
    assert page.page.locator(".lines").inner_text().split("\n")[:4] == ["this design (endless beam)", "A", "B", "C"]
    page.page.locator(".compared button", has_text="Remove").first.click()
    page.until("document.querySelectorAll('.compared tbody tr').length === 3")
    page.page.locator(".compared button", has_text="Show").last.click()
    page.until("squamaView.state.mu === 1")


@pytest.mark.slow
def test_bending_is_shown_too(visit) -> None:
    page = visit()
    page.page.locator(".controls .choice select").nth(0).select_option("bending")
    page.until("squamaView.design.kind === 'bending'")
    page.page.locator(".choice", has_text="Force law").wait_for(state="hidden")
    page.page.locator(".outcome dl", has_text="Moment").wait_for()
    page.page.wait_for_timeout(800)
    page.shot("bending")
    page.page.locator(".controls .choice select").nth(0).select_option("twisting")
    page.until("squamaView.design.kind === 'twisting'")
    page.page.locator(".choice", has_text="Force law").wait_for()


def test_files_are_handed_out(visit, tmp_path) -> None:
    page = visit()
    look = """(({canvas: {width, height}, camera: c}) => [width, height, c.fov, c.aspect, c.position.toArray()])
      (squamaView)"""
    got, looked = {}, page.page.evaluate(look)
    for kind in ("toml", "csv", "png", "html", "plots-svg", "plots-png"):
        page.page.locator(".menu summary").click()
        with page.page.expect_download() as waiting:
            page.page.locator(f"[data-do={kind}]").click()
        page.page.locator(".menu div").wait_for(state="hidden")
        got[kind] = tmp_path / waiting.value.suggested_filename
        waiting.value.save_as(got[kind])
    assert squama.Beam.from_toml(got["toml"]) == squama.Beam.from_toml("examples/pla_on_vps.toml")
    assert tomllib.loads(got["toml"].read_text())["scale"]["length"] == "60 mm"
    assert "T (N m)" in got["csv"].read_text()
    assert got["png"].read_bytes().startswith(b"\x89PNG")
    drawn = Image.open(got["png"]).convert("L")
    assert drawn.width >= 1600
    assert drawn.height >= 700
    # the whole beam, and it fills the picture, which has room for the beam before it was twisted too
    beam = np.abs(np.asarray(drawn, int) - drawn.getpixel((0, 0))) > 8
    across, down = np.flatnonzero(beam.any(axis=0)), np.flatnonzero(beam.any(axis=1))
    assert 0 < across[0] < across[-1] < drawn.width - 1
    assert 0 < down[0] < down[-1] < drawn.height - 1
    assert max(np.ptp(across) / drawn.width, np.ptp(down) / drawn.height) > 0.7
    # the view itself stays as it is
    *seen, place = page.page.evaluate(look)
    assert seen == looked[:-1]
    assert place == pytest.approx(looked[-1], rel=1e-9)
    assert got["plots-png"].read_bytes().startswith(b"\x89PNG")
    assert "thick, elastic scales on compliant joints" in got["plots-svg"].read_text()
    # the view opens from the file alone, with nothing to reach
    alone = page.context.browser.new_context(offline=True, viewport={"width": 900, "height": 600})
    own = alone.new_page()
    complaints, asked = [], []
    own.on("console", lambda m: complaints.append(m.text))
    own.on("pageerror", lambda e: complaints.append(str(e)))
    own.on("request", lambda r: asked.append(r.url.split(":")[0]))
    own.goto(got["html"].as_uri())
    own.wait_for_function("window.squamaView && squamaView.contacts.length > 0")
    own.locator("#load").focus()
    before = own.evaluate("squamaView.state.load")
    own.locator("#load").press("ArrowRight")
    assert own.evaluate("squamaView.state.load") > before
    # a drag moves the thumb, and nothing else
    sizes = """() => ['#load', '#stage'].flatMap((id) => { const r = document.querySelector(id).getBoundingClientRect();
      return [r.left, r.top, r.width, r.height]; })"""
    said = set()
    for width in (900, 600, 390):
        own.set_viewport_size({"width": width, "height": 600})
        first = own.evaluate(sizes)
        for i in range(0, 240, 20):
            own.locator("#load").fill(str(i))
            assert own.evaluate(sizes) == first
            said.add(own.locator("#now").inner_text())
    assert len(said) == 12
    motion = live.motion(state.preset("pla").setting)
    assert said >= {motion.words(s) for s in motion.samples(240)[::20]}
    keys = own.locator("#legend").inner_text()
    assert all(words in keys for words in ("not in contact", "sliding", "normal force", "friction on the tip"))
    assert "locked" not in keys
    own.set_viewport_size({"width": 900, "height": 600})
    own.locator("#load").fill("160")
    own.screenshot(path=page.place("alone"))
    eye = own.evaluate("squamaView.camera.position.toArray()")
    own.locator("canvas").press("ArrowLeft")
    assert own.evaluate("squamaView.camera.position.toArray()") != eye
    own.locator("canvas").press("Home")
    own.locator("#play").click()
    own.wait_for_function("(before) => squamaView.state.load !== before", arg=before)
    own.locator("#play").click()
    assert complaints == []
    assert set(asked) <= {"file", "data"}
    alone.close()


def test_model_and_scales_are_chosen_and_named(visit) -> None:
    page = visit()
    joint, scales, law = (page.page.get_by_label(words, exact=True) for words in ("Joint", "Scales", "Force law"))
    axes = page.page.evaluate("squamaView.state.pose")
    assert [sum(x * x for x in axis) for axis in axes[1:]] == pytest.approx([1, 1])
    told = page.page.locator(".outcome .end")
    scales.select_option("yes")
    told.get_by_text("thin, rigid scales on compliant joints").wait_for()
    law.select_option("plate")
    page.until("!squamaView.state.pose")
    told.get_by_text("thin, rigid scales on hinges, plate law").wait_for()
    page.eventually(joint.input_value, "hinge")
    joint.select_option("compliant")
    page.until("squamaView.state.pose")
    page.eventually(lambda: (law.input_value(), scales.input_value()), ("edge", "no"))
    page.page.wait_for_function("location.search.includes('joint=compliant&ideal=no')")


@pytest.mark.slow
def test_a_joint_that_needs_elements_is_solved_beside_the_page(visit) -> None:
    pytest.importorskip("netgen", reason="needs the extra fe")
    page = visit("?" + state.query(state.preset("main").change("theta0", "36")))
    page.page.set_default_timeout(300_000)
    page.page.locator(".choice", has_text="Joint").locator("select").select_option("compliant")
    # the page answers meanwhile, and what is asked then counts
    page.enter("mu", "0.4")
    page.until("squamaView.state.pose && squamaView.state.mu === 0.4")
    page.page.locator(".notice").wait_for(state="hidden")
    page.until_chart(0, "options.series.length > 0")
    page.shot("compliant")


@pytest.mark.slow
def test_both_models_and_a_loop_are_drawn(visit) -> None:
    page = visit()
    names = "options.series.map((s) => s.name).join()"
    page.until_chart(0, f"{names} === 'without contact,on hinges,this design (endless beam)'")
    page.page.get_by_label("Load path", exact=True).select_option("cycle")
    page.until_chart(2, f"{names}.includes('unloading') && options.yAxis[0].min < 0")
    page.page.locator(".outcome dl", has_text="dissipated").wait_for()
    page.page.wait_for_function("location.search.includes('path=cycle')")
    page.page.get_by_label("Material", exact=True).select_option("steel")
    page.until("squamaView.state.torque > 0.3")
    page.eventually(lambda: float(page.number("scale_modulus").input_value()), 200)
    page.shot("loop")
    # what is beyond the axis is marked at its border
    page.page.get_by_label("Joint", exact=True).select_option("hinge")
    page.enter("twist", "1 rad/pitch")
    page.page.locator(".plot").first.locator(".marks b", has_text="\N{UPWARDS ARROW}").wait_for()


@pytest.mark.slow
def test_a_beam_is_let_go_also_from_a_link(visit) -> None:
    page = visit()
    let_go = page.page.locator("[data-do=release]")
    assert not let_go.is_visible()
    page.page.get_by_label("Load path", exact=True).select_option("decay")
    page.page.wait_for_function("location.search.includes('path=decay')")
    top = page.state()["load"]
    let_go.click()
    page.page.locator(".notice", has_text="in the first cycle").wait_for()
    # it goes through the sense in which the scales open, and no arrow says what the way back does not have
    page.until("squamaView.design.sense === -1")
    assert page.page.evaluate("squamaView.contacts.length") == 0
    page.shot("decay")
    page.eventually(let_go.inner_text, "Stop")
    let_go.click()
    page.eventually(let_go.inner_text, "Let go")
    page.until(f"squamaView.state.load === {top} && squamaView.design.sense === 1")
    # a change ends it, too
    let_go.click()
    page.eventually(let_go.inner_text, "Stop")
    page.enter("mu", "0.4")
    page.until("squamaView.state.mu === 0.4 && squamaView.state.x > 0")
    page.eventually(let_go.inner_text, "Let go")
    page.enter("twist", "0")
    let_go.click()
    page.page.locator(".notice", has_text="nothing moves").wait_for()
    other = visit("?" + state.query(state.preset("main").change("path", "decay")))
    other.page.locator("[data-do=release]").click()
    other.until("squamaView.state.name === 'free' && squamaView.design.sense === -1")


@pytest.mark.slow
def test_warnings_are_seen_and_push_nothing_away(visit) -> None:
    page = visit()
    top = "document.querySelector('.stage').getBoundingClientRect().bottom"
    before = page.page.evaluate(top)
    page.page.locator("header select").select_option("main")
    page.page.locator(".warnings li", has_text="not thin").wait_for()
    assert page.page.evaluate(top) == before
    box = page.page.locator(".chart").nth(1).bounding_box()
    assert box["y"] + box["height"] < 800
    # no list shows less than what is chosen in it
    assert page.page.evaluate(SHORT) == []
