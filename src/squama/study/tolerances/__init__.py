"""What tolerances do to a beam: distributions, samples, statistics, and all of it as one dataset."""
