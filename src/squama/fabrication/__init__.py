"""Solids of a beam for the printer and the mould: scales, substrate, tray, lid and blades, in mm."""
