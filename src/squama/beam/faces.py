"""Scales on the bar's other face: their symmetry to those of the first, scaled face, and the bend and twist they see.

The scales of the other face are those of the scaled face, mapped by a symmetry S of the bar, S S = 1, and shifted along
z. A motion with rotation vector w, mapped by S, has rotation vector det(S) S w. With w = -(psi, 0, phi) the laws of the
scaled face hold for the other face with

    (psi, phi) -> det(S) (S_x psi, S_z phi),

and with the lateral bend times det(S) S_y; the stretch is unchanged. With E(psi, phi) the energy of one face, the
energy of both is E(psi, phi) + E(det S S_x psi, det S S_z phi), and moments and torques of both are its derivatives. A
shift changes nothing in an endless beam, because its strains are the same everywhere.

"mirrored" in the plane y = 0, as the flanks of a fish or the two sides of a coat of mail: the other face sees (-psi,
-phi), so each sense of twist closes the scales of one face. "turned" by half a turn about the beam's axis, so that both
faces look alike from outside: it sees (-psi, phi), and twist closes both. For scales across the beam (alpha = 0) the
two coincide.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

from squama.errors import refuse
from squama.units import shown


class Other(NamedTuple):
    """Symmetry of the other face: diagonal of the map ``S`` from the scaled face, and ``shift`` along z in pitches."""

    S: tuple[int, int, int]
    shift: float = 0.0

    @property
    def det(self) -> int:
        """Determinant of the map: -1 for a mirror image."""
        x, y, z = self.S
        return x * y * z

    @property
    def seen(self) -> tuple[int, int, int]:
        """Signs (+1, -1) of bend, twist and lateral bend in the scaled face's laws, applied to the other face."""
        x, y, z = self.S
        return self.det * x, self.det * z, self.det * y


_MIRROR, _TURN = (1, -1, 1), (-1, -1, 1)
FacesName = Literal["one", "mirrored", "mirrored, shifted", "turned", "turned, shifted"]
FACES: Mapping[str, Other | None] = {
    "one": None,
    "mirrored": Other(_MIRROR),
    "mirrored, shifted": Other(_MIRROR, 0.5),
    "turned": Other(_TURN),
    "turned, shifted": Other(_TURN, 0.5),
}
"""Symmetry of the other face by the words of the beam file; None for scales on one face."""


def read(value: object) -> str:
    """Return a word of :data:`FACES`; refuse others."""
    if not isinstance(value, str) or value not in FACES:
        meant = '"mirrored" (as armour) or "turned"' if value == "both" else f"one of {', '.join(map(shown, FACES))}"
        refuse("", shown(value), "does not say where scales are", f"write {meant}")
    return value


def described(faces: str) -> str:
    """Return in words on which faces the scales are."""
    return f"both faces, {faces}" if FACES[faces] else "one face"


def sense(faces: str, axis: int, alpha: float) -> int:
    """Return the sign with which the other face sees a bend (axis 0) or a twist (axis 1) alone; 0 without scales there.

    Scales across the beam, alpha = 0, are their own mirror image in x.
    """
    other = FACES[faces]
    if other is None:
        return 0
    return 1 if axis and not alpha else other.seen[axis]


def only_one(faces: str, what: str) -> None:
    """Refuse scales on both faces; ``what`` names the method that covers only one."""
    if FACES[faces]:
        reason = f"is not covered by {what}: it takes scales on one face"
        refuse("beam.faces", shown(faces), reason, 'write faces = "one"')
