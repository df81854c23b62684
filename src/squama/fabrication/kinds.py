"""Kinds of solids and of their files."""

from typing import Literal, get_args

PartName = Literal["scale", "substrate", "mould", "assembly"]
PARTS: tuple[PartName, ...] = get_args(PartName)
FormatName = Literal["stl", "3mf", "step"]
FORMATS: tuple[FormatName, ...] = get_args(FormatName)


def parts_for(faces: str) -> tuple[PartName, ...]:
    """Return the parts of a beam with scales on these faces: a mould casts the slots of one."""
    return PARTS if faces == "one" else tuple(part for part in PARTS if part != "mould")
