"""Shapes of pitches in the law's range."""

from __future__ import annotations

import numpy as np

from squama.joints import law


def drawn(n: int, seed: int = 1, wider: float = 0.0, region: law.Region = law.CORE) -> law.Shape:
    """Return random shapes from a region's ranges, each a factor wider on both sides; some do not fit into a pitch."""
    low, high = np.array([(r.low / (1 + wider), r.high * (1 + wider)) for r in region]).T
    x = low + (high - low) * np.random.default_rng(seed).random((n, 8))
    alpha, theta, width, zeta, gap, thickness, across, nu = x.T
    alpha, theta, nu = np.radians(np.minimum(alpha, 85)), np.radians(theta), np.minimum(nu, 0.4999)
    c = np.cos(alpha)
    return law.Shape(across * width * c, thickness / 2, zeta, width / 2, gap * c * np.sin(theta), alpha, theta, nu)
