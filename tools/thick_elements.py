"""Elements with thick elastic scales for five beams, up to 2.5 times the engagement, to check the model against.

python tools/thick_elements.py [--out FILE] [--mesh MESH] [--beam NAME]
Writes one JSON line for each beam and coefficient of friction, and goes on where it was stopped: lines that are there
are kept, and a run that was broken off goes on from its restart file beside the output. Lengths in pitches, torques in
E d^3, forces in E d^2.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

from squama import Beam
from squama.fe import runs
from squama.fe.assembly import make_bent
from squama.fe.contact import RowContact
from squama.fe.exposed import box
from squama.fe.geometry import Geometry, geometry
from squama.fe.rows import Row
from squama.study.verification import own_matrix

EXAMPLES = Path(__file__).parents[1] / "examples"
STEEL = {"youngs_modulus": "200 GPa", "poisson_ratio": 0.3, "thickness": "0.5 mm"}
BEAMS: dict[str, dict[str, dict[str, Any]]] = {
    "stiff skin": {},
    "printed": {},
    "steel": {"scale": STEEL},
    "stiff joint": {
        "scale": {
            **STEEL,
            "thickness": "1 mm",
            "embedded": "9 mm",
            "alpha": "45 deg",
            "width": "20 mm",
            "theta0": "12 deg",
        }
    },
    "soft joint": {"scale": {"embedded": "3 mm", "length": "50 mm"}, "substrate": {"youngs_modulus": "0.1 MPa"}},
}
"""What differs from ``pla_on_vps.toml`` (PLA, 3 GPa, on silicone of 1.5 MPa); "stiff skin" is ``stiff_skin.toml``."""
MUS = (0.0, 0.3)
FAR = 2.5
"""Reach over the twist at engagement."""
POINTS = 12
"""Increments to the end, at least."""
FINE = 2e-3
"""Increment of the beam on the linear joint, rad per pitch."""
LOCATED = 1e-9
"""Width, rad per pitch, to which the engagement is located."""


def engagement(shape: Geometry) -> float:
    """Return the twist at which thick plates touch that stay at rest beside their turning sections."""
    exposed = box(shape.eta, shape.beta, shape.thickness)
    contact, still = RowContact(Row(shape.rest, exposed=exposed), 0.0), np.zeros(6)
    phi, step = 0.0, 0.005
    while step > LOCATED:
        if contact.free(contact.corners(still, phi), contact.corners(still, phi + step)) == 1:
            phi += step
        else:
            step /= 2
        if phi > 1:
            message = "the scales do not engage"
            raise SystemExit(message)
    return phi


def run(name: str, mu: float, mesh: str, folder: Path) -> dict[str, Any]:
    """Return what is stored of one beam: the cell's curve, and that of the same mesh's linear joint and plates."""
    file = "stiff_skin.toml" if name == "stiff skin" else "pla_on_vps.toml"
    beam = Beam.from_toml(EXAMPLES / file).replace(**BEAMS[name])
    shape, unit = geometry(beam), beam.substrate.youngs_modulus * beam.pitch**2
    phi_e = engagement(shape)
    begun = time.process_time()
    data = runs.cell(
        beam, to=f"{FAR * phi_e} rad/pitch", mu=mu, mesh=mesh, increment=min(runs.INCREMENT, FAR * phi_e / POINTS),
        restart=folder / f"{name.replace(' ', '_')}_{mu:g}_{mesh}.npz", progress=runs.print_progress,
    )  # fmt: skip
    seconds = time.process_time() - begun
    exposed, _ = runs.exposed_part(beam, shape)
    K, phi = own_matrix(beam, mesh), data["phi"].values
    joint = np.eye(9)
    joint[:7, :7] = K
    linear, T = make_bent(joint, shape, mu, free=(), exposed=exposed), np.full(phi.size, np.nan)
    linear.aim(0.0, phi[-1])
    for i, goal in enumerate(phi):
        if not linear.run(goal, FINE).reached:
            break
        T[i] = linear.T
    rows = {
        "phi": phi, "T": data["T"].values / unit / beam.pitch, "N": data["N"].values / unit,
        "theta": data["theta"].values, "p": data["p"].values / beam.pitch, "s": data["s"].values / beam.pitch,
        "deflection": data["deflection"].values / beam.pitch, "T_linear_joint": T,
    }  # fmt: skip
    words = {key: data.attrs[key] for key in ("mesh", "plates", "sentence", "warnings", "energy_error", "beam")}
    contacts = [str(text) for text in dict.fromkeys(data["contact"].values.tolist())]
    return {
        "name": name, "mu": mu, "size": mesh, "phi_e": phi_e, **words, "contacts": contacts, "K": K.tolist(),
        "seconds": round(seconds, 1), "columns": {key: np.asarray(v, float).tolist() for key, v in rows.items()},
    }  # fmt: skip


def wanted(out: Path, mesh: str, only: str | None) -> Iterator[tuple[str, float]]:
    """Yield the beams and coefficients that the file does not hold yet."""
    lines = out.read_text(encoding="utf-8").splitlines() if out.exists() else []
    done = {(one["name"], one["mu"], one["size"]) for one in map(json.loads, lines)}
    for name in BEAMS:
        for mu in MUS:
            if (name, mu, mesh) not in done and only in (None, name):
                yield name, mu


def main() -> int:
    """Compute what is missing."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path(__file__).with_name("thick_elements.jsonl"))
    parser.add_argument("--mesh", default="medium", choices=tuple(runs.MESHES))
    parser.add_argument("--beam", choices=tuple(BEAMS))
    given = parser.parse_args()
    os.nice(10)
    for name, mu in wanted(given.out, given.mesh, given.beam):
        print(f"{name}, mu = {mu:g}", file=sys.stderr, flush=True)
        line = json.dumps(run(name, mu, given.mesh, given.out.parent))
        with given.out.open("a", encoding="utf-8") as file:
            file.write(f"{line}\n")
            file.flush()
            os.fsync(file.fileno())
    return 0


if __name__ == "__main__":
    sys.exit(main())
