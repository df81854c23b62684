"""The explorer's part under load: that of squama.load, bounded, and what is told of it."""

from __future__ import annotations

import re

import numpy as np
import pytest

import squama
from squama.errors import InputError
from squama.web import bench, state

SKIN = state.of(squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=6))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "support", "place", "most"),
    [("cantilever", "clamped", "tip", 1), ("three-point", "simple", "middle", 3)],
)
def test_a_part_is_that_of_the_package(case: str, support: str, place: str, most: int) -> None:
    way = "up" if case == "cantilever" else "down"
    found = bench.told(bench.followed(SKIN, case, "1.5 N", way), SKIN)
    data = squama.load(SKIN.beam, f"1.5 N {way} at {place}", support=support, mu=SKIN.mu, points=bench.POINTS)
    top = data.isel(point=int(data.share.values.argmax()))
    model, reached, borne = found.words[:3]
    assert model == "Part of 6 scales: thick, elastic scales on compliant joints"
    force, travel = (float(v) for v in re.search(r"([\d.]+) N at (-?[\d.]+) mm", reached).groups())
    assert force == pytest.approx(float(top.F), rel=6e-3)
    assert travel == pytest.approx(1e3 * float(top.travel), rel=6e-3)
    # at the root of a cantilever, in the middle of a bent part
    assert f"scale {most} of 6 bears most, " in borne
    assert float(borne.split()[-2]) == pytest.approx(float(top.N[most - 1]), rel=6e-3)
    assert float(top.N[most - 1]) > max(float(v) for i, v in enumerate(top.N) if i != most - 1 and np.isfinite(v))
    assert found.picture.startswith("<?xml")


def test_a_part_has_the_models_scales_and_says_which() -> None:
    thin = SKIN._replace(ideal="yes", bend=0.02, beam=SKIN.beam.replace(scales=4))
    data = bench.followed(thin, "cantilever", "0.3 N", "up")
    own = squama.load(thin.beam, "0.3 N up at tip", mu=thin.mu, points=bench.POINTS, ideal=True)
    thick = squama.load(thin.beam, "0.3 N up at tip", mu=thin.mu, points=bench.POINTS)
    assert np.array_equal(data.travel, own.travel)
    assert not np.allclose(own.travel, thick.travel, rtol=1e-3)
    words = "Part of 4 scales: thin, rigid scales on compliant joints; without the held bend"
    assert bench.told(data, thin).words[0] == words
    endless = SKIN._replace(beam=SKIN.beam.replace(scales=None))
    assert bench._model(endless).startswith("Part of 25 scales: ")
    assert bench._model(endless).endswith("cut from the endless beam that is shown")
    # another model is another part
    for other in (thin._replace(ideal="no"), thin.hinged, thin.change("mu", "0.4"), thin.change("bend", "0")):
        assert bench.follows(other) != bench.follows(thin)
    assert bench.follows(thin.change("twist", "0.01 rad/pitch")) == bench.follows(thin)


def test_a_part_whose_curve_stops_says_where_and_why() -> None:
    data = bench.followed(SKIN, "cantilever", "0.3 N", "up")
    # as if it had come to 0.25 N of 0.3 N, with no load on any scale
    last = int(data.share.values.argmax())
    short = data.isel(point=slice(last))
    share = float(short.share[-1])
    words = bench._words(short.assign(N=short.N * np.nan))
    reached = f"{float(short.F[-1]):.3g} N of {float(short.F[-1]) / share:.3g} N"
    assert f"The curve stops at {reached}: the range of the curve ends here; nothing locks before" in words
    assert f"{float(short.F[-1]) / share:.3g}" == "0.3"
    assert not any("nan" in line for line in words)
    # what comes to all of the force but for rounding does not stop
    assert not any("stops" in line for line in bench._words(data.assign(share=data.share * (1 - 1e-8))))


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
        bench.followed(SKIN, *given)
    assert len(error.value.problems) == 1


def test_long_parts_and_hinges_are_left_to_the_command() -> None:
    with pytest.raises(InputError, match="at most 25 scales"):
        bench.followed(SKIN.change("scales", "26"), "cantilever", "1 N", "up")
    with pytest.raises(InputError, match='joint = "hinge": is not known of a part; choose compliant'):
        bench.followed(SKIN.hinged, "cantilever", "1 N", "up")
