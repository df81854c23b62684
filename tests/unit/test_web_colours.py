"""Colours of the explorer's page can be told apart and read, on a light and a dark ground."""

from __future__ import annotations

import re
from importlib.resources import files

from squama.plot.palette import DARK_ENDS, ENDED, ENDS, SOFTER, STATES, STEPS, THEMES
from squama.study import compliant_columns
from squama.web import map  # noqa: A004 - the module is named after what it draws


def test_colours_have_contrast() -> None:
    text = files("squama.web").joinpath("page.css").read_text(encoding="utf-8")
    # a mark has places of its own
    used = set(re.findall(r"var\(--(\w+)\)", text)) - {"start", "lead", "place"}
    assert used <= THEMES["light"].keys() == THEMES["dark"].keys()
    for end, colour in DARK_ENDS.items():
        assert contrast(colour, THEMES["dark"]["page"]) >= (1.5 if end == "no engagement" else 2.5), end
    assert len(set(DARK_ENDS.values())) == len(set(ENDS.values())) == len(ENDS)
    # ends of both models and of paths in bend and twist, and tiles that are not done
    assert set(ENDS) == {*map.CODES, *compliant_columns.ENDS, "kinematic lock (line contact)", "not computed"}
    for theme, colour in THEMES.items():
        # classes of a map that lie beside all others, and one that says less than these
        for own in (SOFTER, ENDED):
            assert contrast(own, colour["page"]) >= 2.5
            assert contrast(own, colour["faint"]) >= 1.8
        assert len({SOFTER, ENDED, *STEPS, colour["faint"], ENDS["not computed"]}) == len(STEPS) + 4
        for ground in ("page", "panel"):
            for name, least in (("ink", 7), ("soft", 4.5), ("bad", 4.5), ("accent", 3)):
                assert contrast(colour[name], colour[ground]) >= least, (theme, name, ground)
        for name in STATES.values():
            assert contrast(name, THEMES[theme]["edge"]) >= 1.5


def contrast(one: str, other: str) -> float:
    """Ratio of luminances as WCAG 2 has it."""

    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)
