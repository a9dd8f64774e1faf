"""Arguments: what callers of a controller give, as arrays of the shape they must have."""

from __future__ import annotations

import numpy as np

from usdfoot.errors import UsdfootError
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["agent_numbers", "finite_array", "float_array", "number_array"]


def agent_numbers(agents: object, *, count: int | None = None, of: str = "") -> IntArray:
    """Numbers of agents, shape (M,).

    Args:
        agents: As given.
        count: How many they must be; None = any.
        of: What there are so many of.

    Raises:
        UsdfootError: If they are no whole numbers in a row, or not `count`.
    """
    numbers = np.asarray(agents)
    if numbers.ndim != 1 or (numbers.size and numbers.dtype.kind not in "iu"):
        what = f"has shape {numbers.shape} and type {numbers.dtype}"
        raise UsdfootError("agents", what, "give the agents' numbers, integers of shape (M,)")
    if count is not None and len(numbers) != count:
        raise UsdfootError("agents", f"has {len(numbers)} numbers for {count} {of}", "give one for each")
    return numbers.astype(np.intp)


def number_array(name: str, values: object) -> np.ndarray:
    """Numbers of an argument as an array; those that are none to numpy are taken as floats.

    Raises:
        UsdfootError: If they are no numbers.
    """
    try:
        array = np.asarray(values)
        return array if array.dtype.kind in "iuf" else array.astype(float)
    except (TypeError, ValueError) as error:
        raise UsdfootError(name, f"is no array of numbers ({error})", "give numbers") from error


def float_array(name: str, values: object, shape: tuple[int, ...]) -> FloatArray:
    """Values of an argument as an array of the shape, not the caller's own.

    Raises:
        UsdfootError: If they are no numbers or of another shape.
    """
    array = number_array(name, values)
    if array.shape != shape:
        raise UsdfootError(name, f"has shape {array.shape}", f"give numbers of shape {shape}")
    return array.astype(float)


def finite_array(name: str, values: object, shape: tuple[int, ...]) -> FloatArray:
    """The same, none of which is infinite or not a number.

    Raises:
        UsdfootError: If one is.
    """
    array = float_array(name, values, shape)
    if not np.isfinite(array).all():
        raise UsdfootError(name, "has values that are not finite", f"give finite numbers of shape {shape}")
    return array
