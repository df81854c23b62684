"""Gaussian processes of the law of the joint: reading their numbers from the package's file, and evaluation.

An output is a trend, linear in the features f, and a sum over the designs of the sample of a weight and
    (1 + r + r^2/3) exp(-r),    r^2 = 5 sum_k ((f_k - f_k of the design) / l_k)^2
(Matern 5/2) with the lengths l_k of its process. `tools/joint_law.py` makes the file anew.
"""

from __future__ import annotations

import functools
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from squama.errors import refuse
from squama.types import Array

T = TypeVar("T")
PLACE, WIDER = (Path(__file__).with_name(f"law{of}.npz") for of in ("", "_wide"))
"""Files of the fits: of the core of the law's range, and of all of it."""
VERSION = 1
"""Version of the file's format, raised whenever the meaning of its numbers changes."""
STIFFNESS, STRAIN = 45, 184
"""Numbers of outputs of the law: for K, and for the strains, whose process is the last one."""
_CHUNK = 16
"""Shapes evaluated at a time, so that the kernel's values stay in the processor's cache."""


class Error(NamedTuple):
    """Relative error of the law against finite elements of designs that were not fitted."""

    rms: float
    worst: float


class Errors(NamedTuple):
    """Errors of the law on ``designs`` shapes that were not fitted: K_theta, torque per twist, torque and strain.

    The last two, at twice the twist of engagement, are the torque and the strain near the edges of the embedded scale.
    """

    designs: int
    K_theta: Error
    rigidity: Error
    torque: Error
    strain: Error


class Processes(NamedTuple):
    """g Gaussian processes of m outputs over p features from the same n designs, each with its own lengths l.

    ``inverse`` (p, g): 5 / l^2. ``sample`` (p, g n): twice the designs times ``inverse``. ``squares`` (g, n): the
    designs' squares times ``inverse``. ``trend`` (1 + p, m); ``weights``, (n, outputs) for each process. Outputs are
    stored process by process; ``places`` (m,) is the position of each output there.
    """

    inverse: Array
    sample: Array
    squares: Array
    trend: Array
    weights: tuple[Array, ...]
    places: Array


class Apart(NamedTuple):
    """Numbers of the estimated error of the law as a function of the distance to the fitted designs.

    ``designs`` (n, p): their features over the ``lengths`` (p,), which are means over the processes of K. The rms of
    the torque's relative error is ``floor`` everywhere, and ``scale`` r^``power`` at a distance r, see
    :func:`squama.joints.law.band`.
    """

    designs: Array
    lengths: Array
    floor: float
    scale: float
    power: float


class Law(NamedTuple):
    """Content of the law's file: mean and deviation of the features, processes of K and of the strains, errors."""

    mean: Array
    spread: Array
    stiffness: Processes
    strain: Processes
    errors: Errors
    apart: Apart

    def scaled(self, features: Array) -> Array:
        """Return features (n, p), less the sample's mean, over its standard deviation."""
        return np.asarray((features - self.mean) / self.spread)


def values(of: Processes, x: Array) -> Array:
    """Return the outputs (..., m) at scaled features (n, p), or at complex steps in k directions (n, k, p)."""
    y = of.trend[0] + x @ of.trend[1:]
    points = x if x.ndim == 2 else x[:, 0].real
    for first in range(0, len(x), _CHUNK):
        some = slice(first, first + _CHUNK)
        part = points[some]
        squares = ((part * part) @ of.inverse)[..., None] - (part @ of.sample).reshape(-1, *of.squares.shape)
        near, rates, at = nearness(squares + of.squares), None, 0
        if x.ndim > 2:
            near, step = near[:, None], x[some].imag
            rates = (2 * part[:, None] * step @ of.inverse)[..., None]
            rates = rates - (step @ of.sample).reshape(*step.shape[:2], *of.squares.shape)
            rates *= falling(squares + of.squares)[:, None]
        for k, weights in enumerate(of.weights):
            sums = near[..., k, :] @ weights
            y[some, ..., at : at + weights.shape[1]] += (
                sums if rates is None else sums + 1j * (rates[..., k, :] @ weights)
            )
            at += weights.shape[1]
    return np.asarray(y[..., of.places])


def falling(square: Array) -> Array:
    """Return the kernel's derivative with respect to the squared distance r^2, -(1 + r) exp(-r) / 6."""
    r = np.sqrt(square + 1e-12)
    return np.asarray(-(1 + r) * np.exp(-r) / 6)


def nearness(square: Array) -> Array:
    """Return the kernel at squared distances r^2."""
    # rounding may make squares slightly negative
    r = np.sqrt(square + 1e-12)
    near = r / 3
    near += 1
    near *= r
    near += 1
    near *= np.exp(np.negative(r, out=r), out=r)
    return np.asarray(near)


@functools.cache
def shipped(*, wider: bool = False) -> Law:
    """Return the fit of the core, or of the whole range, from its file, read once; raises as :func:`read`."""
    return read(WIDER if wider else PLACE, unpacked)


def read(place: Path, made: Callable[[Mapping[str, Array]], T]) -> T:
    """Return what is made of the arrays of a file of the package.

    Raises
    ------
    InputError
        The file is missing or damaged.
    """
    try:
        with place.open("rb") as bytes_of, np.load(bytes_of, allow_pickle=False) as file:
            return made({name: file[name] for name in file.files})
    except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile, zlib.error):
        reason = "the law of the joint is missing, damaged or of another version"
        refuse("", "", reason, "install squama anew", place.name)


def unpacked(table: Mapping[str, Array]) -> Law:
    """Return a law from the arrays of its file; ``group`` is the number of each output's process.

    Raises
    ------
    ValueError, KeyError
        They are not those of a law.
    """
    if table["version"] != VERSION or table["group"].shape != (STIFFNESS + STRAIN,):
        raise ValueError
    wide = {name: np.asarray(x, float) for name, x in table.items()}
    if not all(np.isfinite(x).all() for x in wide.values()):
        raise ValueError
    # the last process is that of the strains
    group, last = table["group"], len(wide["lengths"]) - 1
    parts = _processes(wide, group[:STIFFNESS], range(last)), _processes(wide, group, (last,))
    designs, shares = int(wide["errors"][0]), wide["errors"][1:].reshape(4, 2)
    errors = Errors(designs, *(Error(*pair) for pair in shares.tolist()))
    lengths = wide["lengths"][:last].mean(axis=0)
    apart = Apart(wide["sample"] / lengths, lengths, *wide["band"].tolist())
    return Law(wide["mean"], wide["spread"], *parts, errors, apart)


def _processes(wide: Mapping[str, Array], group: Array, numbers: Sequence[int]) -> Processes:
    """Return the processes with the given numbers from the file's arrays."""
    lengths, sample = wide["lengths"][list(numbers)], wide["sample"]
    outputs = [np.flatnonzero(group == g) for g in numbers]
    order = np.concatenate(outputs)
    inverse = 5 / lengths**2
    doubled = np.concatenate([2 * sample.T * x[:, None] for x in inverse], axis=1)
    squares = inverse @ (sample**2).T
    weights = tuple(np.ascontiguousarray(wide["weights"][:, at]) for at in outputs)
    return Processes(inverse.T, doubled, squares, wide["trend"][:, order], weights, np.argsort(order))
