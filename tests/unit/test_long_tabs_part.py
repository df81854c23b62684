"""examples/long_tabs.toml: a public part whose embedded parts are longer than the pitch, on two rollers."""

from pathlib import Path

import numpy as np
import pytest

import squama
from squama.beam import matrixfile

EXAMPLE = Path("examples/long_tabs.toml")


@pytest.fixture(scope="module")
def part():
    return squama.Part.from_toml(EXAMPLE)


def test_before_contact_it_is_a_bar_in_three_point_bending(part):
    """P = 48 E I u / L^3 of the bare bar, 50.2 N/m, times what the joint's matrix gives for bend with all else free."""
    beam, span = part.beam, 0.18
    bare = 48 * beam.substrate.youngs_modulus * beam.substrate.width * beam.substrate.thickness**3 / 12 / span**3
    assert bare == pytest.approx(50.2, abs=0.05)
    K = beam.joint.matrix.K
    moment = 2.5 * 1.25**3 / 12
    stiffer = 1 / (np.linalg.inv(K)[7, 7] * moment)
    r = squama.load(part, "0.2 mm down at middle", points=3)
    # tolerance: 18 cells in place of a continuous bar
    assert float(r.F[-1]) / 0.2e-3 == pytest.approx(stiffer * bare, rel=0.02)


@pytest.mark.slow
def test_figures(part):
    r = squama.load(part)
    assert "embedded" not in r.attrs["warnings"]
    assert str(r.end.values) == "range end"
    assert float(r.share_e) * 30 == pytest.approx(4.1, rel=0.05)
    # tolerance: none of physics; to be told where the answer changes
    assert float(r.F[-1]) == pytest.approx(12.5, rel=0.1)
    assert float(r.F[20]) == pytest.approx(4.08, rel=0.1)


def test_the_matrix_says_whose_tab_bends(part):
    made = part.beam.joint.matrix.made
    assert made["scale.youngs_modulus"] == 2.8e9
    stiffer = part.beam.replace(scale={"youngs_modulus": "5.6 GPa"})
    assert any("scale.youngs_modulus = 2.8 GPa, not 5.6 GPa" in line for line in stiffer.warnings())
    # moduli count in units of the bar's
    both = stiffer.replace(substrate={"youngs_modulus": "3 MPa"})
    assert not part.beam.joint.matrix.differences(matrixfile.made_for(both))
    assert part.beam.joint.matrix == matrixfile.parse(part.beam.joint.matrix.text)
