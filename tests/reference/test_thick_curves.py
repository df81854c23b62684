"""The model of compliant joints against curves of an independent derivation: thin or thick, rigid or elastic scales."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from squama.contacts import increments
from squama.contacts.path import Path as Way
from squama.contacts.path import Scale

CASES = json.loads((Path(__file__).parent / "thick_scales.json").read_text())
CASES = CASES if isinstance(CASES, list) else next(v for v in CASES.values() if isinstance(v, list))
VARIANTS = ("thin_rigid", "thick_rigid", "thin_elastic", "thick_elastic")


def way(case: dict, variant: str, mu: float | None = None) -> Way:
    h = case["thickness"] if "thick" in variant else 0.0
    D = case["plate_D"] if "elastic" in variant else math.inf
    angles = (math.radians(case[name]) for name in ("alpha_deg", "theta0_deg"))
    scale = Scale(case["eta"], case["beta"], case["lam"], *angles, h, D, case["plate_nu"])
    return Way.of(scale, np.array(case["K"]), case["mu"] if mu is None else mu)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("i", range(len(CASES)))
def test_curves(i: int, variant: str) -> None:
    curve = CASES[i]["curves"][variant]
    one = way(CASES[i], variant)
    assert one.contact.phi == pytest.approx(curve["phi_e"], rel=1e-12)
    rows = np.array(curve["rows"])
    states, end = one.states(rows[:, 0])
    assert end.code == increments.RANGE
    # tolerance: the plates of the reference are some thousandths stiffer, 20 modes against 24, and steps are others
    T, N, place = (1.5e-3, 4e-3, 2e-4) if "elastic" in variant else (1e-4, 2e-4, 2e-4)
    np.testing.assert_allclose(states[:, 1], rows[:, 1], rtol=T)
    np.testing.assert_allclose(states[:, 2], rows[:, 2], rtol=N)
    np.testing.assert_allclose(states[:, 4:6], rows[:, 3:5], rtol=place)
