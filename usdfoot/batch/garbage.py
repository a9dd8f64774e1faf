"""Garbage: how often the processes of a run look for objects that hold each other."""

from __future__ import annotations

import gc

__all__ = ["collect_no_more", "collect_seldom"]

THRESHOLDS = 50_000, 20, 50
"""Of `gc.set_threshold`. A crowd is millions of objects of which hardly any hold each other: looking through them as
often as Python does takes a tenth of a run."""


def collect_seldom() -> None:
    """Has Python look less often; for processes that are usdfoot's own, not for those that it is a guest in."""
    gc.freeze()
    gc.set_threshold(*THRESHOLDS)


def collect_no_more() -> None:
    """Has Python not look at all when it ends, as it does several times; for processes that are usdfoot's own."""
    gc.freeze()
