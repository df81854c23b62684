"""Contacts between neighbouring scales: one solver for any number of them, in a row of scales or an endless one."""
