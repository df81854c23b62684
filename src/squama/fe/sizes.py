"""Meshes by name."""

from collections.abc import Mapping
from typing import Literal

MeshName = Literal["coarse", "medium", "fine"]
MeshSize = MeshName | tuple[float, float]
"""A mesh by its name, or by the sizes of its elements in the bulk and along the embedded scale's edges, pitches."""
MESHES: Mapping[MeshName, tuple[float, float]] = {
    "coarse": (0.2, 0.06),
    "medium": (0.15, 0.013),
    "fine": (0.12, 0.0075),
}
