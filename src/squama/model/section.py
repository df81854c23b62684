"""Torsion and bending of the bare substrate, a solid rectangular bar, and bending of a plate.

Only the product C_w I enters the torque (paper, Eq. 14), and it equals Saint-Venant's torsion constant J, so the
warping coefficient is C_w = J / I. The paper does not define I; here I is the polar moment. Lengths are in any one
unit; moments of area are in its fourth power.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from squama.types import Array

# sum of 1 / n^5 over odd n = 31/32 zeta(5)
_ODD_FIFTH_POWERS = 31 / 32 * 1.0369277551433699263


def torsion_constant(width: Any, thickness: Any) -> Any:
    """Return Saint-Venant's torsion constant J of a solid rectangle, for floats, arrays or complex steps.

    With a >= b the two sides, J = a b^3 / 3 - (64 / pi^5) b^4 sum over odd n of tanh(n pi a / (2 b)) / n^5.
    The sum is split by tanh(x / 2) = 1 - 2 / (exp(x) + 1) into 31/32 zeta(5) and a rest that converges like
    exp(-n pi a / b): six terms give full double precision, the next is below 1e-19 of the sum even for a square.

    Source: Timoshenko and Goodier, Theory of Elasticity, 3rd ed., section 109, Eq. 161. Range: any rectangle, within
    linear elasticity for free warping; small twist rate (the sides' helices stay flat).

    >>> import numpy as np
    >>> round(torsion_constant(32, 16)), torsion_constant(np.array([32.0, 16.0]), 16.0).round()
    (29974, array([29974.,  9213.]))
    """
    if isinstance(width, int | float) and isinstance(thickness, int | float):
        exp: Any = math.exp
        a, b = max(width, thickness), min(width, thickness)
    else:
        import numpy as np  # a single beam does without it

        exp, first = np.exp, np.real(width) >= np.real(thickness)
        a, b = np.where(first, width, thickness), np.where(first, thickness, width)
    total = _ODD_FIFTH_POWERS
    for n in range(1, 13, 2):
        small = exp(-n * math.pi * a / b)
        total = total - 2 * small / (1 + small) / n**5
    return a * b**3 / 3 - 64 / math.pi**5 * b**4 * total


def torsion_shear(x: Array, y: Array, width: float, thickness: float) -> tuple[Array, Array]:
    """Return the shear stresses (tau_xz, tau_yz) (n,) in a twisted rectangle over G and the twist rate, at places (n,).

    With the warping function psi = x y - (8 w^2 / pi^3) sum over odd n of (-1)^((n - 1) / 2) sin(k x) sinh(k y) /
    (n^3 cosh(k t / 2)), k = n pi / w, they are psi_x - y and psi_y + x; x is along the width w from the middle, y along
    the thickness t. Counterclockwise about z = x cross y.

    Source: Timoshenko and Goodier, Theory of Elasticity, 3rd ed., section 109. Range: any rectangle; thirty terms leave
    2 % of the largest stress at the corners, where it is 0.

    >>> import numpy as np
    >>> tau = torsion_shear(np.array([0.0, 16.0]), np.array([8.0, 0.0]), 32, 16)
    >>> [abs(float(stress.round(2).sum())) for stress in tau]
    [14.88, 11.83]
    """
    import numpy as np

    n = np.arange(1, 60, 2.0)[:, None]
    k, sign = n * np.pi / width, np.where(n % 4 == 1, 1.0, -1.0)
    # sinh(k y) and cosh(k y) over cosh(k t / 2), without overflow
    near, far = (np.exp(k * (end * np.abs(y) - thickness / 2)) for end in (1, -1))
    whole = 1 + np.exp(-k * thickness)
    sinh, cosh = np.sign(y) * (near - far) / whole, (near + far) / whole
    each = 8 * width**2 / np.pi**3 * sign * k / n**3
    across = (each * np.cos(k * x) * sinh).sum(axis=0), (each * np.sin(k * x) * cosh).sum(axis=0)
    return -across[0], 2 * x - across[1]


def clamped_ratio(width: float, thickness: float, length: float, poisson_ratio: float) -> float:
    """Return the torsional stiffness of a rectangular bar between clamps that keep its ends plane, over free warping.

    The warping is psi chi(z), psi as in :func:`torsion_shear`; chi may differ from the twist rate.
    With C = int psi^2, I the polar moment, J the torsion constant and E/G = 2 (1 + nu), the energy is least for a chi
    that rises as cosh: each clamp takes a length a tanh(L k/2) of a bar of length L away,

        a = sqrt((1 - J/I) E C / (G J)),    k = sqrt((1 - J/I) G J / (E C))

    Source: Reissner, On non-uniform torsion of cylindrical rods, J. Math. Phys. 31 (1952) 214, for a rectangle.
    Vlasov's theory, whose warping goes with the twist rate, has a = 1/k = sqrt(E C/(G J)). By finite elements 5, 12,
    25 times a pitch of a bar 1.4 by 0.7 pitches are 1.077, 1.032, 1.016 times as stiff.

    >>> [round(clamped_ratio(1.4, 0.7, n, 0.49), 3) for n in (5, 12, 25)]
    [1.073, 1.029, 1.014]
    """
    import numpy as np

    # the sides may change places, and sinh stays small where the thickness is the less
    width, thickness = max(width, thickness), min(width, thickness)
    g, weights = np.polynomial.legendre.leggauss(40)
    x, y = (at.ravel() for at in np.meshgrid(g * width / 2, g * thickness / 2))
    n = np.arange(1, 60, 2.0)[:, None]
    k, sign = n * np.pi / width, np.where(n % 4 == 1, 1.0, -1.0)
    ratio = np.sinh(k * y) / np.cosh(k * thickness / 2)
    psi = x * y - (8 * width**2 / np.pi**3 * sign * np.sin(k * x) * ratio / n**3).sum(axis=0)
    warping = float(np.outer(weights, weights).ravel() @ psi**2) * width * thickness / 4
    share = 1 - warping_coefficient(width, thickness)
    per = 2 * (1 + poisson_ratio) * warping / float(torsion_constant(width, thickness))
    lost = math.sqrt(share * per) * math.tanh(math.sqrt(share / per) * length / 2)
    return length / (length - 2 * lost)


def polar_moment(width: float, thickness: float) -> float:
    """Return the polar second moment of area of a rectangle, I = a b (a^2 + b^2) / 12, the I of Eqs. 13-16."""
    return width * thickness * (width**2 + thickness**2) / 12


def warping_coefficient(width: float, thickness: float) -> float:
    """Return the warping coefficient C_w = J / I of a rectangle (Eqs. 13-16), between 0 and 0.85."""
    return float(torsion_constant(width, thickness) / polar_moment(width, thickness))


def bending_moment_of_area(width: float, thickness: float) -> float:
    """Return the second moment of area of a rectangle bent about its width, width * (2t)^3 / 12 (docs, theory)."""
    return width * thickness**3 / 12


def plate_rigidity(youngs_modulus: float | Array, thickness: float | Array, poisson_ratio: float | Array) -> Any:
    """Return the bending rigidity D of a plate per width, E t^3 / (12 (1 - nu^2)), for floats or arrays.

    Source: Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed., Eq. 3; thin plates.
    """
    return youngs_modulus * thickness**3 / (12 * (1 - poisson_ratio**2))


def shear_modulus(youngs_modulus: float, poisson_ratio: float) -> float:
    """Return the shear modulus G_B = E_B / (2 (1 + nu)), Pa, of an isotropic elastic solid (docs, theory: energy)."""
    return youngs_modulus / (2 * (1 + poisson_ratio))
