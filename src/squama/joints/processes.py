"""The numbers of the law of the joint: Gaussian processes from the package's file, and their values.

An output is a trend, linear in the features f, and a sum over the designs of the sample of a weight and
    (1 + r + r^2/3) exp(-r),    r^2 = 5 sum_k ((f_k - f_k of the design) / l_k)^2
(Matern 5/2) with the lengths l_k of its process. `tools/joint_law.py` makes the file anew.
"""

from __future__ import annotations

import functools
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama.errors import refuse
from squama.types import Array

PLACE = Path(__file__).with_name("law.npz")
VERSION = 1
"""Changes whenever the numbers of the file would mean something else."""
STIFFNESS, STRAIN = 45, 184
"""Outputs of the law: of K, and then of the strains, whose process is the last one."""
_CHUNK = 16
"""Shapes at a time, so that their nearness to the sample stays in the processor's cache."""


class Error(NamedTuple):
    """How far the law is from elements that were not fitted, relative."""

    rms: float
    worst: float


class Errors(NamedTuple):
    """Errors on ``designs`` shapes: of K_theta, of the torque per twist, and two at twice the engagement.

    These are the torque, and the strain near the edges of the embedded scale.
    """

    designs: int
    K_theta: Error
    rigidity: Error
    torque: Error
    strain: Error


class Processes(NamedTuple):
    """Processes of m outputs over p features from the same n designs, each with its lengths l; g of them.

    ``inverse`` (p, g): 5 / l^2; ``sample`` (p, g n): twice the designs times that; ``squares`` (g, n): of the designs,
    times that; ``trend`` (1 + p, m) and ``weights``, (n, outputs) of each process, with the outputs one process after
    the other; ``places`` (m,): where each output stands there.
    """

    inverse: Array
    sample: Array
    squares: Array
    trend: Array
    weights: tuple[Array, ...]
    places: Array


class Apart(NamedTuple):
    """How far the law may be off at a place, by how far the designs are from it of which it is made.

    ``designs`` (n, p): their features over the ``lengths`` (p,), means of those of the processes of K. The torque is
    off by a rms of ``floor`` everywhere, and of ``scale`` r^``power`` at a distance r, see
    :func:`squama.joints.law.band`.
    """

    designs: Array
    lengths: Array
    floor: float
    scale: float
    power: float


class Law(NamedTuple):
    """What stands in the file: what features are less and over, processes of K and of the strains, errors."""

    mean: Array
    spread: Array
    stiffness: Processes
    strain: Processes
    errors: Errors
    apart: Apart

    def scaled(self, features: Array) -> Array:
        """Return features (n, p) less the sample's mean over its deviation."""
        return np.asarray((features - self.mean) / self.spread)


def values(of: Processes, x: Array) -> Array:
    """Return the outputs (..., m) of processes at scaled features (n, p), or with complex steps in k ways (n, k, p)."""
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
    """Return the kernel's derivative by the square r^2, -(1 + r) exp(-r) / 6."""
    r = np.sqrt(square + 1e-12)
    return np.asarray(-(1 + r) * np.exp(-r) / 6)


def nearness(square: Array) -> Array:
    """Return the kernel at squares r^2."""
    # where they ought to be 0 they may be a little below
    r = np.sqrt(square + 1e-12)
    near = r / 3
    near += 1
    near *= r
    near += 1
    near *= np.exp(np.negative(r, out=r), out=r)
    return np.asarray(near)


@functools.cache
def shipped() -> Law:
    """Return the law of the package.

    Raises
    ------
    InputError
        Its file is missing or damaged.
    """
    try:
        with PLACE.open("rb") as bytes_of, np.load(bytes_of, allow_pickle=False) as file:
            return unpacked({name: file[name] for name in file.files})
    except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile, zlib.error):
        reason = "the law of the joint is missing, damaged or of another version"
        refuse("", "", reason, "install squama anew", PLACE.name)


def unpacked(table: Mapping[str, Array]) -> Law:
    """Return a law from the arrays of its file; ``group`` numbers each output's process.

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
    """Return processes by their numbers."""
    lengths, sample = wide["lengths"][list(numbers)], wide["sample"]
    outputs = [np.flatnonzero(group == g) for g in numbers]
    order = np.concatenate(outputs)
    inverse = 5 / lengths**2
    doubled = np.concatenate([2 * sample.T * x[:, None] for x in inverse], axis=1)
    squares = inverse @ (sample**2).T
    weights = tuple(np.ascontiguousarray(wide["weights"][:, at]) for at in outputs)
    return Processes(inverse.T, doubled, squares, wide["trend"][:, order], weights, np.argsort(order))
