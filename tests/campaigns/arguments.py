"""Public functions are called with arguments of every kind: they answer, or refuse in lines that can be printed.

All arguments but one or a few are as they should be; these are numbers out of range, texts, dates, lists without a
shape, files, functions, objects of other packages. No other error, no warning, and no more than some seconds.
"""

from __future__ import annotations

import inspect
import math
import random
import time
import warnings
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import squama
from squama.errors import InputError, ValidityWarning

TRIALS, SIZE = 100, 100
SECONDS = 20.0
"""Of one call, at most."""
CONSTANTS = 0.8
"""Of strange arguments that are always the same; the others are drawn."""
SHARE = 1 / 30
"""Of the other arguments that are strange, too."""
LONGEST = 3000
"""Characters of a message."""
BEAM = squama.Beam.from_ratios(mu=0.3, youngs_modulus="2 MPa")
HINGED = {"joint": "hinge", "ideal": True}
SHAPE = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": 0.7, "theta0": 0.2, "mu": 0.3}
CALLS: dict[str, dict[str, Any]] = {
    "solve": SHAPE | {"stiffness_ratio": 1.0, "thickness": 0.01, "law": "edge", "sense": "+", "margin": 0.01,
                      "load": "twisting"},
    "ends": SHAPE | {"thickness": 0.0, "law": "plate", "sense": "-", "contacts": "tip"},
    "contact": {k: SHAPE[k] for k in ("eta", "beta", "lam", "alpha")} | {"theta": 0.5, "neighbour": 1, "sense": "+"},
    "forces": SHAPE | {"theta": 0.5, "law": "edge", "sense": "+", "neighbour": 1},
    "combined": SHAPE | {"psi": 0.1, "phi": 0.1, "toward": (0.0, 1.0), "neutral_height": 0.0},
    "held": SHAPE | {"psi": 0.1, "phi": 0.1, "points": 16},
    "gradient": SHAPE | {"of": "RED", "wrt": ("mu", "eta"), "load": "twisting", "margin": 0.01},
    "free_vibration": SHAPE | {"kappa": 1.0, "amplitude": 0.1, "swings": 3, "mode": "uniform", "faces": "one"},
    "twist": HINGED | {"beam": BEAM, "mu": 0.3, "law": "edge", "points": 5, "at": None, "to": "0.1 rad/pitch",
                       "sense": "+", "margin": 0.01},
    "bend": {"beam": BEAM, "mu": 0.3, "points": 5, "at": [1.0], "to": None, "joint": "hinge", "neutral": "face"},
    "cycle": HINGED | {"beam": BEAM, "twist": [0.0, 5.0, 1.0], "mu": 0.3, "law": "edge", "load": "twisting",
                       "points": 5, "loops": 1, "margin": 0.01},
    "vibrate": HINGED | {"beam": BEAM, "release": "0.1 rad/pitch", "rotor": "0.01 kg m2", "damping": 0.0, "swings": 2,
                         "mode": "uniform", "density": None},
    "read_measured": {"path": "no.csv", "beam": BEAM, "load": "twisting", "decimal": None, "columns": None},
    "open_sweep": {"path": "no.zarr"},
    "read": {"path": "no.nc"},
    "save": {"dataset": xr.Dataset(), "path": "no/such/folder/a.nc"},
}  # fmt: skip
CONSTANT: tuple[Any, ...] = (
    None, True, np.False_, 1 + 2j, np.array([1j]), datetime(2026, 1, 1, tzinfo=UTC), np.datetime64("2026-01-01"),
    timedelta(1), np.timedelta64(3, "s"), "0.3", "", "\x1b[31m\0", b"0.3", "5 rad/m", "3 mm", "x" * 5000, "9**9**9 m",
    Path("beam.toml"), [], [[]], (), {}, {"mu": 0.3}, {0.3}, [[1.0, 2.0], [3.0]], [0.3, "x"], [0.3, None], [True, 0.3],
    np.empty((0, 3)), np.empty((2, 0)), np.array([0.1, 0.2], object), np.array([(1, 2.0)], dtype="i4,f8"),
    np.array(["a"]), np.ma.masked_all(3), xr.DataArray([0.1, 0.2]), xr.Dataset(), BEAM, squama.Beam, len, object(),
    iter([1.0]), range(3), memoryview(b"ab"), Decimal("0.3"), Decimal("NaN"), Fraction(1, 3), 10**400, -(10**30),
    math.nan, math.inf, -math.inf, -0.0, 5e-324, 1.7e308,
)  # fmt: skip
DRAWN: tuple[Callable[[random.Random], Any], ...] = (
    lambda dice: dice.uniform(-1, 1),
    lambda dice: 10 ** dice.uniform(-320, 308),
    lambda dice: -dice.expovariate(1),
    lambda dice: [dice.uniform(0.01, 1) for _ in range(3)],
    lambda dice: dice.randrange(-3, 12),
    lambda dice: np.float32(dice.random()),
)


def one(name: str, given: dict[str, Any]) -> str:
    """Call a function; return what was wrong, nothing if nothing."""
    begun = time.monotonic()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ValidityWarning)
        try:
            getattr(squama, name)(**given)
        except InputError as error:
            text = str(error)
            if not text or len(text) > LONGEST or not text.replace("\n", "").isprintable():
                return f"a message of {len(text)} characters: {text[:80]!r}"
        except Exception as error:
            return f"{type(error).__name__}: {str(error)[:120]}"
    took = time.monotonic() - begun
    return f"{took:.0f} s" if took > SECONDS else ""


def trial(seed: int) -> list[str]:
    """Call functions with arguments, some of them strange."""
    dice = random.Random(seed)
    failed = []
    for number in range(SIZE):
        name = dice.choice(list(CALLS))
        given = dict(CALLS[name])
        known = list(inspect.signature(getattr(squama, name)).parameters)
        for argument in [dice.choice(known), *(k for k in given if dice.random() < SHARE)]:
            given[argument] = dice.choice(CONSTANT) if dice.random() < CONSTANTS else dice.choice(DRAWN)(dice)
        if wrong := one(name, given):
            odd = {k: v for k, v in given.items() if k not in CALLS[name] or v is not CALLS[name][k]}
            failed.append(f"seed {seed}, {number}: {name}({odd!r}): {wrong}"[:400])
    return failed
