"""Choice of the joint of a beam's scales: the matrix of its file, the fitted law, finite elements, else a hinge."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple

from squama.errors import InputError, Problem
from squama.fe.geometry import geometry
from squama.joints import law
from squama.joints.factor import scaled

if TYPE_CHECKING:
    from squama.beam.design import Beam
    from squama.types import Array

Source = Literal["matrix", "law", "elements", "hinge"]
_HINGED = "hinges, as the joint is not known: {}"
_SEVEN = _HINGED.format(
    "joint.matrix holds six motions and the twist, not the bend; squama joint --matrix writes all nine, and without it "
    "in the file the law of the joint holds them"
)


class Joint(NamedTuple):
    """The joint of a beam's scales.

    ``K`` (9, 9), with E = 1 and d = 1, over the motions of ``squama.joints.factor`` (7 by 7 where the file has no
    more, None for a hinge); its ``source``; a ``note`` for the reader, or ""; ``band``, the estimated relative error of
    the torque due to K (NaN if unknown); ``strain`` (4, 9, 9), the forms of :func:`squama.joints.law.strain`, None
    where neither the law nor elements supply them; ``bends``: whether K includes bending of the embedded part.
    """

    K: Array | None
    source: Source
    note: str
    band: float
    strain: Array | None = None
    bends: bool = False


def shape(beam: Beam) -> law.Shape:
    """Return the ratios and angles of a beam on which its joint depends."""
    g = geometry(beam)._asdict()
    return law.Shape(*(g[name] for name in law.Shape._fields))


def known(beam: Beam) -> bool:
    """Return whether a beam's joint is known from its matrix or the law, without finite elements."""
    return not unknown(beam)


def unknown(beam: Beam) -> str:
    """Return why a beam's joint is not known without finite elements; "" if it is known."""
    problems = [] if beam.joint.matrix is not None else law.outside(shape(beam))
    return _HINGED.format(said(problems)) if problems else ""


def impossible(beam: Beam) -> str:
    """Return why a beam's joint is not known even with finite elements; "" if it is known."""
    joint = joint_of(beam)
    return joint.note if joint.K is None else ""


def unbent(beam: Beam) -> str:
    """Return why the joint's matrix does not cover bending; "" if it does, or if the beam has no matrix."""
    return _SEVEN if beam.joint.matrix is not None and len(beam.joint.matrix.K) < 9 else ""


def joint_of(beam: Beam) -> Joint:
    """Return the joint of a beam's scales.

    The first available source counts: the matrix of the beam's file; the law, in its range; finite elements, if the
    extra fe is installed, cached for the user; else a hinge. A stiffness or an inclusion factor in the file was
    measured and overrides the corresponding part of K, see ``squama.joints.factor.scaled``.

    Raises
    ------
    InputError
        The elements refuse the beam, or the file of the law is missing.
    """
    found = _found(beam)
    if found.K is None or (beam.joint.stiffness is None and beam.joint.inclusion_factor is None):
        return found
    unit = beam.unit_moment
    K_theta = None if beam.joint.stiffness is None else beam.joint.stiffness / unit
    rigid = None if beam.joint.inclusion_factor is None else beam.torsional_rigidity / (unit * beam.pitch)
    K = scaled(found.K, K_theta=K_theta, rigidity=rigid, free=beam.given.free("twist"))
    return found._replace(K=K)


def _found(beam: Beam) -> Joint:
    """Return the joint without the stiffness or inclusion factor that the file gives."""
    problems, by_law = _by_law(shape(beam))
    if beam.joint.matrix is not None:
        return Joint(beam.joint.matrix.K, "matrix", "", math.nan, by_law and by_law.strain)
    if by_law:
        return by_law
    from squama.fe.stiffness import joint

    # a rigid embedded part, if long, may make the beam several times too stiff
    bends = geometry(beam).lean > 0 and beam.scale.youngs_modulus is not None
    try:
        made = joint(beam, tab="elastic" if bends else "rigid")
    except InputError as error:
        why = said([*problems, *error.problems])
        return Joint(None, "hinge", _HINGED.format(why), math.nan)
    note = f"the joint is by elements{', whose embedded parts bend' * bends}: {said(problems)}"
    return Joint(made.K, "elements", note, made.K_theta.error / made.K_theta.value, made.strain, bends)


@functools.lru_cache(maxsize=256)
def _by_law(form: law.Shape) -> tuple[list[Problem], Joint | None]:
    """Return why the law does not cover a shape, and the joint by it; the same for all beams of a shape."""
    problems = law.outside(form)
    if problems:
        return problems, None
    K, strain = law.stiffness(form), law.strain(form)
    for shared in (K, strain):
        shared.flags.writeable = False
    return problems, Joint(K, "law", "", float(law.band(form)), strain)


def said(problems: Iterable[Problem]) -> str:
    """Return problems as one line, each once."""
    return "; ".join(dict.fromkeys(map(str, problems)))
