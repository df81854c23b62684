"""Make the synthetic measurements of the examples: what a twisting test of a beam could give. They are no real tests.

Run it from the repository: python examples/make_measured_loop.py [folder to write to]
"""

import itertools
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import squama

HERE = Path(__file__).parent
SEED = 2020
SPEED = 1.0  # degrees per second
TWIST_RESOLUTION = 0.05  # degrees


class Loop(NamedTuple):
    """A test: what a fit has to find (stiffness in N m), the way in degrees over the beam, what the load cell does.

    ``step`` degrees between two readings; in N mm ``noise`` (standard deviation), ``drift`` of the zero during the test
    and ``resolution``.
    """

    beam: str
    model: str
    how: dict[str, Any]
    mu: float
    K_theta: float
    ends: list[float]
    step: float
    noise: float
    drift: float
    resolution: float
    fit: str


LOOPS = {
    # three cycles; the second stays in contact
    "measured_loop.csv": Loop(
        "pla_on_vps.toml", "edge law", {"joint": "hinge", "ideal": True, "points": 2000}, 0.31, 0.72,
        [0, 120, 0, 150, 60, 172, 0], 3.0, 15.0, 4.0, 5.0, "--joint hinge",
    ),
    "stiff_skin_loop.csv": Loop(
        "stiff_skin.toml", "its 25 scales with free ends, kept straight by a guide",
        {"points": 200, "hold": "bend, lateral bend"}, 0.31, 0.105,
        [0, 110, 0, 130, 90, 135, 0], 2.0, 0.1, 0.05, 0.02,
        "--set 'beam.hold=\"bend, lateral bend\"'",
    ),
}  # fmt: skip

HEADER = """\
# SYNTHETIC data, not a real test: made by examples/make_measured_loop.py, seed {seed}
# A beam as in examples/{o.beam} in twisting, three cycles, twisted by hand wheel at about {speed:g} deg/s.
# The model of squama ({o.model}) with mu = {o.mu} and K_theta = {o.K_theta} N m, and on its torque noise of \
{o.noise:g} N mm,
# a zero that drifts by {o.drift:g} N mm in all, and steps of {o.resolution:g} N mm; the twist is read in steps of \
{resolution} deg.
# Fit it with: squama fit {name} {o.beam} {o.fit}
# At each reversal there is a second reading, taken while the scales stick: its torque lies between both branches.
time (s),total twist (deg),torque (N mm)
"""


def make(name: str) -> str:
    """Return the text of a file."""
    o, rng = LOOPS[name], np.random.default_rng(SEED)
    beam = squama.Beam.from_toml(HERE / o.beam).replace(friction={"mu": o.mu}, joint={"stiffness": o.K_theta})
    history = ", ".join(f"{end}" for end in o.ends) + " deg total"
    true = squama.cycle(beam, history, **o.how)
    total, torque = np.degrees(true.Phi.values * beam.length), 1e3 * true["T"].values
    # every way begins and ends with a turning point, which stands twice in a cycle
    readings = []
    for leg, (start, stop) in enumerate(itertools.pairwise(o.ends), start=1):
        way = true.leg.values == leg
        n = int(abs(stop - start) / o.step)
        wanted = np.linspace(start, stop, n + 1)[1:-1] + rng.uniform(-0.2, 0.2, n - 1) * o.step
        wanted = np.append(wanted, stop)
        order = np.argsort(total[way], kind="stable")
        exact = np.interp(wanted, total[way][order], torque[way][order])
        if leg > 1:
            before = readings[-1]
            after = float(np.interp(start, total[way][order], torque[way][order]))
            readings.append((before[0], before[1] + rng.uniform(0.3, 0.9) * (after - before[1])))
        readings += zip(wanted.tolist(), exact.tolist(), strict=True)
    twist, exact = np.array(readings).T
    time = np.concatenate([[0.0], np.cumsum(np.maximum(np.abs(np.diff(twist)), 0.5))]) / SPEED
    read = exact + rng.normal(0, o.noise, exact.size) + o.drift * (time / time[-1] - 0.5)
    twist = TWIST_RESOLUTION * np.round(twist / TWIST_RESOLUTION)
    read = o.resolution * np.round(read / o.resolution)
    digits = 0 if o.resolution >= 1 else 2
    rows = [f"{t:.1f},{a:.2f},{m:.{digits}f}\n" for t, a, m in zip(time, twist, read + 0.0, strict=True)]
    return HEADER.format(name=name, seed=SEED, speed=SPEED, resolution=TWIST_RESOLUTION, o=o) + "".join(rows)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    for name in LOOPS:
        (folder / name).write_text(make(name), encoding="utf-8", newline="")
