"""Limits of the reach of a scale: every neighbour within reach is checked for contact, so the reach is bounded."""

from __future__ import annotations

import math

SEARCH = math.pi / 2
"""Load angle per pitch, rad, up to which other contacts are searched."""
LARGEST = 100.0
"""Largest eta and beta. Such a design takes about 0.2 s for every pair of plates; 300 would take a second."""
MOST = LARGEST * (1 + 1e-12)
"""Largest eta and beta, with room for the rounding of l/d and b/d."""
ALLOWED = f"more than 0, up to {LARGEST:g}"
