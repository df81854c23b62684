"""cases.json: 60 designs by the oracle; folded and mirrored paths, farther neighbours, work, plates."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import squama
from oracle.plates import CORNERS, EDGES
from oracle.vectors import MP, Design, cross, dot, norm, scale, sub
from properties.designs import Drawn, Followed, balance, follow
from squama.model import energy, mechanics
from squama.model.paths import FLOAT, FoldedTwist

RECORD = json.loads((Path(__file__).parent / "cases.json").read_text(encoding="utf-8"))
CASES = RECORD["cases"]
LAWS = ("plate", "edge")
ENDS = {
    "friction": "frictional lock",
    "kinematic": "kinematic lock",
    "edge-tip": "off tip edge",
    "edge-side": "off side edge",
    "return": "released",
    "half-turn": "range end",
    "none": "no engagement",
}
each_case = pytest.mark.parametrize("case", CASES, ids=[f"{i}-{c['kind']}" for i, c in enumerate(CASES)])
each_law = pytest.mark.parametrize("law", LAWS)


def near(got: Any, want: Any, tol: float = 1e-10, floor: float = 0.0) -> bool:
    got, want = float(got), float(want)
    return got == want or abs(got - want) <= tol * max(abs(want), floor)


def drawn(case: dict[str, Any]) -> Drawn:
    alpha, theta0 = (math.radians(case[n]) for n in ("alpha_deg", "theta0_deg"))
    return Drawn(case["eta"], case["beta"], case["lam"], alpha, theta0, case["mu"])


def sense(case: dict[str, Any]) -> str:
    return "+" if case["sense"] > 0 else "-"


def end_of(case: dict[str, Any], law: str) -> str:
    want = case[law]
    if want["neighbour"] is not None:
        return "other contact"
    if want["end"] == "friction" and want["phi_end"] == case["phi_e"]:
        return "static lock"
    if case["mu"] == 0 and law == "edge" and want["end"] == "friction":
        return "kinematic lock"
    return ENDS[want["end"]]


@each_law
@each_case
def test_end(case: dict[str, Any], law: str) -> None:
    d, want = drawn(case), case[law]
    e = squama.ends(**d.ratios, theta0=d.theta0, mu=d.mu, law=law, sense=sense(case))
    assert (str(e.end), int(e.neighbour)) == (end_of(case, law), case["k"])
    assert near(e.phi_e, case["phi_e"])
    last = want["neighbour"] or {"theta": want["theta_end"], "phi": want["phi_end"]}
    assert near(e.theta_end, last["theta"])
    assert near(e.phi_end, last["phi"])
    assert str(e.other).endswith(f"(k = {want['neighbour']['k']})" if want["neighbour"] else "")
    f = follow(d, law, sense(case))
    assert (f is None) == (case["k"] == 0)
    if want["fold"] is not None:
        assert f is not None
        assert isinstance(f.row, FoldedTwist)
        assert near(f.row.theta_f, want["fold"]["theta"])
        assert near(f.row.point(0.0, law, FLOAT).load, want["fold"]["phi"])


@each_law
@pytest.mark.parametrize("case", [c for c in CASES if "mid" in c["edge"] or "mid" in c["plate"]])
def test_state_half_way(case: dict[str, Any], law: str) -> None:
    if "mid" not in case[law]:
        assert end_of(case, law) == "static lock"
        return
    d, mid = drawn(case), case[law]["mid"]
    theta = float(mid["theta"])
    f = follow(d, law, sense(case))
    assert f is not None
    folded = isinstance(f.row, FoldedTwist)
    pt = f.row.point(-math.sqrt(f.row.theta_f - theta) if folded else theta, law, FLOAT)
    b = balance(pt, d)
    got = {
        "theta": pt.theta,
        "phi": pt.load,
        "dphi_dtheta": pt.load_rate / pt.theta_rate,
        "dr_dtheta": pt.slip_rate / pt.theta_rate,
        "dr_dphi": pt.slip_rate / pt.load_rate,
        "N0": b.N * d.eta,
        "f0": b.f * d.eta,
        "torque_energy": b.torque,
        "mu_lock": mechanics.mu_lock(pt),
    }
    wrong = {name: (value, mid[name]) for name, value in got.items() if not near(value, mid[name])}
    assert not wrong
    assert near(pt.p, mid["p"], floor=0.1)
    assert near(pt.s, mid["s"], floor=0.1)
    # the same through the public functions, which take the first branch
    at = {**d.ratios, "sense": sense(case), "neighbour": case["k"]}
    c = squama.contact(theta, **at)
    assert near(c.phi, mid["phi"])
    assert near(c.p, mid["p"], floor=0.1)
    assert near(c.s, mid["s"], floor=0.1)
    for got_rate, name, sign in (
        (c.dphi_dtheta, "dphi_dtheta", 1),
        (c.ds_dtheta, "da_dtheta", -1),
        (c.dp_dtheta, "dc_dtheta", 1),
    ):
        assert near(sign * got_rate, mid[name], floor=0.1)
    g = squama.forces(theta, **at, theta0=d.theta0, mu=d.mu, law=law)
    for got_force, name in zip(g, ("N0", "f0", "torque_energy", "mu_lock", "dr_dtheta"), strict=True):
        assert near(got_force, mid[name])


def cut(f: Followed, want: dict[str, Any], d: Drawn) -> float:
    """Path parameter of the recorded cut-off, as the theory has it; the package's own must be the same."""
    margin, lock = float(RECORD["margin"]), f.end.endswith("lock")
    if not lock:
        x = f.x_end
    elif want["fold"] is not None:
        x = f.x0 + (1 - margin) * (f.x_end - f.x0)
    else:
        x = float(f.row.parameter(d.theta0 + (1 - margin) * (f.theta_end - d.theta0), FLOAT))
    row = type(f.row)(*(np.array([v]) for v in f.row))
    got = energy.cutoff(row, np.array([f.x0]), np.array([f.x_end]), np.array([lock]), margin)
    assert near(got[0], x)
    return x


@each_law
@pytest.mark.parametrize("case", [c for c in CASES if "work" in c["edge"] or "work" in c["plate"]])
def test_work(case: dict[str, Any], law: str) -> None:
    want = case[law]
    if "work" not in want:
        return
    d = drawn(case)
    f = follow(d, law, sense(case))
    assert f is not None
    x = cut(f, want, d)
    if want["neighbour"] is None:
        assert near(f.row.theta(x), want["work"]["theta_c"])
        assert near(f.row.point(x, law, FLOAT).load, want["work"]["phi_c"])
    recorded = want["work" if want["neighbour"] is None else "work_to_neighbour"]
    series = energy.work(f.row, f.x0, x, f.pole, d.mu, law)
    assert near(series(x), recorded["W"], 1e-9)
    assert near((f.row.theta(x) - d.theta0) ** 2 / 2, recorded["spring"], floor=1e-3)
    # and by the whole chain, where no plates come in before
    if case["plates"] is not None and float(case["plates"]["phi"]) <= f.load_end:
        return
    beam = squama.Beam.from_ratios(
        eta=d.eta, beta=d.beta, lam=d.lam, alpha=d.alpha, theta0=d.theta0, zeta=0.01, width="1 m"
    )
    r = squama.twist(beam, mu=d.mu, law=law, sense=sense(case), points=3, joint="hinge")
    assert r.end.item() == end_of(case, law)
    assert near(r.W_fr_c * beam.pitch / beam.joint_stiffness, recorded["W"], 1e-9)
    assert near(r.theta_c, want["work"]["theta_c"])


FACE = re.compile(r"corner ([ABCD])(\d+) on the face of scale (\d+) \(k = (\d+)\)")
EDGE = re.compile(r"\w+ edge ([ABCD])(\d+)([ABCD])\2 on \w+ edge ([ABCD])(\d+)([ABCD])\5 \(k = (\d+)\)")
MIRROR = str.maketrans("ABCD", "DCBA")


def pair_of(words: str) -> tuple[int, list[str]]:
    """Return k and the pair as the oracle names it."""
    if m := FACE.fullmatch(words):
        corner, its, face, k = m.groups()
        assert {int(its), int(face)} == {1, 1 + int(k)}
        return int(k), ["corner-face", corner, "face"] if its == "1" else ["corner-face", "face", corner]
    m = EDGE.fullmatch(words)
    assert m, words
    one, first, two, three, last, four, k = m.groups()
    assert (first, int(last)) == ("1", 1 + int(k))
    names = {frozenset(e): e for e in EDGES}
    return int(k), ["edge-edge", names[frozenset(one + two)], names[frozenset(three + four)]]


def distance(d: Design, words: str, theta: float, phi: float) -> Any:
    """Distance between the named features' plane and corner, or lines, by plain vectors."""
    k, (kind, a, b) = pair_of(words)
    one, two = (scale(MP, d, MP.mpf(theta), MP.mpf(phi), j) for j in (0, k))
    if kind == "corner-face":
        corner, plate = (getattr(one, a), two) if b == "face" else (getattr(two, b), one)
        return dot(sub(corner, plate.base), plate.z)
    ends = [[getattr(s, c) for c in e] for s, e in ((one, a), (two, b))]
    directions = [sub(e[1], e[0]) for e in ends]
    n = cross(*directions)
    return dot(sub(ends[0][0], ends[1][0]), n) / norm(MP, n)


@each_case
def test_first_contact_of_the_plates(case: dict[str, Any]) -> None:
    d, want = drawn(case), case["plates"]
    tip = squama.ends(**d.ratios, theta0=d.theta0, mu=d.mu, sense=sense(case))
    e = squama.ends(**d.ratios, theta0=d.theta0, mu=d.mu, sense=sense(case), contacts="all")
    assert e.phi_e == tip.phi_e
    if want is None or (np.isfinite(tip.phi_end) and float(want["phi"]) > tip.phi_end):
        assert e.end == tip.end
        assert e.phi_end == tip.phi_end
        assert str(e.other) == str(tip.other)
        return
    k, pair = pair_of(str(e.other))
    if sense(case) == "-":
        # the oracle names the features of the mirror image
        names = {frozenset(x): x for x in EDGES}
        swap = {c: c.translate(MIRROR) for c in CORNERS} | {x: names[frozenset(x.translate(MIRROR))] for x in EDGES}
        pair = [swap.get(x, x) for x in pair]
    assert (k, pair) == (want["k"], want["pair"])
    if tip.neighbour == 0:
        assert str(e.end) == "no engagement"
        assert e.phi_end == np.inf
        return
    assert str(e.end) == "other contact"
    # tolerance: first contacts of plates are recorded to 1e-6
    assert near(e.theta_end, want["theta"], 3e-6)
    assert near(e.phi_end, want["phi"], 3e-6)
    rigid = Design(d.eta, MP.mpf(d.alpha), d.beta, d.lam, d.theta0, case["sense"])
    assert abs(distance(rigid, str(e.other), float(e.theta_end), float(e.phi_end))) < 1e-12
