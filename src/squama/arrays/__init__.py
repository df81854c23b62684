"""Functions over arrays of ratios: contacts, forces, paths, ends, derivatives; tables of designs."""
