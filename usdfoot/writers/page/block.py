"""The page's data block: named arrays as one compressed text, which assets/data.js takes apart again."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["encode_block", "quantised"]

TYPES = {"float32", "int16", "int32", "uint8", "uint16", "uint32"}


def encode_block(arrays: Mapping[str, NDArray[Any]]) -> tuple[list[dict[str, Any]], str]:
    """What the block holds, in order, and the block itself: zlib's stream in base64.

    Whole numbers are stored as differences along the flattened array, which wrap around, and all numbers by bytes of
    equal significance, since both compress better.

    Args:
        arrays: Of the types in TYPES, by name.

    Returns:
        Name, type and number of values of every array; the text.
    """
    directory, parts = [], []
    for name, values in arrays.items():
        kind = str(values.dtype)
        if kind not in TYPES:
            raise TypeError(f"{name} is {kind}; the page reads {', '.join(sorted(TYPES))}")
        directory.append({"name": name, "type": kind, "count": int(values.size)})
        parts.append(_planes(values.ravel()))
    return directory, base64.b64encode(zlib.compress(b"".join(parts), level=6)).decode("ascii")


def quantised(values: FloatArray, resolution: float) -> IntArray:
    """Values as multiples of `resolution` in 16 bits; the smallest number stands for NaN, the others are clipped."""
    known = np.isfinite(values)
    steps = np.clip(np.rint(np.where(known, values, 0.0) / resolution), -32767, 32767)
    return np.where(known, steps, -32768).astype(np.int16)


def _planes(values: NDArray[Any]) -> bytes:
    """Bytes of equal significance together, the least significant first."""
    size = values.dtype.itemsize
    unsigned = np.ascontiguousarray(values).view(f"u{size}")
    if values.dtype.kind in "iu":
        unsigned = np.diff(unsigned, prepend=unsigned.dtype.type(0))
    return unsigned.astype(f"<u{size}").view(np.uint8).reshape(-1, size).T.tobytes()
