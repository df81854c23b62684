"""Finite elements of the substrate and its scales, a reference independent of the model."""
