"""A reader of decks that checks their syntax: keywords and parameters, sets, nodes, and the data lines of each.

It knows the keywords that our decks use, in both dialects, as the programs' references define them. It cannot say
whether a program accepts a deck or what it makes of it.
"""

from __future__ import annotations

from typing import NamedTuple

from squama.errors import InputError

LONGEST, MOST_ENTRIES = 256, 16
NODES = {"C3D10": 10, "C3D8": 8, "C3D8I": 8}


class Rule(NamedTuple):
    """What a keyword takes: parameters that it ``needs`` and ``may`` have, how many data lines, and their fields."""

    needs: tuple[str, ...] = ()
    may: tuple[str, ...] = ()
    lines: tuple[int, float] = (0, 0)
    fields: tuple[int, ...] = ()


_MANY = float("inf")
_ANY = tuple(range(1, 17))
COMMON = {
    "HEADING": Rule(lines=(1, _MANY), fields=_ANY),
    "NODE": Rule(may=("NSET",), lines=(1, _MANY), fields=(4,)),
    "ELEMENT": Rule(("TYPE",), ("ELSET",), (1, _MANY), (9, 11)),
    "NSET": Rule(("NSET",), (), (1, _MANY), _ANY),
    "ELSET": Rule(("ELSET",), (), (1, _MANY), _ANY),
    "MATERIAL": Rule(("NAME",)),
    "ELASTIC": Rule(lines=(1, 1), fields=(2,)),
    "HYPERELASTIC": Rule(("NEO HOOKE",), (), (1, 1), (2,)),
    "SOLID SECTION": Rule(("ELSET", "MATERIAL")),
    "SURFACE": Rule(("NAME", "TYPE"), (), (1, _MANY), (2,)),
    "SURFACE INTERACTION": Rule(("NAME",)),
    "SURFACE BEHAVIOR": Rule(("PRESSURE-OVERCLOSURE",), (), (1, 1), (1,)),
    "CONTACT PAIR": Rule(("INTERACTION", "TYPE"), (), (1, 1), (2,)),
    "BOUNDARY": Rule(lines=(1, _MANY), fields=(3, 4)),
    "STEP": Rule((), ("NLGEOM", "INC")),
    "STATIC": Rule(lines=(1, 1), fields=(4,)),
    "END STEP": Rule(),
}
DIALECTS = {
    "calculix": {
        **COMMON,
        "FRICTION": Rule(lines=(1, 1), fields=(2,)),
        "RIGID BODY": Rule(("NSET", "REF NODE", "ROT NODE")),
        "NODE PRINT": Rule(("NSET",), ("FREQUENCY",), (1, 1), _ANY),
        "NODE FILE": Rule(lines=(1, 1), fields=_ANY),
        "EL FILE": Rule(lines=(1, 1), fields=_ANY),
    },
    "abaqus": {
        **COMMON,
        "FRICTION": Rule(lines=(1, 1), fields=(1,)),
        "RIGID BODY": Rule(("REF NODE",), ("ELSET", "PIN NSET", "TIE NSET")),
        "OUTPUT": Rule((), ("FIELD", "HISTORY", "FREQUENCY")),
        "NODE OUTPUT": Rule((), ("NSET",), (1, _MANY), _ANY),
        "ELEMENT OUTPUT": Rule((), ("ELSET",), (1, _MANY), _ANY),
        "CONTACT OUTPUT": Rule((), (), (1, _MANY), _ANY),
    },
}
STEP_ONLY = {"STATIC", "END STEP", "NODE PRINT", "NODE FILE", "EL FILE", "OUTPUT", "NODE OUTPUT", "ELEMENT OUTPUT"}
MODEL_ONLY = {"NODE", "ELEMENT", "NSET", "ELSET", "MATERIAL", "SOLID SECTION", "RIGID BODY", "SURFACE", "CONTACT PAIR"}


class Card(NamedTuple):
    """A keyword with its parameters (value "" where none is given), its line number and its data lines."""

    name: str
    parameters: dict[str, str]
    line: int
    data: list[tuple[int, list[str]]]


class Deck(NamedTuple):
    """What a deck holds: comments, cards, nodes, sets (nodes and elements by name, in their order), elements."""

    comments: list[str]
    cards: list[Card]
    nodes: dict[int, tuple[float, float, float]]
    elements: dict[int, tuple[int, ...]]
    nsets: dict[str, list[int]]
    elsets: dict[str, list[int]]
    surfaces: dict[str, list[tuple[str, str]]]


def read(text: str) -> Deck:
    """Read a deck.

    Raises
    ------
    InputError
        A line that is no keyword, comment or data of one; a number that is none.
    """
    deck = Deck([], [], {}, {}, {}, {}, {})
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("**"):
            deck.comments.append(line)
        elif line.startswith("*"):
            head, *rest = (part.strip() for part in line[1:].split(","))
            pairs = (part.partition("=") for part in rest)
            deck.cards.append(Card(head.upper(), {k.strip().upper(): v.strip() for k, _, v in pairs}, number, []))
        elif not deck.cards:
            message = f"line {number}: data before the first keyword"
            raise InputError(message)
        elif line.strip():
            fields = [part.strip() for part in line.split(",")]
            deck.cards[-1].data.append((number, fields[:-1] if not fields[-1] else fields))
    for card in deck.cards:
        _collect(deck, card)
    return deck


def _collect(deck: Deck, card: Card) -> None:
    """Put the data of a card into the deck."""
    for number, fields in card.data:
        try:
            if card.name == "NODE":
                x, y, z = (float(v) for v in fields[1:4])
                deck.nodes[int(fields[0])] = (x, y, z)
                if "NSET" in card.parameters:
                    deck.nsets.setdefault(card.parameters["NSET"], []).append(int(fields[0]))
            elif card.name == "ELEMENT":
                deck.elements[int(fields[0])] = tuple(int(v) for v in fields[1:])
                if "ELSET" in card.parameters:
                    deck.elsets.setdefault(card.parameters["ELSET"], []).append(int(fields[0]))
            elif card.name in ("NSET", "ELSET"):
                sets = deck.nsets if card.name == "NSET" else deck.elsets
                mine = sets.setdefault(card.parameters.get(card.name, ""), [])
                for field in fields:
                    mine += sets[field] if field in sets else [int(field)]
            elif card.name == "SURFACE":
                deck.surfaces.setdefault(card.parameters.get("NAME", ""), []).append((fields[0], fields[-1]))
        except (ValueError, KeyError):
            message = f"line {number}: *{card.name}: cannot be read: {', '.join(fields)[:60]}"
            raise InputError(message) from None


def check(text: str, dialect: str) -> list[str]:
    """Return what is wrong with a deck, a line each; an empty list if nothing is.

    Parameters
    ----------
    text : str
        The deck.
    dialect : {"calculix", "abaqus"}
        Whose keywords it is to follow.

    Raises
    ------
    InputError
        The deck cannot be read at all.
    """
    deck = read(text)
    found = [
        f"line {i}: {len(line)} characters, {LONGEST} at most"
        for i, line in enumerate(text.splitlines(), start=1)
        if len(line) > LONGEST
    ]
    stepping = False
    for card in deck.cards:
        rule = DIALECTS[dialect].get(card.name)
        if rule is None:
            found.append(f"line {card.line}: *{card.name}: is no keyword of {dialect} that is known here")
            continue
        stepping = stepping or card.name == "STEP"
        if card.name in STEP_ONLY and not stepping:
            found.append(f"line {card.line}: *{card.name}: belongs into a step")
        if card.name in MODEL_ONLY and stepping:
            found.append(f"line {card.line}: *{card.name}: belongs before the step")
        found += _parameters(card, rule) + _data(card, rule) + _references(deck, card)
        stepping = stepping and card.name != "END STEP"
    if stepping or not any(card.name == "STEP" for card in deck.cards):
        found.append("there is no complete step: *STEP ... *END STEP")
    return found + _mesh(deck)


def _parameters(card: Card, rule: Rule) -> list[str]:
    found = [f"line {card.line}: *{card.name}: lacks {name}" for name in rule.needs if name not in card.parameters]
    unknown = [name for name in card.parameters if name not in (*rule.needs, *rule.may)]
    return found + [f"line {card.line}: *{card.name}: {name}: unknown parameter" for name in unknown]


def _data(card: Card, rule: Rule) -> list[str]:
    least, most = rule.lines
    found = []
    if not least <= len(card.data) <= most:
        found.append(f"line {card.line}: *{card.name}: has {len(card.data)} data lines")
    if card.name == "HEADING":
        return found
    for number, fields in card.data:
        if len(fields) > MOST_ENTRIES:
            found.append(f"line {number}: {len(fields)} entries, {MOST_ENTRIES} at most")
        elif rule.fields and len(fields) not in rule.fields:
            found.append(f"line {number}: *{card.name}: {len(fields)} entries")
    return found


def _references(deck: Deck, card: Card) -> list[str]:
    """Return sets, surfaces and nodes that a card names but nobody defines."""
    found = []

    def miss(what: str, name: str, line: int = card.line) -> None:
        found.append(f"line {line}: *{card.name}: there is no {what} {name}")

    materials = {c.parameters.get("NAME") for c in deck.cards if c.name == "MATERIAL"}
    interactions = {c.parameters.get("NAME") for c in deck.cards if c.name == "SURFACE INTERACTION"}
    for key, value in card.parameters.items():
        if key in ("PIN NSET", "TIE NSET") or (key == "NSET" and card.name not in ("NODE", "NSET")):
            if value not in deck.nsets:
                miss("node set", value)
        elif key == "ELSET" and card.name not in ("ELEMENT", "ELSET") and value not in deck.elsets:
            miss("element set", value)
        elif key in ("REF NODE", "ROT NODE") and (not value.isdecimal() or int(value) not in deck.nodes):
            miss("node", value)
        elif key == "MATERIAL" and value not in materials:
            miss("material", value)
        elif key == "INTERACTION" and value not in interactions:
            miss("interaction", value)
        elif key == "TYPE" and card.name == "ELEMENT" and value not in NODES:
            miss("element type", value)
    for number, fields in card.data:
        if card.name == "BOUNDARY":
            known = int(fields[0]) in deck.nodes if fields[0].isdecimal() else fields[0] in deck.nsets
            if not known:
                miss("node or node set", fields[0], number)
            if not all(v.isdecimal() and 1 <= int(v) <= 6 for v in fields[1:3]):
                found.append(f"line {number}: *BOUNDARY: degrees of freedom are 1 to 6")
        elif card.name == "CONTACT PAIR":
            for name in fields:
                if name not in deck.surfaces:
                    miss("surface", name, number)
        elif card.name == "SURFACE":
            if fields[0] not in deck.elsets:
                miss("element set", fields[0], number)
            if fields[-1] not in ("S1", "S2", "S3", "S4", "S5", "S6"):
                found.append(f"line {number}: *SURFACE: {fields[-1]}: is no face")
    return found


def _mesh(deck: Deck) -> list[str]:
    """Return elements with wrong numbers of nodes, and nodes that do not exist."""
    found = []
    for card in (c for c in deck.cards if c.name == "ELEMENT"):
        want = NODES.get(card.parameters.get("TYPE", ""), 0)
        for number, fields in card.data:
            if want and len(fields) != want + 1:
                found.append(f"line {number}: *ELEMENT: {len(fields) - 1} nodes, {card.parameters['TYPE']} has {want}")
    for number, nodes in deck.elements.items():
        missing = [n for n in nodes if n not in deck.nodes]
        if missing:
            found.append(f"element {number}: there is no node {missing[0]}")
        elif len(set(nodes)) != len(nodes):
            found.append(f"element {number}: a node stands in it twice")
    for kind, sets, known in (("node", deck.nsets, deck.nodes), ("element", deck.elsets, deck.elements)):
        for name, members in sets.items():
            missing = [n for n in members if n not in known]
            if missing:
                found.append(f"{kind} set {name}: there is no {kind} {missing[0]}")
    return found
