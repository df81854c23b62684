"""The colours of all pictures, in one table: figures, the beam in space, the explorer and its page.

This module imports no plotting library; scripts and style sheets of pages get their colours from it.
"""

from __future__ import annotations

from squama.model.outcome import End

INK, GREY, ACCENT = "#1a1a1a", "#7a7a7a", "#b2182b"
"""Colours of lines and text in figures, of background items, of marks."""
UNLOADED = "#2166ac"
"""Colour of unloading."""
KEPT = ("#0072b2", "#b5651d", "#8a63b0")
"""Colours of designs in comparison, distinguishable for colour-blind readers (each has its own dashes as well)."""
ENDS = {
    End.FRICTIONAL: "#4477aa",
    End.KINEMATIC: "#1d2d50",
    End.LINE: "#5b4b8a",
    End.STATIC: "#d9dde3",
    End.OFF_TIP: "#ddcc77",
    End.OFF_SIDE: "#e08a5b",
    End.OTHER: "#aa4499",
    End.RELEASED: "#88ccee",
    End.RANGE: "#999933",
    End.NONE: "#ffffff",
    End.TOUCHING: "#f7d4d6",
    End.STOPPED: "#664422",
    End.SIDE: "#ee99aa",
    End.JOINT: "#7a9a8b",
    "joint unknown": "#bbbbbb",
    "not computed": "#f4e3e3",
}
"""Colours of the ends of curves on a map: blue for a lock after sliding, grey for a lock at engagement; unknown and
uncomputed cells.
"""
DARK_ENDS = ENDS | {End.KINEMATIC: "#9db2e8", End.LINE: "#9a86d0", End.STOPPED: "#b3875a", End.NONE: "#3a4047"}
"""The same on a dark background."""
STEPS = ("#7e4fb3", "#b0408f", "#dd5e66", "#f2914a", "#f7c64b", "#f2ef6b")
"""Colours of the classes of a figure on a map, from small to large, on either background."""
SOFTER, ENDED = "#1b9e9e", "#858c94"
"""Colours of a stiffness below that of the bar, and of curves that end before, on either background."""
LOCKS = (End.FRICTIONAL, End.KINEMATIC, End.STATIC)
"""Ends at which the load grows without bound."""
READABLE = 0.9
"""End of the axes near such an end, as a share of the way from engagement to it."""
STATES = {"free": "#4a90c2", "sliding": "#e0a030", "locked": "#c8323c", "ended": "#8a63b0"}
"""Colours of scales by their state."""
WORDS = {"free": "not in contact", "sliding": "sliding", "locked": "locked", "ended": "at the end of the curve"}
"""Words for the states."""
_PAGE = {
    "ink": ("#1d2125", "#e8eaed"),
    "page": ("#ffffff", "#16191d"),
    "panel": ("#f3f4f5", "#20252b"),
    "line": ("#c9ced3", "#414952"),
    "soft": ("#59636e", "#a9b3bd"),
    "accent": ("#0b62a8", "#6cb6ff"),
    "bad": ("#b3161f", "#ff8a8f"),
    "note": ("#fff4d6", "#3d3317"),
    "faint": ("#d9dde1", "#3a4047"),
    "curve": ("#14181c", "#f4f6f8"),
    "mark": ("#c8323c", "#ff7a80"),
    "background": ("#f7f7f5", "#16191d"),
    "bar": ("#cfc8ba", "#6d675c"),
    "edge": ("#2b2b2b", "#e6e6e6"),
    "point": ("#111111", "#ffffff"),
    "normal": ("#14803c", "#3ddc84"),
    "friction": ("#c2185b", "#ff5fa2"),
}
THEMES = {theme: {name: pair[i] for name, pair in _PAGE.items()} for i, theme in enumerate(("light", "dark"))}
"""A light and a dark theme: text, background and lines of a page; its plots; colours of the beam in space."""
SCENE = {"states": STATES, "words": WORDS, "themes": THEMES}
"""Colours and words for the scripts of the beam in space."""


def variables(theme: str) -> str:
    """Return the colours of a theme as variables of a style sheet."""
    return " ".join(f"--{name}: {value};" for name, value in THEMES[theme].items())
