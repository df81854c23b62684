"""Make examples/measured_loop.csv: what a twisting test of the beam pla_on_vps.toml could give. It is not a real test.

Run it from the repository: python examples/make_measured_loop.py [file to write]
"""

import itertools
import sys
from pathlib import Path

import numpy as np

import squama

HERE = Path(__file__).parent
SEED = 2020
MU, K_THETA = 0.31, 0.72  # what a fit has to find; the stiffness in N m
ENDS = [0, 120, 0, 150, 60, 172, 0]  # three cycles, degrees over the whole beam; the second stays in contact
STEP = 3.0  # degrees between two readings
SPEED = 1.0  # degrees per second
NOISE = 15.0  # N mm, standard deviation of the load cell's noise
DRIFT = 4.0  # N mm, what the zero of the load cell drifts during the test
TWIST_RESOLUTION, TORQUE_RESOLUTION = 0.05, 5.0  # degrees, N mm

HEADER = f"""\
# SYNTHETIC data, not a real test: made by examples/make_measured_loop.py, seed {SEED}
# A beam as in examples/pla_on_vps.toml in twisting, three cycles, twisted by hand wheel at about {SPEED:g} deg/s.
# The model of squama (edge law) with mu = {MU} and K_theta = {K_THETA} N m, and on its torque noise of {NOISE:g} N mm,
# a zero that drifts by {DRIFT:g} N mm in all, and steps of {TORQUE_RESOLUTION:g} N mm; the twist is read in steps of \
{TWIST_RESOLUTION} deg.
# At each reversal there is a second reading, taken while the scales stick: its torque lies between both branches.
time (s),total twist (deg),torque (N mm)
"""


def make() -> str:
    """Return the text of the file."""
    rng = np.random.default_rng(SEED)
    beam = squama.Beam.from_toml(HERE / "pla_on_vps.toml").replace(friction={"mu": MU}, joint={"stiffness": K_THETA})
    history = ", ".join(f"{end}" for end in ENDS) + " deg total"
    true = squama.cycle(beam, history, points=2000, joint="hinge", ideal=True)
    total, torque = np.degrees(true.Phi.values * beam.length), 1e3 * true["T"].values
    # every way begins and ends with a turning point, which stands twice in a cycle
    readings = []
    for leg, (start, stop) in enumerate(itertools.pairwise(ENDS), start=1):
        way = true.leg.values == leg
        n = int(abs(stop - start) / STEP)
        wanted = np.linspace(start, stop, n + 1)[1:-1] + rng.uniform(-0.2, 0.2, n - 1) * STEP
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
    read = exact + rng.normal(0, NOISE, exact.size) + DRIFT * (time / time[-1] - 0.5)
    twist = TWIST_RESOLUTION * np.round(twist / TWIST_RESOLUTION)
    read = TORQUE_RESOLUTION * np.round(read / TORQUE_RESOLUTION)
    rows = [f"{t:.1f},{a:.2f},{m:.0f}\n" for t, a, m in zip(time, twist, read + 0.0, strict=True)]
    return HEADER + "".join(rows)


if __name__ == "__main__":
    place = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "measured_loop.csv"
    place.write_text(make(), encoding="utf-8", newline="")
