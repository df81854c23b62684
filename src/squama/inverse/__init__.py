"""From what a beam is to do to the beam: inverse design under bounds and limits, and trade-offs (Pareto fronts)."""
