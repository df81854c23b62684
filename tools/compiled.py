"""Compile all code that the package keeps compiled: processes beside each other would each do it anew."""

import numpy as np

import squama
from squama.batch.answers import FEW
from squama.fe.elements import Elements, Material
from squama.fe.mesh import EDGES

law = squama.law(squama.Beam.from_toml("examples/stiff_skin.toml"), mu=0.2)
law.trial(0, 4)
law.tangent()
squama.ends(eta=3, beta=1.25, lam=0.45, alpha=0.8, theta0=0.17, mu=np.linspace(0, 1, FEW + 1))
corners = np.vstack([np.zeros(3), np.eye(3)])
nodes = np.vstack([corners, corners[EDGES].mean(1)])
Elements(nodes, np.arange(10)[None], Material())(nodes)
