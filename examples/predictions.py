"""What each model predicts for the test that would decide between them: docs/howto/decide.md.

Torque in the sense in which the scales touch (T+) at three twists, its ratio to that in the other sense (T-) with a
band, and the loss factor of a loop; then ratios of two specimens.
"""

import numpy as np

import squama

skin = squama.Beam.from_toml("examples/stiff_skin.toml")
CASES = {
    f"{n} scales, {ends}": (skin.replace(scales=n), {"ends": ends}) for ends in ("couple", "gripped") for n in (12, 25)
} | {
    "endless, free to bow": (skin, {"ends": "endless"}),
    "endless, held straight": (skin.replace(hold="bend, lateral bend"), {"ends": "endless"}),
    "hinges, thick scales": (skin, {"joint": "hinge", "ideal": False}),
    "hinges, thin scales": (skin, {"joint": "hinge", "ideal": True}),
}
PAIRS = (
    ("25 scales, couple", "12 scales, couple"),
    ("25 scales, gripped", "12 scales, gripped"),
    ("12 scales, gripped", "12 scales, couple"),
    ("25 scales, gripped", "25 scales, couple"),
)
CHANGES = (
    {"scale": {"alpha": "51 deg"}},
    {"scale": {"theta0": "21 deg"}},
    {"scale": {"thickness": "1.7 mm"}},
    {"friction": {"mu": 0.28}},
)
"""Tolerances, one standard deviation each."""
LAW = 0.045
"""Error of the joint's law, as a share of what the scales contribute."""
TWISTS = np.array([0.06, 0.08, 0.1])
"""Twists, rad per pitch."""


def torques(name, sense="+", **change):
    """Return the torques (N m) of a case at the twists, with dimensions that are changed."""
    beam, how = CASES[name]
    beam = beam.replace(**change)
    return squama.twist(beam, at=TWISTS / beam.pitch, sense=sense, **how)["T"].values


def ratio(name, **change):
    """Return T+/T- of a case at the last twist."""
    return torques(name, **change)[-1] / torques(name, "-", **change)[-1]


def band(value, changed, law=0.0):
    """Return the root of the sum of squares of the changes of a value, with the error of the law."""
    return np.linalg.norm([*(x - value for x in changed), law])


def main():
    """Print both tables."""
    print(f"{'T+ (N mm) at rad/pitch:':24}  0.06   0.08    0.1         T+/T-   loss factor")
    found = {}
    for name, (beam, how) in CASES.items():
        value = ratio(name)
        text = f"{value:.2f}"
        if "hinges" not in name:
            changed = [ratio(name, **change) for change in CHANGES]
            found[name] = value, changed
            text += f" +- {band(value, changed, LAW * (value - 1)):.2f}"
        loss = 2 * float(squama.cycle(beam, "0.1 rad/pitch", points=30, **how).zeta_eq.squeeze())
        print(f"{name:24}", *(f"{1e3 * T:6.2f}" for T in torques(name)), f"{text:>15}", f"{loss:10.3f}")
    print("\nT+/T- of two specimens")
    for over, under in PAIRS:
        (a, others), (b, more) = found[over], found[under]
        spread = band(a / b, [x / y for x, y in zip(others, more, strict=True)])
        print(f"{f'{over} / {under}':42}{a / b:.2f} +- {spread:.2f}")


if __name__ == "__main__":
    main()
