"""Write tests/reference/cases.json: run as `python -m oracle.make_cases [seed]` from tests/ (minutes)."""

from __future__ import annotations

import json
import multiprocessing
import random
import sys
import time
from pathlib import Path
from typing import Any

from .path import End, engagement, path_end, rigid_path
from .plates import first_contact
from .twisting import LAWS, contact, forces
from .vectors import MP, Design, Num
from .work import point, work

OUT = Path(__file__).parent.parent / "reference" / "cases.json"
MARGIN = "0.01"
KINDS = {
    "general": 20,
    "folded": 12,
    "return": 3,
    "small": 5,
    "static": 4,
    "none": 3,
    "frictionless": 4,
    "mirrored": 7,
    "mirrored-none": 2,
}


def draw(r: random.Random, kind: str) -> dict[str, Any]:
    """Draw one design of a kind (not every draw is of that kind yet: see `fits`)."""
    low = kind in {"folded", "return"}
    log_theta = 10 ** r.uniform(-1, 1.3)
    mu = {"static": r.uniform(4, 10), "frictionless": 0.0, "folded": r.uniform(0, 0.6)}
    return {
        "kind": kind,
        "eta": round(r.uniform(1.2, 8), 3),
        "alpha_deg": round(r.uniform(1, 14) if low else r.uniform(1, 85), 2),
        "beta": round(r.uniform(0.3, 2), 3),
        "lam": round(r.uniform(0.2, 1), 3),
        "theta0_deg": 0.1 if kind == "small" else round(r.uniform(3, 20) if low else log_theta, 2),
        "mu": round(mu.get(kind, r.choice([r.uniform(0, 1), r.uniform(0, 3)])), 3),
        "sense": -1 if kind.startswith("mirrored") else 1,
    }


def design(case: dict[str, Any]) -> Design:
    """Return the 30-digit design of a case (k not yet found)."""
    names = ("eta", "alpha_deg", "beta", "lam", "theta0_deg", "sense")
    return Design.of(*(case[n] for n in names))


def fits(case: dict[str, Any]) -> bool:
    """Whether a draw is of its kind."""
    d, mu, kind = design(case), MP.mpf(str(case["mu"])), case["kind"]
    if kind.endswith("none"):
        return engagement(d) is None
    e = path_end(d, mu, "edge", digits=False)
    wanted = {
        "folded": e.theta_f is not None,
        "return": e.kind == "return",
        "static": e.kind == "friction" and e.theta == d.theta0,
    }
    return e.kind != "none" and wanted.get(kind, True)


def text(x: Num) -> str:
    return MP.nstr(MP.mpf(x), 17)


def solve(d: Design, mu: Num, law: str) -> dict[str, Any]:
    """Everything recorded for one design and one law."""
    e = path_end(d, mu, law)
    out: dict[str, Any] = {"end": e.kind, "theta_end": text(e.theta), "phi_end": text(e.phi)}
    out["fold"] = None if e.theta_f is None else {"theta": text(e.theta_f), "phi": text(e.phi_f)}
    n = e.neighbour
    out["neighbour"] = None if n is None else {"k": n.k, "theta": text(n.theta), "phi": text(n.phi)}
    if e.kind == "none" or e.phi == e.phi_e:
        return out
    dk = d.with_k(e.k)
    out["mid"] = mid(dk, mu, law, e)
    w = work(dk, mu, law, e, MARGIN)
    out["work"] = {k: text(getattr(w, k)) for k in ("theta_c", "phi_c", "W", "spring")}
    if n is not None:
        w = work(dk, mu, law, e, MARGIN, upto_neighbour=True)
        out["work_to_neighbour"] = {k: text(getattr(w, k)) for k in ("W", "spring")}
    return out


def mid(d: Design, mu: Num, law: str, e: End) -> dict[str, str]:
    """State half way along the path; at .4 where half way is the fold (rates per theta are infinite)."""
    fraction = "0.4" if e.kind == "return" else "0.5"
    t, q = point(d, e, MP.mpf(fraction))
    c, f = contact(t, q, d, law), forces(t, q, d, law, mu)
    state = {"theta": t, "phi": q, **vars(c), **vars(f)}
    return {"fraction": fraction} | {k: text(v) for k, v in state.items()}


def fill(case: dict[str, Any]) -> dict[str, Any]:
    """Solve a case by both laws, and look for the first other contact of the plates."""
    d, mu = design(case), MP.mpf(str(case["mu"]))
    first = engagement(d)
    case["k"], case["phi_e"] = (0, "inf") if first is None else (first[0], text(first[1]))
    f = d.floats()
    c = first_contact(
        f.eta, f.beta, f.lam, f.sense * f.alpha, f.theta0, rigid_path(d), None if first is None else first[0]
    )
    case["plates"] = c and {"k": c.k, "pair": list(c.pair), "theta": f"{c.theta:.9f}", "phi": f"{c.phi:.9f}"}
    for law in LAWS:
        case[law] = solve(d, mu, law)
    return case


def main() -> None:
    """Draw the designs, solve them on all cores, write the file."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 2020
    r, start = random.Random(seed), time.time()
    cases = []
    for kind, count in KINDS.items():
        found = 0
        while found < count:
            case = draw(r, kind)
            if fits(case):
                cases.append(case)
                found += 1
    print(f"{len(cases)} designs drawn in {time.time() - start:.0f} s", flush=True)
    with multiprocessing.Pool() as pool:
        done = []
        for case in pool.imap(fill, cases, chunksize=1):
            done.append(case)
            print(len(done), case["kind"], case["plate"]["end"], case["edge"]["end"], flush=True)
            record = {"seed": seed, "margin": MARGIN, "digits": 17, "cases": done}
            OUT.write_text(json.dumps(record, indent=0, separators=(",", ":")) + "\n", encoding="utf-8")
    print(f"{time.time() - start:.0f} s, {OUT.stat().st_size} bytes")


if __name__ == "__main__":
    main()
