"""HTML cards of beams and results for notebooks: a short table, and a side view of the beam."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from html import escape

from squama.beam.faces import described
from squama.beam.parts import RATIOS, Assembly
from squama.units import as_text, number

DRAWN = 6
"""Largest number of scales in the drawing."""
_ACROSS = 360.0
"""Width of the drawing in pixels."""


def card(title: str, rows: Iterable[tuple[str, str]], notes: Iterable[str] = (), drawing: str = "") -> str:
    """Return HTML with a title, a drawing, rows of names and values, and notes; all text is escaped."""
    table = "".join(
        f'<tr><td style="text-align:left">{escape(name)}</td><td style="text-align:left">{escape(value)}</td></tr>'
        for name, value in rows
    )
    below = "".join(f'<div style="max-width:44em">{escape(note)}</div>' for note in notes)
    return f"<div><b>{escape(title)}</b>{drawing}<table>{table}</table>{below}</div>"


def of_beam(beam: Assembly, warnings: Iterable[str]) -> str:
    """Return the HTML card of a beam: sizes, materials, ratios, warnings, side view."""
    scale, substrate, mm = beam.scale, beam.substrate, 1e3
    size = f"{scale.length * mm:.4g} x {scale.width * mm:.4g} x {scale.thickness * mm:.4g} mm"
    sunk, bar = f"{scale.embedded * mm:.4g} mm", f"{substrate.width * mm:.4g} x {substrate.thickness * mm:.4g} mm"
    modulus = "rigid" if scale.youngs_modulus is None else as_text(scale.youngs_modulus, "pressure")
    ratios = ", ".join(f"{name} {getattr(beam, name):.4g}" for name in RATIOS)
    friction = "-" if beam.friction.mu is None else number(beam.friction.mu)
    rows = [
        ("scales", f"{size}, {sunk} embedded, {modulus}"),
        ("angles", f"alpha {math.degrees(scale.alpha):.4g} deg, theta0 {math.degrees(scale.theta0):.4g} deg"),
        ("substrate", f"{bar}, {as_text(substrate.youngs_modulus, 'pressure')}, nu {substrate.poisson_ratio:.4g}"),
        ("mu", friction),
        ("ratios", ratios),
    ]
    length = beam.pitch * beam.pitches * mm
    faces = f" on {described(beam.faces)}" if beam.other else ""
    long = "endless" if beam.scales is None else f"{length:.4g} mm long"
    whole = "scales" if beam.scales is None else beam.extent
    title = f"Beam: {whole}{faces}, pitch {beam.pitch * mm:.4g} mm, {long}"
    return card(title, rows, (f"warning: {text}" for text in warnings), side(beam))


def side(beam: Assembly) -> str:
    """Return a side view of the bar and its first scales as SVG, to scale."""
    scale, d, t = beam.scale, beam.pitch, beam.substrate.thickness / 2
    count = min(beam.pitches, DRAWN)
    # along the bar and up: half a width, an exposed and an embedded length
    width = scale.width / 2 * math.sin(scale.alpha)
    out = math.cos(scale.alpha) * math.cos(scale.theta0), math.sin(scale.theta0)
    tip, root = ((out[0] * x, out[1] * x) for x in (scale.length, -scale.embedded))
    left, right = min(-width + root[0], -d / 2), (count - 1) * d + max(width + tip[0], d / 2)
    # up or down, and how far along
    faces = [(1, 0.0), *([(-1, beam.other.shift * d)] if beam.other else [])]
    right += faces[-1][1]
    top, bottom = t + tip[1], -t - tip[1] * (len(faces) - 1)
    k = _ACROSS / (right - left)

    def polygon(points: Iterable[tuple[float, float]], style: str) -> str:
        return f'<polygon points="{" ".join(f"{(x - left) * k:.2f},{(top - y) * k:.2f}" for x, y in points)}" {style}/>'

    bar = [(left, -t), (right, -t), (right, t), (left, t)]
    shapes = [polygon(bar, 'fill="#d9d4c7" stroke="none"')]
    for (up, along), i in itertools.product(faces, range(count - 1, -1, -1)):
        z = i * d + along
        for (x, y), style in ((root, 'fill-opacity="0.15"'), (tip, 'fill-opacity="0.55"')):
            plate = [(z - width, up * t), (z + width, up * t)]
            plate += [(z + width + x, up * (t + y)), (z - width + x, up * (t + y))]
            shapes.append(polygon(plate, f'fill="#4c86bd" stroke="#1f5fa8" stroke-width="0.8" {style}'))
    words = f"{count} of {beam.pitches} scales seen from the side"
    return (
        f'<svg role="img" aria-label="{words}" width="{_ACROSS:.0f}" height="{(top - bottom) * k:.1f}" '
        f'style="display:block">{"".join(shapes)}</svg>'
    )
