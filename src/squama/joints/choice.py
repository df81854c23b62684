"""What holds the scales of a beam: the matrix of its file, the law, elements, or else a hinge; one rule for all."""

from __future__ import annotations

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
    """What holds a scale.

    ``K`` in E = 1 and d = 1 over the nine motions of ``squama.joints.factor``, the first seven where a file gives
    no more, None on a hinge; where it is from; a note for the reader, empty where there is nothing to say; ``band``,
    about how far the torque may be off for it, relative, NaN where that is not known; forms ``strain`` (4, 9, 9) of
    :func:`squama.joints.law.strain`, None where neither the law nor elements know them; ``bends``: the embedded part
    bends in K.
    """

    K: Array | None
    source: Source
    note: str
    band: float
    strain: Array | None = None
    bends: bool = False


def shape(beam: Beam) -> law.Shape:
    """Return what a beam's joint depends on."""
    g = geometry(beam)._asdict()
    return law.Shape(*(g[name] for name in law.Shape._fields))


def known(beam: Beam) -> bool:
    """Whether a beam's joint is known without elements: by its matrix, or by the law."""
    return not unknown(beam)


def unknown(beam: Beam) -> str:
    """Return why a beam's joint is not known without elements; empty where it is."""
    problems = [] if beam.joint.matrix is not None else law.outside(shape(beam))
    return _HINGED.format(said(problems)) if problems else ""


def impossible(beam: Beam) -> str:
    """Return why a beam's joint is not known, with elements; empty where it is."""
    joint = joint_of(beam)
    return joint.note if joint.K is None else ""


def unbent(beam: Beam) -> str:
    """Return why a joint's matrix does not know bends; empty where it does, or there is none."""
    return _SEVEN if beam.joint.matrix is not None and len(beam.joint.matrix.K) < 9 else ""


def joint_of(beam: Beam) -> Joint:
    """Return what holds a beam's scales.

    The matrix of its file; else the law, in its range; else elements, where the extra fe is installed, kept in the
    user's cache; else a hinge. A stiffness or an inclusion factor that the file gives was measured and goes before
    all: K takes it on, see ``squama.joints.factor.scaled``.

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
    """Return the joint without what the file gives of single figures."""
    form = shape(beam)
    problems = law.outside(form)
    strain = None if problems else law.strain(form)
    if beam.joint.matrix is not None:
        return Joint(beam.joint.matrix.K, "matrix", "", math.nan, strain)
    if not problems:
        return Joint(law.stiffness(form), "law", "", float(law.band(form)), strain)
    from squama.fe.stiffness import joint

    # a rigid one may make a beam with long embedded parts several times too stiff
    bends = geometry(beam).lean > 0 and beam.scale.youngs_modulus is not None
    try:
        made = joint(beam, tab="elastic" if bends else "rigid")
    except InputError as error:
        why = said([*problems, *error.problems])
        return Joint(None, "hinge", _HINGED.format(why), math.nan)
    note = f"the joint is by elements{', whose embedded parts bend' * bends}: {said(problems)}"
    return Joint(made.K, "elements", note, made.K_theta.error / made.K_theta.value, made.strain, bends)


def said(problems: Iterable[Problem]) -> str:
    """Return mistakes in one line, each once."""
    return "; ".join(dict.fromkeys(map(str, problems)))
