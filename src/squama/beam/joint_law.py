"""K_theta, C_f and the rigidity of a beam: as given, from the joint's matrix, or by the scaling laws.

One rule for one beam and for columns of beams: a value that is given comes first, then the joint's matrix, scaled to
the beam's pitch and modulus, then the laws of :data:`squama.model.joint.LAWS`. A matrix stands for the shape for which
it was made whatever the other sizes are; `squama.beam.validity` says where they differ. K_theta does not depend on the
load: it is the stiffness of a scale against a turn about its width at a given twist and bend. The inclusion factor in
bending does not come from the matrix.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from squama.loads import LOADS, STRAINS
from squama.model import joint, section
from squama.model.twisting import Number

if TYPE_CHECKING:
    from squama.beam.matrixfile import StoredMatrix

Free = tuple[int, int, int, int]
"""Which of the strains bend, twist, lateral bend and stretch are free: 1, else 0."""
Each = Callable[..., Number]
"""How a law is evaluated: :func:`one`, :func:`one_by_one` or :func:`whole`."""


class Given(NamedTuple):
    """What a beam says of its joint: stiffness (N m), inclusion factor, matrix; None for what it does not.

    ``seen``: signs with which the other face sees bend, twist and lateral bend, empty where it has no scales; stiffness
    and matrix are of one face, a factor that is given is the beam's.
    ``held``: which strains of the bar are, of :data:`squama.loads.STRAINS`.
    """

    stiffness: Number | None
    inclusion_factor: Number | None
    matrix: StoredMatrix | None
    seen: tuple[int, ...] = ()
    held: tuple[str, ...] = ()

    @property
    def may(self) -> tuple[str, ...]:
        """Strains that are not held, of :data:`squama.loads.STRAINS`.

        None where a joint's matrix has seven motions and knows no bend.
        """
        if self.matrix is not None and len(self.matrix.rows) < 9:
            return ()
        return tuple(name for name in STRAINS if name not in self.held)

    def free(self, *loaded: str) -> Free:
        """Return which strains are free, 1 or 0, with others ``loaded``: what is neither loaded nor held."""
        psi, phi, chi, eps = (int(name in self.may and name not in loaded) for name in STRAINS)
        return psi, phi, chi, eps

    @property
    def line(self) -> str:
        """The line of the bar that keeps its length: "free" for none, without axial force, or "middle"."""
        return "free" if "stretch" in self.may else "middle"

    def gathered(self, factor: Number) -> Number:
        """Return the inclusion factor of the beam by that of scales on one face: each face's tabs add as much."""
        return 1 + 2 * (factor - 1) if self.seen else factor


class Sizes(NamedTuple):
    """What the laws depend on, SI: floats, or arrays that broadcast; ``half`` is half the scale's width."""

    modulus: Number
    poisson: Number
    width: Number
    depth: Number
    pitch: Number
    half: Number
    thickness: Number
    embedded: Number
    beta: Number
    lam: Number
    zeta: Number


def one(law: Each, *arguments: Number) -> Number:
    """Evaluate a law for one beam."""
    return law(*arguments)


def one_by_one(law: Each, *arguments: Number) -> Number:
    """Evaluate a law for arrays, one element after the other: to the last bit as for one beam."""
    import numpy as np

    return np.asarray(np.frompyfunc(law, len(arguments), 1)(*arguments), float)


def whole(law: Each, *arguments: Number) -> Number:
    """Evaluate a law for whole arrays; a complex step goes through it."""
    import numpy as np

    return np.asarray(law(*arguments))


def stiffness(s: Sizes, given: Given, each: Each = one) -> Number:
    """Return the stiffness K_theta of a scale's joint, N m per rad, of one beam or of many, under any load."""
    if given.stiffness is not None:
        return given.stiffness
    if given.matrix is not None:
        return each(_scaled, given.matrix.K_theta, s.modulus, s.pitch, 3)
    return each(joint.LAWS["stiffness"].value, s.modulus, s.thickness, s.half, s.embedded)


def inclusion(load: str, s: Sizes, given: Given, each: Each = one) -> Number:
    """Return the inclusion factor C_f under "twisting" or "bending"; other arguments as of :func:`stiffness`."""
    if given.inclusion_factor is not None:
        return given.inclusion_factor
    if given.matrix is not None and LOADS[load].matrix:
        figure = given.matrix.rigidity(given.free("twist"), given.seen, own(s) if given.seen else ())
        return each(_scaled, figure, s.modulus, s.pitch, 4) / bare(load, s, each)
    return given.gathered(each(joint.LAWS[f"inclusion {load}"].value, s.zeta, s.beta, s.lam))


def rigidity(load: str, s: Sizes, given: Given, each: Each = one) -> Number:
    """Return the rigidity of the beam without contact, N m^2; arguments as of :func:`inclusion`."""
    return inclusion(load, s, given, each) * bare(load, s, each)


def bare(load: str, s: Sizes, each: Each = one) -> Number:
    """Return the rigidity of the bar without scales, N m^2."""
    return _BARE[load](s, each)


def own(s: Sizes) -> tuple[float, float, float, float]:
    """Return the stiffness of one bar without scales against its strains, E d^3 (of the stretch: per stretch)."""
    bend, twist = (bare(load, s) / (s.modulus * s.pitch**4) for load in ("bending", "twisting"))
    return float(bend), float(twist), float(bend * (s.width / s.depth) ** 2), float(s.width * s.depth / s.pitch**2)


def _scaled(figure: Number, modulus: Number, pitch: Number, power: int) -> Number:
    """Return a matrix' figure for a beam's modulus and pitch."""
    return figure * modulus * pitch**power


_BARE: dict[str, Callable[[Sizes, Each], Number]] = {
    "twisting": lambda s, each: (
        each(section.torsion_constant, s.width, s.depth) * section.shear_modulus(s.modulus, s.poisson)
    ),
    "bending": lambda s, each: s.modulus * each(section.bending_moment_of_area, s.width, s.depth),
}
