"""Input data: the beam and its parts, the beam file, the joint's matrix or laws, and the model's range of validity."""
