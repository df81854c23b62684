"""Scales on the bar's other face: how they lie to those of the scaled face, and which bend and twist they see.

The other face's scales are the scaled face's, mapped by a symmetry S of the bar, S S = 1, and shifted along z. A motion
with rotation vector w, mapped by S, has rotation vector det(S) S w. With w = -(psi, 0, phi) the other face sees, by the
scaled face's own laws,

    (psi, phi) -> det(S) (S_x psi, S_z phi),

likewise the lateral bend as det(S) S_y times, and the stretch as it is. So with E(psi, phi) the energy of one face that
of both is E(psi, phi) + E(det S S_x psi, det S S_z phi), and moments and torques of both are its derivatives. A shift
changes nothing of an endless beam: its strains are the same all along.

"mirrored" in the plane y = 0, as the flanks of a fish or the two sides of a coat of mail: the other face sees
(-psi, -phi), so each sense of twist closes the scales of one face. "turned" by half a turn about the beam's axis, both
faces alike as seen from outside: it sees (-psi, phi), and twist closes both. Scales across the beam (alpha = 0) are
alike either way.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

from squama.errors import refuse
from squama.units import shown


class Other(NamedTuple):
    """The other face: diagonal of the map ``S`` of the scaled face to it, ``shift`` along the beam in pitches."""

    S: tuple[int, int, int]
    shift: float = 0.0

    @property
    def det(self) -> int:
        """Determinant of the map: -1 for a mirror image."""
        x, y, z = self.S
        return x * y * z

    @property
    def seen(self) -> tuple[int, int, int]:
        """Signs of bend, twist and lateral bend that it sees, by the scaled face's laws."""
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
"""Where a beam has scales, by the words of its file."""


def read(value: object) -> str:
    """Return a word of :data:`FACES`; refuse others."""
    if not isinstance(value, str) or value not in FACES:
        meant = '"mirrored" (as armour) or "turned"' if value == "both" else f"one of {', '.join(map(shown, FACES))}"
        refuse("", shown(value), "does not say where scales are", f"write {meant}")
    return value


def described(faces: str) -> str:
    """Say on which faces there are scales."""
    return f"both faces, {faces}" if FACES[faces] else "one face"


def sense(faces: str, axis: int, alpha: float) -> int:
    """Return the sense in which the other face sees the bend (axis 0) or the twist (1) alone; 0 without scales there.

    Scales across the beam, alpha = 0, are their own mirror image in x.
    """
    other = FACES[faces]
    if other is None:
        return 0
    return 1 if axis and not alpha else other.seen[axis]


def only_one(faces: str, what: str) -> None:
    """Refuse scales on both faces where ``what`` covers one."""
    if FACES[faces]:
        reason = f"is not covered by {what}: it takes scales on one face"
        refuse("beam.faces", shown(faces), reason, 'write faces = "one"')
