"""The pitch of the paper's Fig. 6b; no shape is meshed twice."""

import functools

import numpy as np
import pytest

from squama.fe import mesh
from squama.fe.geometry import Geometry


@pytest.fixture(scope="session", autouse=True)
def _meshed_once():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mesh, "_mesh", functools.cache(mesh._mesh))
        yield


@pytest.fixture(scope="session")
def fig6b():
    return Geometry(1.28, 0.32, 0.18, 3.0, 0.6, 0.004, np.radians(45), np.radians(10), 0.25)


@pytest.fixture(scope="session")
def pitch(fig6b):
    """Coarse: about 3000 elements."""
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    return mesh.pitch_mesh(fig6b, 0.2, 0.06)


@pytest.fixture(scope="session")
def coarse(fig6b):
    """Very coarse: 1700 elements, too stiff by a few percent."""
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    return mesh.pitch_mesh(fig6b, 0.4, 0.2)
