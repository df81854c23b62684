"""The finite beam beside CalculiX: same mesh, same beam, torque and inclinations along the twist, and CPU time.

``OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/calculix.py`` prints a table, a row per number of scales;
``--write`` also puts it into docs/howto/decks.md. Both programs run one after the other on one core with increments of
the same size; CPU seconds, so other work on the machine does not count. Ours are those of a second run: compiled
kernels are loaded, the mesh is made anew.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama import Beam
from squama.fe import deck
from squama.fe.ccx import run_calculix
from squama.fe.runs import cell

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "fe" / "calculix"))
from beside import beside

PAGE = Path(__file__).parents[1] / "docs" / "howto" / "decks.md"
BEGIN, END = "<!-- written by benchmarks/calculix.py -->", "<!-- end -->"
BEAM = Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
"""The paper's Fig. 6b."""
HEAD = (
    "scales", "elements", "torque before contact (%)", "at the end (%)", "largest (%)", "inclination (deg)",
    "overlap, gap (0.001 pitches)", "CPU (s)",
)  # fmt: skip


class Row(NamedTuple):
    """Differences of CalculiX from us, and CPU seconds of both."""

    scales: int
    elements: int
    before: float
    last: float
    largest: float
    theta: float
    overlap: float
    gap: float
    theirs: float
    ours: float

    @property
    def cells(self) -> list[str]:
        """Texts of the table."""
        torques = [f"{100 * x:+.2f}" for x in (self.before, self.last, self.largest)]
        edges = f"{1e3 * self.overlap:.1f}, {1e3 * self.gap:.2f}"
        times = f"{self.theirs:.0f}, {self.ours:.0f}"
        return [str(self.scales), str(self.elements), *torques, f"{np.degrees(self.theta):.2f}", edges, times]


def measure(scales: int, mesh: tuple[float, float], twist: float, increments: int) -> Row:
    """Run both programs to a twist (rad per pitch)."""
    model = deck.model(
        BEAM, scales=scales, mu=0.2, twist=twist, size=mesh[0], edge_size=mesh[1], increments=increments, ideal=True
    )
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "beam.inp"
        place.write_text(deck.write(model, "calculix"), encoding="utf-8")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        theirs = run_calculix(place, threads=1)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    asked = {"scales": scales, "mesh": mesh, "increment": twist / increments, "ideal": True}
    cell(BEAM, to=f"{twist / increments} rad/pitch", **asked)
    begun = time.process_time()
    ours = cell(BEAM, to=f"{twist} rad/pitch", **asked)
    own = time.process_time() - begun
    both = beside(BEAM, ours, theirs)
    dT, gap = both["dT"].values, both["gap"].values
    return Row(
        scales=scales,
        elements=len(model.tets),
        before=float(dT[np.isnan(gap)][-1]),
        last=float(dT[-1]),
        largest=float(dT[np.abs(dT).argmax()]),
        theta=float(np.abs(both["theta_calculix"] - both["theta"]).max()),
        overlap=-float(np.nanmin(both["gap_calculix"])),
        gap=float(np.nanmin(gap)),
        theirs=seconds,
        ours=own,
    )


def table(rows: list[Row]) -> str:
    """Return the rows in Markdown."""
    lines = [HEAD, ["---"] * len(HEAD), *(row.cells for row in rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"


def main() -> None:
    """Measure, print, and write if asked."""
    parser = argparse.ArgumentParser(description="The finite beam beside CalculiX.")
    parser.add_argument("--scales", type=int, nargs="+", default=[2, 5])
    parser.add_argument("--mesh", type=float, nargs=2, default=[0.4, 0.2], help="sizes of elements, pitches")
    parser.add_argument("--to", type=float, default=0.12, help="twist, rad per pitch")
    parser.add_argument("--increments", type=int, default=12)
    parser.add_argument("--write", action="store_true", help=f"put the table into {PAGE.name}")
    asked = parser.parse_args()
    if any(os.environ.get(name) != "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")):
        message = "set OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1: one core, or seconds of idle threads are counted"
        raise SystemExit(message)
    size, edge = asked.mesh
    rows = []
    for scales in asked.scales:
        rows.append(measure(scales, (size, edge), asked.to, asked.increments))
        print(table(rows[-1:]), flush=True)
    if asked.write:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        _, found, after = rest.partition(END)
        if not found:
            message = f"{PAGE}: lacks {BEGIN} and {END}"
            raise SystemExit(message)
        PAGE.write_text(f"{before}{BEGIN}\n\n{table(rows)}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
