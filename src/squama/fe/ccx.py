"""Run a CalculiX deck of `squama.fe.deck`, read its results, and check the contact in every increment.

An increment accepted by CalculiX is no proof of sound contact: a scale may have slipped through its neighbour. So the
gap of every pair of edges is computed from the corners of the plates, and a run in which a gap falls far below zero is
refused.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from squama.errors import InputError
from squama.fe.deck import MARK
from squama.io import files
from squama.people import per_pitch
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr


LARGEST = 500_000_000
"""Largest size of a deck, bytes."""
DEEPEST = 0.02
"""Penetration (pitches) from which a contact counts as lost; that of the penalty contact is far smaller."""
_PRINTED = ("CORNERS", "TIP", "SIDE", "EDGES", "FIXED")
"""Sets of nodes with results printed at every increment."""
_TITLE = re.compile(r"\s*(?:displacements|forces) .* for set (\w+) and time\s+(\S+)")


class CalculixError(InputError):
    """CalculiX is missing, fails, or loses a contact; ``done``: dataset of the increments before, or None."""

    def __init__(self, message: str, done: xr.Dataset | None = None) -> None:
        super().__init__(message)
        self.done = done


def run_calculix(
    deck: str | os.PathLike[str],
    *,
    folder: str | os.PathLike[str] | None = None,
    threads: int = 2,
    timeout: float | None = None,
) -> xr.Dataset:
    """Run a deck (.inp) that `squama deck --for calculix` has written; return the dataset of :func:`results`.

    ``folder``: working folder of the program, with its files after the run, a temporary one if not given; ``threads``:
    number of threads; ``timeout``: limit of the time, s.

    Raises
    ------
    CalculixError
        The program is missing, stops before the end, or a contact is lost. ``done`` has the increments before.
    InputError
        The file cannot be read, or was not written by squama.
    """
    ccx = shutil.which("ccx")
    if ccx is None:
        message = "CalculiX (ccx) is not installed; install it with: apt-get install calculix-ccx"
        raise CalculixError(message)
    text = files.read_text(deck, limit=LARGEST, missing="write it with: squama deck")
    _read(text)
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(temporary if folder is None else folder)
        place.mkdir(parents=True, exist_ok=True)
        (place / "beam.inp").write_text(text, encoding="utf-8")
        log, printed = place / "ccx.log", place / "beam.dat"
        for old in (printed, place / "beam.sta"):
            old.unlink(missing_ok=True)
        env, status = {**os.environ, "OMP_NUM_THREADS": str(threads)}, -1
        with log.open("w", encoding="utf-8") as out, suppress(subprocess.TimeoutExpired):
            status = subprocess.run(
                [ccx, "-i", "beam"], cwd=place, stdout=out, stderr=out, env=env, timeout=timeout, check=False
            ).returncode
        said = [line.strip() for line in log.read_text(encoding="utf-8", errors="replace").splitlines()]
        data = results(text, printed.read_text(encoding="utf-8") if printed.exists() else "")
    count = data.sizes["point"] - 1
    if status == -1:
        message = f"CalculiX was stopped after {timeout:g} s; {count} increments are done: give it more time"
        raise CalculixError(message, data)
    errors = [line for line in said if "*ERROR" in line]
    if status or errors or not np.isclose(float(data["share"][-1]), 1.0):
        lines = [line for line in said if line in errors or "best solution" in line]
        why = f" ({lines[0][:120]})" if lines else ""
        message = (
            f"CalculiX stopped after {count} increments{why}: take a smaller twist, finer elements or more increments"
        )
        raise CalculixError(message, data)
    return audit(data)


def audit(data: xr.Dataset) -> xr.Dataset:
    """Return the dataset, or raise CalculixError if a tip edge went through the next side edge in some increment."""
    gap = data["gap"].values
    for j, i in np.argwhere(gap < -DEEPEST)[:1].tolist():
        place = f"increment {j} at {per_pitch(float(data['phi'][j]))}"
        message = (
            f"the contact of scales {i + 1} and {i + 2} was lost in {place}: "
            f"their edges overlap by {-gap[j, i]:.3g} pitches, though CalculiX accepted it; write the deck with "
            "more increments"
        )
        raise CalculixError(message, data.isel(point=slice(0, j)))
    return data


def results(deck: str, printed: str) -> xr.Dataset:
    """Return a run's printed results as a dataset, from the texts of the deck and of the printed results (.dat).

    Dimensions ``point`` (0 is the beam at rest) and ``scale``: ``phi`` twist per pitch (rad), ``T`` torque at the fixed
    end (N m), ``theta`` inclination against the local section (rad), ``local_twist`` of the bar at the scale (rad),
    ``w_X``, ``w_Z`` turns about its length and normal (rad), ``gap`` between tip edge and next side edge (pitches, NaN
    where they do not cross), ``share`` of the twist.
    """
    import xarray as xr

    about, numbers, rest = _read(deck)
    times, values = _tables(printed, numbers)
    share, d, n = np.append(0.0, times), about["pitch_mm"], int(about["scales"])
    moved = {name: np.concatenate([x[None], x + values[name]]) for name, x in rest.items()}
    corners = (moved["CORNERS"] / d).reshape(-1, n, 4, 3)
    local = _local_twist(moved["EDGES"], d, n)
    w = _turns(corners, local)
    x, force = rest["FIXED"], values["FIXED"]
    T = 1e-3 * np.append(0.0, (x[:, 0] * force[..., 1] - x[:, 1] * force[..., 0]).sum(-1))
    each, rad = ("point", "scale"), {"units": "rad"}
    return xr.Dataset(
        {
            "T": ("point", T, {"long_name": "torque", "units": "N m"}),
            "theta": (each, about["theta0"] - w[..., 1], {"long_name": "inclination against the local section", **rad}),
            "local_twist": (each, local, {"long_name": "twist of the bar at the scale", **rad}),
            "w_X": (each, w[..., 0], {"long_name": "turn of the scale about its length", **rad}),
            "w_Z": (each, w[..., 2], {"long_name": "turn of the scale about its normal", **rad}),
            "gap": (
                each,
                _gaps(*(moved[name].reshape(len(share), n, -1, 3) / d for name in ("TIP", "SIDE"))),
                {"long_name": "gap of tip edge and next side edge, in pitches"},
            ),
            "share": ("point", share, {"long_name": "share of the twist", "units": "1"}),
        },
        coords={
            "phi": ("point", share * about["twist_per_pitch"], {"long_name": "twist per pitch", **rad}),
            "scale": np.arange(1, n + 1),
            "mu": about["mu"],
        },
        attrs={"title": "beam of scales in CalculiX", "load": "twisting"},
    )


def _read(deck: str) -> tuple[dict[str, float], dict[str, list[int]], dict[str, Array]]:
    """Return the beam's data in the head; numbers and places (mm) of the nodes of each printed set, in order."""
    about: dict[str, float] = {}
    sets: dict[str, list[int]] = {}
    nodes: dict[int, list[float]] = {}
    keyword = name = ""
    try:
        for line in deck.splitlines():
            if line.startswith(MARK):
                about |= json.loads(line.removeprefix(MARK))
            elif line.startswith("*") and not line.startswith("**"):
                keyword, _, rest = line.partition(",")
                name = rest.partition("NSET=")[2].strip()
            elif keyword == "*NODE":
                number, *place = line.split(",")
                nodes[int(number)] = [float(v) for v in place]
            elif keyword == "*NSET" and name in _PRINTED:
                sets.setdefault(name, []).extend(int(v) for v in line.split(",") if v.strip())
        return about, sets, {name: np.array([nodes[i] for i in sets[name]]) for name in _PRINTED}
    except (ValueError, KeyError):
        message = "this deck was not written by squama deck: its head, nodes or sets lack what is read; write it anew"
        raise InputError(message) from None


def _tables(text: str, numbers: dict[str, list[int]]) -> tuple[Array, dict[str, Array]]:
    """Return the times of the whole increments, and values (increments, nodes, 3) in the order of each set."""
    found: dict[str, list[dict[int, list[float]]]] = {name: [] for name in numbers}
    times: dict[float, None] = {}
    for line in text.splitlines():
        if title := _TITLE.match(line):
            name, time = title.groups()
            found[name].append({})
            times[float(time)] = None
        elif line.strip():
            # a run that was stopped may have broken off in the middle of a number
            with suppress(ValueError):
                number, *values = line.split()[:4]
                found[name][-1][int(number)] = [float(v) for v in values]
    done = [
        dict(zip(numbers, tables, strict=True))
        for tables in zip(*found.values(), strict=False)
        if all(len(t.get(i, ())) == 3 for t, members in zip(tables, numbers.values(), strict=True) for i in members)
    ]
    shaped = {
        name: np.reshape([[t[name][i] for i in nodes] for t in done], (-1, len(nodes), 3))
        for name, nodes in numbers.items()
    }
    return np.array(list(times)[: len(done)]), shaped


def _local_twist(places: Array, d: float, n: int) -> Array:
    """Return the turn (states, scales) of the bar's back face at every scale, rad, positive with the twist."""
    across = np.zeros((len(places), 2, n))
    for side in (1, -1):
        on = np.flatnonzero(np.sign(places[0, :, 0]) == side)
        on = on[np.argsort(places[0, on, 2])]
        z = places[0, on, 2] / d
        across += side * np.array([[np.interp(np.arange(n), z, state[on, k]) for k in (0, 1)] for state in places])
    return np.asarray(-np.arctan2(across[:, 1], across[:, 0]))


def _turns(corners: Array, local: Array) -> Array:
    """Return rotation vectors (states, scales, 3) of plates from rest, on rest axes, less the bar's twist; rad."""
    from scipy.spatial.transform import Rotation

    D, A, B, C = np.moveaxis(corners, 2, 0)
    x, y = B + C - A - D, A + B - C - D
    x, y = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (x, y))
    axes = np.stack([x, y, np.cross(x, y)], axis=-2)
    # back from the section's attitude: the inverse of the clockwise turn
    back = Rotation.from_rotvec(local.reshape(-1, 1) * [0.0, 0.0, 1.0]).as_matrix().reshape(*local.shape, 3, 3)
    turn = axes[:1] @ back @ axes.swapaxes(-1, -2)
    return Rotation.from_matrix(turn.reshape(-1, 3, 3)).as_rotvec().reshape(*local.shape, 3)


def _gaps(tips: Array, sides: Array) -> Array:
    """Return the gaps (states, scales) of each tip edge to the next scale's side edge; NaN where they do not cross.

    ``tips``, ``sides`` (states, scales, nodes, 3): nodes in a row along the edges, the tip's from C to B, the side's
    from D to C.
    """
    gap = np.full(tips.shape[:2], np.nan)
    # all pairs of segments
    C, D = tips[:, :-1, :-1, None], sides[:, 1:, None, :-1]
    u, v = tips[:, :-1, 1:, None] - C, sides[:, 1:, None, 1:] - D
    u, v, way = np.broadcast_arrays(u, v, D - C)
    normal = np.cross(v, u)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    # C + p u - D - s v = gap normal
    p, s, g = np.moveaxis(np.linalg.solve(np.stack([u, -v, -normal], axis=-1), way[..., None])[..., 0], -1, 0)
    crossed = np.where((p >= 0) & (p <= 1) & (s >= 0) & (s <= 1), g, np.inf).min(axis=(-2, -1))
    gap[:, :-1] = np.where(np.isfinite(crossed), crossed, np.nan)
    return gap
