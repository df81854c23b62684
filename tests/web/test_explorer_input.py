"""What the explorer shows of what is entered and pointed at: values of fields, designs of the map."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from squama.web import map, state  # noqa: A004 - the module is named after what it draws


@pytest.mark.slow
def test_a_field_holds_its_value_ready_to_be_typed_over(visit) -> None:
    page = visit()
    field, keys = page.number("twist"), page.page.keyboard
    chosen = "(e) => e.value.slice(e.selectionStart, e.selectionEnd)"
    page.enter("twist", "90 deg total")
    page.eventually(field.input_value, "90")
    page.eventually(lambda: field.evaluate(chosen), "90")
    # away and back
    for _ in range(2):
        keys.press("Tab")
        keys.press("Shift+Tab")
        assert field.input_value() == "90"
        assert field.evaluate(chosen) == "90"
    keys.type("30")
    assert field.input_value() == "30"
    keys.press("Enter")
    page.until(f"Math.abs(squamaView.state.load - {math.radians(30) / 25}) < 1e-9")
    # the same in other words is a value, too
    page.enter("twist", "1.20 deg/pitch")
    page.eventually(field.input_value, "30")
    field_of = page.page.locator(".field", has=field)
    assert "1.2 deg per pitch (slider 0 to" in field_of.inner_text()
    assert field_of.inner_text().startswith("Twist over 25 scales Nφ")
    # what is typed behind it stays until it is entered
    keys.press("End")
    keys.type("1")
    page.page.wait_for_timeout(200)
    assert field.input_value() == "301"
    # a wrong entry that another change makes pointless does not come back
    page.enter("mu", "rough")
    page.page.locator(".field.wrong").wait_for()
    page.until(f"Math.abs(squamaView.state.load - {math.radians(301) / 25}) < 1e-9")
    page.enter("twist", "0.1 rad/pitch")
    page.until("Math.abs(squamaView.state.load - 0.1) < 1e-9")
    page.page.locator(".field.wrong").wait_for(state="detached")
    page.number("mu").focus()
    assert page.number("mu").input_value() == "0.25"


@pytest.mark.slow
def test_the_map_says_what_is_under_the_pointer(visit) -> None:
    page = visit()
    page.until_chart(4, "options.series.length > 0")
    chart = page.page.locator(".chart").nth(4)
    chart.scroll_into_view_if_needed()
    at = page.page.evaluate("squamaTest.chart(4).convertToPixel({xAxisIndex: 0, yAxisIndex: 0}, [9, 22])")
    box = chart.bounding_box()
    page.page.mouse.move(box["x"] + at[0], box["y"] + at[1])
    tip = chart.locator("> div", has_text="engages")
    tip.wait_for()
    said = tip.inner_text().split("\n")
    page.shot("tooltip")
    now = state.preset("pla")
    key = map.key(now, "mu", "alpha")
    found = map.grid(key)
    e, ratio = (f"{float(v[22, 9]):.3g}" for v in (np.degrees(found.load_e), found.figure))
    name = map.CLASSES[found.code[22, 9]]
    whole = f"{math.degrees(25 * found.load_e[22, 9]):.3g}"
    engages = f"engages at {whole} deg ({e} deg per pitch)"
    assert said == ["μ = 0.5, α = 63.3 deg", name, engages, f"{ratio} times as stiff as the bar"]
    # whole, over what stands below it
    inside = """(e) => { const r = e.getBoundingClientRect();
      return [[r.left, r.top], [r.right, r.bottom]].map(([x, y], i) =>
        e.contains(document.elementsFromPoint(x + 3 - 6 * i, y + 3 - 6 * i)[0])); }"""
    tip.evaluate("(e) => { e.style.pointerEvents = 'auto'; }")
    assert tip.evaluate(inside) == [True, True]


@pytest.mark.slow
def test_a_curve_says_its_values_with_their_units_under_the_pointer(visit) -> None:
    page = visit()
    chart = page.page.locator(".chart").first
    box = chart.bounding_box()
    page.page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 0.5 * box["height"])
    tip = chart.locator("> div", has_text="this design")
    tip.wait_for()
    first, *rows = tip.inner_text().split("\n")
    page.shot("read_off")
    assert re.fullmatch(r"\d+(\.\d)? deg", first)
    assert rows
    assert all(re.fullmatch(r"[\w ()]+: \d+(\.\d+)? N mm", row) for row in rows)
