"""Animation layers: one SkelAnimation an agent, with its contacts (design.md section 3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray
from usdfoot.model.contacts import FootContacts
from usdfoot.writers.layers import (
    apply_schemas,
    author,
    author_samples,
    define_prim,
    frame_arrays,
    quaternion_array,
)
from usdfoot.writers.layers_over import author_times
from usdfoot.writers.poses import PosedAgent

__all__ = ["write_animation"]

ValueTypes = Sdf.ValueTypeNames


def write_animation(layer: Sdf.Layer, agent: PosedAgent, *, units: StageUnits) -> None:
    """Author /Crowd/Anims/<name> into a layer.

    Args:
        layer: Layer to author in.
        agent: Its motion, posed.
        units: Of the written stage.
    """
    motion, character = agent.motion, agent.resting.character
    prim = define_prim(layer, f"{tokens.Prim.ANIMS}/{motion.name}", "SkelAnimation")
    apply_schemas(prim, tokens.Schema.CONTACT_INSTANCES)
    author(prim, "joints", ValueTypes.TokenArray, Vt.TokenArray(character.skeleton.joints), uniform=True)
    codes, joints = agent.codes, len(character.skeleton.joints)
    translations = frame_arrays(Vt.Vec3fArray.FromNumpy(agent.translations.reshape(-1, 3)), joints)
    rotations = frame_arrays(quaternion_array(agent.rotations.reshape(-1, 4)), joints)
    scales = Vt.Vec3hArray.FromNumpy(np.ascontiguousarray(character.rest_scales, dtype=np.float16))
    author_samples(author(prim, "translations", ValueTypes.Float3Array), codes, translations)
    author_samples(author(prim, "rotations", ValueTypes.QuatfArray), codes, rotations)
    author(prim, "scales", ValueTypes.Half3Array, scales)
    if motion.shapes is not None:
        _write_blend_shapes(prim, motion.shapes.names, codes, motion.shapes.weights)
    elif character.blend_shapes is not None:
        bound = character.blend_shapes
        _write_blend_shapes(prim, bound.names, bound.codes.tolist(), bound.weights)
    for side in (0, 1):
        height = float(character.biped.ball_heights[side]) / units.meters_per_unit
        _write_contacts(prim, side, motion.contacts[side], height, units)


def _write_blend_shapes(prim: Sdf.PrimSpec, names: Sequence[str], codes: list[float], weights: FloatArray) -> None:
    author(prim, "blendShapes", ValueTypes.TokenArray, Vt.TokenArray(names), uniform=True)
    rows = [Vt.FloatArray.FromNumpy(np.ascontiguousarray(row, dtype=np.float32)) for row in weights]
    author_samples(author(prim, "blendShapeWeights", ValueTypes.FloatArray), codes, rows)


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
