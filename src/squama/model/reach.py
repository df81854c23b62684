"""How far a scale may reach. Every neighbour within reach is asked for its contact, so the reach is bounded."""

from __future__ import annotations

import math

SEARCH = math.pi / 2
"""Load angle per pitch, rad, up to which contacts that end nothing are looked for."""
LARGEST = 100.0
"""Largest eta and beta. Such a design answers in about .2 s for every pair of plates; one of 300 takes a second."""
MOST = LARGEST * (1 + 1e-12)
"""The same with room for the rounding of l/d and b/d."""
ALLOWED = f"more than 0, up to {LARGEST:g}"
