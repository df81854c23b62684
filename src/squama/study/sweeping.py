"""Sweeps: figures of beams for every combination of parameters, tile by tile, into a store that can be resumed.

Memory holds one tile and its intermediate arrays, whatever the size of the sweep.
"""

from __future__ import annotations

import functools
import itertools
import json
import math
import os
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama import arguments
from squama.batch.answers import FEW
from squama.beam import joint_law
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.errors import refuse
from squama.interrupt import Interrupted, until_interrupted
from squama.io import files
from squama.loads import LOADS, JointName, LawName, LoadName, SenseName
from squama.needs import need
from squama.progress import bars
from squama.study import cluster, columns, compliant_columns, models, parameters, store
from squama.study.plan import Plan, Tile, tile_shape, versions
from squama.types import Array
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

Ranges = Mapping[str, object]
_FAR = np.iinfo(np.int16).max
SMALLEST_TILE, LARGEST_TILE, PARTS = 1024, 65536, 16
"""Bounds of the default number of cells of a tile, a sixteenth of the sweep."""
MOST_TILES = 1_000_000


class State(NamedTuple):
    """Progress of a run: tiles and cells of its shard, those done (also by earlier runs), seconds elapsed and left."""

    tiles: int
    tiles_done: int
    cells: int
    cells_done: int
    elapsed_s: float
    left_s: float | None


Listener = Callable[[State], None]


def sweep(
    beam: Beam,
    over: Ranges,
    *,
    joint: JointName | None = None,
    ideal: bool | None = None,
    at: float | str | None = None,
    law: LawName | Sequence[LawName] = "edge",
    sense: SenseName = "+",
    margin: float = 0.01,
    load: LoadName = "twisting",
    out: str | os.PathLike[str] = "map.zarr",
    tile: int | None = None,
    shard: str | None = None,
    dask: object = None,
    progress: str | Listener | None = None,
) -> xr.Dataset:
    """Solve a beam for every combination of some parameters, into a zarr store.

    Beams are endless, whatever their number of scales. The same call resumes a sweep that was stopped or killed; the
    final store is the same, byte for byte.

    Parameters
    ----------
    over : mapping
        Parameters and their values: ``(low, high, count)`` with both ends, a list or an array of increasing values,
        or text such as ``"15deg:75deg:601"``. Names: eta, beta, lam, zeta, slenderness, alpha, theta0, mu, a value of
        the beam file such as ``scale.length``, ``joint.factor`` (on K_theta of the compliant joint), margin (hinge);
        ``psi``, the bend per pitch in which the beam is held while it is twisted, free to stretch.
    joint, ideal : str, bool, optional
        As in :func:`squama.twist`: thick, elastic scales on compliant joints where this model covers load and law, or
        "hinge". The compliant joint is that of the law or of the beam's matrix.
    at : float or str, optional
        Twist at which the figures of compliant joints are taken: a rate in rad/m or text such as "90 deg total", "0.1
        rad/pitch"; by default twice the twist at which the beam engages.
    law : str or sequence of str
        "edge", "plate", or both, which adds a dimension ``law``; "plate" is for hinges only. No effect in bending.
    sense : str
        As in :func:`squama.twist`.
    margin : float
        Cut-off before a lock on hinges, as in :func:`squama.twist`.
    load : {"twisting", "bending"}
    out : path
        Path of the store, ending in .zarr; an existing store is continued.
    tile : int, optional
        Largest number of cells of a tile, the part that is solved and written at once.
    shard : str, optional
        "1/4": only every fourth tile, beginning with the first; for job arrays.
    dask : str or distributed.Client, optional
        "local:2", "tcp://host:8786" or a client: solve the tiles there. Workers need the same folder.
    progress : str or callable, optional
        "bar", "json" (lines on standard error), or a function of ``squama.study.sweeping.State``.

    Returns
    -------
    xarray.Dataset
        Opened from the store, values read when used: ``phi_e`` (inf: no engagement), ``phi_end`` (no further than
        ``at``), ``end`` (codes, with flag_meanings), at the twist ``at`` ``torque`` (N m), ``tangent`` (N m2),
        ``stiffness_ratio``, ``N``, ``stress``, ``W_fr``, ``U_el``, ``RED`` (NaN beyond the end), ``phi_twofold``,
        ``phi_fivefold``, ``phi_strength`` up to it, ``K_theta``, ``rigidity``; ``status`` of each tile.
        On hinges: ``phi_e``, ``theta_end``, ``phi_end``, ``end``, ``neighbour``, and at the cut-off ``f0``, ``torque``
        (N m), ``U_el``, ``W_fr`` (J/m), ``RED``. In bending ``psi`` stands for ``phi``. Attributes name the model.

    Raises
    ------
    InputError
        An argument or a cell is not valid, or the store belongs to another sweep and stays unchanged.
    KeyboardInterrupt
        After Ctrl-C, when the running tile is done.

    Examples
    --------
    >>> import squama, tempfile
    >>> beam = squama.Beam.from_ratios()
    >>> over = {"mu": (0, 1, 3), "alpha": ("15 deg", "75 deg", 5)}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     r = squama.sweep(beam, over, joint="hinge", out=f"{folder}/map.zarr")
    ...     print(dict(r.sizes), f"{float(r.RED.sel(mu=0.5)[2]):.3f}")
    {'mu': 3, 'alpha': 5, 'tile_mu': 1, 'tile_alpha': 1} 0.740
    """
    arguments.beam(beam)
    plan = make_plan(
        beam, over, joint=joint, ideal=ideal, at=at, law=law, sense=sense, margin=margin, load=load, tile=tile
    )
    run(plan, Path(out), shard=shard, dask=dask, progress=progress)
    found = store.open_sweep(out)
    lines = [*notes(plan, joint, found), found.attrs["warnings"]]
    return found.assign_attrs(warnings="\n".join(filter(None, lines)))


def make_plan(
    beam: Beam,
    over: Ranges,
    *,
    joint: str | None = None,
    ideal: bool | None = None,
    at: float | str | None = None,
    law: str | Sequence[str] = "edge",
    sense: str = "+",
    margin: float = 0.01,
    load: str = "twisting",
    tile: int | None = None,
    bare: bool = True,
) -> Plan:
    """Check the arguments of :func:`sweep` and the corners of its grid; return the plan."""
    arguments.load(load)
    arguments.sense(sense)
    laws = (law,) if isinstance(law, str) else tuple(law)
    for name in laws:
        arguments.law(name)
    if len(set(laws)) != len(laws) or not laws:
        refuse("law", ", ".join(laws) or "nothing", "give each law once")
    margin = arguments.margin(margin)
    if tile is not None and (isinstance(tile, bool) or not isinstance(tile, int | np.integer) or tile < 1):
        refuse("tile", shown(tile), "must be a whole number of cells, 1 or more")
    model = models.Model.chosen(beam, load, laws, sense, joint, ideal, at, bent=parameters.BEND in over)
    if not model.compliant:
        only_one(beam.faces, "a sweep on hinges")
    swept = parameters.axes(over, bare=bare, joint=model.joint, ideal=model.ideal, load=load)
    names = {axis.name for axis in swept}
    if not LOADS[load].sided:
        laws, sense = (LOADS[load].law(laws[0]),), "+"
    if "mu" not in names:
        arguments.friction(beam.friction.mu, None, "sweep it")
    columns.check(beam, load, swept)
    margins = None if "margin" in names or model.compliant else margin
    plan = Plan(beam.to_toml(), load, laws, sense, margins, tuple(swept), (), versions(), model=model)
    most = max(SMALLEST_TILE, min(LARGEST_TILE, plan.cells // PARTS)) if tile is None else int(tile)
    plan = plan._replace(tile=tile_shape(plan.shape, plan.dims, most))
    if (tiles := math.prod(plan.grid)) > MOST_TILES:
        refuse("tile", str(most), f"makes {tiles:,} tiles, more than {MOST_TILES:,}", "give larger tiles")
    return plan


def run(
    plan: Plan, path: Path, *, shard: str | None = None, dask: object = None, progress: str | Listener | None = None
) -> tuple[int, int]:
    """Compute the unfinished tiles of a plan's shard; return the number of finished tiles of the store, and of all."""
    mine = read_shard(shard)
    if dask is not None:
        cluster.check(dask)
        need("distributed")
    shown_by = listener(progress)
    with ExitStack() as stack:
        # no store is made before the cluster answers and a first tile is solved
        new = not store.there(path)
        found = None
        if dask is not None and (new or cluster.remote(dask)):
            found = stack.enter_context(cluster.client(dask))
        early = {tile: (compute(plan, tile),) for tile in itertools.islice(plan.tiles(mine), int(new))}
        done = store.prepare(path, plan, mine)
        sizes = [(plan.size(tile), bool(done[tile])) for tile in plan.tiles(mine)]
        share, old = len(sizes), sum(was for _, was in sizes)
        todo = (tile for tile in plan.tiles(mine) if not done[tile])
        with shown_by as tell, until_interrupted() as stopped:
            cells, before = sum(n for n, _ in sizes), sum(n for n, was in sizes if was)
            state, start = State(share, old, cells, before, 0.0, 0.0 if before == cells else None), time.monotonic()
            tell(state)

            def finished(tile: Tile, wrote: bool) -> None:
                nonlocal state
                if wrote:
                    solved, gone = state.cells_done + plan.size(tile), time.monotonic() - start
                    # time left follows from the cells that this run has solved
                    left = gone / (solved - before) * (cells - solved)
                    state = State(share, state.tiles_done + 1, cells, solved, gone, left)
                    tell(state)

            with store.writing(path):
                if dask is None:
                    for tile in todo:
                        finished(tile, one_tile(str(path), tile, *early.pop(tile, ())))
                        if stopped():
                            break
                elif old < share:
                    found = found or stack.enter_context(cluster.client(dask))
                    cluster.run(found, one_tile, path, todo, finished, stopped)
            if stopped() and (now := state.tiles_done) < share:
                message = f"stopped after {now} of {share} tiles; the same command goes on from there"
                raise Interrupted(message)
    store.sweep_orphans(path, plan)
    # others may have finished tiles meanwhile
    return int(store.marked(path, plan).sum()), done.size


_beam = functools.lru_cache(maxsize=4)(Beam.from_toml_text)


def compute(plan: Plan, tile: Tile) -> dict[str, Array]:
    """Solve the cells of a tile: every variable of the store, in SI units and the shape of the tile."""
    place = dict(zip(plan.dims, plan.place(tile), strict=True))
    law = plan.laws[place.pop("law").start if "law" in place else 0]
    mesh = np.ix_(*(axis.values[place[axis.name]] for axis in plan.axes))
    values = {axis.name: v for axis, v in zip(plan.axes, mesh, strict=True)}
    margin = float(values.pop("margin").item()) if "margin" in values else plan.margin or 0.0
    beam = _beam(plan.beam_toml)
    c = plan.model.cells(beam, plan.load, values, joint_law.one_by_one)
    shape = tuple(part.stop - part.start for part in plan.place(tile))
    few = FEW if plan.cells <= FEW else 0
    found = plan.model.solved(beam, c, shape, load=plan.load, law=law, sense=plan.sense, margin=margin, few=few)
    if "neighbour" in found:
        found["neighbour"] = np.minimum(found["neighbour"], _FAR)
    return {name: found[variable.field].astype(variable.dtype) for name, variable in plan.variables.items()}


def notes(plan: Plan, joint: str | None, data: xr.Dataset) -> list[str]:
    """Return notes: why hinges replace the compliant joint, or which share of the cells lacks figures and why."""
    if not plan.model.compliant:
        note = models.note(_beam(plan.beam_toml), plan.load, plan.laws, joint, bent=parameters.BEND in plan.dims)
        return [note] if note else []
    most = len(compliant_columns.ENDS)
    counts = np.zeros(most + 1, int)
    for tile in plan.tiles():
        counts += np.bincount(data["end"][plan.place(tile)].values.ravel() + 1, minlength=most + 1)
    return models.shares(counts[1:])


@functools.lru_cache(maxsize=2)
def _writer(path: str, there: Path, digest: str) -> store.Writer:  # noqa: ARG001
    """Return the writer of a store: one of the same name in another folder, or of another sweep, is another store."""
    place = Path(path)
    plan = store.read_plan(place)
    here = versions()
    if here != plan.versions:
        # a worker on another machine; a store must not mix versions
        both = "; ".join(f"{n} {v} against {here[n]}" for n, v in plan.versions.items() if v != here[n])
        refuse(files.label(place), "", f"a worker has other versions: {both} (stored against the worker's)")
    return store.Writer(place, plan)


def one_tile(path: str, tile: Tile, values: Mapping[str, Array] | None = None) -> bool:
    """Write one tile, solved here unless ``values`` are given; False if it is done or another writer has it."""
    place = Path(path)
    with store.writing(place):
        writer = _writer(path, place.absolute(), store.read_plan(place).digest)
        with writer.claim(tile) as mine:
            if mine:
                writer.write(tile, values or compute(writer.plan, tile))
            return mine


def read_shard(text: str | None) -> tuple[int, int]:
    """Read a shard "i/n", 1 <= i <= n; without text 1/1."""
    match = re.fullmatch(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", str(text or "1/1"))
    if match is None:
        refuse("shard", shown(text), "is not i/n", "write e.g. 1/4")
    i, n = map(int, match.groups())
    if not 1 <= i <= n:
        refuse("shard", shown(text), f"must be from 1/{max(n, 1)} to {max(n, 1)}/{max(n, 1)}", "the first is 1")
    return i, n


# ---- progress: a bar, lines of JSON, or nothing --------------------------------------------------------------


def _json_lines(state: State) -> None:
    """Write the state as a line of JSON on standard error."""
    record = {k: round(v, 3) if isinstance(v, float) else v for k, v in state._asdict().items()}
    print(json.dumps(record), file=sys.stderr, flush=True)


@contextmanager
def _bar() -> Iterator[Listener]:
    """Show a progress bar on standard error, with the time left."""
    with bars(0.0) as listen:
        yield lambda state: listen("tiles", state.tiles_done, state.tiles)


def known(name: str) -> None:
    """Refuse a kind of progress other than bar, json and none."""
    if name not in ("bar", "json", "none"):
        refuse("progress", shown(name), "must be bar, json or none")


def listener(progress: str | Listener | None) -> AbstractContextManager[Listener]:
    """Return a context whose value takes each :class:`State`: a bar, lines of JSON, a function, or nothing."""
    if callable(progress):
        return nullcontext(progress)
    known(progress or "none")
    if progress == "bar":
        return _bar()
    return nullcontext(_json_lines if progress == "json" else lambda _: None)
