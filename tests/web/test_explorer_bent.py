"""The explorer's two sliders: a beam that is bent, and twisted while it stays bent."""

from __future__ import annotations

import numpy as np
import pytest

from squama.scene import geometry

SIZES = {"phone": (390, 844), "page": (1280, 800), "wide": (1920, 1080)}
BAR = "() => { const v = squamaView; return [v.design, v.state.load, squamaGeometry.bar(v.design, v.state.load)]; }"


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES)
def test_bend_and_twist_by_their_sliders(visit, size):
    width, height = SIZES[size]
    page = visit(viewport={"width": width, "height": height})
    page.enter("bend", "0.03 rad/pitch")
    page.until("Math.abs(squamaView.design.held - 0.03) < 1e-9")
    page.enter("twist", "0.1 rad/pitch")
    page.until("Math.abs(squamaView.state.load - 0.1) < 1e-9")
    d, load, bar = page.page.evaluate(BAR)
    np.testing.assert_allclose(bar, geometry.bar(d, load)[0], rtol=0, atol=1e-12)
    scale = page.page.evaluate(
        "() => squamaGeometry.scale(squamaView.design, squamaView.state.load, squamaView.state.theta, 2.5)"
    )
    theta = page.state()["theta"]
    np.testing.assert_allclose(scale["corners"], geometry.scale(d, load, theta, 2.5).corners, rtol=0, atol=1e-12)
    page.page.locator(".warnings li", has_text="the map does not include the held bend").wait_for()
    page.page.wait_for_function("location.search.includes('bend=0.03')")
    for scheme in ("light", "dark"):
        page.page.emulate_media(color_scheme=scheme)
        page.page.wait_for_function(
            "dark => document.body.classList.contains('body--dark') === dark", arg=scheme == "dark"
        )
        page.shot(f"bent_{size}_{scheme}")
        # no sideways scrolling
        assert page.page.evaluate("document.documentElement.scrollWidth") <= width
    # what cannot be bent so far is explained there, and changes nothing
    page.enter("bend", "0.9 rad/pitch")
    field = page.page.locator(".field", has=page.number("bend"))
    field.locator(".error", has_text="is beyond the beam's").wait_for()
    assert page.state()["held"] == 0.03


@pytest.mark.slow
def test_the_slider_bends_and_a_link_holds_it(visit):
    page = visit()
    slider = page.slider("bend")
    slider.focus()
    slider.press("PageUp")
    page.until("squamaView.design.held > 0.01")
    bent = page.page.evaluate("squamaView.design.held")
    page.page.wait_for_function("location.search.includes('bend=')")
    again = visit("?" + page.page.url.partition("?")[2])
    assert again.state()["held"] == pytest.approx(bent)
    # in bending alone there is nothing to hold
    again.page.get_by_label("Loading", exact=True).select_option("bending")
    again.slider("bend").wait_for(state="hidden")
