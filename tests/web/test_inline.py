"""The beam in space inside a notebook: a frame of its own, without a server and without the internet."""

import io
import math
import re
from base64 import b64decode

from PIL import Image

import squama

BEAM = squama.Beam.from_ratios(scales=6)


def test_the_frame_turns_the_beam_and_fetches_nothing(browser) -> None:
    shown = squama.view(BEAM, to="0.2 rad/pitch", mu=0.5, joint="hinge")
    context = browser.new_context(offline=True, viewport={"width": 900, "height": 700})
    page = context.new_page()
    asked, wrong = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.set_content(shown._repr_html_())
    frame = page.frame_locator("iframe")
    frame.locator("canvas").wait_for()
    text = frame.locator("body").inner_text()
    # the nearest of the states inside
    seen = float(re.search(r"inclination ([\d.]+)", text)[1])
    assert abs(seen - math.degrees(shown.state.theta)) < 0.5
    assert "thin, rigid scales on hinges" in text
    assert not wrong
    assert all(url.startswith(("data:", "about:")) for url in asked)
    context.close()


def test_without_nicegui_it_is_a_picture(monkeypatch) -> None:
    shown = squama.view(BEAM, to="0.2 rad/pitch", mu=0.5, joint="hinge")
    monkeypatch.setattr("squama.scene.standalone.find_spec", lambda _: None)
    made = b64decode(re.search(r"base64,([^\"]+)", shown._repr_html_())[1])
    assert Image.open(io.BytesIO(made)).size == (1600, 760)
    assert repr(shown).startswith(
        "View(thin, rigid scales on hinges, edge law; endless beam: Twist 68.8 deg (11.5 deg per pitch) over 6 scales"
    )
