"""Sobol indices: how much of a figure's variance comes from each tolerance, alone and with all others.

First-order index S1 and total index ST by Saltelli's scheme (Saltelli et al., Comput. Phys. Commun. 181 (2010) 259)
as SALib draws and evaluates it, (D + 2) N samples for D tolerances, with bootstrap confidence intervals.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np

from squama.errors import InputError
from squama.model.solve import Array

RESAMPLES = 200
CONFIDENCE = 0.95


class Indices(NamedTuple):
    """Indices of the figures that have them, (figures, parameters) each; ``*_conf`` half widths of 95 % intervals."""

    figures: tuple[str, ...]
    S1: Array
    S1_conf: Array
    ST: Array
    ST_conf: Array
    left_out: dict[str, str]


def needed() -> None:
    """Refuse where SALib is missing.

    Raises
    ------
    InputError
        One line.
    """
    if find_spec("SALib") is None:
        message = "Sobol indices: SALib is not installed; pip install squama[fit]"
        raise InputError(message)


def indices(names: tuple[str, ...], base: int, seed: int, evaluate: Callable[[Array], dict[str, Array]]) -> Indices:
    """Draw Saltelli's samples, evaluate them and return the indices.

    Parameters
    ----------
    names : tuple of str
        The parameters.
    base : int
        N, a power of two.
    seed : int
        0 or more.
    evaluate : callable
        Points (n, parameters) of the unit cube to figures by name, (n,) each; not finite where one does not exist.

    Returns
    -------
    Indices
        A figure that does not exist in all samples, or does not vary, has none; ``left_out`` says why.
    """
    from SALib.analyze import sobol as analyze
    from SALib.sample import sobol as sample

    problem: dict[str, Any] = {"num_vars": len(names), "names": list(names), "bounds": [[0.0, 1.0]] * len(names)}
    with warnings.catch_warnings():
        # of what SALib hands on to SciPy and pandas
        warnings.simplefilter("ignore")
        points = sample.sample(problem, base, calc_second_order=False, seed=np.random.default_rng([seed, base]))
        found = evaluate(points)
        rows: dict[str, Any] = {}
        left_out: dict[str, str] = {}
        for name, values in found.items():
            there = np.isfinite(values).mean()
            if there < 1:
                left_out[name] = f"exists in {there:.4g} of the samples only"
            elif np.ptp(values) <= 1e-12 * np.abs(values).max():
                left_out[name] = "does not vary"
            else:
                # a seed of 0 means none to SALib
                rows[name] = analyze.analyze(
                    problem,
                    values,
                    calc_second_order=False,
                    num_resamples=RESAMPLES,
                    conf_level=CONFIDENCE,
                    seed=seed + 1,
                )

    def table(key: str) -> Array:
        return np.array([rows[name][key] for name in rows], float).reshape(len(rows), len(names))

    return Indices(tuple(rows), table("S1"), table("S1_conf"), table("ST"), table("ST_conf"), left_out)
