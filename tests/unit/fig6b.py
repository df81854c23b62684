"""The beam of Fig. 6b with the stiffness of its joint by elements."""

import numpy as np

import squama
from squama.beam import matrixfile

# of 6467 tetrahedra, over u_X, u_Y, u_Z, w_X, w_Y, w_Z, phi; E = 1, d = 1
LOWER = """
1.11149
0.03757 0.80550
-0.04975 0.00924 1.07382
-0.01040 0.03646 -0.00869 0.17161
-0.01684 0.00088 0.09614 -0.00139 0.02138
0.03558 -0.08809 -0.00634 0.00117 -0.00112 0.15331
-0.02042 0.01149 0.07621 -0.00394 0.00630 -0.00656 0.04997
"""
ROWS = [[float(x) for x in line.split()] for line in LOWER.split("\n") if line]
K = np.array([[ROWS[max(i, j)][min(i, j)] for j in range(7)] for i in range(7)])
PLAIN = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)


def held(beam, K):
    """The beam on a stiffness of its joint."""
    return beam.replace(joint={"matrix": matrixfile.stored(beam, K)})


BEAM = held(PLAIN, K)
