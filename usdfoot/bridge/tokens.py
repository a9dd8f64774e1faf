"""Every name usdfoot reads from or writes to a stage: schemas, attributes, tokens, prims and files.

The names are the contract of design.md sections 2 and 3; tools outside the project rely on them. What exists once per
foot is a tuple indexed by side, so ``Clip.STRIKE_TIMES[side]`` is the attribute of that foot (0 = left, 1 = right).
"""

from typing import Final

PLUGIN: Final = "usdfoot"
"""Name of the schemas' plugin and library."""

SIDES: Final = ("left", "right")
"""Names of the feet in the order of the side index; also the instances of `Schema.CONTACT`."""

SidePair = tuple[str, str]
"""One name per foot: (left, right)."""


def _per_side(prefix: str, suffix: str) -> SidePair:
    return (f"{prefix}:{SIDES[0]}:{suffix}", f"{prefix}:{SIDES[1]}:{suffix}")


class Schema:
    """Names of the API schemas as they stand in `apiSchemas`."""

    BIPED: Final = "UsdfootBipedAPI"
    CLIP: Final = "UsdfootClipAPI"
    PLAN: Final = "UsdfootPlanAPI"
    PATH: Final = "UsdfootPathAPI"
    TERRAIN: Final = "UsdfootTerrainAPI"
    OBSTACLE: Final = "UsdfootObstacleAPI"
    AGENT: Final = "UsdfootAgentAPI"
    RESULT: Final = "UsdfootResultAPI"
    CONTACT: Final = "UsdfootContactAPI"
    """Multiple apply: what is applied is one of `CONTACT_INSTANCES`."""
    CONTACT_INSTANCES: Final[SidePair] = (f"{CONTACT}:{SIDES[0]}", f"{CONTACT}:{SIDES[1]}")


class Biped:
    """Properties of `Schema.BIPED`, on a Skeleton."""

    PELVIS: Final = "usdfoot:biped:pelvis"
    HIP: Final = _per_side("usdfoot:biped", "hip")
    KNEE: Final = _per_side("usdfoot:biped", "knee")
    ANKLE: Final = _per_side("usdfoot:biped", "ankle")
    BALL: Final = _per_side("usdfoot:biped", "ball")
    BALL_HEIGHT: Final = _per_side("usdfoot:biped", "ballHeight")
    COM: Final = "usdfoot:biped:com"
    LEG_LENGTH_NOMINAL: Final = "usdfoot:biped:legLength:nominal"
    LEG_LENGTH_MAX: Final = "usdfoot:biped:legLength:max"


class Clip:
    """Properties of `Schema.CLIP`, on a SkelAnimation."""

    STYLE: Final = "usdfoot:clip:style"
    ROOT_MOTION: Final = "usdfoot:clip:rootMotion"
    CYCLIC: Final = "usdfoot:clip:cyclic"
    START: Final = "usdfoot:clip:start"
    END: Final = "usdfoot:clip:end"
    STRIKE_TIMES: Final = _per_side("usdfoot:clip", "strikeTimes")
    FLAT_TIMES: Final = _per_side("usdfoot:clip", "flatTimes")
    LIFTOFF_TIMES: Final = _per_side("usdfoot:clip", "liftoffTimes")
    MIRROR: Final = "usdfoot:clip:mirror"
    SOURCE: Final = "usdfoot:clip:source"
    SKELETON: Final = "usdfoot:clip:skeleton"


class ClipSource:
    """Values of `Clip.SOURCE`."""

    RECORDED: Final = "recorded"
    SYNTHETIC: Final = "synthetic"
    ALL: Final = (RECORDED, SYNTHETIC)


class RootMotion:
    """Values of `Clip.ROOT_MOTION`."""

    AUTO: Final = "auto"
    TRAVEL: Final = "travel"
    IN_PLACE: Final = "inPlace"
    ALL: Final = (AUTO, TRAVEL, IN_PLACE)


class Plan:
    """Properties of `Schema.PLAN`, on a PointInstancer."""

    STRIKE_TIMES: Final = "usdfoot:plan:strikeTimes"
    LIFTOFF_TIMES: Final = "usdfoot:plan:liftoffTimes"
    ROOT_WEIGHTS: Final = "usdfoot:plan:rootWeights"
    STYLES: Final = "usdfoot:plan:styles"
    ROOT_TRAJECTORY: Final = "usdfoot:plan:rootTrajectory"


class Path:
    """Properties of `Schema.PATH`, on BasisCurves."""

    SPEED: Final = "usdfoot:path:speed"
    STEP_LENGTH: Final = "usdfoot:path:stepLength"
    STEP_WIDTH: Final = "usdfoot:path:stepWidth"
    START_TIME: Final = "usdfoot:path:startTime"
    STYLE: Final = "usdfoot:path:style"


class Terrain:
    """Properties of `Schema.TERRAIN`, on a Mesh or a prim above meshes."""

    WALKABLE: Final = "usdfoot:terrain:walkable"


class Obstacle:
    """Properties of `Schema.OBSTACLE`, on any Boundable."""

    MARGIN: Final = "usdfoot:obstacle:margin"


class Agent:
    """Properties of `Schema.AGENT`, on the agent prim."""

    PLAN: Final = "usdfoot:agent:plan"
    PATH: Final = "usdfoot:agent:path"
    TRAJECTORY: Final = "usdfoot:agent:trajectory"
    ID: Final = "usdfoot:agent:id"
    GOAL: Final = "usdfoot:agent:goal"
    SPEED: Final = "usdfoot:agent:speed"
    CHARACTER: Final = "usdfoot:agent:character"
    CLIPS: Final = "usdfoot:agent:clips"
    MOTION: Final = "usdfoot:agent:motion"
    ROOT_WEIGHT: Final = "usdfoot:agent:rootWeight"
    REPLACE_DISTANCE: Final = "usdfoot:agent:replaceDistance"
    IK_REACH: Final = "usdfoot:agent:ikReach"
    HIP_SPACING: Final = "usdfoot:agent:hipSpacing"
    CROUCH: Final = "usdfoot:agent:crouch"
    COM_SHIFT: Final = "usdfoot:agent:comShift"
    PITCH: Final = "usdfoot:agent:pitch"
    SWAY: Final = "usdfoot:agent:sway"
    GRAVITY: Final = "usdfoot:agent:gravity"
    COMFORT: Final = "usdfoot:agent:comfort"


class Op:
    """Transforms that are authored on written agents and their plans; the turn about the up axis by `turn_op`."""

    TRANSLATE: Final = "xformOp:translate"
    ORIENT_STANCE: Final = "xformOp:orient:stance"
    SCALE_STANCE: Final = "xformOp:scale:stance"
    MOVED: Final = "moved"
    """Suffix of those on the plan of an agent that artists moved."""


def turn_op(up_axis: str, suffix: str = "") -> str:
    """Name of the turn about a stage's up axis."""
    return f"xformOp:rotate{up_axis}" + (f":{suffix}" if suffix else "")


class Motion:
    """Values of `Agent.MOTION`."""

    CLIPS: Final = "clips"
    PHYSICS: Final = "physics"
    HYBRID: Final = "hybrid"
    ALL: Final = (CLIPS, PHYSICS, HYBRID)


class Result:
    """Properties of `Schema.RESULT`, on the executed plan; arrays as long as the plan unless said otherwise."""

    BLEND_ERROR: Final = "usdfoot:result:blendError"
    PLACEMENT_ERROR: Final = "usdfoot:result:placementError"
    SLIDE: Final = "usdfoot:result:slide"
    YAW_ERROR: Final = "usdfoot:result:yawError"
    HULL_DISTANCE: Final = "usdfoot:result:hullDistance"
    TIME_WARP: Final = "usdfoot:result:timeWarp"
    ROOT_WEIGHT: Final = "usdfoot:result:rootWeight"
    BETA: Final = "usdfoot:result:beta"
    FORCE_IMBALANCE: Final = "usdfoot:result:forceImbalance"
    CLAMP_TIME: Final = "usdfoot:result:clampTime"
    JUMP_HEIGHT: Final = "usdfoot:result:jumpHeight"
    ROOT_VELOCITY_ERROR: Final = "usdfoot:result:rootVelocityError"
    STATUS: Final = "usdfoot:result:status"
    CLIP_COUNTS: Final = "usdfoot:result:clipCounts"
    CLIPS: Final = "usdfoot:result:clips"
    """Concatenated over the steps, `CLIP_COUNTS` of them each."""
    CLIP_WEIGHTS: Final = "usdfoot:result:clipWeights"
    """Concatenated over the steps, `CLIP_COUNTS` of them each."""


class Status:
    """Values of `Result.STATUS`."""

    OK: Final = "ok"
    OUTSIDE_HULL: Final = "outsideHull"
    ROOT_WEIGHTED: Final = "rootWeighted"
    IK_LIMITED: Final = "ikLimited"
    UNREACHABLE: Final = "unreachable"
    OFF_TERRAIN: Final = "offTerrain"
    ALL: Final = (OK, OUTSIDE_HULL, ROOT_WEIGHTED, IK_LIMITED, UNREACHABLE, OFF_TERRAIN)
    PLACED: Final = (OK, OUTSIDE_HULL)
    """Those that promise the placement."""


class Contact:
    """Properties of `Schema.CONTACT`, on a written SkelAnimation."""

    STRIKE_TIMES: Final = _per_side("usdfoot:contact", "strikeTimes")
    FLAT_TIMES: Final = _per_side("usdfoot:contact", "flatTimes")
    LIFTOFF_TIMES: Final = _per_side("usdfoot:contact", "liftoffTimes")
    POSITIONS: Final = _per_side("usdfoot:contact", "positions")
    BALL_HEIGHT: Final = _per_side("usdfoot:contact", "ballHeight")


class Prim:
    """Paths of the written crowd."""

    CROWD: Final = "/Crowd"
    """The default prim."""
    AGENTS: Final = "/Crowd/Agents"
    PLANS: Final = "/Crowd/Plans"
    ANIMS: Final = "/Crowd/Anims"
    MATERIALS: Final = "/Crowd/Materials"
    """Those of the scene that agents are bound to, below it by their paths there."""


class Overlay:
    """What is drawn over a crowd: its root, and properties that no schema declares."""

    ROOT: Final = "/__usdfoot"
    AGENTS: Final = "usdfoot:overlay:agents"
    """On a part: names of the agents drawn."""
    OWNERS: Final = "usdfoot:overlay:owners"
    """On a part: index into `AGENTS` of each instance or line."""
    FOOTSTEPS: Final = "usdfoot:overlay:footsteps"
    """On a part: number of each instance's footstep in its plan, -1 = none in particular."""
    NOTES: Final = "usdfoot:overlay:scale"
    """Prefix of the root's numbers that say which length stands for what."""


class File:
    """Names of the files in the output folder."""

    CROWD: Final = "crowd.usd"
    OVERRIDES: Final = "overrides.usda"
    AGENTS: Final = "agents.usdc"
    FOOTSTEPS: Final = "footsteps.usdc"
    ANIMS: Final = "anims.usda"
    MATERIALS: Final = "crowd.materials.usda"
    """Weakest of the layers; only where agents are bound to materials that are no part of their characters."""
    EXPANDED: Final = "crowd.expanded.usda"
    REPORT: Final = "report.json"
    PENDING: Final = ".pending"
    """Folder of chunks that are done while others are not."""
    CHUNKS: Final = ".chunks"
    """Folder of what several chunks' agents and footsteps are joined from, for runs in which a few change."""
    EXAMPLES: Final = ".examples"
    """Folder of what large crowds keep of their clips' analysis."""


PROVENANCE: Final = "usdfoot"
"""Key of the provenance in a written layer's `customLayerData`."""


class Lod:
    """Schemas and properties of USD's own UsdLod (from 26.08 on)."""

    ROOT: Final = "LODRootAPI"
    DISTANCE: Final = "LODDistanceHeuristic"
    HEURISTICS: Final = "lod:heuristics"
    DEFAULT_INDEX: Final = "lod:default:index"
    DOMAIN: Final = "lod:domain"
    THRESHOLDS: Final = "thresholds"


class Record:
    """Keys of what a chunk's layers say about their making, below `PROVENANCE`."""

    CONTENT_HASH: Final = "contentHash"
    AGENT_HASHES: Final = "agentHashes"
    REPORT: Final = "entries"
