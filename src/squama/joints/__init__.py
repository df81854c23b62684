"""What holds a scale in the substrate, over nine motions: by a matrix, the shipped law, elements, or a hinge."""
