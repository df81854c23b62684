"""Functions over arrays of ratios: contact, forces, paths, ends, derivatives; tables of designs."""
