"""Pressure in a chamber of a part: a thrust on its section; what is refused."""

import numpy as np
import pytest

import squama
from squama.errors import InputError

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")


def test_a_pressure_is_a_thrust_on_the_section_of_its_chamber():
    loads = "20 kPa pressure on 10 mm x 4 mm at -2 mm", "0.8 N thrust at -2 mm"
    chamber, thrust = (squama.load(SKIN, load, scales=4, points=5) for load in loads)
    np.testing.assert_allclose(chamber["F"], thrust["F"], rtol=1e-12)
    assert float(chamber["F"][-1]) == pytest.approx(0.8)
    # below the middle it bends the part towards its scales
    assert float(chamber["y_axis"][-1, -1] - chamber["y_axis"][0, -1]) > 0


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ("20 kPa pressure", "has no section of a chamber"),
        ("20 kPa pressure on 40 mm2", "has no section of a chamber"),
        ("20 kPa pressure on 50 mm x 4 mm", "is not inside the bar of 28 mm x 14 mm"),
        ("3 N pressure on 10 mm x 4 mm", "is a force"),
        ("-3 kPa pressure on 10 mm x 4 mm", "must be above 0"),
        ("3 N tendon on 10 mm x 4 mm", "as only a pressure has"),
    ],
)
def test_what_is_refused(load, words):
    with pytest.raises(InputError, match=words):
        squama.load(SKIN, load, scales=5)
