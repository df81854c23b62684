"""Stiffness of a scale's joint over nine motions: from a matrix, the fitted law, finite elements, or a hinge."""
