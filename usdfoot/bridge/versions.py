"""Versions of the libraries a result depends on."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

import numpy as np
from pxr import Usd

__all__ = ["library_versions"]


def library_versions() -> dict[str, str]:
    """Version of USD, Warp and numpy by name."""
    usd = ".".join(str(part) for part in Usd.GetVersion())
    return {"usd": usd, "warp": _warp_version(), "numpy": np.__version__}


def _warp_version() -> str:
    """As it was installed, since importing Warp to ask takes longer than what many a run has to do."""
    try:
        return version("warp-lang")
    except PackageNotFoundError:  # a program's own copy
        from warp import __version__

        return __version__
