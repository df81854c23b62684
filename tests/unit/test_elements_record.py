"""JSON of `squama cell`: no elements are needed to say what they found."""

import numpy as np
import xarray as xr

import squama
from squama.cli.elements import _record


def test_a_key_means_what_it_means_in_other_commands():
    beam = squama.Beam.from_ratios(mu=0.5, scales=3)
    data = xr.Dataset(
        {"phi": ("point", np.array([0.1, 0.2])), "N": (("point", "scale"), np.ones((2, 3)))},
        attrs={"load": "twisting", "ends": "held", "warnings": "one\ntwo", "beam": beam.to_toml()},
    ).assign_coords(mu=((), 0.5))
    found = _record(data)
    # "ends" is how they are loaded
    assert "ends" not in found
    assert (found["axial"], found["load"], found["warnings"]) == ("held", "twisting", ["one", "two"])
    assert found["beam"] == beam.model_dump()
    assert [*found["curve"]] == ["phi"]
    assert np.shape(found["each"]["N"]) == (2, 3)
