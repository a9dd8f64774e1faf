"""The agents' layer: instanceable references to characters on their root paths (design.md section 3)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from usdfoot.bridge import tokens
from usdfoot.bridge.own_attributes import BINDING
from usdfoot.bridge.scene import Character, Visibility
from usdfoot.bridge.units import StageUnits
from usdfoot.writers.attributes import Attribute, prim_spec, relationship_spec, sampled_spec, seen_spec, specs_of
from usdfoot.writers.crate.specs import Reference, Samples, Spec, switch
from usdfoot.writers.poses import PosedAgent

__all__ = ["agent_spec", "stance_attributes"]

_TRANSLATE = "xformOp:translate"
UPRIGHT_TOLERANCE = 1e-7
"""Rotations and scales of a character closer than this to none are left out."""


def agent_spec(
    agent: PosedAgent,
    *,
    reference: tuple[str, str],
    units: StageUnits,
    visibility: Visibility = (),
    own: Mapping[str, Spec] | None = None,
) -> Spec:
    """Spec of an agent: position on the ground, yaw and extent over time.

    Args:
        agent: Its motion, posed.
        reference: Asset and prim path by which it refers to its character.
        units: Of the written stage.
        visibility: When it is to be seen.
        own: What describes it, as visibility does, on the instance itself, which shares its prototype with
            others whatever it says.
    """
    motion, codes, turn = agent.motion, agent.codes, f"xformOp:rotate{units.up_axis}"
    sampled = {
        _TRANSLATE: Samples(type_name="double3", codes=codes, values=units.points_to_stage(motion.root_positions)),
        turn: Samples(type_name="double", codes=codes, values=np.degrees(motion.root_yaws)),
        "extent": Samples(type_name="float3[]", codes=codes, values=agent.extents),
    }
    stance = stance_attributes(agent.resting.character)
    order = Attribute("token[]", [_TRANSLATE, turn, *stance], uniform=True)
    below = {
        **{f".{name}": sampled_spec(samples) for name, samples in sampled.items()},
        ".skel:animationSource": relationship_spec([f"{tokens.Prim.ANIMS}/{motion.name}"]),
        f".{tokens.Agent.PLAN}": relationship_spec([f"{tokens.Prim.PLANS}/{motion.name}"]),
        **specs_of({**stance, "xformOpOrder": order}),
    }
    if visibility:
        samples = {code: seen for code, seen in visibility if code is not None}
        below[".visibility"] = seen_spec(visibility[0][1], list(samples), list(samples.values()))
    below |= own or {}
    binding = ["MaterialBindingAPI"] if any(name.startswith(f".{BINDING}") for name in below) else []
    return prim_spec(
        "SkelRoot",
        below,
        schemas=["SkelBindingAPI", *binding, tokens.Schema.AGENT],
        fields={"instanceable": switch(True), "references": Reference(*reference)},
    )


def stance_attributes(character: Character) -> dict[str, Attribute]:
    """What stands the referenced prim upright at its size, nothing for most characters, in the order of its ops."""
    attributes = {}
    x, y, z, w = character.agent_rotation.tolist()
    if 1.0 - abs(w) > UPRIGHT_TOLERANCE**2 and max(abs(x), abs(y), abs(z)) > UPRIGHT_TOLERANCE:
        attributes["xformOp:orient:stance"] = Attribute("quatd", [x, y, z, w])
    if abs(character.agent_scale - 1.0) > UPRIGHT_TOLERANCE:
        attributes["xformOp:scale:stance"] = Attribute("double3", [character.agent_scale] * 3)
    return attributes
