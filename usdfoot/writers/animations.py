"""Animation layers: one SkelAnimation an agent, with its contacts (design.md section 3)."""

from __future__ import annotations

import numpy as np
from pxr import Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.units import StageUnits
from usdfoot.model.contacts import FootContacts
from usdfoot.writers.crate.sampled import Samples
from usdfoot.writers.layers import apply_schemas, author, define_prim
from usdfoot.writers.layers_over import author_times
from usdfoot.writers.poses import PosedAgent

__all__ = ["animation_samples", "write_animation"]

ValueTypes = Sdf.ValueTypeNames
_TRANSLATIONS, _ROTATIONS, _WEIGHTS = "translations", "rotations", "blendShapeWeights"


def animation_samples(agent: PosedAgent) -> dict[str, Samples]:
    """Poses and weights of blend shapes of an agent over time, by the attribute."""
    bound, codes = agent.resting.character.blend_shapes, agent.codes
    samples = {
        _TRANSLATIONS: Samples(type_name="float3[]", codes=codes, values=agent.translations),
        _ROTATIONS: Samples(type_name="quatf[]", codes=codes, values=agent.rotations),
    }
    if agent.motion.shapes is not None:
        samples[_WEIGHTS] = Samples(type_name="float[]", codes=codes, values=agent.motion.shapes.weights)
    elif bound is not None:
        samples[_WEIGHTS] = Samples(type_name="float[]", codes=bound.codes, values=bound.weights)
    return samples


def write_animation(layer: Sdf.Layer, agent: PosedAgent, *, units: StageUnits) -> None:
    """Author /Crowd/Anims/<name> into a layer that has its `animation_samples`.

    Args:
        layer: Layer to author in.
        agent: Its motion, posed.
        units: Of the written stage.
    """
    motion, character = agent.motion, agent.resting.character
    prim = define_prim(layer, f"{tokens.Prim.ANIMS}/{motion.name}", "SkelAnimation")
    apply_schemas(prim, tokens.Schema.CONTACT_INSTANCES)
    author(prim, "joints", ValueTypes.TokenArray, Vt.TokenArray(character.skeleton.joints), uniform=True)
    scales = Vt.Vec3hArray.FromNumpy(np.ascontiguousarray(character.rest_scales, dtype=np.float16))
    author(prim, "scales", ValueTypes.Half3Array, scales)
    shapes = motion.shapes or character.blend_shapes
    if shapes is not None:
        author(prim, "blendShapes", ValueTypes.TokenArray, Vt.TokenArray(shapes.names), uniform=True)
    for side in (0, 1):
        height = float(character.biped.ball_heights[side]) / units.meters_per_unit
        _write_contacts(prim, side, motion.contacts[side], height, units)


def _write_contacts(
    prim: Sdf.PrimSpec, side: int, contacts: FootContacts, ball_height: float, units: StageUnits
) -> None:
    """UsdfootContactAPI of one foot; `ball_height` is in stage units."""
    names = tokens.Contact
    for name, times in (
        (names.STRIKE_TIMES[side], contacts.strike_times),
        (names.FLAT_TIMES[side], contacts.flat_times),
        (names.LIFTOFF_TIMES[side], contacts.liftoff_times),
    ):
        author_times(prim, name, times, units)
    positions = np.ascontiguousarray(units.points_to_stage(contacts.positions), dtype=np.float32)
    author(prim, names.POSITIONS[side], ValueTypes.Point3fArray, Vt.Vec3fArray.FromNumpy(positions), uniform=True)
    author(prim, names.BALL_HEIGHT[side], ValueTypes.Float, ball_height, uniform=True)
