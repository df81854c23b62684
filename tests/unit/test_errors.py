"""Errors as values: their text, and how a place and a source are put before what they name."""

import pickle

import pytest

from squama import arguments, units
from squama.errors import InputError, Problem, Problems, naming, refuse


@pytest.mark.parametrize(
    ("problem", "line"),
    [
        (Problem("mu", "-1", "must be 0 or more", "write e.g. 0.25"), "mu = -1: must be 0 or more; write e.g. 0.25"),
        (Problem("mu", "", "is not given", "pass mu=0.3"), "mu: is not given; pass mu=0.3"),
        (Problem("", '"12 deg"', "is an angle"), '"12 deg" is an angle'),
        (Problem(reason="nothing moves"), "nothing moves"),
        (Problem("mu", "3", "is too much", "", "a.toml"), "a.toml: mu = 3: is too much"),
        (Problem("", "3", "is too much", "", "a.csv: line 3"), "a.csv: line 3: 3 is too much"),
        (Problem("", "", "is empty", "", "a.csv"), "a.csv: is empty"),
    ],
)
def test_a_problem_is_one_line_of_what_is_known(problem, line):
    assert str(problem) == line
    assert str(InputError(problem)) == line


def test_text_is_a_reason_and_each_line_one():
    error = InputError("one\ntwo", Problem("mu", "3", "is too much"))
    assert error.problems == (Problem(reason="one"), Problem(reason="two"), Problem("mu", "3", "is too much"))
    assert str(error).splitlines() == ["one", "two", "mu = 3: is too much"]
    assert isinstance(error, ValueError)


def test_an_error_travels_between_processes():
    error = InputError(Problem("mu", "3", "is too much", source="a.toml"))
    assert pickle.loads(pickle.dumps(error)).problems == error.problems


def test_a_place_and_a_source_stand_before_those_inside():
    inner = Problem("", "3", "is too much")
    assert str(inner.at("mu")) == "mu = 3: is too much"
    assert str(inner.at("mu").at("design 17", "beams.csv")) == "beams.csv: design 17: mu = 3: is too much"
    # a file that a key names is part of the place, so that the key keeps its own file
    matrix = inner.at(source="joint.csv: line 3").at("joint.matrix").at(source="beam.toml")
    assert matrix == Problem("joint.matrix: joint.csv: line 3", "3", "is too much", "", "beam.toml")


@pytest.mark.parametrize(
    ("where", "names", "want"),
    [
        ("mu", {"mu": "--mu"}, "--mu"),
        ("mus", {"mu": "--mu"}, "mus"),
        ("mu", {"friction.mu": "--mu"}, "mu"),
        ("scale.alpha", {"scale.alpha": "--set scale.alpha"}, "--set scale.alpha"),
        ("scale.alpha", {"scale": "--scale"}, "--scale.alpha"),
        ("at[3]", {"at": "--at"}, "--at[3]"),
        ("bounds: mu", {"bounds": "--bounds"}, "--bounds: mu"),
        ("bounds: mu", {"bounds: ": "--bounds "}, "--bounds mu"),
        ("design 17: mu", {"mu": "--mu"}, "design 17: --mu"),
        ("to", {"t": "--t", "to": "--to"}, "--to"),
        ("scale.length", {"scale.len": "--len"}, "scale.length"),
        ("over.mu", {"over.": "--over "}, "--over mu"),
        ("joint.matrix: j.csv", {"joint": "J", "joint.matrix": "--set joint.matrix"}, "--set joint.matrix: j.csv"),
    ],
)
def test_a_place_is_laid_to_a_flag(where, names, want):
    assert Problem(where, "1", "is wrong").renamed(names).where == want


def test_what_is_laid_to_a_flag_stands_in_no_file_any_more():
    error = InputError(Problem("mu", "3", "is too much", source="a.toml"), Problem("eta", "3", "is odd", "", "a.toml"))
    assert str(error.renamed({"mu": "--mu"})).splitlines() == ["--mu = 3: is too much", "a.toml: eta = 3: is odd"]


def test_a_quantity_gets_its_place_from_who_reads_it():
    with pytest.raises(InputError) as raised, naming("to", "flags"):
        units.quantity("12 deg", "length")
    assert raised.value.problems == (
        Problem("to", '"12 deg"', "is an angle, but a length is needed", 'write e.g. "12 mm"', "flags"),
    )


def test_mistakes_are_collected_and_told_once_each():
    problems = Problems()
    with problems.caught("bounds"):
        arguments.positive("mu", [1, -1, -2])
    for _ in range(2):
        with problems.caught():
            refuse("eta", "0", "must be above 0")
    problems.add("law", "x", "is not known")
    with pytest.raises(InputError) as raised:
        problems.settle("a.toml")
    assert str(raised.value).splitlines() == [
        "a.toml: bounds: mu = -1 (and 1 more): must be above 0; write e.g. 0.25",
        "a.toml: eta = 0: must be above 0",
        "a.toml: law = x: is not known",
    ]
    Problems().settle()


def test_friction_is_the_given_one_or_that_of_the_beam():
    assert arguments.friction(0.2, None) == 0.2
    assert arguments.friction(0.2, 0) == 0
    assert arguments.frictions(None, [0, 0.5]).tolist() == [0, 0.5]
    with pytest.raises(InputError, match=r"^mu: is not given; sweep it, or write mu under \[friction\]"):
        arguments.friction(None, None, "sweep it")
    with pytest.raises(InputError, match=r"^mu: must be one number, not an array of shape \(2,\)"):
        arguments.friction(None, [0, 0.5])
    with pytest.raises(InputError, match=r"^mu: must be one number or a sequence"):
        arguments.frictions(None, [])


@pytest.mark.parametrize("margin", [0, 1, 1e-13, float("nan"), "x"])
def test_margins_are_refused_at_their_ends(margin):
    with pytest.raises(InputError, match=r"^margin = "):
        arguments.margin(margin)
