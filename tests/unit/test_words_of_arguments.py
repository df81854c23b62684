"""Words that public arguments take: the types that editors and type checkers read are the tables of the program."""

import inspect
from typing import Literal, get_args, get_origin

import pytest

import squama
from squama import loads
from squama.beam import faces
from squama.fabrication import kinds
from squama.fe import sizes
from squama.io import numerals
from squama.model.laws import LAWS


@pytest.mark.parametrize(
    ("alias", "table"),
    [
        (loads.LoadName, loads.LOADS),
        (loads.LawName, LAWS),
        (loads.JointName, loads.HELD),
        (loads.LineName, loads.LINES),
        (loads.EndsName, loads.ENDS),
        (loads.ModeName, loads.MODES),
        (faces.FacesName, faces.FACES),
        (sizes.MeshName, sizes.MESHES),
        (kinds.PartName, kinds.PARTS),
        (kinds.FormatName, kinds.FORMATS),
        (numerals.DecimalName, (".", ",")),
    ],
)
def test_types_are_the_tables(alias, table):
    assert get_origin(alias) is Literal
    assert set(get_args(alias)) == set(table)


@pytest.mark.parametrize("word", ["law", "sense", "joint", "neutral", "mode"])
def test_every_door_has_the_type(word):
    alias = {"neutral": "LineName"}.get(word, f"{word.capitalize()}Name")
    doors = [getattr(squama, name) for name in squama.__all__]
    hints = [door.__annotations__ for door in doors if inspect.isfunction(door)]
    found = [one[word] for one in hints if word in one]
    assert len(found) > 1
    assert all(alias in one for one in found)


@pytest.mark.parametrize(
    ("door", "argument", "alias"),
    [
        (squama.cell, "mesh", "MeshSize"),
        (squama.verify, "mesh", "MeshSize"),
        (squama.verify, "beam_mesh", "MeshSize"),
        (squama.free_vibration, "faces", "FacesName"),
        (squama.export, "parts", "Sequence[PartName]"),
        (squama.export, "formats", "Sequence[FormatName]"),
        (squama.read_measured, "decimal", "DecimalName | None"),
    ],
)
def test_the_doors_of_one_word_have_its_type(door, argument, alias):
    assert door.__annotations__[argument] == alias
