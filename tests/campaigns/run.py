"""Random campaigns: seeded trials by the thousand, counted, continued where they were stopped.

python tests/campaigns/run.py [NAME ...] [--trials N] [--state FOLDER] [--seed S]

A campaign is a module beside this one with ``TRIALS`` (how many by default), ``SIZE`` (cases of a trial) and
``trial(seed) -> list[str]``, which tries ``SIZE`` cases and returns one line for each that failed, with what is needed
to have it again. The exit status is 1 if any failed.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import time
from pathlib import Path

HERE = Path(__file__).parent
SHOWN = 20
"""Failures that are printed of a campaign."""


def campaign(name: str, trials: int | None, folder: Path, seed: int) -> int:
    """Run a campaign from where it was stopped; return how many cases failed."""
    module = importlib.import_module(name)
    wanted = trials or module.TRIALS
    file = folder / f"{name}-{seed}.json"
    kept = json.loads(file.read_text()) if file.exists() else {"done": 0, "failed": [], "seconds": 0.0}
    while kept["done"] < wanted:
        start = time.monotonic()
        kept["failed"] += module.trial(seed + kept["done"])
        kept["done"] += 1
        kept["seconds"] += time.monotonic() - start
        part = file.with_suffix(".part")
        part.write_text(json.dumps(kept))
        part.replace(file)
    for line in kept["failed"][:SHOWN]:
        print(f"{name}: {line}")
    tried = kept["done"] * module.SIZE
    print(f"{name}: {tried} tried, {len(kept['failed'])} failed, {kept['seconds']:.0f} s", flush=True)
    return len(kept["failed"])


def main() -> int:
    """Run the campaigns that are named, or all."""
    every = sorted(f.stem for f in HERE.glob("*.py") if f.stem != "run")
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(every)}; all without")
    parser.add_argument("--trials", type=int, help="how many, instead of each campaign's own number")
    parser.add_argument("--state", type=Path, default=Path("out/campaigns"), help="folder of what was done already")
    parser.add_argument("--seed", type=int, default=0, help="of the first trial")
    given = parser.parse_args()
    given.state.mkdir(parents=True, exist_ok=True)
    sys.path[:0] = [str(HERE), str(HERE.parent)]
    failed = sum(campaign(name, given.trials, given.state, given.seed) for name in given.names or every)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
