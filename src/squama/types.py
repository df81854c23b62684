"""Types that many rooms share."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]
"""An array of numbers: floats, complex numbers, whole numbers or truths."""
