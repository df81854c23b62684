"""Pictures of a beam in three dimensions: its motion, its geometry, still pictures, animations, a page of its own."""
