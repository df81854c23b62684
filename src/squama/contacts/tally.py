"""What is counted along a path: entries of :attr:`squama.contacts.increments.Walk.tally`."""

from __future__ import annotations

WAY, H, SIZE, BEFORE, FRESH, COUNT = range(6)
"""The way; the next, the last and the last but one increment; increments since the last event, and in all."""
WORK, RUBBED, LOST, SLID, SLID_OTHER = range(6, 11)
"""Work of the loads, frictional work, energy lost in snaps, length of slip of the first contact of each face."""
POWER, POWER2, LOAD, LOAD2, ONSET = range(11, 16)
"""Rates of frictional work and of the loads' at the last two states; the load where a contact last began to slide."""
SINCE, EVENTS, ZERO, NOTED, TRIAL, JUMPED = range(16, 22)
"""Way since which the contacts are these; events; events without an increment; where the last increment is noted, 0 for
nowhere; trial and way of the last jump."""
ENERGY, MOST, STICK, GRIPS, HASTY = range(22, 27)
"""Elastic energy, now and at most; contacts that stick, and what their grips took up; how a jump is looked for: 1 in
haste, 2 where a walk was given up for it, 0 at leisure."""
TALLY = 27
