"""The plane of bend and twist: what is in contact, what locks, inclination, moment and torque, each state from rest."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from squama import arguments
from squama.arrays.combined_states import Combined, combined
from squama.beam.design import Beam
from squama.beam.faces import only_one
from squama.contacts import events, states
from squama.contacts import path as real_path
from squama.contacts.legs import follow_straight
from squama.curves import hinge_polygons, real
from squama.curves.chosen import chosen
from squama.curves.labelled import Labelled, attributes, labelled
from squama.curves.path import VERBS, Asked, States
from squama.curves.polygons import Stations, read
from squama.curves.real_figures import in_si
from squama.loads import LOADS, neutral_height
from squama.model.outcome import End
from squama.model.screw import LOCKED
from squama.types import Array

if TYPE_CHECKING:
    import xarray as xr

ROOM = 0.15
"""Room around a path on a map of its plane, as a part of the path's size."""
OPEN, SLIDING = "open", "sliding"
"""States of a map that are no ends."""
SAMPLES, HALVINGS = 32, 8
"""Places on the way to a state of hinges at which a lock is looked for, and how often it is then closed in on."""
_NEXT = "on hinges the next scale's eight contacts are looked at; other pairs of plates are not"


def bend_twist_map(
    beam: Beam,
    path: Stations,
    *,
    mu: float | None = None,
    joint: str | None = None,
    ideal: bool | None = None,
    neutral: str | None = None,
    points: int = 81,
) -> xr.Dataset:
    """Map the plane of bend and twist around a path: contacts, locks, inclination, moment and torque.

    Every state is reached straight from rest, on its own ray: with friction, moment and torque depend on the way.

    Parameters
    ----------
    beam, mu, joint, ideal, neutral
        As in :func:`bend_twist`.
    path
        As in :func:`bend_twist`; the map is the box around rest and its corners, with some room. A ray such as
        "bend 8 rad/m, twist 10 rad/m" names the far corner.
    points
        Points each way.

    Returns
    -------
    xarray.Dataset
        Over ``psi`` and ``phi`` (rad per pitch; ``kappa``, ``Phi`` in rad/m along them): ``state`` ("open", "sliding",
        or what ends the way to it, such as "frictional lock", "no equilibrium"), ``contact``, ``theta``, ``N``, ``M``,
        ``T`` and the scales' parts of them, NaN where the way ends before; on hinges ``mu_lock``, too. Attributes as of
        :func:`bend_twist`.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg")
    >>> m = squama.bend_twist_map(beam, "bend 0.2 rad/pitch, twist 0.3 rad/pitch", mu=0.5, joint="hinge", points=21)
    >>> print(m["T"].dims, *m.state.sel(psi=0.1, phi=[0.1, 0.3], method="nearest").values, sep=", ")
    ('psi', 'phi'), sliding, frictional lock
    """
    arguments.beam(beam)
    only_one(beam.faces, "the map of bend and twist")
    way = read(path, beam)
    m = np.asarray(arguments.friction(beam.friction.mu, mu))
    n = arguments.whole("points", points, 3, 1000)
    means = chosen(beam, joint=joint, ideal=ideal, neutral=neutral)
    asked = Asked(means.beam, way, m, "edge", 0.01, n, ideal=means.ideal, note=means.note)
    corners = np.array([(0.0, 0.0), *way.points])
    room = ROOM * float(np.ptp(corners, axis=0).max())
    psi, phi = (np.linspace(v.min() - room, v.max() + room, n) for v in corners.T)
    # at rest itself there is no way, and nothing in contact
    grid = np.meshgrid(np.where(psi == 0, 1e-9 * room, psi), phi, indexing="ij")
    found = (_real if means.real else _hinges)(asked, *(v.ravel() for v in grid))
    twisting = LOADS["twisting"]
    attrs = attributes(
        asked, "plane of bend and twist of a scale-covered beam", "+", means.joint, found.notes, twisting
    )
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("psi", "phi"): {role: np.reshape(v, (n, n)) for role, v in found.by_dim[()].items()},
        ("psi",): {"psi": psi, "kappa": psi / beam.pitch},
        ("phi",): {"load": phi, "rate": phi / beam.pitch},
    }
    return _dataset(
        labelled(twisting, States(by_dim), m, "combined"),
        attrs | {"load": "bending and twisting", "neutral": means.beam.neutral, **found.attrs},
    )


def _dataset(variables: dict[str, Labelled], attrs: dict[str, Any]) -> xr.Dataset:
    import xarray as xr

    return xr.Dataset(variables, attrs=attrs).set_coords(["mu", "psi", "phi", "kappa", "Phi"])


def _hinges(asked: Asked, psi: Array, phi: Array) -> States:
    """Return states (n,) of thin, rigid scales on hinges."""
    beam, mu, height = asked.beam, float(asked.mus), neutral_height(asked.beam.neutral, asked.beam.lam)

    def at(w: Array, which: Array) -> Combined:
        ways = psi[which][:, None], phi[which][:, None]
        return combined(w * ways[0], w * ways[1], **beam.ratios, mu=mu, toward=ways, neutral_height=height)

    def stops(s: Combined) -> Array:
        return np.asarray((s.contact == LOCKED) | ((s.contact != "") & (s.mu_lock > 0) & (s.mu_lock <= mu)))

    w, every = np.arange(1, SAMPLES + 1) / SAMPLES, np.arange(psi.size)
    s = at(w, every)
    ended = stops(s).any(axis=1)
    which = np.flatnonzero(ended)
    high = w[stops(s)[which].argmax(axis=1)][:, None]
    low = high - 1 / SAMPLES
    for _ in range(HALVINGS):
        beyond = stops(at((low + high) / 2, which))
        low, high = np.where(beyond, low, (low + high) / 2), np.where(beyond, (low + high) / 2, high)
    state = np.where(s.contact[:, -1] == "", OPEN, SLIDING).astype("U40")
    state[which] = np.where(at(high, which).contact[:, 0] == LOCKED, End.LINE, End.FRICTIONAL)
    forces = {"N": s.normal, "M": s.bending_moment, "T": s.torque, "theta": s.theta, "mu_lock": s.mu_lock}
    last = {name: np.where(ended, np.nan, v[:, -1]) for name, v in forces.items()}
    contact = np.where(s.contact[:, -1] == LOCKED, "", s.contact[:, -1])
    v = hinge_polygons.in_si(asked, [contact], psi, phi, [last], np.full(psi.size, np.nan))
    kept = ("contact", "theta", "N", "M", "M_scales", "T", "T_scales", "mu_lock")
    return States({(): {"state": state} | {name: v[name] for name in kept}}, notes=[_NEXT])


def _real(asked: Asked, psi: Array, phi: Array) -> States:
    """Return states (n,) of the real beam."""
    beam, held = asked.beam, real.Held.of(asked.beam, *VERBS)
    plate = real.scale(beam, ideal=asked.ideal)
    gone = follow_straight(plate, held.K, float(asked.mus), np.column_stack([psi, phi]), **held.bar)
    contacts, v = gone.answers.contacts, real_path.named(gone.rows)
    state = real_path.endings(contacts, gone.answers.ends).astype("U40")
    reached = np.isin(state, (End.RANGE, End.NONE))
    state[reached] = np.where(v["contacts"][reached] > 0, SLIDING, OPEN)
    first = [events.named(*map(int, met)) if met[0] >= 0 else "" for met in contacts[:, :3]]
    touching = events.last(gone.answers)
    own = {"theta": states.inclinations(gone.way, gone.rows), "T": gone.T, "M": gone.M}
    own |= {"N": v["N"], "f": v["f"], "W_fr": v["W_fr"], "W_snap": v["W_snap"]}
    own |= {"U_el": np.sum([*states.energies(gone.way, gone.rows).values()], axis=0)}
    si = in_si(beam, held, own)
    bar = beam.unit_moment * states.bare(gone.way.beams)[0] @ [phi, psi]
    si |= {"torque": si["T"], "M_scales": si["M"] - bar[1], "scales": si["T"] - bar[0]}
    si |= {"state": state, "contact": np.where(state == OPEN, "", np.where(reached, touching, np.array(first)))}
    far = float(np.abs([psi, phi]).max())
    kept = ("state", "contact", "theta", "N", "M", "M_scales", "torque", "scales", "W_fr", "W_snap", "U_el", "RED")
    notes = real.notes(held, beam, far, ideal=asked.ideal)
    return States({(): {name: si[name] for name in kept}}, real.attributes(held, *VERBS), notes)
