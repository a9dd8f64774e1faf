"""Versions of the libraries a result depends on."""

from __future__ import annotations

import numpy as np
import warp as wp
from pxr import Usd

__all__ = ["library_versions"]


def library_versions() -> dict[str, str]:
    """Version of USD, Warp and numpy by name."""
    return {"usd": ".".join(str(part) for part in Usd.GetVersion()), "warp": wp.__version__, "numpy": np.__version__}
