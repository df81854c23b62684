"""The law of a section, for rod programs and section programs of others: an object, a table, files."""
