"""Sweeps: a response for every combination of some parameters, tile by tile, into a store that can be resumed.

Memory is that of one tile and of the engine at work on it, however large the sweep is.
"""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squama import checks, files
from squama.design import Beam
from squama.engines import ENGINES
from squama.errors import InputError
from squama.interrupt import Interrupted, until_interrupted
from squama.study import cells, cluster, parameters, stored, tiles, zstore
from squama.study.plan import Plan, Tile, check_tiles, default_tile, tile_shape, versions
from squama.study.progress import Clock, Listener, listener
from squama.units import shown

if TYPE_CHECKING:
    import xarray as xr

Ranges = Mapping[str, Any]
COMPILED = 200_000
"""Cells from which it pays to load the compiled engine, where there is one."""


def sweep(
    beam: Beam,
    over: Ranges,
    *,
    law: str | Sequence[str] = "edge",
    sense: str = "+",
    margin: float = 0.01,
    load: str = "twisting",
    out: str | os.PathLike[str] = "map.zarr",
    tile: int | None = None,
    shard: str | None = None,
    dask: Any = None,
    progress: str | Listener | None = None,
    engine: str = "auto",
) -> xr.Dataset:
    """Solve a beam for every combination of some parameters, into a zarr store.

    The same call goes on where an earlier one was stopped or killed; the store is in the end the same, byte for byte.

    Parameters
    ----------
    beam : Beam
        The beam; what is not swept stays as it is.
    over : mapping
        Parameters and their values: ``(low, high, count)`` with both ends, a list or an array of increasing values,
        or text such as ``"15deg:75deg:601"``. Names: eta, beta, lam, zeta, slenderness, alpha, theta0, mu, margin, or
        a value of the beam file such as ``scale.length``.
    law : str or sequence of str
        "edge", "plate", or both, which adds a dimension ``law``. Without effect in bending.
    sense, margin : str, float
        As in :func:`squama.twist`.
    load : {"twisting", "bending"}
        Kind of loading.
    out : path
        The store, ending in .zarr: made, or continued.
    tile : int, optional
        Largest number of cells of a tile, which is solved and written at once.
    shard : str, optional
        "1/4": only every fourth tile, beginning with the first; for job arrays.
    dask : str or distributed.Client, optional
        "local:2", "tcp://host:8786" or a client: solve the tiles there. Workers need the same folder.
    progress : str or callable, optional
        "bar", "json" (lines on standard error), or a function of :class:`squama.study.progress.State`.
    engine : str
        As in :func:`squama.solve`.

    Returns
    -------
    xarray.Dataset
        Opened from the store, values read when used: ``phi_e``, ``theta_end``, ``phi_end``, ``end`` (codes, with
        flag_meanings), ``neighbour``, and at the cut-off ``f0``, ``torque`` (N m), ``U_el``, ``W_fr`` (J/m), ``RED``;
        ``status`` of each tile. In bending ``psi`` stands for ``phi``.

    Raises
    ------
    InputError
        An argument or a cell is not usable, or the store is not this sweep's; it is then as it was.
    KeyboardInterrupt
        After Ctrl-C, when the running tile is done.

    Examples
    --------
    >>> import squama, tempfile
    >>> beam = squama.Beam.from_ratios()
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     r = squama.sweep(beam, {"mu": (0, 1, 3), "alpha": ("15 deg", "75 deg", 5)}, out=f"{folder}/map.zarr")
    ...     print(dict(r.sizes), f"{float(r.RED.sel(mu=0.5)[2]):.3f}")
    {'mu': 3, 'alpha': 5, 'tile_mu': 1, 'tile_alpha': 1} 0.740
    """
    plan = make_plan(beam, over, law=law, sense=sense, margin=margin, load=load, tile=tile, engine=engine)
    run(plan, Path(out), shard=shard, dask=dask, progress=progress)
    return stored.open_sweep(out)


def make_plan(
    beam: Beam,
    over: Ranges,
    *,
    law: str | Sequence[str] = "edge",
    sense: str = "+",
    margin: float = 0.01,
    load: str = "twisting",
    tile: int | None = None,
    engine: str = "auto",
    bare: bool = True,
) -> Plan:
    """Check the arguments of :func:`sweep` and every corner of its grid; return what is to be computed."""
    checks.one_of("load", load, ("twisting", "bending"))
    checks.sense(sense)
    laws = (law,) if isinstance(law, str) else tuple(law)
    for name in laws:
        checks.law(name)
    if len(set(laws)) != len(laws) or not laws:
        checks.fail(f"law = {', '.join(laws) or 'nothing'}: give each law once")
    margin = checks.scalar("margin", margin, 1e-12, 1.0, "at least 1e-12 and below 1")
    checks.one_of("engine", engine, ("auto", *ENGINES))
    if tile is not None and (isinstance(tile, bool) or not isinstance(tile, int | np.integer) or tile < 1):
        checks.fail(f"tile = {shown(tile)}: must be a whole number of cells, 1 or more")
    swept = parameters.axes(over, bare=bare)
    names = {axis.name for axis in swept}
    if load == "bending":
        laws, sense = ("edge",), "+"
        if "alpha" in names:
            checks.fail("alpha: has no effect in bending; leave it out")
    if "mu" not in names and beam.friction.mu is None:
        checks.fail("mu is not given: sweep it, or write mu under [friction] in the beam's file")
    cells.check(beam, load, swept)
    plan = Plan(
        beam_toml=beam.to_toml(),
        load=load,
        laws=laws,
        sense=sense,
        margin=None if "margin" in names else margin,
        engine=engine,
        axes=tuple(swept),
        tile=(),
        versions=versions(),
    )
    asked = default_tile(plan.cells) if tile is None else int(tile)
    plan = plan._replace(tile=tile_shape(plan.shape, plan.dims, asked), engine=_engine(engine, plan.cells))
    check_tiles(plan.grid, asked)
    return plan


def _engine(asked: str, count: int) -> str:
    """Return the engine by name: a store must not mix two, whose last digits differ."""
    if asked != "auto":
        return asked
    compiled = "numba" in ENGINES and count >= COMPILED and find_spec("numba") is not None
    return "numba" if compiled else "numpy"


def run(
    plan: Plan,
    path: Path,
    *,
    shard: str | None = None,
    dask: Any = None,
    progress: str | Listener | None = None,
) -> tuple[int, int]:
    """Compute the tiles of a plan that are not done; return how many of the store's tiles are done, and of how many."""
    mine = read_shard(shard)
    if dask is not None:
        cluster.check(dask)
    shown_by = listener(progress)
    with ExitStack() as stack:
        # a cluster that does not answer leaves no store behind
        found = stack.enter_context(cluster.client(dask)) if dask is not None and cluster.remote(dask) else None
        done = stored.prepare(path, plan)
        share, share_cells, old, old_cells = 0, 0, 0, 0
        for tile in plan.tiles(mine):
            size = plan.size(tile)
            share, share_cells = share + 1, share_cells + size
            if done[tile]:
                old, old_cells = old + 1, old_cells + size
        todo = (tile for tile in plan.tiles(mine) if not done[tile])
        with shown_by, until_interrupted() as stopped:
            clock = Clock(share, share_cells, old, old_cells, shown_by)

            def finished(tile: Tile, wrote: bool) -> None:
                if wrote:
                    clock.done(plan.size(tile))

            try:
                if dask is None:
                    for tile in todo:
                        finished(tile, one_tile(str(path), tile))
                        if stopped():
                            break
                elif old < share:
                    found = found or stack.enter_context(cluster.client(dask))
                    cluster.run(found, one_tile, path, todo, finished, stopped)
            except OSError as error:
                raise zstore.refused(path, error) from None
            if stopped() and clock.tiles_done < share:
                message = f"stopped after {clock.tiles_done} of {share} tiles; the same command goes on from there"
                raise Interrupted(message)
    # others may have finished tiles meanwhile
    return int(stored.marked(path, plan).sum()), done.size


@functools.lru_cache(maxsize=2)
def _writer(path: str, digest: str) -> zstore.Writer:  # noqa: ARG001 - another sweep of the same name is another store
    place = Path(path)
    plan = stored.read_plan(place)
    here = versions()
    if here != plan.versions:
        # on another machine; a store must not mix them
        both = "; ".join(f"{n} {v} against {here[n]}" for n, v in plan.versions.items() if v != here[n])
        message = f"{files.label(place)}: a worker has other versions: {both} (stored against the worker's)"
        raise InputError(message)
    return zstore.Writer(place, plan)


def one_tile(path: str, tile: Tile) -> bool:
    """Solve and write one tile of a store; False if it is done or another process is at it.

    Raises
    ------
    InputError
        It cannot be written.
    """
    place = Path(path)
    try:
        writer = _writer(path, stored.read_plan(place).digest)
        with writer.claim(tile) as handle:
            if handle is None:
                return False
            writer.write(tile, tiles.compute(writer.plan, tile), handle)
    except OSError as error:
        raise zstore.refused(place, error) from None
    return True


def read_shard(text: str | None) -> tuple[int, int]:
    """Return i and n of "i/n", 1 <= i <= n."""
    if text is None:
        return 1, 1
    match = re.fullmatch(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", str(text))
    if match is None:
        message = f"shard = {shown(text)}: is not i/n; write e.g. 1/4"
        raise InputError(message)
    i, n = int(match[1]), int(match[2])
    if not 1 <= i <= n:
        message = f"shard = {shown(text)}: must be from 1/{max(n, 1)} to {max(n, 1)}/{max(n, 1)}; the first is 1"
        raise InputError(message)
    return i, n
