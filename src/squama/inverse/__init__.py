"""Inverse design: from a required response to the dimensions of a beam, under bounds and limits; Pareto fronts."""
