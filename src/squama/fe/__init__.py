"""Finite elements of the substrate and of its scales; shares the design with the rest, and nothing of the model."""
