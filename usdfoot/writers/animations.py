"""Animation layers: one SkelAnimation an agent, with its contacts (design.md section 3)."""

from __future__ import annotations

from usdfoot.bridge import tokens
from usdfoot.bridge.units import StageUnits
from usdfoot.model.contacts import FootContacts
from usdfoot.writers.attributes import Attribute, code_array, prim_spec, sampled_spec, specs_of
from usdfoot.writers.crate.specs import Samples, Spec
from usdfoot.writers.poses import PosedAgent

__all__ = ["animation_spec"]


def animation_spec(agent: PosedAgent, *, units: StageUnits) -> Spec:
    """Spec of an agent's animation: poses and weights of blend shapes over time, and its contacts.

    Args:
        agent: Its motion, posed.
        units: Of the written stage.
    """
    motion, character = agent.motion, agent.resting.character
    attributes = {
        "joints": Attribute("token[]", character.skeleton.joints, uniform=True),
        "scales": Attribute("half3[]", character.rest_scales),
    }
    shapes = motion.shapes or character.blend_shapes
    if shapes is not None:
        attributes["blendShapes"] = Attribute("token[]", shapes.names, uniform=True)
    for side in (0, 1):
        height = float(character.biped.ball_heights[side]) / units.meters_per_unit
        attributes |= _contact_attributes(side, motion.contacts[side], height, units)
    sampled = {f".{name}": sampled_spec(samples) for name, samples in _samples(agent).items()}
    return prim_spec("SkelAnimation", {**sampled, **specs_of(attributes)}, schemas=tokens.Schema.CONTACT_INSTANCES)


def _samples(agent: PosedAgent) -> dict[str, Samples]:
    """What changes over time, by attribute."""
    bound, codes = agent.resting.character.blend_shapes, agent.codes
    samples = {
        "translations": Samples(type_name="float3[]", codes=codes, values=agent.translations),
        "rotations": Samples(type_name="quatf[]", codes=codes, values=agent.rotations),
    }
    if agent.motion.shapes is not None:
        samples["blendShapeWeights"] = Samples(type_name="float[]", codes=codes, values=agent.motion.shapes.weights)
    elif bound is not None:
        samples["blendShapeWeights"] = Samples(type_name="float[]", codes=bound.codes, values=bound.weights)
    return samples


def _contact_attributes(
    side: int, contacts: FootContacts, ball_height: float, units: StageUnits
) -> dict[str, Attribute]:
    """UsdfootContactAPI of one foot; `ball_height` is in stage units."""
    names = tokens.Contact
    return {
        names.STRIKE_TIMES[side]: code_array(contacts.strike_times, units),
        names.FLAT_TIMES[side]: code_array(contacts.flat_times, units),
        names.LIFTOFF_TIMES[side]: code_array(contacts.liftoff_times, units),
        names.POSITIONS[side]: Attribute("point3f[]", units.points_to_stage(contacts.positions), uniform=True),
        names.BALL_HEIGHT[side]: Attribute("float", ball_height, uniform=True),
    }
