"""Agent ops: the transforms that artists authored on a written agent, against those that usdfoot authors itself."""

from __future__ import annotations

import math

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdfoot.bridge.placements import AgentOps, fault_of, matrix_of, planar_matrix
from usdfoot.bridge.scene import Character
from usdfoot.bridge.stance import stance_matrix, stance_ops
from usdfoot.bridge.tokens import Op, turn_op
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError
from usdfoot.maths.types import FloatArray
from usdfoot.model.displacement import Displacement
from usdfoot.readers.overrides import new_layer

__all__ = ["displacement_of", "has_ops", "read_agent_ops"]

_XFORM_OPS = "xformOp"
LONGEST_LEVER = 0.5
"""Farther from the agent than this a pivot of usdfoot's own turn would let planted feet drift between samples [m]: a
lever l that turns by a from one sample to the next is off by l a^2 / 8 halfway."""
_ROUNDED = 1e-9
_STILL = np.eye(4)
_EARLIEST = Usd.TimeCode.EarliestTime()
"""A single sample counts at any time, as does a value at none."""


def has_ops(prim: Usd.Prim | None) -> bool:
    """Whether transforms are authored on a prim, if there is one."""
    return prim is not None and any(name.startswith(_XFORM_OPS) for name in prim.GetAuthoredPropertyNames())


def read_agent_ops(over: Usd.Prim, character: Character, start: Displacement, *, units: StageUnits) -> AgentOps | None:
    """What artists authored over an agent; None if that moves nothing.

    Args:
        over: What they say of the agent, and nobody else, on its stage.
        character: The agent's.
        start: Where it starts as long as they do not move it.
        units: Of the written stage.

    Raises:
        SceneError: If feet could not follow what they authored.
    """
    stage = _composed(over, character, start, units=units)
    ops = UsdGeom.Xformable(stage.GetPrimAtPath(over.GetPath())).GetOrderedXformOps()
    own = [Op.TRANSLATE, turn_op(units.up_axis)]
    free = [op.GetOpName() for op in ops if op.GetOpName() in own and not _is_said(over, op.GetName())]
    if any(op.IsInverseOp() and op.GetName() in own for op in ops):
        raise _unfollowed(over, "its xformOpOrder inverts what usdfoot authors")
    moving = [op.GetOpName() for op in ops if op.MightBeTimeVarying()]
    if moving:
        what = f"{', '.join(moving)} is animated, and footsteps stand still"
        raise _unfollowed(over, what, "author one value, which says where the agent starts")
    names, matrices = [op.GetOpName() for op in ops], [np.array(op.GetOpTransform(_EARLIEST)) for op in ops]
    undo_stance = np.linalg.inv(stance_matrix(character))
    whole = undo_stance @ _product(matrices)
    _require_planar(over, whole, units)
    if free != own:
        return _held(whole, start, units)
    translate, turn = map(names.index, own)
    before, between = _product(matrices[:translate]), _product(matrices[translate + 1 : turn])
    after = undo_stance @ _product(matrices[turn + 1 :])
    for part in (before, between, after):
        _require_planar(over, part, units)
    if max(np.linalg.norm(part[3, :3]) for part in (between, after)) * units.meters_per_unit > LONGEST_LEVER:
        return _held(whole, start, units)
    parts = [
        _STILL if np.allclose(part, _STILL, rtol=0.0, atol=_ROUNDED) else part for part in (before, between, after)
    ]
    if all(part is _STILL for part in parts):
        return None
    return AgentOps(before=parts[0], between=parts[1], after=parts[2], start=start)


def _held(place: FloatArray, start: Displacement, units: StageUnits) -> AgentOps:
    """Transforms that leave the agent's prim where they put it (row vectors), shape (4, 4)."""
    return AgentOps(before=_STILL, between=_STILL, after=_STILL, start=start, held=planar_matrix(place, units))


def displacement_of(ops: AgentOps, units: StageUnits) -> Displacement:
    """How the artists' transforms move the agent: as far as they move it at its start."""
    if ops.held is not None:
        return Displacement.between(ops.start, ops.held)
    if all(np.array_equal(part, _STILL) for part in (ops.between, ops.after)):
        return planar_matrix(ops.before, units)  # wherever it starts
    own = matrix_of(ops.start, units)
    place, turn = np.eye(4), own.copy()
    place[3], turn[3] = own[3], [0.0, 0.0, 0.0, 1.0]
    moved = ops.after @ turn @ ops.between @ place @ ops.before
    return Displacement.between(ops.start, planar_matrix(moved, units))


def _composed(over: Usd.Prim, character: Character, start: Displacement, *, units: StageUnits) -> Usd.Stage:
    """The agent as it starts, with what artists say over it."""
    layer, path = new_layer(units), over.GetPath()
    stage = Usd.Stage.Open(layer, sessionLayer=None)
    agent = UsdGeom.Xformable(stage.DefinePrim(path, "SkelRoot"))
    if character.asset:
        agent.GetPrim().GetReferences().AddReference(character.asset, character.asset_prim)
    authored = {
        Op.TRANSLATE: (Sdf.ValueTypeNames.Double3, Gf.Vec3d(*units.points_to_stage(start.translation).tolist())),
        turn_op(units.up_axis): (Sdf.ValueTypeNames.Double, math.degrees(start.yaw)),
    }
    for name, value in stance_ops(character).items():
        x, y, z, *w = value
        is_turn = name == Op.ORIENT_STANCE
        kind = Sdf.ValueTypeNames.Quatd if is_turn else Sdf.ValueTypeNames.Double3
        authored[name] = (kind, Gf.Quatd(*w, x, y, z) if is_turn else Gf.Vec3d(x, y, z))
    for name, (kind, content) in authored.items():
        agent.GetPrim().CreateAttribute(name, kind, custom=False).Set(content)
    agent.CreateXformOpOrderAttr(list(authored))
    whole = new_layer(units)
    whole.subLayerPaths = [over.GetStage().GetRootLayer().identifier, layer.identifier]
    return Usd.Stage.Open(whole, sessionLayer=None)


def _is_said(over: Usd.Prim, name: str) -> bool:
    """Whether artists gave an attribute a value."""
    attribute = over.GetAttribute(name)
    return bool(attribute) and attribute.HasAuthoredValue()


def _product(matrices: list[FloatArray]) -> FloatArray:
    """Of transforms in USD's order, the outermost first (row vectors), shape (4, 4)."""
    product = np.eye(4)
    for matrix in matrices:
        product = matrix @ product
    return product


def _require_planar(over: Usd.Prim, matrix: FloatArray, units: StageUnits) -> None:
    """Raises SceneError if nobody could stand after a transform."""
    fault = fault_of(matrix, units)
    if fault:
        raise _unfollowed(over, f"its transform {fault}")


def _unfollowed(over: Usd.Prim, what: str, remedy: str = "") -> SceneError:
    usual = "let it only move the agent and turn it about the vertical, beside usdfoot's own xformOps, or take it away"
    return SceneError(over.GetPath(), what, remedy or usual)
