"""Help and version of the commands: what they say, and that nothing heavy is loaded for it."""

import contextlib
import functools
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import squama
from squama.cli import main
from squama.cli.app import COMMANDS, EXAMPLES, make
from squama.cli.flags import collecting

ROOT = Path(__file__).parents[2]


def _out(capsys, *arguments):
    assert main(list(arguments)) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


@functools.cache
def _help(command):
    """Return the help of a command, which is made once."""
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        assert main([command, "--help"]) == 0
    assert error.getvalue() == ""
    return out.getvalue()


def _typed(example):
    """Return the words of an example as a shell reads them, which joins lines that end in a backslash."""
    return shlex.split(example.replace("\\\n", ""))


def _process(*arguments, code):
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
    )


def test_version(capsys):
    assert _out(capsys, "--version").strip() == squama.__version__


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"]])
def test_help_names_the_commands(arguments, capsys):
    text = _out(capsys, *arguments)
    for name, words in COMMANDS.items():
        assert name in text
        assert words.split(",")[0].split(":")[0] in " ".join(text.replace("\u2502", " ").split())


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_explains_every_flag(command):
    lines = _help(command).splitlines()
    flags = [
        line for line in lines if line.startswith("\u2502") and " --" in line[:8] and "display this" not in line.lower()
    ]
    assert flags
    for line in flags:
        assert len(line.strip(" \u2502*").split("  ")) > 1, line


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_ends_with_an_example(command):
    example = _help(command).rstrip().rpartition("Example:\n")[2]
    assert example == f"squama {command} {EXAMPLES[command]}"
    with collecting():
        found, bound, _ = make().parse_args(_typed(example)[1:], exit_on_error=False, print_error=False)
    assert found.__name__ == command.replace("-", "_")
    assert bound.arguments


@pytest.mark.slow
def test_the_examples_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "examples" / "limb.toml", "target.toml")
    for name in ("designs.csv", "pla_on_vps.toml", "cantilever.toml"):
        shutil.copy(ROOT / "examples" / name, name)
    # in this order: what one writes another reads; elements, fronts and the paper's figures have tests of their own
    for command in EXAMPLES:
        if command == "fit":
            assert main(["cycle", "beam.toml", "--to", "90 deg total", "--points", "40", "--csv", "test.csv"]) == 0
        if command not in ("explore", "pareto", "joint", "cell", "verify", "paper"):
            assert main([command, *_typed(EXAMPLES[command])]) == 0, (command, capsys.readouterr().err)


@pytest.mark.parametrize("command", [name for name in COMMANDS if name != "new"])
def test_every_command_that_computes_has_json(command, capsys):
    assert "--json" in _help(command)


@pytest.mark.slow(but=6)
@pytest.mark.parametrize("arguments", [["--version"], ["--help"], *([name, "--help"] for name in COMMANDS)])
def test_help_loads_nothing_heavy(arguments):
    heavy = ["numpy", "scipy", "xarray", "pandas", "pydantic", "matplotlib", "h5py"]
    code = (
        f"import sys; from squama.cli import main; main(sys.argv[1:]); print([m for m in {heavy} if m in sys.modules])"
    )
    assert _process(*arguments, code=code).stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("module", ["squama", "squama.cli"])
def test_as_a_module(module):
    code = f"import runpy, sys; sys.argv[0] = 'squama'; runpy.run_module({module!r}, run_name='__main__')"
    done = _process("--version", code=code)
    assert (done.returncode, done.stdout.strip()) == (0, squama.__version__)


def _completion(shell, folder, monkeypatch, capsys):
    monkeypatch.setenv("HOME", str(folder))
    script = folder / f"squama.{shell}"
    assert "installed" in _out(capsys, "--install-completion", "--shell", shell, "--output", str(script))
    return script


@pytest.mark.slow(but=1)
@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["unc"], ["uncertainty"]),
        (["twist", "--ne"], ["--neutral", "--netcdf"]),
        (["twist", "be"], ["beam.toml"]),
        (["twist", "beam.toml", "--plot", "pic"], ["pictures"]),
        (["fit", "beam.toml", "te"], ["test.csv"]),
        (["cycle", "beam.toml", "--to", "be"], []),
    ],
)
def test_bash_completes_commands_flags_and_files(typed, offered, tmp_path, monkeypatch, capsys):
    script = _completion("bash", tmp_path, monkeypatch, capsys)
    for name in ("beam.toml", "test.csv"):
        (tmp_path / name).touch()
    (tmp_path / "pictures").mkdir()
    words = " ".join(map(shlex.quote, ["squama", *typed]))
    ask = f'. {script}; COMP_WORDS=({words}); COMP_CWORD={len(typed)}; _squama; printf "%s\\n" "${{COMPREPLY[@]}}"'
    done = subprocess.run(["bash", "--norc", "-c", ask], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stdout.split() == offered, done.stderr


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("shell", "files"), [("zsh", "_files"), ("fish", "-l csv -r -F "), ("powershell", "CompleteFilename")]
)
def test_other_shells_complete_every_command(shell, files, tmp_path, monkeypatch, capsys):
    text = _completion(shell, tmp_path, monkeypatch, capsys).read_text(encoding="utf-8")
    assert [name for name in COMMANDS if name not in text] == []
    assert files in text


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ("twsit", 'Unknown command "twsit". Did you mean "twist"?'),
        ("foo", 'Unknown command "foo"; see "squama --help"'),
    ],
)
def test_a_command_that_is_not_there(typed, words, capsys):
    assert main([typed]) == 2
    assert capsys.readouterr().err == f"squama: error: {words}\n"


@pytest.mark.slow
def test_help_says_of_the_joint_what_commands_do(tmp_path, capsys):
    """By default bending has the joint of twisting."""
    said = {}
    for command in COMMANDS:
        words = " ".join(re.sub(r"[\s│]+", " ", _help(command)).split())
        if "Joint of a scale" in words:
            said[command] = words
    assert len(said) == 12
    for command, words in said.items():
        assert "Default: compliant; hinge with the plate law" in words, command
    beam = ROOT / "examples" / "stiff_skin.toml"
    for command, more in (
        ("bend", ["--points", "3"]),
        ("cycle", ["--load", "bending", "--to", "0.08 rad/pitch", "--points", "5"]),
        ("vibrate", ["--load", "bending", "--release", "60 deg total", "--swings", "1", "--rotor", "1e-4 kg m2"]),
        ("view", ["--load", "bending", "-o", str(tmp_path / "a.png")]),
    ):
        assert '"compliant"' in (found := _out(capsys, command, str(beam), "--json", *more)) or command == "view"
        assert "thick, elastic scales" in found, command
    page = (ROOT / "docs" / "howto" / "commands.md").read_text(encoding="utf-8")
    assert "`bend` models the beam as you would print it: thick, elastic scales" in page
