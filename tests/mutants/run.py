"""Plant errors in the kernel, one at a time, in a copy of the tree, and show that the tests catch each of them.

python tests/mutants/run.py [--only FILE ...] [--list] [--since REV] [--sample N] [--log FILE] [--jobs N] [--all]
    [--switched]
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import itertools
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import NamedTuple, TextIO

import switched
from equivalent import EQUIVALENT
from known import BY_HAND, TESTS
from plant import Mutant, by_hand, mutants

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "squama"
LIMIT = 180
"""Seconds of the processor that the tests may take with an error in place; a loop without end counts as caught."""
QUICK = 80
"""The same where nothing is compiled."""
PATIENCE = 8
"""How many times as long a process may take by the clock: one that waits without end stands still, and catches nothing.
"""
CAUGHT, SURVIVED, STILL = "caught", "SURVIVED", "STOOD STILL"
FEW = 3
"""Errors that a sample takes from each file before it takes more of the long ones."""
LIBRARIES = ("pytest", "hypothesis.extra.numpy", "numba", "mpmath", "pydantic", "pint", "scipy.optimize", "scipy.stats")
LIBRARIES += (
    "scipy.sparse.linalg",
    "xarray",
    "h5netcdf",
    "zarr",
    "matplotlib.pyplot",
    "cyclopts",
    "rich.table",
    "ipctk",
)
"""What the package and its tests import."""
COMPILED, FEW_DESIGNS = ("model/", "batch/"), 400
"""What is compiled for many designs: to do so for one error takes longer than to answer these many by Python."""
LEFT_OUT = (
    "-k",
    "not numba and not memory_is and not ctrl_c and not killed_at and not killed_between and not worker_that",
)


class Running(NamedTuple):
    """A child that runs the tests with an error in place."""

    mutant: Mutant
    tree: Path
    source: str
    stamp: os.stat_result


def planted(only: list[str]) -> list[Mutant]:
    """Return every error, by hand and by the tree, file after file."""
    found: list[Mutant] = [by_hand(PACKAGE, *row) for row in BY_HAND]
    found += [m for file in TESTS for m in mutants(PACKAGE, file)]
    return [m for m in found if not only or any(part in m.file for part in only)]


def drawn(found: list[Mutant], number: int) -> list[Mutant]:
    """Draw errors, FEW of each file and then in proportion; a file's draw is the same in every run, more hold fewer."""
    ranked = []
    for file, group in itertools.groupby(sorted(found), key=lambda m: m.file):
        mixed = list(group)
        random.Random(file).shuffle(mixed)
        ranked += [(i - FEW if i < FEW else i / len(mixed), m) for i, m in enumerate(mixed)]
    return [m for _, m in sorted(ranked)[:number]]


def rewritten(since: str) -> set[tuple[str, int]]:
    """Return the file and number of every line that has come since a revision."""
    lines, file = set(), ""
    command = ["git", "diff", "--unified=0", "--no-ext-diff", "--relative=src/squama", since, "--", "src/squama"]
    for line in subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines():
        if line.startswith("+++ "):
            file = line.removeprefix("+++ b/")
        elif line.startswith("@@"):
            first, _, count = line.split()[2].removeprefix("+").partition(",")
            lines |= {(file, int(first) + i) for i in range(int(count or 1))}
    return lines


def row(m: Mutant) -> str:
    """Name an error in the log, as long as its line stays as it is."""
    return f"{m.file}\t{m.change}\t{m.text}"


def reason(m: Mutant) -> str | None:
    """Why a change is no error; None if it is one."""
    known = EQUIVALENT.get((m.file, m.text), {})
    return known.get(m.change, known.get("*"))


def copy(place: Path) -> Path:
    """Copy what the tests need; compiled files stay behind, so that no stale one is found."""
    skip = shutil.ignore_patterns("__pycache__", "mutants")
    for folder in ("src", "tests", "examples", "tools"):
        shutil.copytree(ROOT / folder, place / folder, ignore=skip)
    for file in ("pyproject.toml", "CITATION.cff"):
        shutil.copy2(ROOT / file, place / file)
    return place


def run_tests(tree: Path, tests: tuple[str, ...], extra: tuple[str, ...], few: int | None) -> int:
    """Run the tests of a tree, a file at a time, in this process; returns pytest's first bad status.

    Up to ``few`` designs are answered by Python.
    """
    import pytest

    os.chdir(tree)
    sys.path[:0] = [str(tree / "src"), str(tree)]
    os.environ["PYTHONPATH"] = str(tree / "src")  # of what the tests start
    sys.dont_write_bytecode = not extra
    options = ["-x", "-q", "--no-header", "--hypothesis-profile=mutants", "--benchmark-disable", "--assert=plain"]
    # the libraries are there before pytest
    options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
    if few:
        importlib.import_module("squama.batch.answers").FEW = few
    for file, some in itertools.groupby(tests, key=lambda test: test.partition("::")[0]):
        status = pytest.main(
            [*options, *LEFT_OUT, *extra, "-p", "no:cacheprovider", *(f"tests/{test}" for test in some)]
        )
        import squama

        assert str(tree) in str(squama.__file__)
        if status not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
            print(file, flush=True)
            return int(status)
    return 0


def child(
    tree: Path,
    tests: tuple[str, ...],
    log: Path,
    extra: tuple[str, ...] = (),
    limit: int = LIMIT,
    few: int | None = None,
    number: int = 0,
) -> int:
    """Fork; the child has the libraries loaded and none of the package or, with a number, all of it and an error on."""
    pid = os.fork()
    if pid:
        return pid
    status = 3
    try:
        os.setsid()
        if limit:
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
            signal.alarm(PATIENCE * limit)
        with log.open("w", encoding="utf-8") as out:
            os.dup2(out.fileno(), 1)
            os.dup2(out.fileno(), 2)
        if number:
            switched.turn_on(number, tree / "tests")
        status = run_tests(tree, tests, extra, few)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def plant(m: Mutant, tree: Path) -> tuple[str, os.stat_result]:
    """Write the error into a tree; return what stood there, and when it was written."""
    path = tree / "src" / "squama" / m.file
    source, stamp = path.read_text(encoding="utf-8"), path.stat()
    path.write_text(m.apply(source), encoding="utf-8")
    # a time of its own: neither the original's compiled file nor another error's must be taken for this one
    os.utime(path, (stamp.st_atime, stamp.st_mtime + 7 + m.start))
    return source, stamp


def restore(done: Running) -> None:
    """Write back what stood there."""
    path = done.tree / "src" / "squama" / done.mutant.file
    path.write_text(done.source, encoding="utf-8")
    os.utime(path, (done.stamp.st_atime, done.stamp.st_mtime))


def preload() -> None:
    """Import the libraries once, before the first fork."""
    for name in LIBRARIES:
        importlib.import_module(name)
    assert "squama" not in sys.modules


def baseline(tree: Path, todo: list[Mutant]) -> bool:
    """Run the tests without an error; they must pass. Leaves compiled files behind."""
    log = tree.with_suffix(".log")
    every = tuple(dict.fromkeys(t for m in todo for t in TESTS[m.file]))
    pid = child(tree, every, log, ("--maxfail=100", "--tb=short"), limit=0, few=FEW_DESIGNS)
    good = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    if not good:
        print(log.read_text(encoding="utf-8")[-5000:])
    return good


def report(
    m: Mutant, place: str, status: int, used: resource.struct_rusage, log: Path | None, out: TextIO | None = None
) -> str:
    """Print and log what became of an error; returns it."""
    code = os.waitstatus_to_exitcode(status)
    end = STILL if code == -signal.SIGALRM else CAUGHT if code else SURVIVED
    word = f"{end} ({signal.Signals(-code).name})" if code < 0 and end == CAUGHT else end
    seconds = used.ru_utime + used.ru_stime
    print(
        f"{place} {word:8} src/squama/{m.file}:{m.line} {m.change:28} [{seconds:.1f} s] | {m.text}",
        file=out,
        flush=True,
    )
    if log:
        with log.open("a", encoding="utf-8") as file:
            file.write(f"{row(m)}\t{word}\t{seconds:.1f}\n")
    return end


def serve(put: dict[int, Mutant], tree: Path, ends: Path, log: Path | None, terminal: TextIO) -> int:
    """Load, compile and test a tree whose errors are off, then with each of them on, in a process forked from here."""
    sys.path.insert(0, str(tree / "src"))
    switched.compiles()
    every = tuple(dict.fromkeys(t for m in put.values() for t in TESTS[m.file]))
    if run_tests(tree, every, ("--maxfail=100", "--tb=short"), FEW_DESIGNS):
        return 2
    for count, (number, m) in enumerate(sorted(put.items()), 1):
        child(tree, TESTS[m.file], tree.with_suffix(".log"), limit=QUICK, few=FEW_DESIGNS, number=number)
        _, status, used = os.wait3(0)
        end = report(m, f"{count:4}/{len(put)}", status, used, log, terminal)
        with ends.open("a", encoding="utf-8") as out:
            out.write(f"{number} {end}\n")
    return 0


def try_switched(todo: list[Mutant], folder: Path, log: Path | None) -> tuple[dict[Mutant, str], list[Mutant]]:
    """Try errors behind switches; returns what became of each, and those that need a compilation of their own."""
    told, ends, several = folder / "switched.log", folder / "ends", todo
    while True:
        tree = copy(folder / "switched")
        put = switched.put_in(tree / "src", several)
        if not put:
            return {}, todo
        pid = os.fork()
        if not pid:
            status = 3
            try:
                terminal = os.fdopen(os.dup(1), "w")
                with told.open("w", encoding="utf-8") as out:
                    os.dup2(out.fileno(), 1)
                    os.dup2(out.fileno(), 2)
                status = serve(put, tree, ends, log, terminal)
            except BaseException:
                traceback.print_exc()
            finally:
                sys.stdout.flush()
                os._exit(status)
        if os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0:
            break
        other = switched.of_another_type(told.read_text(encoding="utf-8"))
        if not other:
            print(told.read_text(encoding="utf-8")[-5000:])
            raise SystemExit(2)
        several = [m for number, m in put.items() if number not in other]
        shutil.rmtree(tree)
    lines = (line.split(maxsplit=1) for line in ends.read_text(encoding="utf-8").splitlines())
    return {put[int(number)]: end for number, end in lines}, [m for m in todo if m not in put.values()]


def try_all(todo: list[Mutant], trees: list[Path], log: Path | None) -> dict[Mutant, str]:
    """Run every error, as many at once as there are trees, and log each; returns what became of each."""
    free, running, ends = list(trees), {}, {}
    queue = list(reversed(todo))
    while queue or running:
        while queue and free:
            m, tree = queue.pop(), free.pop()
            source, stamp = plant(m, tree)
            few = FEW_DESIGNS if m.file.startswith(COMPILED) else None
            pid = child(tree, TESTS[m.file], tree.with_suffix(".log"), few=few)
            running[pid] = Running(m, tree, source, stamp)
        pid, status, used = os.wait3(0)
        done = running.pop(pid)
        restore(done)
        free.append(done.tree)
        ends[done.mutant] = report(done.mutant, f"{len(ends) + 1:4}/{len(todo)}", status, used, log)
    return ends


def main() -> int:
    """Plant, run, tell; the exit status is 1 if an error was not caught."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--only", nargs="+", default=[], metavar="FILE", help="errors in files whose path holds one of these"
    )
    parser.add_argument("--since", metavar="REV", help="errors in lines that have come since a revision of git")
    parser.add_argument("--list", action="store_true", help="list the errors and plant none")
    parser.add_argument("--sample", type=int, metavar="N", help="N errors drawn by chance, some of every file")
    parser.add_argument("--log", type=Path, metavar="FILE", help="keep results here; what is there already is left out")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="tests at the same time (2)")
    parser.add_argument("--all", action="store_true", help="also those that are known to be no error")
    parser.add_argument(
        "--switched", action="store_true", help="compile once, with most errors behind switches; of a compiled room"
    )
    given = parser.parse_args()
    found = planted(given.only)
    if given.since:
        new = rewritten(given.since)
        found = [m for m in found if (m.file, m.line) in new]
    same = [m for m in found if reason(m)]
    todo = found if given.all else [m for m in found if not reason(m)]
    if given.sample is not None:
        todo = drawn(todo, given.sample)
    if given.log and given.log.exists():
        told = [line.rsplit("\t", 2) for line in given.log.read_text(encoding="utf-8").splitlines()]
        known = {name for name, end, _ in told if end != STILL}
        todo = [m for m in todo if row(m) not in known]
    if given.list:
        for m in found:
            print(
                f"src/squama/{m.file}:{m.line}  {m.change}  | {m.text}"
                + (f"  (no error: {reason(m)})" if reason(m) else "")
            )
        print(f"{len(found)} changes, {len(same)} of them known to be no error")
        return 0
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[name] = "1"
    os.environ["MPLBACKEND"] = "Agg"
    preload()
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="squama-mutants-") as folder:
        ends, alone = try_switched(todo, Path(folder), given.log) if given.switched else ({}, todo)
        first = copy(Path(folder) / "tree0")
        if alone and not baseline(first, alone):
            print("the tests fail without any planted error: mend that first")
            return 2
        # with the tests' compiled files
        more = (Path(folder) / f"tree{i}" for i in range(1, min(given.jobs, len(alone))))
        trees = [first, *(shutil.copytree(first, place) for place in more)]
        ends |= try_all(alone, trees, given.log)
    left = {m: end for m, end in ends.items() if end != CAUGHT}
    still = sum(end == STILL for end in left.values())
    with contextlib.suppress(BrokenPipeError):
        for m, end in left.items():
            print(f"{end} src/squama/{m.file}:{m.line}  {m.change}  | {m.text}")
        print(
            f"{len(ends)} errors planted, {len(ends) - len(left)} caught, {len(left) - still} survived, {still} stood"
            f" still ({len(same)} changes are known to be no error) in {time.monotonic() - start:.0f} s"
        )
    return 1 if any(end == STILL or not reason(m) for m, end in left.items()) else 0


if __name__ == "__main__":
    sys.exit(main())
