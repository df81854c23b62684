"""Bad command lines over all commands: nasty texts for the flags that the parser knows, nasty files.

The commands run in one process of their own, which is started anew where one has hung or died; most lines have a
mistake, the others are held small. Expected is exit status 0 or 2, lines of ``squama: error:`` with 2, no traceback,
and an end within :data:`LIMIT` seconds.
"""

from __future__ import annotations

import contextlib
import inspect
import io
import multiprocessing
import os
import random
import shlex
import shutil
import tempfile
import typing
import warnings
from pathlib import Path
from typing import Any

TRIALS = 40
SIZE = 50
LIMIT = 180.0
"""Seconds for one command: a small run of finite elements on a busy machine."""
_LEFT_OUT = {"explore", "paper"}
"""One serves until it is stopped, the other takes minutes and no values."""
_LONG = ("joint", "verify")
_NASTY = [
    "", " ", "-", "--", "-1", "0", "1", "2", "3", "1e400", "-1e400", "nan", "inf", "1e-320", "1e300", "0x10", "\u0663",
    "\xbd", "1_000", "9" * 25, "9" * 5000, "1,2", ",", "1,,2", "0.2,0.3", "a=b", "=", "a=", "mu=0:1:3", "mu=1:0:3",
    "mu=0:1:1e400", "mu=::", "mu=0.1:0.5", "alpha=15deg:75deg:3", "scale.alpha=95 deg", "scale.alpha=30 deg",
    "beam.scales=1e9", "joint.matrix=beam.toml", "1 9**9**9 m", "1 m**9**9**9", "1 m", "5 rad/m", "0.01 rad/pitch",
    "-0.2 rad/pitch", "0.05 rad/pitch", "90 deg", "90 deg total", "1e300 rad/m", "1e-300 rad/m", "0, 0.1, 0 rad/pitch",
    "60 deg +- 1 deg", "mu=normal(0.25, 0.03)", "normal(", "5 N mm", "\0", "\n", "\x1b[31m", "\udcff", "'", '"', "%s",
    "{}", "$(id)", "/dev/full", "/dev/null", "/proc/x", "x" * 300, "twisting", "bending", "edge", "plate", "edge,plate",
    "+", "compliant", "hinge", "coarse", "0.9,0.9", "free", "1/2", "0/0", "local:0", "tcp://[::", "bar", "json", "lock",
    "RED", "mu", "stl", "all",
]  # fmt: skip
_FILES = [
    "beam.toml", "empty.toml", "text.toml", "huge.toml", "binary.toml", "folder.toml", "loop.toml", "pipe.toml",
    "nothing.toml", "test.csv", "bad.csv", "empty.csv", "binary.csv", "sealed/out.csv", "out.csv", "out.nc", "out.png",
    "out.gif", "out.html", "out.inp", "out.toml", "out.zarr", "file.zarr", "out.vtu", "out.npz", "out", "target.toml",
    "designs.csv", "tolerances.toml",
]  # fmt: skip
_SMALL = {
    "cell": {"--to": "0.005rad/pitch", "--mesh": "0.9,0.9"},
    "verify": {"--to": "0.005rad/pitch", "--mesh": "0.9,0.9"},
    "deck": {"--scales": "2"},
    "uncertainty": {"--samples": "1024", "--vary": "scale.alpha=60 deg +- 1 deg"},
    "plan": {"--noise": "5 N mm", "--joint": "hinge"},
    "view": {"--frames": "2"},
    "sweep": {"--over": "mu=0:1:3", "--out": "out.zarr"},
}
"""What is asked where a line says nothing else: commands that would not run without it, or for long."""
_INPUT = {
    "fit": ["test.csv", "beam.toml"],
    "design": ["target.toml"],
    "pareto": ["target.toml"],
    "ends": ["designs.csv"],
    "map": ["out.zarr"],
}


def _commands() -> dict[str, Any]:
    from squama.cli.app import COMMANDS, make

    app = make()
    return {name: app[name].default_command for name in COMMANDS if name not in _LEFT_OUT}


def _flags(function: Any) -> dict[str, bool]:
    """Return the flags of a command, and whether each takes a value."""
    parameters = inspect.signature(function).parameters
    files = {name for name, p in parameters.items() if p.kind in (p.POSITIONAL_ONLY, p.VAR_POSITIONAL)}
    found = {}
    for name, kind in typing.get_type_hints(function).items():
        if hasattr(kind, "__dataclass_fields__"):
            found |= typing.get_type_hints(kind)
        elif name not in {*files, "return"}:
            found[name] = kind
    return {f"--{name.strip('_').replace('_', '-')}": kind is not bool for name, kind in found.items()}


def _folder(place: Path) -> None:
    """Fill a folder with files good and bad."""
    from squama.cli.short import EXAMPLE

    good = EXAMPLE.read_text()
    texts = {
        "beam.toml": good,
        "empty.toml": "",
        "text.toml": "scale = [[[[",
        "huge.toml": good.replace("0.25", "9" * 5000),
        "test.csv": "Phi (rad/m), T (N m)\n" + "".join(f"{i / 5},{i / 200 + max(0, i - 13) / 50}\n" for i in range(30)),
        "bad.csv": "Phi (9**9 m), T\n1,1e300\nnan,2\n",
        "empty.csv": "",
        "file.zarr": "x",
        "designs.csv": "eta,beta,lambda,alpha_deg,theta0_deg,mu\n3,1.25,0.45,45,10,0.5\n",
        "target.toml": 'start = "beam.toml"\n[target]\nlock = "1e300 rad/m"\n[vary]\nscale.alpha = ["9deg", "2deg"]\n',
        "tolerances.toml": '[tolerance]\nscale.alpha = "60 deg +- 400 deg"\n',
    }
    for name, text in texts.items():
        (place / name).write_text(text)
    (place / "binary.toml").write_bytes(bytes(range(256)))
    (place / "binary.csv").write_bytes(bytes(range(256)))
    (place / "folder.toml").mkdir()
    (place / "sealed").mkdir(mode=0o555)
    (place / "loop.toml").symlink_to("loop.toml")
    os.mkfifo(place / "pipe.toml")


def lines(seed: int) -> list[list[str]]:
    """Return the command lines of a trial."""
    draw, commands = random.Random(seed), _commands()
    found = []
    for _ in range(SIZE):
        name = draw.choice([name for name in commands if name not in _LONG or draw.random() < 0.2])
        flags = {flag: takes for flag, takes in _flags(commands[name]).items() if flag != "--fresh"}
        places = [*_INPUT.get(name, ["beam.toml"])]
        if draw.random() < 0.3:
            places[draw.randrange(len(places))] = draw.choice([*_FILES, *_NASTY])
        if draw.random() < 0.1:
            places.append(draw.choice([*_FILES, *_NASTY]))
        asked: dict[str, str | None] = dict(_SMALL.get(name, {}))
        for flag in draw.sample([*flags], min(len(flags), draw.choice([0, 1, 1, 2, 2, 3]))):
            value = draw.choice(_NASTY if draw.random() < 0.7 else _FILES)
            asked[flag] = value if flags[flag] or draw.random() < 0.05 else None
        pairs = [[flag] if value is None else [flag, value] for flag, value in asked.items()]
        found.append([name, *places, *(word for pair in pairs for word in pair)])
    return found


def _serve(pipe: Any, folder: str) -> None:
    """Run command lines that come through a pipe, and send back status, output and errors."""
    os.chdir(folder)
    from squama.cli import main

    while True:
        line = pipe.recv()
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
            try:
                status: object = main(line)
            except BaseException as error:
                status = f"{type(error).__name__}: {error}"
        pipe.send((status, err.getvalue()))


class _Process:
    """The process that runs command lines, in a folder of its own."""

    def __init__(self) -> None:
        self.folder = tempfile.mkdtemp()
        _folder(Path(self.folder))
        self.pipe, other = multiprocessing.Pipe()
        self.process = multiprocessing.get_context("spawn").Process(
            target=_serve, args=(other, self.folder), daemon=True
        )
        self.process.start()
        other.close()

    def run(self, line: list[str]) -> str:
        """Run a line; return what is wrong with how it ended."""
        self.pipe.send(line)
        if not self.pipe.poll(LIMIT):
            return f"takes more than {LIMIT:.0f} s"
        try:
            status, said = self.pipe.recv()
        except EOFError:
            return "ended the process"
        told = said.splitlines()
        if status not in (0, 2):
            return f"ended with {status}"
        if "Traceback" in said or (status == 2 and not any(text.startswith("squama: error: ") for text in told)):
            return f"said {said[-200:]!r}"
        return "an endless line" if any(len(text) > 2000 for text in told) else ""

    def stop(self) -> None:
        """End the process, and remove its folder."""
        self.process.kill()
        self.process.join()
        shutil.rmtree(self.folder, ignore_errors=True)


def trial(seed: int) -> list[str]:
    """Run the lines of a seed; return those that ended otherwise than they should."""
    failed, process = [], _Process()
    try:
        for line in lines(seed):
            if wrong := process.run(line):
                failed.append(f"seed {seed}: squama {shlex.join(line)[:300]}: {wrong}")
                process.stop()
                process = _Process()
    finally:
        process.stop()
    return failed
