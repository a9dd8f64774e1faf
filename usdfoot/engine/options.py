"""Options of the engine, with their units and defaults."""

from __future__ import annotations

from dataclasses import dataclass, field

from usdfoot.engine.follow_options import FollowOptions
from usdfoot.errors import UsdfootError

__all__ = ["FRAMES", "ROOTED_FRAME", "SEAMS", "SPACES", "EngineOptions"]

SEAMS = ("inertialise", "crossfade", "none")
SPACES = ("neighbours", "delaunay", "3d")
FRAMES = ("support", "root")
BANDS = ("polar", "cartesian")
BEYONDS = ("segment", "closest")
BLENDS = ("sum", "slerp")

ROOTED_FRAME = "what mixes in the root's velocity looks for footsteps from the support ball; use the frame support"
"""Why a root weight and `frame` = root exclude each other."""


@dataclass(frozen=True, kw_only=True)
class EngineOptions:
    """What an animator may turn.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    space: str = "neighbours"
    """What a step is blended from: neighbours = the examples around its footstep that are also most like it in timing,
    turn, rise and departure; delaunay = those of the Delaunay triangle ([B] 4.3); 3d = those of the tetrahedron of
    landing and root speed ([B] 7)."""
    frame: str = "support"
    """Where landings and footsteps are measured from: support = the support ball; root = the root as the step starts,
    midway between the feet, which lets its error into every step for IK to mend ([B] 4.1, 4.3)."""
    band: str = "polar"
    """How root velocities are weighted: polar = over their bearing and speed ([B] 4.1, 5); cartesian = over x and z."""
    blend: str = "sum"
    """How rotations are blended: sum = by sums of all with their signs aligned, whatever their order; slerp = by slerps
    one after the other, the heaviest first ([B] 4.4)."""
    correction: bool = True
    """Measure the blended landing and correct the query ([B] Fig. 5, 8); off = the paper's behaviour."""
    corrections: int = 8
    """How often the query is corrected at most."""
    choice_tolerance: float = 1.0e-3
    """A landing this near its footstep keeps its examples; farther, others are tried [m]."""
    landing_tolerance: float = 1.0e-4
    """A landing this near its footstep is not corrected further [m]."""
    seam: str = "inertialise"
    """inertialise | crossfade ([B] 7) | none."""
    seam_time: float = 0.2
    """Time over which a seam's jump decays on either side, at most the step [s]."""
    longest_step: float = 1.5
    """Longest step without a flight, in lengths of the leg beside the hips' width; a footstep beyond it is out of
    reach."""
    highest_step: float = 0.6
    """Highest step up or down without a flight, in lengths of the leg; a footstep beyond it is out of reach."""
    stand_time: float = 0.5
    """A double support longer than this is stood through [s]."""
    least_time_warp: float = 0.5
    """Planned duration of a step over that of its clips ([B] 5) below which it is named as hurried."""
    most_time_warp: float = 2.0
    """The same above which a step is named as drawn out; the body stands on both feet for as long as the plan lets it
    and then steps at a better pace."""
    stand_seam_time: float = 0.45
    """Time to settle into, and out of, a stand [s]."""
    event_shift: float = 0.06
    """How far the swinging foot's liftoff may pull the clips' along, as a part of the step's duration."""
    step_height_share: float = 0.2
    """Where the pelvis's ground lies between the lower and the higher of two feet at a strike, 0..1."""
    clearance: float = 0.015
    """Least height of the swinging sole over the terrain in mid swing [m]."""
    foot_spacing: float = 0.08
    """Least distance between the swinging foot and the standing leg it passes, centre to centre [m]."""
    subframe_slide: float = 0.001
    """A planted ball that drifts farther than this between two frames gets a sample halfway [m]."""
    root_weight: float | None = None
    """[B]'s lambda4 of every step, 0..1; None = what plans and agents say."""
    root_weight_within: float | None = None
    """Give each step the largest lambda4, `root_weight` at most, that plants it this near its footstep [m]; None = do
    not look for it."""
    beyond_beta: str = "segment"
    """Where a step lands whose lambda4 is beyond beta: segment = on the way from the footstep to the root's landing
    ([B]'s q'); closest = as near the footstep as weights without a negative one allow."""
    follow: FollowOptions = field(default_factory=FollowOptions)
    """How agents without footsteps walk their trajectories."""
    samples: int = 61
    """Samples of each example, more at high frame rates (`MotionOptions.at_rate`); 20 k + 1 puts the liftoffs'
    phases, where the pace may change, on samples."""

    def __post_init__(self) -> None:
        for name, choices in (
            ("seam", SEAMS),
            ("space", SPACES),
            ("frame", FRAMES),
            ("band", BANDS),
            ("beyond_beta", BEYONDS),
            ("blend", BLENDS),
        ):
            if getattr(self, name) not in choices:
                raise UsdfootError(name, f"{getattr(self, name)!r} is not known", f"choose one of {', '.join(choices)}")
        for name in ("seam_time", "stand_time", "stand_seam_time"):
            if not getattr(self, name) > 0.0:
                raise UsdfootError(name, f"is {getattr(self, name)}", "must be above 0 s")
        if not 0.0 < self.least_time_warp <= 1.0 <= self.most_time_warp:
            extremes = f"is {self.least_time_warp} to {self.most_time_warp}"
            raise UsdfootError("time_warp", extremes, "the least must be above 0, the most no less than 1")
        if self.root_weight is not None and not 0.0 <= self.root_weight <= 1.0:
            raise UsdfootError("root_weight", f"is {self.root_weight}", "must be a number between 0 and 1")
        if self.root_weight_within is not None and not 0.0 <= self.root_weight_within < float("inf"):
            raise UsdfootError("root_weight_within", f"is {self.root_weight_within}", "must be 0 m or more")
        if self.frame == "root" and (self.root_weight or self.root_weight_within is not None):
            raise UsdfootError("frame", "root goes with no root weight but 0", ROOTED_FRAME)
