"""The independent oracle: plain vectors, numerical derivatives, root finding; imports nothing of squama."""
