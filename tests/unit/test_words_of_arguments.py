"""Words that public arguments take: the types that editors and type checkers read are the tables of the program."""

import inspect
from typing import Literal, get_args, get_origin

import pytest

import squama
from squama import loads
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
