"""The law of a section for rod and section programs: an object with memory, a table, files."""
