"""Flags as values: what is read, what is refused, and that nothing is lost of several mistakes."""

from pathlib import Path

import pytest
from refusals import refused

from squama.cli import flags
from squama.errors import InputError, refuse


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """No other test writes where files are compared."""
    monkeypatch.chdir(tmp_path)


def _said(read, text):
    with pytest.raises(InputError) as caught:
        read.read("--x", text)
    return str(caught.value)


def test_numbers_keep_their_bounds():
    read = flags.number(0, 10, "0.25")
    assert (read.read("--x", "0"), read.read("--x", "10"), read.read("--x", "2.5e-1")) == (0.0, 10.0, 0.25)
    assert _said(read, "10.5") == '--x = "10.5": is out of range (0 to 10); write e.g. 0.25'
    assert _said(read, "1 mm").startswith('--x = "1 mm": is a length')


def test_whole_numbers():
    read = flags.whole(3, 100_000, "200")
    value = read.read("--x", "2e2")
    assert (value, type(value)) == (200, int)
    assert _said(read, "2.5") == "--x = 2.5: is not a whole number; allowed: 3 to 100000; write e.g. 200"
    assert _said(read, "2") == '--x = "2": is out of range (3 to 100000); write e.g. 200'
    assert "finite" in _said(read, "1e999")


def test_words_and_pairs():
    assert flags.one_of("edge", "plate").read("--x", "plate") == "plate"
    assert _said(flags.one_of("edge", "plate"), "both") == '--x = "both": must be "edge" or "plate"'
    read = flags.pair("name=value", "eta=3")
    assert read.read("--x", ' alpha = "30 deg" ') == ("alpha", "30 deg")
    for text in ("alpha", "alpha=", "=3", 'alpha=""'):
        assert "is not name=value; write e.g. eta=3" in _said(read, text)


@pytest.fixture
def command_line():
    with flags.collecting():
        yield flags.problems()


def test_names_given_twice_are_kept_as_mistakes(command_line):
    given = [flags.Pair("alpha", "1"), flags.Pair("scale.alpha", "2"), flags.Pair("mu", "3")]
    assert flags.once("--over", given) == {"alpha": "1", "scale.alpha": "2", "mu": "3"}
    assert not command_line
    assert flags.once("--over", given, {"alpha": "scale.alpha"}) == {"alpha": "1", "mu": "3"}
    assert [str(p) for p in command_line] == ["--over scale.alpha: is given twice; keep one of them"]


def test_mistakes_are_laid_to_flags():
    names = {"scale.alpha": "--set scale.alpha", "twist": "--to"}
    for where, said in (("scale.alpha", "--set scale.alpha"), ("twist[2]", "--to[2]"), ("twisted", "twisted")):
        with pytest.raises(InputError) as caught, flags.laid(names):
            refuse(where, "3", "is wrong", source="beam.toml" if where == "twisted" else "")
        assert caught.value.problems[0].where == said


def test_all_mistakes_are_told_at_once(command_line):
    with flags.problems().caught():
        refuse("--a", "", "is wrong")
    command_line.add("--b", "1", "is wrong, too")
    with pytest.raises(InputError) as caught:
        flags.settled(None)
    assert str(caught.value).splitlines() == ["--a: is wrong", "--b = 1: is wrong, too"]


def test_command_lines_do_not_share_mistakes(command_line):
    command_line.add("--a", "", "is wrong")
    with flags.collecting():
        assert not flags.problems()
    assert flags.problems() is command_line


EXAMPLE = str(Path(__file__).parents[2] / "examples" / "stiff_skin.toml")
ALPHA = ["--set", 'scale.alpha="40 deg"', "--set", 'scale.alpha="30 deg"']
TABLE = "says how --data is read; give --data too, e.g. --data test.csv, or leave it out"


@pytest.mark.parametrize("command", ["twist", "bend", "vibrate", "joint"])
def test_a_value_set_twice_is_refused_by_its_name(command, capsys):
    refused([command, EXAMPLE, *ALPHA], [["--set scale.alpha: is given twice"]], capsys)


def test_a_value_set_twice_is_refused_in_a_target_and_by_mu(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with flags.collecting(), pytest.raises(InputError, match=r"--set scale\.alpha: is given twice"):
        flags.Base(set_=(flags.Setting("scale.alpha", 1), flags.Setting("scale.alpha", 1))).overrides()
    said = "--set friction.mu: is given twice, or by a flag of its own, too; keep one of them"
    refused(["cycle", EXAMPLE, "--to", "0.1 rad/pitch", "--mu", "0.2", "--set", "friction.mu=0.3"], [[said]], capsys)


def test_how_a_table_is_read_without_a_table_is_refused(capsys):
    for command in ("twist", "bend"):
        given = ["--decimal", ",", "--columns", "2=T (N m)"]
        lines = [['--decimal = ","', TABLE], ['--columns = "2=T (N m)"', TABLE]]
        refused([command, EXAMPLE, *given], lines, capsys)
