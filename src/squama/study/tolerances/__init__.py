"""Effect of tolerances on a beam's response: distributions, samples, statistics, and the dataset that holds them."""
