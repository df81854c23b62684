"""What a notebook shows of a beam, a fit and designs."""

import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.beam.card import DRAWN, card, side

EXAMPLES = Path(__file__).parents[2] / "examples"
BEAM = squama.Beam.from_toml(EXAMPLES / "stiff_skin.toml")


class Balanced(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.open, self.text = [], []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def test_a_beam_says_what_it_is_made_of():
    words = " ".join(Balanced(BEAM._repr_html_()).text)
    scale = BEAM.scale
    for value in (scale.length, scale.width, scale.thickness, scale.embedded, BEAM.substrate.width):
        assert f"{value * 1e3:.4g}" in words
    assert f"{BEAM.scales} scales" in words
    assert f"eta {BEAM.eta:.4g}" in words


def test_warnings_are_on_the_card():
    narrow = BEAM.replace(substrate={"width": "3 mm"})
    (warning, *_) = narrow.warnings(joint="compliant")
    assert warning in " ".join(Balanced(narrow._repr_html_()).text)


@pytest.mark.parametrize("scales", [2, 25])
def test_the_drawing_is_to_scale(scales):
    text = side(BEAM.replace(scales=scales))
    drawn = [
        np.array([[float(x) for x in pair.split(",")] for pair in points.split()])
        for points in re.findall(r'points="([^"]*)"', text)
    ]
    bar, *plates = drawn
    assert len(plates) == 2 * min(scales, DRAWN)
    k = np.ptp(bar[:, 1]) / BEAM.substrate.thickness
    # exposed parts, from the last scale to the first; rounded to hundredths of a pixel
    tips = plates[1::2]
    # tolerance: hundredths of a pixel
    assert tips[0][0, 0] - tips[1][0, 0] == pytest.approx(k * BEAM.pitch, rel=1e-3)
    rise = BEAM.scale.length * np.sin(BEAM.scale.theta0)
    assert tips[0][0, 1] - tips[0][3, 1] == pytest.approx(k * rise, rel=1e-3)


def test_text_of_strangers_is_escaped():
    shown = card("<b>", [("<script>", "&")], ["<i>"])
    assert "<script>" not in shown
    assert Balanced(shown).text == ["<b>", "<script>", "&", "<i>"]


@pytest.mark.slow
def test_designs_and_fits_say_what_they_reach():
    found = squama.inverse_design(
        {"target": {"lock": "0.25 rad/pitch"}, "vary": {"scale.length": ("40 mm", "70 mm")}},
        beam=squama.Beam.from_ratios(mu=0.5),
        starts=64,
    )
    words = " ".join(Balanced(found._repr_html_()).text)
    assert f"scale.length {found[0].beam.scale.length * 1e3:.6g} mm" in words
    assert "lock 0.25 rad/pitch" in words
    loop = EXAMPLES / "measured_loop.csv"
    fit = squama.fit(loop, squama.Beam.from_toml(EXAMPLES / "pla_on_vps.toml"), joint="hinge")
    words = " ".join(Balanced(fit._repr_html_()).text)
    assert fit.lines[0].removeprefix("mu = ") in words
    for doubt in (*fit.doubts, *fit.notes):
        assert doubt in words
