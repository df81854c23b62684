"""Figures and claims of published papers, computed anew."""
