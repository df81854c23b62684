"""The pitch of the paper's Fig. 6b, meshed once."""

import numpy as np
import pytest

from squama.fe.geometry import Geometry


@pytest.fixture(scope="session")
def fig6b():
    return Geometry(1.28, 0.32, 0.18, 3.0, 0.6, 0.004, np.radians(45), np.radians(10), 0.25)


@pytest.fixture(scope="session")
def pitch(fig6b):
    """Coarse: about 3000 elements."""
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    from squama.fe.mesh import pitch_mesh

    return pitch_mesh(fig6b, 0.2, 0.06)
