"""Kinds of solids, and of the files that they are written to."""

from typing import Literal, get_args

PartName = Literal["scale", "substrate", "mould", "assembly"]
PARTS: tuple[PartName, ...] = get_args(PartName)
FormatName = Literal["stl", "3mf", "step"]
FORMATS: tuple[FormatName, ...] = get_args(FormatName)
