"""Figures of many beams with thick, elastic scales on compliant joints, with derivatives by the moved variables.

No differences are taken: a complex step passes through the law of the joint and the plates, and through the contact by
the implicit function theorem (:mod:`squama.contacts.derivatives`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from squama.beam.design import Beam
from squama.contacts import path
from squama.curves import doors
from squama.curves.labelled import Answer
from squama.inverse import hinge_figures
from squama.inverse.named_figures import At, Found, Options, Want
from squama.loads import LOADS
from squama.model.outcome import End
from squama.model.sensitivity import STEP
from squama.study import compliant_columns
from squama.study.columns import Cells
from squama.study.compliant_columns import Figures
from squama.types import Array

LEAST = 1e-9
"""Friction coefficient at which derivatives by friction are taken for a beam without friction."""
_LOCK_ROLES = {"lock": "load_end", "RED": "RED_c", "critical_mu": "mu_static"}
"""Fields of a response that hold the figures of a lock."""
NEAR_REST = 1e-3
"""Load angle (rad per pitch) of a response of which only the figures without a twist are used."""


def evaluate(c: Cells, moved: Sequence[Cells], wants: Sequence[Want], options: Options, *, plates: bool) -> Found:
    """Evaluate figures of designs, as :func:`squama.inverse.hinge_figures.evaluate`; all contacts are followed."""
    del plates
    n, k = c.d.size, len(moved)
    if any(np.imag(m.mu).any() for m in moved):
        c = c.changed({"mu": np.maximum(c.mu, LEAST)}, c.sizes)

    def together(x: Array, *every: Array) -> Array:
        # the real part is that of the harmless columns; the steps of one design stand in a row
        return np.asarray(np.real(x)[:, None] + 1j * np.imag(every).T).ravel()

    with np.errstate(all="ignore"):
        values, last = _values(c.mapped(together, *moved) if k else c, wants, options, k)
    slopes = np.imag(values).reshape(len(wants), n, -1).swapaxes(1, 2)[:, :k] / STEP
    ends = np.array([last.code, last.load_e, last.load_end])
    values, (code, load_e, load_end) = (np.real(v[:, :: max(1, k)]) for v in (values, ends))
    # a beam whose joint is not covered has a curve of length 0
    return Found(values, np.where(np.isfinite(slopes), slopes, 0.0), code.astype(int), load_e, np.nan_to_num(load_end))


def _values(c: Cells, wants: Sequence[Want], options: Options, copies: int) -> tuple[Array, Figures]:
    """Return the wanted figures (wants, n), and all figures at the largest twist of the wants."""
    twists = list(dict.fromkeys(w.at for w in wants if w.at is not None)) or [At(0.0, path.RANGE)]
    n = c.sizes["beam"]["scales"]
    twists.sort(key=lambda at: float(np.max(at.per_pitch(c.d, n).real)))
    load, sense = options.load, options.sense
    by_twist = {
        at: compliant_columns.solved(c, at.per_pitch(c.d, n), load=load, sense=sense, copies=copies, along=False)
        for at in twists
    }
    last = by_twist[twists[-1]]
    found = [_figure(c, want.figure, by_twist.get(want.at or twists[-1], last)) for want in wants]
    return np.array(found).reshape(len(wants), c.d.size), last


def _figure(c: Cells, name: str, f: Figures) -> Array:
    if name == "engagement":
        return np.where(np.isfinite(f.load_e), f.load_e, np.nan)
    if name == "stiffness":
        return f.rigidity
    if name == "length":
        return c.sizes["beam"]["scales"] * c.d
    if name == "strength_share":
        return np.asarray(f.stress / c.sizes["scale"].get("strength", np.nan))
    return np.asarray(getattr(f, name))


def followed(
    beam: Beam, wants: Sequence[Want], options: Options, joint: str | None = "compliant", *, ends: str | None = None
) -> tuple[list[float], Answer]:
    """Return the wanted figures of one beam as of :func:`squama.twist` or :func:`squama.bend`, and the response.

    All contacts are followed; a figure of scales is the largest of all scales. ``joint`` None: the default model of the
    response; ``ends`` None: those of the beam. Figures of a lock are NaN where the curve has none.
    """
    load = LOADS[options.load]
    at = [None if w.at is None else w.at.per_length(beam) for w in wants]
    rates = sorted({rate for rate in at if rate is not None})
    sense = options.sense
    how: doors.How = {"joint": joint}
    if joint == "hinge":
        how |= {"law": options.law, "margin": options.margin}
    if not rates and joint != "compliant":
        rates = [NEAR_REST / beam.pitch]
    elif not rates:
        # far enough for the figures at engagement
        engaged = float(doors.respond(beam, options.load, at=[0.0], sense=sense, ends=ends, **how)["Phi_e"])
        rates = [2 * engaged if np.isfinite(engaged) else 0.0]
    answer = doors.respond(beam, options.load, at=rates, sense=sense, ends=ends, **how)
    alone = {"engagement": float(answer[f"{load.angle}_e"]), "length": beam.length}
    alone["stiffness"] = float(answer.attrs.get("rigidity", load.rigidity(beam)))
    if End(answer["end"].item()).locks:
        alone |= {want: float(answer[load.variable(role)]) for want, role in _LOCK_ROLES.items()}
    found = []
    for want, rate in zip(wants, at, strict=True):
        if rate is None:
            found.append(alone.get(want.figure, np.nan))
            continue
        share = want.figure == "strength_share"
        name = load.variable("stress" if share else want.figure)
        value = float(answer.along(name)[rates.index(rate)]) if name in answer.variables else np.nan
        found.append(value / (beam.scale.strength or np.nan) if share else value)
    return found, answer


EVALUATE: dict[str, Callable[..., Found]] = {"hinge": hinge_figures.evaluate, "compliant": evaluate}
"""Functions that evaluate figures of many designs, by the joint."""
