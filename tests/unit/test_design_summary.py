"""Warnings of squama design: a short line each, equal lines once."""

from __future__ import annotations

from types import SimpleNamespace

from squama.cli.design import _warned

REFUSED = (
    "joint: scale.embedded = 0.449 pitches: longer than the law of the joint reaches",
    "joint: substrate.width = 3.807 of the scale's: the law goes from 1.01 to 3.15 of the scale's",
    "printer files: beam.pitch = 13.36 mm: the slits are only 0.325 mm apart; write at least 13.883 mm",
)
BOWS = "the beam bows: its ends turn by 40 deg; for a couple write ends"


def test_reasons_stand_in_one_line_and_equal_warnings_once():
    first, *others = _warned(SimpleNamespace(refused=REFUSED, warnings=(BOWS, BOWS, "t_s/d = 0.06 is large (a law)")))
    made = "scale.embedded = 0.449 pitches, substrate.width = 3.807 of the scale's (joint)"
    assert first == f"design 1 cannot be made as it is: {made}; beam.pitch = 13.36 mm (printer files); --full says why"
    assert others == ["the beam bows: its ends turn by 40 deg", "t_s/d = 0.06 is large"]
    assert list(_warned(SimpleNamespace(refused=(), warnings=()))) == []
