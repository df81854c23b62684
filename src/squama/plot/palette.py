"""The colours of every picture, one table for all: figures, the beam in space, the explorer and its page.

Nothing is loaded with it; scripts and style sheets of pages are handed what they need.
"""

from __future__ import annotations

from squama.model.outcome import End

INK, GREY, ACCENT = "#1a1a1a", "#7a7a7a", "#b2182b"
"""Lines and text of a figure; what stands behind; what is marked."""
UNLOADED = "#2166ac"
"""Ways back, of falling load."""
KEPT = ("#0072b2", "#b5651d", "#8a63b0")
"""Designs beside each other, told apart by colour-blind readers too (each has its own dashes as well)."""
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
    "joint unknown": "#bbbbbb",
    "not computed": "#f4e3e3",
}
"""Ends of curves on a map; blue ones lock after sliding, grey at once; and where there is none to tell."""
DARK_ENDS = ENDS | {End.KINEMATIC: "#9db2e8", End.LINE: "#9a86d0", End.STOPPED: "#b3875a", End.NONE: "#3a4047"}
"""The same on a dark ground."""
STEPS = ("#7e4fb3", "#b0408f", "#dd5e66", "#f2914a", "#f7c64b", "#f2ef6b")
"""Classes of a figure on a map, from small to large, on either ground."""
SOFTER, ENDED = "#1b9e9e", "#858c94"
"""Of a stiffness below that of the bar, and of curves that end before, on either ground."""
LOCKS = (End.FRICTIONAL, End.KINEMATIC, End.STATIC)
"""Ends towards which the load grows without bound."""
STATES = {"free": "#4a90c2", "sliding": "#e0a030", "locked": "#c8323c", "ended": "#8a63b0"}
"""Scales by their state."""
WORDS = {"free": "not in contact", "sliding": "sliding", "locked": "locked", "ended": "at the end of the curve"}
"""What the states are called."""
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
"""A light and a dark page: its text, ground and lines; its plots; the bar, edges and arrows of the beam in space."""
SCENE = {"states": STATES, "words": WORDS, "themes": THEMES}
"""What the scripts of the beam in space are handed."""


def variables(theme: str) -> str:
    """Return the colours of a theme as variables of a style sheet."""
    return " ".join(f"--{name}: {value};" for name, value in THEMES[theme].items())
