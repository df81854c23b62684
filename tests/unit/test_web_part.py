"""The explorer's part under load: that of squama.load, bounded, and what is told of it."""

from __future__ import annotations

import re

import pytest

import squama
from squama.errors import InputError
from squama.web import bench, state

SKIN = state.of(squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=6))


@pytest.mark.parametrize(
    ("case", "support", "place"), [("cantilever", "clamped", "tip"), ("three-point", "simple", "middle")]
)
def test_a_part_is_that_of_the_package(case: str, support: str, place: str) -> None:
    found = bench.loaded(SKIN, case, "1.5 N", "up" if case == "cantilever" else "down")
    way = "up" if case == "cantilever" else "down"
    data = squama.load(SKIN.beam, f"1.5 N {way} at {place}", support=support, mu=SKIN.mu, points=bench.POINTS)
    top = data.isel(point=int(data.share.values.argmax()))
    force, travel = (float(v) for v in re.search(r"([\d.]+) N at (-?[\d.]+) mm", found.words[0]).groups())
    assert force == pytest.approx(float(top.F), rel=6e-3)
    assert travel == pytest.approx(1e3 * float(top.travel), rel=6e-3)
    if float(top.N.max()):
        assert f"scale {int(top.N.values.argmax()) + 1} of 6 bears most" in found.words[1]
    assert found.picture.startswith("<?xml")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (("cantilever", "rough", "up"), "force"),
        (("cantilever", "2", "up"), "has no unit"),
        (("cantilever", "2 mm", "up"), "force"),
        (("cantilever", "-1 N", "up"), "must be more than 0"),
        (("cantilever", "9" * 400, "up"), "force"),
        (("beam", "1 N", "up"), "case"),
        (("cantilever", "1 N", "at tip; 9 N up"), "direction"),
    ],
)
def test_what_cannot_be_loaded_is_one_line(given: tuple[str, str, str], words: str) -> None:
    with pytest.raises(InputError, match=words) as error:
        bench.loaded(SKIN, *given)
    assert len(error.value.problems) == 1


def test_long_parts_are_left_to_the_command() -> None:
    with pytest.raises(InputError, match="at most 60 scales"):
        bench.loaded(SKIN.change("scales", "61"), "cantilever", "1 N", "up")
