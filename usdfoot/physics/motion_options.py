"""Options of every source of motion in one, for jobs whose agents may mix them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.model.sampling import SamplingOptions
from usdfoot.model.tuning import BodyTuning
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.style import BodyStyle

__all__ = ["MOTIONS", "MotionOptions"]

FINE_RATE = 60.0
"""Frames a second up to which the samples of an example are fine enough: those of half a second are 1/120 s apart."""
MOST_TIMES = 8
"""How many times as many there are at most; they are kept for the whole library."""
MOTIONS = ("clips", "physics", "hybrid")


@dataclass(frozen=True, kw_only=True)
class MotionOptions(EngineOptions):
    """The engine's options, and those of bodies that physics moves.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    motion: str | None = None
    """clips | physics | hybrid for all agents when they are read; None = what each says."""
    conform: bool = False
    """Lay the footsteps of plans on the terrain first; off = they are executed as given."""
    physics: PhysicsOptions = field(default_factory=PhysicsOptions)
    """How the centre of mass is optimised."""
    tuning: BodyTuning = field(default_factory=BodyTuning)
    """Of all agents when they are read, over what each says."""
    body: BodyStyle = field(default_factory=BodyStyle)
    """How the body moves over it."""
    sampling: SamplingOptions = field(default_factory=SamplingOptions)
    """Who is written at which frames."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.motion is not None and self.motion not in MOTIONS:
            raise UsdfootError("motion", f"{self.motion!r} is not known", f"choose one of {', '.join(MOTIONS)}")

    def tuned(self, tuning: BodyTuning) -> MotionOptions:
        """The options of an agent: these, changed as its tuning says."""
        given, body = tuning.given, self.body
        sway = given.get("sway", 1.0)
        return replace(
            self,
            physics=replace(
                self.physics,
                gravity=given.get("gravity", self.physics.gravity),
                comfort=given.get("comfort", self.physics.comfort),
            ),
            body=replace(
                body, pitch=given.get("pitch", 1.0) * body.pitch, sway=sway * body.sway, turn=sway * body.turn
            ),
        )

    def at_rate(self, rate: float) -> MotionOptions:
        """These options with examples fine enough for a frame rate [Hz]: poses are straight between samples.

        Frames closer together than samples would see each of these as a kink. A step takes half a second or so.
        """
        times = min(max(math.ceil(rate / FINE_RATE - 1e-6), 1), MOST_TIMES)
        return replace(self, samples=max(self.samples, times * (EngineOptions.samples - 1) + 1))
