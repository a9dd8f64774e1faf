"""Questions to the person at usdview: the only place that touches Qt."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pxr.Usdviewq.qt import QtWidgets

__all__ = ["ask_choice", "ask_file", "ask_number"]


def ask_number(window: Any, label: str, value: float, *, low: float, high: float) -> float | None:
    """A number within a range, None if the person changed their mind."""
    number, agreed = QtWidgets.QInputDialog.getDouble(window, "Usdfoot", label, value, low, high, 3)
    return float(number) if agreed else None


def ask_choice(window: Any, label: str, choices: Sequence[str], *, current: str) -> str | None:
    """One of several words, None if the person changed their mind."""
    word, agreed = QtWidgets.QInputDialog.getItem(
        window, "Usdfoot", label, list(choices), choices.index(current), False
    )
    return str(word) if agreed else None


def ask_file(window: Any, label: str, name: str) -> str | None:
    """A USD file to write, None if the person changed their mind."""
    path, _ = QtWidgets.QFileDialog.getSaveFileName(window, label, name, "USD (*.usda *.usdc *.usd)")
    return str(path) or None
