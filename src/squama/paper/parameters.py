"""Parameters of the paper's figures, with choices where the paper leaves them open, and the record of a claim."""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.loads import LawName

LAWS: tuple[LawName, ...] = ("plate", "edge")
"""Force laws: that of the paper, and the energy-consistent one."""
MARGIN = 0.01
"""Margin before a lock at which every RED is taken (docs, theory: energy); the paper does not state its own."""

FIG4_MUS = (0.2, 0.4, 0.6, 0.8, 1.0)
FIG5_ETAS = (2.0, 3.0, 4.0, 6.0)
FIG5_SCAN = np.geomspace(1.5, 8.0, 80)
FIG5_ALPHAS = tuple(np.radians([5.0, 15.0, 30.0, 45.0, 60.0]))
FIG5_ALPHA_SCAN = np.radians(np.linspace(1.0, 70.0, 139))
FIG5A_MUS = (0.2, 0.5, 1.0, 2.0, 4.8)
FIG5B_MUS = (0.2, 0.5, 1.0, 2.0, 4.5)
FIG6A_MUS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
FIG6B_ETAS = (2.0, 3.0)
FIG6B_MUS = (0.0, 0.2, 0.5)
FIG6B_REACH = {2.0: 0.38, 3.0: 0.3}
"""Twist of the elements' points for each overlap ratio, rad per pitch: about the end of tip edge contact."""
FIG7_MUS = np.linspace(0.0, 6.0, 121)
FIG7_ETAS = np.linspace(1.5, 8.0, 91)
FIG7_ALPHAS = np.radians(np.linspace(1.0, 75.0, 112))
BENDING_MUS = (0.3, 0.6, 1.0, 2.0)
BENDING_ETAS = np.geomspace(1.5, 10.0, 60)
PLA_ON_PLA = (0.12, 0.38)
"""Measured static friction of printed PLA on PLA."""


class Claim(NamedTuple):
    """One statement of the paper, with numbers computed for it; ``holds`` is yes, no or in part.

    ``at`` has the place of each of the ``values``, such as "mu = 0.2"; each makes a row.
    """

    figure: str
    claim: str
    law: str
    quantity: str
    values: tuple[str, ...]
    unit: str
    holds: str
    note: str = ""
    at: tuple[str, ...] = ("",)

    def rows(self) -> list[dict[str, str]]:
        """Return one row for each value, as a dict by column."""
        about, said = self._asdict(), list(zip(self.at, self.values, strict=True))
        columns = ("figure", "claim", "law", "quantity", "at", "value", "unit", "holds", "note")
        return [{c: {**about, "at": at, "value": value}[c] for c in columns} for at, value in said]


def _beam(**ratios: Any) -> Beam:
    """Return a beam of these ratios with the angles and the substrate common to all figures."""
    return Beam.from_ratios(
        **ratios,
        alpha="45 deg",
        theta0="10 deg",
        width="32 mm",
        thickness="16 mm",
        youngs_modulus="25 GPa",
        poisson_ratio=0.25,
    )


@functools.cache
def main() -> Beam:
    """Return the beam of Figs. 4, 5, 6a and 7."""
    return _beam(eta=3, beta=1.25, lam=0.45, zeta=0.35, slenderness=35)


@functools.cache
def fig6b(eta: float) -> Beam:
    """Return a beam of Fig. 6b, whose overlap ratios the paper does not state."""
    return _beam(eta=eta, beta=0.6, lam=0.32, zeta=0.18, slenderness=45)


def fixed(beam: Beam, *varied: str) -> dict[str, str]:
    """Return as text, by symbol, the ratios and angles of a beam that a figure does not vary."""
    own = {"eta": beam.eta, "beta": beam.beta, "lam": beam.lam, "zeta": beam.scale.embedded / beam.pitch}
    shown = {name: f"{value:.4g}" for name, value in own.items()}
    shown |= {name: f"{math.degrees(getattr(beam.scale, name)):.4g} deg" for name in ("alpha", "theta0")}
    return {name: text for name, text in shown.items() if name not in varied}


def words(fixed: dict[str, str]) -> str:
    """Return fixed ratios as one line of text."""
    return ", ".join(f"{'lambda' if name == 'lam' else name} = {text}" for name, text in fixed.items())
