"""Identification: the parameters of a beam from measured torque and twist (docs, how-to: fit)."""
