"""The page around the beam: undoing, menus, lists, lines of text, marks."""

from __future__ import annotations

import pytest


@pytest.mark.slow
def test_the_way_back_undoes_and_does_not_leave_the_page(visit) -> None:
    page = visit()
    first = page.page.url
    for mu in ("0.3", "0.4"):
        page.enter("mu", mu)
        page.page.wait_for_function(f"location.search.includes('friction.mu={mu}')")
    page.page.go_back()
    page.until("squamaView.state.mu === 0.3")
    page.eventually(lambda: page.number("mu").input_value(), "0.3")
    page.page.go_forward()
    page.until("squamaView.state.mu === 0.4")
    page.page.locator("[data-do=undo]").click()
    page.until("squamaView.state.mu === 0.3")
    page.page.locator("body").press("Control+z")
    page.until("squamaView.state.mu === 0.25")
    page.eventually(lambda: page.page.url, first)
    # nothing is left to undo
    page.page.locator("[data-do=undo]").click()
    page.page.wait_for_timeout(500)
    assert page.page.url == first
    # what somebody writes into the history is read as a link is
    page.page.evaluate("emitEvent('went', { link: '?scale.length=5', step: 0 })")
    page.page.locator(".notice.shown", has_text="has no unit").wait_for()
    for wrong in ("1", "{}", "{ link: 1, step: 'x' }"):
        page.page.evaluate(f"emitEvent('went', {wrong})")
    assert page.state()["mu"] == 0.25


@pytest.mark.slow
def test_the_menu_shuts_by_escape_and_by_a_click_elsewhere(visit) -> None:
    page = visit()
    menu, shut = page.page.locator(".menu > summary"), "!document.querySelector('.menu').open"
    for leave in (lambda: page.page.keyboard.press("Escape"), lambda: page.page.mouse.click(700, 290)):
        menu.click()
        page.page.locator("[data-do=toml]").wait_for(state="visible")
        leave()
        page.until(shut)
    menu.click()
    page.page.locator("[data-do=toml]").wait_for(state="visible")
    menu.click()
    page.until(shut)


@pytest.mark.slow
def test_one_main_part_lists_of_one_width_and_no_line_that_is_cut(visit) -> None:
    page = visit()
    page.page.locator("header select").select_option("main")
    page.page.locator(".warnings li").first.wait_for()
    assert page.page.locator("main").count() == 1
    widths = "(where) => [...document.querySelectorAll(`${where} select`)].map((s) => s.offsetWidth).filter(Boolean)"
    for where in (".controls", ".axes"):
        assert len(set(page.page.evaluate(widths, where))) == 1
    # millimetres stand before ratios
    groups = page.page.locator(".controls summary").all_inner_texts()
    assert groups.index("Dimensions and angles") < groups.index("Ratios")
    page.page.evaluate("document.querySelector('.notice').classList.add('shown')")
    for name in (".warnings", ".notice"):
        style = f"getComputedStyle(document.querySelector('{name}'))"
        lines = page.page.evaluate(
            f"(parseFloat({style}.maxHeight) - 2 * parseFloat({style}.borderTopWidth)) / parseFloat({style}.lineHeight)"
        )
        assert lines == round(lines), name


@pytest.mark.slow
def test_a_mark_that_stands_aside_has_a_leader_to_its_place(visit) -> None:
    page = visit()
    page.page.locator("[data-do=keep]").click()
    page.enter("twist", "0.2 rad/pitch")
    page.page.locator(".marks b.aside", has_text="A").wait_for()
    lead = """() => { const b = document.querySelector('.marks b.aside'), own = b.getBoundingClientRect();
      const at = (pseudo, what) => parseFloat(getComputedStyle(b, pseudo)[what]);
      const place = [...document.querySelectorAll('.axes ~ .cells .marks b')].find((o) => !o.textContent);
      const middle = (r) => r.left + r.width / 2;
      return [at('::before', 'width'), middle(own) - middle(place.getBoundingClientRect())]; }"""
    long, aside = page.page.evaluate(lead)
    assert abs(aside) == pytest.approx(20, abs=1)
    assert long == pytest.approx(12, abs=1)
