"""`squama.solve` on many designs against one design at a time, and against what energies and torques must be."""

from __future__ import annotations

import functools
import math
from collections import Counter

import numpy as np
import pytest

import squama
from properties.designs import balance, each, follow, many, mirrored
from squama.arrays import solution
from squama.errors import InputError
from squama.model import energy, neighbours
from squama.model.paths import ARRAY, FLOAT, FoldedTwist, Twist

groups = pytest.mark.parametrize(
    ("columns", "sense", "law"),
    [(many(90, 61), "+", "edge"), (many(90, 62), "+", "plate"), (mirrored(60, 63), "-", "edge")],
    ids=["edge", "plate", "mirrored"],
)


@groups
def test_many_are_each(columns: dict[str, np.ndarray], sense: str, law: str) -> None:
    ratio = np.linspace(0.0, 3.0, columns["mu"].size)
    margin = 0.03
    s = squama.solve(**columns, stiffness_ratio=ratio, sense=sense, law=law, margin=margin)
    seen: Counter[str] = Counter()
    for i, d in enumerate(each(columns)):
        f = follow(d, law, sense)
        if f is None:
            assert (s.end[i], s.neighbour[i], s.load_e[i], s.RED[i]) == ("no engagement", 0, math.inf, 0)
            continue
        assert (s.end[i], s.neighbour[i]) == (f.end, f.k)
        for name, want in (("load_e", f.load_e), ("load_end", f.load_end), ("theta_end", f.theta_end)):
            assert getattr(s, name)[i] == pytest.approx(want, rel=1e-12)
        seen[f.end] += 1
        if f.x_end <= f.x0:
            assert (s.theta_c[i], s.load_c[i], s.f0[i], s.W_fr[i]) == (d.theta0, s.load_e[i], 0, 0)
            continue
        x = f.x_end
        if f.end in ("frictional lock", "kinematic lock"):
            # a fraction of the inclination, or of the path parameter where a fold was passed
            if isinstance(f.row, FoldedTwist) and f.x_end > 0:
                x = f.x0 + (1 - margin) * (f.x_end - f.x0)
                seen["margin beyond a fold"] += 1
            else:
                theta_c = d.theta0 + (1 - margin) * (f.theta_end - d.theta0)
                assert s.theta_c[i] == pytest.approx(theta_c, rel=1e-12)
                x = float(f.row.parameter(theta_c, FLOAT))
                seen["margin before a fold"] += isinstance(f.row, FoldedTwist)
        pt = f.row.point(x, law, FLOAT)
        b = balance(pt, d)
        for name, want in (
            ("theta_c", pt.theta),
            ("load_c", pt.load),
            ("f0", b.f * d.eta),
            ("torque", b.torque + ratio[i] * pt.load),
            ("U_el", (ratio[i] * pt.load**2 + (pt.theta - d.theta0) ** 2) / 2),
        ):
            assert getattr(s, name)[i] == pytest.approx(want, rel=1e-8, abs=1e-12), (name, d)
        work = float(energy.work(f.row, f.x0, x, f.pole, d.mu, law)(x))
        assert s.W_fr[i] == pytest.approx(work, rel=2e-9, abs=1e-300)
        total = work + s.U_el[i]
        assert s.RED[i] == pytest.approx(work / total if total else 0.0, rel=1e-8)
    assert seen["frictional lock"] > (3 if sense == "+" else 0)
    if law == "plate":
        assert seen["margin beyond a fold"] > 0
        assert seen["margin before a fold"] > 0


def test_the_beam_and_the_array_function_agree() -> None:
    for kind, call in (
        ("twisting", functools.partial(squama.twist, joint="hinge")),
        ("bending", functools.partial(squama.bend, joint="hinge")),
    ):
        beam = squama.Beam.from_ratios(eta=4, theta0="8 deg", stiffness="30 N m")
        if kind == "twisting":
            rigidity, letters = beam.torsional_rigidity, ("phi", "Phi", "T")
        else:
            rigidity, letters = beam.bending_rigidity, ("psi", "kappa", "M")
        load, rate, torque = letters
        ratio = rigidity / (30 * beam.pitch)
        for mu in (0.3, 1.0):
            r = call(beam, mu=mu, margin=0.02)
            s = squama.solve(**beam.ratios, mu=mu, stiffness_ratio=ratio, margin=0.02, load=kind)
            assert (str(s.end), int(s.neighbour)) == (r.end.item(), r.neighbour.item())
            scale = 30 / beam.pitch
            pairs = [(s.load_e, r[f"{load}_e"]), (s.load_end, r[f"{load}_end"]), (s.theta_end, r.theta_end)]
            pairs += [
                (s.theta_c, r.theta_c),
                (s.load_c, r[f"{rate}_c"] * beam.pitch),
                (s.torque * 30, r[f"{torque}_c"]),
            ]
            pairs += [(s.U_el * scale, r.U_el_c), (s.W_fr * scale, r.W_fr_c), (s.RED, r.RED_c), (s.f0, r.f0[-1])]
            for got, want in pairs:
                assert float(got) == pytest.approx(float(want), rel=1e-9)


def test_work_is_linear_in_a_small_friction() -> None:
    """Also where the work is tiny: its accuracy is relative."""
    at = {"eta": 3, "beta": 1.25, "lam": 0.45, "alpha": math.radians(45), "theta0": math.radians(10)}
    mu = np.array([0.0, 1e-12, 1e-9, 1e-6])
    s = squama.solve(**at, mu=mu, margin=0.2)
    assert s.W_fr[0] == 0
    np.testing.assert_allclose(s.W_fr[1:] / mu[1:], s.W_fr[1] / mu[1], rtol=3e-5)
    assert s.W_fr[2] / s.W_fr[1] == pytest.approx(1000, rel=3e-8)


@pytest.mark.parametrize("sense", [1, -1])
def test_engagement_of_each_neighbour_is_a_contact_on_both_edges(sense: int) -> None:
    """Over many designs and all neighbours, whichever comes first."""
    columns = mirrored(4000, 64)
    row = Twist(
        *(columns[n] for n in ("eta", "beta", "lam")),
        sense * np.sin(columns["alpha"]),
        np.cos(columns["alpha"]),
        columns["theta0"],
    )
    alone = {n: columns[n] for n in ("eta", "beta", "lam", "alpha")}
    first = np.full(4000, np.inf)
    for k in range(1, 11):
        c = squama.contact(columns["theta0"], **alone, sense="+" if sense > 0 else "-", neighbour=k)
        with np.errstate(all="ignore"):
            sub = row._replace(k=float(k))
            on, phi = neighbours.engages(sub, ARRAY), neighbours.meets(sub, ARRAY)
        phi = np.where(on, phi, np.inf)
        clear = np.minimum.reduce([abs(abs(c.p) - columns["beta"]), abs(c.s), abs(c.s - columns["eta"])]) > 1e-9
        want = np.where(c.on_edges & (c.phi > 0), c.phi, np.inf)
        assert np.isfinite(want).sum() > (20 if k < 7 else -1)
        np.testing.assert_allclose(phi[clear | np.isnan(c.p)], want[clear | np.isnan(c.p)], rtol=1e-12)
        near = (abs(c.p) <= columns["beta"]) & (c.s > columns["eta"])
        assert np.all(np.isinf(phi[near & clear]))
        first = np.minimum(first, want)
    sol = solution.solve(columns, law="edge", sense="+" if sense > 0 else "-").found
    k, phi = sol.neighbour, sol.load_e
    np.testing.assert_allclose(phi, first, rtol=1e-12)
    assert np.all((k == 0) == np.isinf(phi))
    assert np.all(k <= neighbours.reach(row))


def test_bad_arguments() -> None:
    good = {"eta": 3, "beta": 1, "lam": 1, "alpha": 0.5, "theta0": 0.1, "mu": 0.2}
    for bad in (
        {"load": "twist"},
        {"margin": 0},
        {"stiffness_ratio": -1},
        {"law": "x"},
        {"sense": 1},
    ):
        with pytest.raises(InputError) as caught:
            squama.solve(**good, **bad)
        assert next(iter(bad)) in str(caught.value)
        assert "\n" not in str(caught.value)
