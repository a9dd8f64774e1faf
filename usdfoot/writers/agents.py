"""The agents' layer: instanceable references to characters on their root paths (design.md section 3)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from usdfoot.bridge import tokens
from usdfoot.bridge.own_attributes import BINDING
from usdfoot.bridge.placements import AgentOps
from usdfoot.bridge.scene import Character, Visibility
from usdfoot.bridge.stance import stance_ops
from usdfoot.bridge.tokens import Op, turn_op
from usdfoot.bridge.units import StageUnits
from usdfoot.writers.attributes import Attribute, prim_spec, relationship_spec, sampled_spec, seen_spec, specs_of
from usdfoot.writers.crate.specs import Reference, Samples, Spec, switch
from usdfoot.writers.placed import own_root
from usdfoot.writers.poses import PosedAgent

__all__ = ["agent_spec", "stance_attributes"]


def agent_spec(
    agent: PosedAgent,
    *,
    reference: tuple[str, str],
    units: StageUnits,
    ops: AgentOps | None = None,
    visibility: Visibility = (),
    own: Mapping[str, Spec] | None = None,
) -> Spec:
    """Spec of an agent: position on the ground, yaw and extent over time.

    Args:
        agent: Its motion, posed.
        reference: Asset and prim path by which it refers to its character.
        units: Of the written stage.
        ops: Transforms that artists authored over it.
        visibility: When it is to be seen.
        own: What describes it, as visibility does, on the instance itself, which shares its prototype with
            others whatever it says.
    """
    motion, codes, turn = agent.motion, agent.codes, turn_op(units.up_axis)
    places, yaws = own_root(motion, ops, units)
    sampled = {
        Op.TRANSLATE: Samples(type_name="double3", codes=codes, values=places),
        turn: Samples(type_name="double", codes=codes, values=np.degrees(yaws)),
        "extent": Samples(type_name="float3[]", codes=codes, values=agent.extents),
    }
    stance = stance_attributes(agent.resting.character)
    order = Attribute("token[]", [Op.TRANSLATE, turn, *stance], uniform=True)
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
    types = {Op.ORIENT_STANCE: "quatd", Op.SCALE_STANCE: "double3"}
    return {name: Attribute(types[name], value) for name, value in stance_ops(character).items()}
