"""Placements: agents that artists moved in overrides.usda, whose footsteps go with them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdfoot.bridge.placements import AgentOps, Placement, fault_of, planar_matrix
from usdfoot.bridge.tokens import File, Op, Prim, turn_op
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.displacement import STILL, Displacement, start_of
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.readers.agent_ops import displacement_of, has_ops, read_agent_ops
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.attributes import array_at, value_at
from usdfoot.readers.casting import Casting
from usdfoot.readers.overrides import Overrides, author_move, new_layer
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.stage import start_code
from usdfoot.readers.walks import WalkReader

__all__ = ["Placed", "PlacementReader"]


@dataclass(frozen=True, kw_only=True)
class Placed:
    """What an agent walks where artists want it."""

    walk: FootstepPlan | RootTrajectory
    root: RootTrajectory | None
    """Root trajectory given with a plan."""
    placement: Placement | None
    """None = they neither moved the agent nor changed its plan."""


@dataclass(frozen=True, kw_only=True)
class _Move:
    """How a plan goes with an agent that is moved."""

    in_world: Displacement
    of_prim: Displacement
    """What usdfoot authors on the plan's prim, beside what artists did."""


class PlacementReader:
    """Moves agents, with what they walk, to where artists moved their prims.

    A plan that artists place by a transform of its own, or give to somebody else, is walked where it lies: else what
    was moved together would move twice, and the plan shown not be the one walked.

    Args:
        overrides: Of the artists.
        walks: Of the agents.
        everyone: All agents of the scene, with what the artists say of each.
        absent: Names of those who are not made.
        units: Of the scene.
    """

    def __init__(
        self,
        overrides: Overrides,
        walks: WalkReader,
        *,
        everyone: Sequence[AgentSource],
        absent: Collection[str],
        units: StageUnits,
    ) -> None:
        self._overrides = overrides
        self._walks = walks
        self._everyone = {source.name: source for source in everyone}
        self._absent = absent
        self._units = units
        self._ops: dict[str, AgentOps | None] = {}
        self.problems: list[Problem] = []
        """What artists authored that is not followed."""

    def place(self, source: AgentSource, walk: FootstepPlan | RootTrajectory, casting: Casting) -> Placed:
        """What an agent walks, displaced as artists displaced it.

        Raises:
            PlanError: If that is nowhere.
        """
        if self._overrides.stage is None:
            return Placed(walk=walk, root=self._walks.roots.get(source.name), placement=None)
        root, frame = self._walks.roots.get(source.name), self._walks.frames.get(source.name)
        path = Sdf.Path(self._overrides.plan_path(source.name))
        walker = self._everyone.get(path.name) if path.GetParentPath() == Prim.PLANS else None
        ops, move = self._ops_of(source, casting), self._move_of(walker, casting) if walker else None
        if move:
            walk, root = move.in_world.walk(walk), move.in_world.trajectory(root) if root else None
        plan_move = None
        if walker and walker.name == source.name:
            plan_move = move.of_prim if move else STILL if self._says_moved(source.name) else None
            frame = frame if plan_move is None else self._frame(source.name, plan_move)
        if path.GetParentPath() == Prim.PLANS and path.name in self._absent:
            reason = f"the plan it walks is not written, since {path.name} is muted or not asked for"
            self._warn(source.name, f"{reason}. hide that instead, or ask for it")
        if ops and not (move and plan_move):
            self._warn(source.name, f"its transform is not followed, since {path} has a place of its own. move that")
        is_placed = any(part is not None for part in (frame, plan_move, ops))
        placement = Placement(plan_frame=frame, plan_move=plan_move, agent=ops) if is_placed else None
        return Placed(walk=walk, root=root, placement=placement)

    def _ops_of(self, source: AgentSource, casting: Casting) -> AgentOps | None:
        """What artists authored over an agent and feet can follow; what they cannot is a problem."""
        name = source.name
        if name not in self._ops:
            self._ops[name] = self._read_ops(source, casting) if has_ops(source.override) else None
        return self._ops[name]

    def _read_ops(self, source: AgentSource, casting: Casting) -> AgentOps | None:
        try:
            start, character = start_of(self._walks.given_walk(source)), casting.character_of(source)
        except UsdfootError:  # which is told where it is walked, or cast
            return None
        try:
            return read_agent_ops(source.override, character, start, units=self._units)
        except SceneError as error:
            self._warn(source.name, f"{error.what}, so that the agent is off its footsteps. {error.remedy}")
            return None

    def _move_of(self, walker: AgentSource, casting: Casting) -> _Move | None:
        """How an agent's plan goes with it; None if it does not."""
        ops, over = self._ops_of(walker, casting), self._plan_over(walker.name)
        if ops is None:
            return None
        move = displacement_of(ops, self._units)
        if over is None or not has_ops(over):
            return _Move(in_world=move, of_prim=move)
        order = value_at(over.GetAttribute(_ORDER))
        if self._says_moved(walker.name, values=True) or not (order is None or set(self._plan_ops) <= set(order)):
            return None
        matrix = np.linalg.inv(self._frame(walker.name, STILL)) @ self._frame(walker.name, move)
        if fault_of(matrix, self._units):
            return None
        return _Move(in_world=planar_matrix(matrix, self._units), of_prim=move)

    @property
    def _plan_ops(self) -> tuple[str, str]:
        """Ops that usdfoot authors on plans that go with agents."""
        return f"{Op.TRANSLATE}:{Op.MOVED}", turn_op(self._units.up_axis, Op.MOVED)

    def _plan_over(self, name: str) -> Usd.Prim | None:
        """What artists say of an agent's plan."""
        stage = self._overrides.stage
        return (stage.GetPrimAtPath(f"{Prim.PLANS}/{name}") or None) if stage else None

    def _says_moved(self, name: str, *, values: bool = False) -> bool:
        """Whether artists name these ops in a plan's order or give them values, or only the latter."""
        over = self._plan_over(name)
        if not over:
            return False
        order = () if values else array_at(over.GetAttribute(_ORDER))
        return any(op in order or over.GetAttribute(op).HasAuthoredValue() for op in self._plan_ops)

    def _frame(self, name: str, move: Displacement) -> FloatArray:
        """From a plan's prim that goes with its agent to the world, as artists transform it (row vectors), (4, 4)."""
        layer, path = new_layer(self._units), f"{Prim.PLANS}/{name}"
        ours = Usd.Stage.Open(layer, sessionLayer=None)
        author_move(UsdGeom.Xform.Define(ours, path), move, self._units)
        whole = new_layer(self._units)
        above = self._overrides.layer
        whole.subLayerPaths = [*([above.identifier] if above else []), layer.identifier]
        stage = Usd.Stage.Open(whole, sessionLayer=None)
        return matrices_of(stage.GetPrimAtPath(path), np.array([start_code(stage).GetValue()]))[0]

    def _warn(self, name: str, what: str) -> None:
        where = f"{File.OVERRIDES} {Prim.AGENTS}/{name}"
        self.problems.append(Problem(severity="warning", where=where, message=f"{where}: {what}"))


_ORDER = str(UsdGeom.Tokens.xformOpOrder)
