"""The explorer for everybody: keyboard, names that are read aloud, a phone's width, dark pages."""

from __future__ import annotations

import pytest

from squama.web import fields, state
from squama.web.fields import FIELDS

NAMELESS = """() => [...document.querySelectorAll('input, select, button, canvas, a, summary')].filter((e) => {
  if (e.closest('[aria-hidden=true], .chart') || !e.getClientRects().length) return false;
  return !(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.[0]?.textContent);
}).map((e) => e.outerHTML.slice(0, 200))"""
CLIPPED = """() => [...document.querySelectorAll('.explorer *, header *')].filter((e) => {
  const r = e.getBoundingClientRect();
  return r.width && (r.right > screen.width + 1 || r.left < -1) && !e.closest('table, .strip, .legend'); })
  .map((e) => e.outerHTML.slice(0, 160))"""
SMALL = """() => [...document.querySelectorAll('button, select, input')].filter((e) => {
  const r = e.getBoundingClientRect(); return r.width && r.height < 24; }).map((e) => e.outerHTML.slice(0, 120))"""


def test_everything_has_a_name_and_takes_the_keyboard(visit) -> None:
    page = visit()
    assert page.page.evaluate(NAMELESS) == []
    for details in page.page.locator("details").all():
        details.evaluate("(e) => { e.open = true; }")
    assert page.page.evaluate(NAMELESS) == []
    for name in FIELDS:
        field = fields.of(name, state.example())
        assert page.slider(name).get_attribute("aria-label") == field.label
        assert field.unit in (page.number(name).get_attribute("aria-label") or "")
        described = page.number(name).get_attribute("aria-describedby")
        assert (" deg per pitch" if field.turn else field.allowed.partition("(")[0]) in page.page.locator(
            f"#{described}"
        ).inner_text()
    # by Tab alone from the top to the sliders
    page.page.locator("[data-do=open]").focus()
    seen = ["open"]
    while "twist" not in seen and len(seen) < 60:
        page.page.keyboard.press("Tab")
        seen.append(
            page.page.evaluate("(({dataset: d, tagName}) => d.field || d.do || tagName)(document.activeElement)")
        )
    assert {"open", "SUMMARY", "link", "CANVAS", "reset", "SELECT", "keep", "twist"} <= set(seen)


@pytest.mark.slow
def test_the_view_turns_and_zooms_by_keys(visit) -> None:
    page = visit()
    canvas = page.page.locator("canvas[tabindex='0']")
    eye = "squamaView.camera.position.toArray()"
    start = page.page.evaluate(eye)
    assert "25 scales" in canvas.get_attribute("aria-label")
    for key in ("ArrowLeft", "ArrowUp", "+"):
        before = page.page.evaluate(eye)
        canvas.press(key)
        assert page.page.evaluate(eye) != before
    away = page.page.evaluate("squamaView.camera.position.distanceTo(squamaView.controls.target)")
    canvas.press("-")
    assert page.page.evaluate("squamaView.camera.position.distanceTo(squamaView.controls.target)") > away
    canvas.press("Home")
    assert page.page.evaluate(eye) == start
    # and by the mouse
    box = canvas.bounding_box()
    page.page.mouse.move(box["x"] + 300, box["y"] + 100)
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + 380, box["y"] + 130, steps=3)
    page.page.mouse.up()
    assert page.page.evaluate(eye) != start
    page.page.locator("[data-do=reset]").click()
    page.until(f"JSON.stringify({eye}) === JSON.stringify({start})".replace("'", '"'))
    page.page.locator("[data-do=arrows]").click()
    page.until("squamaView.forces.normal[0].count === 0")


@pytest.mark.slow
def test_a_phone_shows_it_all(visit) -> None:
    page = visit(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True, device_scale_factor=2)
    page.page.wait_for_timeout(700)
    page.shot("phone", full=True)
    assert page.page.evaluate(CLIPPED) == []
    assert page.page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.page.evaluate(SMALL) == []
    page.slider("mu").evaluate("(e) => e.scrollIntoView({block: 'end'})")
    page.slider("mu").tap()
    page.until("squamaView.state.mu !== 0.25")
    # view and plots stay in sight beside the sliders
    page.shot("phone_sliders")
    for place in ("canvas[tabindex='0']", ".chart >> nth=0"):
        box = page.page.locator(place).bounding_box()
        assert box["y"] >= 0
        assert box["height"] > 120
        assert box["y"] + box["height"] <= page.slider("mu").bounding_box()["y"]


@pytest.mark.slow
@pytest.mark.parametrize("height", [720, 800])
def test_a_small_window_shows_the_view_and_the_plots(visit, height) -> None:
    page = visit(viewport={"width": 1280, "height": height})
    assert page.page.evaluate(CLIPPED) == []
    assert page.page.evaluate("document.documentElement.scrollWidth") <= 1280
    for i in (0, 1, 2, 4):
        box = page.page.locator(".chart").nth(i).bounding_box()
        top = page.page.locator(".compared").bounding_box()["y"]
        assert box["y"] + box["height"] <= top < height, "to be seen without scrolling"
        assert box["height"] > (115 if height == 800 else 85)


@pytest.mark.slow
def test_dark_pages_are_dark(visit) -> None:
    page = visit(color_scheme="dark")
    page.until("document.body.classList.contains('body--dark')")
    page.until_chart(0, "options.title[0].textStyle.color === '#e8eaed'")
    page.until("squamaView.scene.background.getHexString() === '16191d'")
    page.until("getComputedStyle(document.body).backgroundColor === 'rgb(22, 25, 29)'")
    page.until_chart(4, "JSON.stringify(options.xAxis[1]).includes('#e8eaed')")
    page.shot("dark")
    page.page.locator("[data-do=dark]").click()
    page.until("!document.body.classList.contains('body--dark')")
    page.until("squamaView.scene.background.getHexString() === 'f7f7f5'")
    page.until_chart(0, "options.title[0].textStyle.color === '#1d2125'")
