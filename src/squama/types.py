"""Types shared by many rooms."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]
"""NumPy array of floats, complex numbers, integers or truth values."""
