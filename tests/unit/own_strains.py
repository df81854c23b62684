"""The Jacobian of rows beside complex steps of the residual: all kinds of contact, with friction; not compiled.

Run in a process of its own, with NUMBA_DISABLE_JIT=1; writes what entries miss, of the rows named as arguments or, if
none is, of all.
"""

import json
import sys
from typing import Any

import numpy as np

from squama.beam.faces import FACES
from squama.contacts import entry, newton, path, tally, touch
from squama.contacts.equations import residual
from squama.contacts.increments import weigh
from squama.contacts.jacobian import jacobian
from squama.contacts.linear import AT, HIGH, INNER, LOW, laid_out
from squama.contacts.meeting import before, meet, prepared
from squama.contacts.newton import shift, solve
from squama.contacts.system import (
    EPS,
    EQUAL,
    FREE,
    LOADED,
    MU,
    OWN,
    PHI,
    STRAINS,
    TILT,
    UNTIED,
    Ties,
    ahead,
    borders,
    strain_columns,
)
from squama.contacts.ties import COUPLE, GRIPPED, LOOSE, Tie, X, Y, Z, of_ends, ties
from squama.contacts.works import remember
from squama.joints import law

N, C = 4, 8
CONTACTS = [
    # scale, how much further, kind, features, sticks, ended
    (0, 1, touch.EE, 0, 2, 0, 0),
    (0, 2, touch.VF, 0, 0, 0, 0),
    (1, 1, touch.FV, 0, 2, 0, 0),
    (1, 2, touch.EF, 2, 2, 0, 0),
    (2, 1, touch.FE, 1, 1, 0, 0),
    (3, 0, touch.LIES, 0, 0, 0, 0),
]
RUBS = [(0, 1, touch.EE, 0, 2, 1, 0), (0, 2, touch.VF, 0, 0, 1, 0), *CONTACTS[2:]]
"""Where there is friction, two contacts stick and others slide."""


def walks(held: Ties | None, free: tuple[float, ...], faces: str = "one") -> list[entry.Walk]:
    """Return a row at rest, real and with room for complex steps."""
    shape = law.Shape(2.0, 0.5, 0.3, 0.8, 0.03, 0.8, 0.3, 0.45)
    scale = path.Scale(*np.array([(2.5, 0.8, 0.5, 0.8, 0.3, 0.03, 0.05, 0.3)]).T)
    other = FACES[faces]
    bar: path.Bar = {"seen": other.seen, "own": (0.1, 0.1, 0.1, 0.1)} if other else {}
    bar["tilt"] = (-0.3, -0.6, 2.0)
    beams = path.beams(scale, law.stiffness(shape)[None], np.zeros(1), **bar)._replace(free=np.array([free]))
    S = entry.system(beams, 0, N * path.faces(beams), OWN if held else EQUAL, held or UNTIED)
    return [entry.walk(S._replace(K=S.K.astype(kind)), C, np.zeros(0)) for kind in (float, complex)]


def random_state(w: entry.Walk, size: float, mu: float) -> None:
    """Write some state: strains of a size, forces and motions of some hundredths.

    Friction is mu N in an increment without slip: terms of its order are left out of the Jacobian.
    """
    rng = np.random.default_rng(3)
    st = w.now
    for c, row in enumerate(RUBS if mu else CONTACTS):
        w.con[c] = row
        # on both faces by turns
        w.con[c, touch.FIRST] = row[0] * w.S.stride + c % w.S.stride
    w.S.shapes[:, MU] = mu
    st.q[:] = 0.03 * rng.standard_normal(st.q.shape)
    st.strains[:] = size * rng.standard_normal(st.strains.shape)
    st.F[:] = 0.02 * rng.standard_normal(st.F.shape)
    st.s[:] = rng.uniform(0.2, 0.6, st.s.shape)
    st.ties[:] = 0.05 * rng.standard_normal(st.ties.shape)
    for _ in range(20):
        # without friction, forces are along the normals
        prepared(w.S, st, w.con, len(CONTACTS), True, w.W)
        for c, row in enumerate(w.con[: len(CONTACTS)]):
            if row[touch.KIND] != touch.LIES:
                n = np.array(meet(w.S, st, row, st.s[c], w.W).n)
                along = np.cross(n, (0.2, -0.1, 0.3))
                st.F[c] = 0.01 * (c + 1) * (n + mu * along / np.sqrt(along @ along))
    w.tally[tally.FRESH], w.tally[tally.SIZE] = 1.0, 1e-3
    weigh(w, 2e-3)
    for _ in range(3):
        remember(w)
    for c, row in enumerate(w.con[: len(CONTACTS)]):
        if row[touch.KIND] != touch.LIES:
            # places of the contact were together
            apart = before(w.S, row, st.s[c], w.past, 0)[0]
            w.past.pairs[:, row[touch.FIRST], row[touch.APART] - 1, 9:12] += apart


def missed(held: Ties | None, free: tuple[float, ...], size: float, mu: float, faces: str = "one") -> dict[str, float]:
    """Return what entries miss, over the largest one: those of a cell's strains by themselves, and all others."""
    real, steps = walks(held, free, faces)
    random_state(real, size, mu)
    random_state(steps, size, mu)
    m, S, J = len(CONTACTS), real.S, real.J
    n = laid_out(S, real.con, m, J)
    inner = J.kept[INNER]

    prepared(S, real.now, real.con, m, True, real.W)
    residual(S, real.now, real.past, real.con, m, J.at, n, real.W, J.r, real.loads)
    jacobian(S, real.now, real.past, real.con, m, n, real.W, J)
    whole = np.zeros((n, n))
    for a in range(inner):
        at, low, high = J.rows[[AT, LOW, HIGH], a]
        whole[a, low:high] = J.band[at + low : at + high]
    wide = n - inner
    whole[:inner, inner:], whole[inner:, :inner] = J.right[:wide, :inner].T, J.lower[:wide, :inner]
    whole[inner:, inner:] = J.corner[:wide, :wide]
    exact, skip = np.zeros((n, n)), np.zeros(n, bool)
    for b in range(n):
        step = np.zeros(n)
        step[b] = 1.0
        shift(S, steps.now, steps.con, m, J.at, n, step, 1e-30j)
        prepared(S, steps.now, steps.con, m, True, steps.W)
        residual(S, steps.now, steps.past, steps.con, m, J.at, n, steps.W, steps.J.r, steps.loads)
        exact[:, b] = steps.J.r[:n].imag * 1e30
        shift(S, steps.now, steps.con, m, J.at, n, step, -1e-30j)
    own = np.zeros((n, n), bool)
    columns = [[v for v in strain_columns(S, J.at, n, i * S.stride) if v >= 0] for i in range(N)]
    for strained in columns:
        own[np.ix_(strained, strained)] = True
    for first in J.at[: len(S.tilts)]:
        # a tilt's shift does not turn with it, which the Jacobian leaves out
        own[first + TILT, first + TILT] = True
    for i in range(N if ahead(S) > len(columns[0]) else 0):
        # how far sections move is eliminated
        first = J.at[i * S.stride]
        skip[first - ahead(S) : first - len(columns[i])] = True
    if skip.any():
        kept = ~skip
        left = np.linalg.solve(whole[np.ix_(skip, skip)], whole[np.ix_(skip, kept)])
        whole = whole[np.ix_(kept, kept)] - whole[np.ix_(kept, skip)] @ left
        exact, own = exact[np.ix_(kept, kept)], own[np.ix_(kept, kept)]
    off, scale = np.abs(whole - exact), np.abs(exact).max()
    return {"own": off[own].max() / scale, "other": off[~own].max() / scale}


def found_in(rounds: int, far: float) -> bool:
    """Say whether a state without contact is found in a number of corrections, from motions so far from it.

    One is not enough to know it, and one that is too large is given up.
    """
    (w, _), newton._ROUNDS = walks(None, (0.0,) * 4), rounds
    w.now.q[:] = far
    return solve(w.S, w.now, w.past, w.con, 0, w.W, w.J, w.loads)


def room(held: Ties | None) -> list[str]:
    """Return the working arrays of a path that are not of the shape said of them."""
    w = walks(held, (0.0,) * 4)[0]
    S, one = w.S, len(w.S.shapes)
    n = (7 if S.own else 6) * one + (ahead(S) * N if S.own else 0) + 6 * C + borders(S)
    W = {"E": (one, 12), "load": (one, 24), "powers": (2 * C, 3, 24), "bent": (2 * C, 3, 24), "side": (2 * C,)}
    W |= {"lifts": (6, n), "told": (C, 3), "views": (2, 12), "corners": (4, 3), "vertex": (7,), "end": (9,)}
    W |= {"first": (one,), "next": (2 * C,), "window": (1,), "hold": (one, 10), "stiffness": (1,)}
    J = {"order": (n,), "last": (n,), "rows": (3, n), "r": (n,), "kept": (5,), "noise": (1,)}
    past = {"E": (3, one, 12), "b": (3, one, 24), "F": (C, 3), "weights": (3,)}
    now = {"q": (one, 7 if S.own else 6), "b": (one, 24), "F": (C, 3), "s": (C, 3)}
    parts = (("W", W), ("J", J), ("past", past), ("now", now))
    found = {f"{of}.{name}": (getattr(getattr(w, of), name).shape, size) for of, v in parts for name, size in v.items()}
    return [name for name, (is_, said) in found.items() if is_ != said]


if __name__ == "__main__":
    loose, gripped, apart = of_ends(N, LOOSE), of_ends(N, GRIPPED), of_ends(N, GRIPPED, apart=True)
    ways: dict[str, Any] = {"loose": (loose, (FREE, LOADED, FREE, FREE)), "some": (loose, (0.0, LOADED, FREE, 0.0))}
    ways |= {"gripped": (gripped, (FREE, LOADED, FREE, FREE)), "at a distance": (apart, (FREE, LOADED, FREE, LOADED))}
    ways["couple"] = (of_ends(N, COUPLE), (FREE, LOADED, FREE, FREE))
    ways["equal"] = (None, (FREE, 0.0, FREE, FREE))
    pushed = [Tie([(N, Y), (1.3, X)], course=(PHI, 1.0), couple=Y - 0.4 * Z)]
    pushed += [Tie(carried=(0.3, 0, 0, -1.0), course=(EPS, 2.0))]
    ways["cantilever"] = (ties(N, pushed), (FREE, LOADED, FREE, FREE))
    bench = [Tie([(0.5, v)]) for v in (X, Y, Z)] + [Tie([(3.2, v)]) for v in (X, Y)]
    bench += [Tie(turn=(1, Z, 0 * Z)), Tie([(2, Y)], course=(PHI, 1.0))]
    ways["on supports"] = (ties(N, bench, floating=True), (FREE, LOADED, FREE, FREE))
    assert (PHI, EPS, STRAINS) == (1, 3, 4)
    found: dict[str, Any] = {"found": [found_in(*given) for given in ((1, 0.01), (30, 0.01), (30, 10.0))]}
    found["room"] = [*room(None), *room(loose)]
    sizes = (0.05, 0.0), (1e-4, 0.4)
    rows = {name: (*way, "one") for name, way in ways.items()}
    for faces, names in (("mirrored", ("loose", "gripped")), ("turned", ("couple", "cantilever", "on supports"))):
        rows |= {f"{faces}, {name}": (*ways[name], faces) for name in names}
    for name in sys.argv[1:] or rows:
        held, free, faces = rows[name]
        found[name] = [missed(held, free, size, mu, faces) for size, mu in sizes]
    sys.stdout.write(json.dumps(found))
