"""K_theta, inclusion factor C_f and rigidity of beams: as given, from the joint's matrix, or by the scaling laws.

One rule for a single beam and for columns of beams: a given value comes first, then the joint's matrix, scaled to the
beam's pitch and modulus, then the laws of :data:`squama.model.joint.LAWS`. A matrix is used as it is even if the beam's
shape differs from the one it was made for; `squama.beam.validity` warns of that. K_theta is the stiffness of a scale
against a turn about its width at fixed twist and bend, so it does not depend on the load. The inclusion factor in
bending is never taken from the matrix.
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
"""Flags of the free strains in the order bend, twist, lateral bend, stretch: 1 if free, else 0."""
Each = Callable[..., Number]
"""Type of the functions that evaluate a law: :func:`one`, :func:`one_by_one` or :func:`whole`."""


class Given(NamedTuple):
    """Data of a beam's joint: stiffness (N m), inclusion factor, matrix; None for a value that is not given.

    ``seen``: signs with which the other face sees bend, twist and lateral bend, empty for scales on one face; stiffness
    and matrix are those of one face, a given inclusion factor is that of the whole beam. ``held``: names of the held
    strains of the bar, of :data:`squama.loads.STRAINS`.
    """

    stiffness: Number | None
    inclusion_factor: Number | None
    matrix: StoredMatrix | None
    seen: tuple[int, ...] = ()
    held: tuple[str, ...] = ()

    @property
    def may(self) -> tuple[str, ...]:
        """Names of the strains that are not held, of :data:`squama.loads.STRAINS`.

        Empty for a joint's matrix of seven rows, which has no bend and stretch.
        """
        if self.matrix is not None and len(self.matrix.rows) < 9:
            return ()
        return tuple(name for name in STRAINS if name not in self.held)

    def free(self, *loaded: str) -> Free:
        """Return flags (1 or 0) of the free strains: neither held nor ``loaded``."""
        psi, phi, chi, eps = (int(name in self.may and name not in loaded) for name in STRAINS)
        return psi, phi, chi, eps

    @property
    def line(self) -> str:
        """Line of the bar that keeps its length: "middle", or "free" where the stretch is free (no axial force)."""
        return "free" if "stretch" in self.may else "middle"

    def gathered(self, factor: Number) -> Number:
        """Return the beam's inclusion factor from that of scales on one face: the tabs of each face add as much."""
        return 1 + 2 * (factor - 1) if self.seen else factor


class Sizes(NamedTuple):
    """Arguments of the laws in SI units: floats, or arrays that broadcast; ``half`` is half the scale's width."""

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
    """Evaluate a law for arrays element by element, with the same digits as for one beam."""
    import numpy as np

    return np.asarray(np.frompyfunc(law, len(arguments), 1)(*arguments), float)


def whole(law: Each, *arguments: Number) -> Number:
    """Evaluate a law for whole arrays, real or with complex steps."""
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
    """Return the inclusion factor C_f under "twisting" or "bending"; other arguments as in :func:`stiffness`."""
    if given.inclusion_factor is not None:
        return given.inclusion_factor
    if given.matrix is not None and LOADS[load].matrix:
        figure = given.matrix.rigidity(given.free("twist"), given.seen, own(s) if given.seen else ())
        return each(_scaled, figure, s.modulus, s.pitch, 4) / bare(load, s, each)
    return given.gathered(each(joint.LAWS[f"inclusion {load}"].value, s.zeta, s.beta, s.lam))


def rigidity(load: str, s: Sizes, given: Given, each: Each = one) -> Number:
    """Return the rigidity of the beam without contact, N m^2; arguments as in :func:`inclusion`."""
    return inclusion(load, s, given, each) * bare(load, s, each)


def bare(load: str, s: Sizes, each: Each = one) -> Number:
    """Return the rigidity of the bar without scales, N m^2."""
    return _BARE[load](s, each)


def own(s: Sizes, each: Each = one) -> tuple[Number, Number, Number, Number]:
    """Return the stiffness of a pitch of the bar without scales against bend, twist, lateral bend (E d^3) and stretch.

    The last is the axial force per stretch over E d^2.
    """
    bend, twist = (bare(load, s, each) / (s.modulus * s.pitch**4) for load in ("bending", "twisting"))
    return bend, twist, bend * (s.width / s.depth) ** 2, s.width * s.depth / s.pitch**2


def _scaled(figure: Number, modulus: Number, pitch: Number, power: int) -> Number:
    """Return a value of a matrix in units of E and d, times modulus and pitch to a power."""
    return figure * modulus * pitch**power


_BARE: dict[str, Callable[[Sizes, Each], Number]] = {
    "twisting": lambda s, each: (
        each(section.torsion_constant, s.width, s.depth) * section.shear_modulus(s.modulus, s.poisson)
    ),
    "bending": lambda s, each: s.modulus * each(section.bending_moment_of_area, s.width, s.depth),
}
