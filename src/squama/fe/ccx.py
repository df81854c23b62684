"""Run a CalculiX deck of `squama.fe.deck`, read what it prints, and look at the contact in every increment.

An increment that the program accepts is no proof that the edges touch as they should: a scale may have slipped through
its neighbour. So the gap of every pair of edges is computed from the corners of the plates, and a run in which a gap
goes far below zero is refused.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import files
from squama.errors import InputError
from squama.fe.deck import MARK
from squama.fe.deck_reader import Deck, read

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

LARGEST = 500_000_000
"""Largest deck that is read, bytes."""
DEEPEST = 0.02
"""Penetration (pitches) from which a contact counts as lost; the penalty itself allows far less."""
PRINTED = (("CORNERS", "displacements"), ("EDGES", "displacements"), ("FIXED", "forces"))
"""Sets and quantities that every increment prints."""
_TITLE = re.compile(r"\s*(displacements|forces) .* for set (\w+) and time\s+(\S+)")


class CalculixError(InputError):
    """CalculiX is missing, fails, or loses a contact; ``done`` is the dataset of the increments before, or None."""

    def __init__(self, message: str, done: xr.Dataset | None = None) -> None:
        super().__init__(message)
        self.done = done


class _Printed(NamedTuple):
    """Times of the increments, and by set and quantity the values (increments, nodes, 3) in the set's order."""

    times: Array
    values: dict[tuple[str, str], Array]


def program() -> str:
    """Return the path of CalculiX.

    Raises
    ------
    CalculixError
        It is not installed.
    """
    found = shutil.which("ccx")
    if found is None:
        message = "CalculiX (ccx) is not installed; install it with: apt-get install calculix-ccx"
        raise CalculixError(message)
    return found


def run_calculix(
    deck: str | os.PathLike[str],
    *,
    folder: str | os.PathLike[str] | None = None,
    threads: int = 2,
    timeout: float | None = None,
) -> xr.Dataset:
    """Run a deck that `squama deck --for calculix` has written.

    Parameters
    ----------
    deck : path
        The deck (.inp).
    folder : path, optional
        Where the program works and leaves its files; a temporary folder if not given.
    threads : int
        Processors to use.
    timeout : float, optional
        Longest time, s.

    Returns
    -------
    xarray.Dataset
        As from `results`.

    Raises
    ------
    CalculixError
        The program is missing, stops before the end, or a contact is lost. Increments done so far are in ``done``.
    InputError
        The file cannot be read, or is no deck of ours.
    """
    ccx = program()
    text = files.read_text(deck, limit=LARGEST, missing="write it with: squama deck")
    parsed = read(text)
    _about(parsed)
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(folder) if folder is not None else Path(temporary)
        place.mkdir(parents=True, exist_ok=True)
        (place / "beam.inp").write_text(text, encoding="utf-8")
        for old in ("beam.dat", "beam.sta"):
            (place / old).unlink(missing_ok=True)
        late = False
        with (place / "ccx.log").open("w", encoding="utf-8") as log:
            environment = {**os.environ, "OMP_NUM_THREADS": str(threads)}
            try:
                status = subprocess.run(
                    [ccx, "-i", "beam"],
                    cwd=place,
                    stdout=log,
                    stderr=log,
                    env=environment,
                    timeout=timeout,
                    check=False,
                ).returncode
            except subprocess.TimeoutExpired:
                status, late = 1, True
        said = (place / "ccx.log").read_text(encoding="utf-8", errors="replace")
        printed = place / "beam.dat"
        data = printed.read_text(encoding="utf-8") if printed.exists() else ""
    done = results(parsed, data) if data.strip() else None
    count = 0 if done is None else done.sizes["point"] - 1
    if late:
        message = f"CalculiX was stopped after {timeout:g} s; {count} increments are done: give it more time"
        raise CalculixError(message, done)
    if status or "*ERROR" in said or done is None or not np.isclose(float(done["share"][-1]), 1.0):
        lines = [line.strip() for line in said.splitlines() if "*ERROR" in line or "best solution" in line]
        why = f" ({lines[0][:120]})" if lines else ""
        message = (
            f"CalculiX stopped after {count} increments{why}: take a smaller twist, finer elements or more increments"
        )
        raise CalculixError(message, done)
    return audit(done)


def audit(data: xr.Dataset) -> xr.Dataset:
    """Return the dataset if no contact was lost in any increment.

    Raises
    ------
    CalculixError
        A tip edge went through its neighbour's side edge; ``done`` holds the increments before.
    """
    gap = np.nan_to_num(data["gap"].values, nan=0.0)
    bad = np.argwhere(gap < -DEEPEST)
    if bad.size:
        j, i = (int(v) for v in bad[0])
        phi = float(data["phi"][j])
        message = (
            f"the contact of scales {i + 1} and {i + 2} was lost in increment {j} (phi = {phi:.4g} rad): their edges "
            f"overlap by {-gap[j, i]:.3g} pitches, though CalculiX accepted it; write the deck with more increments"
        )
        raise CalculixError(message, data.isel(point=slice(0, j)))
    return data


def _table(text: str) -> _Printed:
    """Return the printed tables."""
    found: dict[tuple[str, str], list[list[list[float]]]] = {}
    times: list[float] = []
    rows: list[list[float]] = []
    for line in text.splitlines():
        if title := _TITLE.match(line):
            what, name, time = title.groups()
            rows = []
            found.setdefault((name, what), []).append(rows)
            if not times or float(time) != times[-1]:
                times.append(float(time))
        elif line.strip():
            rows.append([float(v) for v in line.split()[:4]])
    # a run that was stopped may have broken off in the middle of an increment
    sizes = {key: len(found[key][0]) if key in found else 0 for key in PRINTED}
    count = min(len(found.get(key, [])) for key in PRINTED)
    while count and any(len(found[key][count - 1]) != size for key, size in sizes.items()):
        count -= 1
    arrays = {}
    for key, size in sizes.items():
        array = np.array(found.get(key, [])[:count], float).reshape(count, size, 4)
        arrays[key] = array[:, np.argsort(array[0, :, 0])] if count else array
    return _Printed(np.array(times[:count]), arrays)


def results(deck: Deck, text: str) -> xr.Dataset:
    """Return what a run has printed.

    Parameters
    ----------
    deck : Deck
        The deck as read.
    text : str
        The file of printed results (.dat).

    Returns
    -------
    xarray.Dataset
        Dimensions ``point`` (0 is the beam at rest) and ``scale``: ``phi`` twist per pitch (rad), ``T`` torque at the
        fixed end (N m), ``theta`` inclination against the local section (rad), ``local_twist`` of the bar at the scale
        (rad), ``w_X``, ``w_Z`` turns about its length and normal (rad), ``gap`` between tip edge and next side edge
        (pitches, NaN where they do not cross).
    """
    import xarray as xr

    about = _about(deck)
    printed = _table(text)
    d, n = about["pitch_mm"], int(about["scales"])
    share = np.concatenate([[0.0], printed.times])

    def moved(name: str) -> tuple[Array, Array]:
        """Return numbers of the nodes of a set and their places in every state, the rest first."""
        numbers = np.array(sorted(deck.nsets[name]))
        rest = np.array([deck.nodes[i] for i in numbers])
        u = printed.values[name, "displacements"]
        return numbers, np.concatenate([rest[None], rest + u[:, :, 1:]]) if len(u) else rest[None]

    numbers, places = moved("CORNERS")
    order = [int(np.searchsorted(numbers, i)) for i in deck.nsets["CORNERS"]]
    corners = (places[:, order] / d).reshape(len(share), n, 4, 3)
    local = _local_twist(moved("EDGES")[1], d, n)
    theta, roll, yaw = _attitude(corners, local, about)
    fixed = np.array([deck.nodes[i] for i in sorted(deck.nsets["FIXED"])])
    force = printed.values["FIXED", "forces"][:, :, 1:]
    moment = np.array([(fixed[:, 0] * f[:, 1] - fixed[:, 1] * f[:, 0]).sum() for f in force])
    rad, dims = {"units": "rad"}, ("point", "scale")
    return xr.Dataset(
        {
            "T": ("point", np.concatenate([[0.0], moment]) * 1e-3, {"long_name": "torque", "units": "N m"}),
            "theta": (dims, theta, {"long_name": "inclination against the local section", **rad}),
            "local_twist": (dims, local, {"long_name": "twist of the bar at the scale", **rad}),
            "w_X": (dims, roll, {"long_name": "turn of the scale about its length", **rad}),
            "w_Z": (dims, yaw, {"long_name": "turn of the scale about its normal", **rad}),
            "gap": (
                dims,
                _gaps(corners),
                {"long_name": "gap of tip edge and next side edge, in pitches", "units": "1"},
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


def _about(deck: Deck) -> dict[str, Any]:
    about: dict[str, Any] = {}
    for line in deck.comments:
        if line.startswith(MARK):
            about |= json.loads(line.removeprefix(MARK))
    if not {"scales", "pitch_mm", "twist_per_pitch", "alpha", "theta0"} <= set(about):
        message = "this deck was not written by squama deck: its head lacks the beam's data; write it anew"
        raise InputError(message)
    return about


def _local_twist(places: Array, d: float, n: int) -> Array:
    """Return the turn of the bar's back face at every scale, (states, scales), positive in the sense of the twist."""
    rest = places[0]
    angle = np.zeros((len(places), n))
    for j, state in enumerate(places):
        ends = []
        for side in (-1, 1):
            on = np.flatnonzero(np.sign(rest[:, 0]) == side)
            on = on[np.argsort(rest[on, 2])]
            z = rest[on, 2] / d
            ends.append([np.interp(np.arange(n), z, state[on, k]) for k in (0, 1)])
        (x0, y0), (x1, y1) = ends
        angle[j] = -np.arctan2(y1 - y0, x1 - x0)
    return angle


def _attitude(corners: Array, local: Array, about: dict[str, Any]) -> tuple[Array, Array, Array]:
    """Return inclination, roll and yaw from the corners D, A, B, C (states, scales, 4, 3) and the bar's local twist."""
    D, A, B, C = (corners[:, :, i] for i in range(4))
    x = (B + C - A - D) / 2
    y = (A + B - C - D) / 2
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    y /= np.linalg.norm(y, axis=-1, keepdims=True)
    axes = np.stack([x, y, np.cross(x, y)], axis=-2)
    c, s = np.cos(local), np.sin(local)
    # back from the section's attitude: the inverse of the clockwise turn
    turned = np.stack(
        [
            c[..., None] * axes[..., 0] - s[..., None] * axes[..., 1],
            s[..., None] * axes[..., 0] + c[..., None] * axes[..., 1],
            axes[..., 2],
        ],
        axis=-1,
    )
    rest = axes[:1]
    # rotation in the plate's axes at rest: its columns are the turned axes
    E = np.einsum("tsik,tsjk->tsij", np.broadcast_to(rest, turned.shape), turned)
    axial = (
        np.stack([E[..., 2, 1] - E[..., 1, 2], E[..., 0, 2] - E[..., 2, 0], E[..., 1, 0] - E[..., 0, 1]], axis=-1) / 2
    )
    sine = np.linalg.norm(axial, axis=-1)
    angle = np.arctan2(sine, (np.trace(E, axis1=-2, axis2=-1) - 1) / 2)
    w = axial * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 1.0)[..., None]
    return about["theta0"] - w[..., 1], w[..., 0], w[..., 2]


def _gaps(corners: Array) -> Array:
    """Return the gap of each tip edge and the next scale's side edge; NaN where they do not cross or none is next."""
    states, n = corners.shape[:2]
    gap = np.full((states, n), np.nan)
    for i in range(n - 1):
        _, _, B, C = (corners[:, i, k] for k in range(4))
        D2, _, _, C2 = (corners[:, i + 1, k] for k in range(4))
        u, v = B - C, C2 - D2
        normal = np.cross(v, u)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        # C + p u - D2 - s v = gap normal
        left = np.stack([u, -v, -normal], axis=-1)
        p, s, g = np.moveaxis(np.linalg.solve(left, (D2 - C)[..., None])[..., 0], -1, 0)
        gap[:, i] = np.where((p >= 0) & (p <= 1) & (s >= 0) & (s <= 1), g, np.nan)
    return gap
