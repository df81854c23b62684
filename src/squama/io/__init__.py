"""Files: tables of text, datasets and measured points; each file is written beside its place and then renamed."""
