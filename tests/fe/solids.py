"""A cube of quadratic tetrahedra, made without a mesher; the energy of a contact."""

import itertools

import numpy as np
import pytest


def cube(n):
    """Nodes and elements of the unit cube about the origin, n cells a side, six elements a cell."""
    grid = np.linspace(-0.5, 0.5, n + 1)
    corners = np.array(list(itertools.product(grid, grid, grid)))
    steps = np.array([(n + 1) ** 2, n + 1, 1])
    cells = []
    for cell in itertools.product(range(n), repeat=3):
        for order in itertools.permutations(range(3)):
            at = [np.array(cell)]
            for axis in order:
                at.append(at[-1] + np.eye(3, dtype=int)[axis])
            cells.append([int(a @ steps) for a in at])
    tets = np.array(cells)
    edges = corners[tets[:, 1:]] - corners[tets[:, :1]]
    inverted = np.linalg.det(edges) < 0
    tets[inverted] = tets[inverted][:, [1, 0, 2, 3]]
    pairs = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
    ends = np.sort(tets[:, pairs].reshape(-1, 2), axis=1)
    unique, places = np.unique(ends, axis=0, return_inverse=True)
    nodes = np.concatenate([corners, corners[unique].mean(1)])
    return nodes, np.concatenate([tets, len(corners) + places.reshape(-1, 6)], axis=1)


def images(nodes):
    """Masters, whether each node is an image of one a pitch below, and the masters' places."""
    top = np.abs(nodes[:, 2] - 0.5) < 1e-9
    master = np.arange(len(nodes))
    below = {tuple(np.round(x, 9)): i for i, x in enumerate(nodes)}
    for i in np.flatnonzero(top):
        master[i] = below[tuple(np.round(nodes[i] - [0, 0, 1], 9))]
    kept, master = np.unique(master, return_inverse=True)
    return master, top, nodes[kept]


def stiffness(nodes, tets, material):
    """Small-strain stiffness (3 n, 3 n) of a mesh; degrees of freedom 3 i + axis."""
    from squama.fe.elements import Elements

    elements = Elements(nodes, tets, material)
    return elements.matrix(elements(nodes).values).tocsr()


def barrier_energy(contact, corners, kappa):
    """Energy of the barrier between scales with corners (n, 3)."""
    V = np.asfortranarray(corners)
    barrier = contact._ipc.BarrierPotential(contact.dhat, kappa)
    return barrier(contact._found(V, contact.dhat), contact._mesh, V)


def relaxed(body, z, v, way):
    """Free unknowns in balance at motions and a place on the way, and the body condensed there."""
    for _ in range(15):
        r = body.reduce(z, v, way)
        step = r.update(0 * r.s)
        z = z + step
        if np.abs(step).max() < 1e-11:
            return z, body.reduce(z, v, way)
    pytest.fail("no balance was found")
