"""Functions over arrays of ratios: contact, forces, ends, derivatives; tables of designs."""
