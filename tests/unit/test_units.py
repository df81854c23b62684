"""Units: every accepted spelling gives the right SI value, everything else a line that says what to write."""

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from squama.errors import InputError
from squama.people import apart_by
from squama.units import (
    Bounds,
    Dimension,
    as_text,
    bounded,
    change,
    curvature,
    is_number,
    moment,
    number,
    quantity,
    twist,
)

DEG = math.pi / 180


@pytest.mark.parametrize(
    ("text", "dimension", "si"),
    [
        ("60 mm", "length", 0.06),
        ("1e-3 m", "length", 1e-3),
        ("+2.5cm", "length", 0.025),
        (".5 um", "length", 5e-7),
        ("5 µm", "length", 5e-6),
        ("2 inch", "length", 0.0508),
        ("45 deg", "angle", 45 * DEG),
        ("45deg", "angle", 45 * DEG),
        ("45°", "angle", 45 * DEG),
        ("0.2 rad", "angle", 0.2),
        ("0.25 turn", "angle", math.pi / 2),
        ("25 GPa", "pressure", 25e9),
        ("1.5 MPa", "pressure", 1.5e6),
        ("3 N/mm^2", "pressure", 3e6),
        ("10 psi", "pressure", 68947.57293168361),
        ("2 N m", "torque", 2),
        ("2 N*m", "torque", 2),
        ("2 Nm", "torque", 2),
        ("2 N m/rad", "torque", 2),
        ("2 N mm", "torque", 2e-3),
        ("2 N mm/deg", "torque", 2e-3 / DEG),
        ("2 mN*m/deg", "torque", 2e-3 / DEG),
        ("0.2 rad/m", "twist rate", 0.2),
        ("0.3 deg/mm", "twist rate", 300 * DEG),
        ("0.3 deg / cm", "twist rate", 30 * DEG),
        ("0.3 deg per cm", "twist rate", 30 * DEG),
        ("4 1/m", "twist rate", 4),
        ("4 m**-1", "twist rate", 4),
        ("4 m⁻¹", "twist rate", 4),
        ("4 N/(mm^2)", "pressure", 4e6),
        ("4 kg*m**2/s**2", "torque", 4),
        ("4 cmH2O", "pressure", 392.266),
        ("0.25", "ratio", 0.25),
        ("25 %", "ratio", 0.25),
    ],
)
def test_text_is_read(text, dimension, si):
    assert quantity(text, dimension, bare=False) == pytest.approx(si, rel=1e-13)


@pytest.mark.parametrize(
    ("value", "dimension", "words"),
    [
        ("12 deg", "length", '"12 deg" is an angle, but a length is needed; write e.g. "12 mm"'),
        ("12 mm", "angle", '"12 mm" is a length, but an angle is needed; write e.g. "12 deg"'),
        ("12 inch", "angle", '"12 inch" is a length, but an angle is needed; write e.g. "12 deg"'),
        ("3 cd", "length", 'is not a length: "cd" is not known as a unit of one; write e.g. "12 mm"'),
        ("3 blah", "pressure", '"blah" is not known as a unit'),
        ("3 /", "length", "is not known as a unit"),
        ("1 m**999999999", "length", "is not known as a unit"),
        ("1 9**9**9 m", "length", '"9**9**9 m" is not known as a unit'),
        ("1 m**9**9**9", "length", "is not known as a unit"),
        ("1 m²²²²²²²²²", "length", "is not known as a unit"),
        ("1 m**10", "length", "is not known as a unit"),
        ("1 (9**9)**9 m", "length", "is not known as a unit"),
        ("1 m.__class__", "length", "is not known as a unit"),
        ("1" * 200 + " mm", "length", "is longer than 100 characters"),
        pytest.param("1" + " " * 500_000 + "x", "length", "is longer than 100 characters", id="500,000 blanks"),
        ("45", "angle", '"45" has no unit; write "45 deg"'),
        ("12,5 mm", "length", 'has a decimal comma; write "12.5 mm"'),
        ("nan mm", "length", "is not a length"),
        ("inf", "ratio", "is not a plain number"),
        ("1e999 m", "length", "is not a finite number"),
        ("", "length", "is not a length"),
        (45, "angle", '45 has no unit; write "45 deg"'),
        (32, "length", '32 has no unit; write "32 mm"'),
        (0.032, "length", '0.032 has no unit; write "0.032 mm" or "0.032 m"'),
        (1.5e6, "pressure", '"1500000 Pa"'),
        (2, "torque", '2 has no unit; write "2 N m"'),
        (math.nan, "angle", "nan is not a finite number"),
        (math.inf, "ratio", "inf is not a finite number"),
        (10**400, "ratio", "is not a finite number"),
        (True, "ratio", "true is no number, but a plain number is needed"),
        (None, "length", "is nothing, but a length is needed"),
        pytest.param(-(10**5000), "ratio", "is not a finite number", id="5000 digits"),
        pytest.param([10**5000], "length", "huge numbers is a list", id="list of 5000 digits"),
        ([1], "length", "[1] is a list, but a length is needed"),
    ],
)
def test_bad_values_are_refused_in_one_line(value, dimension, words):
    with pytest.raises(InputError) as caught:
        quantity(value, dimension, bare=False)
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("value", [0.3, np.float64(0.3), np.float32(0.5), 2, np.int64(2)])
def test_bare_numbers_are_si_in_python(value):
    assert quantity(value, "length") == float(value)


def test_bare_angle_out_of_range_gets_the_hint():
    quarter = Bounds(0, math.pi / 2, "0 to 90 deg, exclusive")
    with pytest.raises(InputError) as caught:
        bounded(45, "angle", quarter)
    assert str(caught.value) == '45 rad is out of range (0 to 90 deg, exclusive); write "45 deg"'
    # 1000 would not fit in degrees either, so its own number is no remedy
    with pytest.raises(InputError, match="1000 rad is out of range") as caught:
        bounded(1000, "angle", quarter)
    assert "1000 deg" not in str(caught.value)
    assert bounded(1.5, "angle", quarter) == 1.5


@pytest.mark.parametrize(
    ("value", "rate"),
    [
        ("5 rad/m", 5),
        ("0.3 deg/mm", 300 * DEG),
        ("0.2 rad/pitch", 10),
        ("0.2 rad per pitch", 10),
        ("12 deg / pitch", 12 * DEG / 0.02),
        ("0.2 1/pitch", 10),
        ("90 deg total", math.pi),
        ("1.5 rad total", 3),
        ("-1.5 rad total", -3),
        ("2 1/m", 2),
    ],
)
def test_twist_and_curvature(value, rate):
    for read in (twist, curvature):
        assert read(value, pitch=0.02, scales=25, bare=False) == pytest.approx(rate, rel=1e-13)


def test_bare_twist():
    assert twist(3, pitch=0.02, scales=25) == 3
    with pytest.raises(InputError, match=r'3 has no unit; write "3 rad/m", "3 rad/pitch" or "3 rad total"'):
        twist(3, pitch=0.02, scales=25, bare=False)


@pytest.mark.parametrize("value", ["90 deg", "1.5 rad", "5"])
def test_an_angle_without_its_length_is_refused(value):
    with pytest.raises(InputError) as caught:
        twist(value, pitch=0.02, scales=25)
    for way in ("/m", "/pitch", "total", "25 scales"):
        assert way in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    "value", ["12 mm", "12 mm total", "total", True, math.nan, "1" + " " * 9000 + "x", "1 9**9**9 rad/pitch"]
)
def test_what_is_no_twist_is_refused(value):
    with pytest.raises(InputError):
        twist(value, pitch=0.02, scales=25)


@given(
    st.floats(1e-9, 1e9),
    st.sampled_from([Dimension.LENGTH, Dimension.ANGLE, Dimension.PRESSURE, Dimension.TORQUE, Dimension.RATIO]),
)
def test_text_reads_back_to_the_same_float(value, dimension):
    assert quantity(as_text(value, dimension), dimension, bare=False) == value


def test_text_is_short_where_it_can_be():
    assert as_text(quantity("17.3 mm", "length"), "length") == "17.3 mm"
    assert as_text(quantity("10 deg", "angle"), "angle") == "10 deg"


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.05, "50 N mm"), (-0.05, "-50 N mm"), (0.1, "0.1 N m"), (-12.34567, "-12.3 N m"), (0.0, "0 N m")],
)
def test_torques_for_people(value, text):
    assert moment(value) == text


@pytest.mark.parametrize(("text", "yes"), [("3", True), (" -1e-3 ", True), ("3 mm", False), ("", False)])
def test_numbers_without_a_unit(text, yes):
    assert is_number(text) == yes


def test_pint_is_imported_only_when_needed():
    code = (
        "import sys, squama.beam.design as d; from squama.units import quantity; beam = d.Beam.from_ratios();"
        "slow = {'pint', 'scipy', 'numpy', 'matplotlib'};"
        "assert quantity('3 N mm/deg', 'torque') and not slow & set(sys.modules);"
        "assert beam.warnings() and not slow - {'numpy'} & set(sys.modules);"
        "quantity('1 inch', 'length'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_change_is_told_in_per_cent_or_as_a_factor():
    assert [change(x) for x in (0.123, -0.05, 1783.316)] == ["12 %", "-5 %", "a factor of 1780"]
    assert change(0.123, "+") == "+12 %"


def test_numbers_for_people_have_three_digits_and_no_exponent_up_to_a_million():
    told = [number(x, "N") for x in (1039.2, 99_949.0, -12_345.6, 0.00012345)]
    assert told == ["1040 N", "99900 N", "-12300 N", "0.000123 N"]
    assert [number(x, "%", "+") for x in (1234.5, 0.21, -3.0)] == ["+1230 %", "+0.21 %", "-3 %"]
    assert (number(math.inf), number(math.nan)) == ("never", "-")


def test_how_far_a_figure_is_off_is_told_in_per_cent_or_as_a_multiple():
    assert [apart_by(x) for x in (-0.0213, 0.5, 1039.2)] == ["-2.13 %", "+50 %", "1040 times"]
