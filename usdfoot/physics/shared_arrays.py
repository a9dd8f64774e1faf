"""Arrays shared with the kernels: the same memory for numpy and Warp."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import warp as wp

from usdfoot.model.device import start_warp

__all__ = ["empty_rows", "shared", "shared_record"]

NUMPY_KINDS = {wp.int32: np.dtype(np.int32), wp.bool: np.dtype(bool)}
"""Of Warp's types that are no float64 and not made of them."""


def shared(values: np.ndarray, kind: object) -> wp.array:
    """An array as one of Warp; without a copy where it is contiguous and of that kind.

    Structured arrays have the types of Warp's struct.
    """
    start_warp()
    if values.dtype.names is None:
        values = np.ascontiguousarray(values, dtype=NUMPY_KINDS.get(kind, np.dtype(float)))
    return wp.array(values, dtype=kind, device="cpu", copy=False)


def empty_rows(kind: Any, count: int) -> np.ndarray:
    """Room for `count` structs of Warp, as a structured array (count,)."""
    rows: np.ndarray = np.empty(count, dtype=kind.numpy_dtype())
    return rows


def shared_record(kind: Any, values: Mapping[str, object]) -> Any:
    """A struct of Warp with these fields; arrays are shared, or copied into matrices, as the fields' types say."""
    record = kind()
    for name, value in values.items():
        if isinstance(value, np.ndarray):
            field = kind.vars[name].type
            value = shared(value, field.dtype) if isinstance(field, wp.array) else field(value)
        setattr(record, name, value)
    return record
