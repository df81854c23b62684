"""A part under load on the page."""

from __future__ import annotations

import pytest


def test_a_cantilever_is_loaded_and_greyed_by_a_change(visit) -> None:
    page = visit()
    # the first part of an installation compiles its code
    page.page.set_default_timeout(300_000)
    page.enter("scales", "6")
    page.until("squamaView.design.scales === 6")
    part = page.page.locator(".part")
    part.locator("summary").click()
    force = page.page.locator("[data-do=force]")
    force.fill("nothing")
    force.press("Enter")
    page.page.locator("[data-do=bear]").click()
    page.page.locator(".notice.shown", has_text="force").wait_for()
    force.fill("0.5 N")
    force.press("Enter")
    page.page.locator("[data-do=bear]").click()
    part.locator("li", has_text="0.5 N at").wait_for()
    assert force.input_value() == "0.5 N"
    picture = part.locator("img")
    page.until("document.querySelector('.part img').naturalWidth > 300")
    picture.scroll_into_view_if_needed()
    page.shot("part")
    page.enter("mu", "0.4")
    page.until("document.querySelector('.part .old img')")


@pytest.mark.slow
def test_back_during_a_computation_leaves_page_and_address_together(visit) -> None:
    page = visit()
    # the first part of an installation compiles its code
    page.page.set_default_timeout(300_000)
    page.enter("scales", "8")
    page.until("location.search.includes('beam.scales=8')")
    page.enter("mu", "0.4")
    page.until("location.search.includes('friction.mu=0.4')")
    page.page.locator(".part summary").click()
    page.page.evaluate("() => { document.querySelector('[data-do=bear]').click(); history.back(); }")
    page.page.locator(".notice.shown", has_text="something else is being computed still").wait_for()
    page.until("location.search.includes('friction.mu=0.4')")
    assert page.state()["mu"] == 0.4
    # nothing of the way back is lost
    page.page.locator(".part li", has_text="N at").wait_for()
    page.page.locator("[data-do=undo]").click()
    page.until("squamaView.state.mu === 0.25 && !location.search.includes('friction.mu=0.4')")
