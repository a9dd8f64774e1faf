"""Binary heaps in Warp kernels: what each search looks at next."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["CLOSED", "climb", "sink"]

CLOSED = wp.constant(wp.int32(-2))
"""Slot of a node that has left its heap, or never comes into it."""


@wp.func
def climb(
    heaps: wp.array(dtype=wp.int32, ndim=2),
    slots: wp.array(dtype=wp.int32, ndim=2),
    keys: wp.array(dtype=wp.float64, ndim=2),
    search: int,
    slot: int,
):
    """Moves a node of a search's heap up to where no better one is below it; slots say where in the heap nodes are."""
    node = heaps[search, slot]
    at = wp.int32(slot)
    going = bool(True)
    while going and at > 0:
        above = (at - 1) / 2
        other = heaps[search, above]
        going = keys[search, node] < keys[search, other]
        if going:
            heaps[search, at] = other
            slots[search, other] = at
            at = above
    heaps[search, at] = node
    slots[search, node] = at


@wp.func
def sink(
    heaps: wp.array(dtype=wp.int32, ndim=2),
    slots: wp.array(dtype=wp.int32, ndim=2),
    keys: wp.array(dtype=wp.float64, ndim=2),
    search: int,
    count: int,
):
    """Moves the first node of a search's heap of so many down to where no better one is below it."""
    node = heaps[search, 0]
    at = wp.int32(0)
    going = bool(True)
    while going and 2 * at + 1 < count:
        below = 2 * at + 1
        if below + 1 < count:
            left = heaps[search, below]
            right = heaps[search, below + 1]
            if keys[search, right] < keys[search, left]:
                below += 1
        other = heaps[search, below]
        going = keys[search, other] < keys[search, node]
        if going:
            heaps[search, at] = other
            slots[search, other] = at
            at = below
    heaps[search, at] = node
    slots[search, node] = at
