"""The agents' layer: instanceable references to characters on their root paths (design.md section 3)."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.scene import Character, Visibility
from usdfoot.bridge.units import StageUnits
from usdfoot.writers.crate.sampled import Samples
from usdfoot.writers.layers import apply_schemas, author, author_samples, author_targets, define_prim
from usdfoot.writers.poses import PosedAgent

__all__ = ["agent_samples", "author_stance", "write_agent"]

ValueTypes = Sdf.ValueTypeNames
_TRANSLATE, _EXTENT = "xformOp:translate", "extent"
UPRIGHT_TOLERANCE = 1e-7
"""Rotations and scales of a character closer than this to none are left out."""


def agent_samples(agent: PosedAgent, units: StageUnits) -> dict[str, Samples]:
    """Position on the ground, yaw and extent of an agent over time, by the attribute."""
    motion, codes = agent.motion, agent.codes
    positions = units.points_to_stage(motion.root_positions)
    return {
        _TRANSLATE: Samples(type_name="double3", codes=codes, values=positions),
        _turn(units): Samples(type_name="double", codes=codes, values=np.degrees(motion.root_yaws)),
        _EXTENT: Samples(type_name="float3[]", codes=codes, values=agent.extents),
    }


def _turn(units: StageUnits) -> str:
    return f"xformOp:rotate{units.up_axis}"


def write_agent(
    layer: Sdf.Layer,
    agent: PosedAgent,
    *,
    reference: Sdf.Reference,
    units: StageUnits,
    visibility: Visibility = (),
) -> None:
    """Author /Crowd/Agents/<name> into a layer that has its `agent_samples`.

    Args:
        layer: Layer to author in.
        agent: Its motion, posed.
        reference: How the layer refers to the asset.
        units: Of the written stage.
        visibility: When it is to be seen.
    """
    motion = agent.motion
    prim = define_prim(layer, f"{tokens.Prim.AGENTS}/{motion.name}", "SkelRoot")
    prim.instanceable = True
    prim.referenceList.prependedItems = [reference]
    apply_schemas(prim, ["SkelBindingAPI", tokens.Schema.AGENT])
    author_targets(prim, "skel:animationSource", [f"{tokens.Prim.ANIMS}/{motion.name}"])
    author_targets(prim, tokens.Agent.PLAN, [f"{tokens.Prim.PLANS}/{motion.name}"])
    order = [_TRANSLATE, _turn(units), *author_stance(prim, agent.resting.character)]
    author(prim, "xformOpOrder", ValueTypes.TokenArray, Vt.TokenArray(order), uniform=True)
    _write_visibility(prim, visibility)


def _write_visibility(prim: Sdf.PrimSpec, visibility: Visibility) -> None:
    """On the instance itself, which shares its prototype with others whatever it says."""
    if not visibility:
        return
    attribute = author(prim, "visibility", ValueTypes.Token, visibility[0][1])
    samples = {code: seen for code, seen in visibility if code is not None}
    author_samples(attribute, list(samples), list(samples.values()))


def author_stance(prim: Sdf.PrimSpec, character: Character) -> list[str]:
    """What stands the referenced prim upright at its size, nothing for most characters; gives back the ops' names."""
    order = []
    x, y, z, w = character.agent_rotation.tolist()
    if 1.0 - abs(w) > UPRIGHT_TOLERANCE**2 and max(abs(x), abs(y), abs(z)) > UPRIGHT_TOLERANCE:
        author(prim, "xformOp:orient:stance", ValueTypes.Quatd, Gf.Quatd(w, x, y, z))
        order.append("xformOp:orient:stance")
    if abs(character.agent_scale - 1.0) > UPRIGHT_TOLERANCE:
        scale = Gf.Vec3d(character.agent_scale)
        author(prim, "xformOp:scale:stance", ValueTypes.Double3, scale)
        order.append("xformOp:scale:stance")
    return order
