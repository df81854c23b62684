"""STEP files through build123d: the same blocks and cuts as in the meshes, as exact plane faces."""

from __future__ import annotations

import io
import itertools
import re
from collections.abc import Sequence
from typing import Any

from squama.errors import SquamaError
from squama.fabrication.recipe import QUADS, Array, Recipe
from squama.needs import need

VOLUME = 1e-6
"""Largest relative difference of a volume from the closed form."""
_OCCURRENCE = re.compile(
    rb"=\s*(NEXT_ASSEMBLY_USAGE_OCCURRENCE)\(\s*'\d+'"
    rb",\s*('[^']*'),\s*('[^']*'),\s*(#\d+),\s*(#\d+),\s*(\$|'[^']*')\s*\)"
)
_DATE = "1980-01-01T00:00:00"
"""Date in the file's head, fixed so that the same solids give the same bytes."""


def step(name: str, solids: Sequence[tuple[Recipe, Sequence[tuple[str, Array, Array]]]]) -> bytes:
    """Return a STEP file in millimetres.

    Parameters
    ----------
    name : str
        Name of the whole.
    solids : sequence
        Each solid with its copies: name, rotation matrix, shift.

    Returns
    -------
    bytes

    Raises
    ------
    InputError
        build123d is not installed.
    SquamaError
        A volume differs from that of the closed form.
    """
    cad = need("build123d")
    children = []
    for recipe, copies in solids:
        for label, turn, shift in copies:
            # a shape of its own for each copy: the file's names belong to shapes
            child = _solid(cad, recipe.moved(turn, shift))
            child.label = label
            children.append(child)
    whole = cad.Compound(label=name, children=children) if len(children) > 1 else children[0]
    out = io.BytesIO()
    cad.export_step(whole, out, unit=cad.Unit.MM, timestamp=_DATE)
    return _numbered(out.getvalue())


def _numbered(data: bytes) -> bytes:
    """Return a file whose occurrences are numbered from 1: the kernel counts on from file to file."""
    count = itertools.count(1)

    def line(found: re.Match[bytes]) -> bytes:
        return b"= %s('%d',%s)" % (found[1], next(count), b",".join(found.groups()[1:]))

    return _OCCURRENCE.sub(line, data)


def _solid(cad: Any, recipe: Recipe) -> Any:
    whole, *cuts = (_block(cad, corners) for corners in (recipe.whole, *recipe.cuts))
    found = whole.cut(*cuts) if cuts else whole
    solids = found.solids()
    if len(solids) != 1:
        message = f"{recipe.name}: the STEP solid is in {len(solids)} pieces"
        raise SquamaError(message)
    found = solids[0]
    if abs(found.volume / recipe.volume - 1) > VOLUME:
        message = f"{recipe.name}: the STEP solid has {found.volume:.9g} mm^3, not {recipe.volume:.9g} mm^3"
        raise SquamaError(message)
    return found


def _block(cad: Any, corners: Array) -> Any:
    faces = [
        cad.Face(cad.Wire.make_polygon([tuple(map(float, corners[i])) for i in quad], close=True)) for quad in QUADS
    ]
    return cad.Solid(cad.Shell(faces))
