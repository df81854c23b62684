"""Entries of the counters and sums along a path, :attr:`squama.contacts.increments.Walk.tally`."""

from __future__ import annotations

WAY, H, SIZE, BEFORE, FRESH, COUNT = range(6)
"""The way; the next, the last and the last but one increment; number of increments since the last event, and of all."""
WORK, RUBBED, LOST, SLID, SLID_OTHER = range(6, 11)
"""Work of the loads, frictional work, energy lost in snaps, length of slip of the first contact of each face."""
POWER, POWER2, LOAD, LOAD2, ONSET = range(11, 16)
"""Rates of frictional work and of the loads' work at the last two states; the load where a contact last began to slide.
"""
SINCE, EVENTS, ZERO, NOTED, TRIAL, JUMPED = range(16, 22)
"""Way at which the contacts last changed; number of events; events without an increment; index of the last record (0:
none); trial and way of the last jump.
"""
ENERGY, MOST, STICK, GRIPS, HASTY = range(22, 27)
"""Elastic energy, now and its maximum; number of sticking contacts, and energy in their grips; kind of search for a
jump: 1 quick, 2 quick with a walk given up, 0 complete.
"""
TALLY = 27
