"""What is given: the beam and its parts, its file, the joint's matrix, laws or given values, ranges of validity."""
