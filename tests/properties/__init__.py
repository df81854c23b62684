"""Properties that hold for every design."""
