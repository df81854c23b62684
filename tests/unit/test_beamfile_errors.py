"""Every class of bad beam file, and of bad place for a file: one line per mistake, with its remedy."""

import errno
import os
import stat

import pytest

from squama.beam.design import Beam, Scale
from squama.errors import InputError
from squama.io.files import atomic_write, read_text

GOOD = """\
[scale]
length = "60 mm"
embedded = "7 mm"
width = "30 mm"
thickness = "0.2 mm"
alpha = "45 deg"
theta0 = "10 deg"

[substrate]
width = "32 mm"
thickness = "16 mm"
youngs_modulus = "1.5 MPa"
poisson_ratio = 0.49

[beam]
pitch = "20 mm"
scales = 25

[joint]
stiffness = "0.02 N m"
inclusion_factor = 1.4

[friction]
mu = 0.25
"""


def _complaints(text, tmp_path, name="beam.toml"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as caught:
        Beam.from_toml(path)
    text = str(caught.value)
    assert "pydantic" not in text
    assert "For further information" not in text
    lines = text.splitlines()
    assert all(line.startswith(f"{path}: ") for line in lines)
    return [line.removeprefix(f"{path}: ") for line in lines]


def test_the_good_file_is_good():
    assert Beam.from_toml_text(GOOD).friction.mu == 0.25


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        # bare numbers and wrong dimensions
        ('"45 deg"', "45", ["scale.alpha = 45: has no unit", 'write "45 deg"']),
        ('"45 deg"', '"45"', ['scale.alpha = "45": has no unit', 'write "45 deg"']),
        ('"60 mm"', "60", ["scale.length = 60: has no unit", 'write "60 mm"']),
        ('"0.02 N m"', "0.02", ["joint.stiffness = 0.02: has no unit", 'write "0.02 N m"']),
        ('"60 mm"', '"12 deg"', ['scale.length = "12 deg": is an angle', "a length is needed", '"12 mm"']),
        ('"45 deg"', '"45 mm"', ["scale.alpha", "is a length, but an angle is needed"]),
        ('"1.5 MPa"', '"1.5 m"', ["youngs_modulus", "is a length, but a pressure is needed", "MPa"]),
        ('"20 mm"', '"20 elephants"', ['beam.pitch = "20 elephants"', "is not known as a unit", "mm"]),
        ("0.25", '"0.25 mm"', ["friction.mu", "is a length, but a plain number is needed"]),
        # wrong types
        ('"60 mm"', "true", ["scale.length = true", "is no number", "write e.g."]),
        ('"60 mm"', '["60 mm"]', ["scale.length", "is a list", "write e.g."]),
        ('"60 mm"', "{a = 1}", ["scale.length", "is a table", "write e.g."]),
        ('"60 mm"', "2020-01-01", ["scale.length", "is a date", "write e.g."]),
        ('"60 mm"', '"long"', ['scale.length = "long"', "is not a length", "write e.g."]),
        ('"60 mm"', '"60,5 mm"', ["decimal comma", 'write "60.5 mm"']),
        ("0.25", "true", ["friction.mu = true", "a plain number is needed"]),
        # negative, zero, NaN, infinite, absurd
        ('"60 mm"', '"-60 mm"', ['scale.length = "-60 mm"', "out of range (more than 0", "write e.g."]),
        ('"60 mm"', '"0 mm"', ['scale.length = "0 mm"', "more than 0"]),
        ('"7 mm"', '"-7 mm"', ["scale.embedded", "0 or more"]),
        ('"60 mm"', '"1e-320 m"', ["scale.length", "out of range"]),
        ('"1.5 MPa"', '"0 MPa"', ["youngs_modulus", "more than 0"]),
        ('"0.02 N m"', '"-1 N m"', ["joint.stiffness", "more than 0"]),
        ("1.4", "0", ["joint.inclusion_factor = 0", "more than 0"]),
        ("0.25", "-0.1", ["friction.mu = -0.1", "0 to 10"]),
        ("0.25", "11", ["friction.mu = 11", "0 to 10"]),
        ("0.25", "nan", ["friction.mu = nan", "not a finite number", "write e.g. 0.25"]),
        ("0.25", "inf", ["friction.mu = inf", "not a finite number"]),
        ('"60 mm"', "nan", ["scale.length = nan", "not a finite number"]),
        ('"60 mm"', '"nan mm"', ['scale.length = "nan mm"', "is not a length"]),
        ('"60 mm"', '"1e999 mm"', ["scale.length", "not a finite number"]),
        # ranges
        ("0.49", "0.5", ["substrate.poisson_ratio = 0.5", "-1 to 0.5, exclusive"]),
        ("0.49", "-1", ["substrate.poisson_ratio = -1", "-1 to 0.5, exclusive"]),
        ('"45 deg"', '"-1 deg"', ["scale.alpha", "0 or more, below 90 deg"]),
        ('"45 deg"', '"90 deg"', ["scale.alpha", "0 or more, below 90 deg"]),
        ('"10 deg"', '"-1 deg"', ["scale.theta0", "0 to 90 deg, exclusive"]),
        ('"10 deg"', '"1.6 rad"', ["scale.theta0", "0 to 90 deg, exclusive"]),
        ("= 25", "= 1", ["beam.scales = 1", "whole number", "write e.g. 25"]),
        ("= 25", "= 25.0", ["beam.scales = 25.0", "whole number"]),
        ("= 25", '= "25"', ['beam.scales = "25"', "whole number"]),
        ("= 25", "= true", ["beam.scales = true", "whole number"]),
        ("= 25", '= 25\nfaces = "both"', ['beam.faces = "both"', 'write "mirrored" (as armour) or "turned"']),
        ("= 25", "= 25\nfaces = 2", ["beam.faces = 2", '"turned, shifted"']),
        ('"7 mm"', '"99 mm"', ["scale.embedded = 99 mm", "goes through the substrate", "write less than"]),
        # keys and tables
        (
            "length",
            "lenght",
            ["scale.lenght: unknown key", "did you mean length?", "allowed: length, embedded"],
        ),
        ("pitch", "pich", ["beam.pich: unknown key", "did you mean pitch?", "allowed: pitch, scales"]),
        ("mu =", "mue =", ["friction.mue: unknown key", "did you mean mu?"]),
        ("[friction]\n", "", ["joint.mu: unknown key", "it belongs in [friction]"]),
        (
            "[friction]",
            "[frction]",
            ["[frction]: unknown table", "did you mean [friction]?", "allowed: scale"],
        ),
        ("[substrate]", "[substate]", ["[substate]: unknown table", "did you mean [substrate]?"]),
        ("[scale]", "[stuff]\n[scale]", ["[stuff]: unknown table", "allowed: scale, substrate"]),
        ("[scale]", 'theta = "3 deg"\n[scale]', ['theta = "3 deg": stands outside the tables']),
        ("[scale]", 'mu = "3"\n[scale]', ["stands outside the tables", "put it under [friction]"]),
        ('length = "60 mm"\n', "", ["scale.length: is missing", 'write length = "60 mm" under [scale]']),
        ('pitch = "20 mm"\n', "", ["beam.pitch: is missing", "under [beam]"]),
        ("[friction]\nmu = 0.25", "[[friction]]\nmu = 0.25", ["friction = ", "is not a table", "[friction]"]),
        ("scales = 25", "scales = 25\nscale = 3", ["beam.scale: unknown key", "allowed: pitch, scales"]),
        ("scales = 25", '"a\\nb\\u001b" = 3', ["beam.a\\nb\\x1b: unknown key"]),
        # not TOML
        ("[substrate]", 'length = "61 mm"\n[substrate]', ["line 9: length is given twice; keep one"]),
        ("[beam]", "[scale]", ["line 15: the table [scale] is given twice"]),
        ('"45 deg"', "45 deg", ["line 6: alpha = 45 deg", 'needs quotes; write alpha = "45 deg"']),
        ('"45 deg"', "45deg  # so", ["line 6: alpha = 45deg", 'write alpha = "45deg"']),
        ('"45 deg"', '"45 deg', ["line 6:", "a quote is missing"]),
        ("mu = 0.25", "mu", ["line 24:", "is not valid TOML", "write key = value"]),
        ("mu = 0.25", "mu = " + "9" * 5000, ["is not valid TOML"]),
        ("mu = 0.25", "mu = " + "[" * 5000, ["is nested too deeply"]),
    ],
)
def test_one_mistake_is_one_line(old, new, words, tmp_path):
    assert old in GOOD
    (line,) = _complaints(GOOD.replace(old, new, 1), tmp_path)
    for word in words:
        assert word in line
    assert len(line) < 260


def test_every_mistake_is_told_at_once(tmp_path):
    bad = (
        GOOD.replace('"45 deg"', "45")
        .replace("0.49", "0.6")
        .replace('pitch = "20 mm"\n', "")
        .replace("[friction]", "[fiction]")
    )
    lines = _complaints(bad, tmp_path)
    assert sorted(line.split(" ")[0].rstrip(":") for line in lines) == [
        "[fiction]",
        "beam.pitch",
        "scale.alpha",
        "substrate.poisson_ratio",
    ]


def test_missing_tables(tmp_path):
    lines = _complaints("[friction]\nmu = 1\n", tmp_path)
    assert sorted(line.split(":")[0] for line in lines) == ["[scale]", "[substrate]", "beam.pitch"]
    assert all("is missing" in line for line in lines)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b" \n\t\n", "is empty"),
        (b"\x7fELF\0\0\1", "is a binary file"),
        (GOOD.encode("utf-16"), "is a binary file (or UTF-16 text)"),
        (GOOD.encode() + b"# \xe9\n", "is not UTF-8 text (line 25)"),
        (GOOD.encode() + b"#" * 1_000_000, "is larger than 1,000,000 bytes"),
    ],
)
def test_unreadable_contents(content, words, tmp_path):
    (line,) = _complaints(content, tmp_path)
    assert words in line
    # the file is there, so that squama new needs --force
    assert line.endswith("--force") == (words == "is empty")


def test_no_file_and_a_folder(tmp_path):
    for path, words in (
        (tmp_path / "beam.toml", "no such file; write an example with: squama new"),
        (tmp_path, "folder"),
    ):
        with pytest.raises(InputError, match=words) as caught:
            Beam.from_toml(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert len(str(caught.value).splitlines()) == 1
    for name, words in (("a\0b", "cannot be read"), ("x" * 300, "is too long for a name; give a shorter one")):
        with pytest.raises(InputError, match=words):
            read_text(name)


def test_python_gets_the_same_words():
    with pytest.raises(InputError) as caught:
        Scale(length=-1, embedded=0, width="12 deg", thickness=float("nan"), alpha=45, tetha0=0.1)
    lines = str(caught.value).splitlines()
    assert isinstance(caught.value, ValueError)
    assert caught.value.__suppress_context__
    assert lines == [
        'scale.length = -1 m: is out of range (more than 0; 1 nm to 1000 km); write e.g. "60 mm"',
        'scale.width = "12 deg": is an angle, but a length is needed; write e.g. "12 mm"',
        'scale.thickness = nan: is not a finite number; write e.g. "0.2 mm"',
        'scale.alpha = 45 rad: is out of range (0 or more, below 90 deg); write "45 deg"',
        "scale.tetha0: unknown key; did you mean theta0? allowed: length, embedded, width, thickness, alpha, theta0, "
        "youngs_modulus, poisson_ratio, strength, density",
    ]
    with pytest.raises(InputError) as caught:
        Beam(scale=3, substrat={}, pitch="20 mm")
    assert [line.split(":")[0] for line in str(caught.value).splitlines()] == ["scale = 3", "beam.substrat"]
    with pytest.raises(InputError) as caught:
        Beam.from_ratios(eta=0, beta="x", lam=float("inf"))
    assert str(caught.value).splitlines() == [
        "eta = 0: is out of range (more than 0, up to 100); write e.g. 3",
        'beta = "x": is not a plain number; write e.g. 1.25',
        "lam = inf: is not a finite number; write e.g. 0.45",
    ]
    with pytest.raises(InputError) as caught:
        Scale(**{**Beam.from_toml_text(GOOD).scale.model_dump(), "theta0": "100 deg"})
    assert str(caught.value).endswith('write e.g. "10 deg"')


def test_scales_of_endless_reach(tmp_path):
    far = GOOD.replace('"60 mm"', '"2001 mm"').replace('"30 mm"', '"1000 km"')
    length, width = _complaints(far, tmp_path)
    assert length == (
        "scale.length = 2001 mm: makes eta = l/d = 100.05 with beam.pitch = 20 mm; "
        "allowed: more than 0, up to 100; write at most 2000 mm"
    )
    assert "beta = b/d = 2.5e+07" in width
    assert width.endswith("write at most 4000 mm")
    assert Beam.from_ratios(eta=100, beta=100, lam=0.3).beta == pytest.approx(100)
    with pytest.raises(InputError, match="eta = 1000: is out of range"):
        Beam.from_ratios(eta=1000)


def _refused(path, words, writer=lambda place: place.write_text("new")):
    with pytest.raises(InputError, match=words) as caught:
        atomic_write(path, writer)
    assert len(str(caught.value).splitlines()) == 1


def test_places_that_take_no_file(tmp_path):
    _refused(tmp_path, "is a folder")
    _refused(tmp_path / "no" / "out.csv", "does not exist")
    plain = tmp_path / "plain"
    plain.write_text("old")
    _refused(plain / "out.csv", "is not a folder|not a directory")
    plain.chmod(0o444)
    _refused(plain, "is read-only")
    assert plain.read_text() == "old"
    folder = tmp_path / "locked"
    folder.mkdir()
    folder.chmod(0o555)
    _refused(folder / "out.csv", "is read-only")
    folder.chmod(0o755)
    _refused(os.devnull, "is not an ordinary file")
    _refused("a\0b", "cannot be written")
    _refused(tmp_path / ("x" * 300), "is too long for a name")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["locked", "plain"]


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), "the disk is full"),
        (OSError(errno.EROFS, "Read-only file system"), "read-only"),
        (OSError(errno.EIO, "Input/output error"), r"cannot be written \(input/output error\)"),
    ],
)
def test_a_write_that_fails_leaves_the_old_file(error, words, tmp_path):
    path = tmp_path / "out.csv"
    path.write_text("old")

    def half(place):
        place.write_text("ne")
        raise error

    _refused(path, words, half)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_other_errors_of_the_writer_pass_and_leave_nothing(tmp_path):
    def broken(place):
        place.write_text("ne")
        message = "a defect"
        raise ZeroDivisionError(message)

    with pytest.raises(ZeroDivisionError):
        atomic_write(tmp_path / "out.csv", broken)
    assert list(tmp_path.iterdir()) == []


def test_a_write_that_works(tmp_path):
    path = tmp_path / "out.tar.gz"
    seen = []
    atomic_write(path, lambda place: (seen.append(place), place.write_text("whole")))
    assert path.read_text() == "whole"
    assert seen[0].parent == tmp_path
    assert seen[0].suffix == ".gz"
    assert list(tmp_path.iterdir()) == [path]
    # the usual permissions, not those of a private temporary file
    beside = tmp_path / "usual"
    beside.touch()
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE(beside.stat().st_mode)
    # a link stays a link
    link = tmp_path / "link"
    link.symlink_to(path)
    atomic_write(link, lambda place: place.write_text("again"))
    assert link.is_symlink()
    assert path.read_text() == "again"


@pytest.mark.parametrize("wrong", [Beam.from_ratios(), 3, None, b"beam.toml"])
def test_no_path_is_refused_in_one_line(wrong):
    with pytest.raises(InputError, match="not a path; write") as caught:
        Beam.from_toml(wrong)
    assert len(str(caught.value).splitlines()) == 1
