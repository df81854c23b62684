"""Figures and claims of published papers, recomputed."""
