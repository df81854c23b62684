"""What tabs in both faces add to a bar, by elements: about twice what those of one do, and no coupling to stretch."""

from __future__ import annotations

from math import tan

import numpy as np
import pytest

import squama
from squama.fe import mesh
from squama.fe.elements import Material
from squama.fe.geometry import Geometry, geometry
from squama.fe.pitch_stiffness import response
from squama.joints.factor import BEND, K_THETA, TWIST, pivots

pytest.importorskip("netgen")

S = np.array([1.0, -1.0, 1.0])
STIFF = Material(1e5, 0.3)
"""Of the second tab, which is meshed: E_s/E."""
SIZES = (0.3, 0.06)


def with_other_tab(occ, g: Geometry, edge_size, *, tab):
    """Return the solid of :func:`squama.fe.mesh._cell` with the mirror image of its tab glued in."""
    c, slope, t = g.cut, tan(g.alpha), g.thickness
    ends = [(-g.width / 2, c), (-g.width / 2, c + 1), (g.width / 2, c + 1), (g.width / 2, c)]

    def prism(low: float, high: float):
        return mesh._polygon(occ, [(x, low, z + x * slope) for x, z in ends]).Extrude(occ.Vec(0, high - low, 0))

    def plate(signs):
        x, y, z = g.rest.axes * signs
        far = t / tan(g.theta0)
        around = [(-g.zeta, -g.beta), (far, -g.beta), (far, g.beta), (-g.zeta, g.beta)]
        floor = [g.rest.base * signs + p * x + q * y - t / 2 * z for p, q in around]
        return mesh._polygon(occ, floor).Extrude(occ.Vec(*map(float, t * z)))

    second = plate(S) - prism(-g.lam - 1, -g.lam)
    cell = occ.Glue([prism(-g.lam, g.lam) - plate(np.ones(3)) - second, second])
    faces = {round(f.center.z - f.center.x * slope - c, 6): f for f in cell.faces}
    trafo = occ.gp_Trsf.Translation(occ.Vec(0, 0, 1))
    faces[0.0].Identify(faces[1.0], "pitch", occ.IdentificationType.PERIODIC, trafo)
    for edge in cell.edges:
        place = np.array([[edge.center.x, edge.center.y, edge.center.z]])
        if g.in_slot(place) or g.in_slot(place * S):
            edge.maxh = edge_size
    return cell


@pytest.mark.slow
def test_tabs_of_both_faces_add_twice_what_one_does(monkeypatch):
    beam = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.45, zeta=0.35, slenderness=10, alpha="30 deg")
    g = geometry(beam)
    one = response(mesh.pitch_mesh(g, *SIZES), g).K
    monkeypatch.setattr(mesh, "_cell", with_other_tab)
    monkeypatch.setattr(mesh, "_mesh", mesh._mesh.__wrapped__)
    pitch = mesh.pitch_mesh(g, *SIZES)
    middles = pitch.nodes[pitch.tets[:, :4]].mean(axis=1)
    both = response(pitch._replace(tab=np.flatnonzero(g.in_slot(middles * S, 1e-9))), g, STIFF).K
    unit = beam.substrate.youngs_modulus * beam.pitch**4
    bare = {TWIST: beam.G_B * beam.J / unit, BEND: beam.replace(joint={"inclusion_factor": 1}).bending_rigidity / unit}
    for load, rigidity in bare.items():
        added = [pivots(K)[load] / rigidity - 1 for K in (one, both)]
        # tolerance: a coarse mesh and what two tabs do to each other, 5, 0.5 and 10 % measured, on every processor
        assert added[1] / added[0] == pytest.approx(2, rel=0.1)
    assert pivots(both)[K_THETA] == pytest.approx(pivots(one)[K_THETA], rel=0.02)

    def alone(K):
        return K[6:, 6:] - K[6:, :6] @ np.linalg.solve(K[:6, :6], K[:6, 6:])

    # what bends and twists a bar by one face's tabs: mirrored, they do so together, and no longer stretch it
    (_, coupled, stretched), (_, double, _) = alone(one)[0], alone(both)[0]
    assert double == pytest.approx(2 * coupled, rel=0.2)
    assert abs(alone(both)[1, 2]) < 0.05 * abs(alone(one)[1, 2])
    assert abs(alone(both)[0, 2]) < 0.05 * abs(stretched)
