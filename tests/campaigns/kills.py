"""Sweeps by one or two processes are killed at random moments, some over a damaged store; the end is always the same.

After each kill the store, if there is one, opens, and every tile with a mark has its values; the last run leaves the
undisturbed store, byte for byte.
"""

from __future__ import annotations

import contextlib
import os
import random
import shutil
import signal
import tempfile
import time
from pathlib import Path

import stores

from squama.study.plan import Plan
from squama.study.sweeping import run

TRIALS, SIZE = 20, 5
MOST_KILLS = 4
LONGEST = 0.4
"""Seconds before a kill, at most; a whole sweep takes about as long."""


def killed(dice: random.Random, plan: Plan, store: Path) -> None:
    """Run a sweep in one or two processes, and kill them."""
    children = []
    for _ in range(dice.choice((1, 2))):
        child = os.fork()
        if child == 0:
            with contextlib.suppress(BaseException):
                run(plan, store)
            os._exit(0)
        children.append(child)
    for child in children:
        time.sleep(dice.uniform(0, LONGEST))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


def trial(seed: int) -> list[str]:
    """Kill sweeps."""
    dice = random.Random(seed)
    failed = []
    for number in range(SIZE):
        which = dice.randrange(len(stores.SWEEPS))
        origin, whole, values = stores.finished(which)
        folder = Path(tempfile.mkdtemp(prefix="squama-kills-"))
        store = folder / "map.zarr"
        damaged = dice.random() < 0.3
        try:
            if damaged:
                shutil.copytree(origin, store)
                stores.damage(dice, store)
            wrong = []
            kills = dice.randint(1, MOST_KILLS)
            for _ in range(kills):
                killed(dice, stores.plan(which), store)
                if store.exists():
                    wrong += stores.read(store, values)
            wrong += stores.resumed(store, which, whole)
            if left := [p.name for p in folder.iterdir() if p != store]:
                wrong.append(f"left behind: {left}")
            told = f"seed {seed}, {number}: {kills} kills{' over a damaged store' if damaged else ''}"
            failed += [f"{told}: {'; '.join(wrong)}"] if wrong else []
        finally:
            shutil.rmtree(folder)
    return failed
