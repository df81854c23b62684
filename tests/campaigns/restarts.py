"""Restart files of finite elements are damaged at random, and the same command is asked to go on from them.

It says in one line with exit status 2 that the file is damaged, or goes on to the answer of the undamaged file.
"""

from __future__ import annotations

import contextlib
import functools
import io
import json
import tempfile
import warnings
from pathlib import Path

import numpy as np
from results import damaged

import squama
from squama.cli import main

TRIALS, SIZE = 20, 20
ASKED = ["cell", "beam.toml", "--mesh", "0.9,0.9", "--increment", "0.02", "--restart", "run.npz", "--quiet", "--json"]
FIRST, THEN = ("--to", "0.08 rad/pitch"), ("--to", "0.1 rad/pitch")


def said(folder: Path, *more: str) -> tuple[int, str, str]:
    """Run the command in a folder; return its exit status, output and errors."""
    out, errors = io.StringIO(), io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        status = main([*ASKED, *more])
    return status, out.getvalue(), errors.getvalue()


@functools.cache
def begun() -> tuple[str, bytes, str]:
    """Return a beam, the restart file of a run whose scales touch, and the answer of the run that goes on from it."""
    beam = squama.Beam.from_ratios(beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2).to_toml()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "beam.toml").write_text(beam)
        assert said(folder, *FIRST)[0] == 0
        file = (folder / "run.npz").read_bytes()
        answer = said(folder, *THEN)[1]
        assert json.loads(answer)["curve"]["N"][-1] > 0
        return beam, file, answer


def remade(data: bytes, rng: np.random.Generator) -> tuple[bytes, str]:
    """Return a file whose arrays were written anew: one is left out, cut, repeated, of other numbers or another type.

    What stands behind the arrays is as it was.
    """
    with np.load(io.BytesIO(data)) as stored:
        arrays = dict(stored)
    name, kind = str(rng.choice(list(arrays))), str(rng.choice(["left out", "cut", "twice", "more", "nan", "words"]))
    old = np.atleast_1d(arrays.pop(name))
    if kind != "left out":
        number = old.dtype.kind == "f"
        arrays[name] = {
            "cut": old[:-1], "twice": np.stack([old, old]), "more": old * 1.01 if number else old,
            "nan": np.full_like(old, np.nan) if number else old[:0], "words": old.astype(str),
        }[kind]  # fmt: skip
    made = io.BytesIO()
    np.savez(made, **arrays)
    return made.getvalue() + data[data.rindex(b"PK\5\6") + 22 :], f"{name}: {kind}"


def trial(seed: int) -> list[str]:
    """Go on from damaged files; return what went wrong."""
    rng = np.random.default_rng(seed)
    beam, file, answer = begun()
    failed = []
    for case in range(SIZE):
        data, how = (damaged if rng.random() < 0.6 else remade)(file, rng)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "beam.toml").write_text(beam)
            (folder / "run.npz").write_bytes(data)
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    status, out, errors = said(folder, *THEN)
            except BaseException as error:
                wrong = f"{type(error).__name__}: {str(error)[:200]!r}"
            else:
                lines = errors.splitlines()
                refused = (
                    status == 2 and len(lines) == 1 and "run.npz: is damaged" in errors and errors[:-1].isprintable()
                )
                wrong = "" if refused or (status == 0 and out == answer) else f"status {status}, {lines[:3]}"
        if wrong:
            failed.append(f"seed {seed}, case {case}: {how}: {wrong}")
    return failed
