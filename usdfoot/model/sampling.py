"""Sampling: who is written at every frame, and who at every few only."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.errors import UsdfootError

__all__ = ["ALL_FRAMES", "SamplingOptions"]


@dataclass(frozen=True, kw_only=True)
class SamplingOptions:
    """How often far agents are sampled.

    Raises:
        UsdfootError: If a value is out of its range, or a distance has no camera to count from.
    """

    every: int = 1
    """Far agents have samples at every so many frames, and wherever else a planted foot would drift; 1 = at all."""
    camera: str = ""
    """Path of the prim that agents are far from; "" = all agents are far."""
    near: float = 0.0
    """Agents that come no nearer to the camera than this are far [m]."""

    def __post_init__(self) -> None:
        if self.every < 1:
            raise UsdfootError("every", f"is {self.every}", "must be 1 frame or more")
        if not 0.0 <= self.near < float("inf"):
            raise UsdfootError("near", f"is {self.near}", "must be 0 m or more")
        if bool(self.near) != bool(self.camera):
            raise UsdfootError("near", "counts from a camera", "give both the distance and the camera, or neither")


ALL_FRAMES = SamplingOptions()
"""Everybody has samples at every frame."""
