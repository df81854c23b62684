"""Warnings of results by Python's warnings: once for a call, at its line, silent inside and in the command line."""

from __future__ import annotations

import inspect
import pickle
import warnings

import pytest

import squama
from squama.cli import main
from squama.curves import doors

THICK = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
HINGE = {"joint": "hinge", "points": 3}


def _heard(run):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        result = run()
    return result, found


def test_each_line_is_told_once_where_the_call_stands():
    for call in (lambda: squama.twist(THICK, **HINGE), lambda: squama.bend(THICK, **HINGE)):
        r, found = _heard(call)
        assert [str(one.message) for one in found] == r.attrs["warnings"].splitlines() != []
        assert {(one.category, one.filename) for one in found} == {(squama.ResultWarning, __file__)}
        assert {one.lineno for one in found} == {inspect.getsourcelines(call)[1]}
    assert issubclass(squama.ResultWarning, squama.SquamaWarning)


def test_a_result_within_its_range_is_silent():
    thin = THICK.replace(scale={"thickness": "0.05 mm", "embedded": 0}, joint={"stiffness": "0.02 N m"})
    r, found = _heard(lambda: squama.twist(thin, **HINGE))
    assert (r.attrs["warnings"], found) == ("", [])


def test_what_is_called_inside_is_silent():
    _, found = _heard(lambda: doors.twist(THICK, **HINGE))
    assert found == []
    swept, found = _heard(lambda: squama.sweep(THICK, {"mu": [0.1, 0.2]}, joint="hinge"))
    assert [str(one.message) for one in found] == [*dict.fromkeys(swept.attrs["warnings"].splitlines())]


def test_a_filter_makes_errors_of_them():
    with warnings.catch_warnings():
        warnings.simplefilter("error", squama.ResultWarning)
        with pytest.raises(squama.ResultWarning, match="the scales are not thin"):
            squama.twist(THICK, **HINGE)


def test_the_command_line_says_each_once(capsys, tmp_path):
    THICK.to_toml(tmp_path / "beam.toml")
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert main(["twist", str(tmp_path / "beam.toml"), "--joint", "hinge", "--points", "3"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    for line in doors.twist(THICK, **HINGE).attrs["warnings"].splitlines():
        assert out.count(line) == 1


def test_public_functions_go_to_other_processes():
    assert pickle.loads(pickle.dumps(squama.twist)) is squama.twist
    assert list(inspect.signature(squama.twist).parameters)[:2] == ["beam", "mu"]
