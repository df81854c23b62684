"""A state as the query of a link, and back: exact to the last bit, readable, checked as a beam file is."""

from __future__ import annotations

from collections.abc import Iterable
from urllib.parse import parse_qsl, urlencode

from squama import beamfile
from squama.beamfile import TABLES
from squama.design import Beam
from squama.errors import InputError
from squama.units import as_text, shown
from squama.web.fields import CHOICES
from squama.web.state import MOST_KEPT, State

LONGEST = 20_000
"""Characters of a query at most."""


def query(state: State) -> str:
    """Return the query of the link that shows a state.

    Examples
    --------
    >>> from squama.web.state import preset
    >>> link = query(preset("main"))
    >>> link[:46], read(link) == preset("main")
    ('load=twisting&law=edge&sense=%2B&margin=0.01&t', True)
    """
    return urlencode([*_pairs(state), *(("keep", query(one)) for one in state.kept)])


def _pairs(state: State) -> Iterable[tuple[str, str]]:
    yield from ((name, getattr(state, name)) for name in CHOICES)
    yield from ((name, repr(float(getattr(state, name)))) for name in ("margin", "twist"))
    data = state.beam.model_dump()
    for table, keys in TABLES.items():
        part = data if table == "beam" else data[table]
        for key, (dimension, _, _) in keys.items():
            if part[key] is not None:
                yield f"{table}.{key}", str(part[key]) if dimension is None else as_text(part[key], dimension)


def read(text: str) -> State:
    """Return the state of a query.

    Raises
    ------
    InputError
        Something in it cannot be used: one line per mistake.
    """
    return _read(text, kept=True)


def _read(text: str, *, kept: bool) -> State:
    if len(text) > LONGEST:
        message = f"the link is longer than {LONGEST} characters; copy it anew"
        raise InputError(message)
    pairs = parse_qsl(text.removeprefix("?"), keep_blank_values=True)
    tables: dict[str, dict[str, object]] = {}
    plain: dict[str, str] = {}
    keeps: list[str] = []
    problems = []
    for name, value in pairs:
        table, dot, key = name.partition(".")
        if dot and table in TABLES and key in TABLES[table]:
            whole = TABLES[table][key].dimension is None and value.isdecimal() and len(value) < 9
            tables.setdefault(table, {})[key] = int(value) if whole else value
        elif name in CHOICES or name in ("margin", "twist"):
            plain[name] = value
        elif name == "keep" and kept:
            keeps.append(value)
        else:
            problems.append(f"{shown(name)}: is not known in a link")
    if len(keeps) > MOST_KEPT:
        problems.append(f"keep: {len(keeps)} designs; at most {MOST_KEPT}")
    if problems:
        raise InputError("\n".join(problems))
    beam = Beam._build(beamfile.merge({}, tables), source="link: ", bare=False)
    state = State(beam, 0.0)
    state = state._replace(beam=beam.replace(friction={"mu": state.mu}))
    for name, value in plain.items():
        state = _loaded(state, value) if name == "load" else state.change(name, value)
    return state._replace(kept=tuple(_read(one, kept=False) for one in keeps))


def _loaded(state: State, load: str) -> State:
    """Change the kind of loading, without the start of its own that a change on the page has."""
    state.change("load", load)
    return state._replace(load=load)
