"""Studies of many designs: sweeps over parameters of a beam, kept in labelled stores that can be resumed."""
