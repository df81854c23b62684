"""The finite element points of Fig. 6b that come with the package, computed anew.

``python benchmarks/fig6b.py out/fig6b`` runs the periodic cells (the extra fe; about ten minutes on two cores) and
writes the file. The folder gets a restart file and a netCDF file of each cell; a second call goes on there.
"""

from __future__ import annotations

import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import xarray as xr

from squama._version import __version__
from squama.curves import doors
from squama.errors import InputError
from squama.fe import runs
from squama.io import datasets, files
from squama.paper import parameters as par
from squama.paper.elements import C_F, COLUMNS, COMPLIANT, K_THETA, STORED
from squama.study import parts
from squama.study.verification import hinge_of, own_matrix
from squama.types import Array

MESHES: tuple[str | tuple[float, float], ...] = ((0.2, 0.02), (0.2, 0.03))
"""Where elements invert early in the first, the next is taken; sizes in the bulk and at the scale's edges, pitches."""
PACKAGES = ("netgen-mesher", "ipctk", "numpy", "scipy")


def run(eta: float, mu: float, folder: Path) -> tuple[xr.Dataset, str | tuple[float, float]]:
    """Run one periodic cell, or the rest of it; return the curve that goes farthest and its mesh."""
    found: list[tuple[xr.Dataset, str | tuple[float, float]]] = []
    for i, mesh in enumerate(MESHES):
        name = f"eta{eta:g}_mu{mu:g}" + (f"_{i + 1}" if i else "")
        print(f"eta = {eta:g}, mu = {mu:g}, mesh {mesh}", file=sys.stderr, flush=True)
        data = runs.cell(
            par.fig6b(eta),
            mu=mu,
            to=f"{par.FIG6B_REACH[eta]:g} rad/pitch",
            mesh=mesh,
            ideal=True,
            restart=folder / f"{name}.npz",
            progress=runs.print_progress,
        )
        datasets.save(data, folder / f"{name}.nc")
        found.append((data, mesh))
        if data.attrs["reached"]:
            break
    return max(found, key=lambda one: float(one[0]["phi"][-1]))


def write(folder: Path, place: Path = STORED) -> Path:
    """Run all cells and write their points, with the compliant joint's torque of the same mesh beside them."""
    rows: list[Array] = []
    notes: list[str] = []
    for eta in par.FIG6B_ETAS:
        beam = par.fig6b(eta)
        # what is embedded, and so the mesh, is the same for all
        K = {mesh: own_matrix(beam, mesh) for mesh in MESHES}
        joint = hinge_of(K[MESHES[0]], beam)
        unit = beam.substrate.youngs_modulus * beam.pitch**3
        K_theta, C_f = joint["stiffness"] / unit, joint["inclusion_factor"]
        for mu in par.FIG6B_MUS:
            data, mesh = run(eta, mu, folder)
            rate, T = data["Phi"].values[1:], data["T"].values[1:]
            meshed = beam.replace(joint=parts.joint_of(beam, K[mesh]))
            other = doors.twist(meshed, mu=mu, at=rate, joint="compliant", ideal=True)["T"].values
            scale = beam.G_B * beam.I
            columns = [np.full(rate.size, eta), np.full(rate.size, mu), rate, T / scale, other / scale]
            rows.append(np.column_stack(columns))
            notes.append(
                f"eta = {eta:g}, mu = {mu:g}: {data.attrs['sentence']}; {data.attrs['mesh']}; "
                f"energy balance {data.attrs['energy_error']:.1e}"
            )
    head = [
        "Periodic cells of finite elements at the geometry of Fig. 6b, and the compliant joint with their stiffness",
        "by: make fig6b; versions: " + ", ".join([f"squama {__version__}", *(f"{p} {version(p)}" for p in PACKAGES)]),
        f"{K_THETA}: {K_theta:.6g}",
        f"{C_F}: {C_f:.6g}",
        *notes,
    ]
    lines = [f"# {line}" for line in head] + [",".join((*COLUMNS, COMPLIANT))]
    lines += [",".join("" if np.isnan(v) else f"{v:.7g}" for v in row) for row in np.concatenate(rows)]
    return files.atomic_write(place, lambda at: at.write_text("\n".join(lines) + "\n", encoding="utf-8"))


def main() -> int:
    """Write the stored points anew; the argument is the folder of the runs."""
    if len(sys.argv) != 2:
        print("usage: python benchmarks/fig6b.py FOLDER", file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    try:
        folder.mkdir(parents=True, exist_ok=True)
        print(f"wrote {write(folder)}")
    except InputError as error:
        print(f"squama: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt as stop:
        print(f"squama: {stop}; {files.label(folder)} holds what is done", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
