"""What the explorer shows of what is entered and pointed at: values of fields, designs of the map."""

from __future__ import annotations

import math

import numpy as np
import pytest

from squama.web import map, state  # noqa: A004 - the module is named after what it draws


@pytest.mark.slow
def test_a_field_holds_its_value_ready_to_be_typed_over(visit) -> None:
    page = visit()
    field, keys = page.number("twist"), page.page.keyboard
    per_pitch = f"{math.radians(90) / 25:.6g}"
    chosen = "(e) => e.value.slice(e.selectionStart, e.selectionEnd)"
    page.enter("twist", "90 deg total")
    page.eventually(field.input_value, per_pitch)
    page.eventually(lambda: field.evaluate(chosen), per_pitch)
    # away and back
    for _ in range(2):
        keys.press("Tab")
        keys.press("Shift+Tab")
        assert field.input_value() == per_pitch
        assert field.evaluate(chosen) == per_pitch
    keys.type("0.2")
    assert field.input_value() == "0.2"
    keys.press("Enter")
    page.until("Math.abs(squamaView.state.load - 0.2) < 1e-9")
    # the same in other words is a value, too
    page.enter("twist", "0.20 rad/pitch")
    page.eventually(field.input_value, "0.2")
    # what is typed behind it stays until it is entered
    keys.press("End")
    keys.type("1")
    page.page.wait_for_timeout(200)
    assert field.input_value() == "0.21"
    # a wrong entry that another change makes pointless does not come back
    page.enter("mu", "rough")
    page.page.locator(".field.wrong").wait_for()
    page.until("Math.abs(squamaView.state.load - 0.21) < 1e-9")
    page.enter("twist", "0.1")
    page.until("Math.abs(squamaView.state.load - 0.1) < 1e-9")
    page.page.locator(".field.wrong").wait_for(state="detached")
    page.number("mu").focus()
    assert page.number("mu").input_value() == "0.25"


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
    assert said == ["μ = 0.5, α = 63.3 deg", name, f"engages at {e}° per pitch", f"{ratio} times as stiff as the bar"]
    # whole, over what stands below it
    inside = """(e) => { const r = e.getBoundingClientRect();
      return [[r.left, r.top], [r.right, r.bottom]].map(([x, y], i) =>
        e.contains(document.elementsFromPoint(x + 3 - 6 * i, y + 3 - 6 * i)[0])); }"""
    tip.evaluate("(e) => { e.style.pointerEvents = 'auto'; }")
    assert tip.evaluate(inside) == [True, True]
