"""Array aliases used in annotations throughout."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["BoolArray", "FloatArray", "IntArray", "StyleArray"]

FloatArray = NDArray[np.floating]
IntArray = NDArray[np.integer]
BoolArray = NDArray[np.bool_]
StyleArray = NDArray[np.object_]
"""Names of styles, str."""
