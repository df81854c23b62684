"""Damaged beam files and tables: what reads them returns, or refuses in lines that can be printed; nothing else.

A beam that is read is the same again from its own text, and so is a matrix.
"""

from __future__ import annotations

import functools
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

import squama
from squama.arrays import designs_table
from squama.beam import matrixfile
from squama.cli.uncertainty import tolerance_table as tolerances
from squama.errors import InputError, ValidityWarning
from squama.inverse.target import read_target
from squama.io import measured

TRIALS = 60
SIZE = 200
EXAMPLES = Path(__file__).parents[2] / "examples"
HOSTILE = [
    b"nan", b"inf", b"-1e400", b"9" * 5000, b'"\\u202e"', b"\x1b[2J", b"[" * 3000, b"{a = 1}", b"[1, 2]", b"''", b'"""',
    b"true", b"1979-05-27", b"=1+1", b"\0", b"\xff", b"\r", b"\n", b",", b";", b"\t", b'"', b"'", b"#", b"0x10", b"1_0",
    b"-0.0", b"1e-320", b'"-5 mm"', b'"1e300 mm"', b'"20 furlong"', b"\xef\xbb\xbf", b"../../../etc/passwd", b"%s{0}",
]  # fmt: skip
TOLERANCES = b'[tolerance]\nmu = "normal(0.25, 0.03)"\nscale.alpha = "60 deg +- 1 deg"\nbeam.pitch = "+- 2 %"\n'


def _beam(path: Path) -> str:
    beam = squama.Beam.from_toml(path)
    return "" if squama.Beam.from_toml_text(beam.to_toml()) == beam else "another beam from its own text"


def _matrix(path: Path) -> str:
    matrix = matrixfile.read(path)
    return "" if matrixfile.parse(matrix.text) == matrix else "another matrix from its own text"


def _designs(path: Path) -> str:
    found = designs_table.solve(path, law="edge", sense="+", contacts="tip")
    if wrong := [str(line) for line in found.problems if not str(line).isprintable()]:
        return f"a line that cannot be printed: {wrong[0][:200]!r}"
    again = designs_table.write(found, path.with_name("again.csv")) if found.rows else None
    return "" if again is None or again.exists() else "no table"


def _any(read: Callable[[Path], object]) -> Callable[[Path], str]:
    def call(path: Path) -> str:
        read(path)
        return ""

    return call


@functools.cache
def files() -> list[tuple[str, bytes, Callable[[Path], str]]]:
    """Return names, contents and what reads them: an empty text where all is well."""
    beam = (EXAMPLES / "pla_on_vps.toml").read_bytes()
    start = squama.Beam.from_toml(EXAMPLES / "pla_on_vps.toml")
    matrix = matrixfile.stored(start, np.diag([1.0, 2, 3, 4, 5, 6, 7]) + 0.1).text.encode()
    points = _any(lambda path: measured.read(path, pitch=0.02, scales=25))
    rows = b"".join((EXAMPLES / "designs.csv").read_bytes().splitlines(keepends=True)[:12])
    return [
        ("a.toml", beam, _beam),
        ("p.toml", (EXAMPLES / "cantilever.toml").read_bytes(), _any(squama.Part.from_toml)),
        ("a.csv", matrix, _matrix),
        ("d.csv", rows, _designs),
        ("m.csv", (EXAMPLES / "measured_loop.csv").read_bytes()[:3000], points),
        ("t.toml", (EXAMPLES / "lock_at_120.toml").read_bytes(), _any(read_target)),
        ("r.toml", (EXAMPLES / "limb.toml").read_bytes(), _any(read_target)),
        ("f.toml", (EXAMPLES / "front.toml").read_bytes(), _any(functools.partial(read_target, need="front"))),
        ("u.toml", TOLERANCES, _any(lambda path: tolerances(str(path)))),
    ]


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a text with one to three damages: a bit, bytes, a hostile value in place of a word, lines mixed."""
    for _ in range(int(rng.integers(1, 4))):
        i, n = int(rng.integers(len(data) + 1)), int(rng.choice([1, 1, 4, 40]))
        hostile = HOSTILE[int(rng.integers(len(HOSTILE)))]
        lines = data.splitlines(keepends=True) or [b""]
        j, k = rng.integers(len(lines), size=2)
        words = data.split(b" ")
        words[int(rng.integers(len(words)))] = hostile
        after = data.partition(b"=")[0] + b"= " + hostile + b"\n"
        ways = (
            lambda data=data, i=i, n=n: data[:i] + rng.bytes(n) + data[i + n :],
            lambda data=data, i=i, n=n: data[:i] + data[i + n :],
            lambda data=data, i=i, hostile=hostile: data[:i] + hostile + data[i:],
            lambda words=words: b" ".join(words),
            lambda lines=lines, j=j, k=k: b"".join([*lines[:j], lines[k], *lines[j:]]),
            lambda lines=lines, j=j: b"".join([*lines[:j], *lines[j + 1 :]]),
            lambda data=data, i=i: (
                bytes([*data[:i], *(b ^ (1 << int(rng.integers(8))) for b in data[i : i + 1])]) + data[i + 1 :]
            ),
            lambda data=data, after=after: data + after,
        )
        data = ways[int(rng.integers(len(ways)))]()
    return data


def trial(seed: int) -> list[str]:
    """Read damaged files; return what went wrong."""
    rng = np.random.default_rng(seed)
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "pla_on_vps.toml").write_bytes((EXAMPLES / "pla_on_vps.toml").read_bytes())
        for case in range(SIZE):
            name, data, read = files()[int(rng.integers(len(files())))]
            path = Path(folder) / name
            path.write_bytes(damaged(data, rng))
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    warnings.simplefilter("ignore", ValidityWarning)
                    wrong = read(path)
            except InputError as error:
                lines = str(error).split("\n")
                bad = [line for line in lines if not line.isprintable() or not line or len(line) > 2500]
                wrong = f"a message that is none: {bad[0][:300]!r}" if bad else ""
            except Exception as error:
                wrong = f"{type(error).__name__}: {str(error)[:200]!r}"
            if wrong:
                failed.append(f"seed {seed}, case {case}: {name}: {wrong}")
    return failed
