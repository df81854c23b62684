"""A beam in three dimensions: its motion, geometry, still pictures, animations and a standalone page."""
