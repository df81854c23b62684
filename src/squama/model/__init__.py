"""Mechanics of contacts between scales: formulas for any number type, paths of contacts, laws of the joint."""
