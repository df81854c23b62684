"""`squama.gradient`: against central differences at every kind of end, exact identities, names, JAX."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import squama
from properties.designs import many, mirrored
from squama.arrays.derivatives import OUTPUTS, PARAMETERS

PAPER = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": math.pi / 4, "theta0": math.radians(10), "mu": 0.5}
MARGIN = 0.1
STEPS = (1e-3, 5e-4, 2.5e-4)
CASES = {
    "edge": (many(700, 21), {"law": "edge"}),
    "plate": (many(500, 22), {"law": "plate"}),
    "edge, other sense": (mirrored(400, 23), {"law": "edge", "sense": "-"}),
    "plate, other sense": (mirrored(300, 24), {"law": "plate", "sense": "-"}),
    "bending": (many(300, 25) | {"eta": np.linspace(0.9, 8, 300)}, {"load": "bending"}),
    "neighbours": ({}, {"law": "edge", "sense": "-"}),
}
"""Designs by name, and the settings they are solved with."""
ENDS = {
    "edge": {
        "frictional lock",
        "kinematic lock",
        "static lock",
        "off tip edge",
        "off side edge",
        "other contact",
        "released",
        "range end",
        "no engagement",
    },
    "plate": {"frictional lock", "off tip edge", "other contact", "static lock"},
    "bending": {"frictional lock", "kinematic lock (line contact)", "static lock", "no engagement"},
    "neighbours": {"off side edge", "other contact"},
}
"""Ends that must occur among the designs whose derivatives are compared."""


def far_first(n: int, seed: int) -> dict[str, np.ndarray]:
    """Designs that engage with a farther neighbour first when they are twisted the other way."""
    drawn = {name: np.concatenate([mirrored(4000, seed + i)[name] for i in range(4)]) for name in mirrored(1, 0)}
    found = np.flatnonzero(squama.solve(**drawn, sense="-").neighbour > 1)[:n]
    return {name: v[found] for name, v in drawn.items()}


def differences(
    columns: dict[str, Any], name: str, margin: float, **settings: Any
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], np.ndarray]:
    """Central differences, extrapolated twice; what the last extrapolation changed; where the ends stay the same."""
    base = squama.solve(**columns, **settings, margin=margin)
    value = np.full(base.code.shape, margin) if name == "margin" else columns[name]
    same = value > 0

    def moved(by: float) -> squama.Solved:
        if name == "margin":
            return squama.solve(**columns, **settings, margin=margin * (1 + by))
        return squama.solve(**(columns | {name: value * (1 + by)}), **settings, margin=margin)

    slopes = []
    for h in STEPS:
        up, down = moved(h), moved(-h)
        for s in (up, down):
            same = same & (s.code == base.code) & (s.neighbour == base.neighbour)
        with np.errstate(all="ignore"):
            slopes.append({o: (getattr(up, o) - getattr(down, o)) / (2 * h * value) for o in OUTPUTS})
    first, second, third = slopes
    best, change = {}, {}
    for o in OUTPUTS:
        with np.errstate(all="ignore"):
            once, again = (4 * second[o] - first[o]) / 3, (4 * third[o] - second[o]) / 3
            best[o] = (16 * again - once) / 15
            # how large a derivative is in the measure of its output and its parameter
            scale = np.abs(best[o]) + np.abs(getattr(base, o) / value) + 1e-6
            change[o] = np.abs(again - once) / scale
        best[o + " scale"] = scale
    return best, change, same


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("case", CASES)
def test_derivatives_are_those_of_central_differences(case: str) -> None:
    columns, settings = CASES[case]
    columns = columns or far_first(60, 3)
    n = columns["eta"].size
    r = np.random.default_rng(1)
    columns = columns | {"stiffness_ratio": r.choice([0.0, 1.0], n) * r.uniform(1, 50, n)}
    g = squama.gradient(**columns, **settings, margin=MARGIN)
    assert g.array.shape == (len(OUTPUTS), len(PARAMETERS), n)
    seen = set()
    # the spring is at rest where the contact opens again: differences of zeros are noise
    released = g.end == "released"
    for name in PARAMETERS:
        assert np.abs(g["f0", name][released]).max(initial=0) < 1e-10
        beam = columns["stiffness_ratio"] * g["load_c", name]
        if name != "stiffness_ratio":
            assert g["torque", name][released] == pytest.approx(beam[released], rel=1e-9, abs=1e-10)
        best, change, same = differences(columns, name, MARGIN, **settings)
        for o in OUTPUTS:
            sure = same & (change[o] < 1e-5) & ~(released & (o in ("f0", "torque")))
            wrong = np.abs(g[o, name] - best[o]) > 1e-6 * best[o + " scale"]
            assert not (sure & wrong).any(), (o, name, np.flatnonzero(sure & wrong), g.end[sure & wrong])
            none = np.array(g.end) == "no engagement"
            unsure = same & ~none & ~released & (change[o] >= 1e-5)
            assert unsure.sum() <= 0.03 * n, (o, name)
            seen |= set(g.end[sure])
            if o in ("load_e", "load_end"):
                assert np.isnan(g[o, name][none]).all()
            else:
                assert np.isfinite(g[o, name]).all()
        seen |= set(g.end[g.end == "no engagement"])
    assert ENDS.get(case, set()) <= seen


@pytest.mark.parametrize("margin", [1e-2, 1e-4, 1e-8])
@pytest.mark.parametrize("law", ["edge", "plate"])
def test_near_the_pole(law: str, margin: float) -> None:
    """Close to the lock f0 is R/(margin x_e) plus terms that stay, R the residue: it falls as 1/margin."""
    g = squama.gradient(**PAPER, law=law, margin=margin)
    s = squama.solve(**PAPER, law=law, margin=margin)
    # tolerance: what stays beside the pole is as large as the margin; 1e-7 of rounding
    assert g["f0", "margin"] * margin == pytest.approx(-s.f0, rel=3 * margin + 1e-7)
    # the frictional work grows by the same amount with every factor of the margin: only its bound moves
    if margin < 1e-3:
        up, down = (squama.solve(**PAPER, law=law, margin=margin * e) for e in (2.0, 0.5))
        assert g["W_fr", "margin"] * margin == pytest.approx((up.W_fr - down.W_fr) / math.log(4), rel=3 * margin + 1e-7)
    assert g["theta_end", "margin"] == 0


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_exact_identities(law: str) -> None:
    columns = many(400, 31)
    g = squama.gradient(**columns, law=law, stiffness_ratio=2.0)
    s = squama.solve(**columns, law=law, stiffness_ratio=2.0)
    end, locks = s.end, np.isin(s.end, ["frictional lock", "kinematic lock"])
    met = s.end != "no engagement"
    # engagement knows nothing of friction, stiffness and margin
    for name in ("mu", "stiffness_ratio", "margin"):
        assert not g["load_e", name][met].any()
        assert not g["theta_end", name][end != "frictional lock"].any() or name == "mu"
    # the end is where it is whatever the rigidity; that adds its part to torque and energy
    for o in ("theta_end", "load_end", "theta_c", "load_c", "f0", "W_fr"):
        assert not g[o, "stiffness_ratio"][met].any()
    assert g["torque", "stiffness_ratio"] == pytest.approx(s.load_c, rel=1e-13)
    assert g["U_el", "stiffness_ratio"] == pytest.approx(s.load_c**2 / 2, rel=1e-13)
    # the margin moves the cut-off of locks only
    assert g["theta_c", "margin"] == pytest.approx(np.where(locks, g["theta_c", "margin"], 0), abs=0)
    # a frictional lock does not know where the scales began, once the path is fixed: D has no theta0 in it
    lock = end == "frictional lock"
    assert np.abs(g["theta_end", "theta0"][lock]).max() < 1e-9
    # no path: the scales rest
    static = end == "static lock"
    assert (g["theta_end", "theta0"][static | ~met] == 1).all()
    assert g["load_end", "eta"][static] == pytest.approx(g["load_e", "eta"][static])
    # RED is made of the two energies
    total = s.U_el + s.W_fr
    for name in PARAMETERS:
        red = (g["W_fr", name] * s.U_el - s.W_fr * g["U_el", name])[met] / total[met] ** 2
        # each work by a rule of its own, which are good to 1e-9
        assert g["RED", name][met] == pytest.approx(red, rel=3e-8, abs=2e-10)


def test_torque_is_the_derivative_of_the_work_done() -> None:
    """Virtual work, for the edge law: along the path (moved by the margin) dU_el + dW_fr = torque d(load)."""
    columns = many(300, 32)
    s = squama.solve(**columns, stiffness_ratio=1.5)
    g = squama.gradient(**columns, stiffness_ratio=1.5, wrt="margin")
    work = g["U_el", "margin"] + g["W_fr", "margin"]
    assert work == pytest.approx(s.torque * g["load_c", "margin"], rel=1e-10, abs=1e-14)


def test_without_friction_work_begins_with_mu() -> None:
    g = squama.gradient(**(PAPER | {"mu": 0.0}), of=["W_fr", "theta_end"], wrt=["mu", "eta"])
    h = 1e-6
    a, b = (squama.solve(**(PAPER | {"mu": m})) for m in (h, 2 * h))
    assert g["W_fr", "mu"] == pytest.approx((4 * a.W_fr - b.W_fr) / (2 * h), rel=1e-6)
    zero = squama.solve(**(PAPER | {"mu": 0.0}))
    ahead = (4 * a.theta_end - b.theta_end - 3 * zero.theta_end) / (2 * h)
    assert g["theta_end", "mu"] == pytest.approx(ahead, rel=1e-6)
    assert g["W_fr", "eta"] == 0


def test_names_shapes_and_choice() -> None:
    mu = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 20.0]])
    g = squama.gradient(**(PAPER | {"mu": mu}), of="RED", wrt=["mu", "alpha"])
    assert g.of == ("RED",)
    assert g.wrt == ("mu", "alpha")
    assert g.array.shape == (1, 2, 2, 3)
    assert g.end[1, 2] == "static lock"
    everything = squama.gradient(**(PAPER | {"mu": mu}))
    np.testing.assert_allclose(g["RED", "alpha"], everything["RED", "alpha"], rtol=1e-10)
    few = squama.gradient(**(PAPER | {"mu": mu}), of=["torque"])
    np.testing.assert_allclose(few["torque", "theta0"], everything["torque", "theta0"], rtol=1e-10)
    bend = squama.gradient(**(PAPER | {"alpha": 0.0}), load="bending", of="W_fr", wrt="beta")
    assert not bend["W_fr", "beta"].any()


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"of": "phi"}, 'of = "phi": must be "load_e" or'),
        ({"wrt": ["eta", "nu"]}, 'wrt = "nu": must be "eta" or'),
        ({"law": "soft"}, 'law = "soft"'),
        ({"load": "pulling"}, 'load = "pulling"'),
        ({"margin": 0}, "margin = 0"),
        ({"eta": -1}, "eta = -1"),
    ],
)
def test_bad_input(wrong: dict[str, Any], text: str) -> None:
    with pytest.raises(squama.InputError) as caught:
        squama.gradient(**(PAPER | wrong))
    assert str(caught.value).startswith(text)
    assert "\n" not in str(caught.value)


def test_unknown_names_of_a_result() -> None:
    g = squama.gradient(**PAPER, of="RED", wrt="mu")
    with pytest.raises(squama.InputError, match='output = "W_fr"'):
        g["W_fr", "mu"]
