"""Contacts between neighbouring scales: one solver for any number of contacts of a row of scales, or of an endless one."""
