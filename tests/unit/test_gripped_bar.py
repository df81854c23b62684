"""A bar without contact between grips, far aside: against the least energy of its cells."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import minimize

from squama.contacts import path, row
from squama.contacts.path import Path, Scale
from squama.contacts.system import PHI
from squama.contacts.ties import Tie, X, Y, Z, freed, ties
from squama.joints import law


def test_a_bar_between_grips_is_pushed_far_aside():
    """Least energy of three cells by matrix exponentials; the force is 7 times the bar's bending stiffness."""
    n, at, far, aside = 3, 1.4149066631589562, 0.25 * 0.30488461547218565, 5.853337499764999
    push = np.array([-0.995468258023498, 0.01746567539006702, -0.09347672143818128])
    scale = Scale(0.5, 0.2, 0.6090776418105625, 0.7354653762590153, 0.33059076347731897, 0.0)
    K = law.stiffness(
        law.Shape(
            1.573410209316368, scale.lam, 0.29622660088745567, 0.5902839390348372, 0.017310379809526485, scale.alpha,
            scale.theta0, 0.3876582658518381,
        )
    )  # fmt: skip
    way = Path.at_rest(scale, K, 0.0, free=(1, 1, 1, 1), aside=aside)
    held = [Tie([(at, push)], course=(PHI, 1.0)), *(Tie(turn=(n, axis, 0 * Z)) for axis in (X, Y, Z))]
    held += [Tie([(n, axis)]) for axis in (X, Y)]
    found = row.tied(way, n, row.legs(np.linspace(0.0, far, 25)[1:], PHI), ties(n, held), freed(np.ones((n, 4)), PHI))
    assert len(found.rows) == 24
    alone = K[6:, 6:] - K[6:, :6] @ np.linalg.solve(K[:6, :6], K[:6, 6:])

    def ends(strains):
        """Frames of the sections."""
        every = [np.eye(4)]
        for psi, phi, chi, eps in strains.reshape(n, 4):
            S = np.array([[0, phi, -chi, 0], [-phi, 0, psi, 0], [chi, -psi, 0, 1 + eps], [0, 0, 0, 0]])
            every.append(every[-1] @ expm(S))
        return every

    def off(strains):
        """What the ties impose."""
        every = ends(strains)
        R, t, places = every[-1][:3, :3], every[-1][:2, 3], [frame[:3, 3] for frame in every]
        turn = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
        place = (2 - at) * (places[1] - Z) + (at - 1) * (places[2] - 2 * Z)
        return [*turn, *t, push @ place - far]

    def energy(strains):
        """Energy of the joints and the bar."""
        e = strains.reshape(n, 4)[:, [1, 0, 3]]
        return float(np.einsum("ia,ab,ib", e, alone, e) + aside * K[7, 7] * (strains[2::4] ** 2).sum()) / 2

    least = minimize(
        energy, 1.1 * found.cells[-1, :, :4].ravel(), constraints={"type": "eq", "fun": off}, method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 300},
    )  # fmt: skip
    assert least.success
    assert path.named(found.rows)["energy"][-1].sum() == pytest.approx(least.fun, rel=1e-6)
    assert found.loads[-1, 0] > 7 * alone[1, 1]
