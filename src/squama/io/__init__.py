"""Files: tables of text, datasets, measured points; written beside their place and moved."""
