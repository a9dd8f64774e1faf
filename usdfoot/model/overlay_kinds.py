"""Kinds of what an overlay shows."""

from __future__ import annotations

__all__ = ["KINDS"]

KINDS = ("Footsteps", "Errors", "Contacts", "Com", "Space", "Timing")
"""What can be shown and hidden on its own; parts are named by their kind, or below it: Errors, Errors/Blend."""
