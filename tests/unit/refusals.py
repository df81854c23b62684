"""Commands that are refused."""

from pathlib import Path

from squama.cli import main


def everything():
    """All files of the folder and what they hold."""
    return {path: path.read_bytes() if path.is_file() else None for path in sorted(Path().rglob("*"))}


def refused(arguments, lines, capsys):
    """The command ends in status 2 with these words in its lines, and changes no file."""
    before = everything()
    status = main(arguments)
    captured = capsys.readouterr()
    assert status == 2, captured.err
    assert captured.out == ""
    said = captured.err.splitlines()
    assert len(said) == len(lines), captured.err
    for line, words in zip(said, lines, strict=True):
        assert line.startswith("squama: error: ")
        for word in words:
            assert word in line, line
    assert everything() == before
