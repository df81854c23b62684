"""Endless beams on a stiffness matrix over a scale's motions and the twist, twisted by the solver of elements."""

import numpy as np

from squama.fe.assembly import make_bent
from squama.fe.contact import DHAT, SLIP
from squama.fe.geometry import Geometry

INCREMENT = 2e-3


def shape(eta, beta, lam, alpha=45.0, theta0=10.0):
    """A beam; its section is in the matrix."""
    return Geometry(1.0, lam, 0.0, eta, beta, 0.0, np.radians(alpha), np.radians(theta0), 0.3)


def straight(geometry, K, mu, *, hinged=False, exposed=None, dhat=DHAT, slip=SLIP):
    """A beam at rest that is twisted only, by a matrix (7, 7)."""
    whole = np.eye(9)
    whole[:7, :7] = K
    return make_bent(whole, geometry, mu, free=(), hinged=hinged, exposed=exposed, dhat=dhat, slip=slip)


def curve(geometry, K, mu, twists, *, increment=INCREMENT, **options):
    """The beam at twists in their order, NaN beyond its end, and its walk."""
    walk = straight(geometry, K, mu, **options)
    twists = np.asarray(twists, float)
    legs = np.split(twists, np.flatnonzero(np.diff(np.sign(np.diff(twists)))) + 2)
    found, at = [], 0.0
    for leg in legs:
        way = walk.phi
        walk.aim(0.0, leg[-1])
        for twist in leg:
            if not walk.run(way + abs(twist - at), increment).reached:
                break
            found.append({name: column[-1] for name, column in walk.columns.items()} | walk.works())
        at = leg[-1]
    columns = {name: np.full(twists.size, np.nan) for name in found[0] if name != "contact"} if found else {}
    for name, column in columns.items():
        column[: len(found)] = [one[name] for one in found]
    return columns, walk


def contacts(walk):
    """The pairs of features in contact one after the other."""
    pairs = [words.partition(" (")[0] for words in walk.columns["contact"]]
    return [pair for before, pair in zip(["", *pairs], pairs, strict=False) if pair not in ("", before)]


def unbalanced(columns):
    """Work of the torque less what is stored and rubbed away, over that work, at the last point that was reached."""
    i = np.flatnonzero(np.isfinite(columns["T"]))[-1]
    W, U, W_fr = (columns[name][i] for name in ("W", "U_el", "W_fr"))
    return (W - U - W_fr) / W
