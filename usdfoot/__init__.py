"""Footsteps as scene description: turns planned footsteps on a USD stage into character animation."""

__version__ = "0.1.0"
__all__ = ["__version__"]
